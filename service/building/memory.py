"""How much memory a process has in use: what only it can give back."""

from __future__ import annotations

import os
from pathlib import Path

__all__ = ["private_bytes"]


def private_bytes(process: int | str) -> int | None:
    """Return the bytes of a process's memory that are neither shared nor read from a file.

    Libraries and cached kernels are mapped from files and shared by all workers, so they do not
    count; neither does address space that is reserved and was never touched.

    Parameters
    ----------
    process : int or str
        Its id, or ``self``.

    Returns
    -------
    int or None
        None if the system does not tell, or if there is no such process.
    """
    try:
        pages = Path(f"/proc/{process}/statm").read_text().split()
        return (int(pages[1]) - int(pages[2])) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, IndexError):
        return None
