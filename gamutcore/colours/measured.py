"""Measured samples as CIELAB colours, relative to the white of their medium or as measured.

This step decides whether two gamuts are comparable. The white, the adaptation, the illuminant and
the observer are therefore recorded in the provenance, and every assumption is a warning. The rules
and their sources are in ``docs/decisions/media-relative.md``.

The colour of a spectrum is its product with a matrix of weights (ASTM E308). The matrix combines
the colour-matching functions, the illuminant and the interpolation between bands.
"""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.characterisation.columns import is_reflective_condition
from gamutcore.characterisation.samples import JSON, reflectance_scale
from gamutcore.colours.colorimetry import (
    ICC_D50,
    adaptation_matrix,
    adaptation_text,
    adaptation_to_d50,
    colour_science,
    lab_to_xyz,
    white_of,
    xyz_to_lab,
)
from gamutcore.colours.device_model import (
    device_model,
    extrapolation_warnings,
    impossible_colour_warnings,
    range_warnings,
)
from gamutcore.colours.ink_limits import InkLimits, limited_cube, surface_corners
from gamutcore.colours.models import DeviceModel
from gamutcore.colours.sampling import (
    AbsoluteColours,
    SurfaceColours,
    count_warnings,
    device_colours,
    surface_values,
)
from gamutcore.errors import InvalidPointsError, OptionError
from gamutcore.number_text import number_text

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation.samples import Samples

_NAMED_ILLUMINANT = re.compile(r"\b(?:ILLUMINANT[,:=\s]+)?(D50|D55|D65|D75|FL?\d{1,2}|[ACE])\b")
_DAYLIGHT = re.compile(r"\b(D50|D55|D65|D75)\b")
_OBSERVER = re.compile(r"\b(2|10)\s*(?:°|\xba|DEG|\ufffd)|OBSERVER[\w\s,:=]*?\b(2|10)\b")
_ILLUMINANT_KEYWORDS = ("ILLUMINANT", "ILLUMINATION_NAME")
_OBSERVER_KEYWORDS = ("OBSERVER", "OBSERVER_ANGLE", "CIE_OBSERVER_ANGLE", "CIE_OBSERVER")
_TELLING_KEYWORDS = ("WEIGHTING_FUNCTION", "MEASUREMENT_SOURCE", "INSTRUMENTATION")
_PLAIN_NUMBER = re.compile(r"\d{1,6}(\.\d{1,12})?")
_CONSISTENT = 2.0
"""Mean ΔE*ab up to which Lab and XYZ columns agree; XYZ with two decimals differs by 0.1."""

_POOR_FIT = 5.0
"""Mean leave-one-out ΔE*ab above which a model is called unreliable; real devices reach 0.1 to
1.5."""

_USELESS_FIT = 10.0
"""Mean leave-one-out ΔE*ab from which a model says nothing about the white: that of solids and
overprints alone is 17, and misses the paper by as much; three levels of a display have 7."""

_APART = 1e-6
"""Smallest range of a channel that varies, as a share of its full range."""

_LEAST, _MOST_EXTRAPOLATED = 0.98, 5.0
"""Range of the luminance of an extrapolated white, relative to the lightest sample. A fit misses a
paper by 1 % of its luminance; the primaries alone of a display have from 0.07 to 0.7 of it."""

_LIGHTEST_PAPER = 1.2
"""Largest Y of a paper, with fluorescence."""

_NEAR_WHITE = 0.05
"""Largest difference of device values from white of a sample that can stand for it without a
device model: 1 ΔE00 of yellow, 3 of black."""

_SAME_READING = 0.01
"""ΔE*ab below which repeats are copies of one reading, or of their mean."""

_FIT_REMEDY = (
    "Leave it out to use the samples' own colours. Or send at least two distinct device values "
    "more than there are varying channels, and not all of them in one plane."
)


@dataclass(frozen=True, eq=False)
class MeasuredColours:
    """CIELAB colours of samples (n, 3) relative to ICC's D50, and their reference.

    The provenance has the white, illuminant, observer, adaptation and intent. `as_measured` tells
    that the tristimulus values are a display's own, without adaptation, and `lights` that the data
    states that the samples are lights. `absolute` is the way from media-relative colours to
    absolute ones; None for bare colours. `white_sample` has the device value (1, k) and the colour
    (1, 3) of a white that was not measured, where the samples surround it.
    """

    lab: FloatArray
    provenance: dict[str, JSON]
    warnings: tuple[str, ...]
    as_measured: bool = False
    lights: bool = False
    absolute: AbsoluteColours | None = None
    white_sample: tuple[FloatArray, FloatArray] | None = None


