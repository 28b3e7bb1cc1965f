"""Gamuts as arguments: a file to build from, a saved gamut, or the name of a reference."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand, TyperOption

from gamutcore.cli.reference_cache import cached_reference

if TYPE_CHECKING:
    from gamutcore.gamut import Gamut

__all__ = [
    "Black",
    "BuildCommand",
    "Compensation",
    "Decode",
    "MaxError",
    "Source",
    "Triangles",
    "asking",
    "choose_option",
    "chosen_options",
    "gamut_of",
    "number_or_text",
    "numbers_of",
]

Source = Annotated[
    str,
    typer.Argument(
        metavar="GAMUT",
        help="A file to build from, a saved .gamut file, or the name of a reference.",
    ),
]
"""A gamut as an argument."""

Triangles = Annotated[int | None, typer.Option(help="Largest triangle count of the level.")]
"""The level by its count."""

Compensation = Annotated[
    bool | None,
    typer.Option(
        "--black-point-compensation/--no-black-point-compensation",
        "--bpc/--no-bpc",
    ),
]
"""Black-point compensation of links, pictures and tables."""

Decode = Annotated[
    str | None,
    typer.Option(
        metavar="CURVE",
        help="How code values of the source become light: bt1886 (displays of video, an exponent "
        "of 2.4), oetf (the inverse of the curve of cameras), pq, hlg or srgb. Default: as "
        "displays of the space or encoding do; bt1886 for BT.709 and BT.2020. Profiles state it.",
    ),
]
"""The decoding of the source of links and pictures."""

MaxError = Annotated[
    float | None,
    typer.Option(help="Largest distance of the level from the full boundary; 0 is the boundary."),
]
"""The level by its error."""

Black = Annotated[str, typer.Option("--gcr", "--black")]
"""How much black: presets of gray component replacement and other rules."""

_CHOSEN = "gamutcore.options"
"""Key of the options of the build in the context of a command."""


class BuildCommand(TyperCommand):
    """A command that may build gamuts: it has an option for each of `gamutcore.options`.

    Parameters of its questions without a help have that of their declarations. The declarations
    take half a second to import, so they are read when the command runs, completes or shows its
    help.
    """

    question = ""

    def get_params(self, ctx: Any) -> list[Any]:  # noqa: ANN401  # typer's own click is private
        """Return the parameters of the command and the options of builds."""
        from gamutcore.options import OPTIONS  # noqa: PLC0415

        own = super().get_params(ctx)
        if self.question:
            _describe(own, self.question)
        taken = {name for option in own for name in option.opts}
        added = [
            TyperOption(
                param_decls=[f"build_{name}", _flag(name, taken)],
                type=str,
                metavar="VALUE",
                help=f"{option.documentation} Accepted: {option.accepted}.",
                callback=_keep,
                expose_value=False,
            )
            for name, option in OPTIONS.items()
        ]
        return [*own, *added]


def asking(question: str) -> type[BuildCommand]:
    """Return the class of a command that asks a question of `gamutcore.questions`."""
    return type("AskingCommand", (BuildCommand,), {"question": question})


def _describe(params: list[Any], question: str) -> None:
    """Give parameters without a help the description that the question declares."""
    from gamutcore.arguments import accepted_values  # noqa: PLC0415
    from gamutcore.questions import QUESTIONS  # noqa: PLC0415

    declared = {option.name: option for option in QUESTIONS[question].all_parameters}
    for option in params:
        if option.name in declared and option.help is None:
            parameter = declared[option.name]
            # the bounds of floats are those of requests
            bounded = not option.is_flag and option.type.name != "float"
            accepted = f" Accepted: {accepted_values(parameter.kind)}." if bounded else ""
            option.help = parameter.description + accepted


def _flag(name: str, taken: set[str]) -> str:
    flag = f"--{name.replace('_', '-')}"
    return f"--gamut-{name.replace('_', '-')}" if flag in taken else flag


def _keep(ctx: typer.Context, param: typer.CallbackParam, value: str | None) -> None:
    if value is not None:
        chosen = ctx.meta.setdefault(_CHOSEN, {})
        chosen[str(param.name).removeprefix("build_")] = value


def chosen_options(ctx: typer.Context) -> Mapping[str, str]:
    """Return the options of the build that a command was given, as texts."""
    chosen: dict[str, str] = ctx.meta.get(_CHOSEN, {})
    return chosen


def choose_option(ctx: typer.Context, name: str, text: str) -> None:
    """Give an option of the build a value, as the command line would."""
    ctx.meta.setdefault(_CHOSEN, {})[name] = text


def gamut_of(
    source: str, ctx: typer.Context, *, alone: bool = True, space: str | None = None
) -> Gamut:
    """Return the gamut of an argument, built with the options of the command.

    Unless the gamut is `alone` in the command, options that do not apply to a saved gamut or a
    reference are meant for the others. `space` is the default of the option of this name.
    """
    from gamutcore.content import gamut_source, is_saved_gamut  # noqa: PLC0415
    from gamutcore.errors import OptionError, errors_in  # noqa: PLC0415
    from gamutcore.gamut import Gamut  # noqa: PLC0415
    from gamutcore.options import OPTIONS, Options, option_value  # noqa: PLC0415

    texts = {**({} if space is None else {"space": space}), **chosen_options(ctx)}
    options: dict[str, Any] = {name: option_value(name, text) for name, text in texts.items()}
    input_data = gamut_source(source)
    if isinstance(input_data, bytes):
        data, reference = input_data, None
        if is_saved_gamut(data):
            if options and alone:
                name, value = next(iter(options.items()))
                raise OptionError.not_applicable(
                    name, value, f"{source} is a gamut that is built already"
                )
            return Gamut.load(source)
    else:
        data, reference = input_data.data, input_data
        if not alone:
            options = {name: options[name] for name in options if _fits(OPTIONS[name].data)}
    chosen = Options.from_mapping(options)

    def build() -> Gamut:
        with _progress(Path(source).name) as report, errors_in(source):
            return Gamut(data, chosen, progress=report)

    if reference is not None:
        return cached_reference(reference, chosen, build)
    gamut = build()
    gamut.name = gamut.name or Path(source).stem
    return gamut


def numbers_of(text: str, option: str, remedy: str) -> list[float]:
    """Return the numbers of an option, which are separated by commas or spaces."""
    try:
        return [float(part) for part in text.replace(",", " ").split()]
    except ValueError as error:
        raise typer.BadParameter(remedy, param_hint=option) from error


def number_or_text(text: str) -> float | str:
    """Return the number that a text is, or the text."""
    try:
        return float(text)
    except ValueError:
        return text


def _fits(kinds: tuple[str, ...]) -> bool:
    return "reference" in kinds


@contextmanager
def _progress(name: str) -> Iterator[Callable[[str, float], None] | bool]:
    """Show a bar on a terminal, and nothing elsewhere."""
    if not sys.stderr.isatty():
        yield False
        return
    from rich.console import Console  # noqa: PLC0415
    from rich.progress import Progress  # noqa: PLC0415

    from gamutcore.building import STAGES  # noqa: PLC0415

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(name, total=len(STAGES))
        yield lambda stage, fraction: bar.update(
            task, completed=STAGES.index(stage) + fraction, description=f"{name}: {stage}"
        )
