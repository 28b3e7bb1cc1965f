"""ICC profiles of devices: output and display profiles of versions 2, 4 and 5, from a device model.

Colours are those of the device model, or measured ones where a node of a table has the device
values of a sample. Device values are those of the model's inverse. A display whose channels nearly
add has a matrix and curves; other devices have tables, and all have them in version 5. The error of
the file against the model is measured for each profile.
"""

from __future__ import annotations

import os
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, cast

import numpy as np

from gamutcore.arguments import Choice, WholeNumber, check_option
from gamutcore.building import parsed_input
from gamutcore.characterisation import IccProfile, Samples, read_characterisation
from gamutcore.characterisation.icc import looks_like_icc
from gamutcore.colours import (
    SPACE_PARAMETERS,
    RgbSpace,
    adaptation_matrix,
    compensate_black,
    consistent_samples,
    lab_to_xyz,
    luminance_of_black,
    measured_colours,
    xyz_to_lab,
)
from gamutcore.content import content_of, gamut_source, is_saved_gamut
from gamutcore.errors import OptionError, ReferenceNameError, errors_in
from gamutcore.export.icc_file import (
    COPYRIGHT,
    D50,
    curve_element,
    data_space,
    description_element,
    fixed_element,
    icc_file,
    text_element,
    xyz_element,
)
from gamutcore.export.picture_file import atomic_write
from gamutcore.gamut import Gamut
from gamutcore.limits import Limits
from gamutcore.links.profile_tables import InverseTables, forward_table
from gamutcore.links.table import check_path
from gamutcore.questions import PICTURE_SPACE, black_rule, map_points, no_limit_warnings
from gamutcore.references import Reference
from gamutcore.results import TabularRepr
from gamutcore.search import delta_e_2000

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from gamutcore.arrays import FloatArray
    from gamutcore.colours import DeviceModel
    from gamutcore.links.profile_tables import InverseTable
    from gamutcore.options import Options

__all__ = [
    "PROFILE_SIZE",
    "PROFILE_SUFFIXES",
    "Differences",
    "Profile",
    "profile",
]

PROFILE_SIZE = Annotated[int, WholeNumber(9, 65)]
"""Nodes of B2A tables along L*, a* and b*."""

PROFILE_VERSION = Annotated[int, Choice((2, 4, 5))]
"""Versions of profiles."""

SOURCE_GAMUT = "srgb"
"""Gamut that the perceptual intent maps from."""

_SOURCE_SAMPLES = 20_000
"""Samples of a reference gamut that is mapped from; 100,000 take 3 s more."""

ADDITIVE = 1.0
"""Largest 95th percentile of ΔE00 between a matrix with curves and the model of a display: a just
noticeable difference. Other displays get tables."""

INPUTS = 20_000
"""Random device values at which the errors are measured. Those beyond the ink limit are scaled."""

EDGE_STEPS = 65
"""Places on each edge of the device's cube where the errors are measured as well."""

_CURVE = 1024
"""Entries of the curves of a display: 10 bits, and a multiple of the levels of 8 bits."""

_PERCEPTUAL_BLACK = 0.0034731
"""Luminance of the black of the perceptual reference medium (ICC.1:2010, 6.3.4.3)."""

PROFILE_SUFFIXES = (".icc", ".icm")
"""Suffixes of profiles."""


