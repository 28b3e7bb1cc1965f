"""Settings of the service, read from environment variables with the prefix ``GAMUT_``.

Each field is one variable: ``max_body_bytes`` is ``GAMUT_MAX_BODY_BYTES``. ``make documents``
writes the table of `settings_table` into ``docs/settings.md``.
"""

import ipaddress
import re
from collections.abc import Callable
from collections.abc import Set as AbstractSet
from typing import Annotated, Literal
from urllib.parse import urlsplit

from pydantic import (
    AfterValidator,
    Field,
    NonNegativeFloat,
    NonNegativeInt,
    PositiveFloat,
    PositiveInt,
    ValidationInfo,
    field_validator,
)
from pydantic_settings import BaseSettings, SettingsConfigDict

from service.access.api_keys import ApiKeys
from service.access.hosts import host_names
from service.http.cors import origins
from service.storage import is_address

__all__ = ["ENVIRONMENT_PREFIX", "Settings", "settings_table", "settings_text"]

ENVIRONMENT_PREFIX = "GAMUT_"

_MEBIBYTE = 1024 * 1024

_LEAST_MEMORY = 256 * _MEBIBYTE
"""What a process needs without gamuts: of the API with coarse levels, or of a warm build."""

_BROKER = re.compile(r"rediss?://")

_SECRETS = {
    "broker": (
        (re.compile(r"://.*@"), "://***@"),
        (re.compile(r"\?.*"), "?***"),  # Redis takes a password from the query as well
    ),
    "api_keys": ((re.compile(r":[0-9a-fA-F]{64}"), ":***"),),
}
"""What hides the secret parts of a setting: patterns with their replacements."""


def _checked(parse: Callable[[str], object]) -> AfterValidator:
    """Return a validator that keeps the text of a setting if `parse` raises no ValueError."""

    def check(text: str) -> str:
        parse(text)
        return text

    return AfterValidator(check)


def _parse_proxies(text: str) -> None:
    if text and text != "*":
        for proxy in text.split(","):
            # uvicorn would accept any other text as a name that matches no connection.
            ipaddress.ip_network(proxy.strip())


def _memory_or(zero: str) -> AfterValidator:
    """Return a validator of an amount of memory, for which 0 means `zero`."""

    def check(limit: int) -> int:
        if 0 < limit < _LEAST_MEMORY:
            message = f"must be 0 ({zero}) or at least {_LEAST_MEMORY} (256 MiB)"
            raise ValueError(message)
        return limit

    return AfterValidator(check)


