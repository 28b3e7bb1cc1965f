"""The npm package ``web/boundary``: it answers as `gamutcore` does, and can be installed."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from gamutcore import Gamut, __version__, reference
from gamutcore.search import contains, leaves, map_colours, nearest, signed_distance

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "web" / "boundary"

FILES = {
    "FOGRA39L": ROOT / "examples" / "FOGRA39L.ti3",
    "FOGRA29L": ROOT / "examples" / "FOGRA29L.ti3",
    "television": ROOT / "examples" / "Panasonic-TV.icc",
    "Display P3 profile": ROOT / "tests" / "data" / "DisplayP3-v4.icc",
}
REFERENCES = ("srgb", "bt2020", "pointer", "optimal-colours-d50-2")


def run(command, **environment):
    ended = subprocess.run(
        command, env={**os.environ, **environment}, check=False, capture_output=True, text=True
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr
    return ended.stdout


@pytest.mark.slow
def test_the_reader(typescript_program, tmp_path):
    gamut = Gamut(FILES["FOGRA39L"], surface_samples=2000)
    path = tmp_path / "history"
    path.write_bytes(gamut.to_bytes())
    assert "# fail 0" in run(
        typescript_program(PACKAGE / "tests" / "reader.test.ts"), HISTORY=str(path)
    )


@pytest.mark.slow
def test_answers_about_plain_arrays(typescript_program):
    assert "# fail 0" in run(typescript_program(PACKAGE / "tests" / "boundary.test.ts"))


@pytest.fixture(scope="module")
def answers(typescript_program, tmp_path_factory):
    """Return a function from a gamut, a triangle count and questions to JavaScript's answers."""
    program = typescript_program(PACKAGE / "tests" / "answers.ts")

    def ask(gamut, triangles, colours, lightness, hues):
        folder = tmp_path_factory.mktemp("answers")
        (folder / "history").write_bytes(gamut.to_bytes())
        questions = {"colours": colours, "lightness": lightness, "hues": hues}
        asked = {name: np.asarray(values).tolist() for name, values in questions.items()}
        (folder / "questions.json").write_text(json.dumps(asked))
        paths = [str(folder / "history"), str(triangles), str(folder / "questions.json")]
        return json.loads(run([*program, *paths]))

    return ask


@pytest.mark.slow
@pytest.mark.parametrize("name", [*FILES, *REFERENCES, "Oklab"])
def test_answers_are_those_of_the_core(name, answers):
    if name in FILES:
        gamut = Gamut(FILES[name], surface_samples=2000)
    elif name == "Oklab":
        gamut = reference("srgb", space="Oklab", surface_samples=2000)
    else:
        gamut = reference(name, surface_samples=2000)
    count = min(1000, gamut.history.triangles)
    level = gamut.level(count)
    mesh = (level.vertices, level.faces, gamut.history.centre)
    low, high = level.vertices.min(axis=0), level.vertices.max(axis=0)
    size = float(np.linalg.norm(high - low))
    rng = np.random.default_rng(50)
    # half of the colours are near the surface, where answers differ most easily
    anywhere = rng.uniform(low - 0.2 * (high - low), high + 0.2 * (high - low), (5000, 3))
    surface = nearest(rng.uniform(low, high, (5000, 3)), mesh).points
    colours = np.vstack([anywhere, surface + rng.normal(0.0, 1e-3 * size, (5000, 3))])
    hues = np.arange(7.0, 360.0, 15.0)
    lightness = np.linspace(low[0], high[0], 25)[1:-1] + 0.0137 * (high[0] - low[0])
    found = answers(gamut, count, colours, lightness, hues)

    distance = signed_distance(colours, mesh)
    certain = np.abs(distance) > 1e-6
    assert certain.mean() > 0.99
    assert found["triangles"] == len(level.faces)
    assert found["volume"] == pytest.approx(level.volume, rel=1e-9)
    # the bound of the next coarser level in the history's error curve
    assert found["tolerance"] >= gamut.tolerance(triangles=count) - 1e-9
    inside = contains(colours, mesh)
    assert 0.1 < inside.mean() < 0.9
    assert np.array_equal(np.array(found["inside"])[certain], inside[certain])
    edge = np.abs(distance - 2.0) > 1e-6
    assert np.array_equal(np.array(found["within"])[edge], contains(colours, mesh, 2.0)[edge])
    assert np.abs(np.abs(found["distance"]) - np.abs(distance)).max() < 1e-9 * size
    # where two points are equally near, either is right
    points, ours = nearest(colours, mesh), np.array(found["nearest"])
    apart = np.linalg.norm(ours - points.points, axis=1)
    tied = np.abs(np.linalg.norm(ours - colours, axis=1) - points.distance) < 1e-12 * size
    assert np.all((apart < 1e-6) | tied)
    assert (apart < 1e-6).mean() > 0.999
    centre = map_colours(colours, mesh, "clip-focal", focus=gamut.history.centre)
    assert np.abs(found["centre"] - centre.points)[certain].max() < 1e-6
    assert found["clipped"]

    kept = map_colours(colours, mesh, "clip-chroma").points
    ours = np.array(found["chroma"])
    # the core maps by another method where a hue has no colour between its own and the axis
    same = (np.abs(kept[:, 0] - colours[:, 0]) < 1e-9 * size) | (np.hypot(*kept[:, 1:].T) < 1e-9)
    assert same.mean() > 0.9
    assert (np.linalg.norm(ours - kept, axis=1)[same & certain] < 1e-6 * size).mean() > 0.999

    table = leaves(mesh, hues, lightness)
    for i, row in enumerate(found["table"]):
        for j, intervals in enumerate(row):
            cell = i * len(lightness) + j
            expected = table.chroma[table.offsets[cell] : table.offsets[cell + 1]]
            assert np.array(intervals).reshape(-1, 2) == pytest.approx(expected, abs=1e-6 * size)


