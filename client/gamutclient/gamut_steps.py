"""What each method of a gamut sends, and how it reads the answer."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gamutclient.arrays import (
    BooleanArray,
    ColourRows,
    Colours,
    FloatArray,
    IndexArray,
    array_rows,
    colour_rows,
    npy_bytes,
    npy_records,
)
from gamutclient.errors import InvalidPointsError
from gamutclient.meshes import Mesh, mesh_of_ply
from gamutclient.results import (
    ChromaTable,
    ChromaticityComparison,
    ChromaticityGamut,
    ColourCrossings,
    ColourCusps,
    ColourSection,
    Conditions,
    GamutComparison,
    GamutRings,
    Intersection,
    MappedColours,
    NearestColours,
    Overlap,
)
from gamutclient.transport import Connections, Request, Retries, Steps, sent

if TYPE_CHECKING:
    import httpx

__all__ = ["GamutSteps", "Level", "MeshLevel", "Question", "RemoteGamut"]

NPY = "application/x-npy"
CSV = "text/csv"
JSON = "application/json"

_STRING = re.compile(r'"((?:[^"\\]|\\.)*)"')

MOST_ROWS = 250_000
"""Rows of one request: the service takes a million, and answers while the next rows are sent."""

VOLUMES = ("volume_a", "volume_b", "intersection")


class Level(TypedDict, total=False):
    """The level that answers: a triangle count or an error limit; the service's default if none."""

    triangles: int | None
    max_error: float | None


class Question(Level, total=False):
    """The level, and the space of the colours; that of the gamut by default."""

    space: str | None


class MeshLevel(TypedDict, total=False):
    """The level of a mesh, besides the triangle count."""

    max_error: float | None
    max_mismatch: float | None
    side: Literal["both", "inside", "outside"]


class RemoteGamut:
    """A gamut on the service: its description, and how it is asked."""

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

    def chromaticity(self) -> ChromaticityGamut | None:
        """Return the chromaticities of the gamut; None if they have no area."""
        stored = self.description.get("chromaticity")
        return stored and ChromaticityGamut.from_mapping(stored)

    def __repr__(self) -> str:
        space = self.description["provenance"].get("space", "CIELAB")
        return f"<{type(self).__name__} {self.id[:12]} in {space}: volume {self.volume:.4g}>"

    # --- requests --------------------------------------------------------------------------------

    def _get(
        self, part: str, params: Mapping[str, Any], accept: str = JSON
    ) -> Steps[httpx.Response]:
        path = f"/v1/gamuts/{self.id}/{part}" if part else f"/v1/gamuts/{self.id}"
        return sent(Request("GET", path, params, {"Accept": accept}), self.retries)

    def _post(
        self, operation: str, rows: ColourRows, params: Mapping[str, Any]
    ) -> Steps[tuple[NDArray[Any], dict[str, Any]]]:
        """Post rows in parts, and return the records of the answer and the facts of its level.

        A table is not divided, because its values decide their scale together.
        """
        found = []
        points, table = rows.points, rows.table
        for start in range(0, max(len(points), 1), MOST_ROWS):
            path = f"/v1/gamuts/{self.id}/{operation}"
            headers = {"Content-Type": NPY if table is None else CSV, "Accept": NPY}
            body = npy_bytes(points[start : start + MOST_ROWS]) if table is None else table
            request = Request("POST", path, params, headers, body)
            response = yield from sent(request, self.retries)
            records = npy_records(response.content)
            if "row" in (records.dtype.names or ()):
                records["row"] += start
            found.append(records)
        stated = response.headers.get("gamut-conditions")
        level = {
            "triangles": int(response.headers["gamut-triangles"]),
            "max_error": float(response.headers["gamut-max-error"]),
            "gamut": stated and Conditions.from_header(stated),
            "warnings": _strings(response.headers.get("gamut-warning", "")),
        }
        answers = np.concatenate(found)
        if table is not None and rows.shape[0] not in {-1, len(answers)}:
            message = f"{rows.shape[0] - len(answers)} rows of the table have no colour."
            raise InvalidPointsError(f"{message} Leave them out.")
        return answers, level

    def _on_surface(self, records: NDArray[Any]) -> dict[str, Any]:
        has_device = "device" in (records.dtype.names or ())
        return {
            "device": records["device"].astype(np.float64) if has_device else None,
            "channels": self.channels if has_device else (),
        }

    def _view(self, part: str, params: Mapping[str, Any]) -> Steps[dict[str, Any]]:
        response = yield from self._get(part, params)
        document: dict[str, Any] = response.json()
        return document

    def _section(self, plane: Mapping[str, Any], level: Level) -> Steps[ColourSection]:
        found = yield from self._view("slice", {**level, **plane})
        counts = [len(polygon) for polygon in found["polygons"]]
        device = [row for polygon in found.get("device", ()) for row in polygon]
        return ColourSection(
            points=_floats([row for polygon in found["polygons"] for row in polygon]).reshape(
                -1, 3
            ),
            device=_floats(device).reshape(-1, len(found["channels"]))
            if "device" in found
            else None,
            channels=tuple(found["channels"]),
            offsets=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
            **_level_of(found),
        )


