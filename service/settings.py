"""Every option of the service, read from the environment with the prefix ``GAMUT_``.

One field is one variable: ``max_body_bytes`` is ``GAMUT_MAX_BODY_BYTES``. The table in
``docs/settings.md`` is `settings_table` of this model, and a test holds the two together.
"""

import ipaddress
import re
from collections.abc import Set as AbstractSet
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, ValidationInfo, field_validator
from pydantic_settings import BaseSettings, SettingsConfigDict

from gamutcore.limits import MAX_PIXELS, MAX_SAMPLES, Limits
from service.access.api_keys import ApiKeys
from service.http.cors import origins
from service.storage.location import is_address

__all__ = ["ENVIRONMENT_PREFIX", "Settings", "settings_table", "settings_text"]

ENVIRONMENT_PREFIX = "GAMUT_"

_MEBIBYTE = 1024 * 1024

_LEAST_BUILD_MEMORY = 256 * _MEBIBYTE
"""Below this the warm process itself, with its libraries and kernels, is beyond the limit."""

_BROKER = re.compile(r"(redis|amqp)s?://")

_SECRETS = {
    "broker": (
        (re.compile(r"://.*@"), "://***@"),
        (re.compile(r"\?.*"), "?***"),  # Redis takes a password from the query as well
    ),
    "api_keys": ((re.compile(r":[0-9a-fA-F]{64}"), ":***"),),
}
"""What hides the secret parts of a setting: patterns with their replacements."""


def _api_keys(text: str) -> str:
    ApiKeys(text)
    return text


def _origins(text: str) -> str:
    origins(text)
    return text


def _proxies(text: str) -> str:
    if text and text != "*":
        for proxy in text.split(","):
            # uvicorn would take what is neither for a name that no connection has.
            ipaddress.ip_network(proxy.strip())
    return text


