from hypothesis import given
from hypothesis import strategies as st

from service.caching.byte_bounded_cache import ByteBoundedCache


def test_the_least_recently_used_value_leaves_first():
    cache = ByteBoundedCache(30)
    for key in "abc":
        cache.put(key, key.upper(), 10)
    cache.get("a")
    cache.put("d", "D", 10)
    assert [cache.get(key) for key in "abcd"] == ["A", None, "C", "D"]


def test_a_value_above_the_bound_is_not_kept_and_drives_nothing_out():
    cache = ByteBoundedCache(10)
    cache.put("a", "A", 10)
    cache.put("b", "B", 11)
    assert cache.get("a") == "A"
    assert cache.get("b") is None


def test_a_value_that_grows_drives_others_out_and_in_the_end_itself():
    cache = ByteBoundedCache(30)
    values = {key: [key] for key in "abc"}
    for key, value in values.items():
        cache.put(key, value, 10)
    misses = cache.misses
    cache.resize("a", values["a"], 20)
    assert [cache.get(key) for key in "abc"] == [["a"], None, ["c"]]
    cache.resize("b", values["b"], 5)
    cache.resize("c", ["c"], 5)  # an equal value, but not the one that is kept
    assert (cache.nbytes, cache.misses) == (30, misses)
    cache.resize("a", values["a"], 31)
    assert [cache.get(key) for key in "abc"] == [None, None, ["c"]]
    assert cache.nbytes == 10


def test_a_value_is_discarded_only_while_it_is_the_one_that_is_kept():
    cache = ByteBoundedCache(30)
    old, new = ["a"], ["a"]
    cache.put("a", old, 10)
    cache.put("a", new, 20)
    assert not cache.discard_value("a", old)
    assert not cache.discard_value("b", old)
    assert (cache.get("a") is new, cache.nbytes) == (True, 20)
    assert cache.discard_value("a", new)
    assert (cache.get("a"), cache.nbytes) == (None, 0)


def test_keys_are_discarded_by_condition():
    cache = ByteBoundedCache(100)
    for key in range(6):
        cache.put(key, key, 1)
    cache.discard_where(lambda key: key % 2 == 0)
    assert [key for key in range(6) if cache.get(key) is not None] == [1, 3, 5]
    assert cache.nbytes == 3


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 40)), max_size=60))
def test_the_bound_holds_and_the_newest_that_fits_is_there(puts):
    cache = ByteBoundedCache(50)
    sizes = {}
    for key, size in puts:
        cache.put(key, (key, size), size)
        sizes[key] = size
        assert cache.get(key) == (key, size)
        present = [key for key in sizes if cache.get(key) is not None]
        assert cache.nbytes == sum(sizes[key] for key in present) <= 50
