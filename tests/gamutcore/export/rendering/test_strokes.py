"""Labels of axes as polylines."""

import numpy as np
import pytest

from gamutcore.colours.spaces import SPACES
from gamutcore.export.rendering.strokes import GLYPHS, HEIGHT, text_strokes


def test_all_axes_and_numbers_have_glyphs():
    labels = "".join(axis for space in SPACES.values() for axis in space.axes) + "0123456789-+."
    drawn = {character for character in labels if character.isascii()}
    assert drawn <= set(GLYPHS) | {"_"}


@pytest.mark.parametrize("text", ["L*", "-100", "0.5", "8"])
def test_texts_are_centred(text):
    ends = np.concatenate(text_strokes(text))
    assert np.abs(ends[:, 0]).max() <= 5.5 * len(text) / 2
    assert abs(ends[:, 1].max() + ends[:, 1].min()) <= HEIGHT


def test_characters_without_a_glyph_leave_a_gap():
    wide, narrow = text_strokes("1☃1"), text_strokes("11")
    assert len(wide) == len(narrow)
    assert np.ptp(np.concatenate(wide)[:, 0]) > np.ptp(np.concatenate(narrow)[:, 0])
