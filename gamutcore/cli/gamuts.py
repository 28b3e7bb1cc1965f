"""Commands about one gamut: build, info, mesh, export and reference."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gamutcore.cli.inputs import (
    BuildCommand,
    Instrument,
    MaxError,
    Noise,
    Source,
    Triangles,
    WithInterval,
    check_interval_options,
    gamut_of,
)
from gamutcore.cli.output import (
    DIAGRAM_NAMES,
    DIAGRAMS,
    INTERVAL_HEADINGS,
    AsCsv,
    AsJson,
    Output,
    answer_form,
    coordinate_text,
    interval_row,
    percent_text,
    state,
    tell,
    write_bytes,
    write_facts,
    write_figures,
    write_rows,
    write_table,
)
from gamutcore.cli.sections import picture
from gamutcore.number_text import fixed_text, number_text, volume_text, volume_unit

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from gamutcore.colours.spaces import ColourSpace
    from gamutcore.gamut import Gamut

__all__ = ["add_to"]


Into = Annotated[
    Path | None,
    typer.Option(
        metavar="PROFILE",
        help="ICC profile that gets the boundary. It has version 5. The .icc file is the profile "
        "with the level as its gamut boundary.",
    ),
]
"""The profile that a boundary is embedded in."""


ShowAll = Annotated[bool, typer.Option("--all", help="Show all figures.")]
"""All rows of the text."""

ROWS = 12
"""Rows of the text without --all."""

LONGEST_PATH = 60
"""Characters of a path in a row."""


def add_to(app: typer.Typer) -> None:
    """Add the commands to a program."""
    for command in (build, info, mesh, export):
        app.command(cls=BuildCommand)(command)
    app.command()(reference)


def build(
    ctx: typer.Context,
    source: Source,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FILE", help="By default the name with .gamut."),
    ] = None,
    show_all: ShowAll = False,
    as_json: AsJson = False,
) -> None:
    """Build a gamut, and save it as a .gamut file.

    All commands open such a file at once.
    """
    from gamutcore.export.viewer_page import HTML_SUFFIXES  # noqa: PLC0415

    path = output or Path(Path(source).with_suffix(".gamut").name)
    if path.suffix.lower() not in {".gamut", "", *HTML_SUFFIXES}:
        raise typer.BadParameter(
            f"{path.name} does not end in .gamut, or in .html for a page. gamut export writes "
            "meshes, pictures and tables.",
            param_hint="--output",
        )
    gamut = gamut_of(source, ctx)
    gamut.save(path)
    if as_json:
        write_facts({"file": str(path), **_facts(gamut)}, None, as_json=True)
    else:
        name = str(path) if len(str(path)) <= LONGEST_PATH else f"…{str(path)[1 - LONGEST_PATH :]}"
        _write_description([("file", name), *_rows(gamut)], gamut, None, show_all=show_all)


def info(
    ctx: typer.Context,
    source: Source,
    interval: WithInterval = False,
    noise: Noise = None,
    repeats: Annotated[
        str | None,
        typer.Option(metavar="FILE", help="A second reading of the chart, for the interval."),
    ] = None,
    instrument: Instrument = 0.0,
    show_all: ShowAll = False,
    output: Output = None,
    as_json: AsJson = False,
) -> None:
    """Show the key figures of a gamut.

    JSON has the whole description. With --interval, the answer is how well the volume of a measured
    device is known.
    """
    form = answer_form(output, as_json=as_json, as_csv=False)
    if interval and form == "csv":
        raise typer.BadParameter("Intervals are written as text or JSON.", param_hint="--output")
    if not interval:
        check_interval_options(noise, repeats, instrument)
    gamut = gamut_of(source, ctx)
    if interval:
        answer = gamut.uncertainty(noise, repeats, instrument=instrument)
        stated = state(gamut.conditions, warnings=answer.warnings)
        if form == "json":
            facts = {
                "summary": list(answer.summary),
                "volume": answer.volume.to_mapping(),
                "relative": answer.relative.to_mapping(),
                "noise": answer.noise,
                "noise_from": answer.noise_from,
                "patches": answer.patches,
                "patches_needed": answer.patches_needed,
            }
            write_facts({**facts, **stated}, output, as_json=True)
            return
        unit = volume_unit(gamut.colour_space.name)
        rows = {f"volume ({unit})": interval_row(answer.volume, volume_text)}
        write_figures(answer.summary, INTERVAL_HEADINGS, rows, output)
    elif form == "text":
        _write_description(_rows(gamut), gamut, output, show_all=show_all)
    else:
        write_facts(gamut.description if form == "json" else _facts(gamut), output, as_json=as_json)


def mesh(
    ctx: typer.Context,
    source: Source,
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", metavar="FILE", help="A file with the suffix of its format."
        ),
    ],
    triangles: Triangles = None,
    max_error: MaxError = None,
    side: Annotated[str, typer.Option(help="both, inside or outside of the boundary.")] = "both",
    into: Into = None,
) -> None:
    """Write a level as a mesh file.

    The suffix chooses the format: .glb, .gltf, .ply, .stl, .obj, .3mf, .gam, .icc or .cge. The
    level has 1,000 triangles unless a count or a limit is given; .cge is made from the full
    boundary.
    """
    from gamutcore.export import format_of_suffix  # noqa: PLC0415

    full = format_of_suffix(output.suffix).full
    gamut = gamut_of(source, ctx)
    if full and triangles is None and max_error is None:
        max_error = 0.0
    level = gamut.mesh(triangles, max_error=max_error, side=side)  # type: ignore[arg-type]  # checked
    level.save(output, into=into)
    error = level.max_error
    bound = "" if error is None else f", within {number_text(error)} of the boundary"
    tell(f"{output}: {level.triangles} triangles{bound}")
    state(gamut.conditions)


def export(
    ctx: typer.Context,
    source: Source,
    table: Annotated[
        str | None,
        typer.Option(
            help="vertices (colours with device values), cusps (of 360 hues), leaves (largest "
            "chroma of 360 hues and 101 lightnesses) or levels (error by count). By default "
            "vertices."
        ),
    ] = None,
    triangles: Triangles = None,
    max_error: MaxError = None,
    output: Output = None,
    as_json: AsJson = False,
    as_csv: AsCsv = False,
    into: Into = None,
) -> None:
    """Write a table, a mesh, a picture or a page for browsers.

    An output with the suffix of a mesh format is written as by the command mesh, and .png as by the
    command picture. A file with the suffix .html shows the gamut at any level, without a network.
    The form of tables is CSV unless JSON is asked for. Device values are in per cent.
    """
    from gamutcore.export import FORMATS  # noqa: PLC0415
    from gamutcore.export.viewer_page import HTML_SUFFIXES  # noqa: PLC0415

    suffix = None if output is None else output.suffix.lower()
    others = {".png", *HTML_SUFFIXES, *(form.suffix for form in FORMATS.values())}
    if output is not None and suffix in others:
        if table is not None or as_json or as_csv:
            raise typer.BadParameter(
                "Give --table, --json and --csv for tables only.", param_hint="--output"
            )
        _export_file(ctx, source, output, triangles, max_error, into)
        return
    if into is not None:
        raise typer.BadParameter("Give it for an output that ends in .icc.", param_hint="--into")
    if table is None and not as_json and not as_csv and suffix not in _TABLES:
        raise typer.BadParameter(
            f"Give a name that ends in {', '.join(sorted(others | {'.csv', '.json'}))}, or one of "
            "--table, --csv and --json.",
            param_hint="--output",
        )
    table = table or "vertices"
    if table not in {"vertices", "cusps", "leaves", "levels"}:
        raise typer.BadParameter("Give vertices, cusps, leaves or levels.", param_hint="--table")
    gamut = gamut_of(source, ctx)
    columns: dict[str, Any]
    if table == "levels":
        rows = gamut.description["levels"]
        names = ("triangles", "volume", "mismatch", "mismatch_bound", "distance_bound")
        columns = {name: [row[name] for row in rows] for name in names}
    elif table == "vertices":
        level = gamut.mesh(triangles, max_error=max_error)
        columns = dict(zip(gamut.colour_space.axes, level.vertices.T.tolist(), strict=True))
        if level.device is not None:
            values = (100.0 * level.device.values).round(4).T.tolist()
            columns |= dict(zip(level.device.channels, values, strict=True))
    elif table == "cusps":
        cusps = gamut.cusps(triangles=triangles, max_error=max_error)
        columns = {name: getattr(cusps, name) for name in ("hue", "lightness", "chroma")}
        if cusps.device is not None:
            columns |= dict(zip(cusps.channels, (100.0 * cusps.device).T, strict=True))
    else:
        leaves = gamut.leaves(triangles=triangles, max_error=max_error)
        columns = {
            "hue": leaves.hue.repeat(len(leaves.lightness)),
            "lightness": leaves.lightness.tolist() * len(leaves.hue),
            "chroma": leaves.largest.reshape(-1),
        }
        if leaves.largest_device is not None:
            values = (100.0 * leaves.largest_device).reshape(-1, len(leaves.channels)).T
            columns |= dict(zip(leaves.channels, values, strict=True))
    as_json = as_json or (output is not None and output.suffix.lower() == ".json" and not as_csv)
    stated = state(gamut.conditions)
    write_table(columns, output, as_json=as_json, as_csv=not as_json, stated=stated)


_TABLES = (None, "", ".csv", ".json", ".txt")
"""Suffixes of files that hold tables; None is the standard output."""


def _export_file(
    ctx: typer.Context,
    source: str,
    output: Path,
    triangles: int | None,
    max_error: float | None,
    into: Path | None,
) -> None:
    """Write a page, a picture or a mesh, by the suffix of the file."""
    from gamutcore.export.viewer_page import HTML_SUFFIXES  # noqa: PLC0415

    suffix = output.suffix.lower()
    if into is not None and suffix != ".icc":
        raise typer.BadParameter("Give it for an output that ends in .icc.", param_hint="--into")
    if suffix in HTML_SUFFIXES:
        if triangles is not None or max_error is not None:
            raise typer.BadParameter("A page shows every level.", param_hint="--output")
        gamut_of(source, ctx).save(output)
    elif suffix == ".png":
        picture(ctx, source, output, triangles=triangles, max_error=max_error)
    else:
        mesh(ctx, source, output, triangles, max_error, into=into)


def reference(
    name: Annotated[
        str | None, typer.Argument(help="Name of a reference; all are listed without one.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE", help="Save its definition.")
    ] = None,
    search: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="List what a name may mean, the most likely first."),
    ] = None,
    as_json: AsJson = False,
    as_csv: AsCsv = False,
) -> None:
    """List the reference gamuts, or show one.

    Their names are gamuts in all commands.
    """
    from gamutcore.references import (  # noqa: PLC0415
        REFERENCES,
        USUAL,
        find_reference,
        search_references,
    )

    if name is not None and search is not None:
        raise typer.BadParameter("Give the name of a reference or --search.", param_hint="--search")
    if name is None:
        slugs = dict.fromkeys((*USUAL, *REFERENCES))
        references = (
            [REFERENCES[slug] for slug in slugs] if search is None else search_references(search)
        )
        if not references:
            find_reference(str(search))  # raises, with the reason
        columns = {
            key: [getattr(entry, key) for entry in references] for key in ("slug", "name", "kind")
        }
        write_table(columns, output, as_json=as_json, as_csv=as_csv)
        return
    one = find_reference(name)
    if output is not None:
        write_bytes(one.data, output)
        return
    facts = {
        key: getattr(one, key)
        for key in ("slug", "name", "kind", "white", "illuminant", "observer", "primaries")
    }
    write_facts({**facts, "source": one.source}, None, as_json=as_json, as_csv=as_csv)


def _write_description(
    rows: list[tuple[str, str]], gamut: Gamut, output: Path | None, *, show_all: bool
) -> None:
    """Write the rows that are asked most, or all of them, and the warnings of the build."""
    write_rows(rows if show_all else rows[:ROWS], output)
    if len(rows) > ROWS and not show_all:
        typer.echo(f"{len(rows) - ROWS} more with --all.", err=True)
    provenance = gamut.description["provenance"]
    for warning in (*provenance.get("warnings", ()), *gamut.conditions.size_warnings):
        tell(f"Warning: {warning}")


def _rows(gamut: Gamut) -> list[tuple[str, str]]:
    """Return names and texts about a gamut, those that are asked most first."""
    description, conditions, space = gamut.description, gamut.conditions, gamut.colour_space
    provenance, options = description["provenance"], description["options"]
    unit = volume_unit(space.name)
    volumes = description.get("volumes", {})
    intent = conditions.intent
    same = volumes.get(intent, volumes.get("own", {}))

    def volume_row(volume: float, times: float | None) -> str:
        return f"{volume_text(volume)} {unit}" + (
            "" if times is None else f", {number_text(times, 3)} × sRGB"
        )

    rows = [("volume", volume_row(gamut.volume, same.get("times_srgb")))]
    rows += [
        (f"  {name}", volume_row(volumes[name]["volume"], volumes[name]["times_srgb"]))
        for name in ("relative", "absolute")
        if name in volumes and name != intent
    ]
    if "distinguishable_colours" in description:
        millions = description["distinguishable_colours"] / 1e6
        rows.append(("colours", f"{number_text(millions, 3)} million that can be told apart"))
    vertices = gamut.mesh(max_error=0.0).vertices
    order = vertices[:, space.definition.lightness].argsort()
    rows += [
        ("white", _coordinates(vertices[order[-1]], space)),
        ("black", _coordinates(vertices[order[0]], space)),
        ("intent", intent),
        ("space", f"{space.name}, white {conditions.white}"),
    ]
    if gamut.channels:
        rows.append(("channels", " ".join(gamut.channels)))
    if conditions.ink_limit is not None or conditions.is_print:
        limit = conditions.ink_limit
        rows.append(("ink limit", "none" if limit is None else f"{number_text(limit)} %"))
    rows.append(("triangles", f"{description['counts']['triangles']:,}"))
    facts = _measurement_facts(provenance)
    rows += [
        (name, facts.pop(name).replace("the 95th percentile", "95 %"))  # fits a line
        for name in ("patches", "model error")
        if name in facts
    ]
    rows += _chromaticity_rows(description.get("chromaticity"))
    rows.append(("area", f"{volume_text(description['area'])} {unit.replace('cubic', 'square')}"))
    rows += [
        (axis, f"{coordinate_text(low, space)} to {coordinate_text(high, space)}")
        for axis, low, high in zip(space.axes, *description["bounds"], strict=True)
    ]
    if conditions.medium_white is not None:
        lab = ", ".join(
            f"{axis} {fixed_text(value, 1)}"
            for axis, value in zip(("L*", "a*", "b*"), conditions.medium_white, strict=True)
        )
        rows.append(("medium", f"white {lab} as measured"))
    for name in ("illuminant", "observer"):
        value = options.get(name, provenance.get(name))
        if isinstance(value, str | int | float):
            rows.append((name, str(value)))
    if conditions.black_limit is not None:
        rows.append(("black limit", f"{number_text(conditions.black_limit)} %"))
    if "measurement condition" in facts:
        rows.append(("condition", facts["measurement condition"]))
    if "device model" in facts:
        rows.append(("device model", facts["device model"]))
    return [*rows, ("boundary", str(options["boundary"])), ("id", gamut.id)]


def _coordinates(point: Sequence[float], space: ColourSpace) -> str:
    """Return a colour in text."""
    values = [
        f"{axis} {coordinate_text(v, space)}" for axis, v in zip(space.axes, point, strict=True)
    ]
    return ", ".join(values)


def _chromaticity_rows(areas: Mapping[str, Any] | None) -> list[tuple[str, str]]:
    """Return the rows of chromaticity areas and coverages."""
    if areas is None:
        return []
    from gamutcore.references import REFERENCES  # noqa: PLC0415

    rows: list[tuple[str, str]] = []
    for diagram, name in DIAGRAMS.items():
        figures = areas[diagram]
        area = f"{number_text(figures['of_bt709'], 4)} × BT.709"
        rows.append((f"{name} area", f"{area}, of the {areas['basis']}"))
        shares = [
            f"{REFERENCES[slug].name.removeprefix('ITU-R ').removesuffix(' (1998)')} "
            f"{percent_text(share)}"
            for slug, share in figures["coverage"].items()
        ]
        rows.append((f"{name} covers", f"{', '.join(shares)} %"))
    return rows


def _chromaticity(areas: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return the lines of chromaticity areas and coverages; areas as multiples of BT.709."""
    if areas is None:
        return {}
    facts: dict[str, Any] = {"chromaticity of": areas["basis"]}
    for diagram, name in DIAGRAM_NAMES.items():
        facts[f"{name} area, BT.709 = 1"] = areas[diagram]["of_bt709"]
        for slug, share in areas[diagram]["coverage"].items():
            facts[f"{name} coverage of {slug}"] = share
    return facts


