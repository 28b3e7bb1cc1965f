"""Commands that answer questions about colours: query, compare, match, map and recipe."""

from __future__ import annotations

import contextlib
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gamutcore.cli.inputs import (
    Black,
    BuildCommand,
    Compensation,
    Decode,
    Instrument,
    Noise,
    WithInterval,
    asking,
    check_interval_options,
    chosen_options,
    gamut_of,
    gamuts_of,
    is_pattern,
    number_or_text,
    numbers_of,
    share_of,
)
from gamutcore.cli.output import (
    DIAGRAMS,
    INTERVAL_HEADINGS,
    AsCsv,
    AsJson,
    Output,
    answer_form,
    check_answer_form,
    coordinate_text,
    interval_row,
    percent_text,
    shortened,
    state,
    tell,
    write_answer,
    write_facts,
    write_figures,
    write_report,
    write_table,
)
from gamutcore.number_text import fixed_text, number_text, volume_text, volume_unit

if TYPE_CHECKING:
    from collections.abc import Callable

    from gamutcore.colours.spaces import ColourSpace
    from gamutcore.gamut import Gamut
    from gamutcore.pictures import MappedPicture
    from gamutcore.results import ComparisonUncertainty, GamutComparison
    from gamutcore.tables import ColourTable

__all__ = ["add_to"]

SECTORS = 36
"""Default number of sectors of hue, as in `gamutcore.questions`."""

POSITIONS = ("inside", "edge", "outside")
"""Positions of colours, as `Gamut.classify` has them."""


Colours = Annotated[
    str,
    typer.Argument(
        metavar="COLOURS",
        help="A table of colours: CSV, CGATS, CxF, .ase or .npy, or a chart of Argyll (.ti1, "
        ".ti2); - reads standard input.",
    ),
]
OfGamut = Annotated[
    str,
    typer.Option("--gamut", metavar="GAMUT", help="A file, .gamut file or reference."),
]
ColoursIn = Annotated[
    str | None,
    typer.Option(
        "--colours-in",
        metavar="SPACE",
        help="Space of the colours, such as LCHab or sRGB. By default, the columns say it.",
    ),
]
ColumnNames = Annotated[
    str | None,
    typer.Option("--columns", help="Names or numbers of the three columns of the colours."),
]
Scale = Annotated[
    float | None,
    typer.Option(help="Value of white in the table, such as 1, 100 or 255. By default, found."),
]


def add_to(app: typer.Typer) -> None:
    """Add the commands to a program."""
    app.command(cls=asking("nearest"))(query)
    app.command(cls=asking("comparisons"))(compare)
    app.command(cls=BuildCommand)(match)
    app.command("map", cls=asking("map"))(map_colours)
    app.command(cls=asking("recipes"))(recipe)


def query(
    ctx: typer.Context,
    colours: Colours,
    gamut: OfGamut,
    metric: str = "CIE 2000",
    tolerance: Annotated[
        float | None,
        typer.Option(
            help="Largest distance outside of a colour in gamut. By default that of the boundary's "
            "and the level's error; 0 is exact."
        ),
    ] = None,
    edge_width: Annotated[
        float | None,
        typer.Option(help="Largest distance from the surface at the edge. 1 in CIELAB."),
    ] = None,
    passing: Annotated[
        float | None,
        typer.Option(
            "--pass", help="Largest ΔE00 from the gamut of a colour that passes. Adds passes."
        ),
    ] = None,
    colours_in: ColoursIn = None,
    columns: ColumnNames = None,
    scale: Scale = None,
    triangles: int | None = None,
    max_error: float | None = None,
    output: Output = None,
    as_json: AsJson = False,
) -> None:
    """Check a table of colours or a chart against a gamut.

    The columns of the table stay. Added are in_gamut, position (inside, edge or outside), distance
    and distance_euclidean from the surface (negative inside), the nearest colour of the gamut, its
    difference delta_e_2000, and its device values in per cent. A colour inside is its own nearest;
    its device values are those of `recipe`.

    distance is by --metric, as the nearest colour. distance_euclidean is in units of the space. A
    colour is in gamut if it is not farther outside than the tolerance, and at the edge if this
    distance is at most the edge width.
    """
    check_answer_form(output, as_json=as_json)
    target_gamut = gamut_of(gamut, ctx)
    table = _table(colours, colours_in, columns, scale, target_gamut.colour_space.name)
    level = {"triangles": triangles, "max_error": max_error}
    limits = tolerance, edge_width, passing
    added, summary, warnings = _report(target_gamut, table, metric, level, limits)
    stated = state(target_gamut.conditions, warnings=warnings)
    write_answer(table, added, output, as_json=as_json, stated=stated)
    tell(summary + _skipped(table), err=output is None)


