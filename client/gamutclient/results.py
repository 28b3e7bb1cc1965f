"""What the methods of a gamut return. Names and shapes are those of `gamutcore`."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from gamutclient.arrays import BooleanArray, FloatArray, IndexArray
from gamutclient.shown import Shown

if TYPE_CHECKING:
    import trimesh

__all__ = [
    "ChromaTable",
    "ColourCrossings",
    "ColourCusps",
    "ColourSection",
    "Conditions",
    "GamutComparison",
    "Intersection",
    "MappedColours",
    "Mesh",
    "NearestColours",
    "Rings",
]


@dataclass(frozen=True, kw_only=True, repr=False)
class Conditions(Shown):
    """What the colours of a gamut are relative to.

    Attributes
    ----------
    intent : str
        ``"relative"``, ``"absolute"``, ``"perceptual"`` or ``"saturation"``; ``"as given"`` for
        colours whose white is not known.
    ink_limit, black_limit : float or None
        In per cent.
    white : str
        Name of the reference white of the space.
    space : str
    """

    intent: str
    ink_limit: float | None
    black_limit: float | None
    white: str
    space: str


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class SurfaceAnswer(Shown):
    """Colours on the surface of a level, and the device values there.

    Attributes
    ----------
    points : (..., 3) float64
        In the space of the colours that were given.
    device : (..., k) float64 or None
        Device values from 0 to 1; None if the gamut has colours only, NaN inside the gamut.
    channels : tuple of str
        Names of the k channels.
    triangles : int
        Triangle count of the level.
    max_error : float or None
        Upper bound of the distance of the level from the full boundary.
    gamut : Conditions or None
        What the colours of the gamut are relative to; None from services that do not state it.
    warnings : tuple of str
        Reasons why the answer may mislead.
    """

    points: FloatArray
    device: FloatArray | None
    channels: tuple[str, ...]
    triangles: int
    max_error: float | None
    gamut: Conditions | None = None
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class NearestColours(SurfaceAnswer):
    """The nearest points of the surface.

    Attributes
    ----------
    distance : (...) float64
        Euclidean distance in the space of the gamut.
    delta_e : (...) float64
        Colour difference CIE 2000.
    """

    distance: FloatArray
    delta_e: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class MappedColours(SurfaceAnswer):
    """Colours that were mapped into the gamut.

    Attributes
    ----------
    moved : (...) bool
    delta_e : (...) float64
        Colour difference CIE 2000 of the colours and their images.
    """

    moved: BooleanArray
    delta_e: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class ColourCrossings(SurfaceAnswer):
    """All crossings of lines with the surface, line by line, along each line.

    Attributes
    ----------
    offsets : (n + 1,) int64
        The crossings of line i are those from ``offsets[i]`` to ``offsets[i + 1]``.
    t : (m,) float64
        Place on the line: 0 at its start, 1 at its end.
    entering : (m,) bool
    """

    offsets: IndexArray
    t: FloatArray
    entering: BooleanArray


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class ColourCusps(SurfaceAnswer):
    """Cusps. NaN where a hue has none.

    Attributes
    ----------
    hue, lightness, chroma : (n,) float64
    """

    hue: FloatArray
    lightness: FloatArray
    chroma: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class ColourSection(SurfaceAnswer):
    """Closed polygons of a section, one after the other.

    Attributes
    ----------
    offsets : (k + 1,) int64
        Polygon i has the points from ``offsets[i]`` to ``offsets[i + 1]``.
    """

    offsets: IndexArray

    @property
    def polygons(self) -> list[FloatArray]:
        """The corners of each polygon, (m, 3)."""
        return np.split(self.points, self.offsets[1:-1]) if len(self.offsets) > 1 else []


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class ChromaTable(Shown):
    """Intervals of chroma inside the gamut, for every hue and lightness.

    Attributes
    ----------
    hue : (h,) float64
    lightness : (l,) float64
    offsets : (h · l + 1,) int64
        Hue i and lightness j have the intervals from ``offsets[i * l + j]`` to the next offset.
    chroma : (m, 2) float64
    triangles : int
    max_error : float or None
    """

    hue: FloatArray
    lightness: FloatArray
    offsets: IndexArray
    chroma: FloatArray
    triangles: int
    max_error: float | None
    gamut: Conditions | None = None
    warnings: tuple[str, ...] = ()

    @property
    def largest(self) -> FloatArray:
        """Largest chroma for each hue and lightness, (h, l); NaN where no colour is in gamut."""
        starts, ends = self.offsets[:-1], self.offsets[1:]
        last = np.append(self.chroma[:, 1], np.nan)[np.where(ends > starts, ends - 1, -1)]
        return last.reshape(len(self.hue), len(self.lightness))


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Rings(Shown):
    """Gamut rings (IDMS 1.1, 5.32).

    Attributes
    ----------
    lightness : (n,) float64
    hues : (s,) float64
    radius : (n, s) float64
    volume : float
    reference_radius, intersection_radius : (n, s) float64 or None
    """

    lightness: FloatArray
    hues: FloatArray
    radius: FloatArray
    volume: float
    reference_radius: FloatArray | None = None
    intersection_radius: FloatArray | None = None
    gamut: Conditions | None = None
    reference_gamut: Conditions | None = None
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class SectorFigures(Shown):
    """The figures of a comparison by sector of hue, arrays (n,)."""

    volume_a: FloatArray
    volume_b: FloatArray
    intersection: FloatArray
    union: FloatArray
    symmetric_difference: FloatArray
    a_covers_b: FloatArray
    b_covers_a: FloatArray
    jaccard: FloatArray


@dataclass(frozen=True, eq=False, repr=False)
class ChromaticityGamut(Shown):
    """The chromaticities of a gamut: a convex polygon.

    Attributes
    ----------
    xy : (n, 2) float64
        Corners in the CIE 1931 diagram, counter-clockwise, before any adaptation.
    basis : str
        ``"primaries"`` or ``"colours"``, the hull of the gamut's own colours.
    """

    xy: FloatArray
    basis: str

    @property
    def uv(self) -> FloatArray:
        """Corners in the CIE 1976 u′v′ diagram (CIE 15:2018, 8.2.2)."""
        x, y = self.xy.T
        scale = -2.0 * x + 12.0 * y + 3.0
        found: FloatArray = np.stack([4.0 * x / scale, 9.0 * y / scale], axis=1)
        return found


@dataclass(frozen=True, eq=False, repr=False)
class AreaOverlap(Shown):
    """Areas of two chromaticity gamuts in one diagram; `area_ratio` is A ÷ B."""

    area_a: float
    area_b: float
    intersection: float
    area_ratio: float
    a_covers_b: float
    b_covers_a: float


@dataclass(frozen=True, eq=False, repr=False)
class ChromaticityComparison(Shown):
    """Areas and coverage in the CIE 1931 xy and the CIE 1976 u′v′ diagram.

    Attributes
    ----------
    xy, uv : AreaOverlap
    basis_a, basis_b : str
        As `ChromaticityGamut.basis`.
    """

    xy: AreaOverlap
    uv: AreaOverlap
    basis_a: str
    basis_b: str


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class GamutComparison(Shown):
    """Comparison of two gamuts, A and B.

    Attributes
    ----------
    volume_a, volume_b, intersection, union, symmetric_difference : float
        In cubic units of the space.
    a_covers_b, b_covers_a, jaccard : float
    hues : (n + 1,) float64
        Ends of the sectors.
    sectors : SectorFigures
    white_a, white_b, black_a, black_b : (3,) float64
        The lightest and the darkest colours.
    triangles, max_error : tuple
        Of both levels.
    warnings : tuple of str
    chromaticity : ChromaticityComparison or None
        None if a gamut has no chromaticities.
    """

    volume_a: float
    volume_b: float
    intersection: float
    union: float
    symmetric_difference: float
    a_covers_b: float
    b_covers_a: float
    jaccard: float
    hues: FloatArray
    sectors: SectorFigures
    white_a: FloatArray
    white_b: FloatArray
    black_a: FloatArray
    black_b: FloatArray
    triangles: tuple[int, int]
    max_error: tuple[float | None, float | None]
    gamuts: tuple[Conditions | None, Conditions | None] = field(repr=False)
    warnings: tuple[str, ...]
    chromaticity: ChromaticityComparison | None


@dataclass(frozen=True, repr=False)
class Intersection(Shown):
    """The part that two gamuts have in common, as ``press & srgb`` gives it."""

    volume: float
    of_first: float
    of_second: float
    jaccard: float
    gamuts: tuple[Conditions | None, Conditions | None] = field(repr=False)
    warnings: tuple[str, ...]


def _not_loaded(_format_name: str) -> NoReturn:
    raise TypeError("Use `await gamut.mesh_file(format_name, ...)` for a file in another format.")


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Mesh(Shown):
    """A level as a triangle mesh.

    Attributes
    ----------
    vertices : (n, 3) float32
        In the space of the gamut.
    faces : (m, 3) int32
        Anticlockwise as seen from outside.
    device : (n, k) float32 or None
        Device values from 0 to 1.
    channels : tuple of str
    max_error : float or None
        Upper bound of the distance from the full boundary.
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    device: NDArray[np.float32] | None
    channels: tuple[str, ...]
    max_error: float | None
    load: Callable[[str], bytes] = field(default=_not_loaded, repr=False)

    @property
    def triangles(self) -> int:
        """Number of triangles."""
        return len(self.faces)

    @property
    def volume(self) -> float:
        """Enclosed volume."""
        one, two, three = (self.vertices[self.faces[:, k]].astype(np.float64) for k in range(3))
        return float(np.einsum("ij,ij->", one, np.cross(two, three)) / 6.0)

    def to_bytes(self, format_name: str) -> bytes:
        """Return the mesh as a file of a format of the service, such as ``"glb"``."""
        return self.load(format_name)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the mesh to a file in the format of its suffix, such as ``.glb``."""
        Path(path).write_bytes(self.load(Path(path).suffix.removeprefix(".").lower()))

    def to_trimesh(self) -> trimesh.Trimesh:
        """Return a `trimesh.Trimesh`, none of whose vertices are merged."""
        import trimesh as library  # noqa: PLC0415  # optional

        made: Any = library.Trimesh(self.vertices, self.faces, process=False, validate=False)
        return made  # type: ignore[no-any-return]
