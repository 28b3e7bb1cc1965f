"""Files of the package as answers: coding, entity tag and conditional requests."""

import gzip
from pathlib import Path

from starlette.datastructures import Headers

from service.http.conditional import IMMUTABLE
from service.routes.static_files import static_file

NAME = "swagger-ui/LICENSE"
CONTENT = (Path(__file__).parents[3] / "service" / "static" / NAME).read_bytes()


def answered(**fields):
    return static_file(Headers(fields), NAME, "text/plain")


def test_the_client_chooses_the_coding():
    plain, small = answered(), answered(**{"accept-encoding": "gzip"})
    assert plain.body == CONTENT
    assert "content-encoding" not in plain.headers
    assert gzip.decompress(small.body) == CONTENT
    assert small.headers["content-encoding"] == "gzip"
    assert small.headers["etag"] != plain.headers["etag"]
    for answer in (plain, small):
        assert answer.headers["vary"] == "Accept-Encoding"
        assert answer.headers["cache-control"] == IMMUTABLE
        assert answer.headers["x-content-type-options"] == "nosniff"


def test_known_content_is_not_sent_again():
    etag = answered().headers["etag"]
    assert answered(**{"if-none-match": f'"other", {etag}'}).status_code == 304
    assert answered(**{"if-none-match": '"other"'}).status_code == 200