def _table(
    path: str,
    space: str | None,
    columns: str | None,
    scale: float | None,
    own: str | None = None,
) -> ColourTable:
    """Read a table of colours, and say what was understood.

    `own` is the space of the gamut, which numbers without names are in: as over HTTP.
    """
    from gamutcore.errors import GamutError, MissingColumnError, errors_in  # noqa: PLC0415
    from gamutcore.tables import read_table  # noqa: PLC0415

    data = sys.stdin.buffer.read() if path == "-" else Path(path).read_bytes()
    try:
        with errors_in("standard input" if path == "-" else path):
            try:
                table = read_table(data, space=space, columns=columns, scale=scale)
            except MissingColumnError as missing:
                try:
                    table = read_table(data, space=space, columns=columns, scale=scale, own=own)
                except GamutError:
                    raise missing from None
    except GamutError as error:
        if "line" in error.where:
            error.where.pop("row", None)
        raise
    tell(table.reading)
    return table


def _skipped(table: ColourTable) -> str:
    """Return a sentence on rows without a colour."""
    count = table.without_colour
    return f" {count} row{'s' * (count > 1)} without a colour." if count else ""


def _report(
    gamut: Gamut,
    table: ColourTable,
    metric: str,
    level: dict[str, Any],
    limits: tuple[float | None, float | None, float | None],
) -> tuple[dict[str, Any], str, tuple[str, ...]]:
    """Return the columns that a query adds, its summary and its warnings.

    The limits are the tolerance, the edge width and the largest ΔE00 that passes.
    """
    import numpy as np  # noqa: PLC0415

    from gamutcore.errors import DeviceModelError  # noqa: PLC0415

    tolerance, edge_width, passing = limits
    if edge_width is None:
        edge_width = gamut.default_edge_width
    if tolerance is None:
        tolerance = gamut.tolerance(**level)
    arguments = {"space": table.space, "tolerance": tolerance, **level}
    inside = gamut.contains(table.points, **arguments)
    outside = ~inside
    near = gamut.nearest(table.points[outside], metric=metric, space=table.space, **level)
    colours = gamut.convert(table.points, table.space)
    points, difference = colours.copy(), np.zeros(len(colours))
    points[outside] = gamut.convert(near.points, table.space)
    difference[outside] = near.delta_e
    columns: dict[str, Any] = {
        "in_gamut": inside,
        "position": gamut.classify(table.points, edge_width=edge_width, **arguments),
        "distance": gamut.distance(table.points, metric=metric, space=table.space, **level),
        "distance_euclidean": gamut.distance(table.points, space=table.space, **level),
    }
    for axis, name in enumerate(gamut.colour_space.axes):
        columns[f"nearest_{name.rstrip('*')}"] = points[:, axis]
    columns["delta_e_2000"] = difference
    if passing is not None:
        columns["passes"] = difference <= passing
    if near.device is not None:
        device = np.full((len(colours), len(near.channels)), np.nan)
        device[outside] = near.device
        with contextlib.suppress(DeviceModelError):  # saved by an older version, for example
            recipes = gamut.to_device(table.points[inside], space=table.space, **level)
            device[inside] = recipes.device
        columns |= dict(zip(near.channels, 100.0 * device.T, strict=True))
    unit = f"in {gamut.colour_space.name}"
    noun = "patches" if table.is_chart else "colours"
    counts = {place: int((columns["position"] == place).sum()) for place in POSITIONS}
    summary = (
        f"{int(inside.sum())} of {len(colours)} {noun} are in gamut. By position:"
        f" {counts['inside']} inside, {counts['edge']} at the edge, {counts['outside']} outside."
        f" Tolerance {number_text(tolerance, 2)}, edge width {number_text(edge_width, 2)} {unit}."
    )
    if passing is not None:
        summary += f" {int(columns['passes'].sum())} pass (ΔE00 up to {number_text(passing)})."
    if outside.any():
        worst = int(np.argmax(difference))
        summary += (
            f" Worst: {table.label(worst)}, ΔE00 {difference[worst]:.2f} from the nearest colour."
        )
    warnings = _chart_warnings(gamut, near.warnings) if table.is_chart else near.warnings
    return columns, summary, warnings


