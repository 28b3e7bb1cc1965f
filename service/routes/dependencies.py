"""Dependencies of the routes of gamuts: gamuts by id or slug, and the check of the query.

The slug of a reference gamut is accepted wherever the id of a gamut is: in paths, queries and
bodies. Options of its build are query parameters beside those of the operation. The gamut is built
on first use. An answer names its address by id in ``Content-Location``, and may be cached for
minutes only: a later version of the algorithm gives a slug another id. See
``docs/decisions/references.md``.
"""

import asyncio
import re
import time
from collections.abc import Callable, Coroutine
from functools import cache, lru_cache
from typing import Annotated, Any
from urllib.parse import unquote_plus

from fastapi import Depends, Path, Request
from fastapi.responses import Response
from fastapi.routing import APIRoute
from pydantic import TypeAdapter, ValidationError

from gamutcore.building import gamut_id as id_of_build
from gamutcore.levels import LevelRequest, Side
from gamutcore.options import OPTIONS, Options, option_value
from gamutcore.references import REFERENCES, Reference
from service.access.rate_limits import client_of
from service.container import service_of
from service.http.bodies import check_head
from service.http.requests import GAMUT_ID, GAMUT_PATTERN, ID_PATTERN, check_items, request_error
from service.openapi.documentation import EXAMPLE_ID
from service.problems.problem import Problem, ProblemError
from service.routes.jobs import wait_for_build
from service.routes.submission import check_surface_samples
from service.storage.published import PublishedGamut

__all__ = [
    "CACHE_SECONDS",
    "GamutId",
    "GamutRoute",
    "NamedGamuts",
    "as_alias",
    "check_gamut_query",
    "check_request",
    "checked_gamut",
    "is_reference_id",
    "level_request",
    "read_only",
]

CACHE_SECONDS = 300
"""Time for which caches may keep an answer at the address of a slug."""

_SHORT_LIVED = f"public, max-age={CACHE_SECONDS}".encode()
"""``Cache-Control`` at the address of a slug, in the place of ``immutable``."""

_ID = re.compile(ID_PATTERN + r"\Z")

_NAMING = {
    "/v1/comparisons": ("a", "b"),
    "/v1/links": ("source", "destination"),
    "/v1/gamuts/{gamut_id}/viewer.html": ("with",),
}
"""Query parameters that name gamuts, by path. Others have `reference` and `source`."""

_READING = frozenset({"GET", "POST"})
"""Methods of operations that build reference gamuts."""

_REFERENCE_OPTIONS = tuple(name for name, each in OPTIONS.items() if "reference" in each.data)
"""Names of the options that reference gamuts have."""

_MOST_NAMES = 400
"""Largest number of slugs and ids in a list."""


