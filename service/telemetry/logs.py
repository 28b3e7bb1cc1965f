"""The log: one line per event, as text or JSON, without secrets.

All loggers, including those of the server and of libraries, write to standard error through one
handler. A line names the request and the gamut. Text that looks like a credential is masked; header
fields are never logged. The module does not import the web framework, because worker processes use
it too.
"""

from __future__ import annotations

import functools
import json
import logging
import re
import sys
import threading
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

from service.http.request_context import current_request_id

if TYPE_CHECKING:
    from types import TracebackType

__all__ = ["JsonLines", "TextLines", "complain", "configure_logging", "without_secrets"]

_USUAL = frozenset(vars(logging.makeLogRecord({}))) | {"message", "asctime", "color_message"}
"""Attributes of every record. All others were given with ``extra``."""

_encoded = json.JSONEncoder(separators=(",", ":"), default=repr).encode
"""Made once, because `json.dumps` would make an encoder per line."""

_GAMUT_ID = re.compile(r"\b[0-9a-f]{64}\b")

_NAMES = (
    r"(?:proxy-)?authorization|x-api-key|cookie"
    r"|[\w-]*(?:api[_-]?key|access[_-]?key|account[_-]?key|secret|token|passw(?:or)?d|passwd"
    r"|signature|credentials?|sas)[\w-]*|sig"
)

_SECRET_NAME = re.compile(_NAMES, re.IGNORECASE)

_SECRETS = (
    # The value of a field with such a name, in any notation: a: b, a=b, 'a': 'b', (b'a', b'b'); for
    # a header field with its scheme.
    re.compile(
        rf"""(?P<name>\b(?:{_NAMES})\b(?:["']?\s*[:=]\s*|["']\s*,\s*)(?:b?["'])?"""
        r"""(?:(?:bearer|basic|digest)\s+)?)"""
        r"""(?P<secret>[^\s"',;&)}\]]+)""",
        re.IGNORECASE,
    ),
    # Credentials without a name.
    re.compile(r"(?P<name>\b(?:bearer|basic)\s+)(?P<secret>[A-Za-z0-9._~+/=-]{8,})", re.IGNORECASE),
    # User and password in an address, such as a broker's.
    re.compile(r"(?P<name>\b[a-z][a-z0-9+.-]*://)(?P<secret>[^\s/@\"']+)(?=@)", re.IGNORECASE),
)

_API_KEY = re.compile(r"(?P<name>gamut_[a-z0-9-]{1,32}_)(?P<secret>[A-Za-z0-9_-]{16,})")
"""An API key of this service, whole or with its end cut off, wherever it stands."""

_HINTS = (
    *("authorization", "cookie", "bearer", "basic", "key", "secret", "token", "passw", "://"),
    *("sig", "credential", "sas"),
)
"""Every text that matches a pattern of `_SECRETS` contains one of these. Most lines contain none,
and need no search."""

_DEEPEST = 8
"""Nesting depth of logged values, which may contain themselves."""

_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f\u2028\u2029]")


def without_secrets(text: str) -> str:
    """Return a text with apparent credentials masked: ``token=abc123`` becomes ``token=***``."""
    if not _may_hold_secret(text):
        return text
    for pattern in (_API_KEY, *_SECRETS):
        text = pattern.sub(r"\g<name>***", text)
    return text


class TextLines(logging.Formatter):
    """Formats records as lines for people. The lines of a traceback follow."""

    def format(self, record: logging.LogRecord) -> str:
        """Return the line of a record."""
        message = _CONTROL.sub(_escape, without_secrets(record.getMessage()))
        line = f"{_time(record)} {record.levelname} {record.name}: {message}"
        if request_id := _request_id(record):
            line += f" [{without_secrets(request_id)}]"
        exception = _exception(record)
        return line if exception is None else f"{line}\n{exception}"


