"""Gamuts on the service: what each method sends, and how it reads the answer."""

from __future__ import annotations

import asyncio
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gamutclient import results
from gamutclient.arrays import (
    BooleanArray,
    ColourRows,
    Colours,
    FloatArray,
    array_rows,
    colour_rows,
    npy_bytes,
    npy_records,
)
from gamutclient.errors import InvalidPointsError
from gamutclient.meshes import Mesh, mesh_of_ply
from gamutclient.number_text import number_text
from gamutclient.transport import (
    Awaiting,
    Blocking,
    Connections,
    Request,
    Retries,
    Steps,
    method,
    run,
    run_async,
    sent,
)

if TYPE_CHECKING:
    import httpx

__all__ = ["AsyncGamut", "Gamut", "Level", "MeshLevel", "Question", "RemoteGamut"]

NPY = "application/x-npy"
CSV = "text/csv"
JSON = "application/json"

PICTURES = {
    ".png": "image/png",
    ".tif": "image/tiff",
    ".tiff": "image/tiff",
    ".jpg": "image/jpeg",
    ".exr": "image/x-exr",
}
"""Media types of pictures that the service writes, by the suffix of the file."""

MOST_ROWS = 250_000
"""Rows of one request: the service takes a million, and answers while the next rows are sent."""

SPACE_OPTIONS = (
    *("space", "reference_white", "adaptation", "luminance"),
    *("adapting_luminance", "background", "surround"),
)
"""Options of a build that are its space: references that are shown beside a gamut have its own."""

VOLUMES = ("volume_a", "volume_b", "intersection")

SECTORS = (
    *(*VOLUMES, "max_chroma_a", "max_chroma_b", "lost_mean_a", "lost_mean_b"),
    *("lost_percentile_95_a", "lost_percentile_95_b"),
)


class Level(TypedDict, total=False):
    """The level that answers: a triangle count or an error limit; the service's default if none."""

    triangles: int | None
    max_error: float | None


class Space(TypedDict, total=False):
    """The space of the colours; that of the gamut by default."""

    space: str | None


class Question(Level, Space, total=False):
    """The level, and the space of the colours."""


class MeshLevel(TypedDict, total=False):
    """The level of a mesh, besides the triangle count."""

    max_error: float | None
    max_mismatch: float | None
    side: Literal["both", "inside", "outside"]


