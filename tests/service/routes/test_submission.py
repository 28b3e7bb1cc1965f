"""What is made of a posted body: content, options, and limits; by the id of the job, which says so.

The lifespan of the app in this process does not run, so that nothing is built.
"""

import asyncio
import gzip
import hashlib
import json
import threading

import httpx
import pytest

from gamutcore import Options
from gamutcore.building import gamut_id
from service.application import create_app
from service.settings import Settings
from service.storage.gamut_store import GamutStore
from service.storage.local import LocalBlobs

JSON = {"Content-Type": "application/json"}


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    """The folder of an empty store."""
    opened = GamutStore(LocalBlobs(tmp_path_factory.mktemp("submission")))
    opened.open()
    opened.close()
    return opened.blobs.directory


@pytest.fixture(scope="module")
def post(request_app, store):
    """Post a body to an app with an empty store."""
    app = create_app(Settings(store=str(store), build_queue=10_000))

    def send(**arguments):
        headers = {"Prefer": "respond-async", **arguments.pop("headers", {})}
        return request_app(app, "POST", "/v1/gamuts", headers=headers, **arguments)

    return send


def accepted(answer):
    """The id of the job that was accepted."""
    assert answer.status_code == 202, answer.text
    return answer.headers["location"].rpartition("/")[2]


def expected(content, **options):
    return gamut_id(Options(**options), hashlib.sha256(content).hexdigest())


def test_a_file_is_passed_on_byte_for_byte_and_leaves_nothing_on_the_disk(post, store):
    content = bytes(range(256)) * 12_000
    answer = post(files={"file": content}, data={"options": '{"gamma": 0.5}'})
    assert accepted(answer) == expected(content, gamma=0.5)
    assert post(files={"file": content, "other": content}).status_code == 422
    assert list((store / "temporary").iterdir()) == []
    assert accepted(post(files={"file": b"x"})) == expected(b"x")


def test_few_large_files_are_in_memory_at_a_time(store, monkeypatch):
    """Two fit into the budget of 28 MiB. The store keeps none until all have been sent."""
    gate, entered, keep = threading.Event(), threading.Semaphore(0), GamutStore.keep_input
    inside, most = set(), []

    def keep_behind_the_gate(self, gamut_id, data, *rest):
        if len(data) < 1_000_000:
            return keep(self, gamut_id, data, *rest)
        inside.add(gamut_id)
        most.append(len(inside))
        entered.release()
        assert gate.wait(600)
        inside.remove(gamut_id)
        return keep(self, gamut_id, data, *rest)

    monkeypatch.setattr(GamutStore, "keep_input", keep_behind_the_gate)

    async def scenario():
        sent = asyncio.Semaphore(0)
        transport = httpx.ASGITransport(
            create_app(Settings(store=str(store), memory_bytes=256 << 20))
        )
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as client:

            async def post(content):
                form = client.build_request("POST", "/v1/gamuts", files={"file": content})

                async def body():
                    yield form.read()
                    sent.release()

                fields = {"Content-Type": form.headers["content-type"], "Prefer": "respond-async"}
                return await client.post("/v1/gamuts", content=body(), headers=fields)

            large = [asyncio.create_task(post(bytes(12_000_000 + n))) for n in range(5)]
            try:
                for _ in large:
                    await sent.acquire()
                for _ in range(2):
                    assert await asyncio.to_thread(entered.acquire, timeout=300)
                answers = [await post(b"small")]
            finally:
                gate.set()  # otherwise the threads behind it would not end
            return answers + await asyncio.gather(*large)

    answers = asyncio.run(asyncio.wait_for(scenario(), 600))
    assert {answer.status_code for answer in answers} == {202}
    assert max(most) == 2


MANY = {
    "space": "CAM16-UCS",
    "boundary": "usv",
    "gamma": 0.1,
    "basis": "octahedron",
    "subdivisions": 3,
    "cost": "finest",
    "surface_samples": 5000,
    "intent": "absolute",
    "device_model": "fit",
    "ink_limit": 300,
    "black_limit": 90,
    "observer": 10,
}


@pytest.mark.parametrize(
    ("fields", "options"),
    [
        ({"ink_limit": "300"}, {"ink_limit": 300}),
        ({"Ink-Limit": "300", "SPACE": "oklab"}, {"ink_limit": 300, "space": "Oklab"}),
        ({"centre": "[50, 0, 1]", "options": '{"gamma": 1}'}, {"centre": (50, 0, 1), "gamma": 1}),
        ({"condition": "M1"}, {"condition": "M1"}),
        ({"Space": "Lab", "options": '{"space": "CIE L*a*b*"}'}, {"space": "CIELAB"}),
        ({"ink_limit": ["300", "3e2"], "INK_LIMIT": "300.0"}, {"ink_limit": 300}),
        ({name: str(value) for name, value in MANY.items()}, MANY),
    ],
)
def test_options_may_be_form_fields(post, fields, options):
    assert accepted(post(files={"file": b"x"}, data=fields)) == expected(b"x", **options)


