import itertools

import pytest


@pytest.fixture(scope="session")
def cubes(server):
    """Addresses of two cubes about L* = 50, a* = b* = 0: edges of 20, and of 10."""
    made = []
    for edge in (20, 10):
        corners = itertools.product((-edge / 2, edge / 2), repeat=3)
        body = {"samples": [[50 + x, y, z] for x, y, z in corners], "options": {"gamma": 1}}
        answer = server.client.post("/v1/gamuts", json=body)
        assert answer.status_code in {200, 201}, answer.text
        assert answer.json()["counts"]["triangles"] == 12
        made.append(answer.json()["links"]["self"])
    return made