class NamedGamuts:
    """The gamuts that a request names by id or slug, and the options for the slugs.

    `items` are the query parameters of the operation: all, or all but the options of the build if
    the path or the query has a slug.
    """

    def __init__(self, request: Request) -> None:
        self._request = request
        path = request.scope["route"].path
        self._naming = _NAMING.get(path, ("reference", "source"))
        # Pictures have a parameter with the name of an option.
        self._own = (*self._naming, *(("background",) if path.endswith("/picture.png") else ()))
        self.items = items = request.query_params.multi_items()
        self._path_name: str = request.path_params.get("gamut_id", "")
        self._names = [self._path_name]
        for parameter, text in items:
            if parameter in self._naming:
                self._names += text.split(",")[:_MOST_NAMES]
        # A misspelled slug may have options too, so the slug is refused, and not the options.
        self._has_slug = any(name and not _ID.match(name) for name in self._names)
        self._options: list[tuple[str, str]] = []
        if self._has_slug:
            self._options = [item for item in items if self._is_option(item[0])]
            self.items = [item for item in items if not self._is_option(item[0])]
        self._ids: dict[str, str] = {}

    @classmethod
    def of(cls, request: Request) -> "NamedGamuts":
        """Return the gamuts that a request names. There is one object for each request."""
        if not hasattr(request.state, "named_gamuts"):
            request.state.named_gamuts = cls(request)
        named: NamedGamuts = request.state.named_gamuts
        return named

    async def id_of(self, name: str) -> str:
        """Return the id of a gamut by its id or slug, in the path, the query or the body.

        Reference gamuts that are not stored are built, all of the request at once. Raise
        `PendingBuildError` if that takes longer than the client waits.
        """
        references = {
            each: _reference(each) for each in (*self._names, name) if each not in self._ids
        }
        wanted = {
            each: reference for each, reference in references.items() if reference is not None
        }
        if wanted:
            if self._request.method not in _READING:
                raise read_only(next(iter(wanted.values())).slug)
            options = self._build_options()
            builds = {}
            for each, reference in wanted.items():
                # An id that is known without its gamut is that of the default options.
                chosen = options if each in REFERENCES else Options()
                self._ids[each] = id_of_build(chosen, reference.sha256)
                builds[self._ids[each]] = reference, chosen
            await self._build(builds)
        return self._ids.get(name, name)

    @property
    def options(self) -> tuple[str, ...]:
        """Names of the options of the build that the query may have: none without a slug."""
        if not self._has_slug or self._request.method not in _READING:
            return ()
        return tuple(name for name in _REFERENCE_OPTIONS if name not in self._own)

    def location(self) -> str | None:
        """Return the address of the answer by ids; None if the request has ids only."""
        if not self._has_slug:
            return None
        scope, parts = self._request.scope, []
        name = self._path_name
        gamut_id = self._ids.get(name, name)
        path: str = scope["path"].replace(f"/gamuts/{name}", f"/gamuts/{gamut_id}", 1)
        for part in scope["query_string"].decode("latin-1").split("&"):
            parameter, equals, value = part.partition("=")
            if unquote_plus(parameter) in self._naming:
                names = unquote_plus(value).split(",")
                value = ",".join(self._ids.get(name, name) for name in names)
            if part and not self._is_option(unquote_plus(parameter)):
                parts.append(f"{parameter}{equals}{value}")
        return path + (f"?{'&'.join(parts)}" if parts else "")

    def _is_option(self, parameter: str) -> bool:
        return parameter not in self._own and _option_name(parameter) in OPTIONS

    def _build_options(self) -> Options:
        values: dict[str, object] = {}
        for parameter, text in self._options:
            name = _option_name(parameter)
            if name in values:
                detail = f"The parameter {name!r} is given twice."
                where = {"in": "query", "field": name}
                remedy = "Give each option once."
                raise ProblemError(Problem("invalid-parameter", detail, where, remedy))
            values[name] = option_value(name, text)
        options = Options.from_mapping(values)
        check_surface_samples(options)
        options.check_data("reference")
        return options

    async def _build(self, wanted: dict[str, tuple[Reference, Options]]) -> None:
        """Build the gamuts that are not stored, by id."""
        service, scope = service_of(self._request), self._request.scope
        jobs = []
        for gamut_id, (reference, options) in wanted.items():
            if service.library.find_open(gamut_id) is not None:
                continue
            if await asyncio.to_thread(service.store.is_stored, gamut_id):
                continue
            refuse = scope.get("refuse_build")
            problem = refuse(options != Options()) if refuse else None
            if problem is not None:
                raise ProblemError(problem)
            job = await service.builds.submit(
                gamut_id,
                options.to_mapping(),
                reference.data,
                reference.sha256,
                client_of(scope),
            )
            if not isinstance(job, PublishedGamut):
                jobs.append(job)
        prefer = self._request.headers.getlist("prefer")
        started = time.monotonic()
        for job in jobs:
            await wait_for_build(service, job, prefer, time.monotonic() - started)


def _option_name(parameter: str) -> str:
    return parameter.lower().replace("-", "_")


