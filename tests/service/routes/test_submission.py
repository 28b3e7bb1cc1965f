import asyncio
import dataclasses
import gzip
import json

import httpx
import pytest
from fastapi import FastAPI, Request

from gamutcore import Options
from service.problems.handlers import add_exception_handlers
from service.routes.submission import submission
from service.settings import Settings


@pytest.fixture
def post(tmp_path):
    """Send a body to a small app, and return what was made of it."""

    def send(**arguments):
        app, found = FastAPI(), []
        add_exception_handlers(app)

        @app.post("/")
        async def read(request: Request) -> None:
            limits = Settings(max_surface_samples=200_000, max_inline_bytes=2**25)
            async with submission(request, limits, tmp_path, asyncio.Semaphore(2)) as posted:
                found.append(posted)

        async def request():
            transport = httpx.ASGITransport(app)
            async with httpx.AsyncClient(transport=transport, base_url="http://test") as client:
                return await client.post("/", **arguments)

        answer = asyncio.run(request())
        return found[0] if found else answer

    return send


def test_a_file_is_passed_on_byte_for_byte(post):
    content = bytes(range(256)) * 10_000
    posted = post(files={"file": content}, data={"options": '{"gamma": 0.5}'})
    assert posted.data == content
    assert posted.options == Options(gamma=0.5)


def test_without_options_they_have_their_defaults(post):
    assert post(files={"file": b"x"}).options == Options()
    assert post(json={"samples": [[50, 0, 0]]}).options == Options()


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
    assert post(files={"file": b"x"}, data=fields).options == Options(**options)


def test_an_option_with_two_values_is_refused_with_both(post, assert_problem):
    fields = {"Gamma": "0.5", "options": '{"gamma": 0.25}'}
    answer = post(files={"file": b"x"}, data=fields)
    document = assert_problem(answer, 422, "invalid-body")
    assert document["where"] == {"field": "gamma"}
    assert "0.25" in document["detail"]
    assert "0.5" in document["detail"]


def test_a_form_field_gives_the_id_of_the_same_option_in_json(post):
    plain = post(files={"file": b"x"}, data={"ink_limit": "300"})
    assert (
        plain.gamut_id
        == post(files={"file": b"x"}, data={"options": '{"ink_limit": 300}'}).gamut_id
    )


@pytest.mark.parametrize(
    ("fields", "field", "code"),
    [
        ({"ink_limit": "much"}, "ink_limit", "invalid-option"),
        ({"ink_limit": "300", "options": '{"ink_limit": 200}'}, "ink_limit", "invalid-body"),
        ({"inklimits": "300"}, "inklimits", "invalid-body"),
    ],
)
def test_form_fields_that_are_no_options_are_refused(post, fields, field, code):
    problem = post(files={"file": b"x"}, data=fields).json()
    assert problem["code"] == code
    assert problem["where"]["field"] == field
    assert "ink_limit" in json.dumps(problem)


def test_inline_samples_have_one_form(post):
    samples = {"samples": [[1.0, 2.5, -3e-7]], "columns": ["L", "a", "b"], "maker": "Grün"}
    samples["options"] = {"gamma": 1}
    posted = post(json=samples)
    assert posted.options == Options(gamma=1.0)
    kept = ("samples", "columns", "maker")
    assert json.loads(posted.data) == {key: samples[key] for key in kept}
    other = json.dumps(dict(reversed(samples.items())), indent=2, ensure_ascii=False).encode()
    assert post(content=other, headers={"Content-Type": "application/json"}) == posted


def test_few_samples_are_read_at_once_and_many_by_the_build(post, assert_problem):
    wrong = {"samples": [[50, 0, 0]], "white": "D50"}
    assert_problem(post(json=wrong), 422, "malformed-file")
    many = {**wrong, "samples": [[50, 0, 0]] * 2000}
    assert json.loads(post(json=many).data) == many


@pytest.mark.parametrize("name", [field.name for field in dataclasses.fields(Options)])
@pytest.mark.slow
def test_an_option_beside_the_options_is_not_taken_for_a_condition(post, assert_problem, name):
    samples = [[50, 0, 0]]
    document = assert_problem(post(json={"samples": samples, name: 1}), 422, "invalid-body")
    assert document["where"] == {"field": name}
    assert f'"options": {{"{name}": ...}}' in document["remedy"]
    # Nothing is taken for an option where conditions are stated, or in their usual capitals.
    for stated in ({"conditions": {name: "1"}}, {name.upper(): "1"}):
        assert json.loads(post(json={"samples": samples, **stated}).data)["samples"] == samples


def test_the_settings_bound_the_samples_of_the_surface(post, assert_problem):
    answer = post(json={"samples": [], "options": {"surface_samples": 200_001}})
    document = assert_problem(answer, 422, "invalid-option")
    assert "200000" in document["remedy"]


