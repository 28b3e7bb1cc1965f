"""The clients: connections to a service, by which gamuts are built, found and listed."""

from __future__ import annotations

import io
import json
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Generic, Literal, Self, TypeVar
from urllib.parse import quote

import httpx
import numpy as np

from gamutclient.arrays import Colours, colour_rows, npy_bytes
from gamutclient.errors import ServiceError
from gamutclient.gamuts import CSV, JSON, NPY, AsyncGamut, Gamut, RemoteGamut
from gamutclient.results import ColourMatch
from gamutclient.transport import (
    Awaiting,
    Blocking,
    Request,
    Retries,
    Steps,
    method,
    sent,
)

__all__ = ["AsyncClient", "Client"]

G = TypeVar("G", bound=RemoteGamut)

Progress = Callable[[str, float], None]
"""Called with the stage of a build and the completed fraction of it."""

POLL_SECONDS = 0.25
"""Time between two questions about a build whose progress is shown."""

PAGE = 200

MOST_IN_JSON = 10_000
"""Rows of a request in JSON, which has lists of names of any length and with any characters."""

TIMEOUT = httpx.Timeout(60.0, connect=10.0)
"""A build waits at most 20 s per request, and a million rows take seconds."""


class ServiceClient(Generic[G]):
    """A client whose gamuts are of the class G.

    Attributes
    ----------
    http : httpx.Client or httpx.AsyncClient
        Can be configured: proxies, certificates, limits of connections.
    retries : Retries
    """

    _connections: type[httpx.Client | httpx.AsyncClient]
    _gamut: type[G]

    def __init__(
        self,
        url: str,
        *,
        api_key: str | None = None,
        retries: Retries = Retries(),  # noqa: B008  # frozen
        **settings: Any,  # noqa: ANN401  # of httpx
    ) -> None:
        headers = {} if api_key is None else {"Authorization": f"Bearer {api_key}"}
        given = {"base_url": url, "headers": headers, "timeout": TIMEOUT, **settings}
        self.http: Any = self._connections(**given)
        self.retries = retries

    def _built(self, request: Request, progress: Progress | None) -> Steps[G]:
        headers = {"Prefer": "respond-async" if progress else "wait=20", **request.headers}
        response = yield from sent(replace(request, headers=headers), self.retries)
        if response.status_code != httpx.codes.ACCEPTED:
            return self._gamut(self.http, response.json(), self.retries)
        job = response.json()
        while job["state"] in {"queued", "running"}:
            delay = POLL_SECONDS if progress else float(response.headers.get("retry-after", 1))
            request = Request("GET", f"/v1/jobs/{job['id']}", delay=delay)
            job = (yield from sent(request, self.retries.while_built)).json()
            if progress and job["state"] == "running" and job["stage"]:  # none until it has begun
                progress(job["stage"], job["fraction"])
        if problem := job["problem"]:
            raise ServiceError.from_document(problem, int(problem.get("status", 200)))
        return (yield from self._described(job["id"]))

    def _described(self, gamut_id: str) -> Steps[G]:
        path = f"/v1/gamuts/{quote(gamut_id, safe='')}"
        request = Request("GET", path, headers={"Accept": "application/json"})
        response = yield from sent(request, self.retries)
        return self._gamut(self.http, response.json(), self.retries)

    @method
    def build(
        self,
        /,
        data: object,
        options: Mapping[str, object] | None = None,
        *,
        name: str | None = None,
        progress: Progress | None = None,
        **choices: object,
    ) -> Steps[G]:
        """Build the gamut of a device, a picture or colours, and wait for it.

        Parameters
        ----------
        data : path, bytes, array or table
            The path or the content of a file, an (n, 3) array of L*, a*, b*, a structured array
            whose fields are columns, or a table of named columns such as a pandas DataFrame.
        options : mapping, optional
            How the gamut is built.
        name : str, optional
            By which lists call the gamut; the name of the file if it is a path.
        progress : callable, optional
            Called with a stage and the completed fraction of it.
        **choices
            Options by name, such as ``ink_limit=300``.

        Raises
        ------
        ServiceError
            The data or an option is refused, or the build failed.
        TypeError
            The data has none of these forms.
        """
        content, file_name = _content(data)
        given = {**(options or {}), **choices}
        form = {"options": json.dumps(given, default=_plain)}
        form |= {} if name is None else {"name": name}
        body = {"files": {"file": (file_name, content)}, "data": form}
        return self._built(Request("POST", "/v1/gamuts", body=body), progress)

    @method
    def reference(
        self, /, name: str, *, progress: Progress | None = None, **options: object
    ) -> Steps[G]:
        """Build a reference gamut, such as ``"Display P3"``, and wait for it."""
        document = json.dumps({"reference": name, "options": options}, default=_plain)
        headers = {"Content-Type": "application/json"}
        request = Request("POST", "/v1/gamuts", headers=headers, body={"content": document})
        return self._built(request, progress)

    @method
    def gamut(self, gamut_id: str) -> Steps[G]:
        """Return a gamut of the service by its id.

        Raises
        ------
        ServiceError
            There is no such gamut; the code is ``"gamut-not-found"``.
        """
        return self._described(gamut_id)

    @method
    def gamuts(
        self, name: str = "", match: Literal["contains", "similar"] = "contains"
    ) -> Steps[list[dict[str, Any]]]:
        """List the descriptions of all gamuts whose name contains a text.

        With ``match="similar"``, these are gamuts that the name may mean, in any spelling, the most
        likely first. They are ranked a thousand at a time.
        """
        found: list[dict[str, Any]] = []
        after: str | None = ""
        while after is not None:
            params = {"limit": PAGE, "after": after, "name": name, "match": match}
            request = Request("GET", "/v1/gamuts", params)
            page = (yield from sent(request, self.retries)).json()
            found += page["gamuts"]
            after = page["next"] and httpx.URL(page["next"]).params["after"]
        return found

    @method
    def references(self, name: str = "") -> Steps[list[dict[str, Any]]]:
        """List the reference gamuts: slug, name, white and primaries.

        With a name, only those that it may mean, in any spelling, the most likely first.
        """
        request = Request("GET", "/v1/references", {"name": name} if name else {})
        found: list[dict[str, Any]] = (yield from sent(request, self.retries)).json()["references"]
        return found

    @method
    def match(
        self,
        /,
        colours: Colours,
        gamuts: Iterable[RemoteGamut | str],
        *,
        passing: float | None = None,
        edge_width: float | None = None,
        delta_e: bool = True,
        recipes: bool = False,
        names: Sequence[str] | None = None,
        space: str | None = None,
        max_error: float | None = None,
    ) -> Steps[ColourMatch]:
        """Find which gamuts print colours, and how near the others come.

        Parameters
        ----------
        colours : array or table
            As for the questions to a gamut.
        gamuts : iterable of Gamut or str
            Gamuts of the service, or ids, slugs of references, or names, of which one gamut has the
            text in its name. At most 200, and 500,000 colours times gamuts.
        names : sequence of str, optional
            Of up to 10,000 colours in an array; by default numbers from 1.
        passing, edge_width, delta_e, recipes, space, max_error
            As for `gamutcore.match`.

        Raises
        ------
        ServiceError
            A gamut is missing, a name is ambiguous, or a value is refused.
        """
        rows = colour_rows(colours)
        keys = [each if isinstance(each, str) else each.id for each in gamuts]
        params: dict[str, Any] = {
            "pass": passing,
            "edge_width": edge_width,
            "delta_e": delta_e,
            "recipes": recipes,
            "space": space,
            "max_error": max_error,
        }
        body: dict[str, Any]
        if rows.table is None and len(rows.points) <= MOST_IN_JSON:
            kind = JSON
            document: dict[str, Any] = {"gamuts": keys, "colours": rows.points.tolist()}
            body = {"json": document if names is None else {**document, "names": list(names)}}
        else:
            if names is not None:
                raise ValueError("Names are for colours in an array of at most 10,000 rows.")
            kind = NPY if rows.table is None else CSV
            content = npy_bytes(rows.points) if rows.table is None else rows.table
            params, body = {**params, "gamuts": keys}, {"content": content}
        headers = {"Content-Type": kind, "Accept": JSON}
        request = Request("POST", "/v1/matches", params, headers, body)
        return ColourMatch.from_dict((yield from sent(request, self.retries)).json())


