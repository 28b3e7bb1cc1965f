"""Progress of builds: to a callable, as a bar, or to nobody."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING

from gamutcore.building import STAGES

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

__all__ = ["report_progress"]


@contextlib.contextmanager
def report_progress(
    progress: bool | Callable[[str, float], None],
) -> Iterator[Callable[[str, float], None]]:
    """Provide the function that a build reports to, with `progress` as for `gamutcore.Gamut`.

    It takes a stage of `gamutcore.building.STAGES` and the completed fraction. Without tqdm, True
    shows nothing.
    """
    if callable(progress):
        yield progress
        return
    try:
        from tqdm.auto import tqdm  # noqa: PLC0415  # optional
    except ImportError:
        progress = False
    if not progress:
        yield lambda _stage, _fraction: None
        return
    form = "{desc:16} {percentage:3.0f} %|{bar}| {elapsed}"
    with tqdm(total=len(STAGES), bar_format=form, leave=False) as bar:

        def report(stage: str, fraction: float) -> None:
            bar.set_description_str(stage, refresh=False)
            bar.update(STAGES.index(stage) + fraction - bar.n)

        yield report