class JsonLines(logging.Formatter):
    """Formats records as one JSON object per line.

    Members are ``time``, ``level``, ``logger``, ``message``, and everything given with ``extra``.
    If available, ``request_id``, ``gamut_id`` and ``exception`` follow.
    """

    def format(self, record: logging.LogRecord) -> str:
        """Return the line of a record."""
        message = record.getMessage()
        members: dict[str, Any] = {
            "time": _time(record),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": message,
        }
        if request_id := _request_id(record):
            members["request_id"] = request_id
        # A job has the id of its gamut.
        if gamut_id := _GAMUT_ID.search(message):
            members["gamut_id"] = gamut_id.group()
        members |= {name: value for name, value in vars(record).items() if name not in _USUAL}
        exception = _exception(record)
        if exception is not None:
            members["exception"] = exception
        try:
            line = _encoded(members)
        except (TypeError, ValueError):
            # Names that are not text, or a value that contains itself.
            line = _HINTS[0]
        # One check of the whole line, because nearly no line has secrets.
        return _encoded(_clean(members)) if _may_hold_secret(line) else line


def configure_logging(log_format: str, level: str) -> None:
    """Send all log records of this process, warnings included, to standard error.

    The format is ``text`` or ``json``; `level` is the lowest severity, as in `Settings.log_level`.
    """
    handler = logging.StreamHandler()
    handler.setFormatter(JsonLines() if log_format == "json" else TextLines())
    logging.basicConfig(level=level.upper(), handlers=[handler], force=True)
    logging.captureWarnings(capture=True)
    sys.excepthook = _log_uncaught
    threading.excepthook = _log_uncaught_in_thread


def complain(text: str) -> None:
    """Report why a command ends: as a line for people, or as a log record if the log is JSON."""
    handlers = logging.getLogger().handlers
    if any(isinstance(handler.formatter, JsonLines) for handler in handlers):
        logging.getLogger("service").error("%s", text)
    else:
        sys.stderr.write(f"gamut: {text}\n")


def _time(record: logging.LogRecord) -> str:
    moment = datetime.fromtimestamp(record.created, UTC)
    return moment.isoformat(timespec="milliseconds").replace("+00:00", "Z")


def _request_id(record: logging.LogRecord) -> str:
    identifier: str = getattr(record, "request_id", "")
    return identifier or current_request_id()


def _exception(record: logging.LogRecord) -> str | None:
    parts = []
    if record.exc_info and record.exc_info[1] is not None:
        parts.append(logging.Formatter().formatException(record.exc_info))
    if record.stack_info:
        parts.append(record.stack_info)
    return without_secrets("\n".join(parts)) if parts else None


def _escape(character: re.Match[str]) -> str:
    # A value must not be able to forge a line of the log.
    return character.group().encode("unicode_escape").decode("ascii")


@functools.lru_cache(maxsize=1024)
def _is_secret(name: str) -> bool:
    return _SECRET_NAME.fullmatch(name) is not None


def _may_hold_secret(text: str) -> bool:
    lowered = text.lower()
    return any(hint in lowered for hint in _HINTS) or _API_KEY.search(text) is not None


def _clean(value: Any, depth: int = 0) -> Any:  # noqa: ANN401 - whatever was given with extra
    """Return a value as JSON-able data without secrets."""
    if value is None or isinstance(value, bool | int | float):
        return value
    if depth > _DEEPEST:
        return "..."
    if isinstance(value, Mapping):
        return {
            str(name): "***" if _is_secret(str(name)) else _clean(member, depth + 1)
            for name, member in value.items()
        }
    if isinstance(value, list | tuple | set | frozenset):
        return [_clean(member, depth + 1) for member in value]
    return without_secrets(value if isinstance(value, str) else repr(value))


def _log_uncaught(
    kind: type[BaseException], error: BaseException, traceback: TracebackType | None
) -> None:
    if issubclass(kind, KeyboardInterrupt):
        sys.__excepthook__(kind, error, traceback)
        return
    logging.getLogger("service").critical("uncaught", exc_info=(kind, error, traceback))


def _log_uncaught_in_thread(arguments: threading.ExceptHookArgs) -> None:
    if arguments.exc_value is not None and not isinstance(arguments.exc_value, SystemExit):
        _log_uncaught(arguments.exc_type, arguments.exc_value, arguments.exc_traceback)