@pytest.mark.parametrize("body", [b"[]," * 1_000_200, b"{}," * 1_000_200, b"0," * 8_000_001])
def test_json_that_would_fill_the_memory_is_not_decoded(post, assert_problem, body):
    content = b'{"samples": [' + body + b"0]}"
    answer = post(content=content, headers={"Content-Type": "application/json"})
    assert_problem(answer, 422, "too-many-samples")


def test_large_json_is_asked_for_as_a_file(assert_problem, tmp_path):
    """Decoding it would hold up every other request."""
    app = FastAPI()
    add_exception_handlers(app)

    @app.post("/")
    async def read(request: Request) -> None:
        limits = Settings(max_inline_bytes=2000)
        async with submission(request, limits, tmp_path, asyncio.Semaphore(2)):
            pass

    async def request():
        transport = httpx.ASGITransport(app)
        async with httpx.AsyncClient(transport=transport, base_url="http://test") as client:
            return await client.post("/", json={"samples": [[50.0, 0.0, 0.0]] * 200})

    document = assert_problem(asyncio.run(request()), 413, "body-too-large")
    assert document["where"] == {"limit": 2000}
    assert "file" in document["remedy"]


def test_large_files_leave_nothing_on_the_disk(post, tmp_path):
    content = bytes(3_000_000)
    assert post(files={"file": content}).data == content
    post(files={"file": content, "other": content})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("size", "most"), [(2_000_000, 2), (500_000, 6)])
@pytest.mark.slow
def test_few_large_files_are_in_memory_at_a_time(tmp_path, size, most):
    app, large = FastAPI(), asyncio.Semaphore(2)
    inside, seen = [0], []

    @app.post("/")
    async def read(request: Request) -> None:
        async with submission(request, Settings(), tmp_path, large):
            inside[0] += 1
            seen.append(inside[0])
            await asyncio.sleep(0.2)
            inside[0] -= 1

    async def requests():
        transport = httpx.ASGITransport(app)
        async with httpx.AsyncClient(transport=transport, base_url="http://test") as client:
            await asyncio.gather(*(client.post("/", files={"file": bytes(size)}) for _ in range(6)))

    asyncio.run(requests())
    assert len(seen) == 6
    assert max(seen) == most


@pytest.mark.parametrize("coding", ["gzip", "x-gzip", "zstd", "br", "gzip, gzip", "identity, gzip"])
def test_compressed_bodies_are_not_unpacked(post, assert_problem, coding):
    content = gzip.compress(bytes(1_000_000))
    headers = {"Content-Type": "application/json", "Content-Encoding": coding}
    answer = post(content=content, headers=headers)
    document = assert_problem(answer, 415, "unsupported-media-type")
    assert document["where"] == {"header": "Content-Encoding"}
    assert answer.headers["accept-encoding"] == "identity"


@pytest.mark.parametrize("kind", ["data", "files"])
def test_a_form_has_no_more_parts_than_allowed(post, assert_problem, kind):
    answer = post(**{"files": {"file": b"x"}, kind: {f"part{n}": b"x" for n in range(1000)}})
    assert_problem(answer, 413, "body-too-large")


def test_a_large_field_is_too_large(post, assert_problem):
    answer = post(files={"file": b"x"}, data={"options": " " * 70_000})
    assert_problem(answer, 413, "body-too-large")


def test_options_sent_as_a_file_are_bounded_like_others(post, assert_problem):
    options = b'{"gamma": 0.5' + b" " * 70_000 + b"}"
    answer = post(files={"file": b"x", "options": ("options.json", options)})
    assert_problem(answer, 422, "invalid-body")


@pytest.mark.parametrize(
    ("options", "name"),
    [
        ('{"gamma": 0.5, "gamma": 0.1}', "gamma"),
        ('{"gamma": 0.5, "boundary": "usv", "gamma": 0.5}', "gamma"),
        ('{"gamma": 0.5, "g\\u0061mma": 0.1}', "gamma"),
        ('{"centre": {"L": 50, "L": 60}}', "L"),
        ('{"\\ud800": 1, "\\ud800": 2}', None),
    ],
)
def test_members_that_come_twice_are_refused(post, assert_problem, options, name):
    inline = f'{{"samples": [[50, 0, 0]], "options": {options}}}'
    for body in (
        {"files": {"file": b"x"}, "data": {"options": options}},
        {"content": inline, "headers": {"content-type": "application/json"}},
    ):
        found = assert_problem(post(**body), 422, "invalid-body")
        assert "more than one member" in found["detail"]
        assert name is None or found["where"] == {"field": name}


def test_a_body_has_each_member_once(post, assert_problem):
    twice = '{"samples": [[50, 0, 0]], "options": {}, "options": {"gamma": 0.5}}'
    answer = post(content=twice, headers={"content-type": "application/json"})
    assert assert_problem(answer, 422, "invalid-body")["where"] == {"field": "options"}
