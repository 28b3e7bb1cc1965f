"""The colour space that mesh files declare."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.colours.spaces import SPACES, ColourSpace
from gamutcore.colours.spaces.declared import (
    assumption_warnings,
    declared_space,
    refuse_far_vertices,
    refuse_other_space,
)
from gamutcore.colours.spaces.parameters import SPACE_PARAMETERS
from gamutcore.errors import GamutError, InvalidPointsError, MeshError, OptionError


def test_nothing_is_stated_without_a_space():
    assert declared_space({"scale": "2", "luminance": "x"}) is None


@pytest.mark.parametrize("name", ["CIELAB", "cielab", " Lab ", "CIE  LAB"])
def test_cielab_has_several_names(name):
    space = declared_space({"space": name})
    assert space is not None
    assert space.is_icc_cielab


@pytest.mark.parametrize("name", SPACES)
def test_every_space_is_known_by_its_name_in_any_case(name):
    for written in (name, name.upper(), name.lower()):
        space = declared_space({"space": written})
        assert space is not None
        assert space.name == name
        refuse_other_space(space, ColourSpace(name))


@pytest.mark.parametrize("name", ["sRGB", "", "x" * 5000])
def test_other_spaces_are_refused(name):
    with pytest.raises(MeshError) as caught:
        declared_space({"space": name})
    assert caught.value.where == {"field": "space"}
    assert len(caught.value.message) < 200


@pytest.mark.parametrize(
    ("space", "field", "text"),
    [
        ("CIELAB", "scale", "0"),
        ("CIELAB", "scale", "nan"),
        ("CIELAB", "reference_white", "1 2"),
        ("CIELAB", "reference_white", "D5"),
        ("ICtCp", "luminance", "bright"),
        ("ICtCp", "luminance", "measured"),
        ("CAM16-UCS", "surround", "blue"),
    ],
)
def test_parameters_that_are_none_are_refused(space, field, text):
    with pytest.raises(MeshError) as caught:
        declared_space({"space": space, field: text})
    assert caught.value.where["field"] == field


def test_how_colours_were_found_is_no_parameter_of_the_space():
    said = "ICC media-relative: XYZ scaled by D50/white"
    space = declared_space({"space": "CIELAB", "adaptation": said, "luminance": "80"})
    assert space is not None
    assert space.is_icc_cielab


def test_a_measured_luminance_is_the_number_that_the_file_has():
    said = {"space": "ITP", "luminance": "measured", "white_luminance": "80.5"}
    space = declared_space(said)
    assert space is not None
    assert space.luminance == 80.5


def test_a_white_is_the_same_by_name_and_by_number():
    named = ColourSpace(reference_white="D65")
    x, y, z = named.white.tolist()
    refuse_other_space(named, ColourSpace(reference_white=(x, y, z)))
    with pytest.raises(OptionError, match="reference_white"):
        refuse_other_space(named, ColourSpace(reference_white=(x, y, z + 1e-6)))


def test_far_is_relative_to_the_scale():
    vertices = np.array([[0.0, 0, 0], [50, 1.5e4, 0]])
    refuse_far_vertices(vertices, ColourSpace(scale=2.0))
    with pytest.raises(InvalidPointsError, match="Vertex 1"):
        refuse_far_vertices(vertices, ColourSpace())


def test_what_is_small_for_cielab_is_told():
    small = np.array([[0.0, 0, 0], [1, 0.3, -0.2]])
    (warning,) = assumption_warnings(small, ColourSpace())
    assert "space" in warning
    assert not assumption_warnings(small, ColourSpace("Oklab"))
    assert not assumption_warnings(small, ColourSpace(scale=0.01))
    assert not assumption_warnings(small * 100, ColourSpace())


TEXTS = st.text(max_size=20) | st.floats().map(repr) | st.just("1 1 1")


@given(
    st.sampled_from(list(SPACES)), st.dictionaries(st.sampled_from(sorted(SPACE_PARAMETERS)), TEXTS)
)
def test_any_notes_are_read_or_refused(space, said):
    try:
        stated = declared_space({**said, "space": space})
    except GamutError:
        return
    assert stated is not None
    refuse_other_space(stated, stated)
