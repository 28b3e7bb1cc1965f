"""The stages of a build: the identity, the description and the errors of a gamut."""

import hashlib
import io
import json
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

import gamutcore.building
from benchmarks.booleans import mismatch
from gamutcore import Gamut, Options
from gamutcore.building import STAGES, gamut_id
from gamutcore.errors import (
    CentreError,
    CharacterisationError,
    FlatPointsError,
    GamutError,
    OptionError,
    TooFewPointsError,
    UnrecognisedFormatError,
)

DIGEST = hashlib.sha256(b"data").hexdigest()


def bare(rows):
    text = "\n".join(",".join(map(repr, row)) for row in np.asarray(rows, float).tolist())
    return f"LAB_L,LAB_A,LAB_B\n{text}\n".encode()


OCTAHEDRON = [(90, 0, 0), (10, 0, 0), (50, 40, 0), (50, -40, 0), (50, 0, 40), (50, 0, -40)]


class TestId:
    def test_is_a_sha256_of_what_it_says(self):
        version = gamutcore.building.ALGORITHM_VERSION
        question = f"gamut {version}\n{Options().canonical}\n{DIGEST}\n"
        assert gamut_id(Options(), DIGEST) == hashlib.sha256(question.encode()).hexdigest()

    def test_differs_with_the_input_and_the_algorithm(self, monkeypatch):
        before = gamut_id(Options(), DIGEST)
        assert gamut_id(Options(), hashlib.sha256(b"date").hexdigest()) != before
        later = gamutcore.building.ALGORITHM_VERSION + 1
        monkeypatch.setattr(gamutcore.building, "ALGORITHM_VERSION", later)
        assert gamut_id(Options(), DIGEST) != before


class TestDescription:
    def test_says_what_went_in(self, fogra39_gamut, fogra39):
        description, options = fogra39_gamut.description, Options(surface_samples=40_000)
        digest = hashlib.sha256(fogra39).hexdigest()
        assert description["id"] == fogra39_gamut.id == gamut_id(options, digest)
        assert description["options"] == options.to_mapping()
        assert fogra39_gamut.options == options
        assert description["provenance"]["input"] == {"sha256": digest, "bytes": len(fogra39)}

    def test_agrees_with_its_history(self, fogra39_gamut):
        description, history = fogra39_gamut.description, fogra39_gamut.history
        full = history.full()
        assert description["counts"] == {
            "triangles": history.triangles,
            "vertices": history.vertices,
            "minimum": 4,
            "constructed": description["counts"]["constructed"],
        }
        # where faces of the cube cross: few, because nearly all of the surface is on single faces
        assert 0 < description["counts"]["constructed"] < 0.001 * history.vertices
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


def attempt(action):
    try:
        return action()
    except GamutError as error:
        return error


