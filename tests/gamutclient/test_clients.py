"""Clients: builds with progress, lists, names, keys, errors and retries."""

import asyncio
import datetime as dt
import io
import json

import gamutclient
import httpx
import numpy as np
import pytest
import servers
from gamutclient.transport import Request, Retries

import gamutcore

PROBLEM = {"code": "queries-busy", "detail": "Too many rows.", "where": {}, "remedy": "Wait."}
BUSY = (429, {"Retry-After": "0"}, json.dumps(PROBLEM).encode())
LOST = (None, {}, b"")
FOUND = (200, {}, json.dumps({"references": [{"slug": "srgb"}]}).encode())


def answered(scripted, *answers, **settings):
    scripted.answers[:] = answers
    with gamutclient.Client(scripted.url, **settings) as client:
        return client.references()


def test_figures_of_a_later_service_do_not_disturb(scripted):
    level = {"triangles": 4, "max_error": 0.0}
    loss = {"mean": 1.0, "percentile_95": 2.0, "share_outside": 0.5, "median": 0.8}
    volumes = dict.fromkeys(("volume_a", "volume_b", "intersection"), 1)
    ends = dict.fromkeys(("white_a", "white_b", "black_a", "black_b"), (50, 0, 0))
    answer = {
        **volumes,
        **ends,
        "sectors": {"hue_from": [0], "hue_to": [360]} | {name: [1] for name in volumes},
        "levels": {"a": level, "b": level},
        "warnings": [],
        "lost_a": loss,
    }
    described = (200, {}, json.dumps({"id": "a" * 64}).encode())
    scripted.answers[:] = [described, (200, {}, json.dumps(answer).encode())]
    with gamutclient.Client(scripted.url) as client:
        assert client.gamut("a" * 64).compare("srgb", lost=True).lost_a.mean == 1.0


class TestBuilds:
    def test_progress_is_told(self, client, sphere):
        told = []
        gamut = client.build(
            np.array(sphere(seed=801, count=5000)),
            cost="finest",
            name="A ball",
            progress=lambda stage, fraction: told.append((stage, fraction)),
        )
        assert gamut.volume > 0
        assert all(0 <= fraction <= 1 for _, fraction in told)
        assert {stage for stage, _ in told} <= {
            *("characterisation", "colours", "boundary", "decimation", "metric", "encoding")
        }
        assert [each["id"] for each in client.gamuts("A ball")] == [gamut.id]

    def test_names_and_deletion(self, client, sphere):
        gamut = client.build(np.array(sphere(seed=802)))
        gamut.give_name("Named later")
        assert client.gamut(gamut.id).description["name"] == "Named later"
        gamut.delete()
        with pytest.raises(gamutclient.ServiceError) as caught:
            client.gamut(gamut.id)
        assert caught.value.code == "gamut-not-found"
        assert caught.value.status == 404

    def test_lists_have_all_pages(self, client, sphere, monkeypatch):
        monkeypatch.setattr("gamutclient.clients.PAGE", 2)
        built = {client.build(np.array(sphere(seed=seed))).id for seed in (803, 804, 805)}
        listed = [each["id"] for each in client.gamuts()]
        assert built <= set(listed)
        assert len(listed) == len(set(listed))

    @pytest.mark.parametrize("progress", [None, lambda *_: None])
    def test_refused_data(self, client, progress):
        with pytest.raises(gamutclient.ServiceError) as caught:
            client.build(np.zeros((5, 3)), progress=progress)
        assert caught.value.code == "too-few-points"
        assert caught.value.remedy
        with pytest.raises(gamutclient.ServiceError, match="srgb") as caught:
            client.reference("sRGG", progress=progress)
        assert caught.value.status == 422

    @pytest.mark.parametrize(
        "data", [np.zeros((6, 4)), np.zeros(9), None, [["a", "b", "c"]], np.zeros((9, 3), complex)]
    )
    def test_data_that_is_no_list_of_colours(self, client, data):
        """An array of four columns must not be read as one of three."""
        for build in (client.build, gamutcore.Gamut):
            with pytest.raises(TypeError, match=r"\(n, 3\)"):
                build(data)

    def test_the_forms_of_data(self, client, sphere):
        """The same gamuts as `gamutcore` builds of an array, of named columns, of a table."""
        colours = np.array(sphere(seed=806))
        named = np.zeros(len(colours), [(name, "f8") for name in ("LAB_L", "LAB_A", "LAB_B")])
        for axis, name in enumerate(named.dtype.names):
            named[name] = colours[:, axis]

        class Table:
            def to_csv(self, index):
                assert index is False
                rows = ["L*,a*,b*", *(",".join(map(repr, map(float, row))) for row in colours)]
                return "\n".join(rows) + "\n"

        for data in (colours, colours.tolist(), colours.reshape(-1, 2, 3), named, Table()):
            assert client.build(data).id == gamutcore.Gamut(data).id
        text = io.StringIO(Table().to_csv(index=False))
        assert client.build(text).id == gamutcore.Gamut(Table()).id

    def test_numbers_of_numpy_are_options(self, client):
        given = {"surface_samples": np.int64(1000), "luminance": np.float32(100)}
        gamut = client.reference("sRGB", space="ICtCp", **given)
        assert gamut.description["options"]["surface_samples"] == 1000
        with pytest.raises(TypeError, match="set"):
            client.build(np.eye(3), space={"CIELAB"})

    def test_names_are_searched_in_any_spelling(self, client, sphere):
        assert client.references("Rec2020")[0]["slug"] == "bt2020"
        assert client.references("qwxz") == []
        built = client.build(np.array(sphere(seed=807)), name="PSOcoated_v3")
        assert client.gamuts("FOGRA51", match="similar")[0]["id"] == built.id
        assert built.id not in {each["id"] for each in client.gamuts("FOGRA51")}

    def test_ids_stay_in_their_place_of_the_address(self, client):
        for gamut_id in ("../references", "pointer/mesh", "pointer?space=Oklab", ""):
            with pytest.raises(gamutclient.ServiceError):
                client.gamut(gamut_id)

    def test_large_arrays_are_sent_in_parts(self, remote, monkeypatch):
        colours = np.random.default_rng(1).uniform(-100, 100, (70, 3))
        whole = remote[0].nearest(colours), remote[0].crossings(colours, (50, 0, 0), kind="line")
        monkeypatch.setattr("gamutclient.gamuts.MOST_ROWS", 16)
        parts = remote[0].nearest(colours), remote[0].crossings(colours, (50, 0, 0), kind="line")
        np.testing.assert_array_equal(parts[0].points, whole[0].points)
        np.testing.assert_array_equal(parts[1].offsets, whole[1].offsets)
        np.testing.assert_array_equal(parts[1].t, whole[1].t)


