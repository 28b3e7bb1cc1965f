from typing import NamedTuple

from hypothesis import given
from hypothesis import strategies as st

from service.routes.paging import page_of


class Entry(NamedTuple):
    id: str


@given(st.integers(0, 40), st.integers(1, 12))
def test_following_the_links_shows_every_entry_once_and_in_order(count, limit):
    entries = [Entry(f"{number:064x}") for number in range(count)]
    after, seen = "", []
    while True:
        rest = [entry for entry in entries if entry.id > after]
        shown, following, headers = page_of(rest[: limit + 1], limit, "/v1/things")
        assert len(shown) <= limit
        seen += shown
        if following is None:
            assert headers == {}
            break
        assert headers == {"Link": f'<{following}>; rel="next"'}
        path, _, after = following.partition(f"?limit={limit}&after=")
        assert path == "/v1/things"
    assert seen == entries