@dataclass(frozen=True, kw_only=True)
class Differences:
    """Colour differences CIEDE2000 between a profile and the device model.

    Attributes
    ----------
    mean, percentile_95 : float
        Of `INPUTS` random device values within the ink limits.
    worst : float
        Of these and of the edges of the device's cube.
    """

    mean: float
    percentile_95: float
    worst: float

    @classmethod
    def of(cls, one: FloatArray, two: FloatArray) -> Differences:
        """Return those between colours in CIELAB; the first `INPUTS` are of random values."""
        delta_e = delta_e_2000(one, two)
        some = delta_e[:INPUTS]
        return cls(
            mean=float(some.mean()),
            percentile_95=float(np.percentile(some, 95.0)),
            worst=float(delta_e.max()),
        )

    def __str__(self) -> str:
        return f"mean {self.mean:.3f}, 95 % {self.percentile_95:.3f}, worst {self.worst:.2f} dE00"


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Profile(TabularRepr):
    """An ICC profile of a device.

    Attributes
    ----------
    name : str
        What the description begins with.
    device_class : {"prtr", "mntr"}
        Output device or display.
    version : int
        2, 4 or 5.
    channels : tuple of str
        Names of the device's channels.
    form : {"tables", "matrix"}
        Lookup tables, or a matrix with curves.
    forward : Differences
        Between the colours that the profile gives for device values, and those of the model.
    round_trip : Differences or None
        Between colours in gamut and the colours of the device values that the profile gives for
        them, by the profile and with the relative intent. None for a matrix, which has an exact
        inverse.
    warnings : tuple of str
        Those of the device's gamut.
    """

    name: str
    device_class: str
    version: int
    channels: tuple[str, ...]
    form: Literal["tables", "matrix"]
    forward: Differences
    round_trip: Differences | None
    warnings: tuple[str, ...]
    _data: bytes

    def to_bytes(self) -> bytes:
        """Return the profile as a file. Equal inputs give equal bytes."""
        return self._data

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the profile to an ``.icc`` or ``.icm`` file, complete or not at all.

        Raises
        ------
        OptionError
            The name has another suffix.
        OSError
            The file cannot be written.
        """
        target = Path(path)
        check_path(target, PROFILE_SUFFIXES)
        with atomic_write(target) as draft:
            draft.write_bytes(self._data)


def profile(
    data: object,
    *,
    version: int = 2,
    black: str | float | ArrayLike = "medium",
    size: int = 33,
    source_gamut: Gamut | str | os.PathLike[str] = SOURCE_GAMUT,
    name: str | None = None,
    gamut_boundary: bool = False,
    triangles: int | None = None,
    **options: Any,  # noqa: ANN401  # checked by Options
) -> Profile:
    """Make an ICC profile of a press or a display.

    Parameters
    ----------
    data : path, bytes, table or Gamut
        Measurements with device values, in any form that `Gamut` accepts; an ICC profile; the name
        of an RGB space; or a gamut with a device model and the intent ``relative``.
    version : {2, 4, 5}, optional
        Of the profile; 5 is iccMAX.
    black : str, float or array_like, optional
        How much black the device values have, as for `Gamut.to_device`.
    size : int, optional
        Nodes of the B2A tables along L*, a* and b*, 9 to 65.
    source_gamut : Gamut, str or path, optional
        Gamut that the perceptual intent maps from, as `Gamut.map` accepts.
    name : str, optional
        What the description begins with; by default that of the data.
    gamut_boundary : bool, optional
        Whether the profile has its gamut as a mesh in CIELAB with device values. Needs version 5.
    triangles : int, optional
        Largest number of triangles of this mesh; 1000 by default.
    **options
        How the gamut is built, as for `Gamut`, such as ``ink_limit``. The space of the gamut
        mapping is CAM16-UCS unless given. A `Gamut` has its own options.

    Returns
    -------
    Profile

    Raises
    ------
    OptionError
        An option is not accepted, the intent is not ``relative``, or the device has fewer than
        three channels; ``where["field"]`` names it.
    DeviceModelError
        The data has no device model: it is of bare colours, a picture or a mesh.
    GamutError
        The data cannot be read, or no gamut can be built.
    OSError
        A file cannot be read.

    Notes
    -----
    The relative intent clips to the nearest colours, the perceptual one compresses from
    `source_gamut` by ``sgck``, and the saturation intent scales black and clips towards the cusp.
    A2B nodes at the device values of samples have the measured colours, and others the model's.
    `Profile.forward` and `Profile.round_trip` have the differences from the model, and the
    description of the file states them.

    Examples
    --------
    >>> made = profile("examples/FOGRA39L.ti3", size=9, surface_samples=1000, ink_limit=300)
    >>> made.device_class, made.form, made.forward.mean < 0.2
    ('prtr', 'tables', True)
    """
    version = int(check_option("version", version, PROFILE_VERSION))
    size = int(check_option("size", size, PROFILE_SIZE))
    if gamut_boundary and version != 5:
        raise OptionError.not_applicable(
            "gamut_boundary", True, f"version {version} has no gamut boundaries", "Give version 5."
        )
    if triangles is not None and not gamut_boundary:
        raise OptionError.not_applicable(
            "triangles", triangles, "only a gamut boundary has triangles", "Give gamut_boundary."
        )
    gamut, content = _gamut(data, options)
    level = _in_cielab(gamut, content, options).mesh(triangles) if gamut_boundary else None
    device = _Device.of(gamut)
    rule = black_rule(black, device.model)
    samples = None if content is None else _samples(content, gamut.options)
    elements, form = None, "tables"
    if device.kind == "mntr" and device.space == "RGB " and version < 5:
        elements = _matrix(device.model)
    inverse: InverseTable | None = None
    if elements is not None:
        form = "matrix"
    else:
        mappings = _mappings(gamut, source_gamut, version)
        inverse_tables = InverseTables(gamut, rule, size)
        inverse, distances = inverse_tables.colorimetric()
        elements = {**_forward_tables(device, _measured(samples, gamut.options), version)}
        elements["B2A1"] = inverse.to_bytes(version)
        for tag, colours, mapping in mappings:
            elements[tag] = inverse_tables.mapped(colours, mapping).to_bytes(version)
        elements["gamt"] = distances.to_bytes(version)
    tags = {**device.tags(version), **elements}
    if content is not None and samples is not None:
        tags["targ"] = text_element(_measurements(content, samples, gamut))
    title = name or _title(data, gamut)

    def file(description: str) -> bytes:
        head = {"desc": description_element(description, version)}
        head["cprt"] = (
            text_element(COPYRIGHT) if version == 2 else description_element(COPYRIGHT, version)
        )
        pcs = "Lab " if form == "tables" else "XYZ "
        intent = "perceptual" if form == "matrix" else "relative"
        profile = icc_file(version, device.kind, (device.space, pcs), {**head, **tags}, intent)
        return profile if level is None else level.to_bytes("icc", into=profile)

    forward, round_trip = _errors(file(title), device.model, inverse)
    errors = f"error of A2B {forward}"
    if round_trip is not None:
        errors += f"; round trip {round_trip}"
    return Profile(
        name=title,
        device_class=device.kind,
        version=version,
        channels=device.model.channels,
        form=cast("Literal['tables', 'matrix']", form),
        forward=forward,
        round_trip=round_trip,
        warnings=(
            *gamut.conditions.build_warnings,
            *no_limit_warnings(gamut.options, device.model),
        ),
        _data=file(f"{title}: {errors}"),
    )


def _gamut(data: object, options: dict[str, Any]) -> tuple[Gamut, bytes | None]:
    """Return the gamut of some data, and the data itself unless it is a gamut already."""
    source = data
    if isinstance(data, str | os.PathLike):
        input_data = gamut_source(data)
        data = input_data.data if isinstance(input_data, Reference) else input_data
    with errors_in(source):
        if isinstance(data, bytes) and is_saved_gamut(data):
            data = Gamut.from_bytes(data)
        if not isinstance(data, Gamut):
            content = content_of(data)
            return _checked(Gamut(content, {"space": PICTURE_SPACE, **options})), content
    for field, value in options.items():
        raise OptionError.not_applicable(field, value, "the gamut is built already")
    return _checked(data), None


def _in_cielab(gamut: Gamut, content: bytes | None, options: dict[str, Any]) -> Gamut:
    """Return the gamut in CIELAB relative to D50, in which boundaries of profiles are."""
    if gamut.colour_space.is_icc_cielab:
        return gamut
    if content is None:
        raise OptionError.not_applicable(
            "gamut_boundary", True, "the gamut is not in CIELAB", "Give the measurements."
        )
    others = {name: options[name] for name in options.keys() - {"space", *SPACE_PARAMETERS}}
    return Gamut(content, others)


def _checked(gamut: Gamut) -> Gamut:
    if not gamut.has_device_model:
        raise gamut.no_device_model()
    intent = gamut.options.intent
    if intent != "relative":
        raise OptionError.not_applicable(
            "intent", intent, "profiles hold media-relative colours", "Give relative."
        )
    return gamut


class _Device(NamedTuple):
    """A device as a profile names it: class, data colour space, white and black.

    `white` are tristimulus values relative to D50 with the intent absolute, and `black` is the
    darkest neutral colour in CIELAB, media-relative.
    """

    model: DeviceModel
    kind: str
    space: str
    white: FloatArray
    black: FloatArray
    adaptation: str

    @classmethod
    def of(cls, gamut: Gamut) -> _Device:
        model, facts = gamut.device_model, gamut.description["provenance"]
        lights = (
            facts.get("format") == "reference"
            or str(facts.get("medium", "")).startswith("display")
            or facts.get("device_class") in {"display", "colour space"}
        )
        white = lab_to_xyz(np.array([facts.get("white_lab", (100.0, 0.0, 0.0))]))[0]
        black = map_points(gamut, np.zeros((1, 3)), "clip-lightness", max_error=0.0)[0]
        adaptation = gamut.options.adaptation or "Bradford"
        kind = "mntr" if lights and not model.inks else "prtr"
        return cls(model, kind, data_space(model.channels), white, black, adaptation)

    def tags(self, version: int) -> dict[str, bytes]:
        """Return the tags of white, black and channels."""
        black = lab_to_xyz(self.black[np.newaxis])[0]
        if self.kind == "mntr":  # the eye is adapted to a display (ICC.1:2010, 9.2.34)
            matrix = adaptation_matrix(self.white, np.array(D50), self.adaptation)
            tags = {"wtpt": xyz_element(D50), "chad": fixed_element(matrix)}
        else:
            tags = {"wtpt": xyz_element(self.white)}
            black = black * self.white / np.array(D50)
        if version == 2:
            tags["bkpt"] = xyz_element(black)
        elif self.space.endswith("CLR"):
            tags["clrt"] = self._colorants()
        return tags

    def _colorants(self) -> bytes:
        """Return an element of the type colorantTableType (ICC.1:2010, 10.4)."""
        solids = np.eye(len(self.model.channels))
        scale, offset = np.array((655.35, 257.0, 257.0)), np.array((0.0, 128.0, 128.0))
        lab = np.clip((self.model.lab(solids) + offset) * scale, 0.0, 65535.0)
        codes = np.round(lab).astype(">u2")
        rows = [
            channel.encode("ascii", "replace")[:31].ljust(32, b"\0") + code.tobytes()
            for channel, code in zip(self.model.channels, codes, strict=True)
        ]
        return b"clrt" + struct.pack(">2I", 0, len(rows)) + b"".join(rows)


def _samples(content: bytes, options: Options) -> Samples | None:
    """Return the measured samples of a file; None if it has none."""
    parsed = parsed_input(content, options, Limits())
    return parsed if isinstance(parsed, Samples) and parsed.device is not None else None


def _measurements(content: bytes, samples: Samples, gamut: Gamut) -> str:
    """Return measured samples as CGATS text: the file itself, or its device values and colours."""
    if gamut.description["provenance"]["format"] == "cgats" and not looks_like_icc(content):
        return content.decode("latin-1")
    space = data_space(gamut.channels).strip()
    numbered = space.endswith("CLR")
    count = len(gamut.device_model.channels)
    names = [f"{space}_{i + 1 if numbered else space[i]}" for i in range(count)]
    columns = [] if samples.device is None else [100.0 * samples.device]
    for values, titles in (
        (samples.lab, "LAB_L LAB_A LAB_B"),
        (samples.xyz, "XYZ_X XYZ_Y XYZ_Z"),
    ):
        if values is not None:
            columns.append(values)
            names += titles.split()
    lines = [" ".join(f"{value:.6g}" for value in row) for row in np.hstack(columns).tolist()]
    head = f"CGATS.17\nNUMBER_OF_FIELDS {len(names)}\nBEGIN_DATA_FORMAT\n{' '.join(names)}\n"
    head += f"END_DATA_FORMAT\nNUMBER_OF_SETS {len(lines)}\nBEGIN_DATA\n"
    return head + "\n".join(lines) + "\nEND_DATA\n"


def _title(data: object, gamut: Gamut) -> str:
    facts = gamut.description["provenance"]
    stated = facts.get("conditions", {}).get("DESCRIPTOR") or facts.get("reference")
    function = gamut.device_model.function
    if isinstance(function, RgbSpace) and function.is_for_displays:
        stated = f"{stated}, {function.reference.decoding}"
    if not stated and isinstance(data, str | os.PathLike):
        stated = Path(data).stem
    return " ".join(str(stated or f"gamut {gamut.id[:12]}").split())[:80]


def _measured(samples: Samples | None, options: Options) -> tuple[FloatArray, FloatArray] | None:
    """Return device values and media-relative colours of samples."""
    if samples is None or samples.device is None:
        return None
    samples = consistent_samples(samples)
    assert samples.device is not None  # noqa: S101 (checked above)
    colours = measured_colours(
        samples,
        "relative",
        observer=options.observer,
        illuminant=options.illuminant,
        adaptation=options.adaptation or "Bradford",
    )
    return samples.device, colours.lab


def _forward_tables(
    device: _Device, measured: tuple[FloatArray, FloatArray] | None, version: int
) -> dict[str, bytes]:
    """Return A2B tables. Perceptual black is that of the reference medium from version 4 on."""
    relative = forward_table(device.model, measured, version=version)
    tables = {"A2B0": relative, "A2B1": relative, "A2B2": relative}
    if version >= 4:
        black = luminance_of_black(lab_to_xyz(device.black[np.newaxis])[0])

        def change(lab: FloatArray) -> FloatArray:
            return xyz_to_lab(compensate_black(lab_to_xyz(lab), black, _PERCEPTUAL_BLACK))

        tables["A2B0"] = forward_table(device.model, measured, change, version)
    return tables


def _mappings(
    gamut: Gamut, source_gamut: Gamut | str | os.PathLike[str], version: int
) -> list[tuple[str, FloatArray, Callable[[FloatArray], FloatArray]]]:
    """Return tag, source colours and mapping of the perceptual and the saturation intent."""
    source = _source(gamut, source_gamut)
    colours = source.convert(source.level(source.history.triangles).vertices, "CIELAB")

    def perceptual(lab: FloatArray) -> FloatArray:
        if version >= 4:
            lab = xyz_to_lab(compensate_black(lab_to_xyz(lab), _PERCEPTUAL_BLACK, 0.0))
        return map_points(gamut, lab, "sgck", source=source, max_error=0.0)

    def saturation(lab: FloatArray) -> FloatArray:
        return map_points(
            gamut, lab, "clip-focal", focus="cusp", black_point_compensation=True, max_error=0.0
        )

    return [("B2A0", colours, perceptual), ("B2A2", colours, saturation)]


def _source(gamut: Gamut, source: Gamut | str | os.PathLike[str]) -> Gamut:
    """Return the gamut that the perceptual intent maps from, in the space of the device's."""
    if isinstance(source, Gamut):
        return source
    try:
        input_data = gamut_source(source)
    except ReferenceNameError as error:
        error.where["field"] = "source_gamut"
        raise
    gamut_options = gamut.options.to_mapping()
    options = {
        name: gamut_options[name] for name in ("space", *SPACE_PARAMETERS) if name in gamut_options
    }
    if isinstance(input_data, Reference):
        return Gamut(input_data.data, {**options, "surface_samples": _SOURCE_SAMPLES})
    with errors_in(source):
        return (
            Gamut.from_bytes(input_data)
            if is_saved_gamut(input_data)
            else Gamut(input_data, options)
        )


