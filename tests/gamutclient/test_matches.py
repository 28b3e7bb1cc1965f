"""Matches by the service are those of `gamutcore.match`, in the same class."""

import asyncio
from itertools import product

import gamutclient
import numpy as np
import pytest

import gamutcore

COLOURS = np.random.default_rng(3).uniform((20, -30, -30), (80, 30, 30), (12, 3))
BOXES = {"client box a": (25.0, 10.0, 10.0), "client box b": (10.0, 25.0, 10.0)}


def corners(sides):
    return np.array([(50 + x, y, z) for x, y, z in product(*((-side, side) for side in sides))])


@pytest.fixture(scope="module")
def pair():
    gamuts = []
    for name, sides in BOXES.items():
        gamut = gamutcore.Gamut(corners(sides))
        gamut.name = name
        gamuts.append(gamut)
    return gamuts


@pytest.fixture(scope="module")
def stored(client):
    return [client.build(corners(sides), name=name) for name, sides in BOXES.items()]


@pytest.mark.parametrize(
    "terms", [{}, {"passing": 3.0}, {"delta_e": False, "edge_width": 2.5}, {"max_error": 0.0}]
)
def test_the_same_as_in_the_own_process(client, pair, stored, terms):
    names = [f"spot {row}" for row in range(len(COLOURS))]
    here = gamutcore.match(COLOURS, pair, names=names, **terms)
    there = client.match(COLOURS, stored, names=names, **terms)
    assert type(there).__name__ == type(here).__name__
    assert there.to_dict() == here.to_dict()


def test_files_names_and_coroutines(server, client, pair, stored):
    table = "name,L,a,b\n" + "".join(
        f"spot {row},{L},{a},{b}\n" for row, (L, a, b) in enumerate(COLOURS)
    )
    here = gamutcore.match(COLOURS, pair, names=[f"spot {row}" for row in range(len(COLOURS))])
    there = client.match(table.encode(), list(BOXES))
    assert there.colours == here.colours
    np.testing.assert_allclose(there.distance, here.distance, atol=1e-9)

    async def ask():
        async with gamutclient.AsyncClient(server.url) as opened:
            return await opened.match(COLOURS, [each.id for each in stored])

    assert (asyncio.run(ask()).position == here.position).all()


def test_recipes(client):
    levels = np.array(list(product((0.0, 50.0, 100.0), repeat=3)))
    columns = {f"RGB_{channel}": levels[:, at] for at, channel in enumerate("RGB")}
    colours = {"LAB_L": levels.mean(axis=1), "LAB_A": levels[:, 0] - levels[:, 1]}
    colours["LAB_B"] = levels[:, 1] - levels[:, 2]
    rows = np.rec.fromarrays(list((columns | colours).values()), names=list(columns | colours))
    gamut = client.build(rows, surface_samples=200)
    found = client.match([(50, 0, 0), (30, 10, 5)], [gamut], recipes=True)
    assert len(found.recipes[0].channels) == 3
    assert found.recipes[0].device[0] == pytest.approx([0.5] * 3, abs=0.01)
    assert found.recipes[0].delta_e.max() < 0.5


def test_ambiguous_names_and_names_of_a_table(client, stored):
    with pytest.raises(gamutclient.ServiceError) as caught:
        client.match(COLOURS, ["client box"])
    assert {each["id"] for each in caught.value.where["candidates"]} == {each.id for each in stored}
    with pytest.raises(ValueError, match="Names are for colours in an array"):
        client.match(b"L,a,b\n50,0,0\n", stored, names=["a"])