def test_api_keys(guarded_app):
    with gamutclient.Client(guarded_app, api_key=servers.READER[0]) as client:
        assert len(client.references()) > 50
    with (
        gamutclient.Client(guarded_app) as client,
        pytest.raises(gamutclient.ServiceError) as caught,
    ):
        client.references()
    assert caught.value.status == 401


@pytest.mark.slow
class TestRetries:
    def test_a_busy_service_and_one_that_is_lost_are_asked_again(self, scripted):
        async def ask():
            async with gamutclient.AsyncClient(scripted.url) as client:
                return await client.references()

        assert answered(scripted, BUSY, LOST, BUSY, FOUND) == [{"slug": "srgb"}]
        assert len(scripted.requests) == 4
        scripted.answers[:] = [BUSY, LOST, FOUND]
        assert asyncio.run(ask()) == [{"slug": "srgb"}]

    def test_attempts_are_bounded(self, scripted):
        with pytest.raises(gamutclient.ServiceError, match="Too many rows") as caught:
            answered(scripted, BUSY, retries=Retries(attempts=3))
        assert caught.value.code == "queries-busy"
        assert len(scripted.requests) == 3
        with pytest.raises(gamutclient.ConnectionLostError, match="2 times"):
            answered(scripted, LOST, retries=Retries(attempts=2))

    def test_a_build_is_awaited_while_the_service_restarts(self):
        """Driven without a connection, so that nothing waits."""
        client = gamutclient.Client("http://127.0.0.1:9")
        steps = client._built(Request("POST", "/v1/gamuts"), None)
        assert next(steps).method == "POST"
        accepted = {"id": "a" * 64, "state": "queued"}
        answer = httpx.Response(202, json=accepted, headers={"Retry-After": "2"})
        assert steps.send(answer).delay == 2
        waits = []

        def refuse():
            while True:
                asked = steps.send(httpx.ConnectError("refused"))
                assert asked.path.startswith("/v1/jobs/")
                waits.append(asked.delay)

        with pytest.raises(gamutclient.ConnectionLostError, match="12 times"):
            refuse()
        assert max(waits) <= 8
        assert 50 < sum(waits) < 60

    def test_an_address_without_a_scheme_is_not_tried_again(self):
        with (
            gamutclient.Client("127.0.0.1:8000") as client,
            pytest.raises(gamutclient.ConnectionLostError, match=r"1 times.*http://"),
        ):
            client.references()

    @pytest.mark.parametrize(
        ("answer", "code"),
        [
            ((503, {"Retry-After": "3600"}, b"{}"), "http-503"),
            ((502, {}, b"<html>bad gateway</html>"), "http-502"),
        ],
    )
    def test_long_waits_and_other_errors_are_not_repeated(self, scripted, answer, code):
        with pytest.raises(gamutclient.ServiceError, match=f"HTTP status {answer[0]}") as caught:
            answered(scripted, answer)
        assert caught.value.code == code
        assert len(scripted.requests) == 1

    def test_what_the_service_asks_for_is_waited(self):
        """A number or a date (RFC 9110, 5.6.7); otherwise the wait is the client's own."""

        def wait(text):
            answer = httpx.Response(503, headers={"Retry-After": text})
            return Retries(longest_wait=4000).wait(answer, attempt=1)

        soon = dt.datetime.now(dt.UTC) + dt.timedelta(seconds=3000)
        assert 2000 <= wait(soon.strftime("%a, %d %b %Y %H:%M:%S GMT")) <= 3000
        assert wait("Sun, 06 Nov 1994 08:49:37 GMT") == 0
        assert wait("12") == 12
        assert wait("soon") == wait("") == 0.25
        assert wait("4001") is None