def measured_colours(
    samples: Samples,
    intent: str,
    *,
    observer: int | None = None,
    illuminant: str | None = None,
    adaptation: str = "Bradford",
) -> MeasuredColours:
    """Return CIELAB colours of measured samples.

    Data with both colours and spectra is used by its colours if they are for D50 and 2° and the
    caller requests nothing else; otherwise by its spectra. The declared illuminant and observer
    belong to the colours, and to the spectra in data of spectra alone.

    ``"relative"`` makes the medium's white the white of D50 (L* 100). ``"absolute"`` keeps colours
    as measured; a display's luminance stays relative to its white. Unless given, observer and
    illuminant are those that data without colours declares, else 2° and D50.
    """
    OptionError.check_intent(intent, "the data is measured samples")
    return _Medium(samples, intent, observer, illuminant, adaptation).colours()


class _Medium:
    """The samples' medium: its kind, its white, and the assumptions about it."""

    def __init__(
        self,
        samples: Samples,
        intent: str,
        observer: int | None,
        illuminant: str | None,
        adaptation: str,
    ) -> None:
        self.adaptation = adaptation
        self.as_measured = False
        self.extrapolated: FloatArray | None = None
        self.samples = samples
        self.intent = intent
        self.warnings: list[str] = []
        declared = _stated_display(samples)
        self.assumed = declared is None and samples.additive
        self.display = self.assumed if declared is None else declared
        if self.assumed:
            self.warnings.append(
                "The data does not state its medium. Its RGB values are assumed to be a display's; "
                "state DEVICE_CLASS OUTPUT for a printer or other reflecting samples."
            )
        self.illuminant, self.illuminant_text = self._illuminant()
        self.foreign_observer = ""
        self.observer, self.observer_text = self._observer()
        stated = self.illuminant if self.illuminant_text == self.illuminant else ""
        self.declared_illuminant = re.sub("^F(?=[0-9])", "FL", stated)
        self.declared_observer = self.observer if self.observer_text == f"{self.observer}°" else ""
        self.reference = self._reference_white()
        self.colours_from = "LAB" if samples.lab is not None else "XYZ"
        if self._needs_spectra(observer, illuminant):
            self._integrate(observer, illuminant)
        else:
            self._check_requested(observer, illuminant)
        if self.foreign_observer and observer is None:
            self.warnings.append(
                f"The declared observer {self.foreign_observer[:40]} is neither CIE 1931 (2°) nor "
                "CIE 1964 (10°); 2° is used."
            )

    def colours(self) -> MeasuredColours:
        """Return the colours with the provenance and all warnings."""
        samples, white = self.samples, None
        medium = "display" if self.display else "reflective"
        if samples.device is None and samples.white is None:
            medium = "unknown"
            lab, adaptation = self._bare_lab()
        else:
            xyz = self._tristimulus_values()
            white = self._white(xyz)
            if white is None and (self.intent == "relative" or self.display):
                raise InvalidPointsError(
                    "The white of the medium was not measured, and no device model gives it.",
                    where={"field": "white"},
                    remedy="Add the sample without ink (of lights: with all channels at full "
                    "scale), or state the white.",
                )
            needed = self.intent == "relative" or (self.display and samples.lab is None)
            if white is not None and needed and not (white > 0).all():
                raise InvalidPointsError(
                    f"The medium's white has the tristimulus values {_list_of(white)}.",
                    where={"field": "white"},
                    remedy="Give a white with positive X, Y and Z.",
                )
            medium = "display (assumed, not stated)" if self.assumed else medium
            lab, adaptation = self._absolute_print(xyz)
            if white is not None and self.display:
                lab, adaptation = self._display_lab(xyz, white)
            elif white is not None and self.intent == "relative":
                lab, adaptation = self._relative_print(xyz, white)
        provenance: dict[str, JSON] = {
            "intent": self.intent,
            "medium": medium,
            "white": None if white is None else _list_of(white),
            "illuminant": self.illuminant_text,
            "observer": self.observer_text,
            "adaptation": adaptation,
            "colours_from": self.colours_from,
        }
        # luminance of a display's white in cd/m², as Argyll's files declare it
        stated = samples.conditions.get("LUMINANCE_XYZ_CDM2", "").split()
        if self.display and len(stated) == 3 and _PLAIN_NUMBER.fullmatch(stated[1]):
            provenance["white_luminance"] = round(float(stated[1]), 4)
        absolute = None if white is None or not (white > 0).all() else self._absolute(white)
        sample = None
        if self.extrapolated is not None and absolute is not None:
            matrix = np.eye(3) if self.intent == "relative" else absolute.matrix
            sample = self.extrapolated[np.newaxis], xyz_to_lab(matrix @ ICC_D50)[np.newaxis]
        return MeasuredColours(
            lab,
            provenance,
            tuple(self.warnings),
            self.as_measured,
            self.display and not self.assumed,
            absolute,
            sample,
        )

    def _absolute(self, white: FloatArray) -> AbsoluteColours:
        """Return the way from relative to absolute colours, as `_display_lab` and `_print_lab`."""
        if not self.display:
            if not np.array_equal(self.reference, ICC_D50):
                white = adaptation_to_d50(white[np.newaxis], self.reference, self.adaptation)[0]
            return AbsoluteColours(np.diag(white / ICC_D50))
        adaptation = adaptation_matrix(ICC_D50, white / white[1], self.adaptation)
        if self.samples.lab is not None and np.array_equal(self.reference, ICC_D50):
            return AbsoluteColours(adaptation * white[1])
        return AbsoluteColours(adaptation, as_measured=True)

    def _needs_spectra(self, observer: int | None, illuminant: str | None) -> bool:
        samples = self.samples
        if samples.spectra is None:
            return False
        colours = samples.lab is not None or samples.xyz is not None
        has_options = observer is not None or illuminant is not None
        self_luminous = self.display and samples.lab is None
        usual = self.observer == "2" and (self.illuminant == "D50" or self_luminous)
        usual = usual and not self.foreign_observer
        return has_options or not colours or not usual

    def _check_requested(self, observer: int | None, illuminant: str | None) -> None:
        """Refuse an observer or illuminant other than that of the colours."""
        if observer is not None and str(observer) != self.observer:
            raise _other_condition("observer", observer, f"{self.observer}°")
        if illuminant is not None:
            if self.illuminant_text.startswith("none"):
                raise _no_illuminant(illuminant)
            if illuminant != self.illuminant:
                raise _other_condition("illuminant", illuminant, self.illuminant)

    def _integrate(self, observer: int | None, illuminant: str | None) -> None:
        """Replace the colours by the tristimulus values of the spectra."""
        spectra = self.samples.spectra
        assert spectra is not None  # noqa: S101 (only called for data with spectra)
        alone = self.samples.lab is None and self.samples.xyz is None
        degrees, why = 2, "usual"
        if observer is not None:
            degrees, why = observer, "asked for"
        elif alone and self.declared_observer:
            degrees, why = int(self.declared_observer), "stated"
        self.observer, self.observer_text = str(degrees), f"{degrees}°"
        self.colours_from = f"SPECTRUM, ASTM E308, observer {degrees}° ({why})"
        if self.display and spectra.kind != "reflectance":
            if illuminant is not None:
                raise _no_illuminant(illuminant)
            xyz = emission_xyz(spectra.wavelengths, spectra.values, degrees)
            self.illuminant, self.illuminant_text = "D50", "none: self-luminous"
            self.reference = ICC_D50
        else:
            light, why = "D50", "usual"
            if illuminant is not None:
                light, why = illuminant, "asked for"
            elif alone and self.declared_illuminant in ILLUMINANTS:
                light, why = self.declared_illuminant, "stated"
            self.illuminant = self.illuminant_text = light
            xyz, scale = reflectance_xyz(spectra.wavelengths, spectra.values, light, degrees)
            self.colours_from += (
                f", illuminant {light} ({why}), reflectances on the scale 0-{scale:g}"
            )
            self.reference = self._reference_white()
        self.samples = replace(self.samples, lab=None, xyz=xyz, illumination=None)

    def _bare_lab(self) -> tuple[FloatArray, str]:
        """Bare colours unchanged: without device values their medium is unknown."""
        samples = self.samples
        if self.intent != "relative":
            raise OptionError.not_applicable(
                "intent",
                self.intent,
                "colours without device values or a declared white are used unchanged",
                "Give relative, or leave it out.",
            )
        self.intent = "none: the colours as given"
        self.warnings.append(
            "The data has no device values and states no white. Its colours are used as they are; "
            "they are not made relative to the white of the medium."
        )
        as_given = "none: colours without device values are taken as they are"
        if samples.lab is not None:
            return samples.lab, as_given
        xyz = self._tristimulus_values()
        if np.array_equal(self.reference, ICC_D50):
            return xyz_to_lab(xyz), as_given
        lab = xyz_to_lab(adaptation_to_d50(xyz, self.reference, self.adaptation))
        return lab, adaptation_text(self.adaptation, self.illuminant)

    def _tristimulus_values(self) -> FloatArray:
        samples = self.samples
        if samples.lab is not None:
            xyz = lab_to_xyz(samples.lab, self.reference)
            if samples.xyz is not None and not self.display:
                self._compare(samples.lab, samples.xyz)
            return xyz
        assert samples.xyz is not None  # noqa: S101 (samples have one of the two)
        return samples.xyz if self.display else samples.xyz / self._scale(samples.xyz)

    def _scale(self, xyz: FloatArray) -> float:
        # paper has Y near 0.8 or 80, and fluorescence may reach twice the full scale
        white = self.samples.white
        if self.samples.illumination is not None:
            return float(self.samples.illumination[1])
        highest = float(xyz[:, 1].max()) if white is None else float(white[1])
        if highest <= 2.0:
            return 1.0
        if highest <= 200.0:
            return 100.0
        self.warnings.append(
            f"The largest Y is {number_text(highest)}, which is no reflectance; it is "
            "taken as the white's."
        )
        return highest

    def _compare(self, lab: FloatArray, xyz: FloatArray) -> None:
        other = xyz_to_lab(xyz / self._scale(xyz), self.reference)
        difference = float(np.linalg.norm(other - lab, axis=1).mean())
        if difference > _CONSISTENT:
            self.warnings.append(
                f"The Lab and XYZ columns differ by {difference:.1f} ΔE*ab on average; Lab is used."
            )

    def _white(self, xyz: FloatArray) -> FloatArray | None:
        """The white in the scale of `xyz`: declared, measured, or by the device model."""
        samples = self.samples
        if samples.white is not None:
            if samples.lab is not None or not self.display:
                return samples.white / self._scale(samples.white[np.newaxis])
            return samples.white
        assert samples.device is not None  # noqa: S101 (bare colours without a white are handled before)
        target = np.full(len(samples.channels), 1.0 if samples.additive else 0.0)
        patches = np.all(np.abs(samples.device - target) < 1e-6, axis=1)
        if patches.any():
            mean: FloatArray = xyz[patches].mean(axis=0)
            return mean
        return self._unmeasured_white(samples.device, xyz, target)

    def _unmeasured_white(
        self, device: FloatArray, xyz: FloatArray, target: FloatArray
    ) -> FloatArray | None:
        """The white by the device model, else the sample nearest to it; None if neither is one."""
        source = "all channels at full scale" if self.samples.additive else "no ink"
        highest = float(xyz[:, 1].max())
        away = np.abs(device - target).max(axis=1)
        scaled = xyz_to_lab(xyz / (highest or 1.0))
        # a grid that ends before white would be interpolated, and answers with its last level
        model = device_model(*_mean_colours(device, scaled), "fit")
        error = model.mean_error
        if model.function is not None and error is not None and error < _USELESS_FIT:
            lab = model.function.fitted(target[np.newaxis])[0]
            white = lab_to_xyz(lab) * highest
            most = _MOST_EXTRAPOLATED * highest if self.display else _LIGHTEST_PAPER
            if (white > 0).all() and _LEAST * highest <= white[1] <= most:
                self.warnings.append(
                    f"The white was not measured; the device model's colour of {source} is taken "
                    f"as the white: {_list_of(white)}. It misses left-out samples by {error:.2g} "
                    f"ΔE*ab on average; the nearest sample is {100 * away.min():.2g} % of a "
                    "channel away."
                )
                inside = (device.min(axis=0) <= target) & (target <= device.max(axis=0))
                self.extrapolated = target if inside.all() else None
                return white
        nearest = int(np.argmin(away))
        # colours of two channels are flat, and refused for that
        is_solid = np.count_nonzero(np.ptp(device, axis=0) > _APART) >= 3
        if is_solid and away[nearest] > _NEAR_WHITE:
            return None
        self.warnings.append(
            f"The white was not measured; the sample nearest to {source} is taken as the white: "
            f"{_list_of(xyz[nearest])}."
        )
        return np.asarray(xyz[nearest])

    def _display_lab(self, xyz: FloatArray, white: FloatArray) -> tuple[FloatArray, str]:
        if self.intent == "relative":
            lab = xyz_to_lab(adaptation_to_d50(xyz, white, self.adaptation))
            adaptation = adaptation_text(self.adaptation, "the white")
            return lab, f"{adaptation}, luminance relative to the white"
        if self.samples.lab is not None and np.array_equal(self.reference, ICC_D50):
            return self.samples.lab, "none"
        self.as_measured = True
        return xyz_to_lab(xyz / white[1]), "none; luminance relative to the white"

    def _relative_print(self, xyz: FloatArray, white: FloatArray) -> tuple[FloatArray, str]:
        scaled = "ICC media-relative: XYZ scaled by D50/white"
        if not np.array_equal(self.reference, ICC_D50):
            scaled = f"{adaptation_text(self.adaptation, self.illuminant)}; {scaled}"
            xyz = adaptation_to_d50(xyz, self.reference, self.adaptation)
            white = adaptation_to_d50(white[np.newaxis], self.reference, self.adaptation)[0]
        return xyz_to_lab(xyz * (ICC_D50 / white)), scaled

    def _absolute_print(self, xyz: FloatArray) -> tuple[FloatArray, str]:
        if not np.array_equal(self.reference, ICC_D50):
            xyz = adaptation_to_d50(xyz, self.reference, self.adaptation)
            return xyz_to_lab(xyz), adaptation_text(self.adaptation, self.illuminant)
        return xyz_to_lab(xyz) if self.samples.lab is None else self.samples.lab, "none"

    def _illuminant(self) -> tuple[str, str]:
        conditions = self.samples.conditions
        for keywords, pattern in (
            (_ILLUMINANT_KEYWORDS, _NAMED_ILLUMINANT),
            (_TELLING_KEYWORDS, _DAYLIGHT),
        ):
            for keyword in keywords:
                match = pattern.search(conditions.get(keyword, "").upper())
                if match:
                    return match[1], match[1]
        if any(keyword in conditions for keyword in _ILLUMINANT_KEYWORDS):
            self.warnings.append("The declared illuminant is unknown; D50 is assumed.")
        elif self.display and self.samples.lab is None:
            return "D50", "none: self-luminous"
        return "D50", "D50 (assumed, not stated)"

    def _observer(self) -> tuple[str, str]:
        conditions = self.samples.conditions
        # IDMS files declare the year and the angle separately: join all keywords
        declared = " ".join(conditions.get(keyword, "").strip() for keyword in _OBSERVER_KEYWORDS)
        if declared := declared.strip():
            degrees = declared_observer(declared)
            if degrees is not None:
                return degrees, f"{degrees}°"
            self.foreign_observer = declared
            return "2", "2° (assumed, the one that is stated is not known)"
        for keyword in _TELLING_KEYWORDS:
            match = _OBSERVER.search(conditions.get(keyword, "").upper())
            if match:
                return (degrees := match[1] or match[2]), f"{degrees}°"
        return "2", "2° (assumed, not stated)"

    def _reference_white(self) -> FloatArray:
        illumination = self.samples.illumination
        if illumination is not None and self.samples.lab is None and not self.display:
            self.illuminant = "the stated illumination"
            self.illuminant_text = (
                f"as stated: perfect diffuser {', '.join(f'{v:g}' for v in illumination)}"
            )
            relative: FloatArray = illumination / illumination[1]
            return relative
        white = white_of(self.illuminant, self.observer)
        if white is None:
            self.warnings.append(f"The illuminant {self.illuminant} is unknown; D50 is assumed.")
            self.illuminant, self.illuminant_text = "D50", "D50 (assumed)"
            return ICC_D50
        return white


