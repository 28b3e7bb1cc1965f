"""Fixtures of several test modules of the compute package."""

from __future__ import annotations

import functools
import io
import struct
from pathlib import Path
from typing import TYPE_CHECKING

import meshio
import numpy as np
import pytest
import trimesh

from gamutcore import Gamut, Options, reference
from gamutcore.boundary import Boundary, modified_convex_hull, wrap_colours
from gamutcore.characterisation import read_characterisation
from gamutcore.colours import ICC_D50, surface_colours
from gamutcore.colours.colorimetry import colour_science
from gamutcore.decimation import decimate
from gamutcore.geometry import TriangleMesh, connected_components
from gamutcore.history import History, build_history
from gamutcore.references import find_reference

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    import pygltflib
    from numpy.typing import ArrayLike

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of the real and malformed files that are shared beside the checkout."""
    folder = ROOT.parent / "shared" / "data"
    if not folder.is_dir():
        pytest.skip("the shared data folder is not beside this checkout")
    return folder


@pytest.fixture(scope="session")
def fogra39() -> bytes:
    """FOGRA39L, a real press: 1617 CMYK patches with XYZ and Lab."""
    return (ROOT / "examples" / "FOGRA39L.ti3").read_bytes()


@pytest.fixture(scope="session")
def few_patches(fogra39: bytes) -> bytes:
    """FOGRA39L with those 90 patches whose inks are 0, 40 or 100 %."""
    lines = fogra39.decode().splitlines()
    start = lines.index("BEGIN_DATA") + 1
    rows = [row for row in lines[start:-1] if {*map(float, row.split()[1:5])} <= {0, 40, 100}]
    head = [line.replace("SETS 1617", f"SETS {len(rows)}") for line in lines[:start]]
    return "\n".join([*head, *rows, "END_DATA\n"]).encode()


@pytest.fixture(scope="session")
def small_profile() -> Callable[[str], bytes]:
    """Return a function from a name to one of the CC0 profiles of the tests."""
    return lambda name: (ROOT / "tests" / "data" / name).read_bytes()


@pytest.fixture(scope="session")
def made_profile() -> Callable[..., bytes]:
    """Return a function that puts an ICC profile together from its tags."""

    def make(
        tags: dict[str, bytes],
        *,
        space: str = "RGB ",
        pcs: str = "Lab ",
        kind: str = "prtr",
        version: int = 4,
    ) -> bytes:
        offset = 132 + 12 * len(tags)
        table, body = b"", b""
        for tag, data in tags.items():
            table += struct.pack(">4sII", tag.encode("latin-1"), offset + len(body), len(data))
            body += data + bytes(-len(data) % 4)
        header = bytearray(128)
        header[0:4] = struct.pack(">I", offset + len(body))
        header[8] = version
        header[12:24] = (kind + space + pcs).encode("latin-1")
        header[36:40] = b"acsp"
        return bytes(header) + struct.pack(">I", len(tags)) + table + body

    return make


@pytest.fixture(scope="session")
def assert_every_invariant() -> Callable[[TriangleMesh, ArrayLike, int], None]:
    """Return a check of all invariants of a level after rounding to float32."""

    def check(mesh: TriangleMesh, centre: ArrayLike, triangles: int) -> None:
        assert mesh.vertices.dtype == np.float32
        assert mesh.triangles == triangles == 2 * len(mesh.vertices) - 4
        validity = mesh.validity(centre)
        assert validity.is_gamut, (triangles, validity)

    return check


UNION_TRIANGLES = 50_000
"""Levels are checked together up to this size: a small mesh costs more calls than arithmetic."""


@pytest.fixture(scope="session")
def assert_every_level(
    assert_every_invariant: Callable[[TriangleMesh, ArrayLike, int], None],
) -> Callable[[Iterable[TriangleMesh], ArrayLike], list[int]]:
    """Return a check of all invariants of many levels, which returns their triangle counts.

    Levels side by side are one mesh. It is closed and manifold, has no faulty face and sees the
    centre if and only if each level does. A closed level in one piece has genus 0 if it has
    2 V - 4 triangles. If anything fails, the levels are checked one by one, to name the level.
    """

    def check_union(meshes: list[TriangleMesh], centre: ArrayLike) -> bool:
        sizes = np.array([len(mesh.vertices) for mesh in meshes])
        begins = np.cumsum(sizes) - sizes
        faces = [mesh.faces + begin for mesh, begin in zip(meshes, begins, strict=True)]
        union = TriangleMesh(np.vstack([mesh.vertices for mesh in meshes]), np.vstack(faces))
        found = union.validity(centre)
        edges = union.faces[:, [0, 1, 1, 2]].reshape(-1, 2).T
        pieces, _ = connected_components(edges[0], edges[1], len(union.vertices))
        return (
            pieces == len(meshes)
            and all(mesh.triangles == 2 * len(mesh.vertices) - 4 for mesh in meshes)
            and all(mesh.vertices.dtype == np.float32 for mesh in meshes)
            and (found.finite and found.closed and found.manifold and found.star_shaped)
            and found.degenerate_faces == found.duplicate_faces == 0
        )

    def check_all(meshes: list[TriangleMesh], centre: ArrayLike) -> None:
        if not check_union(meshes, centre):
            for mesh in meshes:
                assert_every_invariant(mesh, centre, mesh.triangles)
            raise AssertionError("the levels are valid one by one, but not side by side")

    def check(levels: Iterable[TriangleMesh], centre: ArrayLike) -> list[int]:
        counts: list[int] = []
        waiting: list[TriangleMesh] = []
        for level in levels:
            counts.append(level.triangles)
            waiting.append(level)
            if sum(mesh.triangles for mesh in waiting) > UNION_TRIANGLES:
                check_all(waiting, centre)
                waiting = []
        if waiting:
            check_all(waiting, centre)
        return counts

    return check


@pytest.fixture(scope="session")
def icosphere() -> Callable[..., TriangleMesh]:
    """Return a function that makes a sphere of 20 · 4ⁿ triangles whose vertices lie on it."""

    def make(
        subdivisions: int, radius: float = 1.0, centre: ArrayLike = (0.0, 0.0, 0.0)
    ) -> TriangleMesh:
        sphere = trimesh.creation.icosphere(subdivisions, radius)
        vertices = np.asarray(sphere.vertices) + np.asarray(centre, np.float64)
        return TriangleMesh(vertices.astype(np.float32), np.asarray(sphere.faces, np.int32))

    return make


@pytest.fixture(scope="session")
def random_cloud() -> Callable[..., np.ndarray]:
    """Return a function from a seed to points on a bumpy surface about (50, 0, 0), as a gamut's."""

    def make(seed: int, count: int = 200) -> np.ndarray:
        random = np.random.default_rng(seed)
        directions = random.normal(size=(count, 3))
        directions /= np.linalg.norm(directions, axis=1)[:, np.newaxis]
        return directions * random.uniform(30.0, 60.0, (count, 1)) + (50.0, 0.0, 0.0)

    return make


