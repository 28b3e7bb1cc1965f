import pytest

from service.building.embedded import EmbeddedEngine
from service.building.engine import Engine, queue_full, shutting_down
from service.settings import Settings


@pytest.mark.parametrize(("estimate", "told"), [(0, "1"), (7, "7"), (10**6, "600")])
def test_a_full_queue_says_when_to_come_back_within_reason(estimate, told):
    problem = queue_full(16, estimate).problem
    assert (problem.code, problem.headers) == ("queue-full", {"Retry-After": told})
    assert "16" in problem.detail


def test_a_service_that_stops_says_when_to_come_back():
    problem = shutting_down().problem
    assert problem.kind.status == 503
    assert int(problem.headers["Retry-After"]) > 0


def test_the_embedded_engine_does_what_every_engine_does(store, book):
    engine = EmbeddedEngine(Settings(), store, book, sole_owner=True)
    promised = {name for name in vars(Engine) if not name.startswith("_")}
    assert promised <= set(dir(engine))
    facts = engine.facts()
    assert (facts.queued, facts.running, facts.warm_workers) == (0, 0, 0)
    assert (facts.workers, facts.capacity) == (1, 16)
