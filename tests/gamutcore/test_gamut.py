"""The gamut: its identity, its description, its file, and the errors of a build."""

import hashlib
import io
import json
import struct
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

import gamutcore.gamut
from gamutcore.characterisation import characterisation
from gamutcore.errors import (
    CentreError,
    CharacterisationError,
    FlatPointsError,
    GamutError,
    HistoryFileError,
    MeshError,
    OptionError,
    TooFewPointsError,
    UnrecognisedFormatError,
)
from gamutcore.export import FORMATS, encoded_mesh
from gamutcore.gamut import STAGES, Gamut, Options, build_gamut, gamut_id, read_description
from gamutcore.history import history_bytes
from gamutcore.metric import mismatch

COLORD = Path("/usr/share/color/icc/colord")
ARGYLL = Path("/usr/share/color/argyll/ref")

# Bruce Lindbloom's table of RGB working spaces: Lab D50, 2°, Bradford (reference/figures.md).
WORKING_SPACES = {
    COLORD / "sRGB.icc": 832_870,
    COLORD / "AdobeRGB1998.icc": 1_208_631,
    COLORD / "AppleRGB.icc": 798_403,
    COLORD / "BetaRGB.icc": 1_717_450,
    COLORD / "ColorMatchRGB.icc": 836_975,
    COLORD / "NTSC-RGB.icc": 1_300_252,
    COLORD / "ProPhotoRGB.icc": 2_879_568,
    COLORD / "WideGamutRGB.icc": 2_164_221,
    ARGYLL / "sRGB.icm": 832_870,
    ARGYLL / "ClayRGB1998.icm": 1_208_631,
    ARGYLL / "ProPhoto.icm": 2_879_568,
}

DIGEST = hashlib.sha256(b"data").hexdigest()


def bare(rows):
    text = "\n".join(",".join(map(repr, row)) for row in np.asarray(rows, float).tolist())
    return f"LAB_L,LAB_A,LAB_B\n{text}\n".encode()


OCTAHEDRON = [(90, 0, 0), (10, 0, 0), (50, 40, 0), (50, -40, 0), (50, 0, 40), (50, 0, -40)]


class TestId:
    def test_is_a_sha256_of_what_it_says(self):
        question = f"gamut 4\n{Options().canonical}\n{DIGEST}\n"
        assert gamutcore.gamut.ALGORITHM_VERSION == 4
        assert gamut_id(Options(), DIGEST) == hashlib.sha256(question.encode()).hexdigest()

    def test_is_the_same_for_the_same_question(self):
        spelled_out = Options.from_mapping(json.loads(Options().canonical))
        assert gamut_id(spelled_out, DIGEST) == gamut_id(Options(), DIGEST)

    @pytest.mark.parametrize(
        "change",
        [
            {"gamma": 0.3},
            {"boundary": "convex-hull"},
            {"boundary": "segment-maxima"},
            {"boundary": "segment-maxima", "segments": (16, 17)},
            {"boundary": "usv"},
            {"boundary": "usv", "basis": "octahedron"},
            {"boundary": "usv", "subdivisions": 3},
            {"boundary": "usv", "gamma": 0.1},
            {"centre": (50, 0, 0)},
            {"cost": "quadric"},
            {"surface_samples": 99_999},
            {"intent": "absolute"},
            {"source": "measurements"},
            {"ink_limit": 300},
            {"black_limit": 90},
        ],
    )
    def test_differs_with_every_option(self, change):
        assert gamut_id(Options(**change), DIGEST) != gamut_id(Options(), DIGEST)

    def test_differs_with_the_input_and_the_algorithm(self, monkeypatch):
        before = gamut_id(Options(), DIGEST)
        assert gamut_id(Options(), hashlib.sha256(b"date").hexdigest()) != before
        monkeypatch.setattr(gamutcore.gamut, "ALGORITHM_VERSION", 5)
        assert gamut_id(Options(), DIGEST) != before


