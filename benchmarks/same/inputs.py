"""The files that both revisions read: valid ones of every format, and damaged ones.

The working tree makes them once, so that both revisions read the same bytes.
"""

from __future__ import annotations

import io
import itertools
import json
import shutil
import struct
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

import gamutcore

__all__ = ["write_inputs"]

Array = np.ndarray[Any, np.dtype[np.float64]]

XYZ_OF_RGB = np.array([(0.436, 0.385, 0.143), (0.222, 0.717, 0.061), (0.014, 0.097, 0.714)])
"""sRGB's primaries under D50, rounded: any device will do."""

WHITE = XYZ_OF_RGB.sum(axis=1)

PARTS = np.array([5, 55, 85, 80, 8, 45, 95, 85, 10, 5, 5, 5, 95, 40, 5, 10, 65, 30, 35, 15, 60])
INKS = PARTS.reshape(7, 3) / 100
"""Transmittances for red, green and blue light of C, M, Y, K, orange, green and violet."""

SPACES = "CIELAB CIELUV CIEXYZ CAM16-UCS CAM02-UCS DIN99o Oklab IPT ICtCp ITP Jzazbz"

SMALL: dict[str, object] = {"surface_samples": 4000}

WRONG_OPTIONS: list[dict[str, object]] = [
    {name: value}
    for name, values in {
        "space": ("CIELABB", 3, None),
        "boundary": ("alpha", ["usv"]),
        "gamma": (0, 2, -1, "big", True, float("nan")),
        "segments": ([1, 2], [16], "16", [16, 999]),
        "basis": ("cube", "icosahedron"),
        "subdivisions": (8, 1.5, 2),
        "centre": ([0, 0], [500, 0, 0], "middle"),
        "cost": ("length", 1),
        "surface_samples": (7, 1e9, "many"),
        "intent": ("absolut", "perceptual"),
        "source": ("transforms", "boundary"),
        "device_model": ("spline", "interpolation"),
        "ink_limit": (0, 2000, "300"),
        "black_limit": (-1, 101),
        "observer": (3, 10),
        "illuminant": ("D65", "L"),
        "condition": ("M9", ""),
        "reference_white": ("D51", [1, 2], [1, 0, 0]),
        "adaptation": ("CAT97",),
        "luminance": (100, "measured"),
        "adapting_luminance": (4,),
        "background": (20,),
        "surround": ("dim", "bright"),
        "popularity": (0.1, 1),
        "inklimit": (300,),
    }.items()
    for value in values
]


def write_inputs(folder: Path, root: Path, data: Path | None) -> None:
    """Write ``files``, ``damaged`` and ``cases.json``, which names a file and options per case.

    Parameters
    ----------
    folder : Path
        An empty folder.
    root : Path
        The repository with ``examples`` and ``tests/data``.
    data : Path or None
        A folder whose files, and those of its folders, are read as well.
    """
    files, damaged = folder / "files", folder / "damaged"
    files.mkdir()
    damaged.mkdir()
    for source in ("examples", "tests/data"):
        for path in (root / source).iterdir():
            if path.suffix in {".ti3", ".icc", ".csv", ".cxf"}:
                shutil.copy(path, files)
    for name, content in {**_tables(), **_profiles(), **_pictures(), **_meshes()}.items():
        (files / name).write_bytes(content)
    cases = _cases()
    for path in sorted(data.rglob("*")) if data else []:
        if path.is_file() and path.suffix != ".md":
            name = "-".join(path.relative_to(data or path).parts)
            shutil.copy(path, files / name)
            cases[f"data {name}"] = (name, {**SMALL})
    for name in [*sorted(_tables() | _profiles() | _pictures() | _meshes()), "colorport-24.cxf"]:
        for number, content in enumerate(_damaged((files / name).read_bytes())):
            (damaged / f"{number}-{name}").write_bytes(content)
    (folder / "cases.json").write_text(json.dumps(cases))
    (folder / "wrong.json").write_text(json.dumps(WRONG_OPTIONS))