class RemoteGamut:
    """A gamut on the service: its description, and what its methods send."""

    def __init__(self, http: Connections, description: Mapping[str, Any], retries: Retries) -> None:
        self.http, self.retries = http, retries
        self.description = dict(description)

    @property
    def id(self) -> str:
        """The gamut's id, 64 hexadecimal digits."""
        return str(self.description["id"])

    @property
    def volume(self) -> float:
        """Volume of the full boundary, in cubic units of the space."""
        return float(self.description["volume"])

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the device's channels; empty if the gamut has colours only."""
        return tuple(self.description["provenance"].get("channels") or ())

    def chromaticity(self) -> results.ChromaticityGamut | None:
        """Return the chromaticities of the gamut; None if they have no area."""
        stored = self.description.get("chromaticity")
        return stored and results.ChromaticityGamut.from_mapping(stored)

    def __repr__(self) -> str:
        space = self.description["provenance"].get("space", "CIELAB")
        volume = number_text(self.volume, 4)
        return f"<{type(self).__name__} {self.id[:12]} in {space}: volume {volume}>"

    # --- colours ---------------------------------------------------------------------------------

    def _ask(
        self, operation: str, rows: ColourRows, params: Mapping[str, Any]
    ) -> Steps[tuple[dict[str, NDArray[Any]], dict[str, Any]]]:
        """Post rows in parts, and return the columns of the answer and the facts of its level.

        A table is not divided, because its values decide their scale together.
        """
        found = []
        points, table = rows.points, rows.table
        for start in range(0, max(len(points), 1), MOST_ROWS):
            path = f"/v1/gamuts/{self.id}/{operation}"
            headers = {"Content-Type": NPY if table is None else CSV, "Accept": NPY}
            body = npy_bytes(points[start : start + MOST_ROWS]) if table is None else table
            request = Request("POST", path, params, headers, {"content": body})
            response = yield from sent(request, self.retries)
            part = npy_records(response.content)
            if "row" in (part.dtype.names or ()):
                part["row"] += start
            found.append(part)
        records = np.concatenate(found)
        if table is not None and rows.shape[0] not in {-1, len(records)}:
            message = f"{rows.shape[0] - len(records)} rows of the table have no colour."
            raise InvalidPointsError(f"{message} Leave them out.")
        columns = {name: records[name].copy() for name in records.dtype.names or ()}
        if "row" not in columns:
            columns = {name: rows.in_shape(values) for name, values in columns.items()}
        stated = response.headers.get("gamut-conditions")
        conditions = results.Conditions.from_header(stated) if stated else None
        own = conditions.space if conditions else ""
        return columns, {
            "device": columns.get("device"),
            "channels": self.channels if "device" in columns else (),
            "triangles": int(response.headers["gamut-triangles"]),
            "max_error": float(response.headers["gamut-max-error"]),
            # the service finds the space of a table by its columns, and does not name it
            "space": params.get("space") or (own if table is None else ""),
            "gamut": conditions,
            "warnings": _strings(response.headers.get("gamut-warning", "")),
        }

    @method
    def contains(
        self, colours: Colours, *, tolerance: float | None = None, **asked: Unpack[Question]
    ) -> Steps[BooleanArray]:
        """Whether colours are in gamut: inside the level, or within a tolerance of it.

        By default, the tolerance covers the error of the level and of the full boundary. With 0,
        colours are exactly inside or on the surface.
        """
        params = {**asked, "tolerance": tolerance}
        found, _ = yield from self._ask("contains", colour_rows(colours), params)
        return found["inside"]

    @method
    def tolerance(self, **level: Unpack[Level]) -> Steps[float]:
        """Return the distance up to which a colour outside of a level counts as in gamut."""
        path, headers = f"/v1/gamuts/{self.id}/contains", {"Accept": JSON}
        request = Request("POST", path, level, headers, {"json": {"colours": []}})
        response = yield from sent(request, self.retries)
        return float(response.json()["tolerance"])

    @method
    def distance(
        self, colours: Colours, *, metric: str | None = None, **asked: Unpack[Question]
    ) -> Steps[FloatArray]:
        """Return the least distances of colours from the surface, negative inside.

        By ``"CIE 1976"``, Euclidean in the space of the gamut, or ``"CIE 2000"``.
        """
        params = {**asked, "distance": True, "metric": metric}
        found, _ = yield from self._ask("contains", colour_rows(colours), params)
        return found["distance"]

    @method
    def classify(
        self,
        colours: Colours,
        *,
        edge_width: float | None = None,
        tolerance: float | None = None,
        **asked: Unpack[Question],
    ) -> Steps[NDArray[np.str_]]:
        """Say whether colours are ``"inside"``, at the ``"edge"`` or ``"outside"``.

        A colour is at the edge if its distance from the surface is at most `edge_width`, or the
        tolerance. The default width is `tolerance` if that is given, else 1 in CIELAB.
        """
        params = {**asked, "tolerance": tolerance, "edge_width": edge_width}
        if tolerance is None and edge_width is None:  # services of earlier versions know no more
            params["position"] = True
        found, _ = yield from self._ask("contains", colour_rows(colours), params)
        return found["position"]

    @method
    def nearest(
        self, colours: Colours, *, metric: str = "CIE 1976", **asked: Unpack[Question]
    ) -> Steps[results.NearestColours]:
        """Find the nearest colours of the surface, by ``"CIE 1976"`` or ``"CIE 2000"``."""
        params = {**asked, "metric": metric}
        found, facts = yield from self._ask("nearest", colour_rows(colours), params)
        return results.NearestColours(
            points=found["point"],
            distance=found["distance"],
            delta_e=found["delta_e_2000"],
            **facts,
        )

    @method
    def to_device(
        self,
        colours: Colours,
        *,
        black: str | float | None = None,
        method: str = "clip-nearest",
        **asked: Unpack[Question],
    ) -> Steps[results.ColourRecipes]:
        """Find device values that give colours, with a rule of black, by default ``"medium"``."""
        params = {**asked, "black": black, "method": method}
        found, facts = yield from self._ask("recipes", colour_rows(colours), params)
        return results.ColourRecipes(
            points=found["colour"],
            delta_e=found["delta_e_2000"],
            inside=found["inside"],
            black_least=found.get("black_least"),
            black_most=found.get("black_most"),
            **facts,
        )

    @method
    def to_colour(self, device: ArrayLike, **asked: Unpack[Space]) -> Steps[FloatArray]:
        """Give the colours of device values, (..., k) from 0 to 1, in the order of the channels."""
        values = np.asarray(device, np.float64)
        rows = ColourRows(values.reshape(-1, values.shape[-1]), values.shape[:-1])
        found, _ = yield from self._ask("colours", rows, asked)
        return found["colour"]

    @method
    def map(
        self,
        colours: Colours,
        method: str = "clip-hue",
        *,
        focus: Colours | Literal["cusp"] | None = None,
        source: RemoteGamut | str | None = None,
        black_point_compensation: bool = False,
        **asked: Unpack[Question],
    ) -> Steps[results.MappedColours]:
        """Map colours into the gamut: ``"clip-hue"``, ``"clip-nearest"`` or ``"sgck"``."""
        params = {**asked, "method": method, "source": _id(source)}
        if black_point_compensation:  # unknown to services of earlier versions
            params["black_point_compensation"] = True
        if focus is not None:
            params["focus"] = focus if isinstance(focus, str) else np.ravel(focus).tolist()
        found, facts = yield from self._ask("map", colour_rows(colours), params)
        return results.MappedColours(
            points=found["mapped"], moved=found["moved"], delta_e=found["delta_e_2000"], **facts
        )

    @method
    def map_picture(
        self,
        picture: str | os.PathLike[str] | bytes,
        output: str | os.PathLike[str],
        method: str = "clip-hue",
        *,
        focus: Colours | Literal["cusp"] | None = None,
        source: RemoteGamut | str | None = None,
        black_point_compensation: bool | None = None,
        decode: Literal["bt1886", "oetf", "pq", "hlg", "srgb"] | None = None,
        iterations: int | None = None,
        depth: Literal["8", "16", "half", "float"] | None = None,
        table: int | None = None,
        to: str = "picture",
        black: str | float | Sequence[tuple[float, float]] | None = None,
        **level: Unpack[Level],
    ) -> Steps[dict[str, float]]:
        """Map a picture file of gray or RGB into the gamut, and write the result.

        `output` is a .png, .tif, .exr or .jpg file. `to` is the encoding of the result:
        ``"picture"``, the slug of an RGB space, or ``"device"``, such as CMYK as TIFF. `decode`
        is how values without a profile become light, by default as displays do. Returned are the
        numbers of pixels and distinct colours, in all, ``outside`` and ``moved``, and the
        differences ``delta_e`` and ``delta_e_95``, by their names in the field Gamut-Mapped.
        """
        target = Path(output)
        suffix = target.suffix.lower()
        if suffix not in PICTURES:
            message = f"Pictures are not written as {suffix!r}. Give one of {', '.join(PICTURES)}."
            raise ValueError(message)
        content = picture if isinstance(picture, bytes) else Path(picture).read_bytes()
        if black is not None and not isinstance(black, str | float | int):
            black = ",".join(f"{light}:{amount}" for light, amount in black)
        params = {
            **level,
            "method": method,
            "source": _id(source),
            "black_point_compensation": black_point_compensation,
            "decode": decode,
            "focus": focus if focus is None or isinstance(focus, str) else np.ravel(focus).tolist(),
            "iterations": iterations,
            "depth": depth,
            "table": table,
            "to": to,
            "black": black,
        }
        headers = {"Content-Type": "image/*", "Accept": PICTURES[suffix]}
        path = f"/v1/gamuts/{self.id}/map"
        request = Request("POST", path, params, headers, {"content": content})
        answer = yield from sent(request, self.retries)
        draft = target.with_name(f".{target.name}.part")
        draft.write_bytes(answer.content)
        draft.replace(target)
        told = (each.partition("=") for each in answer.headers["gamut-mapped"].split(", "))
        return {name.replace("-", "_"): float(value) for name, _, value in told}

    def _crossings(
        self, starts: Colours, ends: Colours, params: Mapping[str, Any]
    ) -> Steps[results.ColourCrossings]:
        rows = (array_rows(starts), array_rows(ends))
        both = np.broadcast_arrays(*(each.in_shape(each.points) for each in rows))
        lines = np.hstack([each.reshape(-1, 3) for each in both])
        found, facts = yield from self._ask("crossings", ColourRows(lines, ()), params)
        return results.ColourCrossings(
            points=found["point"],
            t=found["t"],
            entering=found["entering"],
            offsets=_offsets(np.bincount(found["row"], minlength=len(lines))),
            **facts,
        )

    @method
    def crossings(
        self,
        starts: Colours,
        ends: Colours,
        *,
        kind: Literal["segment", "ray", "line"] = "segment",
        **asked: Unpack[Question],
    ) -> Steps[results.ColourCrossings]:
        """Find the crossings of lines with the surface, in order."""
        return self._crossings(starts, ends, {**asked, "kind": kind})

    @method
    def max_chroma(
        self, lightness: ArrayLike, hue: ArrayLike, **level: Unpack[Level]
    ) -> Steps[FloatArray]:
        """Return the largest chroma at lightnesses and hues, NaN where no colour is in gamut."""
        light, angle = np.broadcast_arrays(*(np.asarray(each, float) for each in (lightness, hue)))
        turn = np.radians(angle)
        ends = np.stack([light, np.cos(turn), np.sin(turn)], axis=-1)
        starts = ends * (1.0, 0.0, 0.0)
        found = yield from self._crossings(starts, ends, {**level, "kind": "ray"})
        chroma = np.full(light.size, np.nan)
        crossed = found.offsets[1:] > found.offsets[:-1]
        chroma[crossed] = found.t[found.offsets[1:][crossed] - 1]
        return chroma.reshape(light.shape)

    # --- the shape -------------------------------------------------------------------------------

    def _get(
        self, part: str, params: Mapping[str, Any], accept: str = "*/*"
    ) -> Steps[httpx.Response]:
        path = f"/v1/gamuts/{self.id}/{part}"
        return sent(Request("GET", path, params, {"Accept": accept}), self.retries)

    def _file(self, part: str, params: Mapping[str, Any], accept: str = "*/*") -> Steps[bytes]:
        return (yield from self._get(part, params, accept)).content

    def _shape(
        self, part: str, params: Mapping[str, Any]
    ) -> Steps[tuple[dict[str, Any], dict[str, Any]]]:
        """Return the answer to a question about the shape, and the facts of its level."""
        document = (yield from self._get(part, params, JSON)).json()
        level = document["level"]
        return document, {
            "triangles": level["triangles"],
            "max_error": level["max_error"],
            "gamut": _conditions(document.get("gamut")),
            "warnings": tuple(document.get("warnings", ())),
        }

    @method
    def cusps(self, hues: int = 360, **level: Unpack[Level]) -> Steps[results.ColourCusps]:
        """List the cusps: points of largest chroma at a number of equidistant hues, from 0° on."""
        found, facts = yield from self._shape("cusps", {**level, "hues": hues})
        return results.ColourCusps(
            points=_floats(found["point"]),
            device=_floats(found["device"]) if "device" in found else None,
            channels=tuple(found["channels"]),
            **_members(found, "hue", "lightness", "chroma"),
            **facts,
        )

    def _section(self, params: Mapping[str, Any]) -> Steps[results.ColourSection]:
        found, facts = yield from self._shape("slice", params)
        channels = tuple(found["channels"])
        device = [row for polygon in found.get("device", ()) for row in polygon]
        points = [row for polygon in found["polygons"] for row in polygon]
        return results.ColourSection(
            points=_floats(points).reshape(-1, 3),
            device=_floats(device).reshape(-1, len(channels)) if "device" in found else None,
            channels=channels,
            offsets=_offsets([len(polygon) for polygon in found["polygons"]]),
            **facts,
        )

    @method
    def slice(
        self,
        L: float | None = None,
        *,
        hue: float | None = None,
        plane: ArrayLike | None = None,
        **level: Unpack[Level],
    ) -> Steps[results.ColourSection]:
        """Cut the gamut by a plane: of a lightness, a hue, or a x + b y + c z = d."""
        return self._section({**level, "lightness": L, "hue": hue, "plane": _numbers(plane)})

    @method
    def leaf(self, hue: float, **level: Unpack[Level]) -> Steps[results.ColourSection]:
        """Return the section by the half-plane of a hue."""
        return self._section({**level, "hue": hue})

    @method
    def leaves(
        self, hues: int = 360, lightness: int = 101, **level: Unpack[Level]
    ) -> Steps[results.ChromaTable]:
        """List the intervals of chroma in gamut for every hue and lightness."""
        params = {**level, "hues": hues, "lightness": lightness}
        found, facts = yield from self._shape("leaves", params)
        cells = [cell for row in found["intervals"] for cell in row]
        channels = tuple(found.get("channels", ()))
        device = None
        if "device" in found:
            values = [ends for row in found["device"] for cell in row for ends in cell]
            device = _floats(values).reshape(-1, 2, len(channels))
        return results.ChromaTable(
            **_members(found, "hue", "lightness"),
            device=device,
            channels=channels,
            offsets=_offsets([len(cell) for cell in cells]),
            chroma=_floats([ends for cell in cells for ends in cell]).reshape(-1, 2),
            **facts,
        )

    @method
    def rings(
        self,
        reference: RemoteGamut | str | None = None,
        *,
        sectors: int = 360,
        **level: Unpack[Level],
    ) -> Steps[results.GamutRings]:
        """List the gamut rings, alone or with those of a reference and the intersection."""
        params = {**level, "sectors": sectors, "reference": _id(reference)}
        found = (yield from self._get("rings", params, JSON)).json()
        radii = ("radius", "reference_radius", "intersection_radius")
        return results.GamutRings(
            hues=_floats(found["hue"]),
            volume=float(found["volume"]),
            **_members(found, "lightness", *radii),
            gamut=_conditions(found.get("gamut")),
            reference_gamut=_conditions(found.get("reference_gamut")),
            warnings=tuple(found.get("warnings", ())),
        )

    @method
    def picture(
        self,
        size: int = 800,
        view: str | Sequence[float] = "standard",
        *,
        background: Literal["white", "transparent"] = "white",
        axes: bool = True,
        **level: Unpack[Level],
    ) -> Steps[bytes]:
        """Draw the gamut as PNG, from a named view or a hue and an elevation."""
        params = {**level, "size": size, "view": view, "background": background, "axes": axes}
        return self._file("picture.png", params, "image/png")

    @method
    def uncertainty(
        self, noise: float | None = None, *, instrument: float = 0.0
    ) -> Steps[results.VolumeUncertainty]:
        """Estimate how well the volume is known: its 95 % interval, with the parts.

        `noise` is the root mean square ΔE*ab of one reading, by default that of repeated patches.
        `instrument` is the error that all readings have in common.
        """
        params = {"noise": noise, "instrument": instrument}
        found = (yield from self._get("uncertainty", params, JSON)).json()
        return results.VolumeUncertainty(
            volume=results.Interval(**found["volume"]),
            relative=results.Interval(**found["relative"]),
            **{name: found[name] for name in ("noise", "noise_from", "patches", "patches_needed")},
            summary=tuple(found["summary"]),
            gamut=_conditions(found.get("gamut")),
            warnings=tuple(found.get("warnings", ())),
        )

    # --- two gamuts ------------------------------------------------------------------------------

    def _compare(
        self,
        other: RemoteGamut | str,
        sectors: int = 1,
        *,
        lost: bool = False,
        **level: Unpack[Level],
    ) -> Steps[results.GamutComparison]:
        params = {**level, "a": self.id, "b": _id(other), "sectors": sectors}
        params |= {"lost": True} if lost else {}
        request = Request("GET", "/v1/comparisons", params, {"Accept": JSON})
        found = (yield from sent(request, self.retries)).json()
        by_sector, gamuts = found["sectors"], found.get("gamuts", {})
        levels = [found["levels"][name] for name in "ab"]
        stored = found.get("chromaticity")
        volumes: dict[str, Any] = {name: float(found[name]) for name in VOLUMES}
        return results.GamutComparison(
            **volumes,
            **_members(found, "white_a", "white_b", "black_a", "black_b"),
            hues=_floats([*by_sector["hue_from"], by_sector["hue_to"][-1]]),
            sectors=results.HueSectors(**_members(by_sector, *SECTORS)),
            triangles=(levels[0]["triangles"], levels[1]["triangles"]),
            max_error=(levels[0]["max_error"], levels[1]["max_error"]),
            gamuts=(_conditions(gamuts.get("a")), _conditions(gamuts.get("b"))),
            warnings=tuple(found["warnings"]),
            chromaticity=stored and results.ChromaticityComparison.from_mapping(stored),
            lost_a=_loss(found.get("lost_a")),
            lost_b=_loss(found.get("lost_b")),
            summary=tuple(found.get("summary", ())),
        )

    @method
    def compare(
        self,
        other: RemoteGamut | str,
        *,
        sectors: int = 36,
        lost: bool = False,
        **level: Unpack[Level],
    ) -> Steps[results.GamutComparison]:
        """Compare two gamuts: this one, A, and B: a gamut, an id or the slug of a reference."""
        return self._compare(other, sectors, lost=lost, **level)

    @method
    def coverage_of(self, other: RemoteGamut | str) -> Steps[float]:
        """Return the share of another gamut's volume that this gamut covers."""
        return (yield from self._compare(other)).a_covers_b

    @method
    def warnings_about(self, other: RemoteGamut | str) -> Steps[tuple[str, ...]]:
        """Return reasons why a comparison with another gamut may mislead, as `compare` does."""
        return (yield from self._compare(other)).warnings

    @method
    def intersection(self, other: RemoteGamut | str) -> Steps[results.Intersection]:
        """Return the part that both gamuts have; ``press & srgb`` of a blocking client."""
        found = yield from self._compare(other)
        return results.Intersection(
            found.intersection,
            found.b_covers_a,
            found.a_covers_b,
            found.jaccard,
            found.gamuts,
            found.warnings,
        )

    # --- meshes and files ------------------------------------------------------------------------

    def _mesh(self, triangles: int | None, **level: Unpack[MeshLevel]) -> Steps[Mesh]:
        params = {**level, "triangles": triangles, "format": "ply"}
        response = yield from self._get("mesh", params)
        error = response.headers.get("gamut-max-error")
        return mesh_of_ply(response.content, None if error is None else float(error))

    @method
    def mesh_file(
        self, format_name: str, triangles: int | None = None, **level: Unpack[MeshLevel]
    ) -> Steps[bytes]:
        """Return a level as a file of a format of the service, such as ``"glb"``."""
        return self._file("mesh", {**level, "triangles": triangles, "format": format_name})

    @method
    def to_bytes(self) -> Steps[bytes]:
        """Return the gamut as a history file, which `gamutcore.Gamut.from_bytes` reads."""
        return self._file("history", {})

    def _saved(self, path: str | os.PathLike[str]) -> Steps[bytes]:
        """Return the page with the viewer for the suffix ``.html``, and else the history file."""
        if Path(path).suffix.lower() in {".html", ".htm"}:
            return self._file("viewer.html", {}, "text/html")
        return self._file("history", {})

    @method
    def show(
        self,
        *others: RemoteGamut | str,
        state: str = "",
        height: int = results.VIEWER_HEIGHT,
    ) -> Steps[results.ViewerPage]:
        """Show the gamut and others with the viewer in a notebook, without a network.

        Up to five others are gamuts, ids or slugs of references, which have the space of this
        gamut. `state` is how the page begins: what stands behind the number sign of its address,
        such as ``"lightness=50&outside=on"``.
        """
        ids = list(filter(None, map(_id, others)))
        params: dict[str, Any] = {"with": ids or None}
        if not all(re.fullmatch("[0-9a-f]{64}", each) for each in ids):
            options = self.description["options"]
            params |= {name: options.get(name) for name in SPACE_OPTIONS}
        html = yield from self._file("viewer.html", params, "text/html")
        return results.ViewerPage.restoring(html, state, height)

    @method
    def give_name(self, name: str) -> Steps[None]:
        """Give the gamut a name, which lists show."""
        request = Request("PUT", f"/v1/gamuts/{self.id}/name", body={"json": {"name": name}})
        self.description["name"] = (yield from sent(request, self.retries)).json()["name"]

    @method
    def delete(self) -> Steps[None]:
        """Delete the gamut from the service."""
        yield from sent(Request("DELETE", f"/v1/gamuts/{self.id}"), self.retries)