def _chart_warnings(gamut: Gamut, warnings: tuple[str, ...]) -> tuple[str, ...]:
    """Return warnings about the colours of a chart: relative to its white, and not as measured."""
    from gamutcore.questions import colour_warnings  # noqa: PLC0415

    about_measured = colour_warnings(gamut.conditions, "CIELAB")
    others = tuple(warning for warning in warnings if warning not in about_measured)
    if gamut.conditions.intent != "absolute":
        return others
    warning = (
        "The gamut is absolute, and the estimates of a chart are relative to its white: build the "
        "gamut with --intent relative."
    )
    return (*others, warning)


def recipe(
    ctx: typer.Context,
    colours: Colours,
    gamut: OfGamut,
    black: Black = "medium",
    method: str = "clip-nearest",
    colours_in: ColoursIn = None,
    columns: ColumnNames = None,
    scale: Scale = None,
    triangles: int | None = None,
    max_error: float | None = None,
    output: Output = None,
    as_json: AsJson = False,
) -> None:
    """Find device values that give colours, for a press or a display.

    The columns of the table stay. Added are in_gamut, the device values in per cent, the difference
    delta_e_2000 of their colour from the colour asked, and the possible range of black in per cent.

    A colour out of gamut gets the device values of the colour that it is mapped to. The options
    --ink-limit and --black-limit of the gamut are kept.
    """
    check_answer_form(output, as_json=as_json)
    target_gamut = gamut_of(gamut, ctx)
    table = _table(colours, colours_in, columns, scale, target_gamut.colour_space.name)
    recipes = target_gamut.to_device(
        table.points,
        black=number_or_text(black),
        method=method,
        space=table.space,
        triangles=triangles,
        max_error=max_error,
    )
    added: dict[str, Any] = {"in_gamut": recipes.inside}
    added |= dict(zip(recipes.channels, 100.0 * recipes.device.T, strict=True))
    added["delta_e_2000"] = recipes.delta_e
    if recipes.black_least is not None and recipes.black_most is not None:
        added["black_least"] = 100.0 * recipes.black_least
        added["black_most"] = 100.0 * recipes.black_most
    stated = state(target_gamut.conditions, warnings=recipes.warnings)
    write_answer(table, added, output, as_json=as_json, stated=stated)
    inside = int(recipes.inside.sum())
    summary = f"{inside} of {len(recipes.inside)} colours are in gamut."
    if inside:
        worst = float(recipes.delta_e[recipes.inside].max())
        missed = number_text(worst, 2)
        summary += f" Their recipes miss them by ΔE00 {missed} at most, by the device model."
    tell(summary + _skipped(table), err=output is None)


