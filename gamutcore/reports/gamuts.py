"""Many gamuts, asked one after the other: names, files, threads and progress.

A saved gamut is opened when its turn comes, and only as much of its file is read as its level
needs. Kernels release the interpreter's lock, so threads share the work.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from itertools import repeat
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias, TypeVar

from gamutcore.building import fitting_options
from gamutcore.content import gamut_source, is_saved_gamut
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
    """Yield gamuts by names that differ; other files than saved gamuts are built here.

    They are built with those of the options that apply to them. An option that applies to none is
    refused before the first is built.
    """
    if isinstance(sources, Gamut | str | os.PathLike):
        raise OptionError.refusal("gamuts", str(sources)[:80], "a list of gamuts")
    choices: Iterable[dict[str, Any]] = repeat({})
    if options:
        sources = list(sources)
        choices = fitting_options(map(_content, sources), options)
    names: set[str] = set()
    for source, fitting in zip(sources, choices, strict=False):
        gamut: Gamut | Path
        if isinstance(source, Gamut):
            gamut, name = source, source.name
        elif Path(source).exists():
            path = Path(source)
            name = path.stem
            gamut = path if _is_saved(path) else Gamut(path, fitting)
        elif isinstance(source, str):
            name, gamut = source, Gamut(find_reference(source).data, fitting)
        else:
            raise FileNotFoundError(2, "There is no such file.", str(source))
        yield NamedGamut(distinct_name(name or "gamut", names), gamut)


def _content(source: GamutSource) -> tuple[object, bytes | None]:
    """Return the name of a gamut, and the data that it is built from if it is not built yet."""
    if isinstance(source, Gamut):
        return source.name or "a gamut", None
    if Path(source).exists() and _is_saved(Path(source)):
        return source, None
    data = gamut_source(source)
    return source, data if isinstance(data, bytes) else data.data


def _is_saved(path: Path) -> bool:
    with path.open("rb") as file:
        return is_saved_gamut(file.read(64))


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
