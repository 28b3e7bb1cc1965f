"""Texts of the CGATS family: presses, displays, spectra, several conditions, two tables."""

from pathlib import Path

import numpy as np

from gamutcore.characterisation import IccProfile, Samples, characterisation
from gamutcore.colours.measured_colours import measured_colours
from gamutcore.errors import GamutError

ROOT = Path(__file__).parents[3]


def _spectral() -> bytes:
    bands = [f"SPECTRAL_NM{nm}" for nm in range(380, 740, 10)]
    rows = [
        [str(i), *(str(100 * bit) for bit in divmod(i, 2)), *(f"{1 / (i + 2):.4f}" for _ in bands)]
        for i in range(4)
    ]
    names = " ".join(["SAMPLE_ID", "2CLR_1", "2CLR_2", *bands])
    lines = "\r\n".join(" ".join(row) for row in rows)
    return (
        f'CGATS.17\r\nMEASUREMENT_SOURCE "MeasurementCondition=M1 Filter=no"\r\n'
        f"BEGIN_DATA_FORMAT\r\n{names}\r\nEND_DATA_FORMAT\r\nNUMBER_OF_SETS 4\r\nBEGIN_DATA\r\n"
        f"{lines}\r\nEND_DATA\r\n"
    ).encode()


_PRESS = (ROOT / "examples" / "FOGRA39L.ti3").read_bytes()
_DISPLAY = b"""CGATS.17
IDMS_FILE_TYPE\tCGE_MEASUREMENT
IDMS_VERSION 1.3
CGV_DISPLAY_TYPE REFLECTIVE
ILLUMINATION_PERFECT_DIFFUSE_REFLECTOR_XYZ 102 100 63.7
BEGIN_DATA_FORMAT
SampleID RGB_R RGB_G RGB_B XYZ_X XYZ_Y XYZ_Z
END_DATA_FORMAT
NUMBER_OF_SETS 4
BEGIN_DATA
1 0 0 0 3,9 4,5 4,1
2 255 0 0 28.1 18.8 4.6
3 0 255 0 5.5 10.1 5.9
4 255 255 255 46.7 48.8 7.5
END_DATA
"""
SEEDS = [
    _PRESS[:4000] + b"\nEND_DATA\n",
    _DISPLAY,
    _DISPLAY.replace(b"XYZ_", b"M0_XYZ_") + b"CAL\n" + _DISPLAY,
    _spectral(),
]
TOKENS = [
    *b"BEGIN_DATA END_DATA BEGIN_DATA_FORMAT END_DATA_FORMAT NUMBER_OF_SETS LAB_L XYZ_X".split(),
    *b"CMYK_C RGB_R SPECTRAL_NM380 SPEC_400 M1_LAB_L M2 MEASUREMENT_CONDITION FILTER".split(),
    *b'DEVICE_CLASS DISPLAY OUTPUT ILLUMINANT D65 OBSERVER "10 degree" KEYWORD XYY_CAPY'.split(),
    *(b"\n", b"\r", b"\r\n", b"\t", b" ", b'"', b"#", b";"),
]


def check(data: bytes) -> None:
    """Raise unless the file is refused by name or gives finite colours."""
    try:
        read = characterisation(data)
    except GamutError:
        return
    if isinstance(read, IccProfile):
        return
    check_samples(read)


def check_samples(samples: Samples) -> None:
    """Raise unless samples are finite, and their colours are or are refused."""
    assert len(samples) > 0
    if samples.device is not None:
        assert len(samples.device) == len(samples)
        assert ((samples.device >= 0) & (samples.device <= 1)).all()
    for colours in (samples.lab, samples.xyz):
        assert colours is None or np.isfinite(colours).all()
    for intent in ("relative", "absolute"):
        try:
            medium = measured_colours(samples, intent)
        except GamutError:
            continue
        assert np.isfinite(medium.lab).all()