def _other_condition(name: str, value: object, theirs: str) -> OptionError:
    why = f"the data has no spectra, and its colours are for {theirs}"
    return OptionError.not_applicable(name, value, why)


def _no_illuminant(value: str) -> OptionError:
    return OptionError.not_applicable("illuminant", value, "the samples are lights")


def _stated_display(samples: Samples) -> bool | None:
    """Return whether the data states that it is a display's, or other than a display's."""
    stated = samples.conditions.get("DEVICE_CLASS", "").strip().upper()
    if stated:
        return stated in {"DISPLAY", "EMISSION", "MNTR", "MONITOR", "PROJECTOR"}
    kind = samples.conditions.get("CGV_DISPLAY_TYPE", "").strip().upper()  # IDMS 1.3
    if kind in {"EMISSIVE", "REFLECTIVE"}:
        # the Lab of an envelope is relative to D50 in either case
        return kind == "EMISSIVE"
    if samples.spectra is not None and samples.spectra.kind != "unknown":
        return samples.spectra.kind == "emission"
    if is_reflective_condition(samples.condition):
        return False
    # in Argyll's files, iRGB are the device values of RGB printers
    return False if samples.conditions.get("COLOR_REP", "").startswith("iRGB") else None


def _list_of(values: FloatArray) -> list[JSON]:
    return [round(float(value), 6) for value in values]