def _facts(gamut: Gamut) -> dict[str, Any]:
    description = gamut.description
    provenance = description["provenance"]
    lowest, highest = description["bounds"]
    axes = gamut.colour_space.axes
    facts: dict[str, Any] = {
        "id": gamut.id,
        "space": gamut.colour_space.name,
        "channels": provenance.get("channels", []),
        "volume": gamut.volume,
        **_volume_facts(description),
        "area": description["area"],
        "triangles": description["counts"]["triangles"],
        **{
            f"range of {axis}": [low, high]
            for axis, low, high in zip(axes, lowest, highest, strict=True)
        },
    }
    if "distinguishable_colours" in description:
        facts["million distinguishable colours"] = description["distinguishable_colours"] / 1e6
    facts |= _chromaticity(description.get("chromaticity"))
    for name in ("intent", "illuminant", "observer"):
        value = description["options"].get(name, provenance.get(name))
        if isinstance(value, str | int | float):
            facts[name] = value
    if gamut.conditions.ink_limit is not None:
        facts["ink_limit"] = gamut.conditions.ink_limit
    facts["white"] = gamut.conditions.white
    facts |= _measurement_facts(provenance)
    warnings = (*provenance.get("warnings", ()), *gamut.conditions.size_warnings)
    for number, warning in enumerate(warnings, 1):
        facts[f"warning {number}"] = warning
    return facts


