import json

import pytest

from service.problems.responses import JsonResponse


@pytest.mark.parametrize("text", ["plain", "\ud800", "é\n\0", "\U0001f308"])
def test_any_text_comes_back_from_one_line_of_ascii(text):
    response = JsonResponse({text: [text]})
    body = bytes(response.body)
    assert body.isascii()
    assert body.endswith(b"\n")
    assert body.count(b"\n") == 1
    assert json.loads(body) == {text: [text]}
    assert response.headers["content-length"] == str(len(body))


def test_what_json_cannot_express_is_not_sent():
    with pytest.raises(ValueError, match="JSON"):
        JsonResponse({"volume": float("nan")})
