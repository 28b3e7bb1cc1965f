"""The command lines of the documents: none is refused, and each writes its file."""

import itertools
import re
import shlex
from pathlib import Path

import pytest
from PIL import Image

ROOT = Path(__file__).parents[3]
SHELL_BLOCK = re.compile(r"^```(?:sh|bash|console|shell)\n(.*?)^```", re.MULTILINE | re.DOTALL)

NOT_RUN = {
    "key": "writes a key of the service",
    "serve": "the service, which tests of its own start",
    "worker": "the build worker, which tests of its own start",
}
"""Commands of the service, with the reason why they are not run here."""

FEW = {"link": ["--size", "9"], "profile": ["--size", "9"]}
"""Fewer nodes of tables than printed, which take minutes."""


def documented_commands(document):
    """Return the arguments of each line of shell blocks that begins with `gamut`."""
    lines = [
        line
        for block in SHELL_BLOCK.findall(document.read_text())
        for line in block.replace("\\\n", " ").splitlines()
    ]
    commands = [shlex.split(line, comments=True) for line in lines]
    return [words[1:] for words in commands if words[:1] == ["gamut"]]


def coarse(arguments):
    """Return a command with few samples and nodes; saved gamuts have their own."""
    sizes = FEW.get(arguments[0], [])
    if sizes and sizes[0] in arguments:
        place = arguments.index(sizes[0])
        arguments = arguments[:place] + arguments[place + 2 :]
    reads_saved = any(
        argument.endswith(".gamut") and before not in {"-o", "--output"}
        for before, argument in itertools.pairwise(arguments)
    )
    has_samples = "--surface-samples" in arguments or arguments[0] in {"reference", "signals"}
    samples = [] if reads_saved or has_samples else ["--surface-samples", "2000"]
    return [*arguments, *sizes, *samples]


DOCUMENTS = [
    document
    for document in sorted([ROOT / "README.md", *(ROOT / "docs").rglob("*.md")])
    if any(words[0] not in NOT_RUN for words in documented_commands(document))
]


@pytest.mark.slow
@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_no_documented_command_is_refused(document, command, few_patches, tmp_path, monkeypatch):
    (tmp_path / "examples").mkdir()
    for path in (ROOT / "examples").iterdir():
        (tmp_path / "examples" / path.name).symlink_to(path)
    (tmp_path / "gamutcore").symlink_to(ROOT / "gamutcore")
    press = tmp_path / "examples" / "FOGRA39L.ti3"
    press.unlink()
    press.write_bytes(few_patches)
    Image.new("RGB", (8, 8), (200, 60, 20)).save(tmp_path / "photo.png")
    chart = ROOT / "tests" / "data" / "reports" / "chart-cmyk.ti1"
    (tmp_path / "chart.ti1").write_bytes(chart.read_bytes())
    for day in ("monday", "friday"):
        (tmp_path / f"{day}.ti3").write_bytes(few_patches)
    monkeypatch.chdir(tmp_path)
    for arguments in documented_commands(document):
        if arguments[0] in NOT_RUN:
            continue
        command(*coarse(arguments))
        if "-o" in arguments:
            output = Path(arguments[arguments.index("-o") + 1])
            assert output.stat().st_size > 0, arguments


def test_the_documents_have_commands():
    assert {document.name for document in DOCUMENTS} >= {"README.md", "command-line.md"}