class GamutSteps(RemoteGamut):
    """The steps of the methods. `Gamut` and `AsyncGamut` carry them out.

    A step of one method that needs another one names it by this class, because in `Gamut` the
    method of the same name has been carried out already.
    """

    # --- colours ---------------------------------------------------------------------------------

    def contains(
        self, colours: Colours, *, tolerance: float | None = None, **asked: Unpack[Question]
    ) -> Steps[BooleanArray]:
        """Whether colours are in gamut: inside the level, or within a tolerance of it.

        By default, the tolerance covers the error of the level and of the full boundary. With 0,
        colours are exactly inside or on the surface.
        """
        rows = colour_rows(colours)
        params = {**asked, "tolerance": tolerance}
        records, _ = yield from self._post("contains", rows, params)
        return rows.in_shape(records["inside"].astype(bool))

    def tolerance(self, **level: Unpack[Level]) -> Steps[float]:
        """Return the distance up to which a colour outside of a level counts as in gamut."""
        path = f"/v1/gamuts/{self.id}/contains"
        headers = {"Content-Type": JSON, "Accept": JSON}
        request = Request("POST", path, level, headers, b'{"colours": []}')
        response = yield from sent(request, self.retries)
        return float(response.json()["tolerance"])

    def distance(self, colours: Colours, **asked: Unpack[Question]) -> Steps[FloatArray]:
        """Return the distances of colours from the surface, negative inside."""
        rows = colour_rows(colours)
        params = {**asked, "distance": True}
        records, _ = yield from self._post("contains", rows, params)
        return rows.in_shape(records["distance"].astype(np.float64))

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
        rows = colour_rows(colours)
        limits = {"tolerance": tolerance, "edge_width": edge_width}
        # services of earlier versions know the tolerance alone
        limits["position"] = True if tolerance is None and edge_width is None else None
        params = {**asked, **limits}
        records, _ = yield from self._post("contains", rows, params)
        return rows.in_shape(records["position"])

    def nearest(
        self, colours: Colours, *, metric: str = "CIE 1976", **asked: Unpack[Question]
    ) -> Steps[NearestColours]:
        """Find the nearest points of the surface, by ``"CIE 1976"`` or ``"CIE 2000"``."""
        rows = colour_rows(colours)
        records, level = yield from self._post("nearest", rows, {**asked, "metric": metric})
        surface = self._on_surface(records)
        if surface["device"] is not None:
            surface["device"] = rows.in_shape(surface["device"])
        return NearestColours(
            points=rows.in_shape(records["point"].astype(np.float64)),
            distance=rows.in_shape(records["distance"].astype(np.float64)),
            delta_e=rows.in_shape(records["delta_e_2000"].astype(np.float64)),
            **surface,
            **level,
        )

    def map(
        self,
        colours: Colours,
        method: str = "clip-hue",
        *,
        focus: Colours | Literal["cusp"] | None = None,
        source: RemoteGamut | str | None = None,
        black_point_compensation: bool = False,
        **asked: Unpack[Question],
    ) -> Steps[MappedColours]:
        """Map colours into the gamut: ``"clip-hue"``, ``"clip-nearest"`` or ``"sgck"``."""
        rows = colour_rows(colours)
        params = {**asked, "method": method, "source": _id(source)}
        if black_point_compensation:  # unknown to services of earlier versions
            params["black_point_compensation"] = True
        if focus is not None:
            params["focus"] = focus if isinstance(focus, str) else np.ravel(focus).tolist()
        records, level = yield from self._post("map", rows, params)
        surface = self._on_surface(records)
        if surface["device"] is not None:
            surface["device"] = rows.in_shape(surface["device"])
        return MappedColours(
            points=rows.in_shape(records["mapped"].astype(np.float64)),
            moved=rows.in_shape(records["moved"].astype(bool)),
            delta_e=rows.in_shape(records["delta_e_2000"].astype(np.float64)),
            **surface,
            **level,
        )

    def crossings(
        self,
        starts: Colours,
        ends: Colours,
        *,
        kind: Literal["segment", "ray", "line"] = "segment",
        **asked: Unpack[Question],
    ) -> Steps[ColourCrossings]:
        """Find all crossings of lines with the surface, in order."""
        asked_rows = (array_rows(starts), array_rows(ends))
        both = np.broadcast_arrays(*(rows.in_shape(rows.points) for rows in asked_rows))
        lines = np.hstack([each.reshape(-1, 3) for each in both])
        records, level = yield from self._post(
            "crossings", ColourRows(lines, ()), {**asked, "kind": kind}
        )
        counts = np.bincount(records["row"], minlength=len(lines))
        return ColourCrossings(
            points=records["point"].astype(np.float64),
            t=records["t"].astype(np.float64),
            entering=records["entering"].astype(bool),
            offsets=np.concatenate([[0], np.cumsum(counts)]),
            **self._on_surface(records),
            **level,
        )

    # --- the shape -------------------------------------------------------------------------------

    def cusps(self, hues: int = 360, **level: Unpack[Level]) -> Steps[ColourCusps]:
        """Return the points of largest chroma at a number of equidistant hues, from 0° on."""
        found = yield from self._view("cusps", {**level, "hues": hues})
        return ColourCusps(
            points=_floats(found["point"]),
            device=_floats(found["device"]) if "device" in found else None,
            channels=tuple(found["channels"]),
            hue=_floats(found["hue"]),
            lightness=_floats(found["lightness"]),
            chroma=_floats(found["chroma"]),
            **_level_of(found),
        )

    def max_chroma(
        self, lightness: ArrayLike, hue: ArrayLike, **level: Unpack[Level]
    ) -> Steps[FloatArray]:
        """Return the largest chroma at lightnesses and hues, NaN where no colour is in gamut."""
        light, angle = np.broadcast_arrays(*(np.asarray(each, float) for each in (lightness, hue)))
        turn = np.radians(angle)
        ends = np.stack([light, np.cos(turn), np.sin(turn)], axis=-1)
        found = yield from GamutSteps.crossings(
            self, ends * (1.0, 0.0, 0.0), ends, kind="ray", **level
        )
        chroma = np.full(light.size, np.nan)
        crossed = found.offsets[1:] > found.offsets[:-1]
        chroma[crossed] = found.t[found.offsets[1:][crossed] - 1]
        return chroma.reshape(light.shape)

    def slice(
        self,
        L: float | None = None,
        *,
        hue: float | None = None,
        plane: ArrayLike | None = None,
        **level: Unpack[Level],
    ) -> Steps[ColourSection]:
        """Return the section by a plane: of a lightness, a hue, or a x + b y + c z = d."""
        return (yield from self._section(_plane(L, hue, plane), level))

    def leaf(self, hue: float, **level: Unpack[Level]) -> Steps[ColourSection]:
        """Return the section by the half-plane of a hue."""
        return (yield from self._section({"hue": hue}, level))

    def leaves(
        self, hues: int = 360, lightness: int = 101, **level: Unpack[Level]
    ) -> Steps[ChromaTable]:
        """Return the intervals of chroma in gamut for every hue and lightness."""
        found = yield from self._view("leaves", {**level, "hues": hues, "lightness": lightness})
        cells = [cell for row in found["intervals"] for cell in row]
        counts: IndexArray = np.array([len(cell) for cell in cells], np.int64)
        return ChromaTable(
            hue=_floats(found["hue"]),
            lightness=_floats(found["lightness"]),
            offsets=np.concatenate([[0], np.cumsum(counts)]),
            chroma=_floats([ends for cell in cells for ends in cell]).reshape(-1, 2),
            **_level_of(found),
        )

    def rings(
        self,
        reference: RemoteGamut | str | None = None,
        *,
        sectors: int = 360,
        **level: Unpack[Level],
    ) -> Steps[GamutRings]:
        """Return the gamut rings, alone or with those of a reference and the intersection."""
        params = {**level, "sectors": sectors, "reference": _id(reference)}
        found = yield from self._view("rings", params)
        others = ("reference_radius", "intersection_radius")
        return GamutRings(
            lightness=_floats(found["lightness"]),
            hues=_floats(found["hue"]),
            radius=_floats(found["radius"]),
            volume=float(found["volume"]),
            **{name: _floats(found[name]) for name in others if name in found},
            gamut=_conditions(found.get("gamut")),
            reference_gamut=_conditions(found.get("reference_gamut")),
            warnings=tuple(found.get("warnings", ())),
        )

    def slice_svg(
        self,
        L: float | None = None,
        *,
        hue: float | None = None,
        plane: ArrayLike | None = None,
        **level: Unpack[Level],
    ) -> Steps[bytes]:
        """Return the section as a picture."""
        params = {**level, **_plane(L, hue, plane)}
        response = yield from self._get("slice.svg", params, "image/svg+xml")
        return response.content

    def rings_svg(
        self,
        reference: RemoteGamut | str | None = None,
        *,
        sectors: int = 360,
        **level: Unpack[Level],
    ) -> Steps[bytes]:
        """Return the rings as a picture."""
        params = {**level, "sectors": sectors, "reference": _id(reference)}
        response = yield from self._get("rings.svg", params, "image/svg+xml")
        return response.content

    def picture(
        self,
        size: int = 800,
        view: str | Sequence[float] = "standard",
        *,
        background: Literal["white", "transparent"] = "white",
        axes: bool = True,
        **level: Unpack[Level],
    ) -> Steps[bytes]:
        """Return a picture of the gamut as PNG, from a named view or a hue and an elevation."""
        params = {**level, "size": size, "view": view, "background": background, "axes": axes}
        response = yield from self._get("picture.png", params, "image/png")
        return response.content

    # --- two gamuts ------------------------------------------------------------------------------

    def compare(
        self, other: RemoteGamut | str, *, sectors: int = 36, **level: Unpack[Level]
    ) -> Steps[GamutComparison]:
        """Compare this gamut, A, with another one, B: a gamut, an id or the slug of a reference."""
        params = {**level, "a": self.id, "b": _id(other), "sectors": sectors}
        request = Request("GET", "/v1/comparisons", params, {"Accept": JSON})
        found = (yield from sent(request, self.retries)).json()
        by_sector, gamuts = found["sectors"], found.get("gamuts", {})
        ends = ("white_a", "white_b", "black_a", "black_b")
        levels = [found["levels"][name] for name in "ab"]
        stored = found.get("chromaticity")
        facts: dict[str, Any] = {name: _floats(found[name]) for name in ends}
        facts |= {name: float(found[name]) for name in VOLUMES}
        return GamutComparison(
            **facts,
            hues=_floats([*by_sector["hue_from"], by_sector["hue_to"][-1]]),
            sectors=Overlap(*(_floats(by_sector[name]) for name in VOLUMES)),
            triangles=(levels[0]["triangles"], levels[1]["triangles"]),
            max_error=(levels[0]["max_error"], levels[1]["max_error"]),
            gamuts=(_conditions(gamuts.get("a")), _conditions(gamuts.get("b"))),
            warnings=tuple(found["warnings"]),
            chromaticity=stored and ChromaticityComparison.from_mapping(stored),
        )

    def coverage_of(self, other: RemoteGamut | str) -> Steps[float]:
        """Return the share of another gamut's volume that this gamut covers."""
        return (yield from GamutSteps.compare(self, other, sectors=1)).a_covers_b

    def warnings_about(self, other: RemoteGamut | str) -> Steps[tuple[str, ...]]:
        """Return reasons why a comparison with another gamut may mislead, as `compare` does."""
        return (yield from GamutSteps.compare(self, other, sectors=1)).warnings

    def intersection(self, other: RemoteGamut | str) -> Steps[Intersection]:
        """Return the part that both gamuts have; ``press & srgb`` of a blocking client."""
        found = yield from GamutSteps.compare(self, other, sectors=1)
        return Intersection(
            found.intersection,
            found.b_covers_a,
            found.a_covers_b,
            found.jaccard,
            found.gamuts,
            found.warnings,
        )

    # --- meshes and files ------------------------------------------------------------------------

    def mesh_file(
        self: RemoteGamut,
        format_name: str,
        triangles: int | None = None,
        **level: Unpack[MeshLevel],
    ) -> Steps[bytes]:
        """Return a level as a file of a format of the service, such as ``"glb"``."""
        params = {**level, "triangles": triangles, "format": format_name}
        response = yield from self._get("mesh", params, "*/*")
        return response.content

    def mesh(
        self: RemoteGamut, triangles: int | None = None, **level: Unpack[MeshLevel]
    ) -> Steps[Mesh]:
        """Return a level as arrays: of a triangle count, or within an error limit."""
        params = {**level, "triangles": triangles, "format": "ply"}
        response = yield from self._get("mesh", params, "*/*")
        error = response.headers.get("gamut-max-error")
        return mesh_of_ply(response.content, None if error is None else float(error))

    def to_bytes(self: RemoteGamut) -> Steps[bytes]:
        """Return the gamut as a history file, which `gamutcore.Gamut.from_bytes` reads."""
        return (yield from self._get("history", {}, "*/*")).content

    def file(self: RemoteGamut, suffix: str) -> Steps[bytes]:
        """Return the page with the viewer for ``".html"``, and else the history file."""
        if suffix.lower() in {".html", ".htm"}:
            return (yield from self._get("viewer.html", {}, "text/html")).content
        return (yield from self._get("history", {}, "*/*")).content

    def give_name(self, name: str) -> Steps[None]:
        """Give the gamut a name, which lists show."""
        request = Request("PUT", f"/v1/gamuts/{self.id}/name", json={"name": name})
        self.description["name"] = (yield from sent(request, self.retries)).json()["name"]

    def delete(self) -> Steps[None]:
        """Delete the gamut from the service."""
        yield from sent(Request("DELETE", f"/v1/gamuts/{self.id}"), self.retries)