def map_colours(
    ctx: typer.Context,
    colours: Annotated[
        str,
        typer.Argument(
            metavar="COLOURS",
            help="A table of colours, or a picture; - reads a table of standard input.",
        ),
    ],
    gamut: OfGamut,
    method: str = "clip-hue",
    focus: Annotated[
        str | None, typer.Option(help="Focal point L,a,b of clip-focal; the cusp by default.")
    ] = None,
    from_gamut: Annotated[
        str | None, typer.Option("--from", metavar="GAMUT", help="Gamut that sgck maps from.")
    ] = None,
    colours_in: ColoursIn = None,
    columns: ColumnNames = None,
    scale: Scale = None,
    triangles: int | None = None,
    max_error: float | None = None,
    output: Output = None,
    as_json: AsJson = False,
    depth: Annotated[
        str | None,
        typer.Option(help="Depth of the picture that is written: 8, 16, half or float."),
    ] = None,
    lookup_table: Annotated[
        int | None,
        typer.Option(
            "--table",
            help="Map a picture through a table of as many nodes along each channel, 5 to 129; 0 "
            "maps every colour exactly. Default: 65 above 8 megapixels, else 0.",
        ),
    ] = None,
    heat_map: Annotated[
        str | None,
        typer.Option(
            metavar="FILE.png",
            help="Write the colour difference of each pixel as gray: ΔE00 in steps of 0.05.",
        ),
    ] = None,
    to: Annotated[
        str | None,
        typer.Option(
            help="Encoding of the picture that is written: picture, that of the picture (default); "
            "an RGB space such as display-p3; or device, values of the device as TIFF."
        ),
    ] = None,
    black: Annotated[
        str | None,
        typer.Option(
            "--gcr", "--black", help="How much black the device values have, as for gamut recipe."
        ),
    ] = None,
    black_point_compensation: Compensation = None,
    decode: Decode = None,
    iterations: Annotated[
        int | None,
        typer.Option(
            help="Iterations of --method spatial, which keeps the differences between the pixels "
            "of a picture. Default: 25; 0 is clipping."
        ),
    ] = None,
) -> None:
    """Map a table of colours or a picture into a gamut.

    The columns of the table stay. Added are the mapped colour in the space of the colours, its
    difference delta_e_2000, and its device values in per cent, which exist on the surface only.

    A picture is written to a .png, .tif, .exr or .jpg file with its encoding, profile, depth and
    alpha. Pixels in gamut keep their values, except by --method sgck and spatial, and with
    black-point compensation, the default of relative gamuts; --no-bpc switches it off. With
    --depth, floats can be written as PNG and JPEG:
    integers of a picture in linear light are sRGB. --to names another encoding: an RGB space, whose
    profile is embedded, or the device itself, such as CMYK with the profile of --gamut.

    For a picture, the gamut is built in CAM16-UCS unless --space names another space, and the full
    boundary answers unless --triangles or --max-error chooses a level.
    """
    picture = _is_picture(colours)
    if picture and (as_json or any(value is not None for value in (colours_in, columns, scale))):
        raise typer.BadParameter("Pictures have no --colours-in, --columns, --scale and --json.")
    if picture and output is None:
        raise typer.BadParameter("Give a file for the picture.", param_hint="--output")
    if picture and output is not None:
        from gamutcore.export.picture_file import check_written  # noqa: PLC0415

        check_written(output, device=to == "device")
    _check_source(method, from_gamut)
    given_options = {
        "--depth": depth,
        "--table": lookup_table,
        "--heat-map": heat_map,
        "--iterations": iterations,
        "--decode": decode,
        "--to": to,
        "--gcr": black,
    }
    for option, value in given_options.items():
        if value is not None and not picture:
            raise typer.BadParameter("This is an option of pictures.", param_hint=option)
    if not picture:
        check_answer_form(output, as_json=as_json)
    table = None if picture else _table(colours, colours_in, columns, scale)
    sources = [gamut] if from_gamut is None else [gamut, from_gamut]
    space = _space_for_picture(ctx, sources) if picture else None
    target_gamut = gamut_of(gamut, ctx, among=sources, space=space)
    options: dict[str, Any] = {
        "focus": focus
        if focus is None or focus == "cusp"
        else numbers_of(focus, "--focus", "Give three numbers L,a,b."),
        "source": None
        if from_gamut is None
        else gamut_of(from_gamut, ctx, among=sources, space=space),
        "black_point_compensation": black_point_compensation
        if picture
        else bool(black_point_compensation),
        "triangles": triangles,
        "max_error": max_error,
    }
    if table is None:
        assert output is not None  # noqa: S101  # checked above
        options |= {
            "depth": depth,
            "table": lookup_table,
            "heat_map": heat_map,
            "iterations": iterations,
            "decode": decode,
            "to": to or "picture",
            "black": None if black is None else number_or_text(black),
        }
        mapped_picture = target_gamut.map_picture(colours, output, method, **options)
        state(target_gamut.conditions, warnings=mapped_picture.warnings)
        tell(_picture_summary(mapped_picture), err=False)
        return
    mapped = target_gamut.map(table.points, method, space=table.space, **options)
    points = table.own_values(mapped.points)
    added: dict[str, Any] = {
        f"mapped_{axis}": points[:, place]
        for place, axis in enumerate(_axes_of(table, target_gamut))
    }
    added |= {"moved": mapped.moved, "delta_e_2000": mapped.delta_e}
    if mapped.device is not None:
        added |= dict(zip(mapped.channels, 100.0 * mapped.device.T, strict=True))
    stated = state(target_gamut.conditions, warnings=mapped.warnings)
    write_answer(table, added, output, as_json=as_json, stated=stated)
    summary = f"{int(mapped.moved.sum())} of {len(mapped.moved)} colours moved."
    tell(summary + _skipped(table), err=output is None)


