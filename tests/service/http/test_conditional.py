import hashlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.http.conditional import byte_range, check_if_match, entity_tag, matches
from service.problems.problem import ProblemError

ETAG = '"abc"'


def test_the_tag_is_the_content_digest():
    assert entity_tag(b"content") == f'"{hashlib.sha256(b"content").hexdigest()}"'


@pytest.mark.parametrize(
    ("if_none_match", "expected"),
    [
        ('"abc"', True),
        ('W/"abc"', True),
        ('"x", "abc"', True),
        ("*", True),
        ('"ab"', False),
        ("abc", False),
        ("", False),
    ],
)
def test_known_tags_are_recognised(if_none_match, expected):
    assert matches(if_none_match, ETAG) is expected


@pytest.mark.parametrize("fields", [[], ['"abc"'], ["*"], ['"x", "abc"'], ['"x"', ' "abc" ']])
def test_content_that_is_named_passes(fields):
    check_if_match(fields, '"other"', ETAG)


@pytest.mark.parametrize("fields", [['W/"abc"'], ['"ab"'], ["abc"], [""], ['"x"', '"y"']])
def test_content_that_is_not_named_is_a_problem(fields):
    with pytest.raises(ProblemError) as caught:
        check_if_match(fields, ETAG)
    assert caught.value.problem.code == "precondition-failed"


def test_content_without_a_tag_is_named_by_the_star_only():
    check_if_match(["*"])
    with pytest.raises(ProblemError):
        check_if_match([ETAG])


@pytest.mark.parametrize(
    ("field", "expected"),
    [
        ("", None),
        ("bytes=0-0", (0, 1)),
        ("bytes=10-", (10, 100)),
        ("bytes=10-19", (10, 20)),
        ("bytes=10-1000", (10, 100)),
        ("bytes=-10", (90, 100)),
        ("bytes=-1000", (0, 100)),
        ("bytes=0-1,5-6", None),
        ("bytes=20-10", None),
        ("bytes=-", None),
        ("lines=0-1", None),
        ("bytes=a-b", None),
    ],
)
def test_one_range_is_honoured_and_others_are_ignored(field, expected):
    assert byte_range(field, None, ETAG, 100) == expected


@pytest.mark.parametrize("field", ["bytes=100-", "bytes=100-200", "bytes=-0"])
def test_a_range_behind_the_end_is_a_problem(field):
    with pytest.raises(ProblemError) as caught:
        byte_range(field, None, ETAG, 100)
    assert caught.value.problem.code == "range-not-satisfiable"
    assert caught.value.problem.headers["Content-Range"] == "bytes */100"


def test_if_range_asks_for_the_part_of_the_same_content_only():
    assert byte_range("bytes=0-9", ETAG, ETAG, 100) == (0, 10)
    assert byte_range("bytes=0-9", '"other"', ETAG, 100) is None
    assert byte_range("bytes=0-9", f"W/{ETAG}", ETAG, 100) is None


@given(st.text(alphabet="bytes=-0123456789, ", max_size=20), st.integers(1, 50))
@pytest.mark.slow
def test_a_range_lies_inside_the_content(field, size):
    try:
        part = byte_range(field, None, ETAG, size)
    except ProblemError:
        return
    assert part is None or 0 <= part[0] < part[1] <= size
