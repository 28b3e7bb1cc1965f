import hashlib

import pytest

from service.access.api_keys import ApiKeys, new_key


@pytest.fixture(scope="module")
def made():
    return new_key("ci", frozenset({"read"})), new_key("press", frozenset({"read", "write"}))


@pytest.fixture(scope="module")
def keys(made):
    return ApiKeys(", ".join(known.entry for _, known in made))


def test_a_key_is_found_with_its_scopes(keys, made):
    for key, known in made:
        assert keys.find(key.encode()) == known


def test_the_digest_is_that_of_the_key(made):
    (key, known), _ = made
    assert known.entry == f"ci:read:{hashlib.sha256(key.encode()).hexdigest()}"


def test_two_keys_of_one_name_differ():
    assert new_key("ci", frozenset({"read"}))[0] != new_key("ci", frozenset({"read"}))[0]


def test_anything_else_is_not_found(keys, made):
    (first, known), (second, _) = made
    secret = first.rpartition("_")[2]
    for other in (
        "",
        "gamut_ci_",
        known.digest,
        first[:-1],
        first + "A",
        first.upper(),
        f"gamut_press_{secret}",
        f"gamut_nobody_{secret}",
        second.replace("press", "ci"),
        new_key("ci", frozenset({"read"}))[0],
        first + "\n",
    ):
        assert keys.find(other.encode()) is None
    assert keys.find(b"\xff" * 60) is None


def test_without_keys_nobody_is_found(made):
    assert len(ApiKeys("")) == 0
    assert ApiKeys("").find(made[0][0].encode()) is None


@pytest.mark.parametrize(
    "text",
    [
        "ci",
        "ci:read",
        "ci:read:" + "0" * 63,
        "ci:read:" + "G" * 64,
        "ci::" + "0" * 64,
        "ci:admin:" + "0" * 64,
        "CI:read:" + "0" * 64,
        f"ci:read:{'0' * 64},ci:write:{'1' * 64}",
    ],
)
def test_malformed_entries_are_refused(text):
    with pytest.raises(ValueError, match=r"NAME:SCOPES:SHA256|the name ci"):
        ApiKeys(text)


def test_a_pasted_key_is_not_repeated_in_the_message(made):
    key = made[0][0]
    with pytest.raises(ValueError, match="entry 1") as caught:
        ApiKeys(key)
    assert key[-20:] not in str(caught.value)