class Client(Blocking, ServiceClient[Gamut]):
    """A client of the service. Close it, or use it in a ``with`` statement.

    Parameters
    ----------
    url : str
        Address of the service, such as ``"http://127.0.0.1:8000"``.
    api_key : str, optional
    retries : Retries, optional
        How often failed requests are sent again.
    **settings
        Arguments of `httpx.Client`, such as `timeout`, `verify` or `limits`.

    Examples
    --------
    >>> client = Client("http://127.0.0.1:8000", api_key="secret")
    >>> client.close()
    """

    _connections = httpx.Client
    _gamut = Gamut

    def close(self) -> None:
        """Close the connections."""
        self.http.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class AsyncClient(Awaiting, ServiceClient[AsyncGamut]):
    """A client whose methods are coroutines. Close it, or use it in ``async with``.

    The parameters are those of `Client`, and `settings` those of `httpx.AsyncClient`.
    """

    _connections = httpx.AsyncClient
    _gamut = AsyncGamut

    async def close(self) -> None:
        """Close the connections."""
        await self.http.aclose()

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()


def _content(data: object) -> tuple[bytes, str]:
    """Return the content of a file and its name."""
    if isinstance(data, bytes | bytearray | memoryview):
        return bytes(data), "data"
    if isinstance(data, str | os.PathLike):
        path = Path(data)
        return path.read_bytes(), path.name
    if isinstance(data, io.IOBase):
        content = data.read()
        name = Path(str(getattr(data, "name", "data"))).name
        return (content.encode() if isinstance(content, str) else bytes(content)), name
    if callable(getattr(data, "to_csv", None)):
        table: str = data.to_csv(index=False)  # type: ignore[attr-defined]
        return table.encode(), "colours.csv"
    colours = np.asarray(data)
    if colours.dtype.names is None:
        if colours.ndim < 2 or colours.shape[-1] != 3 or colours.dtype.kind not in "fiu":
            raise TypeError(
                f"The data is of the type {type(data).__name__}, as an array of shape "
                f"{colours.shape} and type {colours.dtype}. Give a path, bytes, an (n, 3) array "
                "of L*, a*, b*, a structured array whose fields are columns, or a table."
            )
        colours = colours.reshape(-1, 3).astype(np.float64)
    return npy_bytes(colours), "colours.npy"


def _plain(value: object) -> object:
    """Return a number of NumPy as one of Python, for JSON."""
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"An option is of the type {type(value).__name__}. Give numbers and texts.")
