"""Slugs of reference gamuts in addresses: ASGI middleware that puts the gamut's id in their place.

A slug is accepted wherever the id of a gamut is: in paths below ``/v1/gamuts`` and in the parameter
`gamuts` of ``/v1/meshes``. Options of the build are query parameters beside those of the operation.
The middleware finds the id, builds the gamut if it is not stored, and passes the request on with
the id. All operations therefore take slugs in addresses without knowing of them. A slug in a body
is resolved by the operation, with `named_gamut`. An answer names its address by id in
``Content-Location``, and may be cached for minutes only: a later version of the algorithm gives a
slug another id. See ``docs/decisions/references.md``.
"""

from __future__ import annotations

import asyncio
import re
import time
from functools import cache, lru_cache
from typing import TYPE_CHECKING
from urllib.parse import unquote_plus

from starlette.routing import Match

from gamutcore.building import gamut_id
from gamutcore.errors import GamutError
from gamutcore.options import OPTIONS, Options, option_value
from gamutcore.references import REFERENCES, Reference
from service.access.clients import client_of
from service.http.parameters import ID_PATTERN
from service.problems.problem import Problem, ProblemError, problem_response
from service.routes.naming import read_only
from service.routes.submission import check_surface_samples
from service.routes.waiting import wait_for_build
from service.storage.blobs import StoreUnavailableError
from service.storage.published import PublishedGamut

if TYPE_CHECKING:
    from collections.abc import Iterable

    from starlette.responses import Response
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

    from service.container import ServiceContainer

__all__ = ["CACHE_SECONDS", "ReferenceSlugs", "named_gamut"]

CACHE_SECONDS = 300
"""Time for which caches may keep an answer at the address of a slug."""

_SHORT_LIVED = f"public, max-age={CACHE_SECONDS}".encode()
"""``Cache-Control`` at the address of a slug, in the place of ``immutable``."""

_PATH = re.compile(r"/v1/gamuts/([^/]+)(/.*)?\Z")
_ID = re.compile(ID_PATTERN + r"\Z")

_NAMING = {"/v1/meshes": (b"gamuts",), "/v1/comparisons": (b"a", b"b")}
"""Query parameters that name gamuts, by path."""

_REFERENCE = (b"reference", b"source")
"""The same below a gamut."""

_OF_PICTURES = (b"background",)
"""Query parameters of pictures that have the name of an option; they are the picture's."""

_OPTIONS = "reference_options"
"""Key of the options of the build in the scope of a request by slug."""

_MOST_NAMES = 400
"""Largest number of slugs and ids in a batch."""

_BUILDING_METHODS = frozenset({"GET", "POST"})
"""Methods of operations that need the gamut."""

_CHANGING_METHODS = frozenset({"DELETE", "PUT", "PATCH"})
"""Methods of operations that change the gamut."""


