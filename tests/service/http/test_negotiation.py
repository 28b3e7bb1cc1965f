import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.http.negotiation import Preference, preference, preferred_media_type

OFFERED = ["model/gltf-binary", "model/gltf+json", "text/plain"]


@pytest.mark.parametrize(
    ("accept", "expected"),
    [
        (None, "model/gltf-binary"),
        ("", "model/gltf-binary"),
        ("*/*", "model/gltf-binary"),
        ("text/plain", "text/plain"),
        ("TEXT/Plain", "text/plain"),
        ("text/*", "text/plain"),
        ("model/*", "model/gltf-binary"),
        ("model/gltf+json, */*;q=0.1", "model/gltf+json"),
        ("model/gltf+json;q=0.5, text/plain;q=0.6", "text/plain"),
        # The more specific range decides, whatever its quality: RFC 9110 clause 12.5.1.
        ("model/*;q=1, model/gltf-binary;q=0.2", "model/gltf+json"),
        ("*/*, model/gltf-binary;q=0", "model/gltf+json"),
        ("text/html,application/xhtml+xml,*/*;q=0.8", "model/gltf-binary"),
        ("text/html", None),
        ("model/gltf-binary;q=0", None),
        ("*/*;q=0", None),
        ("nonsense, text/plain", "text/plain"),
        ("text/plain;q=nonsense", "text/plain"),
    ],
)
def test_media_types_are_negotiated(accept, expected):
    assert preferred_media_type(accept, OFFERED) == expected


@given(st.text(alphabet=st.characters(max_codepoint=255)))
def test_any_accept_gets_an_answer(accept):
    assert preferred_media_type(accept, OFFERED) in {*OFFERED, None}


@pytest.mark.parametrize(
    ("fields", "expected"),
    [
        ([], Preference()),
        (["respond-async"], Preference(respond_async=True)),
        (["wait=10"], Preference(wait=10)),
        (["Wait = 10"], Preference(wait=10)),
        (['wait="10"'], Preference(wait=10)),
        (["respond-async, wait=10"], Preference(respond_async=True, wait=10)),
        (["respond-async", "wait=10"], Preference(respond_async=True, wait=10)),
        (["return=minimal; foo=bar, wait=3;x=y"], Preference(wait=3)),
        (["wait=3, wait=5"], Preference(wait=3)),
        (['note="a, wait=3, b", wait=5'], Preference(wait=5)),
        (['note="\\", wait=3"; x="y;z"'], Preference()),
        (['note="never closed, wait=3'], Preference()),
        (["wait=-1"], Preference()),
        (["wait=soon"], Preference()),
        (["wait=99999999999999999999"], Preference()),
        (["wait=²"], Preference()),
    ],
)
def test_preferences_are_read(fields, expected):
    assert preference(fields) == expected


def test_waiting_follows_the_preference():
    assert Preference().seconds(30, 300) == 30
    assert Preference(respond_async=True).seconds(30, 300) == 0
    assert Preference(wait=5).seconds(30, 300) == 5
    assert Preference(respond_async=True, wait=5).seconds(30, 300) == 5
    assert Preference(wait=1000).seconds(30, 300) == 300


def test_only_what_was_honoured_is_reported():
    both = Preference(respond_async=True, wait=5)
    assert both.applied_field(answered_async=True, longest=300) == "respond-async, wait=5"
    assert both.applied_field(answered_async=False, longest=300) == "wait=5"
    assert Preference(wait=1000).applied_field(answered_async=True, longest=300) == ""