class TestBuild:
    def test_reports_its_stages_in_order(self):
        told = []
        Gamut(bare(OCTAHEDRON), Options(), progress=lambda *stage: told.append(stage))
        assert [stage for stage, fraction in told if fraction == 0.0] == list(STAGES)
        assert told == sorted(told, key=lambda one: (STAGES.index(one[0]), one[1]))
        assert told[-1] == (STAGES[-1], 1.0)

    def test_of_a_body_with_a_known_volume(self, assert_every_level):
        gamut = Gamut(bare(OCTAHEDRON))
        assert gamut.description["counts"]["triangles"] == 8
        assert gamut.description["volume"] == pytest.approx(4 / 3 * 40**3)
        assert gamut.description["area"] == pytest.approx(2 * np.sqrt(3) * (40 * np.sqrt(2)) ** 2)
        assert_every_level(gamut.history.levels(), gamut.description["centre"])

    @pytest.mark.slow
    def test_says_of_all_levels_whether_they_have_the_volume(self):
        """In thin bodies, levels that are not on the error curve may change the volume."""
        said = set()
        for thickness, seed in ((1.0, 0), (8e-3, 1), (6e-3, 6), (6e-3, 7), (5e-3, 18), (1e-3, 0)):
            points = np.random.default_rng(seed).normal(size=(120, 3))
            points *= (50, 50, 50 * thickness) / np.linalg.norm(points, axis=1)[:, np.newaxis]
            gamut = Gamut(bare(points + np.array([50.0, 0.0, 0.0])), Options())
            whole = gamut.history.full().volume
            lost = {
                level.triangles: abs(level.volume - whole) / whole
                for level in gamut.history.levels()
            }
            off = {count: part > 1e-5 for count, part in lost.items()}
            # watched where positions are rounded, which these volumes are summed from anew
            assert gamut.description["volume_error"] == pytest.approx(max(lost.values()), rel=0.01)
            in_curve = any(off[level["triangles"]] for level in gamut.description["levels"])
            assert gamut.description["volume_preserved"] is not any(off.values())
            said.add((gamut.description["volume_preserved"], in_curve))
        assert said == {(True, False), (False, False), (False, True)}

    @pytest.mark.parametrize("cost", ["quadric", "finest"])
    def test_says_which_costs_do_not_keep_the_volume(self, random_cloud, cost):
        gamut = Gamut(bare(random_cloud(70)), Options(cost=cost))
        assert gamut.description["volume_preserved"] is False
        assert "volume_error" not in gamut.description

    @pytest.mark.slow
    def test_reruns_are_byte_identical(self, fogra39_gamut, fogra39):
        again = Gamut(fogra39, fogra39_gamut.options)
        assert again.to_bytes() == fogra39_gamut.to_bytes()

    def test_options_reach_their_stations(self, small_gamut, random_cloud):
        data = bare(random_cloud(70))
        default = Gamut(data)
        hull = Gamut(data, gamma=1)
        assert hull.description["volume"] > default.description["volume"]
        centred = Gamut(data, centre=(52, 1, -2))
        assert centred.description["centre"] == [52, 1, -2]
        published = Gamut(data, cost="quadric")
        assert mismatch(published.history.full(), default.history.full()) < 1e-9
        assert published.history.level(50) != default.history.level(50)
        assert len({g.id for g in (small_gamut, default, hull, centred, published)}) == 5

    @pytest.mark.parametrize(
        ("data", "options"),
        [
            ("colours", {"device_model": "fit"}),
            ("colours", {"ink_limit": 300}),
            ("colours", {"surface_samples": 5000}),
            ("colours", {"popularity": 0.1}),
            ("profile", {"observer": 10}),
            ("profile", {"illuminant": "D65"}),
            ("profile", {"device_model": "fit"}),
            ("profile", {"popularity": 0.1}),
            ("picture", {"observer": 10}),
            ("picture", {"illuminant": "D65"}),
            ("picture", {"black_limit": 90}),
            ("picture", {"device_model": "fit"}),
            ("picture", {"surface_samples": 5000}),
            ("mesh", {"boundary": "usv"}),
            ("mesh", {"gamma": 0.3}),
            ("mesh", {"surface_samples": 5000}),
            ("mesh", {"intent": "absolute"}),
            ("mesh", {"device_model": "fit"}),
            ("mesh", {"ink_limit": 300}),
            ("mesh", {"observer": 10}),
            ("mesh", {"illuminant": "D65"}),
            ("mesh", {"condition": "M1"}),
            ("mesh", {"source": "measurements"}),
            ("mesh", {"source": "boundary"}),
        ],
    )
    def test_an_option_of_other_data_is_refused(self, data, options, small_profile, small_gamut):
        stream = io.BytesIO()
        Image.fromarray(np.zeros((8, 8, 3), np.uint8)).save(stream, "PNG")
        content = {
            "colours": bare(OCTAHEDRON),
            "profile": small_profile("sRGB-v4.icc"),
            "picture": stream.getvalue(),
            "mesh": small_gamut.mesh(40).to_bytes("glb"),
        }
        with pytest.raises(OptionError) as caught:
            Gamut(content[data], options)
        assert [caught.value.where["field"]] == list(options)
        assert caught.value.remedy

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
            Gamut(data[form])
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
            Gamut(data, **options)
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
    @pytest.mark.slow
    def test_any_colours_are_a_gamut_or_a_named_error(self, assert_every_level, rows):
        outcome = attempt(lambda: Gamut(bare(rows)))
        if isinstance(outcome, Gamut):
            assert_every_level(outcome.history.levels(), outcome.history.centre)
        else:
            assert outcome.remedy


class TestColourSpace:
    def display(self, luminance="90.0 184.5 101.0"):
        """A display with the primaries of CIEXYZ and a declared luminance."""
        cube = np.array(list(np.ndindex(3, 3, 3))) / 2
        rows = np.concatenate([cube, cube @ np.diag([0.95, 1.0, 1.09])], axis=1)
        document = {
            "columns": ["R", "G", "B", "X", "Y", "Z"],
            "samples": rows.tolist(),
            "conditions": {"DEVICE_CLASS": "DISPLAY", "LUMINANCE_XYZ_CDM2": luminance},
        }
        return json.dumps(document).encode()

    def test_the_measured_luminance_is_used_and_kept(self):
        measured = Options(space="ICtCp", luminance="measured", surface_samples=200)
        gamut = Gamut(self.display(), measured)
        assert gamut.description["provenance"]["colour_space"]["luminance"] == 184.5
        assert gamut.colour_space.luminance == 184.5
        assert Gamut.from_bytes(gamut.to_bytes()).colour_space == gamut.colour_space
        stated = Options(space="ICtCp", luminance=184.5, surface_samples=200)
        same = Gamut(self.display(), stated)
        assert same.description["volume"] == gamut.description["volume"]
        assert same.id != gamut.id

    def test_what_is_not_stated_cannot_be_used(self):
        with pytest.raises(OptionError) as caught:
            Gamut(self.display(""), space="Jzazbz", luminance="measured")
        assert caught.value.where == {"field": "luminance"}
