import gzip
import hashlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.http.compression import CODINGS, compress, compress_response, preferred_coding, zstd
from service.problems.problem import JsonResponse

DECODERS = {"gzip": gzip.decompress, "zstd": zstd.decompress, None: bytes}


@pytest.mark.parametrize(
    ("field", "expected"),
    [
        ("", ""),
        ("gzip", "gzip"),
        ("zstd", "zstd"),
        ("GZIP", "gzip"),
        ("br", ""),
        ("gzip, deflate, br, zstd", "zstd"),
        ("gzip;q=1.0, zstd;q=0.9", "gzip"),
        ("gzip;q=0.5, zstd;q=0.5", "zstd"),
        ("*", "zstd"),
        ("*, zstd;q=0", "gzip"),
        ("*;q=0", ""),
        ("identity", ""),
        ("identity, gzip", "gzip"),
        ("identity, gzip;q=0.5", ""),
        ("identity;q=0.5, gzip;q=0.6", "gzip"),
        ("identity;q=0, br", ""),
        ("gzip;q=0", ""),
        ("gzip;q=nonsense", "gzip"),
    ],
)
def test_codings_are_negotiated(field, expected):
    assert preferred_coding(field.encode()) == expected


@given(st.binary(max_size=50))
def test_any_field_gets_an_answer(field):
    assert preferred_coding(field) in {*CODINGS, ""}


@pytest.mark.parametrize("coding", CODINGS)
@given(content=st.binary(max_size=3000))
def test_content_comes_back_and_is_always_coded_alike(coding, content):
    coded = compress(content, coding)
    assert DECODERS[coding](coded) == content
    assert compress(content, coding) == coded


def test_short_content_is_left_as_it_is():
    short, long = JsonResponse("x" * 100), JsonResponse("x" * 10_000)
    for response in (short, long):
        compress_response(response, ["gzip"])
        assert response.headers["vary"] == "Accept-Encoding"
        assert response.headers["content-length"] == str(len(response.body))
    assert "content-encoding" not in short.headers
    assert long.headers["content-encoding"] == "gzip"


@pytest.mark.parametrize("what", ["self", "mesh", "levels", "mesh.obj"])
def test_every_coding_is_a_representation_of_its_own(server, gamut, what):
    address = gamut["links"].get(what) or gamut["links"]["mesh"] + ".obj"
    seen = {}
    for accepted in ("identity", "gzip", "zstd"):
        headers = {"Accept-Encoding": accepted}
        with server.client.stream("GET", address, headers=headers) as answer:
            body = b"".join(answer.iter_raw())
        assert answer.headers.get("content-encoding", "identity") == accepted
        assert answer.headers["etag"] == f'"{hashlib.sha256(body).hexdigest()}"'
        assert "Accept-Encoding" in answer.headers["vary"]
        assert int(answer.headers["content-length"]) == len(body)
        content = DECODERS[answer.headers.get("content-encoding")](body)
        seen[answer.headers["etag"]] = (content, len(body))
        again = server.client.get(
            address, headers={**headers, "If-None-Match": answer.headers["etag"]}
        )
        assert again.status_code == 304
        assert again.headers["etag"] == answer.headers["etag"]
        assert again.headers["vary"] == answer.headers["vary"]
    assert len(seen) == 3
    assert len({content for content, _ in seen.values()}) == 1
    sizes = [size for _, size in seen.values()]
    assert sizes[0] > max(sizes[1:])


def test_large_meshes_are_compressed_as_well(server, sphere):
    gamut = server.client.post("/v1/gamuts", json={"samples": sphere(seed=33, count=3000)}).json()
    address = f"{gamut['links']['mesh']}?triangles={gamut['counts']['triangles']}&format=ply"
    plain = server.client.get(address)
    assert int(plain.headers["gamut-triangles"]) > 4000
    for coding in CODINGS:
        with server.client.stream("GET", address, headers={"Accept-Encoding": coding}) as answer:
            body = b"".join(answer.iter_raw())
        assert answer.headers["content-encoding"] == coding
        assert DECODERS[coding](body) == plain.content


def test_histories_are_not_compressed(server, gamut):
    answer = server.client.get(gamut["links"]["history"], headers={"Accept-Encoding": "gzip, zstd"})
    assert "content-encoding" not in answer.headers
