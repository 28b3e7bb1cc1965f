"""What a client of the service sends to build, find and list gamuts."""

from __future__ import annotations

import io
import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Generic, Literal, TypeVar
from urllib.parse import quote

import httpx
import numpy as np

from gamutclient.arrays import npy_bytes
from gamutclient.errors import ServiceError
from gamutclient.transport import Connections, Request, Retries, Steps, sent

__all__ = ["ClientSteps", "Progress", "ServiceClient"]

G = TypeVar("G")

Progress = Callable[[str, float], None]
"""Called with the stage of a build and the completed fraction of it."""

POLL_SECONDS = 0.25
"""Time between two questions about a build whose progress is shown."""

PAGE = 200


class ServiceClient(Generic[G]):
    """A client whose gamuts are of the class G.

    Attributes
    ----------
    http : httpx.Client or httpx.AsyncClient
        Can be configured: proxies, certificates, limits of connections.
    retries : Retries
    """

    def __init__(
        self,
        http: Connections,
        retries: Retries,
        gamut: Callable[[Any, Mapping[str, Any], Retries], G],
    ) -> None:
        self.http, self.retries = http, retries
        self._gamut = gamut

    def _built(self, request: Request, progress: Progress | None) -> Steps[G]:
        response = yield from sent(request, self.retries)
        while response.status_code == httpx.codes.ACCEPTED:
            job = response.json()
            yield POLL_SECONDS if progress else float(response.headers.get("retry-after", 1))
            job = yield from self._job(job["id"], progress)
            if job["state"] in {"queued", "running"}:
                continue
            if job["problem"] is not None:
                problem = job["problem"]
                raise ServiceError.from_document(problem, int(problem.get("status", 200)))
            return (yield from self._described(job["id"]))
        return self._gamut(self.http, response.json(), self.retries)

    def _described(self, gamut_id: str) -> Steps[G]:
        headers = {"Accept": "application/json"}
        path = f"/v1/gamuts/{quote(gamut_id, safe='')}"
        request = Request("GET", path, headers=headers)
        response = yield from sent(request, self.retries)
        return self._gamut(self.http, response.json(), self.retries)

    def _job(self, job_id: str, progress: Progress | None) -> Steps[dict[str, Any]]:
        request = Request("GET", f"/v1/jobs/{job_id}")
        job: dict[str, Any] = (yield from sent(request, self.retries.while_built)).json()
        if progress and job["state"] == "running" and job["stage"]:  # none until it has begun
            progress(job["stage"], job["fraction"])
        return job


class ClientSteps(ServiceClient[G]):
    """The steps of the methods. `Client` and `AsyncClient` carry them out."""

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
        form = {"options": json.dumps(given, default=_plain)} | (
            {} if name is None else {"name": name}
        )
        request = Request(
            "POST",
            "/v1/gamuts",
            headers={"Prefer": "respond-async" if progress else "wait=20"},
            files={"file": (file_name, content)},
            data=form,
        )
        return (yield from self._built(request, progress))

    def reference(
        self, /, name: str, *, progress: Progress | None = None, **options: object
    ) -> Steps[G]:
        """Build a reference gamut, such as ``"Display P3"``, and wait for it."""
        document = json.dumps({"reference": name, "options": options}, default=_plain)
        wait = "respond-async" if progress else "wait=20"
        headers = {"Prefer": wait, "Content-Type": "application/json"}
        request = Request("POST", "/v1/gamuts", headers=headers, content=document.encode())
        return (yield from self._built(request, progress))

    def gamut(self, gamut_id: str) -> Steps[G]:
        """Return a gamut of the service by its id.

        Raises
        ------
        ServiceError
            There is no such gamut; the code is ``"gamut-not-found"``.
        """
        return (yield from self._described(gamut_id))

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
            after = _after(page["next"])
        return found

    def references(self, name: str = "") -> Steps[list[dict[str, Any]]]:
        """List the reference gamuts: slug, name, white and primaries.

        With a name, only those that it may mean, in any spelling, the most likely first.
        """
        request = Request("GET", "/v1/references", {"name": name} if name else {})
        found: list[dict[str, Any]] = (yield from sent(request, self.retries)).json()["references"]
        return found


def _after(following: str | None) -> str | None:
    """Return the parameter `after` in the address of the next page."""
    return None if following is None else httpx.URL(following).params["after"]


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
