import asyncio
import re
import time

import httpx

from service.telemetry.server_timing import ServerTiming, timed

METRIC = re.compile(r"([a-z]+);dur=([0-9.]+)")


def times(response):
    return {name: float(value) for name, value in METRIC.findall(response.headers["server-timing"])}


def answer(work):
    async def app(_scope, _receive, send):
        await work()
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send({"type": "http.response.body", "body": b""})

    async def request():
        transport = httpx.ASGITransport(ServerTiming(app))
        async with httpx.AsyncClient(transport=transport, base_url="http://test") as client:
            return await asyncio.gather(client.get("/"), client.get("/"))

    return [times(response) for response in asyncio.run(request())]


def test_parts_of_one_name_add_up_and_the_total_holds_them():
    async def work():
        for _ in range(2):
            with timed("encode"):
                await asyncio.sleep(0.02)
        with timed("open"):
            time.sleep(0.01)  # noqa: ASYNC251 - what is measured

    for told in answer(work):
        assert list(told) == ["total", "encode", "open"]
        assert told["encode"] >= 40
        assert told["open"] >= 10
        assert told["total"] >= told["encode"] + told["open"] - 0.1


def test_work_in_a_task_belongs_to_who_began_it():
    async def part():
        with timed("part"):
            await asyncio.sleep(0.01)

    async def work():
        await asyncio.create_task(part())

    assert all(told["part"] >= 10 for told in answer(work))


def test_outside_of_requests_nothing_is_kept():
    with timed("encode"):
        pass


def test_meshes_tell_what_they_cost(server, gamut):
    path = gamut["links"]["mesh"] + "?triangles=222"
    first, second = server.client.get(path), server.client.get(path)
    assert "encode" in times(first)
    assert list(times(second)) == ["total"]