class TestDescription:
    def test_is_json_and_comes_back_from_it(self, fogra39_gamut):
        text = json.dumps(fogra39_gamut.description, allow_nan=False)
        assert json.loads(text) == fogra39_gamut.description

    def test_says_what_went_in(self, fogra39_gamut, fogra39):
        description = fogra39_gamut.description
        digest = hashlib.sha256(fogra39).hexdigest()
        assert description["id"] == fogra39_gamut.id == gamut_id(Options(), digest)
        assert description["options"] == Options().to_mapping()
        assert fogra39_gamut.options == Options()
        assert description["provenance"]["input"] == {"sha256": digest, "bytes": len(fogra39)}

    @pytest.mark.parametrize(
        "options",
        [
            {"boundary": "convex-hull"},
            {"boundary": "segment-maxima", "segments": [12, 18]},
            {"boundary": "usv", "basis": "tetrahedron", "subdivisions": 4},
        ],
    )
    def test_of_every_boundary(self, fogra39, options):
        """Counts by the methods' own definitions, and levels that keep the volume."""
        given = Options.from_mapping({**options, "surface_samples": 20_000})
        gamut = build_gamut(fogra39, given)
        description = json.loads(json.dumps(gamut.description, allow_nan=False))
        assert options.items() <= description["options"].items()
        assert Gamut.from_bytes(gamut.to_bytes()).options == given
        if given.boundary == "segment-maxima":
            assert description["counts"]["triangles"] == 2 * 12 * 18
            assert description["counts"]["constructed"] >= 2  # the poles
        else:
            assert description["counts"]["constructed"] == 0
        if given.boundary == "usv":
            assert 0.9 < description["counts"]["triangles"] / (2 * 4 * 4**4 - 4) <= 1
        full = gamut.history.full()
        level = gamut.history.level(100)
        assert level.validity(gamut.history.centre).is_gamut
        assert level.volume == pytest.approx(full.volume, rel=1e-4)

    def test_agrees_with_its_history(self, fogra39_gamut):
        description, history = fogra39_gamut.description, fogra39_gamut.history
        full = history.full()
        assert description["counts"] == {
            "triangles": history.triangles,
            "vertices": history.vertices,
            "minimum": 4,
            "constructed": 0,
        }
        assert history.triangles == 2 * history.vertices - 4
        assert description["volume"] == pytest.approx(full.volume, rel=1e-9)
        assert description["area"] == pytest.approx(full.area, rel=1e-9)
        np.testing.assert_array_equal(description["bounds"], full.bounds)
        np.testing.assert_array_equal(description["centre"], history.centre)
        levels = description["levels"]
        assert levels[0]["triangles"] == 4
        assert levels[-1]["triangles"] == history.triangles
        for level in levels:
            read = history.level(level["triangles"])
            assert level["volume"] == pytest.approx(read.volume, rel=1e-9)

    def test_of_a_press_in_terms_that_its_printer_knows(self, fogra39_gamut):
        """FOGRA39: paper white L* 95 (ISO 12647-2:2004), black below 20, a volume about 400,000."""
        (darkest, *_), (lightest, *_) = fogra39_gamut.description["bounds"]
        assert 0 <= darkest < 20
        # relative to the medium: the paper is the white
        assert lightest == pytest.approx(100, abs=0.5)
        assert 350_000 < fogra39_gamut.description["volume"] < 500_000

    def test_memory_is_the_historys(self, fogra39_gamut):
        assert fogra39_gamut.nbytes == fogra39_gamut.history.nbytes > 0