ILLUMINANTS = ("A", "C", "D50", "D55", "D65", "D75", "E", *(f"FL{n}" for n in range(1, 13)))
"""CIE illuminants of reflectance spectra (CIE 15:2018)."""

OBSERVERS = (2, 10)
"""Fields of view of the CIE 1931 and CIE 1964 standard observers, in degrees."""

_SHORTEST, _LONGEST = 360.0, 780.0
"""Range of the tables of ASTM E308 in nm; wavelengths beyond it have no weight."""

_TABLE_STEPS = (5.0, 10.0, 20.0)

LUMINOUS_EFFICACY = 683.0
"""Lumens per watt at the peak of V(λ) (CIE 15:2018, 7.1)."""


def reflectance_xyz(
    wavelengths: FloatArray, reflectances: FloatArray, illuminant: str, observer: int
) -> tuple[FloatArray, float]:
    """Return XYZ (n, 3) of reflecting or transmitting samples, and their scale, 1 or 100.

    `wavelengths` (b,) are ascending band centres in nm. The perfect diffuser has exactly the white
    `white_of` the illuminant, with Y = 1 (ASTM E308-18, section 7; ISO 13655:2017, 5).
    """
    scale = reflectance_scale(reflectances)
    weights = tristimulus_weights(tuple(map(float, wavelengths)), illuminant, observer)
    white = white_of(illuminant, str(observer))
    assert white is not None  # noqa: S101 (the tables know every illuminant of ours)
    xyz: FloatArray = (reflectances / scale) @ weights * (white / weights.sum(axis=0))
    return xyz, scale