class Settings(BaseSettings):
    """The service's options, with their defaults and ranges."""

    model_config = SettingsConfigDict(
        env_prefix=ENVIRONMENT_PREFIX, extra="forbid", frozen=True, allow_inf_nan=False
    )

    store: Annotated[
        str,
        Field(
            min_length=1,
            description="Where gamuts, inputs and jobs are kept: a directory, which belongs to one "
            "running service at a time, or `s3://bucket/prefix`, `gs://bucket/prefix` or "
            "`az://container/prefix`, which any number of services share.",
        ),
    ] = "var/gamuts"
    store_bytes: Annotated[
        int,
        Field(
            ge=0,
            description="Most bytes that a directory holds; the gamuts that were not used for the "
            "longest time go for new ones. 0: no limit, and no gamut ever goes.",
        ),
    ] = 0
    store_reserve_bytes: Annotated[
        int,
        Field(
            ge=0,
            description="Bytes of the directory's file system that are left free; beyond that a "
            "new gamut is answered with 507.",
        ),
    ] = 64 * _MEBIBYTE
    keep_inputs: Annotated[
        bool,
        Field(
            description="Keep the input of a gamut, so that it can be built again when its history "
            "turns out to be damaged."
        ),
    ] = True
    broker: Annotated[
        str,
        Field(
            repr=False,  # it has a password
            description="URL of the broker (`redis://`, `rediss://`, `amqp://` or `amqps://`) "
            "whose workers build the gamuts; they are started with `gamut worker`. Empty: this "
            "process builds them itself. Needs a store that is a bucket.",
        ),
    ] = ""
    host: Annotated[str, Field(description="Address that `gamut serve` listens on.")] = "127.0.0.1"
    port: Annotated[
        int,
        Field(ge=0, le=65535, description="Port that `gamut serve` listens on; 0 is any free one."),
    ] = 8000
    api_keys: Annotated[
        str,
        Field(
            description="API keys by their digests, as `gamut key NAME` prints them: "
            "`NAME:SCOPES:SHA256`, between commas. Scopes are `read`, `write` or `read+write`."
        ),
        AfterValidator(_api_keys),
    ] = ""
    allow_anonymous: Annotated[
        Literal["auto", "none", "read", "all"],
        Field(
            description="What requests without a key may do. `auto`: nothing where there are keys, "
            "else all, and then only on a loopback address.",
        ),
    ] = "auto"
    rate_limit: Annotated[
        float,
        Field(
            ge=0,
            description="Requests per second of each key, or of each address without one; 0 for "
            "no limit. Beyond it 429.",
        ),
    ] = 0.0
    rate_burst: Annotated[
        int, Field(ge=1, description="Requests that may come at once before that limit holds.")
    ] = 100
    build_rate_limit: Annotated[
        float,
        Field(ge=0, description="The same for requests that build, per minute."),
    ] = 0.0
    build_rate_burst: Annotated[
        int, Field(ge=1, description="Requests that build that may come at once.")
    ] = 10
    trusted_proxies: Annotated[
        str,
        Field(
            description="Addresses or networks of proxies, between commas, whose `X-Forwarded-For` "
            "and `X-Forwarded-Proto` are believed; `*` for all. Without it, addresses are those of "
            "the connections.",
        ),
        AfterValidator(_proxies),
    ] = ""
    cors_origins: Annotated[
        str,
        Field(
            description="Origins whose pages may use the API (CORS), between commas, such as "
            "`https://example.org`; `*` for all.",
        ),
        AfterValidator(_origins),
    ] = ""
    log_level: Annotated[
        Literal["critical", "error", "warning", "info", "debug"],
        Field(description="Least severity that is logged."),
    ] = "info"
    log_format: Annotated[
        Literal["text", "json"],
        Field(description="`text` for people, `json` for programs: one object on one line each."),
    ] = "text"
    access_log: Annotated[
        bool, Field(description="Log a line for every request (costs about a tenth of the speed).")
    ] = False
    worker_metrics_port: Annotated[
        int,
        Field(
            ge=0,
            le=65535,
            description="Port at which `gamut worker` serves its figures, on `GAMUT_HOST`, for "
            "Prometheus; 0: none. `gamut serve` has them at `/metrics`.",
        ),
    ] = 0
    traces: Annotated[
        Literal["auto", "on", "off"],
        Field(
            description="OpenTelemetry traces, sent by OTLP over HTTP to where the `OTEL_...` "
            "variables say. `auto`: if they name an endpoint and the extra `otel` is installed."
        ),
    ] = "auto"
    max_body_bytes: Annotated[
        int,
        Field(
            ge=1024,
            description="Largest request body; a larger one is answered with 413. "
            "A picture of 24 megapixels has up to 144 MB.",
        ),
    ] = 160 * _MEBIBYTE
    max_head_bytes: Annotated[
        int,
        Field(
            ge=1024,
            description="Largest address and header fields of a request; beyond that 431.",
        ),
    ] = 32 * 1024
    max_connections: Annotated[
        int,
        Field(
            ge=1,
            description="Connections that are open at the same time. Beyond that the one that has "
            "waited longest without a request is closed for a new one; where there is none, 503.",
        ),
    ] = 1024
    head_timeout: Annotated[
        float,
        Field(gt=0, description="Seconds that address and header fields may take; then 408."),
    ] = 10.0
    body_timeout: Annotated[
        float,
        Field(
            gt=0,
            description="Seconds that a body may take, besides those that its size allows; then "
            "408.",
        ),
    ] = 20.0
    min_body_rate: Annotated[
        int,
        Field(ge=1, description="Bytes per second that a body has to arrive with after that."),
    ] = 4096
    write_timeout: Annotated[
        float,
        Field(
            gt=0,
            description="Seconds for which a client may take none of its answer before it is "
            "disconnected.",
        ),
    ] = 30.0
    max_inline_bytes: Annotated[
        int,
        Field(
            ge=1024,
            description="Largest JSON body with inline samples; larger data is sent as a file. "
            "Decoding JSON holds up all other requests, about 0.1 s per mebibyte.",
        ),
    ] = _MEBIBYTE
    max_surface_samples: Annotated[
        int,
        Field(
            ge=100_000,  # the default of the option has to remain acceptable
            description="Largest `surface_samples` that is accepted.",
        ),
    ] = 1_000_000
    max_patches: Annotated[
        int,
        Field(
            ge=4,
            le=MAX_SAMPLES,
            description="Most samples (patches) that characterisation data may have.",
        ),
    ] = MAX_SAMPLES
    max_pixels: Annotated[
        int,
        Field(ge=1, le=MAX_PIXELS, description="Most pixels that a picture may have."),
    ] = MAX_PIXELS
    max_form_parts: Annotated[
        int,
        Field(ge=2, description="Most fields, and most files, of a form; beyond that 413."),
    ] = 40
    build_workers: Annotated[
        int,
        Field(ge=1, le=64, description="Worker processes, each building one gamut at a time."),
    ] = 1
    build_queue: Annotated[
        int,
        Field(ge=1, description="Builds that may wait for a worker; beyond that POST answers 429."),
    ] = 16
    build_timeout: Annotated[
        float,
        Field(gt=0, description="Seconds after which a build is ended and reported as failed."),
    ] = 120.0
    build_memory_bytes: Annotated[
        int,
        Field(
            ge=0,
            description="Memory of its own that a build's process may have in use, beyond which it "
            "is ended and reported as failed: at least 268435456 (256 MiB), less than which lets "
            "nothing be built. 0: no limit. A million surface samples take 0.7 GB, a picture of "
            "24 megapixels 0.8 GB.",
        ),
    ] = 2048 * _MEBIBYTE
    build_attempts: Annotated[
        int,
        Field(
            ge=1,
            le=10,
            description="How often a build is started that dies, with its worker or with the whole "
            "service, before it is given up.",
        ),
    ] = 3
    build_lease: Annotated[
        float,
        Field(
            ge=3,
            description="Seconds after which a build of a `gamut worker` that is not heard of any "
            "more is given to another. Clocks of the hosts have to agree much better than that.",
        ),
    ] = 20.0
    resend_seconds: Annotated[
        float,
        Field(
            ge=1,
            description="Seconds after which a build that nobody has begun, though nothing waits "
            "in the broker's queue, is sent to the broker again.",
        ),
    ] = 30.0
    client_wait: Annotated[
        float,
        Field(
            ge=0,
            description="Seconds that POST waits for the build before it answers 202, "
            "unless the client says otherwise with `Prefer: wait=N` or `respond-async`.",
        ),
    ] = 30.0
    max_client_wait: Annotated[
        float, Field(ge=0, description="Longest `Prefer: wait=N` that is honoured, in seconds.")
    ] = 300.0
    drain_seconds: Annotated[
        float,
        Field(
            ge=0,
            description="How long a stopping service lets the builds finish that are running. "
            "Those that do not, and those that wait, are taken up at the next start.",
        ),
    ] = 20.0
    job_retention_seconds: Annotated[
        float,
        Field(ge=0, description="How long a finished job can be looked up. Gamuts stay."),
    ] = 86_400.0
    max_event_streams: Annotated[
        int,
        Field(ge=0, description="Clients that may follow jobs by server-sent events at a time."),
    ] = 256
    history_cache_bytes: Annotated[
        int,
        Field(ge=0, description="Memory for opened histories; the least recently used go first."),
    ] = 512 * _MEBIBYTE
    mesh_cache_bytes: Annotated[
        int,
        Field(ge=0, description="Memory for encoded meshes; the least recently used go first."),
    ] = 128 * _MEBIBYTE
    max_batch_meshes: Annotated[
        int,
        Field(ge=1, le=10_000, description="Most meshes that one request may ask for together."),
    ] = 100
    max_batch_triangles: Annotated[
        int,
        Field(
            ge=4,
            le=40_000_000,  # of OBJ they have less than the 4 GiB that a zip archive holds
            description="Most triangles that all meshes of such a request may have together.",
        ),
    ] = 10_000_000
    max_page_size: Annotated[
        int, Field(ge=1, le=1000, description="Most gamuts that one page of the list holds.")
    ] = 100

    @field_validator("build_memory_bytes")
    @classmethod
    def _memory_that_a_build_can_do_with(cls, limit: int) -> int:
        if 0 < limit < _LEAST_BUILD_MEMORY:
            message = f"must be 0 (no limit) or at least {_LEAST_BUILD_MEMORY} (256 MiB)"
            raise ValueError(message)
        return limit

    @field_validator("broker")
    @classmethod
    def _broker_of_a_shared_store(cls, broker: str, info: ValidationInfo) -> str:
        if broker and not _BROKER.match(broker):
            message = "must be redis://…, rediss://…, amqp://… or amqps://…"
            raise ValueError(message)
        if broker and not is_address(info.data.get("store", "")):
            message = (
                "GAMUT_STORE must be a bucket (s3://…, gs://… or az://…) that the API and the "
                "workers share: a directory belongs to one process"
            )
            raise ValueError(message)
        return broker

    @property
    def data_limits(self) -> Limits:
        """How much characterisation data a build accepts."""
        return Limits(self.max_patches, self.max_pixels)


def settings_text(settings: Settings, arguments: AbstractSet[str] = frozenset()) -> str:
    """Return the settings in force as ``GAMUT_NAME=value`` lines, grouped by where they come from.

    Parameters
    ----------
    settings : Settings
    arguments : set of str
        Names of the fields that the command line gave.

    Returns
    -------
    str
        An environment file with comments. Credentials of the broker and digests of API keys are
        replaced by ``***``.
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