class TestFile:
    def test_round_trip(self, fogra39_gamut):
        read = Gamut.from_bytes(fogra39_gamut.to_bytes())
        assert read.description == fogra39_gamut.description
        assert (read.id, read.options) == (fogra39_gamut.id, fogra39_gamut.options)
        for triangles in (4, 100, 5001, read.history.triangles):
            assert read.history.level(triangles) == fogra39_gamut.history.level(triangles)
        assert read.to_bytes() == fogra39_gamut.to_bytes()

    def test_the_description_alone(self, small_gamut, tmp_path):
        path = tmp_path / "gamut"
        path.write_bytes(small_gamut.to_bytes())
        assert read_description(path) == small_gamut.description

    def test_the_description_is_read_without_the_arrays(self, small_gamut, tmp_path):
        path = tmp_path / "gamut"
        data = small_gamut.to_bytes()
        path.write_bytes(data[: 8 + int.from_bytes(data[:8], "little")])
        assert read_description(path) == small_gamut.description

    @pytest.mark.parametrize(
        "metadata",
        [
            {},
            {"gamut": ""},
            {"gamut": "null"},
            {"gamut": "[]"},
            {"gamut": "{}"},
            {"gamut": '{"id": 5, "options": {}}'},
            {"gamut": '{"id": "00"}'},
            {"gamut": '{"id": "00", "options": null}'},
            {"gamut": '{"id": "00", "options": []}'},
            {"gamut": '{"id": "00", "options": {"gamma": 7}}'},
            {"gamut": '{"id": "00", "options": {"5": 7}}'},
            {"gamut": "[" * 100_000},
        ],
    )
    def test_a_history_that_describes_no_gamut_is_refused(self, small_history, metadata, tmp_path):
        data = history_bytes(small_history, metadata)
        with pytest.raises(HistoryFileError):
            Gamut.from_bytes(data)
        path = tmp_path / "gamut"
        path.write_bytes(data)
        with pytest.raises(HistoryFileError):
            read_description(path)

    @settings(max_examples=150)
    @given(place=st.floats(0, 1, exclude_max=True), flip=st.integers(1, 255))
    def test_a_changed_byte_of_the_header_is_refused_or_read(self, small_gamut, place, flip):
        data = bytearray(small_gamut.to_bytes())
        data[int(place * (8 + int.from_bytes(data[:8], "little")))] ^= flip
        outcome = attempt(lambda: Gamut.from_bytes(bytes(data)))
        if isinstance(outcome, Gamut):
            assert outcome.history.full() == small_gamut.history.full()
        else:
            assert isinstance(outcome, HistoryFileError)


def attempt(action):
    try:
        return action()
    except GamutError as error:
        return error