class Settings(BaseSettings):
    """The settings of the service with defaults and ranges."""

    model_config = SettingsConfigDict(
        env_prefix=ENVIRONMENT_PREFIX,
        extra="forbid",
        frozen=True,
        allow_inf_nan=False,
        use_attribute_docstrings=True,
    )

    store: str = Field(default="var/gamuts", min_length=1)
    """Location of gamuts, inputs and jobs: a directory, which belongs to one running service at a
    time, or `s3://bucket/prefix`, `gs://bucket/prefix` or `az://container/prefix`, which any number
    of services share."""

    store_bytes: NonNegativeInt = 0
    """Size limit of a store directory in bytes. The least recently used gamuts are removed for new
    ones. 0: no limit, and nothing is removed."""

    store_reserve_bytes: NonNegativeInt = 64 * _MEBIBYTE
    """Free bytes that are kept on the file system of a store directory. A new gamut that would use
    them is answered with 507."""

    keep_inputs: bool = True
    """Keep the input of a gamut, so that a damaged gamut can be rebuilt, and recipes be asked
    for."""

    broker: str = Field(default="", repr=False)  # it may contain a password
    """URL of the Redis server (`redis://` or `rediss://`) that passes builds to `gamut worker`
    processes. Empty: this process builds. A broker requires a bucket as store."""

    host: str = "127.0.0.1"
    """Listening address of `gamut serve`."""

    port: int = Field(default=8000, ge=0, le=65535)
    """Listening port of `gamut serve`; 0 selects a free port."""

    api_keys: Annotated[str, _checked(ApiKeys)] = ""
    """API keys as digests, as `gamut key NAME` prints them: `NAME:SCOPES:SHA256` or
    `NAME:SCOPES:SHA256:EXPIRY`, separated by commas. Scopes are `read`, `build` and `write`, joined
    by `+`."""

    api_keys_file: str = ""
    """File with further API keys, one per line; `#` begins a comment. It is read again on SIGHUP. A
    file with a fault is then ignored, and the fault is logged."""

    allow_anonymous: Literal["auto", "none", "read", "all"] = "auto"
    """Permissions of requests without a key. `auto`: none if there are keys; otherwise all, on a
    loopback address only."""

    rate_limit: NonNegativeFloat = 0.0
    """Requests per second for each key, or for each address without a key; more are answered with
    429. 0: no limit."""

    rate_burst: PositiveInt = 100
    """Number of requests that may arrive at once within the rate limit."""

    build_rate_limit: NonNegativeFloat = 0.0
    """Requests per minute that build, for each key or address; more are answered with 429. 0: no
    limit."""

    build_rate_burst: PositiveInt = 10
    """Number of building requests that may arrive at once within their rate limit."""

    hosts: Annotated[str, _checked(host_names)] = ""
    """Names of the service, separated by commas, with an optional port, such as
    `gamut.example.org` or `*.example.org`. Requests with another `Host` are answered with 403,
    except for probes and loopback addresses. Empty: any name; on a loopback address without keys,
    loopback addresses only."""

    trusted_proxies: Annotated[str, _checked(_parse_proxies)] = ""
    """Addresses or networks of proxies, separated by commas, whose `X-Forwarded-For` and
    `X-Forwarded-Proto` are used; `*` for all. Empty: the address of the connection is used."""

    cors_origins: Annotated[str, _checked(origins)] = ""
    """Origins whose pages may use the API (CORS), separated by commas, such as
    `https://example.org`; `*` for all."""

    log_level: Literal["critical", "error", "warning", "info", "debug"] = "info"
    """Lowest severity that is logged."""

    log_format: Literal["text", "json"] = "text"
    """`text` for people, `json` for programs, with one object per line."""

    access_log: bool = False
    """Log a line for every request. This costs about a tenth of the throughput."""

    worker_metrics_port: int = Field(default=0, ge=0, le=65535)
    """Port where `gamut worker` serves its metrics on `GAMUT_HOST`; 0: none. `gamut serve` has them
    at `/metrics`."""

    max_body_bytes: int = Field(default=160 * _MEBIBYTE, ge=1024)
    """Largest request body in bytes; a larger one is answered with 413. A picture of 24 megapixels
    has up to 144 MB."""

    max_connections: PositiveInt = 1024
    """Largest number of open connections, idle ones included. Requests on further ones are answered
    with 503."""

    body_timeout: PositiveFloat = 120.0
    """Seconds for the arrival of a body; slower ones are answered with 408."""

    large_bodies: PositiveInt = 32
    """Largest number of bodies over 64 KiB that arrive, or wait to be computed. They are on the
    disk: in `temporary/` of a store directory, in `/tmp` with a bucket. Further ones wait, and are
    answered with 503 after `GAMUT_BODY_TIMEOUT`. A key, or an address without a key, has a quarter
    of them, and at least 2; more are answered with 429."""

    client_requests: PositiveInt = 64
    """Largest number of requests of one key, or of one address without a key, that wait to be
    computed; more are answered with 429. Clients take turns."""

    build_workers: int = Field(default=1, ge=1, le=64)
    """Number of worker processes. Each builds one gamut at a time."""

    build_queue: PositiveInt = 16
    """Largest number of waiting builds; more are answered with 429."""

    build_timeout: PositiveFloat = 120.0
    """Seconds after which a build is ended and fails."""

    build_memory_bytes: Annotated[NonNegativeInt, _memory_or("no limit")] = 2048 * _MEBIBYTE
    """Private memory of a build process in bytes. A build that uses more is ended and fails. 0: no
    limit; otherwise at least 268435456 (256 MiB). A million surface samples take 0.7 GB, a picture
    of 24 megapixels 0.8 GB."""

    client_wait: NonNegativeFloat = 30.0
    """Seconds that POST waits for the build before it answers 202, counted from the time when the
    service can build. Clients can change it with `Prefer: wait=N` or `respond-async`."""

    stop_delay: NonNegativeFloat = 0.0
    """Seconds from SIGTERM, when `/readyz` becomes 503, until the service stops to accept
    connections and builds. Set it above the time in which load balancers notice."""

    drain_seconds: NonNegativeFloat = 20.0
    """Seconds for running builds when the service stops. Unfinished and waiting builds continue
    after the next start."""

    memory_bytes: Annotated[NonNegativeInt, _memory_or("a share of the memory")] = 0
    """Memory of the API process in bytes. Work waits for its memory; a request that needs more than
    seven eighths of it, less 224 MiB for the process, is answered with 422. 0: 60 % of the memory
    of the container or computer, less `GAMUT_BUILD_MEMORY_BYTES` for each worker of this process,
    and at least 469762048 (448 MiB); otherwise at least 268435456 (256 MiB). The full boundary of a
    press takes 100 MB, a link between two presses 0.5 GB, and a mapped picture of 6 megapixels
    0.5 GB."""

    history_cache_bytes: NonNegativeInt = 512 * _MEBIBYTE
    """Memory for open histories in bytes; the least recently used are removed."""

    mesh_cache_bytes: NonNegativeInt = 128 * _MEBIBYTE
    """Memory for encoded meshes in bytes; the least recently used are removed."""

    @field_validator("broker")
    @classmethod
    def _check_broker(cls, broker: str, info: ValidationInfo) -> str:
        if broker and not _BROKER.match(broker):
            message = "must be redis://… or rediss://…"
            raise ValueError(message)
        try:
            _ = urlsplit(broker).port
        except ValueError:
            message = (
                "must have a host and a port, as redis://:password@host:6379/0. Write /, # and ? "
                "of a password as %2F, %23 and %3F."
            )
            raise ValueError(message) from None
        if broker and not is_address(info.data.get("store", "")):
            message = (
                "GAMUT_STORE must be a bucket (s3://…, gs://… or az://…), which the API and the "
                "workers share. A directory belongs to one process."
            )
            raise ValueError(message)
        return broker


