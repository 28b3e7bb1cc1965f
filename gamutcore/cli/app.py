"""The program: its commands, how it reports errors, and its exit status."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Sequence
from typing import Annotated

import typer

from gamutcore.cli import answers, drift, gamuts, links, sections
from gamutcore.version import __version__

__all__ = ["DATA_FAULT", "DEFECT", "USAGE_FAULT", "app", "run"]

DATA_FAULT = 1
"""Exit status if the data, a file or the system is at fault."""

USAGE_FAULT = 2
"""Exit status if an argument or an option is at fault, as for most programs."""

DEFECT = 70
"""Exit status of a defect of the program: EX_SOFTWARE of BSD's sysexits.h."""

TRACEBACK = "GAMUTCORE_TRACEBACK"
"""Environment variable that shows where the program met an unexpected error, if it is not empty."""

EPILOG = (
    "A gamut is given as a file of measurements, a profile, a picture or a mesh, as a saved .gamut "
    "file, or by the name of a reference such as srgb. "
    "Exit status: 0 success, 1 the data or the system is at fault, 2 an argument is at fault, "
    f"70 a defect of the program, whose details {TRACEBACK}=1 shows."
)


_LONGEST = 300
"""Longest part of an unexpected error that is shown, in characters: some hold whole arrays."""

app = typer.Typer(
    name="gamut",
    help="Gamuts of devices, papers, pictures and colour spaces: build them, ask them, draw them.",
    epilog=EPILOG,
    no_args_is_help=True,
    rich_markup_mode=None,  # rich takes a tenth of a second to import
    pretty_exceptions_enable=False,
)


def _show_version(shown: bool) -> None:  # as typer calls it
    if shown:
        typer.echo(__version__)
        raise typer.Exit


@app.callback()
def _program(
    _version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_show_version, is_eager=True, help="Show the version and exit."
        ),
    ] = False,
) -> None:
    pass


gamuts.add_to(app)
answers.add_to(app)
sections.add_to(app)
links.add_to(app)
drift.add_to(app)


def run(program: typer.Typer, arguments: Sequence[str] | None = None) -> int:
    """Run a command line, print errors as one line with the remedy, and return the exit status.

    The arguments are without the program's name; by default they are those of the process.
    """
    try:
        program(None if arguments is None else list(arguments), prog_name="gamut")
    except SystemExit as ended:
        return ended.code if isinstance(ended.code, int) else int(ended.code is not None)
    except BrokenPipeError:  # of `gamut ... | head`
        sys.stderr.close()
        return DATA_FAULT
    except Exception as error:  # noqa: BLE001  # the last handler
        line = _line(error)
        if line is None:
            if os.environ.get(TRACEBACK):
                traceback.print_exc()
            line = _unexpected(error), DEFECT
        typer.echo(f"gamut: {line[0]}", err=True)
        return line[1]
    return 0


def _unexpected(error: Exception) -> str:
    error_text = " ".join(f"{type(error).__name__}: {error}".split())[:_LONGEST].rstrip(".: ")
    return (
        f"unexpected error: {error_text}. This is a defect of the program. Repeat the command with "
        f"{TRACEBACK}=1 in the environment for details, and report them."
    )


def _line(error: Exception) -> tuple[str, int] | None:
    """Return what to print of an error that the user can mend, and the exit status."""
    # imported here: help needs no errors
    from gamutcore.errors import GamutError, OptionError, ReferenceNameError, TriangleCountError  # noqa: PLC0415

    if isinstance(error, GamutError):
        usage = isinstance(error, OptionError | ReferenceNameError | TriangleCountError)
        # an option of a command is named in the message
        shown = {"file"} & error.where.keys() if usage else error.where
        place = ", ".join(f"{name} {error.where[name]}" for name in shown)
        location = f" ({place})" if place else ""
        message = f"{error.message.rstrip('.')}{location}. {error.remedy}".strip()
        return message, USAGE_FAULT if usage else DATA_FAULT
    if isinstance(error, ModuleNotFoundError) and error.name in {"matplotlib", "openpyxl"}:
        return f"{error}", DATA_FAULT
    if isinstance(error, OSError):
        name = f"{error.filename}: " if error.filename else ""
        return f"{name}{error.strerror or error}", DATA_FAULT
    return None
