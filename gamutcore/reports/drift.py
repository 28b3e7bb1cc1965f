"""Drift: how two or more readings of one device differ, and whether noise explains it."""

from __future__ import annotations

from contextlib import suppress
from functools import partial
from itertools import combinations
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np

from gamutcore.arguments import Number, check_option
from gamutcore.errors import (
    DeviceModelError,
    GamutError,
    InvalidPointsError,
    OptionError,
    errors_in,
)
from gamutcore.gamut import Gamut
from gamutcore.number_text import fixed_text, number_text
from gamutcore.options import Options
from gamutcore.questions import plot_text
from gamutcore.reports.document import Chart, Report, ReportColumn, ReportTable
from gamutcore.reports.readings import (
    SAME_PATCH,
    ReadingPair,
    condition_warnings,
    device_text,
    pair_readings,
    read_reading,
    reading_names,
    stated_condition,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

    from gamutcore.results import ComparisonUncertainty

__all__ = ["drift"]

NOISE = Annotated[float, Number(0.0, 100.0)]

MOST_WORST, MOST_NAMED = 10, 5
"""Rows of the worst patches, and names of patches in a sentence."""


class _Volumes(NamedTuple):
    first: float
    second: float
    first_covers: float
    second_covers: float
    interval: ComparisonUncertainty | None
    """Of the second reading beside the first; None if there are too few patches."""

    @property
    def change(self) -> float:
        return self.second / self.first - 1.0


def drift(
    first: object,
    second: object,
    *others: object,
    noise: float | None = None,
    names: Sequence[str] = (),
    **options: Any,  # noqa: ANN401  # checked by Options
) -> Report:
    r"""Compare readings of one device, patch by patch and by their gamuts.

    Parameters
    ----------
    first, second, *others : path, bytes or table
        Measurements with device values, in any form that `Gamut` accepts. The first is compared
        with each of the others. Patches are matched by device values within half a step of 8 bits;
        repeats are averaged.
    noise : float, optional
        Noise of one reading: root mean square ΔE*ab. By default that of the repeated patches.
    names : sequence of str, optional
        Names of the readings. By default those of the files.
    **options
        How the readings are read and their gamuts built, as for `Gamut`.

    Returns
    -------
    Report
        ``data["pairs"]`` has the figures and the differences of all patches. `save` writes csv,
        xlsx, json, html, pdf or txt.

    Raises
    ------
    CharacterisationError
        A file is no reading with device values, or the readings are of different devices or have no
        patch in common.

    Notes
    -----
    ΔE00 is CIEDE2000; ΔL*, ΔC* and ΔH* are second minus first. Noise alone counts as a change with
    a probability of 1 %.

    Examples
    --------
    >>> first = b"C,M,Y,K,L,a,b\n0,0,0,0,95,0,-2\n100,0,0,0,55,-37,-50\n"
    >>> report = drift(first, first.replace(b"55", b"53"))
    >>> round(report.data["pairs"][0]["delta_e_2000"]["largest"], 2)
    1.92
    """
    chosen = Options.from_mapping(options)
    if noise is not None:
        check_option("noise", noise, NOISE)
    sources = [first, second, *others]
    titles = reading_names(sources, names)
    readings = [
        read_reading(source, title, chosen) for source, title in zip(sources, titles, strict=True)
    ]
    pairs = [pair_readings(readings[0], reading, noise) for reading in readings[1:]]
    warnings = condition_warnings(readings)
    gamuts: list[Gamut | None] = []
    for source, reading in zip(sources, readings, strict=True):
        try:
            with errors_in(source):
                gamuts.append(Gamut(reading.content, chosen))
        except OptionError:
            raise
        except GamutError as error:
            gamuts.append(None)
            warnings.append(f"{reading.name} has no volume: {error.message}")
    volumes = [
        _volumes(gamuts[0], gamut, pair) for gamut, pair in zip(gamuts[1:], pairs, strict=True)
    ]
    if any(pair.noise is None for pair in pairs):
        warnings.append(
            "The noise is not known, because no reading has repeats that differ. Give it in ΔE*ab: "
            "noise (--noise)."
        )
    return _report(pairs, volumes, warnings, chosen)


def _volumes(first: Gamut | None, second: Gamut | None, pair: ReadingPair) -> _Volumes | None:
    """Return volumes and coverage of two gamuts, with their intervals."""
    if first is None or second is None:
        return None
    comparison = first.compare(second, sectors=1)
    interval = None
    with suppress(InvalidPointsError, DeviceModelError):
        interval = second.compare_with_interval(
            first, noise=None if pair.noise is None else pair.noise.value
        )
    return _Volumes(
        comparison.volume_a,
        comparison.volume_b,
        comparison.a_covers_b,
        comparison.b_covers_a,
        interval,
    )


def _corners(pair: ReadingPair) -> list[tuple[str, int]]:
    """Return names and rows of white, the solids and their overprints, and the darkest patch."""
    channels, additive = pair.first.samples.channels, pair.first.samples.additive
    count = len(channels)
    corners: list[tuple[str, int]] = []
    for number in range(count + 1):
        for members in combinations(range(count), number):
            corner = np.isin(np.arange(count), members).astype(np.float64)
            away = np.abs(pair.device - corner).max(axis=1)
            row = int(away.argmin())
            if away[row] <= SAME_PATCH:
                white = number == (count if additive else 0)
                black = additive and number == 0
                name = "+".join(channels[member] for member in members)
                corners.append(("white" if white else "black" if black else name, row))
    darkest = int(pair.first.lab[pair.rows[0], 0].argmin())
    if darkest not in {row for _, row in corners}:
        corners.append(("darkest", darkest))
    return sorted(corners, key=lambda corner: corner[0] != "white")


def _patch_table(
    title: str, names: Sequence[str], pair: ReadingPair, rows: Sequence[int]
) -> ReportTable:
    at = list(rows)
    lab, beyond = pair.first.lab[pair.rows[0]][at], pair.beyond_noise()
    differences = zip(("ΔL*", "Δa*", "Δb*", "ΔC*", "ΔH*"), pair.difference[at].T, strict=True)
    columns = [
        ReportColumn("patch", list(names)),
        ReportColumn("ΔE00", pair.delta_e[at].tolist()),
        *(ReportColumn(name, values.tolist()) for name, values in differences),
        ReportColumn("beyond noise", [None] * len(at) if beyond is None else beyond[at].tolist()),
        *(
            ReportColumn(name, values.tolist())
            for name, values in zip(("L*", "a*", "b*"), lab.T, strict=True)
        ),
        ReportColumn("device %", [device_text(values) for values in pair.device[at]]),
    ]
    return ReportTable(title, columns)


def _figures(pair: ReadingPair, volumes: _Volumes | None) -> dict[str, Any]:
    """Return the figures of a pair, as JSON has them."""
    beyond = pair.beyond_noise(any_of_all=True)
    worst = np.argsort(-pair.delta_e, kind="stable")[:MOST_WORST]
    only = {name: pair.only_in(second) for name, second in (("first", False), ("second", True))}
    noise = pair.noise
    return {
        "first": pair.first.name,
        "second": pair.second.name,
        "matched": len(pair.delta_e),
        "only_in": {name: {"count": len(names), "patches": names} for name, names in only.items()},
        "delta_e_2000": {
            "mean": float(pair.delta_e.mean()),
            "median": float(np.median(pair.delta_e)),
            "percentile_95": float(np.percentile(pair.delta_e, 95)),
            "largest": float(pair.delta_e.max()),
            "worst": [pair.names[row] for row in worst],
        },
        "direction": dict(
            zip(("L", "a", "b", "C", "H"), pair.difference.mean(axis=0).tolist(), strict=True)
        ),
        "noise": None if noise is None else {"delta_e_ab": noise.value, "from": noise.source},
        "larger_than_noise": pair.larger_than_noise,
        "beyond_noise": None
        if beyond is None
        else [pair.names[row] for row in np.flatnonzero(beyond)],
        "volume": None if volumes is None else _volume_figures(volumes),
        "patches": {
            "name": pair.names,
            "device": 100.0 * pair.device,
            "lab": pair.first.lab[pair.rows[0]],
            "difference": pair.difference[:, :3],
            "delta_e_2000": pair.delta_e,
        },
    }


def _volume_figures(volumes: _Volumes) -> dict[str, Any]:
    """Return volumes, coverage and their intervals, as JSON has them."""
    interval = volumes.interval
    intervals = None
    if interval is not None:
        intervals = {
            "change": interval.larger.to_mapping(),
            "second_covers": interval.a_covers_b.to_mapping(),
            "first_covers": interval.b_covers_a.to_mapping(),
            "smallest_difference": interval.smallest_difference,
        }
    return {**volumes._asdict(), "change": volumes.change, "interval": intervals}


def _sentences(pair: ReadingPair, volumes: _Volumes | None) -> list[str]:
    figures = _figures(pair, volumes)
    delta_e, names = figures["delta_e_2000"], f"{pair.second.name} against {pair.first.name}"
    light, _, _, chroma, hue = pair.difference.mean(axis=0)
    answer = (
        f"{names}: {_verdict(pair)} Mean ΔE00 {delta_e['mean']:.2f}, 95 % up to "
        f"{delta_e['percentile_95']:.2f}, largest {delta_e['largest']:.2f} "
        f"({delta_e['worst'][0]}). On average ΔL* {_signed(light)}, ΔC* {_signed(chroma)}, "
        f"ΔH* {_signed(hue)}."
    )
    sentences = [answer]
    corners = _corners(pair)
    lightness = pair.first.lab[pair.rows[0], 0]
    darkest = min((row for _, row in corners), key=lambda row: lightness[row])
    ends = [("white", row) for name, row in corners if name == "white"]
    ends.append(("black" if ("black", darkest) in corners else "darkest patch", darkest))
    told = "; ".join(
        f"{name} ({device_text(pair.device[row])} %): ΔE00 {pair.delta_e[row]:.2f}, "
        + ", ".join(
            f"Δ{axis}* {_signed(value)}"
            for axis, value in zip("Lab", pair.difference[row, :3], strict=True)
        )
        for name, row in ends
    )
    sentences.append(f"{told[:1].upper()}{told[1:]}.")
    if volumes is not None:
        change, of_first, of_second = "", "", ""
        if volumes.interval is not None:
            change, of_first, of_second = (
                f" ± {100 * interval.half_width:.2f} %"
                for interval in (
                    volumes.interval.larger,
                    volumes.interval.a_covers_b,
                    volumes.interval.b_covers_a,
                )
            )
        sentences.append(
            f"The volume changed by {_signed(100 * volumes.change)} %{change}, from "
            f"{volumes.first:,.0f} to {volumes.second:,.0f}. {pair.second.name} covers "
            f"{100 * volumes.second_covers:.2f} %{of_first} of {pair.first.name}, which covers "
            f"{100 * volumes.first_covers:.2f} %{of_second} of it."
        )
        smallest = 0.0
        if volumes.interval is not None:
            smallest = 100 * volumes.interval.smallest_difference
        if smallest >= 0.05:
            noise = "without their noise" if pair.noise is None else "this noise"
            sentences.append(
                f"With these numbers of patches and {noise}, changes of volume below "
                f"{smallest:.1f} % mean nothing."
            )
    for name, second in ((pair.first.name, False), (pair.second.name, True)):
        alone = pair.only_in(second)
        if alone:
            listed = ", ".join(alone[:MOST_NAMED]) + (", …" if len(alone) > MOST_NAMED else ".")
            patches = "1 patch is" if len(alone) == 1 else f"{len(alone)} patches are"
            sentences.append(f"{patches} in {name} only, and not compared: {listed}")
    return sentences


def _signed(value: float) -> str:
    return fixed_text(value, 2, signed=True)


def _verdict(pair: ReadingPair) -> str:
    """Return the sentence on change and noise."""
    noise, beyond = pair.noise, pair.beyond_noise(any_of_all=True)
    if not pair.difference.any():
        return "no patch changed."
    if noise is None or beyond is None:
        return "whether the change is larger than the noise is not known."
    stated = f"the noise, {number_text(noise.value, 2)} ΔE*ab ({noise.source})"
    marked, root = np.flatnonzero(beyond), float(np.sqrt(pair.squares.mean()))
    if not pair.larger_than_noise:
        return f"the change is within {stated}."
    listed = ", ".join(
        f"{pair.names[row]}: {device_text(pair.device[row])} %" for row in marked[:MOST_NAMED]
    )
    listed = f" ({listed}{', …' if len(marked) > MOST_NAMED else ''})" if listed else ""
    of_patches = f"{len(marked)} of {len(beyond)} patches changed more than it explains{listed}"
    whole = f"{number_text(root, 2)} times as large as noise alone gives"
    if pair.whole_is_beyond_noise:
        return f"the change is larger than {stated}: {whole}; {of_patches}."
    return f"the change is larger than {stated}, in single patches: {of_patches}."


def _report(
    pairs: Sequence[ReadingPair],
    volumes: Sequence[_Volumes | None],
    warnings: Sequence[str],
    options: Options,
) -> Report:
    all_figures = [_figures(*both) for both in zip(pairs, volumes, strict=True)]
    delta_e = [figures["delta_e_2000"] for figures in all_figures]
    means = np.array([pair.difference.mean(axis=0) for pair in pairs])
    changes = [None if volume is None else 100.0 * volume.change for volume in volumes]
    widths = [
        100.0 * volume.interval.larger.half_width if volume and volume.interval else None
        for volume in volumes
    ]
    covers = [None if volume is None else volume.second_covers for volume in volumes]
    columns = [
        ReportColumn("reading", [pair.second.name for pair in pairs]),
        ReportColumn("patches", [len(pair.delta_e) for pair in pairs]),
        *(
            ReportColumn(title, [figures[name] for figures in delta_e])
            for title, name in (
                ("ΔE00 mean", "mean"),
                ("median", "median"),
                ("95 %", "percentile_95"),
                ("largest", "largest"),
            )
        ),
        ReportColumn("beyond noise", [pair.larger_than_noise for pair in pairs]),
        *(
            ReportColumn(f"Δ{name}*", means[:, at].tolist())
            for name, at in (("L", 0), ("C", 3), ("H", 4))
        ),
        ReportColumn("volume", changes, "%"),
        ReportColumn("±", widths, "%"),
        ReportColumn("coverage", covers, kind="share", decimals=3),
        ReportColumn("noise", [pair.noise and pair.noise.value for pair in pairs], "ΔE*ab"),
        ReportColumn("worst patch", [figures["worst"][0] for figures in delta_e]),
    ]
    tables = [ReportTable(f"Readings against {pairs[0].first.name}", columns)]
    for pair in pairs:
        names, rows = zip(*_corners(pair), strict=True)
        worst = np.argsort(-pair.delta_e, kind="stable")[:MOST_WORST].tolist()
        title = pair.second.name
        tables += [
            _patch_table(f"{title}: white, solids and overprints", names, pair, rows),
            _patch_table(
                f"{title}: largest changes", [pair.names[row] for row in worst], pair, worst
            ),
        ]
    first = pairs[0].first
    lights = first.colours.as_measured
    conditions = {
        "first reading": f"{first.name}, {len(first.device)} patches",
        "colours": "CIELAB relative to the white of the first reading"
        if lights
        else "CIELAB as measured, D50",
        "volumes": f"{options.space}, intent {options.intent}, each relative to its own white"
        if options.intent == "relative"
        else f"{options.space}, intent {options.intent}",
        "patches": "matched by device values within half a step of 8 bits; repeats are averaged",
        "noise": "RMS ΔE*ab of one reading; alone it counts as a change in 1 of 100",
        **{
            name: text
            for name in ("measurement condition", "illuminant", "observer", "backing")
            if (text := stated_condition(first, name))
        },
    }
    sentences = [text for both in zip(pairs, volumes, strict=True) for text in _sentences(*both)]
    charts = [Chart("Share of the patches up to a ΔE00", partial(_draw, pairs))]
    data = {"pairs": all_figures}
    return Report(
        f"Drift from {first.name}", sentences, conditions, tables, charts, tuple(warnings), data
    )


def _draw(pairs: Sequence[ReadingPair], figure: Figure) -> None:
    axes = figure.add_subplot()
    for pair in pairs:
        values = np.sort(pair.delta_e)
        share = 100.0 * np.arange(1, len(values) + 1) / len(values)
        axes.step(values, share, where="post", label=plot_text(pair.second.name))
    axes.axhline(95.0, color="0.7", linewidth=0.8)
    axes.set(xlabel="ΔE00", ylabel="patches (%)", xlim=(0, None), ylim=(0, 101))
    axes.legend(loc="lower right")