def settings_text(settings: Settings, arguments: AbstractSet[str] = frozenset()) -> str:
    """Return the settings in force as ``GAMUT_NAME=value`` lines, grouped by where they come from.

    `arguments` names the fields that the command line gave. The result is an environment file with
    comments; credentials of the broker and digests of API keys become ``***``.
    """
    sources = {
        "command line": settings.model_fields_set & arguments,
        "environment": settings.model_fields_set - arguments,
        "defaults": Settings.model_fields.keys() - settings.model_fields_set,
    }
    lines = []
    for source, names in sources.items():
        lines += [f"# {source}"] if names else []
        for name in (name for name in Settings.model_fields if name in names):
            value = getattr(settings, name)
            text = str(value).lower() if isinstance(value, bool) else str(value)
            for pattern, replacement in _SECRETS.get(name, ()):
                text = pattern.sub(replacement, text)
            lines.append(f"{ENVIRONMENT_PREFIX}{name.upper()}={text}")
    return "\n".join(lines) + "\n"


def settings_table() -> str:
    """Return the Markdown table of all settings: variable, default, meaning."""
    rows = ["| variable | default | meaning |", "|---|---|---|"]
    for name, field in Settings.model_fields.items():
        default = str(field.default).lower() if isinstance(field.default, bool) else field.default
        meaning = " ".join((field.description or "").split())
        rows.append(f"| `{ENVIRONMENT_PREFIX}{name.upper()}` | `{default}` | {meaning} |")
    return "\n".join(rows) + "\n"