def _picture_summary(done: MappedPicture) -> str:
    pixels, colours = max(done.pixels, 1), max(done.colours, 1)
    moved = (
        f"{done.moved} of {done.pixels} pixels moved, mean ΔE00 {done.delta_e:.2f}, 95 % up to "
        f"{done.delta_e_95:.2f}; of the moved pixels {done.moved_delta_e:.2f} and "
        f"{done.moved_delta_e_95:.2f}."
    )
    outside = (
        f"{done.outside / pixels:.1%} of the pixels and {done.colours_outside / colours:.1%} of "
        f"{done.colours} distinct colours are out of gamut."
    )
    lines = [moved, outside]
    if done.missed:
        lines.append(f"{done.missed} have mapped colours outside {done.encoding}.")
    error = done.table_error
    if error is not None:
        lines.append(
            f"Mapped through a table of {error.nodes} nodes along each channel. Its error at "
            f"{error.pixels} pixels is ΔE00 {error.mean:.3f} on average, 95 % up to "
            f"{error.percentile_95:.2f}, largest {error.largest:.2f}. --table 0 has none."
        )
    if done.heat_map is not None:
        lines.append(f"Heat map: {done.heat_map}")
    return "\n".join(lines)


def _check_source(method: str, source: str | None) -> None:
    from gamutcore.arguments import check_option  # noqa: PLC0415
    from gamutcore.questions import METHOD, SPATIAL  # noqa: PLC0415

    known = method if method == SPATIAL else check_option("method", method, METHOD)
    if (known == "sgck") != (source is not None):
        raise typer.BadParameter(
            "Give the gamut that sgck maps from."
            if source is None
            else "Only the method sgck maps from a gamut.",
            param_hint="--from",
        )


def _is_picture(path: str) -> bool:
    if path == "-" or not Path(path).is_file():
        return False
    from gamutcore.characterisation.pictures import picture_format  # noqa: PLC0415

    with Path(path).open("rb") as file:
        return picture_format(file.read(4096)) is not None


def _space_for_picture(ctx: typer.Context, gamuts: list[str]) -> str | None:
    """Return the space to build gamuts in for a picture; None if it is given in some way."""
    from gamutcore.questions import PICTURE_SPACE  # noqa: PLC0415

    chosen = chosen_options(ctx)
    if "space" in chosen or chosen.get("source") == "boundary":
        return None
    if any(_has_space(source, chosen.get("condition")) for source in gamuts):
        return None
    tell(f"Gamuts for pictures are built in {PICTURE_SPACE}; --space changes it.")
    return PICTURE_SPACE


def _has_space(source: str, condition: str | None) -> bool:
    """Return whether a gamut has a space already: it is saved, or a mesh."""
    from gamutcore.characterisation import GamutMesh, read_characterisation  # noqa: PLC0415
    from gamutcore.content import gamut_source, is_saved_gamut  # noqa: PLC0415
    from gamutcore.errors import errors_in  # noqa: PLC0415

    input_data = gamut_source(source)
    if not isinstance(input_data, bytes) or _is_picture(source):
        return False
    with errors_in(source):
        return is_saved_gamut(input_data) or isinstance(
            read_characterisation(input_data, condition=condition), GamutMesh
        )


def _axes_of(table: ColourTable, gamut: Gamut) -> tuple[str, ...]:
    """Return the names of the coordinates of a table."""
    from gamutcore.colours.spaces import ColourConversion  # noqa: PLC0415

    axes = ColourConversion(table.space, gamut.colour_space).axes
    return tuple(axis.rstrip("*") for axis in axes)


