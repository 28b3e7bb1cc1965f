"""The commands link and profile: files for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from gamutcore.cli.inputs import (
    Black,
    Compensation,
    Decode,
    Triangles,
    asking,
    chosen_options,
    number_or_text,
    numbers_of,
)
from gamutcore.cli.output import tell
from gamutcore.cli.reference_cache import cached_reference

__all__ = ["add_to"]


def add_to(app: typer.Typer) -> None:
    """Add the commands to a program."""
    app.command(cls=asking("map"))(link)
    app.command(cls=asking("recipes"))(profile)


def link(
    ctx: typer.Context,
    source: Annotated[
        str,
        typer.Argument(
            metavar="SOURCE",
            help="An RGB space such as rec2020, an ICC profile, or measurements of a device.",
        ),
    ],
    destination: Annotated[str, typer.Argument(metavar="DESTINATION", help="As the source.")],
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="FILE", help="A .cube, .icc or .icm file.")
    ],
    method: str = "clip-hue",
    size: Annotated[
        int | None,
        typer.Option(
            help="Nodes along each channel, 2 to 129. Usual: 17, 33 and 65. Default: 33 for three "
            "channels, 17 for four, and fewer for more."
        ),
    ] = None,
    focus: Annotated[
        str | None, typer.Option(help="Focal point of clip-focal: L,a,b; the cusp by default.")
    ] = None,
    black_point_compensation: Compensation = None,
    decode: Decode = None,
    black: Annotated[
        str,
        typer.Option(
            "--gcr", "--black", help="How much black ink the destination gets, as for recipe."
        ),
    ] = "medium",
    preserve: Annotated[
        str | None,
        typer.Option(
            help="From press to press, inks that stay pure: black (K-only greys), or primaries "
            "(every single ink)."
        ),
    ] = None,
) -> None:
    """Write a gamut mapping between devices as a file.

    Programs such as OpenColorIO, ffmpeg and Resolve apply a .cube file to RGB pictures, and colour
    management systems a device link (.icc), also from and to presses. Colours are mapped in
    CAM16-UCS unless --space names another space.

    Colours that both devices have stay as they are, after black-point compensation. Others are
    clipped to the nearest colour of their hue. --method sgck compresses instead.

    The error is that of the colours of the file against the wanted ones: the colour of the source
    where the destination has it, and the mapped one elsewhere. It is measured at 20,000 random
    inputs and on the edges of the source's cube, printed, and stated in the file.
    """
    from gamutcore.links import check_path  # noqa: PLC0415
    from gamutcore.links import link as compute  # noqa: PLC0415
    from gamutcore.options import option_value  # noqa: PLC0415

    check_path(output)
    options: dict[str, Any] = {
        name: option_value(name, text) for name, text in chosen_options(ctx).items()
    }
    device_link = compute(
        source,
        destination,
        method=method,
        size=size,
        focus=focus
        if focus is None or focus == "cusp"
        else numbers_of(focus, "--focus", "Give three numbers L,a,b."),
        black_point_compensation=black_point_compensation,
        decode=decode,
        black=number_or_text(black),
        preserve=preserve,
        cache=cached_reference,
        **options,
    )
    device_link.save(output)
    for warning in device_link.warnings:
        tell(f"Warning: {warning}")
    worst_at = " ".join(f"{value:.3f}" for value in device_link.errors.worst_at)
    sides = zip(("source", "destination"), device_link.decodings, strict=True)
    stated = [f"{side} {decoding}" for side, decoding in sides if decoding is not None]
    decoded = f" Code values: {', '.join(stated)}." if stated else ""
    tell(
        f"{output}: {device_link.source} to {device_link.destination}, {device_link.method} "
        f"in {device_link.space}, {device_link.table.size} nodes a side. "
        f"Error: {device_link.errors}, at {worst_at}.{decoded}",
        err=False,
    )


def profile(
    ctx: typer.Context,
    measurements: Annotated[
        str,
        typer.Argument(
            metavar="MEASUREMENTS",
            help="Measured device values of a press or a display; also a profile, an RGB space or "
            "a saved .gamut file.",
        ),
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="FILE", help="An .icc or .icm file.")
    ],
    version: Annotated[int, typer.Option(help="Version of the profile: 2, 4, or 5 (iccMAX).")] = 2,
    black: Black = "medium",
    size: Annotated[
        int, typer.Option(help="Nodes of B2A tables along L*, a* and b*, 9 to 65.")
    ] = 33,
    source_gamut: Annotated[
        str, typer.Option(metavar="GAMUT", help="Gamut that the perceptual intent maps from.")
    ] = "srgb",
    name: Annotated[
        str | None, typer.Option(help="What the description of the profile begins with.")
    ] = None,
    gamut_boundary: Annotated[
        bool,
        typer.Option("--gamut-boundary", help="Add the gamut as a mesh, to version 5."),
    ] = False,
    triangles: Triangles = None,
) -> None:
    """Make an ICC profile of a press or a display.

    A press has tables A2B and B2A for the perceptual, relative and saturation intents, and gamt. A
    display has them unless a matrix with curves is close to its model, and in version 5.
    Measurements are kept in the tag targ. The limits --ink-limit and --black-limit hold for all
    B2A tables.

    Two errors are measured, printed, and stated in the file: that of the colours against the
    device model, and that of the round trip. They are of 20,000 device values and of the edges of
    the device's cube.
    """
    from gamutcore.links import PROFILE_SUFFIXES, check_path  # noqa: PLC0415
    from gamutcore.links import profile as compute  # noqa: PLC0415
    from gamutcore.options import option_value  # noqa: PLC0415

    check_path(output, PROFILE_SUFFIXES)
    options = {name: option_value(name, text) for name, text in chosen_options(ctx).items()}
    device_profile = compute(
        measurements,
        version=version,
        black=number_or_text(black),
        size=size,
        source_gamut=source_gamut,
        name=name,
        gamut_boundary=gamut_boundary,
        triangles=triangles,
        **options,
    )
    device_profile.save(output)
    for warning in device_profile.warnings:
        tell(f"Warning: {warning}")
    kind = "Output" if device_profile.device_class == "prtr" else "Display"
    form = "tables" if device_profile.form == "tables" else "matrix and curves"
    round_trip = (
        "" if device_profile.round_trip is None else f" Round trip: {device_profile.round_trip}."
    )
    tell(
        f"{output}: {kind} profile of {device_profile.name}, "
        f"version {device_profile.version}, {form}. Error: {device_profile.forward}.{round_trip}",
        err=False,
    )
