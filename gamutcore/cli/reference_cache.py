"""Reference gamuts that earlier commands built, in the user's cache directory.

A wheel may bring some in `BUILT`, so that the first command need not build them.

A file is named after the gamut's id, which contains the options, the definition and the version of
the algorithm, in a folder of the program's version. It appears by one rename, so processes may read
and write at the same time. A file that cannot be read is built again, and a directory that cannot
be written is not used.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from gamutcore.version import __version__

if TYPE_CHECKING:
    from gamutcore.gamut import Gamut
    from gamutcore.options import Options
    from gamutcore.references import Reference

__all__ = ["BUILT", "CACHE_VARIABLE", "cache_directory", "cached_reference"]

BUILT = Path(__file__).parents[1] / "references" / "built"
"""Reference gamuts that came with the installation; ``.ci/wheels.py`` makes them."""

CACHE_VARIABLE = "GAMUTCORE_CACHE_DIR"
"""Names another directory; empty to keep nothing."""

MOST_FILES = 64
"""Files to keep, those that were used last. A reference takes about one megabyte."""


def cache_directory() -> Path | None:
    """Return the directory of the cache; None if it is switched off."""
    chosen = os.environ.get(CACHE_VARIABLE)
    if chosen is None:
        from platformdirs import user_cache_path  # noqa: PLC0415

        return user_cache_path("gamut-boundary-service", appauthor=False, version=__version__)
    return Path(chosen) / __version__ if chosen else None


def cached_reference(reference: Reference, options: Options, build: Callable[[], Gamut]) -> Gamut:
    """Return a reference gamut of these options from the cache, or build and keep it."""
    from gamutcore.building import gamut_id  # noqa: PLC0415

    name = f"{gamut_id(options, reference.sha256)}.gamut"
    folder = cache_directory()
    gamut = _read(BUILT / name) or (_read_checked(folder / name) if folder else None)
    # files of earlier versions have no device model
    if gamut is not None and (gamut.has_device_model or not gamut.is_of_device):
        return gamut
    gamut = build()
    if folder:
        with suppress(OSError):
            _write(folder / name, gamut.to_bytes(device_model=True))
    return gamut


def _read(path: Path) -> Gamut | None:
    from gamutcore.errors import HistoryFileError  # noqa: PLC0415
    from gamutcore.gamut import Gamut  # noqa: PLC0415

    try:
        gamut = Gamut.load(path)
    except (OSError, HistoryFileError):
        return None
    return gamut if gamut.id == path.stem else None


def _read_checked(path: Path) -> Gamut | None:
    """Read all groups as well, so that damage is noticed and the gamut built again."""
    from gamutcore.errors import HistoryFileError  # noqa: PLC0415

    gamut = _read(path)
    if gamut is not None:
        try:
            gamut.history.level(gamut.history.triangles)
        except HistoryFileError:
            return None
        with suppress(OSError):
            os.utime(path)
    return gamut


def _write(path: Path, data: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as file:
        draft = Path(file.name)
        try:
            file.write(data)
            file.flush()
            draft.replace(path)
        except BaseException:
            draft.unlink(missing_ok=True)
            raise
    files = sorted(path.parent.glob("*.gamut"), key=_last_use, reverse=True)
    for old in files[MOST_FILES:]:
        old.unlink(missing_ok=True)


def _last_use(path: Path) -> float:
    """Return when a file was used; 0 if another process has removed it."""
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0