def emission_xyz(wavelengths: FloatArray, radiances: FloatArray, observer: int) -> FloatArray:
    """Return the tristimulus values (n, 3) of lights with spectral radiances (n, b).

    Y is in cd/m² for radiances in W/(m² sr nm). `wavelengths` (b,) are ascending band centres in
    nm. The weights are those of illuminant E without its normalisation (CIE 15:2018, 7.1).
    """
    matching = _matching_functions(observer)[1]
    weights = tristimulus_weights(tuple(map(float, wavelengths)), "E", observer)
    xyz: FloatArray = radiances @ weights * (LUMINOUS_EFFICACY * matching[:, 1].sum())
    return xyz


@lru_cache(maxsize=64)
def tristimulus_weights(
    wavelengths: tuple[float, ...], illuminant: str, observer: int
) -> FloatArray:
    """Return the contributions (b, 3) of the bands of a spectrum to X, Y and Z, read-only.

    The sum for Y is 1. Bands of 5, 10 and 20 nm get the weights of ASTM E308 and E2022; others are
    interpolated to 1 nm. Unmeasured wavelengths count for the first and last band (7.2 and 7.3).
    """
    bands = np.array(wavelengths)
    used = (bands >= _SHORTEST) & (bands <= _LONGEST)
    weights = np.zeros((len(bands), 3))
    steps = np.unique(np.diff(bands[used]))
    in_tables = len(steps) == 1 and steps[0] in _TABLE_STEPS and not (bands[used] % steps[0]).any()
    make = _table_weights if in_tables else _interpolated_weights
    weights[used] = make(bands[used], illuminant, observer)
    weights.setflags(write=False)
    return weights


