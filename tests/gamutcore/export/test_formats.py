"""The table of formats: names, suffixes, and refusals."""

import pytest

from gamutcore.errors import OptionError
from gamutcore.export import FORMATS, format_of_suffix, mesh_file


def test_suffixes_and_media_types_name_one_format():
    for attribute in ("suffix", "media_type"):
        assert len({getattr(each, attribute) for each in FORMATS.values()}) == len(FORMATS)
    for name, each in FORMATS.items():
        assert each.name == name
        assert format_of_suffix(each.suffix.upper()) is each


@pytest.mark.parametrize("suffix", ["", ".", "glb", ".stp"])
def test_unknown_suffixes_are_refused(suffix):
    with pytest.raises(OptionError, match="no mesh format") as caught:
        format_of_suffix(suffix)
    assert ".glb" in caught.value.remedy


def test_unknown_formats_are_refused(icosphere):
    with pytest.raises(OptionError, match="no mesh format") as caught:
        mesh_file(icosphere(1), "step")
    assert caught.value.where == {"field": "format"}