def compare(
    ctx: typer.Context,
    gamuts: Annotated[
        list[str],
        typer.Argument(
            metavar="GAMUT...",
            help="Files to build from, saved .gamut files, names of references, folders or "
            "patterns.",
        ),
    ],
    sectors: int = SECTORS,
    lost: bool = False,
    triangles: int | None = None,
    max_error: float | None = None,
    interval: WithInterval = False,
    noise: Noise = None,
    instrument: Instrument = 0.0,
    same_instrument: Annotated[
        bool, typer.Option("--same-instrument", help="One instrument has read both.")
    ] = False,
    output: Output = None,
    as_json: AsJson = False,
    as_csv: AsCsv = False,
) -> None:
    """Compare two gamuts or more by volume and coverage.

    Two are compared in words and by figures. With --csv, the result is a table of the sectors of
    hue. With --interval, it is how well the data lets the comparison be known.

    Three or more, a folder or a pattern give the volumes, and the share of each gamut that each
    other one covers. The output is a table (.csv, .xlsx, .json, .html, .txt) or a heat map (.png,
    .svg, .pdf).
    """
    from gamutcore.questions import COMPARISON  # noqa: PLC0415

    if len(gamuts) != 2 or any(Path(name).is_dir() or is_pattern(name) for name in gamuts):
        if lost or interval or sectors != SECTORS:
            raise typer.BadParameter("--lost, --sectors and --interval are for two gamuts.")
        _check_interval_options(noise, instrument, same_instrument=same_instrument)
        _compare_all(ctx, gamuts, triangles, max_error, output, as_json=as_json, as_csv=as_csv)
        return
    form = answer_form(output, as_json=as_json, as_csv=as_csv)
    if not interval:
        _check_interval_options(noise, instrument, same_instrument=same_instrument)
    elif form == "csv":
        raise typer.BadParameter("Intervals are written as text or JSON.", param_hint="--output")
    one, two = (gamut_of(source, ctx, among=gamuts) for source in gamuts)
    names = [Path(name).stem if Path(name).exists() else name for name in gamuts]
    # names that may be mistaken for the letters of the summary are not put into it
    named = len({*names, "A", "B"}) > 3

    def words(answer: GamutComparison | ComparisonUncertainty) -> tuple[str, ...]:
        return answer.summary_with(*names) if named else answer.summary

    if interval:
        answer = one.compare_with_interval(
            two, noise=noise, instrument=instrument, same_instrument=same_instrument
        )
        stated = state(one.conditions, two.conditions, warnings=answer.warnings)
        if form == "json":
            figures = {
                **{name: getattr(answer, name).to_mapping() for name in _INTERVALS},
                "smallest_difference": answer.smallest_difference,
                "noise": list(answer.noise),
                "patches": list(answer.patches),
                "patches_needed": answer.patches_needed,
            }
            write_facts({"summary": list(words(answer)), **figures, **stated}, output, as_json=True)
            return
        first, second = (shortened(name) for name in names)
        labels = (
            f"volume of {first} above that of {second} (%)",
            f"{first} covers of {second} (%)",
            f"{second} covers of {first} (%)",
        )
        rows = {
            label: interval_row(getattr(answer, name), percent_text)
            for label, name in zip(labels, _INTERVALS, strict=True)
        }
        write_figures(words(answer), INTERVAL_HEADINGS, rows, output)
        return
    comparison = one.compare(
        two, sectors=sectors, lost=lost, triangles=triangles, max_error=max_error
    )
    stated = state(one.conditions, two.conditions, warnings=comparison.warnings)
    tabular = COMPARISON.tabulate(comparison)
    by_hue: dict[str, Any] = {name: values.tolist() for name, values in tabular.columns.items()}
    if form == "csv":
        write_table(by_hue, output, as_json=False, as_csv=True)
        return
    if form == "json":
        facts = {
            name: value.tolist() if hasattr(value, "tolist") else value
            for name, value in tabular.document.items()
        }
        write_facts({**facts, "sectors": by_hue, **stated}, output, as_json=True)
        return
    unit = volume_unit(one.colour_space.name)
    common = (
        f"In common: {volume_text(comparison.intersection)} {unit}, "
        f"{percent_text(comparison.jaccard)} % of both together."
    )
    rows = _figures(comparison, one.colour_space)
    write_figures(words(comparison), names, rows, output, notes=[common])


_INTERVALS = ("larger", "a_covers_b", "b_covers_a")
"""Figures of a comparison that have intervals."""


def _figures(comparison: GamutComparison, space: ColourSpace) -> dict[str, list[str]]:
    """Return the figures of a comparison in text, those of A and of B."""

    def pair(figures: Any, name: str, text: Callable[[float], str]) -> list[str]:  # noqa: ANN401
        return [text(float(getattr(figures, name.format(*side)))) for side in ("ab", "ba")]

    axis = space.definition.lightness
    rows = {
        f"volume ({volume_unit(space.name)})": pair(comparison, "volume_{}", volume_text),
        "share of the other covered (%)": pair(comparison, "{}_covers_{}", percent_text),
    }
    for label, name in (("lightest", "white"), ("darkest", "black")):
        ends = (getattr(comparison, f"{name}_{side}")[axis] for side in "ab")
        rows[f"{label} colour ({space.axes[axis]})"] = [coordinate_text(end, space) for end in ends]
    if comparison.lost_a is not None and comparison.lost_b is not None:
        lost = comparison.lost_a, comparison.lost_b
        rows |= {
            "surface outside the other (%)": [percent_text(loss.share_outside) for loss in lost],
            "ΔE00 to the other, mean": [fixed_text(loss.mean, 2) for loss in lost],
            "ΔE00 to the other, 95 %": [fixed_text(loss.percentile_95, 2) for loss in lost],
        }
    for diagram, name in DIAGRAMS.items():
        areas = getattr(comparison.chromaticity, diagram, None)
        if areas is not None:
            ratio = areas.area_ratio
            rows[f"area in {name} (× the other)"] = [
                number_text(ratio, 4),
                number_text(1.0 / ratio, 4),
            ]
            rows[f"other covered in {name} (%)"] = pair(areas, "{}_covers_{}", percent_text)
    return rows


