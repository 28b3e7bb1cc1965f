"""The provenance of mesh files, and levels that are read back with it."""

import copy
import functools
import hashlib
import json
from dataclasses import replace

import numpy as np
import pytest

from gamutcore import Gamut, Options
from gamutcore.colours.spaces import SPACES
from gamutcore.errors import OptionError
from gamutcore.export import mesh_file
from gamutcore.export.provenance import mesh_provenance


def test_glb_and_ply_carry_centre_white_input_and_algorithm(random_cloud):
    white = [95.047, 100.0, 108.883]
    source = json.dumps({"samples": random_cloud(70).tolist(), "white": white}).encode()
    gamut = Gamut(source)
    provenance = mesh_provenance(gamut.description)
    stated = gamut.description["provenance"]
    expected = {
        "centre": " ".join(map(repr, gamut.description["centre"])),
        "white": " ".join(map(repr, stated["white"])),
        "input_sha256": hashlib.sha256(source).hexdigest(),
        "algorithm_version": str(stated["algorithm"]["version"]),
    }
    level = gamut.history.level(10)
    glb = mesh_file(level, "glb", provenance)
    length = int.from_bytes(glb[12:16], "little")
    assert expected.items() <= json.loads(glb[20 : 20 + length])["asset"]["extras"].items()
    header = mesh_file(level, "ply", provenance).partition(b"end_header")[0].decode()
    for name, value in expected.items():
        assert any(
            line.startswith("comment") and name in line and value in line
            for line in header.splitlines()
        ), name


DEVICE = b"RGB_R,RGB_G,RGB_B,LAB_L,LAB_A,LAB_B\n" + b"\n".join(
    b"%d,%d,%d,%d,%d,%d" % (r * 255, g * 255, b * 255, *lab)
    for (r, g, b), lab in zip(
        np.ndindex(2, 2, 2),
        [
            (9, 0, 0),
            (32, 68, -90),
            (87, -70, 70),
            (90, -50, -15),
            (54, 70, 60),
            (60, 90, -55),
            (97, -15, 85),
            (100, 0, 0),
        ],
        strict=True,
    )
)

SPACE_OPTIONS = [
    *({"space": space} for space in SPACES),
    {"reference_white": "D65"},
    {"reference_white": [0.95, 1, 1.1], "adaptation": "CAT16"},
    {"adaptation": "none"},
    {"space": "CIEXYZ", "reference_white": "D65"},
    {"space": "ITP", "luminance": 100.5},
    {"space": "CAM16-UCS", "surround": "dim", "background": 18.4, "adapting_luminance": 1 / 3},
]


@functools.cache
def device_gamut(options):
    return Gamut(DEVICE, options)


def posted_back(options, format_name, asked):
    gamut = device_gamut(Options.from_mapping({"surface_samples": 500, **options}))
    level = gamut.level(60)
    provenance = mesh_provenance(gamut.description)
    data = mesh_file(level, format_name, provenance, gamut.colour_space)
    return gamut, level, Gamut(data, Options.from_mapping(asked))


def recipes(mesh):
    """Each vertex with its device values, as files have them."""
    rows = zip(mesh.vertices.tolist(), mesh.device.values.astype(np.float32).tolist(), strict=True)
    return mesh.device.channels, sorted(rows)


@pytest.mark.parametrize("options", SPACE_OPTIONS, ids=str)
@pytest.mark.parametrize("format_name", ["ply", "glb", "3mf"])
@pytest.mark.slow
def test_a_level_is_read_back_in_its_own_space(options, format_name):
    gamut, level, again = posted_back(options, format_name, options)
    assert again.history.full().volume == pytest.approx(level.volume, rel=1e-12)
    assert again.description["centre"] == gamut.description["centre"]
    assert again.colour_space == gamut.colour_space
    before = copy.deepcopy(gamut.description["provenance"])
    after = again.description["provenance"]
    assert after["colour_space"].pop("from") == "the file"
    before["colour_space"]["adaptation"] = after["colour_space"]["adaptation"]
    assert after["colour_space"] == before["colour_space"]
    for name in ("axes", "space", "white", "illuminant", "observer"):
        assert after[name] == before[name]
    if format_name != "3mf":  # has no place for device values
        assert after["channels"] == before["channels"]
        assert recipes(again.level(60)) == recipes(level)


@pytest.mark.parametrize(
    ("options", "asked", "field"),
    [
        ({"space": "Oklab"}, {}, "space"),
        ({}, {"space": "Oklab"}, "space"),
        ({"reference_white": "D65"}, {}, "reference_white"),
        ({"reference_white": [0.95, 1.0, 1.1]}, {"reference_white": "D65"}, "reference_white"),
        (
            {"reference_white": "D65", "adaptation": "none"},
            {"reference_white": "D65"},
            "adaptation",
        ),
        ({"space": "ICtCp"}, {"space": "ICtCp", "luminance": 100}, "luminance"),
        ({"space": "CAM16-UCS", "surround": "dark"}, {"space": "CAM16-UCS"}, "surround"),
    ],
    ids=str,
)
@pytest.mark.slow
def test_a_level_in_another_space_than_is_asked_for_is_refused(options, asked, field):
    with pytest.raises(OptionError) as caught:
        posted_back(options, "ply", asked)
    assert caught.value.where == {"field": field}
    stated = options.get(field)
    assert str(stated) in caught.value.remedy or field in {"space", "luminance"}


def test_a_mesh_that_states_nothing_and_is_too_small_for_cielab_has_a_warning():
    _, _, again = posted_back({"space": "Oklab"}, "stl", {})
    (warning,) = again.description["provenance"]["warnings"]
    assert "option space" in warning


@pytest.mark.parametrize("format_name", ["ply", "glb", "gltf"])
@pytest.mark.slow
def test_inks_of_any_name_are_read_back(format_name):
    mesh = Gamut(DEVICE, surface_samples=2000).level(60)
    channels = ("Größe", "end of header", "黒")
    named = replace(mesh, device=replace(mesh.device, channels=channels))
    again = Gamut(mesh_file(named, format_name, {"observer": "2°"}))
    assert recipes(again.level(60)) == recipes(named)
    provenance = again.description["provenance"]
    assert provenance["observer"] == "2°"
    assert provenance["channels"] == list(channels)
    assert not [name for name in provenance["stated"] if name.lower().startswith("device")]
