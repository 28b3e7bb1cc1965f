"""Formats for CIELAB relative to D50 refuse other spaces."""

import pytest

from gamutcore.colours.spaces import CIELAB, ColourSpace
from gamutcore.errors import OptionError
from gamutcore.export.icc_cielab import check_icc_cielab


def test_cielab_with_default_parameters_is_accepted():
    check_icc_cielab(CIELAB, "gam")


@pytest.mark.parametrize("name", ["Oklab", "CIELUV", "CIEXYZ"])
def test_other_spaces_are_refused_by_name(name):
    with pytest.raises(OptionError, match=name) as caught:
        check_icc_cielab(ColourSpace(name), "gam")
    assert caught.value.where == {"field": "format"}
    assert "CIELAB" in caught.value.remedy