class ReferenceSlugs:
    """ASGI middleware that resolves slugs, and builds reference gamuts on first use.

    Parameters
    ----------
    app : ASGI app
    service : ServiceContainer
    """

    def __init__(self, app: ASGIApp, service: ServiceContainer) -> None:
        self.app = app
        self.service = service

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on with ids, or answer with a job or a problem."""
        if scope["type"] != "http" or not _naming(scope["path"]):
            await self.app(scope, receive, send)
            return
        try:
            await self._answer(scope, receive, send)
        except ProblemError as error:
            await problem_response(error.problem)(scope, receive, send)

    async def _answer(self, scope: Scope, receive: Receive, send: Send) -> None:
        named = _named_references(scope)
        if not named:
            await self.app(scope, receive, send)
            return
        if not _has_operation(scope):
            # The router answers: an unknown path or method is no matter of reference gamuts.
            await self.app(scope, receive, send)
            return
        if scope["method"] in _CHANGING_METHODS:
            raise read_only(next(iter(named.values())).slug)
        by_slug = any(not _ID.match(name) for name in named)
        query: bytes = scope["query_string"]
        given: dict[str, object] = {}
        if by_slug:
            query, given = _split_query(query, _of_operation(scope["path"]))
        try:
            options = Options.from_mapping(given)
            check_surface_samples(options, self.service.settings)
            options.check_data("reference")
        except GamutError as error:
            raise ProblemError(Problem.from_error(error)) from error
        ids = {name: gamut_id(options, each.sha256) for name, each in named.items()}
        if scope["method"] in _BUILDING_METHODS:
            wanted = {ids[name]: each for name, each in named.items()}
            response = await _build(self.service, scope, wanted, options)
            if response is not None:
                await response(scope, receive, send)
                return
        if not by_slug:
            await self.app(scope, receive, send)
            return
        path, query = _with_ids(scope["path"], query, ids)
        inner = {**scope, "path": path, "raw_path": path.encode(), "query_string": query}
        inner[_OPTIONS] = options
        location = path + (f"?{query.decode('latin-1')}" if query else "")

        async def send_as_alias(message: Message) -> None:
            if message["type"] == "http.response.start" and message["status"] in {200, 206, 304}:
                message["headers"] = _alias_headers(message["headers"], location)
            await send(message)

        try:
            await self.app(inner, receive, send_as_alias)
        finally:
            # The outer middleware needs the matched route.
            scope["route"] = inner.get("route")


async def named_gamut(
    service: ServiceContainer, scope: Scope, name: str
) -> tuple[str, Response | None]:
    """Return the id of a gamut that a body names, and build it if it is a reference gamut.

    Parameters
    ----------
    service : ServiceContainer
    scope : Scope
        Of the request. Options of the build that its address gives apply to slugs.
    name : str
        An id, or the slug of a reference gamut.

    Returns
    -------
    gamut_id : str
        The name itself, if it is no slug.
    response : Response or None
        The job, if the build takes longer than the client waits.

    Raises
    ------
    ProblemError
        The gamut cannot be built now.
    """
    reference = _reference(name)
    if reference is None:
        return name, None
    options = Options() if _ID.match(name) else scope.get(_OPTIONS, Options())
    found = gamut_id(options, reference.sha256)
    return found, await _build(service, scope, {found: reference}, options)


async def _build(
    service: ServiceContainer, scope: Scope, wanted: dict[str, Reference], options: Options
) -> Response | None:
    """Build the gamuts that are not stored, by id. Return an answer if one takes too long."""
    try:
        jobs = []
        for found, reference in wanted.items():
            if service.library.find_open(found) is not None:
                continue
            if await asyncio.to_thread(service.store.is_stored, found):
                continue
            refuse = scope.get("refuse_build")
            problem = refuse(options != Options()) if refuse else None
            if problem is not None:
                raise ProblemError(problem)
            job = await service.builds.submit(
                found,
                options.to_mapping(),
                reference.data,
                None,
                reference.sha256,
                client_of(scope),
            )
            if not isinstance(job, PublishedGamut):
                jobs.append(job)
        prefer = [value.decode("latin-1") for key, value in scope["headers"] if key == b"prefer"]
        started = time.monotonic()
        for job in jobs:
            waited = time.monotonic() - started
            response, _ = await wait_for_build(service, job, prefer, waited)
            if response is not None:
                return response
    except StoreUnavailableError:
        raise ProblemError(Problem.store_unavailable()) from None
    except OSError as error:
        problem = Problem.from_errno(error.errno, remote=service.store.blobs.remote)
        if problem is None:
            raise
        raise ProblemError(problem) from error
    return None


def _has_operation(scope: Scope) -> bool:
    """Return whether the service has an operation of this path and method."""
    return any(route.matches(scope)[0] is Match.FULL for route in scope["app"].routes)


@cache
def _default_ids() -> dict[str, Reference]:
    """The references by their ids with default options, which are built on first use as well."""
    options = Options()
    return {gamut_id(options, each.sha256): each for each in REFERENCES.values()}


@lru_cache(maxsize=1024)
def _reference(name: str) -> Reference | None:
    """Return the reference of a slug or of an id with default options; None if there is none."""
    return _default_ids().get(name) if _ID.match(name) else REFERENCES.get(name)


def _named_references(scope: Scope) -> dict[str, Reference]:
    """Return the references in a request, by the slugs or ids that the client wrote."""
    path = _PATH.match(scope["path"])
    names = [path[1]] if path is not None else []
    naming = _naming(scope["path"])
    for part in scope["query_string"].split(b"&"):
        parameter, _, value = part.partition(b"=")
        if parameter in naming:
            names += _text(value).split(",")[:_MOST_NAMES]
    found = ((name, _reference(name)) for name in names)
    return {name: reference for name, reference in found if reference is not None}


def _naming(path: str) -> tuple[bytes, ...]:
    """Return the query parameters that name gamuts; empty if the path names none either."""
    return _REFERENCE if path.startswith("/v1/gamuts/") else _NAMING.get(path, ())


def _of_operation(path: str) -> tuple[bytes, ...]:
    """Return the query parameters that are no options of the build, whatever their name."""
    return _naming(path) + (_OF_PICTURES if path.endswith("/picture.png") else ())


def _text(quoted: bytes) -> str:
    return unquote_plus(quoted.decode("latin-1"))


def _split_query(query: bytes, own: tuple[bytes, ...]) -> tuple[bytes, dict[str, object]]:
    """Return a query without the options of a build, and these options.

    `own` are the parameters of the operation that have names of options.
    """
    rest, options = [], {}
    for part in query.split(b"&") if query else []:
        quoted, _, value = part.partition(b"=")
        name = _text(quoted).lower().replace("-", "_")
        if name not in OPTIONS or quoted in own:
            rest.append(part)
        elif name in options:
            problem = Problem(
                "invalid-parameter",
                f"The parameter {name!r} is given twice.",
                {"in": "query", "field": name},
                "Give each option once.",
            )
            raise ProblemError(problem)
        else:
            options[name] = option_value(name, _text(value))
    return b"&".join(rest), options


def _with_ids(path: str, query: bytes, ids: dict[str, str]) -> tuple[str, bytes]:
    """Return a path and a query with ids in the place of slugs."""
    naming = _naming(path)
    parts = query.split(b"&")
    for place, part in enumerate(parts):
        parameter, _, value = part.partition(b"=")
        if parameter in naming:
            names = ",".join(ids.get(name, name) for name in _text(value).split(","))
            parts[place] = parameter + b"=" + names.encode("latin-1", "replace")
    found = _PATH.match(path)
    if found is not None:
        path = f"/v1/gamuts/{ids.get(found[1], found[1])}{found[2] or ''}"
    return path, b"&".join(parts)


def _alias_headers(
    headers: Iterable[tuple[bytes, bytes]], location: str
) -> list[tuple[bytes, bytes]]:
    """Return the header fields of an answer by slug: short-lived, with the address by id."""
    kept = [
        (name, _SHORT_LIVED if name == b"cache-control" and b"immutable" in value else value)
        for name, value in headers
        if name != b"content-location"
    ]
    return [*kept, (b"content-location", location.encode("latin-1"))]