def _id(gamut: RemoteGamut | str | None) -> str | None:
    """Return what the service knows another gamut by: its id, or the slug of a reference."""
    return gamut.id if isinstance(gamut, RemoteGamut) else gamut


def _plane(lightness: float | None, hue: float | None, plane: ArrayLike | None) -> dict[str, Any]:
    return {
        "lightness": lightness,
        "hue": hue,
        "plane": None if plane is None else np.ravel(plane).tolist(),
    }


def _floats(values: object) -> FloatArray:
    """Return JSON numbers as an array; null is NaN."""
    return np.array(values, np.float64)


def _level_of(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return the facts of an answer: its level, the conditions of its gamut, and warnings."""
    level = document["level"]
    return {
        "triangles": level["triangles"],
        "max_error": level["max_error"],
        "gamut": _conditions(document.get("gamut")),
        "warnings": tuple(document.get("warnings", ())),
    }


def _conditions(document: Mapping[str, Any] | None) -> Conditions | None:
    return None if document is None else Conditions.from_dict(document)


def _strings(text: str) -> tuple[str, ...]:
    """Return the strings of a list in a header field (RFC 9651, 3.1 and 3.3.3)."""
    return tuple(re.sub(r"\\(.)", r"\1", each) for each in _STRING.findall(text))