@pytest.fixture(scope="session")
def small_history(random_cloud: Callable[..., np.ndarray]) -> History:
    """Return the history of a bumpy surface, small enough to look at each of its levels."""
    boundary = modified_convex_hull(random_cloud(1))
    return build_history(decimate(boundary.mesh, boundary.centre))


@pytest.fixture(scope="session")
def small_gamut() -> Gamut:
    """Return a gamut that was built from bare colours: a grid on a deformed sphere."""
    hue, polar = np.meshgrid(np.arange(0, 360, 15), np.arange(15, 180, 15))
    chroma = 40 * np.sin(np.radians(polar)) * (1 + 0.3 * np.cos(np.radians(3 * hue)))
    lab = [50 + 45 * np.cos(np.radians(polar))]
    lab += [chroma * np.cos(np.radians(hue)), chroma * np.sin(np.radians(hue))]
    rows = "".join("{:.4f},{:.4f},{:.4f}\n".format(*row) for row in np.reshape(lab, (3, -1)).T)
    return Gamut(f"LAB_L,LAB_A,LAB_B\n{rows}".encode())


@pytest.fixture(scope="session")
def srgb_gamut() -> Gamut:
    """Return the reference gamut sRGB with fewer samples."""
    return Gamut(find_reference("srgb").data, surface_samples=10_000)


@pytest.fixture(scope="session")
def screen() -> Callable[..., Gamut]:
    """Return a function from a name and options to a reference gamut of few samples, built once."""
    return functools.cache(
        lambda name, **options: reference(name, **{"surface_samples": 2000, **options})
    )


@pytest.fixture(scope="session")
def press_gamut(fogra39: bytes) -> Gamut:
    """Return the gamut of FOGRA39L with fewer samples and the limit of its printers, 300 %."""
    return Gamut(fogra39, surface_samples=5000, ink_limit=300)


LARGE_SAMPLES = 40_000
"""Samples of the large gamuts of FOGRA39L, which have 58,000 triangles."""


@pytest.fixture(scope="session")
def fogra39_gamut(fogra39: bytes) -> Gamut:
    """Return a large gamut of FOGRA39L; other options are the defaults."""
    return Gamut(fogra39, surface_samples=LARGE_SAMPLES)