@cache
def _default_ids() -> dict[str, Reference]:
    """The references by their ids with default options, which are built on first use as well."""
    options = Options()
    return {id_of_build(options, each.sha256): each for each in REFERENCES.values()}


def is_reference_id(gamut_id: str) -> bool:
    """Whether an id is of a reference gamut with default options, which is built on first use."""
    return gamut_id in _default_ids()


@lru_cache(maxsize=1024)
def _reference(name: str) -> Reference | None:
    """Return the reference of a slug or of an id with default options; None if there is none."""
    return _default_ids().get(name) if _ID.match(name) else REFERENCES.get(name)


def read_only(slug: str) -> ProblemError:
    """Return the error of changing or deleting a reference gamut."""
    where = {"in": "path", "field": "gamut_id"}
    return ProblemError(
        Problem("reference-read-only", f"The gamut is the reference gamut {slug}.", where)
    )


_GamutName = Annotated[
    str,
    Path(
        pattern=f"^{GAMUT_PATTERN}$",
        description="Id of the gamut: SHA-256 of options, input and algorithm, hexadecimal. Or "
        "the slug of a reference gamut, such as `srgb`.",
        examples=[EXAMPLE_ID],
    ),
    GAMUT_ID,
]

_GAMUT_NAME: TypeAdapter[str] = TypeAdapter(_GamutName)


async def _gamut_of_path(request: Request, gamut_id: _GamutName) -> str:
    return await NamedGamuts.of(request).id_of(gamut_id)


GamutId = Annotated[str, Depends(_gamut_of_path)]
"""The id of the gamut in the path, which names it by id or slug."""


async def checked_gamut(request: Request, name: str, place: str, field: str) -> str:
    """Return the id of a gamut, for operations that read their parameters themselves.

    Raise the problem of FastAPI's own check if `name` is neither an id nor a slug.
    """
    if not _ID.match(name):
        try:
            _GAMUT_NAME.validate_python(name)
        except ValidationError as error:
            raise request_error(error, place, field) from error
    return await NamedGamuts.of(request).id_of(name)


async def check_request(request: Request) -> None:
    """Refuse what no operation accepts; see `check_head`."""
    check_head(request, service_of(request).bodies.most_body)


async def check_gamut_query(request: Request) -> None:
    """Refuse unknown and repeated parameters. With a slug, options of its build are known."""
    gamuts = NamedGamuts.of(request)
    check_items(request, gamuts.items, gamuts.options)


def level_request(
    triangles: int | None,
    max_error: float | None,
    max_mismatch: float | None = None,
    side: Side = "both",
    remedy: str = "Give either triangles or max_error.",
) -> LevelRequest:
    """Return the request of query parameters; refuse a count that is combined with a limit."""
    if triangles is not None and (max_error is not None or max_mismatch is not None):
        fault = "A triangle count is combined with an error limit."
        where = {"in": "query", "field": "triangles"}
        raise ProblemError(Problem("invalid-parameter", fault, where, remedy))
    return LevelRequest(triangles, max_error, max_mismatch, side)


class GamutRoute(APIRoute):
    """A route whose answers by slug are marked as such; see `as_alias`."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Return FastAPI's handler and the mark."""
        handle = super().get_route_handler()

        async def handle_named(request: Request) -> Response:
            return as_alias(request, await handle(request))

        return handle_named


def as_alias(request: Request, answer: Response) -> Response:
    """Return an answer; one by slug becomes short-lived and has its address by id."""
    location = NamedGamuts.of(request).location()
    if location is not None and answer.status_code in {200, 206, 304}:
        # A new list, because answers with the same content may share the old one.
        headers = [
            (name, _SHORT_LIVED if name == b"cache-control" and b"immutable" in value else value)
            for name, value in answer.raw_headers
            if name != b"content-location"
        ]
        answer.raw_headers = [*headers, (b"content-location", location.encode("latin-1"))]
    return answer
