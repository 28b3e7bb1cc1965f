"""Commands that show a gamut: slice, rings and picture."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from gamutcore.cli.inputs import Source, asking, gamut_of, numbers_of
from gamutcore.cli.output import (
    AsCsv,
    AsJson,
    Output,
    drawing_axes,
    state,
    write_bytes,
    write_drawing,
    write_table,
)

__all__ = ["add_to"]


def add_to(app: typer.Typer) -> None:
    """Add the commands to a program."""
    app.command("slice", cls=asking("slice"))(cut)
    app.command(cls=asking("rings"))(rings)
    app.command(cls=asking("picture"))(picture)


def cut(
    ctx: typer.Context,
    source: Source,
    lightness: float | None = None,
    hue: float | None = None,
    plane: str | None = None,
    triangles: int | None = None,
    max_error: float | None = None,
    output: Output = None,
    as_json: AsJson = False,
    as_csv: AsCsv = False,
) -> None:
    """Cut a gamut by a lightness, a hue or a plane.

    The result is a table of the corners of all polygons with their device values in per cent, or
    a drawing if the output is a .png, .svg or .pdf file. Drawings need matplotlib, the extra plot.
    """
    axes = drawing_axes(output, as_json=as_json, as_csv=as_csv)
    numbers = None if plane is None else numbers_of(plane, "--plane", "Give four numbers a,b,c,d.")
    gamut = gamut_of(source, ctx)
    level: dict[str, Any] = {"triangles": triangles, "max_error": max_error}
    stated = state(gamut.conditions)
    if output is not None and axes is not None:
        gamut.plot_slice(lightness, axes, hue=hue, plane=numbers, **level)
        write_drawing(axes, output)
        return
    polygons = gamut.slice(lightness, hue=hue, plane=numbers, **level)
    counts = (polygons.offsets[1:] - polygons.offsets[:-1]).tolist()
    columns: dict[str, Any] = {
        "polygon": [number for number, count in enumerate(counts, 1) for _ in range(count)],
        **dict(zip(gamut.colour_space.axes, polygons.points.T, strict=True)),
    }
    if polygons.device is not None:
        columns |= dict(zip(polygons.channels, 100.0 * polygons.device.T, strict=True))
    units = dict.fromkeys(polygons.channels or (), "%")
    write_table(columns, output, as_json=as_json, as_csv=as_csv, stated=stated, units=units)


def rings(
    ctx: typer.Context,
    source: Source,
    reference: Annotated[
        str | None, typer.Option(metavar="GAMUT", help="A gamut to compare with.")
    ] = None,
    sectors: int = 360,
    triangles: int | None = None,
    max_error: float | None = None,
    output: Output = None,
    as_json: AsJson = False,
    as_csv: AsCsv = False,
) -> None:
    """Compute the gamut rings of IDMS 1.1, alone or with a reference.

    The result is a table of radii by lightness and hue, or a drawing if the output is a .png, .svg
    or .pdf file. Drawings need matplotlib, the extra plot.
    """
    from gamutcore.questions import RINGS, build_warnings, comparison_warnings  # noqa: PLC0415

    axes = drawing_axes(output, as_json=as_json, as_csv=as_csv)
    sources = [source] if reference is None else [source, reference]
    gamut, *others = (gamut_of(name, ctx, among=sources) for name in sources)
    other = next(iter(others), None)
    level: dict[str, Any] = {"triangles": triangles, "max_error": max_error}
    if other is None:
        stated = state(gamut.conditions)
    else:
        both = gamut.conditions, other.conditions
        stated = state(*both, warnings=(*build_warnings(*both), *comparison_warnings(*both)))
    if output is not None and axes is not None:
        gamut.plot_rings(other, axes, sectors=sectors, **level)
        write_drawing(axes, output)
        return
    gamut_rings = gamut.rings(other, sectors=sectors, **level)
    columns: dict[str, Any] = {**RINGS.tabulate(gamut_rings).columns}
    write_table(columns, output, as_json=as_json, as_csv=as_csv, stated=stated, units={"hue": "°"})


def picture(
    ctx: typer.Context,
    source: Source,
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE", help="A .png file.")],
    size: int = 800,
    view: str = "standard",
    background: str = "white",
    axes: bool = True,
    triangles: int | None = None,
    max_error: float | None = None,
) -> None:
    """Write a picture of a gamut as PNG.

    The level has 20,000 triangles unless a count or a limit is given.
    """
    if output.suffix.lower() != ".png":
        raise typer.BadParameter(
            f"{output.name} does not end in .png. gamut slice and gamut rings draw .svg and .pdf.",
            param_hint="--output",
        )
    remedy = "Give the name of a view, or two numbers such as 305,25."
    camera = numbers_of(view, "--view", remedy) if {",", " "} & set(view) else view
    gamut = gamut_of(source, ctx)
    drawn = gamut.picture(
        size,
        camera,
        background=background,
        axes=axes,
        triangles=triangles,
        max_error=max_error,
    )
    write_bytes(drawn, output)
    state(gamut.conditions)
