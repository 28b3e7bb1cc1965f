"""Names of device channels in mesh files."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.export.device_properties import property_names


@pytest.mark.parametrize(
    ("channels", "names"),
    [
        (("C", "M", "Y", "K"), ["device_C", "device_M", "device_Y", "device_K"]),
        (("Reflex Blue", "PANTONE 021 C"), ["device_Reflex_Blue", "device_PANTONE_021_C"]),
        (("1", "2"), ["device_1", "device_2"]),
        (("黒", "白"), ["device_1", "device_2"]),
        (("Gold!", "gold", "GOLD"), ["device_Gold", "device_gold_2", "device_GOLD_3"]),
        (("2", "2", "黒"), ["device_2", "device_2_2", "device_3"]),
        (("end_header", "End header 2"), ["device_endheader", "device_endheader_2"]),
        ((), []),
    ],
)
def test_say_what_the_channels_are_called(channels, names):
    assert list(property_names(channels)) == names


@given(st.lists(st.text(), max_size=20))
def test_are_distinct_plain_words(channels):
    names = property_names(tuple(channels))
    assert len({name.upper() for name in names}) == len(names) == len(channels)
    assert all(re.fullmatch("device_[A-Za-z0-9_]+", name) for name in names)
