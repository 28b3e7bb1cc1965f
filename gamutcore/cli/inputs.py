"""Gamuts as arguments: a file to build from, a saved gamut, or the name of a reference."""

from __future__ import annotations

import copy
import glob
import inspect
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from errno import EISDIR, ENOENT
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand

from gamutcore.cli.reference_cache import cached_reference

if TYPE_CHECKING:
    from gamutcore.gamut import Gamut

__all__ = [
    "Black",
    "BuildCommand",
    "Compensation",
    "Decode",
    "Instrument",
    "MaxError",
    "Noise",
    "Source",
    "Triangles",
    "WithInterval",
    "asking",
    "check_interval_options",
    "choose_option",
    "chosen_options",
    "gamut_of",
    "gamuts_of",
    "is_pattern",
    "number_or_text",
    "numbers_of",
    "share_of",
]

Source = Annotated[
    str,
    typer.Argument(
        metavar="GAMUT",
        help="A file, .gamut file or reference. Files are measurements, profiles, pictures or "
        "meshes, which are built with the options; references have names such as srgb.",
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

WithInterval = Annotated[
    bool,
    typer.Option("--interval", help="Intervals of 95 % of the figures."),
]
"""Intervals instead of figures."""

Noise = Annotated[
    float | None,
    typer.Option(
        metavar="DE",
        help="Noise of readings for the interval: root mean square ΔE*ab of one reading. By "
        "default that of repeated patches in the data.",
    ),
]
"""The noise of readings."""

Instrument = Annotated[
    float,
    typer.Option(
        metavar="DE",
        help="Error that all readings have in common, in ΔE*ab, for the interval.",
    ),
]
"""What never averages out."""

Black = Annotated[str, typer.Option("--gcr", "--black")]
"""How much black: presets of gray component replacement and other rules."""

SAVED, TABLES = ".gamut", frozenset({".txt", ".csv", ".tsv", ".json", ".npy"})
"""Suffix of saved gamuts, and suffixes of files in a folder that may be something else."""

_CHOSEN = "gamutcore.options"
"""Key of the options of the build in the context of a command."""


_ALL = "gamutcore.help"
"""Key in the context of a command whose help shows all options."""

BUILD_GROUP = "Building the gamut"

GROUPS: Mapping[str, str] = {
    **dict.fromkeys(("triangles", "max_error", "side"), "Level"),
    **dict.fromkeys(("colours_in", "columns", "scale"), "Table of colours"),
    **dict.fromkeys(("depth", "lookup_table", "heat_map", "to", "iterations"), "Pictures"),
    **dict.fromkeys(("interval", "noise", "repeats", "instrument", "same_instrument"), "Interval"),
    **dict.fromkeys(("output", "as_json", "as_csv"), "Output"),
}
"""Groups of the help by the names of options; others are under "Options"."""

RARE = frozenset(
    {
        *("max_error", "side", "tolerance", "edge_width", "columns", "scale", "focus"),
        *("black_point_compensation", "decode", "preserve", "source_gamut", "gamut_boundary"),
        *("lookup_table", "heat_map", "iterations"),
        *("noise", "repeats", "instrument", "same_instrument"),
    }
)
"""Options that the short help leaves out, beside most of those of builds."""

USUAL = ("intent", "ink_limit", "space")
"""Options of builds in the short help."""

TERM = 24
"""Characters of an option in the help before its text."""


class BuildCommand(TyperCommand):
    """A command that may build gamuts: it has an option for each of `gamutcore.options`.

    Parameters of its questions without a help have that of their declarations. The declarations
    take half a second to import, so they are read when the command runs, completes or shows its
    help.

    Its help fits one screen: the first sentence about the command and about each option that is
    asked often. --help-all shows everything.
    """

    question = ""

    def get_params(self, ctx: Any) -> list[Any]:  # noqa: ANN401  # typer's own click is private
        """Return the parameters of the command and the options of builds."""
        own = super().get_params(ctx)
        if self.question:
            _describe(own, self.question)
        taken = {name for option in own for name in option.opts}
        return [*own, *_build_options(taken)]

    def invoke(self, ctx: Any) -> Any:  # noqa: ANN401
        """Run the command, unless a file cannot be written for lack of its folder."""
        for name in ("output", "heat_map"):
            if ctx.params.get(name) is not None:
                path = Path(ctx.params[name])
                if not path.parent.is_dir():
                    raise FileNotFoundError(ENOENT, "There is no such folder.", str(path.parent))
                if path.is_dir():
                    raise IsADirectoryError(EISDIR, "This is a folder. Name a file.", str(path))
        return super().invoke(ctx)

    def format_help_text(self, ctx: Any, formatter: Any) -> None:  # noqa: ANN401
        """Write what the command does: the first paragraph, unless all is asked for."""
        text = inspect.cleandoc(self.help or "")
        formatter.write_paragraph()
        with formatter.indentation():
            formatter.write_text(text if _ALL in ctx.meta else text.partition("\n\n")[0])

    def format_options(self, ctx: Any, formatter: Any) -> None:  # noqa: ANN401
        """Write the arguments and the options in groups."""
        groups: dict[str, list[tuple[str, str]]] = {"Arguments": [], "Options": []}
        for param in self.get_params(ctx):
            shown = param if _ALL in ctx.meta else _in_short(param)
            if shown is not None:
                groups.setdefault(_group(param), []).append(shown.get_help_record(ctx))
        for group in [*groups][2:]:
            if len(groups[group]) == 1:  # a heading takes two lines
                groups["Options"] += groups.pop(group)
        groups["Options"].sort(key=lambda record: record[0].startswith("--help"))  # at the end
        for group, records in groups.items():
            if records:
                with formatter.section(group):
                    formatter.write_dl([(f"{term:{TERM}}", text) for term, text in records])


_BUILD = "build_"
"""Beginning of the names of the parameters that are options of builds."""


def _group(param: Any) -> str:  # noqa: ANN401  # of typer's own click
    """Return the group of a parameter in the help."""
    if param.param_type_name == "argument":
        return "Arguments"
    return BUILD_GROUP if param.name.startswith(_BUILD) else GROUPS.get(param.name, "Options")


def _in_short(param: Any) -> Any | None:  # noqa: ANN401
    """Return a parameter with the first sentence of its help, or None for rare ones."""
    name = param.name.removeprefix(_BUILD)
    if (name != param.name and name not in USUAL) or name in RARE:
        return None
    brief = copy.copy(param)
    text = param.help or ""
    if text.startswith("`"):  # names of choices, and what each is
        text = text.rpartition("Accepted: ")[2].capitalize()
    brief.help = re.split(r"(?<=[.;])\s", text, maxsplit=1)[0].replace(";", ".")
    return brief


def _show_all(ctx: typer.Context, value: bool) -> None:  # as typer calls it
    if value and not ctx.resilient_parsing:
        ctx.meta[_ALL] = True
        typer.echo(ctx.get_help())
        raise typer.Exit


def _build_options(taken: set[str]) -> list[Any]:
    """Return an option of the command line for each option of builds.

    Typer makes them from the signature of a function, as it does for every command.
    """
    from gamutcore.options import OPTIONS  # noqa: PLC0415

    def command(**_options: str | None) -> None:
        pass

    declared: dict[str, Any] = {
        f"{_BUILD}{name}": Annotated[
            str | None,
            typer.Option(
                _flag(name, taken),
                metavar="VALUE",
                help=f"{option.documentation} Accepted: {option.accepted}.",
                callback=_keep,
                expose_value=False,
            ),
        ]
        for name, option in OPTIONS.items()
    }
    declared["help_all"] = Annotated[
        bool,
        typer.Option(
            "--help-all",
            is_eager=True,
            callback=_show_all,
            expose_value=False,
            help="Show all options, such as --gamma and --cost.",
        ),
    ]
    command.__annotations__ = declared
    command.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        [
            inspect.Parameter(
                name,
                inspect.Parameter.KEYWORD_ONLY,
                default=False if name == "help_all" else None,
                annotation=kind,
            )
            for name, kind in declared.items()
        ]
    )
    options = typer.Typer(add_completion=False)
    options.command(add_help_option=False)(command)
    made: list[Any] = list(typer.main.get_command(options).params)
    return made


def asking(question: str) -> type[BuildCommand]:
    """Return the class of a command that asks a question of `gamutcore.questions`."""
    return type("AskingCommand", (BuildCommand,), {"question": question})


def _describe(params: list[Any], question: str) -> None:
    """Give parameters without a help the description that the question declares."""
    from gamutcore.arguments import Number, accepted_values, marks  # noqa: PLC0415
    from gamutcore.questions import QUESTIONS  # noqa: PLC0415

    declared = {option.name: option for option in QUESTIONS[question].all_parameters}
    for option in params:
        if option.name in declared and option.help is None:
            parameter = declared[option.name]
            # the bounds of floats are those of requests
            is_float = [type(mark) for mark in marks(parameter.kind)] == [Number]
            bounded = not option.is_flag and not is_float
            accepted = f" Accepted: {accepted_values(parameter.kind)}." if bounded else ""
            option.help = parameter.description + accepted


def _flag(name: str, taken: set[str]) -> str:
    flag = f"--{name.replace('_', '-')}"
    return f"--gamut-{name.replace('_', '-')}" if flag in taken else flag


def _keep(ctx: typer.Context, param: typer.CallbackParam, value: str | None) -> None:
    if value is not None:
        chosen = ctx.meta.setdefault(_CHOSEN, {})
        chosen[str(param.name).removeprefix(_BUILD)] = value


def check_interval_options(noise: float | None, repeats: str | None, instrument: float) -> None:
    """Refuse options of intervals without --interval."""
    if noise is not None or repeats is not None or instrument:
        raise typer.BadParameter(
            "Give --noise, --repeats and --instrument with --interval.", param_hint="--interval"
        )


def chosen_options(ctx: typer.Context) -> Mapping[str, str]:
    """Return the options of the build that a command was given, as texts."""
    chosen: dict[str, str] = ctx.meta.get(_CHOSEN, {})
    return chosen


def choose_option(ctx: typer.Context, name: str, text: str) -> None:
    """Give an option of the build a value, as the command line would."""
    ctx.meta.setdefault(_CHOSEN, {})[name] = text


def gamut_of(
    source: str, ctx: typer.Context, *, among: Sequence[str] = (), space: str | None = None
) -> Gamut:
    """Return the gamut of an argument, built with the options of the command.

    `among` are the gamuts of a command that has several. An option is then for those that it
    applies to, and there must be one. `space` is the default of the option of this name.
    """
    from gamutcore.content import gamut_source, is_saved_gamut  # noqa: PLC0415
    from gamutcore.errors import OptionError, errors_in  # noqa: PLC0415
    from gamutcore.gamut import Gamut  # noqa: PLC0415
    from gamutcore.options import Options  # noqa: PLC0415

    options = _fitting(source, among, ctx)
    input_data = gamut_source(source)
    reference = None if isinstance(input_data, bytes) else input_data
    data = input_data if isinstance(input_data, bytes) else input_data.data
    if is_saved_gamut(data):
        for name, value in options.items():
            raise OptionError.not_applicable(
                name, value, f"{source} is a gamut that is built already"
            )
        return Gamut.load(source)
    chosen = Options.from_mapping(options if space is None else {"space": space, **options})

    def build() -> Gamut:
        place = source if reference is None else None
        with _progress(Path(source).name) as report, errors_in(place):
            return Gamut(data, chosen, progress=report)

    if reference is not None:
        return cached_reference(reference, chosen, build)
    gamut = build()
    gamut.name = gamut.name or Path(source).stem
    return gamut


def _fitting(source: str, among: Sequence[str], ctx: typer.Context) -> dict[str, Any]:
    """Return the options of the command, of several gamuts those that apply to one of them."""
    from gamutcore.options import option_value  # noqa: PLC0415

    options = {name: option_value(name, text) for name, text in chosen_options(ctx).items()}
    if not options or not among:
        return options
    from gamutcore.building import fitting_options  # noqa: PLC0415
    from gamutcore.content import gamut_source, is_saved_gamut  # noqa: PLC0415

    def content(name: str) -> bytes | None:
        data = gamut_source(name)
        if isinstance(data, bytes):
            return None if is_saved_gamut(data) else data
        return data.data

    key = f"{_CHOSEN}: {[*among]} {options}"
    if key not in ctx.meta:
        named = dict.fromkeys(among)
        choices = fitting_options(((name, content(name)) for name in named), options)
        ctx.meta[key] = dict(zip(named, choices, strict=True))
    fitting: dict[str, Any] = ctx.meta[key][source]
    return fitting


def _files(given: Sequence[str]) -> list[str]:
    """Return gamuts as arguments, with the files of folders and patterns in their place.

    A folder stands for its files of measurements, profiles and saved gamuts. A saved gamut takes
    the place of a file with the same stem.
    """
    from gamutcore.characterisation import FORMATS  # noqa: PLC0415

    kinds = {"profile", "measurements"}
    suffixes = {end for form in FORMATS if form.kind in kinds for end in form.extensions}
    sources: list[str] = []
    for source in given:
        path = Path(source)
        if path.is_dir():
            files = sorted(file for file in path.iterdir() if file.is_file())
            saved = {file.stem for file in files if file.suffix.lower() == SAVED}
            files = [
                file
                for file in files
                if file.suffix.lower() == SAVED
                or (file.suffix.lower() in suffixes - TABLES and file.stem not in saved)
            ]
        elif is_pattern(source):
            files = sorted(map(Path, glob.glob(source)))  # noqa: PTH207  # absolute ones as well
        else:
            sources.append(source)
            continue
        if not files:
            raise typer.BadParameter(
                f"{source} has no saved gamuts, profiles or measurements.", param_hint="GAMUT"
            )
        sources += map(str, files)
    return sources


def is_pattern(source: str) -> bool:
    """Return whether an argument is a pattern of names of files, such as ``presses/*.icc``."""
    return glob.has_magic(source) and not Path(source).exists()


def gamuts_of(sources: Sequence[str], ctx: typer.Context) -> list[Gamut | Path]:
    """Return the gamuts of arguments; saved ones as paths, to be opened one after the other."""
    from gamutcore.content import is_saved_gamut  # noqa: PLC0415

    gamuts: list[Gamut | Path] = []
    files = _files(sources)
    _fitting(files[0], files, ctx)  # refuses options before the first is built
    for source in files:
        path = Path(source)
        if path.is_file():
            with path.open("rb") as file:
                if is_saved_gamut(file.read(64)):
                    gamuts.append(path)
                    continue
        gamut = gamut_of(source, ctx, among=files)
        if path.is_file():
            gamut.name = path.stem
        gamuts.append(gamut)
    return gamuts


@contextmanager
def share_of(name: str) -> Iterator[Callable[[str, float], None] | None]:
    """Show a bar for a fraction of the whole on a terminal, and nothing elsewhere."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console  # noqa: PLC0415
    from rich.progress import Progress  # noqa: PLC0415

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(name, total=1.0)
        yield lambda done, fraction: bar.update(
            task, completed=fraction, description=f"{name}: {done}"
        )


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


STAGE_WORDS = {
    "characterisation": "Reading the data",
    "colours": "Computing colours",
    "boundary": "Finding the surface",
    "decimation": "Making all levels of detail",
    "metric": "Measuring the levels",
}
"""Stages of a build in plain words, as the viewer has them in ``progress.ts``."""


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
            task,
            completed=STAGES.index(stage) + fraction,
            description=f"{name}: {STAGE_WORDS[stage]}",
        )
