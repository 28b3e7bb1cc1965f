"""Settings of the service, read from environment variables with the prefix ``GAMUT_``.

Each field is one variable: ``max_body_bytes`` is ``GAMUT_MAX_BODY_BYTES``. `settings_table` renders
the table in ``docs/settings.md``, and a test compares both.
"""

import ipaddress
import re
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, ValidationInfo, field_validator
from pydantic_settings import BaseSettings, SettingsConfigDict

from gamutcore.limits import MAX_PIXELS, MAX_SAMPLES, Limits
from service.access.api_keys import ApiKeys
from service.http.cors import origins
from service.storage.location import is_address

__all__ = ["ENVIRONMENT_PREFIX", "Settings", "settings_table"]

ENVIRONMENT_PREFIX = "GAMUT_"

_MEBIBYTE = 1024 * 1024

_LEAST_BUILD_MEMORY = 256 * _MEBIBYTE
"""Below this limit, the warm process itself exceeds the limit."""

_BROKER = re.compile(r"(redis|amqp)s?://")


def _check_api_keys(text: str) -> str:
    ApiKeys(text)
    return text


def _check_origins(text: str) -> str:
    origins(text)
    return text


def _check_proxies(text: str) -> str:
    if text and text != "*":
        for proxy in text.split(","):
            # uvicorn would accept any other text as a name that matches no connection.
            ipaddress.ip_network(proxy.strip())
    return text


