from pathlib import Path

from gamutcore.characterisation import FORMATS
from gamutcore.characterisation.formats import format_summary
from gamutcore.characterisation.pictures.raster import EXTENSIONS

DOCUMENT = Path(__file__).parents[3] / "docs" / "characterisation.md"


def row(entry):
    media_type = entry.media_types[0] if entry.media_types else "–"
    extensions = " ".join(entry.extensions)
    cells = (entry.title, entry.kind, extensions, media_type, entry.recognition)
    return f"| {' | '.join(cells)} |"


def test_the_table_of_the_document_has_all_formats():
    lines = DOCUMENT.read_text().splitlines()
    start = lines.index("|---|---|---|---|---|") + 1
    assert lines[start : start + len(FORMATS)] == [row(entry) for entry in FORMATS]
    assert not lines[start + len(FORMATS)].startswith("|")


def test_names_are_distinct_and_all_pictures_have_a_decoder():
    assert len({entry.name for entry in FORMATS}) == len(FORMATS)
    assert {entry.name for entry in FORMATS if entry.kind == "picture"} == set(EXTENSIONS)


def test_messages_name_all_formats():
    said = format_summary()
    assert all(entry.title.partition(":")[0] in said for entry in FORMATS)