def _matrix(model: DeviceModel) -> dict[str, bytes] | None:
    """Return matrix and curves of an RGB display; None if its channels do not add.

    Curves begin at the luminance k of black. The colour of a value is then Σ c(v)·m, where
    c = k + (1 − k)·t, and t is 0 to 1 on a channel alone. The sum of the columns m is white.
    """
    steps = np.linspace(0.0, 1.0, _CURVE)
    ramps = np.zeros((3, _CURVE, 3))
    for channel in range(3):
        ramps[channel, :, channel] = steps
    xyz = lab_to_xyz(model.lab(ramps.reshape(-1, 3))).reshape(3, _CURVE, 3)
    dark = xyz[:, 0].mean(axis=0)
    primaries = xyz[:, -1] - dark
    k = float(np.clip(dark[1], 0.0, 0.5))
    white = np.array(D50)
    columns = primaries / (1.0 - k)
    columns += (white - columns.sum(axis=0)) / 3.0
    along = ((xyz - dark) * primaries[:, np.newaxis]).sum(axis=2)
    t = np.clip(along / np.maximum((primaries**2).sum(axis=1), 1e-12)[:, np.newaxis], 0.0, 1.0)
    curves = k + (1.0 - k) * np.maximum.accumulate(t, axis=1)
    values = _tried(model)
    light = np.stack([np.interp(values[:, i], steps, curves[i]) for i in range(3)], axis=1)
    differences = Differences.of(model.lab(values), xyz_to_lab(light @ columns))
    if differences.percentile_95 > ADDITIVE:
        return None
    tags = {f"{name}XYZ": xyz_element(column) for name, column in zip("rgb", columns, strict=True)}
    return tags | {
        f"{name}TRC": curve_element(curve) for name, curve in zip("rgb", curves, strict=True)
    }