class Settings(BaseSettings):
    """The settings of the service with defaults and ranges."""

    model_config = SettingsConfigDict(
        env_prefix=ENVIRONMENT_PREFIX, extra="forbid", frozen=True, allow_inf_nan=False
    )

    store: Annotated[
        str,
        Field(
            min_length=1,
            description="Location of gamuts, inputs and jobs: a directory, which belongs to one "
            "running service at a time, or `s3://bucket/prefix`, `gs://bucket/prefix` "
            "or `az://container/prefix`, which any number of services share.",
        ),
    ] = "var/gamuts"
    store_bytes: Annotated[
        int,
        Field(
            ge=0,
            description="Size limit of a store directory in bytes. The least recently used gamuts "
            "are removed for new ones. 0: no limit, and no gamut is removed.",
        ),
    ] = 0
    store_reserve_bytes: Annotated[
        int,
        Field(
            ge=0,
            description="Free bytes that are kept on the file system of a store directory. A new "
            "gamut that would use them is answered with 507.",
        ),
    ] = 64 * _MEBIBYTE
    keep_inputs: Annotated[
        bool,
        Field(description="Keep the input of a gamut, so that a damaged gamut can be rebuilt."),
    ] = True
    broker: Annotated[
        str,
        Field(
            repr=False,  # it may contain a password
            description="URL of the broker (`redis://`, `rediss://`, `amqp://` or `amqps://`) that"
            " passes builds to `gamut worker` processes. Empty: this process builds. A"
            " broker requires a bucket as store.",
        ),
    ] = ""
    host: Annotated[str, Field(description="Listening address of `gamut serve`.")] = "127.0.0.1"
    port: Annotated[
        int,
        Field(
            ge=0, le=65535, description="Listening port of `gamut serve`; 0 selects a free port."
        ),
    ] = 8000
    api_keys: Annotated[
        str,
        Field(
            description="API keys as digests, as `gamut key NAME` prints them: "
            "`NAME:SCOPES:SHA256`, separated by commas. Scopes are `read`, `write` or "
            "`read+write`."
        ),
        AfterValidator(_check_api_keys),
    ] = ""
    allow_anonymous: Annotated[
        Literal["auto", "none", "read", "all"],
        Field(
            description="Permissions of requests without a key. `auto`: none if there are keys; "
            "otherwise all, on a loopback address only.",
        ),
    ] = "auto"
    rate_limit: Annotated[
        float,
        Field(
            ge=0,
            description="Requests per second for each key, or for each address without a key; more"
            " are answered with 429. 0: no limit.",
        ),
    ] = 0.0
    rate_burst: Annotated[
        int,
        Field(
            ge=1, description="Number of requests that may arrive at once within the rate limit."
        ),
    ] = 100
    build_rate_limit: Annotated[
        float,
        Field(
            ge=0,
            description="Requests per minute that build, for each key or address; more are "
            "answered with 429. 0: no limit.",
        ),
    ] = 0.0
    build_rate_burst: Annotated[
        int,
        Field(
            ge=1,
            description="Number of building requests that may arrive at once within their rate "
            "limit.",
        ),
    ] = 10
    trusted_proxies: Annotated[
        str,
        Field(
            description="Addresses or networks of proxies, separated by commas, whose "
            "`X-Forwarded-For` and `X-Forwarded-Proto` are used; `*` for all. Empty: "
            "the address of the connection is used.",
        ),
        AfterValidator(_check_proxies),
    ] = ""
    cors_origins: Annotated[
        str,
        Field(
            description="Origins whose pages may use the API (CORS), separated by commas, such as "
            "`https://example.org`; `*` for all.",
        ),
        AfterValidator(_check_origins),
    ] = ""
    log_level: Annotated[
        Literal["critical", "error", "warning", "info", "debug"],
        Field(description="Lowest severity that is logged."),
    ] = "info"
    log_format: Annotated[
        Literal["text", "json"],
        Field(description="`text` for people, `json` for programs, with one object per line."),
    ] = "text"
    access_log: Annotated[
        bool,
        Field(
            description="Log a line for every request. This costs about a tenth of the throughput."
        ),
    ] = False
    worker_metrics_port: Annotated[
        int,
        Field(
            ge=0,
            le=65535,
            description="Port where `gamut worker` serves its metrics on `GAMUT_HOST`; 0: none. "
            "`gamut serve` has them at `/metrics`.",
        ),
    ] = 0
    traces: Annotated[
        Literal["auto", "on", "off"],
        Field(
            description="OpenTelemetry traces, sent by OTLP over HTTP to the endpoint in the "
            "`OTEL_...` variables. `auto`: on if an endpoint is set and the extra "
            "`otel` is installed."
        ),
    ] = "auto"
    max_body_bytes: Annotated[
        int,
        Field(
            ge=1024,
            description="Largest request body in bytes; a larger one is answered with 413. A "
            "picture of 24 megapixels has up to 144 MB.",
        ),
    ] = 160 * _MEBIBYTE
    max_head_bytes: Annotated[
        int,
        Field(
            ge=1024,
            description="Largest request target and header fields in bytes; more are answered with"
            " 431.",
        ),
    ] = 32 * 1024
    max_connections: Annotated[
        int,
        Field(
            ge=1,
            description="Largest number of open connections. For a new one, the connection that "
            "has been idle longest is closed; if none is idle, the answer is 503.",
        ),
    ] = 1024
    head_timeout: Annotated[
        float,
        Field(
            gt=0,
            description="Seconds within which the request target and the header fields must "
            "arrive; later ones are answered with 408.",
        ),
    ] = 10.0
    body_timeout: Annotated[
        float,
        Field(
            gt=0,
            description="Seconds for a body, in addition to the time that its size allows; slower "
            "ones are answered with 408.",
        ),
    ] = 20.0
    min_body_rate: Annotated[
        int,
        Field(
            ge=1,
            description="Smallest rate of a body in bytes per second, after `GAMUT_BODY_TIMEOUT`.",
        ),
    ] = 4096
    write_timeout: Annotated[
        float,
        Field(
            gt=0,
            description="Seconds after which a client that reads nothing of its answer is "
            "disconnected.",
        ),
    ] = 30.0
    max_inline_bytes: Annotated[
        int,
        Field(
            ge=1024,
            description="Largest JSON body with inline samples in bytes; larger data must be sent "
            "as a file. Decoding JSON blocks other requests for about 0.1 s per "
            "mebibyte.",
        ),
    ] = _MEBIBYTE
    max_surface_samples: Annotated[
        int,
        Field(
            ge=100_000,  # at least the default of the option
            description="Largest accepted value of the option `surface_samples`.",
        ),
    ] = 1_000_000
    max_patches: Annotated[
        int,
        Field(
            ge=4,
            le=MAX_SAMPLES,
            description="Largest number of samples (patches) in characterisation data.",
        ),
    ] = MAX_SAMPLES
    max_pixels: Annotated[
        int,
        Field(ge=1, le=MAX_PIXELS, description="Largest number of pixels in a picture."),
    ] = MAX_PIXELS
    max_form_parts: Annotated[
        int,
        Field(
            ge=2,
            description="Largest number of fields, and of files, in a form; more are answered with"
            " 413.",
        ),
    ] = 10
    build_workers: Annotated[
        int,
        Field(
            ge=1, le=64, description="Number of worker processes. Each builds one gamut at a time."
        ),
    ] = 1
    build_queue: Annotated[
        int,
        Field(ge=1, description="Largest number of waiting builds; more are answered with 429."),
    ] = 16
    build_timeout: Annotated[
        float,
        Field(gt=0, description="Seconds after which a build is ended and fails."),
    ] = 120.0
    build_memory_bytes: Annotated[
        int,
        Field(
            ge=0,
            description="Private memory of a build process in bytes. A build that uses more is "
            "ended and fails. 0: no limit; otherwise at least 268435456 (256 MiB). A "
            "million surface samples take 0.7 GB, a picture of 24 megapixels 0.8 GB.",
        ),
    ] = 2048 * _MEBIBYTE
    build_attempts: Annotated[
        int,
        Field(
            ge=1,
            le=10,
            description="Number of attempts of a build whose process or service dies, before the "
            "build fails.",
        ),
    ] = 3
    build_lease: Annotated[
        float,
        Field(
            ge=3,
            description="Seconds after which another `gamut worker` takes over a build without a "
            "heartbeat. The clocks of all hosts must agree much more closely.",
        ),
    ] = 20.0
    resend_seconds: Annotated[
        float,
        Field(
            ge=1,
            description="Seconds after which an unstarted build is sent to the broker again, if "
            "the broker's queue is empty.",
        ),
    ] = 30.0
    client_wait: Annotated[
        float,
        Field(
            ge=0,
            description="Seconds that POST waits for the build before it answers 202. Clients can "
            "change it with `Prefer: wait=N` or `respond-async`.",
        ),
    ] = 30.0
    max_client_wait: Annotated[
        float, Field(ge=0, description="Largest accepted `Prefer: wait=N` in seconds.")
    ] = 300.0
    drain_seconds: Annotated[
        float,
        Field(
            ge=0,
            description="Seconds for running builds when the service stops. Unfinished and waiting"
            " builds continue after the next start.",
        ),
    ] = 20.0
    job_retention_seconds: Annotated[
        float,
        Field(ge=0, description="Seconds for which a finished job can be read. Gamuts stay."),
    ] = 86_400.0
    max_event_streams: Annotated[
        int,
        Field(
            ge=0, description="Largest number of clients that follow jobs by server-sent events."
        ),
    ] = 256
    history_cache_bytes: Annotated[
        int,
        Field(
            ge=0,
            description="Memory for open histories in bytes; the least recently used are removed.",
        ),
    ] = 512 * _MEBIBYTE
    mesh_cache_bytes: Annotated[
        int,
        Field(
            ge=0,
            description="Memory for encoded meshes in bytes; the least recently used are removed.",
        ),
    ] = 128 * _MEBIBYTE
    max_batch_meshes: Annotated[
        int,
        Field(ge=1, le=10_000, description="Largest number of meshes in one request."),
    ] = 100
    max_batch_triangles: Annotated[
        int,
        Field(
            ge=4,
            le=40_000_000,  # as OBJ less than 4 GiB, the limit of a zip archive
            description="Largest number of triangles of all meshes in one request.",
        ),
    ] = 10_000_000
    max_page_size: Annotated[
        int, Field(ge=1, le=1000, description="Largest number of entries on a page of a list.")
    ] = 100

    @field_validator("build_memory_bytes")
    @classmethod
    def _check_build_memory(cls, limit: int) -> int:
        if 0 < limit < _LEAST_BUILD_MEMORY:
            message = f"must be 0 (no limit) or at least {_LEAST_BUILD_MEMORY} (256 MiB)"
            raise ValueError(message)
        return limit

    @field_validator("broker")
    @classmethod
    def _check_broker(cls, broker: str, info: ValidationInfo) -> str:
        if broker and not _BROKER.match(broker):
            message = "must be redis://…, rediss://…, amqp://… or amqps://…"
            raise ValueError(message)
        if broker and not is_address(info.data.get("store", "")):
            message = (
                "GAMUT_STORE must be a bucket (s3://…, gs://… or az://…), which the API and the "
                "workers share. A directory belongs to one process."
            )
            raise ValueError(message)
        return broker

    @property
    def data_limits(self) -> Limits:
        """Limits of the characterisation data of a build."""
        return Limits(self.max_patches, self.max_pixels)


def settings_table() -> str:
    """Return the Markdown table of all settings.

    Returns
    -------
    str
        One row per field of `Settings`: variable, default, meaning.
    """
    rows = ["| variable | default | meaning |", "|---|---|---|"]
    for name, field in Settings.model_fields.items():
        default = str(field.default).lower() if isinstance(field.default, bool) else field.default
        rows.append(f"| `{ENVIRONMENT_PREFIX}{name.upper()}` | `{default}` | {field.description} |")
    return "\n".join(rows) + "\n"