@pytest.mark.parametrize(
    ("fields", "field", "code", "said"),
    [
        ({"ink_limit": "much"}, "ink_limit", "invalid-option", ["ink_limit"]),
        ({"inklimits": "300"}, "inklimits", "invalid-body", ["ink_limit"]),
        (
            {"ink_limit": "300", "options": '{"ink_limit": 200}'},
            "ink_limit",
            "invalid-body",
            ["200", "300"],
        ),
    ],
)
def test_form_fields_that_are_no_options_or_differ_are_refused(
    post, assert_problem, fields, field, code, said
):
    document = assert_problem(post(files={"file": b"x"}, data=fields), 422, code)
    assert document["where"]["field"] == field
    assert all(each in json.dumps(document) for each in said)


def test_inline_samples_have_one_form(post):
    samples = {"samples": [[1.0, 2.5, -3e-7]] * 2000, "columns": ["L", "a", "b"], "maker": "Grün"}
    samples["options"] = {"gamma": 1}
    one = accepted(post(json=samples))
    other = json.dumps(dict(reversed(samples.items())), indent=2, ensure_ascii=False).encode()
    assert accepted(post(content=other, headers=JSON)) == one
    samples["options"] = {"gamma": 0.5}
    assert accepted(post(json=samples)) != one


def test_few_samples_are_read_at_once_and_many_by_the_build(post, assert_problem):
    wrong = {"samples": [[50, 0, 0]], "white": "D50"}
    assert_problem(post(json=wrong), 422, "malformed-file")
    accepted(post(json={**wrong, "samples": [[50, 0, 0]] * 2000}))


def test_an_option_beside_the_options_is_not_taken_for_a_condition(post, assert_problem):
    few, many = [[50, 0, 0]], [[50, 0, 0]] * 200
    for name in Options.model_fields:
        document = assert_problem(post(json={"samples": few, name: 1}), 422, "invalid-body")
        assert document["where"] == {"field": name}
        assert f'"options": {{"{name}": ...}}' in document["remedy"]
        # Nothing is taken for an option where conditions are stated, or in their usual capitals.
        for stated in ({"conditions": {name: "1"}}, {name.upper(): "1"}):
            accepted(post(json={"samples": many, **stated}))


def test_large_json_is_asked_for_as_a_file(request_app, assert_problem, tmp_path):
    """Decoding it would hold up every other request."""
    app = create_app(Settings(store=str(tmp_path)))
    body = {"samples": [[50.0, 0.0, 0.0]] * 80_000}
    document = assert_problem(
        request_app(app, "POST", "/v1/gamuts", json=body), 413, "body-too-large"
    )
    assert document["where"] == {"limit": 2**20}
    assert "file" in document["remedy"]


@pytest.mark.parametrize("coding", ["gzip", "x-gzip", "zstd", "br", "gzip, gzip", "identity, gzip"])
def test_compressed_bodies_are_not_unpacked(post, assert_problem, coding):
    content = gzip.compress(bytes(1_000_000))
    answer = post(content=content, headers={**JSON, "Content-Encoding": coding})
    document = assert_problem(answer, 415, "unsupported-media-type")
    assert document["where"] == {"header": "Content-Encoding"}
    assert answer.headers["accept-encoding"] == "identity"


def test_forms_are_bounded(post, assert_problem):
    for form in (
        {"files": {"file": b"x"}, "data": {"gamma": ["0.5"] * 1000}},
        {"files": {"file": b"x"}, "data": {"options": " " * 70_000}},
    ):
        assert_problem(post(**form), 413, "body-too-large")
    options = ("options.json", b'{"gamma": 0.5' + b" " * 70_000 + b"}")
    assert_problem(post(files={"file": b"x", "options": options}), 422, "invalid-body")
    answer = post(json={"samples": [], "options": {"surface_samples": 1_000_001}})
    assert "1000000" in assert_problem(answer, 422, "invalid-option")["remedy"]


@pytest.mark.parametrize(
    ("options", "name"),
    [
        ('{"gamma": 0.5, "gamma": 0.1}', "gamma"),
        ('{"gamma": 0.5, "boundary": "usv", "gamma": 0.5}', "gamma"),
        ('{"gamma": 0.5, "g\\u0061mma": 0.1}', "gamma"),
        ('{"centre": {"L": 50, "L": 60}}', "L"),
        ('{"\\ud800": 1, "\\ud800": 2}', None),
        ('{}, "options": {"gamma": 0.5}', "options"),
    ],
)
def test_members_that_come_twice_are_refused(post, assert_problem, options, name):
    inline = f'{{"samples": [[50, 0, 0]], "options": {options}}}'
    bodies = [{"content": inline, "headers": JSON}]
    if name != "options":
        bodies.append({"files": {"file": b"x"}, "data": {"options": options}})
    for body in bodies:
        found = assert_problem(post(**body), 422, "invalid-body")
        assert "more than one member" in found["detail"]
        assert name is None or found["where"] == {"field": name}
