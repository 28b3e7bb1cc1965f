"""Modules of the viewer that need no page, run by Node.js on what `gamutcore` computes."""

import base64
import io
import json
import os
import subprocess
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
from PIL import Image

from gamutcore.colours import ColourSpace
from gamutcore.colours.colorimetry import (
    ICC_D50,
    adaptation_matrix,
    lab_to_xyz,
    rgb_to_xyz,
    white_point,
)
from gamutcore.colours.spaces import SPACES, linear_srgb

TESTS = Path(__file__).parents[2] / "web" / "viewer" / "tests"

P3 = ((0.68, 0.32), (0.265, 0.69), (0.15, 0.06))
"""Primaries of Display P3 (SMPTE EG 432-1)."""

VIEWING = {"adapting_luminance": 60.0, "background": 35.0, "surround": "dim"}
PARAMETERS = {
    "CAM16-UCS": VIEWING,
    "CAM02-UCS": {**VIEWING, "surround": "dark"},
    "ICtCp": {"luminance": 100.0},
    "ITP": {"luminance": 1000.0},
    "Jzazbz": {"luminance": 80.0},
}


def run(command, **environment):
    ended = subprocess.run(
        command, env={**os.environ, **environment}, check=False, capture_output=True, text=True
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert "# fail 0" in ended.stdout


def case(space, lab):
    coordinates = np.float32(space.coordinates(lab)[0])
    shown = space.appearance_lab(coordinates)
    d65 = white_point("D65")
    to_d50 = adaptation_matrix(d65, ICC_D50, "Bradford") @ rgb_to_xyz(P3, d65)
    p3 = lab_to_xyz(shown) @ np.linalg.inv(to_d50).T
    return {
        "description": space.description(),
        "coordinates": coordinates.ravel().tolist(),
        "lab": shown.ravel().tolist(),
        "srgb": linear_srgb(shown).ravel().tolist(),
        "p3": p3.ravel().tolist(),
    }


def test_colour_spaces(typescript_program, tmp_path):
    rng = np.random.default_rng(35)
    ball = rng.normal(size=(60, 3))
    ball *= 45.0 / np.linalg.norm(ball, axis=1, keepdims=True)
    lab = np.vstack([ball + np.array([50.0, 0, 0]), [(100, 0, 0), (0, 0, 0), (87, -86, 83)]])
    cases = []
    for name in SPACES:
        given = PARAMETERS.get(name, {})
        cases.append(case(ColourSpace(name), lab))
        for white, adaptation in (("A", "CAT16"), ((0.9, 1.0, 1.2), "none"), ("D50", "CAT02")):
            other = ColourSpace(name, reference_white=white, adaptation=adaptation, **given)
            cases.append(case(other, lab))
    path = tmp_path / "spaces.json"
    path.write_text(json.dumps(cases))
    run(typescript_program(TESTS / "spaces.test.ts"), SPACES=str(path))


def test_charts(typescript_program, tmp_path):
    run(typescript_program(TESTS / "charts.test.ts"), CHARTS=str(tmp_path))
    paths = sorted(tmp_path.glob("*.svg"))
    assert len(paths) == 16
    for path in paths:
        root = ET.parse(path).getroot()  # noqa: S314 (made by the test)
        width, height = float(root.get("width")), float(root.get("height"))
        for element in root.iter():
            size = element.get("font-size")
            assert size is None or float(size) >= 11.0, path
            if element.tag.endswith("}text") and element.get("x") is not None:
                assert 0.0 <= float(element.get("x")) <= width, path
                assert 0.0 <= float(element.get("y")) <= height, path
            if element.tag.endswith("}image"):
                data = element.get("href").removeprefix("data:image/png;base64,")
                picture = Image.open(io.BytesIO(base64.b64decode(data)))
                picture.load()  # checks sums and sizes
                assert picture.mode == "RGBA"
