"""Containers for several meshes: a zip archive, or a multipart/mixed message (RFC 2046, 5.1.3).

The same meshes always give the same bytes. Archive members are stored without compression and
without a time, in the requested order, and the multipart boundary is a digest. The meshes come from
the mesh cache; only the few bytes between them are made here.
"""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from service.http.representations import OCTET_STREAM
from service.problems.problem import MEDIA_TYPE, Problem

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from gamutcore.levels import Side
    from service.library import EncodedLevel

__all__ = ["CONTAINERS", "Asked", "Container", "Item", "MultipartContainer", "ZipContainer"]

_ATTRIBUTES = 0o100644 << 16
"""A regular file that everybody may read (APPNOTE 4.4.15), Unix."""

_CARRIED = (b"gamut-triangles", b"gamut-vertices", b"gamut-max-error", b"gamut-max-mismatch")
"""Header fields of a mesh that its part repeats."""


class Asked(NamedTuple):
    """One requested mesh of a batch.

    `name` is the parameter ``triangles``, ``max_error`` or ``max_mismatch``, and `value` its value
    as the client wrote it.
    """

    gamut_id: str
    name: str
    value: str
    format_name: str
    side: Side = "both"

    @property
    def address(self) -> str:
        """Address of the single mesh."""
        side = "" if self.side == "both" else f"&side={self.side}"
        level = f"{self.name}={self.value}{side}"
        return f"/v1/gamuts/{self.gamut_id}/mesh?{level}&format={self.format_name}"


@dataclass(frozen=True)
class Item:
    """Result for a requested mesh: the mesh or a problem."""

    asked: Asked
    mesh: EncodedLevel | None
    problem: Problem | None = None


class Container(Protocol):
    """A file that contains meshes, written from start to end."""

    media_type: str

    def parts(self, item: Item) -> Iterator[bytes]:
        """Return the bytes of the next item."""

    def end(self) -> Iterator[bytes]:
        """Return the bytes after the last item."""


class _Window(io.BytesIO):
    """The end of a file that is written piece by piece: `take` removes all bytes so far."""

    _start = 0

    def tell(self) -> int:
        """Return the position in the whole file."""
        return self._start + super().tell()

    def seek(self, place: int, whence: int = io.SEEK_SET) -> int:
        """Move to a position in the whole file that was not taken yet."""
        return self._start + super().seek(place - self._start, whence)

    def take(self) -> bytes:
        """Return the bytes written since the last call."""
        content = self.getvalue()
        self._start += len(content)
        super().seek(0)
        self.truncate()
        return content


class ZipContainer:
    """A zip archive: ``GAMUT/TRIANGLES[-SIDE].SUFFIX`` per mesh, and ``index.json`` at the end.

    The index has an entry for every requested mesh, with the file or the problem; a repeated level
    is stored once. Every reader can read the archive, because it has less than 4 GiB and 65,536
    members.
    """

    media_type = "application/zip"

    def __init__(self, _asked: Sequence[Asked]) -> None:
        self._window = _Window()
        self._archive = zipfile.ZipFile(self._window, "w")
        self._index: list[dict[str, Any]] = []

    def parts(self, item: Item) -> Iterator[bytes]:
        """Return the bytes of the next item."""
        asked, mesh = item.asked, item.mesh
        entry: dict[str, Any] = {
            "gamut": asked.gamut_id,
            asked.name: int(asked.value) if asked.name == "triangles" else float(asked.value),
        }
        if asked.side != "both":
            entry["side"] = asked.side
        if mesh is None:
            entry["problem"] = None if item.problem is None else item.problem.document()
        else:
            fields = dict(mesh.headers)
            triangles = fields[b"gamut-triangles"].decode()
            side = "" if asked.side == "both" else f"-{asked.side}"
            name = f"{asked.gamut_id}/{triangles}{side}.{asked.format_name}"
            entry["file"] = name
            entry["sha256"] = mesh.etag.strip('"')
            for field in _CARRIED:
                if field in fields:
                    key = field.decode().removeprefix("gamut-").replace("-", "_")
                    if key in {"triangles", "vertices"}:
                        entry.setdefault("counts", {})[key] = int(fields[field])
                    else:
                        entry.setdefault("promises", {})[key] = float(fields[field])
            if name not in self._archive.NameToInfo:
                yield self._member(name, mesh.body)
        self._index.append(entry)

    def end(self) -> Iterator[bytes]:
        """Return the index and the central directory."""
        text = json.dumps({"meshes": self._index}, indent=1) + "\n"
        yield self._member("index.json", text.encode("ascii"))
        self._archive.close()
        yield self._window.take()

    def _member(self, name: str, content: bytes) -> bytes:
        # Without a time, which is the earliest date, equal meshes give equal archives.
        member = zipfile.ZipInfo(name)
        member.external_attr = _ATTRIBUTES
        self._archive.writestr(member, content)
        return self._window.take()


class MultipartContainer:
    """A multipart/mixed message with one part per requested mesh, in the requested order.

    A part has the header fields of the mesh, or is a problem document.
    """

    def __init__(self, asked: Sequence[Asked]) -> None:
        digest = hashlib.sha256("\n".join(one.address for one in asked).encode())
        self._boundary = f"gamut-{digest.hexdigest()[:40]}"
        self.media_type = f"multipart/mixed; boundary={self._boundary}"

    def parts(self, item: Item) -> Iterator[bytes]:
        """Return the bytes of the next item."""
        lines = [f"--{self._boundary}", f"Content-Location: {item.asked.address}"]
        if item.mesh is not None:
            fields = dict(item.mesh.headers)
            content = item.mesh.body
            lines += [
                f"{name.decode().title()}: {fields[name].decode()}"
                for name in (b"content-type", *_CARRIED)
                if name in fields
            ]
            lines.append(f"ETag: {item.mesh.etag}")
        else:
            document = {} if item.problem is None else item.problem.document()
            content = json.dumps(document).encode("ascii")
            lines.append(f"Content-Type: {MEDIA_TYPE}")
        lines.append(f"Content-Length: {len(content)}")
        yield ("\r\n".join(lines) + "\r\n\r\n").encode("ascii")
        yield content
        yield b"\r\n"

    def end(self) -> Iterator[bytes]:
        """Return the final boundary."""
        yield f"--{self._boundary}--\r\n".encode("ascii")


CONTAINERS: dict[str, type[ZipContainer | MultipartContainer]] = {
    "application/zip": ZipContainer,
    "multipart/mixed": MultipartContainer,
    OCTET_STREAM: ZipContainer,
}
"""Containers by the media types that a client may accept, the preferred one first."""
