"""The commands report and signals: figures by published standards."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gamutcore.cli.inputs import BuildCommand, Source, choose_option, chosen_options, gamut_of

__all__ = ["add_to"]


def add_to(app: typer.Typer) -> None:
    """Add the commands to a program."""
    app.command(cls=BuildCommand)(report)
    app.command()(signals)


def report(
    ctx: typer.Context,
    source: Source,
    standard: Annotated[
        str,
        typer.Option(
            help="idms (displays, IDMS 1.3), iec-62977 (displays), iso-18621-11 (printing "
            "processes) or cie-246 (comparison with a reference)."
        ),
    ],
    reference: Annotated[
        str | None, typer.Option(metavar="GAMUT", help="Gamut to compare with, as GAMUT.")
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            help="A .html, .pdf, .json, .csv, .xlsx or .txt file. By default text.",
        ),
    ] = None,
) -> None:
    """Report a gamut by a published standard.

    The report names the edition, the method, white, intent, medium and patches, and what of the
    standard could not be checked. Unless --intent is given, the gamut has the intent that the
    standard needs for its medium: absolute for prints and reflective displays.
    """
    from gamutcore.reports import check_report_suffix, find_standard, standard_intent  # noqa: PLC0415
    from gamutcore.reports import report as compute  # noqa: PLC0415

    find_standard(standard, has_reference=reference is not None)
    if output is not None:
        check_report_suffix(output)
    sources = [source] if reference is None else [source, reference]
    gamut = gamut_of(source, ctx, among=sources)
    wanted = standard_intent(gamut, standard)
    free = "intent" not in chosen_options(ctx) and not source.lower().endswith(".gamut")
    if free and wanted not in {"", gamut.conditions.intent}:
        choose_option(ctx, "intent", wanted)
        gamut = gamut_of(source, ctx, among=sources)
    other = None if reference is None else gamut_of(reference, ctx, among=sources)
    document = compute(gamut, standard, other)
    if output is None:
        typer.echo(document.to_text(), nl=False)
        return
    document.save(output)
    typer.echo(f"{output}: {document.sentences[0]}")
    for warning in document.warnings:
        typer.echo(f"Warning: {warning}", err=True)


def signals(
    count: Annotated[int, typer.Argument(metavar="COUNT", help="98, 218, 386 or 602.")] = 602,
    bits: Annotated[int, typer.Option(help="Bits of the codes, up to 16.")] = 8,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="FILE", help="A .csv file.")
    ] = Path("signals.csv"),
) -> None:
    """Write the test signals of a display's gamut.

    They are codes on the surface of the RGB cube.

    Add the readings as columns XYZ_X, XYZ_Y and XYZ_Z; the file is then data of a gamut.
    """
    from gamutcore.reports import write_signals  # noqa: PLC0415

    write_signals(output, count, bits)
    typer.echo(f"{output}: {count} signals of {bits} bits.")