def _table_weights(bands: FloatArray, illuminant: str, observer: int) -> FloatArray:
    """Weights of the standard's own steps, by colour-science from an identity matrix."""
    colour = colour_science()
    identity = colour.MultiSpectralDistributions(np.eye(len(bands)), bands)
    with warnings.catch_warnings():
        # colour-science warns of each step of the standard
        warnings.simplefilter("ignore")
        xyz = colour.msds_to_XYZ(
            identity,
            colour.MSDS_CMFS[_observer_name(observer)],
            colour.SDS_ILLUMINANTS[illuminant],
            method="ASTM E308",
        )
    return np.asarray(xyz, dtype=np.float64) / 100.0


def _interpolated_weights(bands: FloatArray, illuminant: str, observer: int) -> FloatArray:
    """Weights by way of 1 nm: a cubic spline between the bands, constant beyond the ends."""
    fine, _ = _matching_functions(observer)
    weighted = illuminated_functions(illuminant, observer)
    inside = np.clip(fine, bands[0], bands[-1])
    from scipy.interpolate import CubicSpline  # noqa: PLC0415  # 0.3 s, for uneven bands only

    splines: FloatArray = CubicSpline(bands, np.eye(len(bands)), axis=0)(inside)
    weights: FloatArray = splines.T @ weighted / weighted[:, 1].sum()
    return weights