class TestBuild:
    def test_reports_its_stages_in_order(self):
        stages = []
        build_gamut(bare(OCTAHEDRON), Options(), progress=lambda *stage: stages.append(stage))
        assert stages == [(stage, 0.0) for stage in STAGES]

    def test_of_a_body_with_a_known_volume(self, assert_every_invariant):
        gamut = build_gamut(bare(OCTAHEDRON), Options())
        assert gamut.description["counts"]["triangles"] == 8
        assert gamut.description["volume"] == pytest.approx(4 / 3 * 40**3)
        assert gamut.description["area"] == pytest.approx(2 * np.sqrt(3) * (40 * np.sqrt(2)) ** 2)
        for level in gamut.history.levels():
            assert_every_invariant(level, gamut.description["centre"], level.triangles)

    def test_reruns_are_byte_identical(self, fogra39_gamut, fogra39):
        assert build_gamut(fogra39, Options()).to_bytes() == fogra39_gamut.to_bytes()

    def test_options_reach_their_stations(self, small_gamut, random_cloud):
        data = bare(random_cloud(70))
        default = build_gamut(data, Options())
        hull = build_gamut(data, Options(boundary="convex-hull"))
        assert hull.description["volume"] > default.description["volume"]
        centred = build_gamut(data, Options(centre=(52, 1, -2)))
        assert centred.description["centre"] == [52, 1, -2]
        published = build_gamut(data, Options(cost="quadric"))
        assert mismatch(published.history.full(), default.history.full()) < 1e-9
        assert published.history.level(50) != default.history.level(50)
        assert len({g.id for g in (small_gamut, default, hull, centred, published)}) == 5

    @pytest.mark.parametrize("form", ["samples", "picture", "profile"])
    def test_a_gray_device_has_no_volume_and_is_told_why(self, form, made_profile):
        stream = io.BytesIO()
        Image.fromarray(np.arange(256, dtype=np.uint8).reshape(16, 16)).save(stream, "PNG")
        ramp = [[v, 0.9 * v, v, 0.8 * v] for v in range(0, 101, 5)]
        columns = ["GRAY", "XYZ_X", "XYZ_Y", "XYZ_Z"]
        table = json.dumps({"columns": columns, "samples": ramp}).encode()
        curve = b"curv" + bytes(4) + struct.pack(">IH", 1, 0x0200)  # a gamma of 2
        data = {
            "samples": table,
            "picture": stream.getvalue(),
            "profile": made_profile({"kTRC": curve}, space="GRAY"),
        }
        with pytest.raises(FlatPointsError, match="one channel") as caught:
            build_gamut(data[form], Options())
        assert caught.value.where == {"field": "channels"}
        assert "RGB" in caught.value.remedy

    @pytest.mark.parametrize(
        ("data", "options", "kind"),
        [
            (b"", {}, CharacterisationError),
            (b"\x00\x01\x02", {}, UnrecognisedFormatError),
            (b"hello world", {}, CharacterisationError),
            (bare(OCTAHEDRON[:3]), {}, GamutError),
            (bare([(50, 0, 0)] * 20), {}, TooFewPointsError),
            (bare([(50, i, 0) for i in range(20)]), {}, FlatPointsError),
            (bare([(50, i % 5, i // 5) for i in range(20)]), {}, FlatPointsError),
            (bare(OCTAHEDRON), {"centre": (95, 0, 0)}, CentreError),
            (bare(OCTAHEDRON), {"centre": (75, 30, 30)}, CentreError),
            (bare([*OCTAHEDRON, (50, 0, np.nan)]), {}, GamutError),
            (bare([*OCTAHEDRON, (50, 0, 1e30)]), {}, GamutError),
        ],
    )
    def test_what_cannot_be_built_is_a_named_error(self, data, options, kind):
        with pytest.raises(kind) as caught:
            build_gamut(data, Options(**options))
        assert caught.value.message
        assert caught.value.remedy or caught.value.where

    @settings(max_examples=60)
    @given(
        rows=st.lists(
            st.tuples(
                *[st.sampled_from([0.0, 1.0, 50.0, 100.0, -40.0, 1e-9, 1e9, 33.3, -1e5])] * 3
            ),
            max_size=12,
        )
    )
    def test_any_colours_are_a_gamut_or_a_named_error(self, assert_every_invariant, rows):
        outcome = attempt(lambda: build_gamut(bare(rows), Options()))
        if isinstance(outcome, Gamut):
            for level in outcome.history.levels():
                assert_every_invariant(level, outcome.history.centre, level.triangles)
        else:
            assert outcome.remedy


@pytest.mark.parametrize("path", WORKING_SPACES, ids=lambda path: path.name)
def test_the_volume_of_an_rgb_working_space(path):
    if not path.is_file():
        pytest.skip(f"{path.name} is not there: Debian's packages colord-data and argyll have it")
    # The default of 0.2 bridges the concave places of wide spaces (ProPhoto: +0.7 %); 0.05 follows.
    gamut = build_gamut(path.read_bytes(), Options(gamma=0.05))
    assert gamut.description["volume"] == pytest.approx(WORKING_SPACES[path], rel=0.0015)


def test_a_press_profile_and_its_measurements_have_one_gamut(
    shared_data, fogra39, record_property, capsys
):
    # The profile is made of FOGRA39L, for an ink limit of 300 % (data/README.md).
    profile = (shared_data / "press" / "ISOcoated_v2_300_bas.icc").read_bytes()
    options = Options(intent="absolute", ink_limit=300)
    measured, characterised = build_gamut(fogra39, options), build_gamut(profile, options)
    found = mismatch(measured.history.full(), characterised.history.full())
    record_property("mismatch", found)
    with capsys.disabled():
        sys.stdout.write(f"ISOcoated_v2_300 against FOGRA39L, absolute: {100 * found:.3f} %\n")
    assert found <= 0.01


def cube_surface(step):
    """Return all colours of the six faces of the cube of 8-bit RGB, in steps, as rows of pixels."""
    levels = np.arange(0, 256, step, dtype=np.uint8)
    face = np.stack(np.meshgrid(levels, levels, indexing="ij"), axis=-1).reshape(-1, 2)
    faces = [np.insert(face, axis, end, axis=1) for axis in range(3) for end in (0, 255)]
    return np.concatenate(faces)


@pytest.mark.parametrize("name", ["DisplayP3-v4", "AdobeCompat-v2"])
@pytest.mark.parametrize("file_format", ["PNG", "TIFF"])
def test_a_picture_of_all_colours_has_the_gamut_of_its_profile(shared_data, name, file_format):
    profile = (shared_data / "spaces" / f"{name}.icc").read_bytes()
    pixels = cube_surface(3)
    file = io.BytesIO()
    Image.frombytes("RGB", (86, 516), pixels.tobytes()).save(file, file_format, icc_profile=profile)
    found = build_gamut(file.getvalue(), Options())
    characterised = build_gamut(profile, Options())
    assert mismatch(characterised.history.full(), found.history.full()) <= 0.001
    provenance = found.description["provenance"]
    assert provenance["size"] == [86, 516]
    assert provenance["profile"]["description"]


def test_vertices_of_a_picture_have_the_values_of_its_pixels():
    corners = np.array(np.meshgrid([0, 255], [0, 255], [0, 255]), np.uint8).reshape(3, -1).T
    file = io.BytesIO()
    Image.fromarray(corners[np.newaxis]).save(file, "PNG")
    mesh = build_gamut(file.getvalue(), Options()).history
    device = mesh.device_values(mesh.triangles)
    assert device.channels == ("R", "G", "B")
    lightest = mesh.level(mesh.triangles).vertices[:, 0].argmax()
    np.testing.assert_allclose(device.values[lightest], 1, atol=1e-3)
    blue = np.linalg.norm(device.values - (0, 0, 1), axis=1).argmin()
    np.testing.assert_allclose(device.values[blue], (0, 0, 1), atol=1e-3)
    # sRGB's blue, Lindbloom's calculator
    np.testing.assert_allclose(mesh.full().vertices[blue], (29.57, 68.30, -112.03), atol=0.06)


def test_surface_samples_are_refused_where_nothing_is_sampled():
    file = io.BytesIO()
    Image.fromarray(np.eye(4, 3, dtype=np.uint8)[np.newaxis] * 255).save(file, "PNG")
    colours = b"L,a,b\n" + b"".join(b"%d,%d,%d\n" % (i, i % 7, i % 5) for i in range(20))
    for data in (file.getvalue(), colours):
        with pytest.raises(OptionError) as caught:
            build_gamut(data, Options(surface_samples=2000))
        assert caught.value.where == {"field": "surface_samples"}
        assert "are all used" in caught.value.remedy


def test_the_least_used_colours_of_a_picture_can_be_left_out():
    dull = np.array([(r, g, b) for r in (60, 180) for g in (60, 180) for b in (60, 180)], np.uint8)
    speck = np.array([[255, 0, 0], [0, 0, 255]], np.uint8)
    pixels = np.concatenate([np.repeat(dull, 100, axis=0), speck])  # 2 pixels of 802
    file = io.BytesIO()
    Image.frombytes("RGB", (401, 2), pixels.tobytes()).save(file, "PNG")
    every, popular = (
        build_gamut(file.getvalue(), Options(popularity=share)) for share in (None, 0.01)
    )
    plain = io.BytesIO()
    Image.frombytes("RGB", (400, 2), pixels[:800].tobytes()).save(plain, "PNG")
    without = build_gamut(plain.getvalue(), Options())
    assert popular.description["volume"] == without.description["volume"]
    assert every.description["volume"] > 1.5 * without.description["volume"]
    assert every.id != popular.id
    with pytest.raises(OptionError):
        build_gamut(bare(OCTAHEDRON), Options(popularity=0.01))


@pytest.mark.parametrize(
    ("file", "tag"),
    [("press/ISOcoated_v2_300_bas.icc", "targ"), ("oracle/SWOP2013C3_CRPC5.icc", "CxF")],
)
def test_the_measurements_within_a_profile_have_its_gamut(shared_data, file, tag):
    profile = (shared_data / file).read_bytes()
    gamuts = [
        build_gamut(profile, Options(intent="absolute", surface_samples=20_000, **options))
        for options in ({}, {"source": "measurements"})
    ]
    assert mismatch(*[gamut.history.full() for gamut in gamuts]) <= 0.01
    provenance = gamuts[1].description["provenance"]
    assert provenance["embedded"]["tag"] == tag
    assert provenance["model"]["leave_out_error"]["percentile_95"] < 0.5


def test_an_ink_limit_takes_a_part_of_the_gamut_away(fogra39):
    volumes = [
        build_gamut(fogra39, Options(surface_samples=20_000, **options)).description["volume"]
        for options in ({"ink_limit": 150}, {"ink_limit": 240}, {"ink_limit": 320}, {})
    ]
    assert volumes == sorted(volumes)
    assert volumes[0] < 0.9 * volumes[3]
    # K = 0 alone loses 20 % of the volume (reference/characterisation.md, what users expect).
    without_black = build_gamut(fogra39, Options(surface_samples=20_000, black_limit=0))
    assert 0.75 < without_black.description["volume"] / volumes[3] < 0.85


def test_provenance_of_a_profile_says_all_that_went_in(shared_data):
    data = (shared_data / "oracle" / "Ref-ECG-CMYKOGV_FOGRA55_TAC300.icc").read_bytes()
    gamut = build_gamut(
        data, Options(ink_limit=300, black_limit=95, surface_samples=20_000, intent="absolute")
    )
    provenance = gamut.description["provenance"]
    assert provenance["device_class"] == "output"
    assert provenance["channels"][3:5] == ["Black", "Orange"]
    assert provenance["ink_limits"] == {"total": 300, "black": 95}
    assert provenance["model"] == {"name": "ICC profile", "tag": "A2B1", "kind": "lut16"}
    assert provenance["intent"] == "absolute"
    assert provenance["white"] == pytest.approx([0.8528, 0.8762, 0.7929], abs=1e-4)
    assert provenance["illuminant"] == "D50"
    assert provenance["adaptation"]
    assert provenance["warnings"] == []
    assert len(provenance["input"]["sha256"]) == 64
    assert characterisation(data).inks


class TestMesh:
    """A mesh is the boundary itself."""

    @pytest.mark.parametrize("name", FORMATS)
    @pytest.mark.parametrize("triangles", [4, 10, 500, 5000])
    def test_an_exported_level_is_the_full_boundary(self, fogra39_gamut, name, triangles):
        level = fogra39_gamut.history.level(triangles)
        centre = fogra39_gamut.description["centre"]
        provenance = {"centre": " ".join(map(repr, centre)), "space": "CIELAB"}
        gamut = build_gamut(encoded_mesh(level, name, provenance), Options())
        full = gamut.history.full()
        assert gamut.description["counts"]["triangles"] == triangles
        # sums in another order
        assert gamut.description["volume"] == pytest.approx(level.volume, rel=1e-12)
        # the same triangles, whatever their order
        assert triangle_set(full) == triangle_set(level)
        if name != "stl":  # has no place for a centre
            assert gamut.description["centre"] == centre
        assert full.validity(gamut.description["centre"]).is_gamut

    def test_the_description_has_only_options_that_apply(self, fogra39_gamut):
        data = encoded_mesh(fogra39_gamut.history.level(100), "ply")
        gamut = build_gamut(data, Options(cost="quadric"))
        assert gamut.description["options"] == {
            "space": "CIELAB",
            "centre": "auto",
            "cost": "quadric",
        }
        # they ask the same question again
        assert gamut.options == Options(cost="quadric")
        assert Gamut.from_bytes(gamut.to_bytes()).description == gamut.description
        provenance = gamut.description["provenance"]
        assert provenance["format"] == "ply"
        assert provenance["mesh"]["triangles_read"] == 100

    @pytest.mark.parametrize(
        "options",
        [
            {"boundary": "usv"},
            {"boundary": "segment-maxima"},
            {"gamma": 0.3},
            {"surface_samples": 5000},
            {"intent": "absolute"},
            {"ink_limit": 300},
            {"black_limit": 90},
            {"observer": 10},
            {"illuminant": "D65"},
            {"condition": "M1"},
            {"source": "measurements"},
            {"source": "boundary"},
        ],
    )
    def test_options_of_colours_are_refused(self, fogra39_gamut, options):
        data = encoded_mesh(fogra39_gamut.history.level(100), "glb")
        with pytest.raises(OptionError) as caught:
            build_gamut(data, Options(**options))
        assert caught.value.where["field"] in options
        assert caught.value.remedy

    def test_the_centre_may_be_chosen(self, fogra39_gamut):
        data = encoded_mesh(fogra39_gamut.history.level(100), "stl")
        centre = fogra39_gamut.description["centre"]
        gamut = build_gamut(data, Options(centre=tuple(centre)))
        assert gamut.description["centre"] == centre
        with pytest.raises(CentreError):
            build_gamut(data, Options(centre=(500, 0, 0)))

    def test_an_open_mesh_is_refused(self, fogra39_gamut):
        level = fogra39_gamut.history.level(100)
        data = encoded_mesh(type(level)(level.vertices, level.faces[1:]), "ply")
        with pytest.raises(MeshError, match="3 edges have one face only"):
            build_gamut(data, Options())


def triangle_set(mesh):
    """Each triangle by its corners' positions, from the least of them on."""
    corners = mesh.vertices[mesh.faces].tolist()
    turned = (face[face.index(min(face)) :] + face[: face.index(min(face))] for face in corners)
    return sorted(turned)


class TestColourSpace:
    def display(self, luminance="90.0 184.5 101.0"):
        """A display with the primaries of CIEXYZ itself, which states its luminance."""
        cube = np.array(list(np.ndindex(3, 3, 3))) / 2
        rows = np.concatenate([cube, cube @ np.diag([0.95, 1.0, 1.09])], axis=1)
        document = {
            "columns": ["R", "G", "B", "X", "Y", "Z"],
            "samples": rows.tolist(),
            "conditions": {"DEVICE_CLASS": "DISPLAY", "LUMINANCE_XYZ_CDM2": luminance},
        }
        return json.dumps(document).encode()

    def test_the_measured_luminance_is_used_and_kept(self):
        measured = Options(space="ICtCp", luminance="measured", surface_samples=1000)
        gamut = build_gamut(self.display(), measured)
        assert gamut.description["provenance"]["colour_space"]["luminance"] == 184.5
        assert gamut.colour_space.luminance == 184.5
        assert Gamut.from_bytes(gamut.to_bytes()).colour_space == gamut.colour_space
        stated = Options(space="ICtCp", luminance=184.5, surface_samples=1000)
        same = build_gamut(self.display(), stated)
        assert same.description["volume"] == gamut.description["volume"]
        assert same.id != gamut.id

    def test_what_is_not_stated_cannot_be_used(self):
        with pytest.raises(OptionError) as caught:
            build_gamut(self.display(""), Options(space="Jzazbz", luminance="measured"))
        assert caught.value.where == {"field": "luminance"}

    @pytest.mark.parametrize("space", ["CIEXYZ", "Oklab", "CAM16-UCS", "Jzazbz"])
    def test_the_whole_description_is_in_the_space(self, space):
        gamut = build_gamut(bare(OCTAHEDRON), Options(space=space, gamma=1.0))
        points, _ = gamut.colour_space.coordinates(np.array(OCTAHEDRON, float))
        step = gamut.description["grid_step"]
        lowest, highest = points.min(axis=0), points.max(axis=0)
        np.testing.assert_allclose(gamut.description["bounds"], [lowest, highest], atol=step)
        assert (lowest < gamut.description["centre"]).all()
        assert (gamut.description["centre"] < highest).all()
        assert gamut.description["provenance"]["space"] == space
        assert gamut.description["provenance"]["colour_space"]["name"] == space
