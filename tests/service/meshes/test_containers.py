import email.policy
import io
import json
import zipfile
from email.parser import BytesParser

import pytest

from service.meshes.containers import Asked, Item, MultipartContainer, ZipContainer
from service.meshes.encoding import EncodedMesh
from service.problems.problem import Problem

A, B = "0a" * 32, "0b" * 32


def mesh(triangles, content):
    return EncodedMesh.of(content, "model/stl", ("a", ".stl"), triangles, triangles // 2 + 2)


ITEMS = [
    Item(Asked(A, "triangles", "100", "stl"), mesh(100, b"one")),
    Item(Asked(A, "triangles", "101", "stl"), mesh(100, b"one")),
    Item(Asked(A, "triangles", "2", "stl"), None, Problem("triangle-count", "too few")),
    Item(Asked(B, "max_error", "0.5", "stl"), mesh(8, bytes(100_000))),
]


def written(kind, items=ITEMS):
    container = kind([item.asked for item in items])
    content = b"".join(part for item in items for part in container.parts(item))
    return container.media_type, content + b"".join(container.end())


def test_other_programs_unpack_the_archive():
    _, content = written(ZipContainer)
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        assert archive.testzip() is None
        assert archive.namelist() == [f"{A}/100.stl", f"{B}/8.stl", "index.json"]
        assert archive.read(f"{A}/100.stl") == b"one"
        assert archive.read(f"{B}/8.stl") == bytes(100_000)
        for info in archive.infolist():
            assert info.compress_type == zipfile.ZIP_STORED
            assert info.date_time == (1980, 1, 1, 0, 0, 0)
            assert info.external_attr >> 16 == 0o100644
            assert info.flag_bits == 0  # sizes in front, which all readers of streams need


def test_the_index_accounts_for_everything_that_was_asked_for():
    _, content = written(ZipContainer)
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        index = json.loads(archive.read("index.json"))["meshes"]
    assert [entry.get("file") for entry in index] == [f"{A}/100.stl"] * 2 + [None, f"{B}/8.stl"]
    assert [entry.get("triangles") for entry in index] == [100, 101, 2, None]
    assert index[2]["problem"]["code"] == "triangle-count"
    assert index[3]["max_error"] == 0.5
    assert index[3]["counts"] == {"triangles": 8, "vertices": 6}
    assert index[0]["sha256"] == mesh(100, b"one").etag.strip('"')


def test_mail_programs_read_the_message():
    media_type, content = written(MultipartContainer)
    head = f"Content-Type: {media_type}\r\nMIME-Version: 1.0\r\n\r\n".encode()
    message = BytesParser(policy=email.policy.HTTP).parsebytes(head + content)
    parts = list(message.iter_parts())
    assert not message.defects
    assert [part.get_content_type() for part in parts] == [
        "model/stl",
        "model/stl",
        "application/problem+json",
        "model/stl",
    ]
    assert parts[3].get_payload(decode=True) == bytes(100_000)
    assert parts[0]["Gamut-Triangles"] == "100"
    assert parts[0]["ETag"] == mesh(100, b"one").etag
    assert parts[2]["Content-Location"] == f"/v1/gamuts/{A}/mesh?triangles=2&format=stl"
    assert json.loads(parts[2].get_payload(decode=True))["status"] == 422


@pytest.mark.parametrize("kind", [ZipContainer, MultipartContainer])
def test_the_same_meshes_make_the_same_bytes(kind):
    assert written(kind) == written(kind)


def test_another_question_has_another_boundary():
    assert written(MultipartContainer)[0] != written(MultipartContainer, ITEMS[:2])[0]
