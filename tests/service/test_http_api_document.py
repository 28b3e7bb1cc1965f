"""The lines of docs/http-api.md do what the page says."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def test_every_line_of_the_page_works(server, tmp_path):
    if shutil.which("curl") is None:
        pytest.skip("curl is not installed")
    text = (ROOT / "docs" / "http-api.md").read_text()
    script = "".join(re.findall(r"```sh\n(.*?)```", text, re.DOTALL))
    script = script.replace("http://127.0.0.1:8000", server.url)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    answer = subprocess.run(
        ["sh", "-e", "-c", script], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    statuses = re.findall(r"HTTP/1\.1 (\d+)", answer.stdout)
    assert [status[0] for status in statuses] == ["2"] * 7
    assert statuses[3:] == ["202", "204", "200", "200"]
    assert (tmp_path / "FOGRA39L.glb").read_bytes()[:4] == b"glTF"
    assert (tmp_path / "FOGRA39L.ply").read_bytes()[:3] == b"ply"
    assert (tmp_path / "FOGRA39L.stl").stat().st_size == 84 + 50 * 1000
    assert (tmp_path / "FOGRA39L.gamut").stat().st_size > 10**6
    assert '"code":"invalid-option"' in answer.stdout
