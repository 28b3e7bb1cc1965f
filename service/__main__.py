"""Entry point of the console script ``gamut`` and of ``python -m service``.

The program is that of `gamutcore.cli`, with the commands of the service. The web packages are the
extra ``service`` of the distribution, and are imported when a command needs them. Without them,
such a command says what to install, and the other commands work.
"""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from gamutcore.cli.app import DATA_FAULT, app, run

if TYPE_CHECKING:
    from types import ModuleType

__all__ = ["main"]

_WEB_PACKAGES = (
    *("fastapi", "httptools", "prometheus_client", "pydantic_settings", "python_multipart"),
    "uvicorn",
)
"""One module of each package that the extra installs and that the service imports at start."""

store_commands = typer.Typer(help="Maintain a store.", no_args_is_help=True)
app.add_typer(store_commands, name="store")


def _command() -> ModuleType:
    """Return the module of the commands, or end the program if the web packages are missing."""
    missing = [name for name in _WEB_PACKAGES if importlib.util.find_spec(name) is None]
    if missing:
        typer.echo(
            f"gamut needs packages that are not installed: {', '.join(missing)}. "
            "Install them with: pip install 'gamut-boundary-service[service]'",
            err=True,
        )
        raise typer.Exit(DATA_FAULT)
    from service import command  # noqa: PLC0415  # needs the web packages

    return command


@app.command()
def serve(
    host: Annotated[str | None, typer.Option(help="Address to listen on.")] = None,
    port: Annotated[int | None, typer.Option(help="Port to listen on; 0 takes a free one.")] = None,
    store: Annotated[
        str | None,
        typer.Option(help="Location of the store: a directory, or s3://, gs://, az://."),
    ] = None,
    print_settings: Annotated[
        bool,
        typer.Option(
            "--print-settings",
            help="Print the settings in force as GAMUT_NAME=value lines, and exit.",
        ),
    ] = False,
) -> None:
    """Serve over HTTP.

    Further settings come from the environment (GAMUT_...).
    """
    overrides = {"host": host, "port": port, "store": store}
    command = _command()
    act = command.print_settings if print_settings else command.serve
    raise typer.Exit(act(overrides))


@app.command()
def worker(
    check: Annotated[
        bool, typer.Option("--check", help="Only check the workers on this host.")
    ] = False,
) -> None:
    """Build the jobs of a broker.

    GAMUT_BROKER and GAMUT_STORE name the broker and the store.
    """
    command = _command()
    raise typer.Exit(command.check_worker() if check else command.work())


@app.command()
def key(
    name: Annotated[str, typer.Argument(help="Lower-case letters, digits and hyphens; public.")],
    scopes: Annotated[str, typer.Option(help="read, build and write, joined by +.")] = "read+write",
    expires: Annotated[
        str,
        typer.Option(help="Date or time in UTC, such as 2027-01-31T12:00Z; default: never."),
    ] = "",
) -> None:
    """Make an API key and its entry for the settings.

    Keys with the scope build may delete and name only what they built themselves.
    """
    raise typer.Exit(_command().make_key(name, frozenset(scopes.split("+")), expires))


@app.command()
def openapi() -> None:
    """Print the OpenAPI document."""
    sys.stdout.write(_command().openapi_document())


@app.command()
def warm() -> None:
    """Compile the kernels in advance."""
    from gamutcore.warm import compile_kernels  # noqa: PLC0415  # a server compiles nothing

    compile_kernels()


@store_commands.command("list")
def list_gamuts(
    location: Annotated[str | None, typer.Argument(help="GAMUT_STORE by default.")] = None,
    outdated: Annotated[
        bool, typer.Option("--outdated", help="Only gamuts of earlier versions of the algorithm.")
    ] = False,
) -> None:
    """List the gamuts of a store; also while a service uses it."""
    raise typer.Exit(_command().list_store(location, outdated=outdated))


@store_commands.command()
def prune(
    location: Annotated[str | None, typer.Argument(help="GAMUT_STORE by default.")] = None,
    older_than: Annotated[
        float,
        typer.Option(min=0, help="Days since the last use, or since the publication in a bucket."),
    ] = 0.0,
    yes: Annotated[bool, typer.Option("--yes", help="Remove them; else only list them.")] = False,
) -> None:
    """Remove the gamuts that an earlier version of the algorithm built.

    No new request gives their ids. A directory must not be in use by a service.
    """
    raise typer.Exit(_command().prune_store(location, older_than=older_than, confirmed=yes))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line, by default with the process's arguments; return its exit status."""
    return run(app, arguments)


if __name__ == "__main__":
    sys.exit(main())