def _check_interval_options(
    noise: float | None, instrument: float, *, same_instrument: bool
) -> None:
    """Refuse options of intervals without --interval."""
    check_interval_options(noise, None, instrument)
    if same_instrument:
        raise typer.BadParameter("Give it with --interval.", param_hint="--same-instrument")


def _compare_all(
    ctx: typer.Context,
    gamuts: list[str],
    triangles: int | None,
    max_error: float | None,
    output: Path | None,
    *,
    as_json: bool,
    as_csv: bool,
) -> None:
    """Write the matrix of many gamuts."""
    from gamutcore.reports import check_report_suffix, compare_all, matrix_report  # noqa: PLC0415

    if output is not None:
        check_report_suffix(output, charts=True)
    sources = gamuts_of(gamuts, ctx)
    if len(sources) < 2:
        raise typer.BadParameter("Give at least two gamuts.", param_hint="GAMUT")
    with share_of("Comparing") as progress:
        matrix = compare_all(sources, triangles=triangles, max_error=max_error, progress=progress)
    write_report(matrix_report(matrix), output, as_json=as_json, as_csv=as_csv)


def match(
    ctx: typer.Context,
    colours: Colours,
    gamuts: Annotated[
        list[str],
        typer.Argument(
            metavar="GAMUT...",
            help="Saved .gamut files, files to build from, names of references, folders or "
            "patterns.",
        ),
    ],
    passing: Annotated[
        float | None,
        typer.Option(
            "--pass",
            help="Largest ΔE00 from the nearest colour of a gamut that counts as printed. By "
            "default, colours inside and at the edge count.",
        ),
    ] = None,
    edge_width: Annotated[
        float | None,
        typer.Option(help="Largest distance from the surface at the edge. 1 in CIELAB."),
    ] = None,
    delta_e: Annotated[
        bool, typer.Option(help="Find ΔE00 of colours outside, which takes most of the time.")
    ] = True,
    recipe: Annotated[
        bool, typer.Option("--recipe", help="Add device values in per cent: CSV, .xlsx and JSON.")
    ] = False,
    colours_in: ColoursIn = None,
    columns: ColumnNames = None,
    scale: Scale = None,
    max_error: Annotated[
        float | None,
        typer.Option(
            help="Largest error of the levels that answer: 0.2 in CIELAB by default; 0 is the full "
            "boundary."
        ),
    ] = None,
    output: Output = None,
    as_json: AsJson = False,
    as_csv: AsCsv = False,
) -> None:
    """Find which gamuts print a table of colours.

    For each gamut: the share of the colours that it prints, mean and 95th percentile of ΔE00, and
    the worst colours. For each colour: how many gamuts print it, and which is best. Also the two or
    three gamuts that print most together. This is advice, and no routing of jobs.

    The suffix of the output chooses the form: .csv (a row for each colour and gamut), .xlsx, .json,
    .html, .pdf or .txt.
    """
    from gamutcore import match as match_gamuts  # noqa: PLC0415
    from gamutcore.reports import check_report_suffix, match_report  # noqa: PLC0415

    if output is not None:
        check_report_suffix(output)
    table = _table(colours, colours_in, columns, scale)
    sources = gamuts_of(gamuts, ctx)
    with share_of("Matching") as progress:
        found = match_gamuts(
            table,
            sources,
            passing=passing,
            edge_width=edge_width,
            delta_e=delta_e,
            recipes=recipe,
            max_error=max_error,
            progress=progress,
        )
    write_report(match_report(found), output, as_json=as_json, as_csv=as_csv)
    if table.without_colour:
        tell(_skipped(table).strip())
