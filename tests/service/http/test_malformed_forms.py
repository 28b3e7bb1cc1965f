"""Forms that a parser refuses: every fault is a problem of the client."""

import pytest

from service.application import create_app
from service.settings import Settings

PART = b'Content-Disposition: form-data; name="file"; filename="a"\r\n'


@pytest.fixture(scope="module")
def app(tmp_path_factory):
    return create_app(Settings(store=str(tmp_path_factory.mktemp("forms") / "data")))


def form(boundary=b"x", head=PART):
    return b"--%b\r\n%b\r\nabc\r\n--%b--\r\n" % (boundary, head, boundary)


# RFC 2046, section 5.1.1, allows boundaries of up to 70 characters.
FORMS = {
    "a boundary of 257 characters": (b"b" * 257, form(b"b" * 257)),
    "a boundary of 300 characters": (b"b" * 300, form(b"b" * 300)),
    "an empty boundary": (b"", form(b"")),
    "another boundary": (b"y", form()),
    "a name of a field with a null": (b"x", form(head=PART + b"A\0: b\r\n")),
    "a long field": (b"x", form(head=PART + b"A: " + b"b" * 100_000 + b"\r\n")),
    "many fields": (b"x", form(head=PART + b"A: b\r\n" * 1000)),
    "no name": (b"x", form(head=b"Content-Disposition: form-data\r\n")),
    "bytes": (b"x", b"\xff" * 5000),
}


@pytest.mark.parametrize("name", FORMS)
def test_a_malformed_form_is_the_fault_of_the_client(app, request_app, assert_problem, name):
    boundary, content = FORMS[name]
    fields = {"Content-Type": b"multipart/form-data; boundary=" + boundary}
    answer = request_app(app, "POST", "/v1/gamuts", headers=fields, content=content)
    assert_problem(answer, 400, "malformed-body")
