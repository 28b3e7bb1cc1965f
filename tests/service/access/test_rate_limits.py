import pytest

from service.access.rate_limits import TokenBuckets


class Clock:
    now = 0.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def buckets(clock):
    return TokenBuckets(2.0, 3, clock)


def test_a_burst_is_granted_and_no_more(buckets):
    assert [buckets.take("a").granted for _ in range(5)] == [True] * 3 + [False] * 2


def test_what_is_left_is_told(buckets):
    assert [buckets.take("a").remaining for _ in range(4)] == [2, 1, 0, 0]


def test_tokens_come_back_at_the_rate(buckets, clock):
    for _ in range(3):
        buckets.take("a")
    clock.now = 0.49
    refused = buckets.take("a")
    assert not refused.granted
    assert refused.seconds == pytest.approx(0.01)
    clock.now = 0.51
    assert buckets.take("a").granted
    clock.now = 100.0
    assert [buckets.take("a").granted for _ in range(4)] == [True] * 3 + [False]


def test_asking_too_early_costs_nothing(buckets, clock):
    for _ in range(3):
        buckets.take("a")
    for step in range(100):
        clock.now = step / 1000
        assert not buckets.take("a").granted
    clock.now = 0.5
    assert buckets.take("a").granted


def test_clients_do_not_share(buckets):
    for _ in range(4):
        buckets.take("a")
    assert buckets.take("b").granted


def test_any_number_of_clients_takes_a_bounded_memory(buckets):
    for number in range(60_000):
        buckets.take(str(number))
    assert len(buckets) == 50_000
    assert buckets.take("59999").remaining == 1
