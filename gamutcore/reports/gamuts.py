"""Many gamuts, asked one after the other: names, files, threads and progress.

A saved gamut is opened when its turn comes, and only as much of its file is read as its level
needs. Kernels release the interpreter's lock, so threads share the work.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias, TypeVar

from gamutcore.content import is_saved_gamut
from gamutcore.errors import OptionError
from gamutcore.gamut import Gamut, load_level, stored_level
from gamutcore.references import find_reference

__all__ = [
    "GamutSource",
    "NamedGamut",
    "Progress",
    "distinct_name",
    "in_order",
    "named_gamuts",
    "open_level",
]

GamutSource: TypeAlias = Gamut | str | os.PathLike[str]
"""A gamut, the path of a file, or the name of a reference."""

Progress: TypeAlias = Callable[[str, float], None]
"""Takes what was done and the fraction of the whole."""

THREADS = min(os.cpu_count() or 1, 8)

Item = TypeVar("Item")
Value = TypeVar("Value")


class NamedGamut(NamedTuple):
    """A gamut, or the path of a saved one, and a name that no other gamut of the table has."""

    name: str
    source: Gamut | Path


def named_gamuts(sources: Iterable[GamutSource], options: dict[str, Any]) -> Iterator[NamedGamut]:
    """Yield gamuts by names that differ; other files than saved gamuts are built here."""
    if isinstance(sources, Gamut | str | os.PathLike):
        raise OptionError.refusal("gamuts", str(sources)[:80], "a list of gamuts")
    names: set[str] = set()
    for source in sources:
        gamut: Gamut | Path
        if isinstance(source, Gamut):
            gamut, name = source, source.name
        elif Path(source).exists():
            path = Path(source)
            name = path.stem
            with path.open("rb") as file:
                saved = is_saved_gamut(file.read(64))
            gamut = path if saved else Gamut(path, options)
        elif isinstance(source, str):
            name, gamut = source, Gamut(find_reference(source).data, options)
        else:
            raise FileNotFoundError(2, "There is no such file.", str(source))
        yield NamedGamut(distinct_name(name or "gamut", names), gamut)


def distinct_name(name: str, names: set[str]) -> str:
    """Return a name, with a number if it is among `names`, and add it to these."""
    distinct, number = name, 1
    while distinct in names:
        number += 1
        distinct = f"{name} ({number})"
    names.add(distinct)
    return distinct


def open_level(
    gamut: NamedGamut,
    *,
    triangles: int | None = None,
    max_error: float | None = None,
    whole: bool = False,
) -> tuple[Gamut, int]:
    """Return a gamut and the triangle count of the level to ask; `whole` with the device model."""
    source = gamut.source
    if isinstance(source, Path):
        if not whole:
            return load_level(source, triangles, max_error)
        source = Gamut.load(source)
    return source, stored_level(source.description, triangles, max_error)


def in_order(function: Callable[[Item], Value], items: Iterable[Item]) -> Iterator[Value]:
    """Yield the values of a function in the order of the items, computed by a few threads.

    Items are taken when a thread is free, so that few of them are in memory. An interrupt waits
    for the calls that have begun.
    """
    begun: deque[Future[Value]] = deque()
    with ThreadPoolExecutor(THREADS) as threads:
        try:
            for item in items:
                begun.append(threads.submit(function, item))
                if len(begun) > THREADS:
                    yield begun.popleft().result()
            while begun:
                yield begun.popleft().result()
        finally:
            threads.shutdown(wait=False, cancel_futures=True)