def _tried(model: DeviceModel) -> FloatArray:
    """Return device values at which errors are measured: random ones, then those on edges.

    Edges are those of the cube with at most two other full channels, within the ink limits.
    """
    cube, limited = model.limited.cube, model.limited
    count = len(cube.lowest)
    along = np.linspace(0.0, 1.0, EDGE_STEPS)
    edges = []
    for channel in range(count):
        for one in range(count):
            for two in range(one, count):
                row = np.zeros((EDGE_STEPS, count))
                row[:, [one, two]] = 1.0
                row[:, channel] = along
                edges += [row, np.where(np.arange(count) == channel, row, 0.0)]
    shares = np.unique(np.concatenate(edges), axis=0)
    ranges, room = cube.highest - cube.lowest, cube.largest_sum - float(cube.lowest.sum())
    edge = shares * ranges
    edge = edge[edge.sum(axis=1) <= room + 1e-9]
    values = np.random.default_rng(0).random((INPUTS, count)) * ranges
    values *= np.minimum(1.0, room / np.maximum(values.sum(axis=1), 1e-9))[:, np.newaxis]
    return limited.device(cube.lowest + np.concatenate([values, edge]))


def _errors(
    data: bytes, model: DeviceModel, inverse: InverseTable | None
) -> tuple[Differences, Differences | None]:
    """Measure a file against the model; `inverse` is its table B2A1."""
    read = read_characterisation(data)
    if not isinstance(read, IccProfile):
        raise TypeError("the file is no profile")
    transform, _ = read.transform("relative")
    values = _tried(model)
    lab = model.lab(values)

    def colours(device: FloatArray) -> FloatArray:
        pcs_values = transform.pcs_values(device)
        return xyz_to_lab(pcs_values) if read.pcs == "XYZ" else pcs_values

    forward = Differences.of(lab, colours(values))
    if inverse is None:
        return forward, None
    return forward, Differences.of(lab, colours(inverse.values(lab)))