def _cases() -> dict[str, tuple[str, dict[str, object]]]:
    """Return the file and the options of every gamut that is built."""
    cases: dict[str, tuple[str, dict[str, object]]] = {"press": ("FOGRA39L.ti3", {})}
    made = [*_tables(), *_profiles(), *_pictures(), *_meshes()]
    further = ["FOGRA29L.ti3", "Panasonic-TV.icc", "colorport-24.cxf", "spots.csv"]
    further += ["DisplayP3-v4.icc", "sGrey-v4.icc", "sRGB-v2-magic.icc", "sRGB-v4.icc"]
    special: dict[str, dict[str, object]] = {
        "conditions.csv": {"condition": "M1"},
        "spectra.csv": {"illuminant": "A", "observer": 10},
        "boundary.icc": {"source": "boundary"},
        "luminous.txt": {"space": "ITP", "luminance": "measured"},
        "rgb16.tif": {"popularity": 0.05},
    }
    for name in made + further:
        is_mesh = name.startswith(("mesh", "boundary"))
        options = {**({} if is_mesh or "reference" in name else SMALL), **special.get(name, {})}
        if Path(name).suffix in {".png", ".jpg", ".tif", ".npy"}:
            options.pop("surface_samples")
        if name in {"lab.json", "spots.csv", "lch.csv", "colorport-24.cxf"}:
            options.pop("surface_samples")
        cases[name] = (name, options)
    press, display = "FOGRA39L.ti3", "sRGB-v4.icc"
    choices: list[tuple[str, dict[str, Any]]] = [
        *((press, {"space": space}) for space in SPACES.split()),
        *((display, {"space": space, "cost": "finest"}) for space in ("CIELUV", "ICtCp")),
        *((name, {"cost": c}) for name in (press, "7inks.txt") for c in ("finest", "quadric")),
        *((press, {"boundary": b}) for b in ("segment-maxima", "usv")),
        (press, {"gamma": 1}),
        *((n, {"boundary": "device-surface"}) for n in (press, display, "5inks.csv", "rgb.csv")),
        (press, {"boundary": "segment-maxima", "segments": [9, 20], "cost": "quadric"}),
        (press, {"boundary": "usv", "basis": "octahedron", "subdivisions": 3, "gamma": 0.1}),
        (press, {"gamma": 0.3, "centre": [45, 0, 5]}),
        (press, {"intent": "absolute", "ink_limit": 300, "black_limit": 90}),
        ("cmyk.icc", {"ink_limit": 250, "intent": "absolute"}),
        ("rgb.csv", {"device_model": "fit"}),
        *((display, {"intent": i}) for i in ("absolute", "perceptual", "saturation")),
        (press, {"space": "CAM16-UCS", "surround": "dim", "background": 30}),
        (press, {"space": "Oklab", "adaptation": "CAT16", "reference_white": "D50"}),
    ]
    for name, options in choices:
        cases[f"{name} {json.dumps(options)}"] = (name, {**SMALL, **options})
    return cases


