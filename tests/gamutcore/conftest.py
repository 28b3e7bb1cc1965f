"""Fixtures that the tests of several parts of the compute package use."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from collections.abc import Callable

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of the real and malformed files that are shared beside the checkout."""
    folder = ROOT.parent / "shared" / "data"
    if not folder.is_dir():
        pytest.skip("the shared data folder is not beside this checkout")
    return folder


@pytest.fixture(scope="session")
def fogra39() -> bytes:
    """FOGRA39L, a real press: 1617 CMYK patches with XYZ and Lab."""
    return (ROOT / "examples" / "FOGRA39L.ti3").read_bytes()


@pytest.fixture(scope="session")
def small_profile() -> Callable[[str], bytes]:
    """Return a function from a name to one of the CC0 profiles of the tests."""
    return lambda name: (ROOT / "tests" / "data" / name).read_bytes()


@pytest.fixture(scope="session")
def made_profile() -> Callable[..., bytes]:
    """Return a function that puts an ICC profile together from its tags."""

    def make(
        tags: dict[str, bytes],
        *,
        space: str = "RGB ",
        pcs: str = "Lab ",
        kind: str = "prtr",
        version: int = 4,
    ) -> bytes:
        offset = 132 + 12 * len(tags)
        table, body = b"", b""
        for tag, data in tags.items():
            table += struct.pack(">4sII", tag.encode("latin-1"), offset + len(body), len(data))
            body += data + bytes(-len(data) % 4)
        header = bytearray(128)
        header[0:4] = struct.pack(">I", offset + len(body))
        header[8] = version
        header[12:24] = (kind + space + pcs).encode("latin-1")
        header[36:40] = b"acsp"
        return bytes(header) + struct.pack(">I", len(tags)) + table + body

    return make
