"""The clients: connections to a service, by which gamuts are built and found."""

from __future__ import annotations

from typing import Any, Self

import httpx

from gamutclient.client_steps import ClientSteps, ServiceClient
from gamutclient.gamuts import AsyncGamut, Gamut
from gamutclient.transport import Retries, awaiting, blocking

__all__ = ["AsyncClient", "Client"]

TIMEOUT = httpx.Timeout(60.0, connect=10.0)
"""A build waits at most 20 s per request, and a million rows take seconds."""


def _settings(url: str, api_key: str | None, settings: dict[str, Any]) -> dict[str, Any]:
    headers = {} if api_key is None else {"Authorization": f"Bearer {api_key}"}
    return {"base_url": url, "headers": headers, "timeout": TIMEOUT, **settings}


class Client(ServiceClient[Gamut]):
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

    def __init__(
        self,
        url: str,
        *,
        api_key: str | None = None,
        retries: Retries = Retries(),  # noqa: B008  # frozen
        **settings: Any,  # noqa: ANN401  # of httpx
    ) -> None:
        super().__init__(httpx.Client(**_settings(url, api_key, settings)), retries, Gamut)

    build = blocking(ClientSteps[Gamut].build)
    reference = blocking(ClientSteps[Gamut].reference)
    gamut = blocking(ClientSteps[Gamut].gamut)
    gamuts = blocking(ClientSteps[Gamut].gamuts)
    references = blocking(ClientSteps[Gamut].references)

    def close(self) -> None:
        """Close the connections."""
        self.http.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class AsyncClient(ServiceClient[AsyncGamut]):
    """A client whose methods are coroutines. Close it, or use it in ``async with``.

    The parameters are those of `Client`, and `settings` those of `httpx.AsyncClient`.
    """

    def __init__(
        self,
        url: str,
        *,
        api_key: str | None = None,
        retries: Retries = Retries(),  # noqa: B008  # frozen
        **settings: Any,  # noqa: ANN401  # of httpx
    ) -> None:
        http = httpx.AsyncClient(**_settings(url, api_key, settings))
        super().__init__(http, retries, AsyncGamut)

    build = awaiting(ClientSteps[AsyncGamut].build)
    reference = awaiting(ClientSteps[AsyncGamut].reference)
    gamut = awaiting(ClientSteps[AsyncGamut].gamut)
    gamuts = awaiting(ClientSteps[AsyncGamut].gamuts)
    references = awaiting(ClientSteps[AsyncGamut].references)

    async def close(self) -> None:
        """Close the connections."""
        await self.http.aclose()

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()
