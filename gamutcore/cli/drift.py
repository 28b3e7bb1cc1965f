"""The command drift: readings of one device against the first of them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from gamutcore.cli.inputs import BuildCommand, chosen_options
from gamutcore.cli.output import AsCsv, AsJson, Output, tell, write_bytes

__all__ = ["add_to"]


def add_to(app: typer.Typer) -> None:
    """Add the command to a program."""
    app.command(cls=BuildCommand)(drift)


def drift(
    ctx: typer.Context,
    first: Annotated[
        Path, typer.Argument(metavar="FIRST", help="Measurements with device values.")
    ],
    seconds: Annotated[
        list[Path],
        typer.Argument(metavar="SECOND...", help="Later readings of the same device."),
    ],
    noise: Annotated[
        float | None,
        typer.Option(
            help="Noise of one reading: root mean square ΔE*ab. By default that of the repeated "
            "patches."
        ),
    ] = None,
    output: Output = None,
    as_json: AsJson = False,
    as_csv: AsCsv = False,
) -> None:
    """Compare readings of one device: what changed beyond noise.

    Each SECOND is compared with FIRST. Patches are matched by device values within half a step of
    8 bits, and repeats are averaged. Stated are ΔE00, its direction, white and black, the solids
    and their overprints, volume and coverage.

    --output writes .csv, .xlsx, .json, .html, .pdf or .txt.
    """
    from gamutcore.options import option_value  # noqa: PLC0415
    from gamutcore.reports import check_report_suffix  # noqa: PLC0415
    from gamutcore.reports import drift as compute  # noqa: PLC0415

    if as_json and as_csv:
        raise typer.BadParameter("Give --json or --csv, not both.")
    if output is not None and not (as_json or as_csv):
        check_report_suffix(output)
    options: dict[str, Any] = {
        name: option_value(name, text) for name, text in chosen_options(ctx).items()
    }
    report = compute(first, *seconds, noise=noise, **options)
    if as_json or as_csv:
        write_bytes((report.to_json() if as_json else report.to_csv()).encode(), output)
    elif output is None:
        typer.echo(report.to_text(), nl=False)
    else:
        report.save(output)
        tell(report.sentences[0], err=False)
        for warning in report.warnings:
            tell(f"Warning: {warning}")
