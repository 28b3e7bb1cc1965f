"""The log: a line for every event, as text for people or as JSON for programs, without secrets.

All loggers, those of the server and of libraries among them, write through one handler to standard
error. A line names the request and the gamut that it is about. What looks like a credential is
blotted out, wherever in the line it is; header fields are not logged to begin with. This module
knows nothing of the web, because the worker processes use it as well.
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

from service.http.request_id import current_request_id
from service.telemetry.traces import current_trace

if TYPE_CHECKING:
    from types import TracebackType

__all__ = ["JsonLines", "TextLines", "configure_logging", "without_secrets"]

_USUAL = frozenset(vars(logging.makeLogRecord({}))) | {"message", "asctime", "color_message"}
"""Attributes that every record has; all others were given with ``extra``."""

_encoded = json.JSONEncoder(separators=(",", ":"), default=repr).encode
"""Made once: `json.dumps` makes another for each line."""

_GAMUT_ID = re.compile(r"\b[0-9a-f]{64}\b")

_NAMES = (
    r"(?:proxy-)?authorization|x-api-key|cookie"
    r"|[\w-]*(?:api[_-]?key|access[_-]?key|account[_-]?key|secret|token|passw(?:or)?d|passwd"
    r"|signature|credentials?|sas)[\w-]*|sig"
)

_SECRET_NAME = re.compile(_NAMES, re.IGNORECASE)

_SECRETS = (
    # the value of a field of such a name, however the two are written: a: b, a=b, 'a': 'b',
    # (b'a', b'b'); of a header field with its scheme
    re.compile(
        rf"""(?P<kept>\b(?:{_NAMES})\b(?:["']?\s*[:=]\s*|["']\s*,\s*)(?:b?["'])?"""
        r"""(?:(?:bearer|basic|digest)\s+)?)"""
        r"""(?P<secret>[^\s"',;&)}\]]+)""",
        re.IGNORECASE,
    ),
    # credentials without a name
    re.compile(r"(?P<kept>\b(?:bearer|basic)\s+)(?P<secret>[A-Za-z0-9._~+/=-]{8,})", re.IGNORECASE),
    # user and password in an address, such as a message broker's
    re.compile(r"(?P<kept>\b[a-z][a-z0-9+.-]*://)(?P<secret>[^\s/@\"']+)(?=@)", re.IGNORECASE),
)

_HINTS = (
    *("authorization", "cookie", "bearer", "basic", "key", "secret", "token", "passw", "://"),
    *("sig", "credential", "sas"),
)
"""One of these is in every text that a pattern finds something in; most lines have none, and need
not be searched."""

_DEEPEST = 8
"""Levels of a value that are logged: it may hold itself."""

_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f\u2028\u2029]")


def without_secrets(text: str) -> str:
    """Return a text in which everything that looks like a credential is three asterisks."""
    if not _may_hold_secret(text):
        return text
    for pattern in _SECRETS:
        text = pattern.sub(r"\g<kept>***", text)
    return text


class TextLines(logging.Formatter):
    """Writes records as lines for people; a traceback follows on lines of its own."""

    def format(self, record: logging.LogRecord) -> str:
        """Return the line of a record."""
        message = _CONTROL.sub(_escaped, without_secrets(record.getMessage()))
        line = f"{_time(record)} {record.levelname} {record.name}: {message}"
        if request_id := _request_id(record):
            line += f" [{request_id}]"
        exception = _exception(record)
        return line if exception is None else f"{line}\n{exception}"


class JsonLines(logging.Formatter):
    """Writes records as one JSON object on one line each.

    Members are ``time``, ``level``, ``logger``, ``message``, where there are such ``request_id``,
    ``trace_id``, ``span_id``, ``gamut_id`` and ``exception``, and everything that was given with
    ``extra``.
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
        if (trace := current_trace()) is not None:
            members["trace_id"], members["span_id"] = trace
        # Jobs have the ids of the gamuts that they build, so this is a job's id as well.
        if found := _GAMUT_ID.search(message):
            members["gamut_id"] = found.group()
        members |= {name: value for name, value in vars(record).items() if name not in _USUAL}
        exception = _exception(record)
        if exception is not None:
            members["exception"] = exception
        try:
            line = _encoded(members)
        except (TypeError, ValueError):
            # names that are no text, or a value within itself
            line = _HINTS[0]
        # One look at the whole line, since nearly none has anything to hide.
        return _encoded(_clean(members)) if _may_hold_secret(line) else line


def configure_logging(log_format: str, level: str) -> None:
    """Let everything that is logged in this process, warnings included, go to standard error.

    Parameters
    ----------
    log_format : str
        ``text`` or ``json``.
    level : str
        Least severity, as in `Settings.log_level`.
    """
    handler = logging.StreamHandler()
    handler.setFormatter(JsonLines() if log_format == "json" else TextLines())
    logging.basicConfig(level=level.upper(), handlers=[handler], force=True)
    logging.captureWarnings(capture=True)
    sys.excepthook = _log_uncaught
    threading.excepthook = _log_uncaught_in_thread


def _time(record: logging.LogRecord) -> str:
    moment = datetime.fromtimestamp(record.created, UTC)
    return moment.isoformat(timespec="milliseconds").replace("+00:00", "Z")


def _request_id(record: logging.LogRecord) -> str:
    given: str = getattr(record, "request_id", "")
    return given or current_request_id()


def _exception(record: logging.LogRecord) -> str | None:
    parts = []
    if record.exc_info and record.exc_info[1] is not None:
        parts.append(logging.Formatter().formatException(record.exc_info))
    if record.stack_info:
        parts.append(record.stack_info)
    return without_secrets("\n".join(parts)) if parts else None


def _escaped(found: re.Match[str]) -> str:
    # A line that is made up inside of a value must not pass for one of the log's own.
    return found.group().encode("unicode_escape").decode("ascii")


@functools.lru_cache(maxsize=1024)
def _is_secret(name: str) -> bool:
    return _SECRET_NAME.fullmatch(name) is not None


def _may_hold_secret(text: str) -> bool:
    lowered = text.lower()
    return any(hint in lowered for hint in _HINTS)


def _clean(value: Any, depth: int = 0) -> Any:  # noqa: ANN401 - whatever was given with extra
    """Return a value as JSON can express it, without secrets."""
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
