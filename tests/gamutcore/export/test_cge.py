"""Colour gamut envelopes: read by a small independent reader, and compared with sRGB's formulas."""

import numpy as np
import pytest

from gamutcore.errors import OptionError

SRGB = np.array(  # linear sRGB to XYZ of D65, IEC 61966-2-1
    [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
)
BRADFORD = np.array(  # from D65 to D50, Lindbloom
    [
        [1.0478112, 0.0228866, -0.0501270],
        [0.0295424, 0.9904844, -0.0170491],
        [-0.0092345, 0.0150436, 0.7521316],
    ]
)
LEVELS = [0, 25, 51, 76, 102, 127, 153, 178, 204, 229, 255]
"""Levels of the measurement files of CIELab Gamut Tools."""


def read(data):
    """Return keywords and columns, as readers of IDMS files find them: line by line."""
    lines = [line.strip() for line in data.decode("ascii").split("\n")]
    assert int(lines[0].removeprefix("CGATS.")) >= 17
    fields = " ".join(lines[lines.index("BEGIN_DATA_FORMAT") + 1 : lines.index("END_DATA_FORMAT")])
    rows = lines[lines.index("BEGIN_DATA") + 1 : lines.index("END_DATA")]
    (sets,) = [int(line.split()[1]) for line in lines if line.startswith("NUMBER_OF_SETS")]
    assert sets == len(rows)
    table = np.array([[float(cell) for cell in row.split()] for row in rows])
    columns = dict(zip(fields.split(), table.T, strict=True))
    grouped = {
        name: np.stack([columns[f"{name}_{axis}"] for axis in axes], axis=1)
        for name, axes in (("RGB", "RGB"), ("XYZ", "XYZ"), ("LAB", "LAB"))
    }
    return lines, grouped


def lab_of_srgb(rgb):
    """CIELAB relative to D50 of 8-bit sRGB, by the formulas of the standards."""
    encoded = rgb / 255
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    xyz = linear @ SRGB.T @ BRADFORD.T
    ratio = xyz / (0.9642, 1, 0.8249)
    f = np.where(ratio > 216 / 24389, np.cbrt(ratio), (24389 / 27 * ratio + 16) / 116)
    return np.stack(
        [116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1
    )


def test_the_points_are_those_of_the_cube_with_the_colours_of_the_device(srgb_gamut):
    lines, columns = read(srgb_gamut.mesh(max_error=0).to_bytes("cge"))
    assert "IDMS_FILE_TYPE CGE_ENVELOPE" in lines
    rgb = columns["RGB"]
    assert len(rgb) == len(np.unique(rgb, axis=0)) == 602  # 6 m² − 12 m + 8 with m = 11
    assert np.unique(rgb).tolist() == LEVELS
    assert (((rgb == 0) | (rgb == 255)).any(axis=1)).all()
    error = np.linalg.norm(columns["LAB"] - lab_of_srgb(rgb), axis=1)
    assert error.mean() < 0.2
    assert error.max() < 3  # interpolated between 41 samples along an edge of the cube
    white = columns["XYZ"][(rgb == 255).all(axis=1)]
    np.testing.assert_allclose(white, [(96.42, 100, 82.49)], atol=0.05)
    # XYZ and LAB are the same colours: CIE 15:2018, 8.2.1
    luminance = columns["XYZ"][:, 1] / 100
    lightness = np.where(
        luminance > 216 / 24389, 116 * np.cbrt(luminance) - 16, luminance * 24389 / 27
    )
    np.testing.assert_allclose(lightness, columns["LAB"][:, 0], atol=1e-3)


def test_rebuilt_by_the_method_of_the_standard_the_volume_is_that_of_srgb(srgb_gamut):
    """Triangles between the points of the cube's faces; the figure is for sRGB by IDMS at D50."""
    _, columns = read(srgb_gamut.mesh(max_error=0).to_bytes("cge"))
    lab = {tuple(rgb): colour for rgb, colour in zip(columns["RGB"], columns["LAB"], strict=True)}
    total = 0.0
    for axis in range(3):
        for end, sign in ((0, -1), (255, 1)):
            face = np.array([[lab[_on_face(axis, end, u, v)] for v in LEVELS] for u in LEVELS]) - (
                50,
                0,
                0,
            )
            a, b, c, d = face[:-1, :-1], face[1:, :-1], face[1:, 1:], face[:-1, 1:]
            for one, two, three in ((a, b, c), (a, c, d)):
                total += sign * np.einsum("ijk,ijk->", one, np.cross(two, three)) / 6
    assert abs(total) == pytest.approx(830_732, rel=0.01)


def _on_face(axis, end, u, v):
    """Return a point of a face of the cube, with the other axes in cyclic order."""
    point = [0, 0, 0]
    point[axis], point[(axis + 1) % 3], point[(axis + 2) % 3] = end, u, v
    return tuple(point)


def test_other_channels_are_refused(press_gamut, small_gamut):
    with pytest.raises(OptionError, match="C M Y K"):
        press_gamut.mesh(100).to_bytes("cge")
    with pytest.raises(OptionError, match="no device values"):
        small_gamut.mesh(100).to_bytes("cge")