def illuminated_functions(illuminant: str, observer: int) -> FloatArray:
    """Return the colour-matching functions (n, 3) from 360 to 780 nm by 1 nm, times the light.

    Illuminants are interpolated linearly between their tables' 5 nm.
    """
    wavelengths, matching = _matching_functions(observer)
    power = colour_science().SDS_ILLUMINANTS[illuminant]
    light = np.interp(wavelengths, power.wavelengths, power.values)
    weighted: FloatArray = matching * light[:, np.newaxis]
    return weighted


@lru_cache(maxsize=4)
def _matching_functions(observer: int) -> tuple[FloatArray, FloatArray]:
    """Wavelengths from 360 to 780 nm and the colour-matching functions there."""
    functions = colour_science().MSDS_CMFS[_observer_name(observer)]
    wavelengths = np.asarray(functions.wavelengths, dtype=np.float64)
    used = (wavelengths >= _SHORTEST) & (wavelengths <= _LONGEST)
    return wavelengths[used], np.asarray(functions.values, dtype=np.float64)[used]


def _observer_name(observer: int) -> str:
    year = {2: 1931, 10: 1964}[observer]
    return f"CIE {year} {observer} Degree Standard Observer"


_PART = re.compile(r"[0-9]+(?:\.[0-9]+)?|[A-Z]+")
_DEGREES = {"TWO": "2", "TEN": "10", "1931": "2", "1964": "10"}
_FOREIGN = frozenset(
    {
        *("1951", "SCOTOPIC"),
        *("1955", "1959", "STILES", "BURCH"),
        *("1978", "JUDD", "VOS"),
        *("2006", "2012", "2015", "170"),
        *("SHAW", "FAIRCHILD"),
    }
)
"""Years and names of other observers, which share an angle with those of CIE 15: Argyll has 1955_2,
1955_10, 1978_2, 2012_2, 2012_10 and shaw."""


def declared_observer(text: str) -> str | None:
    """Return the standard observer, ``"2"`` or ``"10"``, that a text names; None for any other.

    Argyll and DisplayCAL write ``1931_2``, others ``2 degree``, ``CIE 1964``, ``TEN`` or ``D50/2``.
    """
    parts = _PART.findall(text.upper())
    if not _FOREIGN.isdisjoint(parts):
        return None
    observers = {_DEGREES[part] for part in parts if part in _DEGREES}
    angles = (float(part) for part in parts if part[0].isdigit())
    observers |= {f"{angle:.0f}" for angle in angles if angle in (2.0, 10.0)}
    return observers.pop() if len(observers) == 1 else None


