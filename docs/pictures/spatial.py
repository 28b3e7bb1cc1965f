"""Draw docs/pictures/spatial.png, and print the table of docs/decisions/spatial-mapping.md.

Run by ``make spatial``, which takes some seconds. Needs the extra ``docs``. The pictures are made
here, from a fixed seed. They have saturated textures and shades, the hard case of clipping.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.colors import hsv_to_rgb
from matplotlib.figure import Figure
from matplotlib.image import imread, imsave
from scipy.ndimage import gaussian_filter, sobel

import gamutcore as gc
from gamutcore.arrays import FloatArray
from gamutcore.colours.spaces import ColourConversion, ColourSpace
from gamutcore.search import delta_e_2000

FOLDER = Path(__file__).parent
PRESS = FOLDER.parents[1] / "examples" / "FOGRA39L.ti3"

SIZE = 192
"""Rows and columns of a picture."""

SEED = 34

SHOWN = ("weave", "flowers", "text")

LAB = ColourConversion("sRGB", ColourSpace())
"""Between sRGB and CIELAB relative to D50."""


def made_pictures() -> dict[str, FloatArray]:
    """Return eight pictures in sRGB, (rows, columns, 3) from 0 to 1."""
    random = np.random.default_rng(SEED)
    y, x = np.mgrid[:SIZE, :SIZE] / SIZE

    def noise(sigma: float) -> FloatArray:
        field = gaussian_filter(random.normal(size=x.shape), sigma, mode="wrap")
        scaled: FloatArray = (field - field.min()) / (field.max() - field.min())
        return scaled

    def hsv(hue: object, saturation: object, value: object) -> FloatArray:
        planes = np.broadcast_arrays(hue, saturation, value, x)[:3]
        rgb: FloatArray = hsv_to_rgb(np.clip(np.stack(planes, axis=-1), 0, 1))
        return rgb

    flowers = hsv(0.32, 0.6, 0.25 + 0.3 * noise(3))
    for hue in (0.0, 0.08, 0.14, 0.8, 0.93, 0.7, 0.0, 0.08, 0.14, 0.8, 0.93, 0.7):
        (left, top, size), shape = random.random(3), x.shape
        radius = np.hypot(x - left, y - top) / (0.07 + 0.1 * size)
        angle = np.arctan2(y - top, x - left)
        petal = radius < 0.75 + 0.25 * np.cos(6 * angle)
        veins = 1 - 0.35 * radius + 0.12 * np.cos(40 * angle)
        full = 1 - 0.35 * np.exp(-4 * radius)
        flowers[petal] = hsv(np.full(shape, hue), full, veins)[petal]
    text = hsv(np.floor(6 * x) / 6, 1, 1)
    glyphs = np.kron(random.random((24, 24)) < 0.45, np.ones((SIZE // 24, SIZE // 24))) > 0
    text[glyphs] *= 0.85
    waves = 0.2 + 0.8 * (0.5 + 0.5 * np.sin(40 * x + 12 * noise(6)))
    light = np.exp(-((x - 0.5) ** 2 / 0.05 + (y - 0.9) ** 2 / 0.3))
    flicker = 0.5 * noise(3) + 0.5 * noise(9)
    thread = np.sin(2 * np.pi * 24 * x) * np.sin(2 * np.pi * 24 * y)
    return {
        "weave": hsv(0.62 + 0.04 * noise(20), 0.8 + 0.2 * thread, 0.75 + 0.25 * noise(12)),
        "gradients": hsv(x, 0.3 + 0.7 * y, 0.95),
        "flowers": flowers,
        "text": text,
        "water": hsv(0.5 + 0.08 * noise(12), 0.6 + 0.4 * waves, 0.6 + 0.4 * noise(4)),
        "flame": hsv(0.14 * flicker, 1.1 - 0.4 * light * flicker, 1.2 * light * (0.5 + flicker)),
        "foliage": hsv(0.27 + 0.1 * noise(8), 0.75 + 0.25 * noise(5), 0.3 + 0.7 * noise(2)),
        "mottle": hsv(2 * noise(16) % 1, 0.6 + 0.4 * noise(2), 0.6 + 0.4 * noise(3)),
    }


def lab_of(rgb: FloatArray) -> FloatArray:
    """Return CIELAB of sRGB."""
    return LAB.to_gamut(rgb.reshape(-1, 3)).reshape(rgb.shape)


def similarity(one: FloatArray, two: FloatArray) -> float:
    """Return the mean SSIM (Wang et al. 2004) of gradients of lightness, a Sobel filter's."""
    a, b = (np.hypot(sobel(each[..., 0], 0), sobel(each[..., 0], 1)) / 8 for each in (one, two))

    def smooth(values: FloatArray) -> FloatArray:
        return np.asarray(gaussian_filter(values, 1.5))

    mean_a, mean_b = smooth(a), smooth(b)
    variances = smooth(a * a) - mean_a**2 + smooth(b * b) - mean_b**2
    covariance = smooth(a * b) - mean_a * mean_b
    # the constants of the paper for a range of 20: differences of L* between neighbours
    first, second = (0.01 * 20) ** 2, (0.03 * 20) ** 2
    means = (2 * mean_a * mean_b + first) / (mean_a**2 + mean_b**2 + first)
    return float((means * (2 * covariance + second) / (variances + second)).mean())


def main() -> None:
    """Map the pictures by three methods."""
    press, screen = (
        gc.Gamut(PRESS, surface_samples=20_000, space="CAM16-UCS"),
        gc.reference("sRGB", surface_samples=20_000, space="CAM16-UCS"),
    )
    methods = {"clip-hue": {}, "sgck": {"source": screen}, "spatial": {}}
    figure = Figure(figsize=(7.2, 5.6), facecolor="white", layout="constrained")
    panels = figure.subplots(len(SHOWN), 1 + len(methods))
    with tempfile.TemporaryDirectory() as folder:
        given, output = Path(folder) / "given.png", Path(folder) / "mapped.png"
        for name, rgb in made_pictures().items():
            imsave(given, rgb)
            before, results = lab_of(imread(given)[..., :3].astype(np.float64)), [rgb]
            figures: list[tuple[float, float]] = []
            for method, options in methods.items():
                done = press.map_picture(given, output, method, **options)
                results.append(imread(output)[..., :3].astype(np.float64))
                after = lab_of(results[-1])
                change = delta_e_2000(before.reshape(-1, 3), after.reshape(-1, 3)).mean()
                figures.append((similarity(before, after), float(change)))
            cells = [f"{score:.3f} / {change:.1f}" for score, change in figures]
            share = f"{done.outside / done.pixels:.0%}"
            sys.stdout.write(f"| {' | '.join([name, share, *cells])} |\n")
            if name in SHOWN:
                line = panels[SHOWN.index(name)]
                for axes, picture in zip(line, results, strict=True):
                    axes.imshow(picture[: SIZE // 2, : SIZE // 2], interpolation="nearest")
    for axes, title in zip(panels[0], ["picture", *methods], strict=True):
        axes.set_title(title)
    for axes in panels.flat:
        axes.set_axis_off()
    figure.savefig(FOLDER / "spatial.png", dpi=100, metadata={"Software": None})


if __name__ == "__main__":
    main()
