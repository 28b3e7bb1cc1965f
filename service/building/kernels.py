"""The compiled kernels of an installation, as a running service prepares them.

A service is ready when the default group is compiled and loaded. The optional group then compiles
in the background, and a build that needs it waits. The kernels of CIEDE2000 compile when a request
waits for them. An image and ``make install`` compile all beforehand. Compilation runs in separate
processes, because it needs hundreds of megabytes.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import time
from typing import TYPE_CHECKING, Literal

from gamutcore.kernels import (
    ENTRY_POINTS,
    GROUPS,
    compile_command,
    is_compiled,
    load_kernels,
    stamps_can_be_kept,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["GroupState", "Kernels"]

logger = logging.getLogger(__name__)

_READING = (
    *("gamutcore.colours.spaces", "gamutcore.geometry", "gamutcore.history"),
    "gamutcore.levels",
)
"""Kernels that read, search and write levels. Those of builds are loaded by the worker processes:
without them this process is ready sooner and holds 3 MB less."""

_QUERIES = ("gamutcore.search",)
"""Kernels that answer queries."""

ON_FIRST_USE = "ciede2000"
"""Compiled when a request waits for it: few do, and it takes 12 s."""

LOG_INTERVAL = 5.0
"""Seconds between two lines of the log that count kernels."""

GroupState = Literal["unknown", "compiling", "compiled", "on first use"]


class Kernels:
    """The state of the kernels, and their preparation.

    `loaded` tells whether this process has loaded the compiled kernels. The state "on first use" of
    a group means that compiled code cannot be kept, so each process compiles what it needs.
    """

    def __init__(self) -> None:
        self.loaded = False
        self._usable = {group: asyncio.Event() for group in GROUPS}
        self._wanted = {group: asyncio.Event() for group in GROUPS}
        self._states: dict[str, GroupState] = dict.fromkeys(GROUPS, "unknown")
        self._count = 0

    @property
    def states(self) -> Mapping[str, GroupState]:
        """State of each group."""
        return self._states

    @property
    def detail(self) -> str:
        """The states for people; of a group that compiles, also how many kernels are usable."""
        return ", ".join(
            f"{group}: {state}"
            + (f" {self._count} of {ENTRY_POINTS[group]} kernels" if state == "compiling" else "")
            for group, state in self._states.items()
        )

    async def prepare(self) -> None:
        """Compile the default group and load it, then the optional one; the last when wanted."""
        first, *rest = GROUPS
        await self._compile(first)
        await asyncio.to_thread(load_kernels, _READING)
        self.loaded = True
        self._usable[first].set()
        logger.info("ready")
        for group in rest:
            if group == ON_FIRST_USE and not await asyncio.to_thread(is_compiled, group):
                self._states[group] = "on first use"
                await self._wanted[group].wait()
            await self._compile(group)
            await asyncio.to_thread(load_kernels, _QUERIES)
            self._usable[group].set()

    async def wait(self, group: str, seconds: float) -> bool:
        """Wait until the kernels of a group are usable; return whether they are in time."""
        self._wanted[group].set()
        usable = self._usable[group]
        if not usable.is_set():
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(usable.wait(), seconds)
        return usable.is_set()

    async def _compile(self, group: str) -> None:
        if await asyncio.to_thread(is_compiled, group):
            self._states[group] = "compiled"
            return
        if not stamps_can_be_kept():
            logger.warning(
                "the %s kernels cannot be kept, and every process compiles them on first use:"
                " make the package's directory writable once, or set NUMBA_CACHE_DIR",
                group,
            )
            self._states[group] = "on first use"
            return
        self._states[group], self._count = "compiling", 0
        logger.info("compiling the %s kernels for this processor, %d", group, ENTRY_POINTS[group])
        clock = time.monotonic()
        process = await asyncio.create_subprocess_exec(
            *compile_command(group), stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE
        )
        assert process.stdout is not None  # noqa: S101  # a pipe was asked for
        try:
            await self._count_kernels(group, process.stdout)
            status = await process.wait()
        except asyncio.CancelledError:
            process.kill()
            await process.wait()
            raise
        if status:
            logger.error("the %s kernels were not compiled: exit status %d", group, status)
            self._states[group] = "on first use"
            return
        self._states[group] = "compiled"
        logger.info("compiled the %s kernels in %.0f s", group, time.monotonic() - clock)

    async def _count_kernels(self, group: str, names: asyncio.StreamReader) -> None:
        """Count the kernels that the compiler has named, and log the number now and then."""
        usable, logged = set(), time.monotonic()
        async for name in names:
            usable.add(name)
            self._count = len(usable)
            if time.monotonic() - logged > LOG_INTERVAL:
                logged = time.monotonic()
                logger.info(
                    "compiling the %s kernels: %d of %d", group, self._count, ENTRY_POINTS[group]
                )
