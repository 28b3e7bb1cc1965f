"""Texts in lines of ASCII."""

from hypothesis import given
from hypothesis import strategies as st

from gamutcore.export.plain_text import ascii_line


@given(st.text())
def test_any_text_is_one_quotable_line(text):
    line = ascii_line(text)
    assert line.isascii()
    assert '"' not in line
    assert line.split() == line.split(" ") or line == ""


@given(st.text("abc xyz", min_size=1))
def test_plain_words_stay(text):
    assert ascii_line(text).split() == text.split()