def sample_surface(
    samples: Samples,
    medium: MeasuredColours,
    surface_samples: int,
    limits: InkLimits,
    kind: str | None,
) -> SurfaceColours:
    """Return the colours at the surface of a device by a model `kind` of its samples.

    Samples without device values, or without a model, are the colours themselves.
    """
    provenance: dict[str, JSON] = {**samples.provenance, **medium.provenance}
    warnings = [*samples.warnings, *medium.warnings]
    if samples.device is None:
        provenance["patches"] = _patches(samples, len(medium.lab))
        provenance["model"] = {"name": "none: the colours themselves"}
        warnings += impossible_colour_warnings(medium.lab, lights=medium.lights)
        provenance["warnings"] = list[JSON](warnings)
        return SurfaceColours(medium.lab, None, provenance)

    device, lab = _mean_colours(samples.device, medium.lab)
    averaged = len(samples.device) - len(device)
    if averaged and (repeats := _repeat_noise(samples, medium.lab, device, lab)):
        provenance["repeats"] = repeats
    if medium.white_sample is not None:
        device = np.concatenate([device, medium.white_sample[0]])
        lab = np.concatenate([lab, medium.white_sample[1]])
    distinct = len(device)
    model = device_model(device, lab, kind)
    device, lab = model.device, model.lab
    if len(device) < distinct:
        warnings.append(f"The device model uses {len(device)} of {distinct} distinct samples.")
    provenance["patches"] = _patches(
        samples, len(device), averaged=averaged, thinned=distinct - len(device)
    )
    lowest, highest = device.min(axis=0), device.max(axis=0)
    limited = limited_cube(samples.channels, lowest, highest, limits, inks=samples.inks)
    provenance["model"] = model.provenance
    if model.function is None:
        why = f"no device model can be fitted ({model.degenerate})"
        if limits.given:
            raise limits.refusal(f"{why}.")
        if kind is not None:
            raise OptionError.not_applicable("device_model", kind, why, _FIT_REMEDY)
        warnings.append(f"{why[:1].upper()}{why[1:]}; the samples' colours are used.")
        warnings += impossible_colour_warnings(lab, lights=medium.lights)
        provenance["warnings"] = list[JSON](warnings)
        return SurfaceColours(lab, device, provenance, channels=samples.channels)

    warnings += model.warnings
    warnings += range_warnings(samples, device, limited)
    if model.mean_error is not None and model.mean_error > _POOR_FIT:
        warnings.append(f"Left-out samples have a mean error of {model.mean_error:.1f} ΔE*ab.")
    function = model.function
    surface = surface_values(limited, function.fitted, surface_samples, model.nodes)
    density, points = surface.density, function.fitted(surface.device)
    dark = points[:, 0] < 0
    if dark.any():
        warnings.append(f"{int(dark.sum())} colours below L* 0 were raised to 0.")
        points[dark, 0] = 0.0
    corners = limited.device(surface_corners(limited.cube))
    warnings += extrapolation_warnings(corners, device, points, lab)
    warnings += impossible_colour_warnings(points, lights=medium.lights)
    warnings += count_warnings(len(points), surface_samples, density)
    provenance["surface"] = {"points": len(points), "density": density}
    provenance.update(limited.provenance)
    provenance["warnings"] = list[JSON](warnings)
    residual = np.linalg.norm(function.fitted(samples.device) - medium.lab, axis=1)
    provenance["model"] = {
        **model.provenance,
        "residual": {
            "unit": "ΔE*ab",
            "mean": round(float(residual.mean()), 4),
            "largest": round(float(residual.max()), 4),
        },
    }
    printable = device[limited.contains(device)]
    measured = medium.lab[limited.contains(samples.device)]
    return SurfaceColours(
        points,
        surface.device,
        provenance,
        channels=samples.channels,
        faces=surface.faces,
        device_colours=device_colours(
            DeviceModel(samples.channels, samples.inks, limited, function),
            surface,
            printable,
            measured,
        ),
    )


def _patches(samples: Samples, used: int, *, averaged: int = 0, thinned: int = 0) -> JSON:
    """Numbers of patches that were read, dropped (in reading or here), averaged and used."""
    read, dropped = len(samples), 0
    counts = samples.provenance.get("patches")
    if isinstance(counts, dict):
        count, lost = counts.get("read"), counts.get("dropped")
        read = count if isinstance(count, int) else read
        dropped = lost if isinstance(lost, int) else 0
    return {"read": read, "averaged": averaged, "dropped": dropped + thinned, "used": used}


def _mean_colours(device: FloatArray, lab: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Distinct device values with the mean of their colours."""
    order = np.lexsort(device.T[::-1])
    ranked = device[order]
    first = np.ones(len(ranked), dtype=bool)
    first[1:] = (ranked[1:] != ranked[:-1]).any(axis=1)
    starts = np.flatnonzero(first)
    counts = np.diff(np.append(starts, len(ranked)))
    sums = np.add.reduceat(lab[order], starts, axis=0)
    return ranked[starts], sums / counts[:, np.newaxis]


def _repeat_noise(
    samples: Samples, readings: FloatArray, device: FloatArray, lab: FloatArray
) -> dict[str, JSON]:
    """Return the noise of readings by repeated patches; nothing if the repeats are all equal.

    `device` and `lab` are the distinct device values, sorted, and their mean colours.
    """
    assert samples.device is not None  # noqa: S101 (only called with device values)
    _, patch = np.unique(samples.device, axis=0, return_inverse=True)
    order = np.lexsort(device.T[::-1])
    means = lab[order][patch.reshape(-1)]
    freedom = len(readings) - len(device)
    noise = float(np.sqrt(((readings - means) ** 2).sum() / freedom))
    if noise < _SAME_READING:
        return {}
    target = 1.0 if samples.additive else 0.0
    white = int((np.abs(samples.device - target).max(axis=1) < _APART).sum())
    counts = np.bincount(patch.reshape(-1))
    return {
        "unit": "ΔE*ab",
        "noise": round(noise, 4),
        "readings": int(counts[counts > 1].sum()),
        "device_values": int((counts > 1).sum()),
        "white": white,
    }