def _lab(xyz: Array) -> Array:
    ratio = np.maximum(xyz / WHITE, 1e-4)
    f = np.where(ratio > 0.008856, np.cbrt(ratio), 7.787 * ratio + 16 / 116)
    x, y, z = f[:, 0], f[:, 1], f[:, 2]
    return np.column_stack([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def _device(count: int, *, grid: int = 0) -> tuple[Array, Array]:
    """Device values from 0 to 1 and X, Y, Z of some inks, or of a display if `grid` is given."""
    if grid:
        device = np.array(list(itertools.product(np.linspace(0, 1, grid), repeat=3)))
        return device, (0.002 + 0.998 * device**2.2) @ XYZ_OF_RGB.T
    corners = np.array(list(itertools.product((0.0, 1.0), repeat=count)))
    device = np.vstack([corners, np.random.default_rng(count).random((300, count)).round(2)])
    light = np.prod(1 - device[:, :, None] * (1 - INKS[None, :count]), axis=1)
    return device, light @ XYZ_OF_RGB.T


def _rows(columns: str, rows: Array, separator: str = ",") -> str:
    lines = [separator.join(f"{value:.4f}" for value in row) for row in rows]
    return "\n".join([separator.join(columns.split()), *lines]) + "\n"


def _cgats(columns: str, rows: Array, head: str = "") -> bytes:
    body = _rows(columns, rows, " ").split("\n", 1)[1]
    return (
        f"CGATS.17\n{head}NUMBER_OF_FIELDS {len(columns.split())}\nBEGIN_DATA_FORMAT\n{columns}\n"
        f"END_DATA_FORMAT\nNUMBER_OF_SETS {len(rows)}\nBEGIN_DATA\n{body}END_DATA\n"
    ).encode()


def _npy(array: np.ndarray[Any, Any]) -> bytes:
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


def _tables() -> dict[str, bytes]:
    rgb, xyz = _device(3, grid=5)
    lab = _lab(xyz)
    cmy, printed = _device(3)
    cmyk, pressed = _device(4)
    xyy = np.column_stack([xyz[:, :2] / xyz.sum(axis=1)[:, None], 100 * xyz[:, 1]])
    hue = np.degrees(np.arctan2(lab[:, 2], lab[:, 1])) % 360
    lch = np.column_stack([lab[:, 0], np.hypot(lab[:, 1], lab[:, 2]), hue])
    bands = np.arange(400, 701, 10)
    shares = np.exp(-(((bands - np.array([[620], [540], [450]])) / 60.0) ** 2))
    light = np.prod(1 - cmy[:, :, None] * (1 - INKS[None, :3]), axis=1)
    spectra = np.column_stack([100 * cmy, 0.9 * light @ (shares / shares.sum(axis=0))])
    press = np.column_stack([100 * cmyk, _lab(pressed)])
    other = press[:, 4:] + (0, 1, -3)
    columns = "LAB_L LAB_A LAB_B"
    inks = {n: f"{' '.join(f'{n}CLR_{i + 1}' for i in range(n))} {columns}" for n in (5, 6, 7)}
    many = {n: np.column_stack([100 * _device(n)[0], _lab(_device(n)[1])]) for n in (5, 6, 7)}
    display = np.column_stack([255 * rgb, 250 * xyz])
    structured = np.zeros(len(rgb), [(name, "f8") for name in "RGBXYZ"])
    for name, column in zip("RGBXYZ", np.column_stack([rgb, 100 * xyz]).T, strict=True):
        structured[name] = column
    document = {
        "columns": ["RGB_R", "RGB_G", "RGB_B", "XYZ_X", "XYZ_Y", "XYZ_Z"],
        "samples": np.column_stack([255 * rgb, 100 * xyz]).round(4).tolist(),
        "conditions": {"DEVICE_CLASS": "DISPLAY"},
    }
    return {
        "rgb.csv": _rows(f"R G B {columns}", np.column_stack([255 * rgb, lab])).encode(),
        "cmy.tsv": _rows(f"C M Y {columns}", np.column_stack([cmy, _lab(printed)]), "\t").encode(),
        "cmyk.txt": _cgats(f"CMYK_C CMYK_M CMYK_Y CMYK_K {columns}", press),
        "5inks.csv": _rows(inks[5], many[5]).encode(),
        "6inks.txt": _cgats(inks[6], many[6]),
        "7inks.txt": _cgats(inks[7], many[7], 'MEASUREMENT_CONDITION "M1"\n'),
        "xyy.csv": _rows("RGB_R RGB_G RGB_B x y Y", np.column_stack([255 * rgb, xyy])).encode(),
        "lch.csv": _rows("L* C* h", lch).encode(),
        "xyz.csv": _rows("C M Y XYZ_X XYZ_Y XYZ_Z", np.column_stack([cmy, 100 * printed])).encode(),
        "decimal.csv": _rows(f"R G B {columns}", np.column_stack([255 * rgb, lab]), ";")
        .replace(".", ",")
        .encode(),
        "spectra.csv": _rows(f"C M Y {' '.join(f'SPEC_{n}' for n in bands)}", spectra).encode(),
        "conditions.csv": _rows(
            "CMYK_C CMYK_M CMYK_Y CMYK_K M0_LAB_L M0_LAB_A M0_LAB_B M1_LAB_L M1_LAB_A M1_LAB_B",
            np.column_stack([press, other]),
        ).encode(),
        "luminous.txt": _cgats(
            "RGB_R RGB_G RGB_B XYZ_X XYZ_Y XYZ_Z",
            display,
            'DEVICE_CLASS "DISPLAY"\nLUMINANCE_XYZ_CDM2 "241.0 250.0 206.3"\n',
        ),
        "samples.json": json.dumps(document).encode(),
        "lab.json": json.dumps(_lab(printed).round(4).tolist()).encode(),
        "lab.npy": _npy(_lab(pressed).astype(np.float32)),
        "columns.npy": _npy(structured),
        **{
            f"reference-{name}.json": json.dumps({"reference": name}).encode()
            for name in ("srgb", "pointer", "optimal-colours-d50-2", "bt2020")
        },
    }


def _profiles() -> dict[str, bytes]:
    return {
        "cmyk.icc": _lut_profile(4, b"prtr", b"CMYK", 2),
        "input.icc": _lut_profile(3, b"scnr", b"RGB ", 2),
        "space.icc": _lut_profile(3, b"spac", b"RGB ", 4),
        "six.icc": _lut_profile(6, b"prtr", b"6CLR", 4),
    }


def _lut_profile(channels: int, kind: bytes, space: bytes, version: int) -> bytes:
    """Return a profile with a lut8Type as A2B0 (ICC.1:2022, 10.11)."""
    steps = 3 if channels > 4 else 5
    device = np.array(list(itertools.product(np.linspace(0, 1, steps), repeat=channels)))
    if space == b"RGB ":
        xyz = device**1.8 @ XYZ_OF_RGB.T
    else:
        xyz = np.prod(1 - device[:, :, None] * (1 - INKS[None, :channels]), axis=1) @ XYZ_OF_RGB.T
    codes = np.clip(_lab(xyz) * (2.55, 1, 1) + (0, 128, 128), 0, 255).astype(np.uint8)
    identity = struct.pack(">9i", *(65536 * n for n in (1, 0, 0, 0, 1, 0, 0, 0, 1)))
    table = bytes(range(256))
    lut = b"mft1\0\0\0\0" + bytes((channels, 3, steps, 0)) + identity
    lut += table * channels + codes.tobytes() + table * 3
    text = b"Made up"
    name = b"desc\0\0\0\0" + struct.pack(">I", len(text) + 1) + text + bytes(80)
    if version == 4:
        name = b"mluc\0\0\0\0" + struct.pack(">II2s2sII", 1, 12, b"en", b"GB", 14, 28)
        name += text.decode().encode("utf-16-be")
    white = b"XYZ \0\0\0\0" + struct.pack(">3i", 63190, 65536, 54061)
    copyright_ = name if version == 4 else b"text\0\0\0\0None\0"
    tags = {b"desc": name, b"cprt": copyright_, b"wtpt": white, b"A2B0": lut}
    position, entries, content = 132 + 12 * len(tags), b"", b""
    for tag, value in tags.items():
        padded = value + bytes(-len(value) % 4)
        entries += struct.pack(">4sII", tag, position + len(content), len(value))
        content += padded
    size = position + len(content)
    head = struct.pack(">I4sI4s4s4s", size, b"none", version << 24, kind, space, b"Lab ")
    head += struct.pack(">6H4s4s", 2026, 1, 1, 0, 0, 0, b"acsp", b"APPL") + bytes(24)
    head += struct.pack(">3i", 63190, 65536, 54061) + bytes(48)
    return head + struct.pack(">I", len(tags)) + entries + content


def _pictures() -> dict[str, bytes]:
    y, x = np.mgrid[0:1:96j, 0:1:128j]
    wave = 0.5 + 0.5 * np.sin(9 * x * y)
    rgb = (255 * np.stack([x, y, wave], axis=-1)).astype(np.uint8)
    alpha = np.where(x > 0.1, 255, 0).astype(np.uint8)

    def saved(mode: str, pixels: np.ndarray[Any, Any], kind: str, **how: Any) -> bytes:  # noqa: ANN401
        file = io.BytesIO()
        picture = Image.fromarray(pixels)
        picture.convert(mode).save(file, kind, **how)
        return file.getvalue()

    return {
        "rgb.png": saved("RGB", rgb, "PNG"),
        "rgba.png": saved("RGBA", np.dstack([rgb, alpha]), "PNG"),
        "palette.png": saved("P", rgb, "PNG"),
        "rgb.jpg": saved("RGB", rgb, "JPEG", quality=90),
        "cmyk.jpg": saved("CMYK", rgb, "JPEG", icc_profile=_profiles()["cmyk.icc"]),
        "rgb16.tif": saved("RGB", rgb, "TIFF", compression="tiff_lzw"),
    }


def _meshes() -> dict[str, bytes]:
    srgb = gamutcore.reference("srgb", surface_samples=2000)
    press = gamutcore.Gamut(_tables()["cmyk.txt"], surface_samples=2000)
    meshes = {"mesh-device.ply": press.mesh(400).to_bytes("ply")}
    for name in ("ply", "glb", "gltf", "obj", "stl", "gam"):
        meshes[f"mesh.{name}"] = srgb.mesh(500).to_bytes(name)
    meshes["boundary.icc"] = srgb.mesh(500).to_bytes("icc")
    return meshes


def _damaged(content: bytes) -> Iterable[bytes]:
    """Yield damaged versions of a file."""
    third, size = len(content) // 3, len(content)
    noise = np.random.default_rng(size).integers(0, size, 40)
    flipped = bytearray(content)
    for place in noise.tolist():
        flipped[place] ^= 1 << place % 8
    damages: tuple[Callable[[], bytes], ...] = (
        lambda: content[:third],
        lambda: content[: size - 7],
        lambda: bytes(flipped),
        lambda: content[:third] + bytes(64) + content[third + 64 :],
        lambda: content[:third] + content[2 * third :],
        lambda: content[:200].replace(b"1", b"x").replace(b"L", b"Q") + content[200:],
        lambda: content[: 2 * third] + b"\nnan,inf,-1e999 \xff\n" + content[2 * third :],
    )
    for damage in damages:
        yield damage()
