"""Changes that keys with the scope ``build`` may make: to gamuts that they built themselves."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from service.access.api_keys import WRITE
from service.access.middleware import client_key
from service.problems.problem import Problem, ProblemError

if TYPE_CHECKING:
    from fastapi import Request

    from service.storage.gamuts import GamutStore

__all__ = ["check_owner", "claim", "may_change"]


async def claim(request: Request, store: GamutStore, gamut_id: str) -> None:
    """Make the key of a request the owner of a gamut that is being built, if there is no owner."""
    key = client_key(request.scope)
    if key is not None:
        await asyncio.to_thread(store.owners.claim, gamut_id, key.name)


async def may_change(request: Request, store: GamutStore, gamut_id: str) -> bool:
    """Return whether the client may name, delete or cancel a gamut."""
    key = client_key(request.scope)
    if key is None or WRITE in key.scopes:
        return True
    return await asyncio.to_thread(store.owners.read, gamut_id) == key.name


async def check_owner(request: Request, store: GamutStore, gamut_id: str) -> None:
    """Raise the problem ``built-by-another`` unless the client may change a gamut."""
    if not await may_change(request, store, gamut_id):
        detail = "The key has the scope build, and another client built the gamut."
        raise ProblemError(Problem("built-by-another", detail, {"scope": WRITE}))