def _measurement_facts(provenance: Mapping[str, Any]) -> dict[str, Any]:
    """Return the patches, the condition and the error of the device model of measurements."""
    facts: dict[str, Any] = {}
    patches = provenance.get("patches")
    if isinstance(patches, dict):
        others = [
            f"{patches[name]} {name}" for name in ("averaged", "dropped") if patches.get(name)
        ]
        used = f"{patches.get('used', patches['read'])} of {patches['read']} used"
        facts["patches"] = ", ".join([used, *others])
        facts["measurement condition"] = provenance.get("measurement_condition") or "not stated"
    model = provenance.get("model")
    if isinstance(model, dict) and "leave_out_error" in model:
        facts["device model"] = model["name"]
        error = model["leave_out_error"]
        facts["model error"] = "unknown"
        if error is not None:
            facts["model error"] = (
                f"{error['mean']:.2f} {error['unit']} on average, {error['percentile_95']:.2f} at "
                f"the 95th percentile, of {error.get('of', 'left-out patches')}"
            )
    return facts


def _volume_facts(description: dict[str, Any]) -> dict[str, Any]:
    """Return the volume of each intent, and as multiples of sRGB; nothing for older files."""
    names = {"relative": "media-relative", "absolute": "absolute"}
    volumes = description.get("volumes", {})
    facts: dict[str, Any] = {
        f"volume, {shown}": volumes[name]["volume"]
        for name, shown in names.items()
        if name in volumes
    }
    facts |= {
        f"times sRGB{shown and ', '}{shown}": volumes[name]["times_srgb"]
        for name, shown in {"own": "", **names}.items()
        if name in volumes
    }
    return facts