@pytest.mark.slow
def test_the_packed_package_answers_in_a_fresh_folder(tmp_path):
    npm = shutil.which("npm")
    compiler = ROOT / "web" / "node_modules" / "typescript" / "bin" / "tsc"
    if npm is None or not compiler.exists():
        pytest.skip("npm and the packages of web/ are needed")
    packed = json.loads(
        run([npm, "pack", "--json", f"--pack-destination={tmp_path}", str(PACKAGE)])
    )[0]
    names = {file["path"] for file in packed["files"]}
    assert {"LICENSE", "README.md", "package.json", "dist/index.js", "dist/index.d.ts"} <= names
    assert not any("tests" in name or "src" in name for name in names)
    page = tmp_path / "page"
    page.mkdir()
    (page / "package.json").write_text('{"private": true, "type": "module"}')
    archive = tmp_path / packed["filename"]
    run([npm, "install", "--prefix", str(page), "--offline", "--no-audit", str(archive)])
    (page / "srgb.gamut").write_bytes(reference("srgb", surface_samples=1000).to_bytes())
    program = """\
import { readFileSync } from "node:fs";
import { Boundary, History } from "@gamut/boundary";

const history: History = await History.from(new Uint8Array(readFileSync("srgb.gamut")));
const boundary = Boundary.of(history, 500);
const intervals: [number, number][] = boundary.chroma(50, 40);
const [inside, outside] = [[53.2, 80, 67], [53.2, 60, -120]].map((lab) => boundary.contains(lab));
console.log(inside, outside, intervals.length);
"""
    (page / "page.ts").write_text(program)
    reader = "export function readFileSync(path: string): Uint8Array;"
    (page / "node.d.ts").write_text(f'declare module "node:fs" {{ {reader} }}')
    options = ["--strict", "--target", "es2023", "--module", "nodenext"]
    ended = subprocess.run(
        ["node", str(compiler), *options, "page.ts", "node.d.ts"],
        cwd=page,
        check=False,
        capture_output=True,
        text=True,
    )
    assert ended.returncode == 0, ended.stdout
    answered = subprocess.run(
        ["node", "page.js"], cwd=page, check=True, capture_output=True, text=True
    )
    assert answered.stdout.split() == ["true", "false", "1"]


def test_the_version_is_that_of_the_project_and_nothing_is_needed():
    package = json.loads((PACKAGE / "package.json").read_text())
    assert package["version"] == __version__
    assert "dependencies" not in package