@pytest.fixture(scope="session")
def fogra39_points(fogra39: bytes) -> np.ndarray:
    """Return the surface colours of the large gamut of FOGRA39L."""
    return surface_colours(read_characterisation(fogra39), surface_samples=LARGE_SAMPLES).points


@pytest.fixture(scope="session")
def fogra39_boundary(fogra39: bytes) -> Boundary:
    """Return the full boundary of the large gamut of FOGRA39L."""
    colours = surface_colours(read_characterisation(fogra39), surface_samples=LARGE_SAMPLES)
    options = Options()
    wrapping = wrap_colours(
        colours.points,
        colours.faces,
        options.boundary,
        options.centre,
        options.boundary_parameters,
    )
    return wrapping.boundary


@pytest.fixture(scope="session")
def fogra39_finest(fogra39_boundary: Boundary) -> History:
    """Return the history of FOGRA39L whose vertices are moved."""
    return build_history(decimate(fogra39_boundary.mesh, fogra39_boundary.centre, "finest"))


@pytest.fixture(scope="session")
def fogra39_quadric(fogra39_boundary: Boundary) -> History:
    """Return the history of FOGRA39L by the published cost."""
    return build_history(decimate(fogra39_boundary.mesh, fogra39_boundary.centre, "quadric"))


@pytest.fixture(scope="session")
def displayed() -> Callable[..., np.ndarray]:
    """Return a function from CIELAB to what a display shows: clipped sRGB, encoded or linear.

    Everything in it is colour-science's: the decoding of CIELAB, Bradford's adaptation to D65, and
    the matrix from the chromaticities of the primaries (its stored one has four digits).
    """
    colour = colour_science()
    white = colour.XYZ_to_xy(ICC_D50)
    space = colour.RGB_COLOURSPACES["sRGB"].copy()
    space.use_derived_matrix_XYZ_to_RGB = True

    def convert(lab: ArrayLike, *, encoded: bool) -> np.ndarray:
        xyz = colour.Lab_to_XYZ(np.asarray(lab, np.float64), white)
        linear = np.clip(colour.XYZ_to_RGB(xyz, space, white, "Bradford"), 0.0, 1.0)
        return np.asarray(space.cctf_encoding(linear) if encoded else linear)

    return convert


COMPONENTS = {5121: "<u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


@pytest.fixture(scope="session")
def gltf_accessor() -> Callable[[pygltflib.GLTF2, int], np.ndarray]:
    """Return a function that decodes an accessor of a glTF asset, as ISO/IEC 12113 lays it out."""

    def decode(asset: pygltflib.GLTF2, number: int) -> np.ndarray:
        accessor = asset.accessors[number]
        view = asset.bufferViews[accessor.bufferView]
        buffer = asset.buffers[view.buffer]
        data = (
            asset.get_data_from_buffer_uri(buffer.uri) if buffer.uri else asset.binary_blob()
        )  # fmt: skip
        kind, width = np.dtype(COMPONENTS[accessor.componentType]), WIDTHS[accessor.type]
        start = (view.byteOffset or 0) + (accessor.byteOffset or 0)
        assert view.byteStride in {None, kind.itemsize * width}
        values = np.frombuffer(data, kind, accessor.count * width, start)
        return values.reshape(-1, width) if width > 1 else values

    return decode


@pytest.fixture(scope="session")
def mesh_readers(gltf_accessor: Callable[..., np.ndarray]) -> dict[tuple[str, str], Callable]:
    """Return functions from bytes to a mesh, by format and by the library that reads them."""

    def by_trimesh(kind: str) -> Callable[[bytes], TriangleMesh]:
        def read(data: bytes) -> TriangleMesh:
            loaded = trimesh.load(io.BytesIO(data), kind, process=False)
            if isinstance(loaded, trimesh.Scene):
                (loaded,) = loaded.geometry.values()
            return TriangleMesh(np.asarray(loaded.vertices), np.asarray(loaded.faces))

        return read

    def by_pygltflib(data: bytes) -> TriangleMesh:
        import pygltflib  # of the extra test-all

        asset = pygltflib.GLTF2.load_from_bytes(data)
        (primitive,) = asset.meshes[0].primitives
        positions = gltf_accessor(asset, primitive.attributes.POSITION)
        faces = gltf_accessor(asset, primitive.indices).reshape(-1, 3)
        return TriangleMesh(positions, faces)

    def by_meshio(data: bytes) -> TriangleMesh:
        read = meshio.read(io.BytesIO(data), "ply")
        return TriangleMesh(read.points, read.cells_dict["triangle"])

    return {
        ("glb", "trimesh"): by_trimesh("glb"),
        ("glb", "pygltflib"): by_pygltflib,
        ("ply", "trimesh"): by_trimesh("ply"),
        ("ply", "meshio"): by_meshio,
    }