class Gamut(Blocking, RemoteGamut):
    """A gamut on the service. `Client` returns it.

    Attributes
    ----------
    description : dict
        What the service says about the gamut: id, options, provenance, counts, volume.

    Notes
    -----
    Colours in arguments are arrays (..., 3) in the space of the gamut, unless `space` names another
    one. Questions are answered on the level of `triangles`, the smallest within `max_error`, or by
    default one within 0.1 in CIELAB.
    """

    def mesh(self, triangles: int | None = None, **level: Unpack[MeshLevel]) -> Mesh:
        """Return a level as a mesh: of a triangle count, or within an error limit."""

        def load(format_name: str) -> bytes:
            return self.mesh_file(format_name, triangles, **level)

        return replace(run(self._mesh(triangles, **level), self.http), load=load)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the gamut to a file that `gamutcore.Gamut.load` reads, or to a page, ``.html``."""
        Path(path).write_bytes(run(self._saved(path), self.http))

    def __and__(self, other: object) -> results.Intersection:
        """Return the intersection with another gamut: its volume, and its shares of both."""
        return self.intersection(other) if isinstance(other, RemoteGamut | str) else NotImplemented


class AsyncGamut(Awaiting, RemoteGamut):
    """A gamut on the service whose methods are coroutines. `AsyncClient` returns it.

    Attributes
    ----------
    description : dict
        As for `Gamut`.
    """

    @method
    def mesh(self, triangles: int | None = None, **level: Unpack[MeshLevel]) -> Steps[Mesh]:
        """Return a level as arrays: of a triangle count, or within an error limit."""
        return self._mesh(triangles, **level)

    async def save(self, path: str | os.PathLike[str]) -> None:
        """Write the gamut to a file that `gamutcore.Gamut.load` reads, or to a page, ``.html``."""
        content = await run_async(self._saved(path), self.http)
        await asyncio.to_thread(Path(path).write_bytes, content)


def _id(gamut: RemoteGamut | str | None) -> str | None:
    """Return what the service knows another gamut by: its id, or the slug of a reference."""
    return gamut.id if isinstance(gamut, RemoteGamut) else gamut


def _numbers(values: ArrayLike | None) -> list[float] | None:
    return None if values is None else np.ravel(values).tolist()


def _floats(values: object) -> FloatArray:
    """Return JSON numbers as an array; null is NaN."""
    return np.array(values, np.float64)


def _members(document: Mapping[str, Any], *names: str) -> dict[str, Any]:
    """Return those members of a document that it has, as arrays."""
    return {name: _floats(document[name]) for name in names if name in document}


def _loss(stored: Mapping[str, float] | None) -> results.ColourLoss | None:
    if stored is None:
        return None
    names = [each.name for each in fields(results.ColourLoss)]
    return results.ColourLoss(**{name: stored[name] for name in names})


def _offsets(counts: ArrayLike) -> NDArray[np.int64]:
    """Return the first entry of each of some lists, and the end of the last, by their lengths."""
    return np.concatenate([[0], np.cumsum(np.asarray(counts, np.int64))])


def _conditions(document: Mapping[str, Any] | None) -> results.Conditions | None:
    return None if document is None else results.Conditions.from_dict(document)


def _strings(text: str) -> tuple[str, ...]:
    """Return the strings of a list in a header field (RFC 9651, 3.1 and 3.3.3)."""
    return tuple(re.sub(r"\\(.)", r"\1", each) for each in re.findall(r'"((?:[^"\\]|\\.)*)"', text))
