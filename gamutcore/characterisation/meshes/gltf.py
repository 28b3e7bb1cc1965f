"""glTF 2.0 (Khronos Group; ISO/IEC 12113): binary (GLB) or JSON with its buffers embedded.

Buffers are the GLB chunk or ``data:`` URIs; nothing outside the file is read. Triangles, strips and
fans of all meshes of the scene are joined, with the transforms of their nodes. This package's
exports have L*, a*, b* as positions, and a rotation for display in the node. That rotation is never
applied. Attributes ``_DEVICE_C`` are device values, with full names in ``extras.device_channels``
of the mesh.
"""

from __future__ import annotations

import base64
import binascii
import json
import re
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from gamutcore.characterisation.meshes.mesh import (
    MAX_VERTICES,
    TOO_MANY_DEVICE_VALUES,
    by_channel,
    gamut_mesh,
    reads_device_values,
    refuse_too_many,
)
from gamutcore.errors import MalformedFileError, SampleLimitError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from gamutcore.arrays import FloatArray, LongArray
    from gamutcore.characterisation.meshes.mesh import GamutMesh

__all__ = ["gltf_mesh", "looks_like_glb", "looks_like_gltf"]

MAX_OBJECTS = 50_000
"""Maximum number of brackets in the JSON. A scene with one gamut has some tens."""

MAX_COMMAS = 500_000
MAX_NODES = 1_000
"""Maximum number of nodes with a mesh."""

LIGHTNESS_UPWARDS = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
"""Rotation for display in this package's exports, from (L*, a*, b*) to (a*, L*, -b*)."""

_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_FLOAT = 5126
_DEVICE = "_DEVICE_"
_READ_EXTENSIONS = {"KHR_materials_unlit", "KHR_mesh_quantization"}
_DATA_URI = re.compile(r"data:[^,]{0,200};base64,")
_ASSET = re.compile(r'"asset"\s*:\s*\{')


def looks_like_glb(data: bytes) -> bool:
    """Return whether bytes have the signature of binary glTF."""
    return data.startswith(b"glTF")


def looks_like_gltf(text: str) -> bool:
    """Return whether a JSON text has an object ``asset``, meshes and accessors, as glTF does."""
    return (
        text.lstrip().startswith("{")
        and '"meshes"' in text
        and '"accessors"' in text
        and _ASSET.search(text) is not None
    )


def gltf_mesh(data: bytes) -> GamutMesh:
    """Return the mesh in binary glTF, or in JSON in UTF-8: the triangles of the whole scene.

    Transforms of nodes are applied, with a warning, unless this package wrote the file or the
    transform is only the rotation for display. Where an error is in the JSON, ``where["field"]`` is
    its path.
    """
    name, text, chunk = ("glb", *_chunks(data)) if looks_like_glb(data) else ("gltf", data, None)
    scene = _Scene(_decoded(text), chunk)
    vertices, faces, device, warnings = scene.triangles()
    return gamut_mesh(name, vertices, faces, stated=scene.stated, device=device, warnings=warnings)


def _chunks(data: bytes) -> tuple[bytes, bytes | None]:
    """Return the JSON and the binary chunk (glTF 2.0, 4.4)."""
    if len(data) < 20 or int.from_bytes(data[4:8], "little") != 2:
        raise MalformedFileError(
            "The file is not binary glTF of version 2.",
            where={"byte": 4},
            remedy="Send glTF 2.0, whole.",
        )
    place = 12
    parts: list[bytes] = []
    while place + 8 <= len(data) and len(parts) < 2:
        size = int.from_bytes(data[place : place + 4], "little")
        kind, content = data[place + 4 : place + 8], data[place + 8 : place + 8 + size]
        if len(content) < size or (not parts and kind != b"JSON"):
            raise MalformedFileError(
                f"A chunk of {size} bytes is not within the file's {len(data)} bytes, or not JSON.",
                where={"byte": place},
                remedy="Send the whole file.",
            )
        if parts and kind != b"BIN\0":
            break
        parts.append(content)
        place += 8 + size
    if not parts:
        raise MalformedFileError(
            "The file has no JSON chunk.", where={"byte": 12}, remedy="Send the whole file."
        )
    return parts[0], parts[1] if len(parts) > 1 else None


def _decoded(text: bytes) -> dict[str, Any]:
    if (
        text.count(b"[") + text.count(b"{") > MAX_OBJECTS or text.count(b",") > MAX_COMMAS
    ):  # decoding would make an object of each
        raise SampleLimitError(
            f"The glTF has more than {MAX_OBJECTS} objects.",
            remedy="Send one mesh, with its numbers in a buffer.",
        )
    try:
        document = json.loads(text.decode("utf-8-sig"), parse_constant=_refuse_constant)
    except json.JSONDecodeError as error:
        raise MalformedFileError(
            f"The JSON is malformed: {error.msg}.",
            where={"line": error.lineno, "column": error.colno},
            remedy="Send glTF 2.0.",
        ) from None
    except (ValueError, RecursionError):
        raise MalformedFileError(
            "The JSON is not UTF-8, nested too deeply, or has a number with too many digits.",
            remedy="Send glTF 2.0.",
        ) from None
    if not isinstance(document, dict):
        raise _wrong("", "is not an object")
    return document


def _refuse_constant(name: str) -> NoReturn:
    raise MalformedFileError(f"{name} is not a number in JSON.", remedy="Send glTF 2.0.")


def _wrong(path: str, problem: str, remedy: str = "") -> MalformedFileError:
    return MalformedFileError(
        f"The glTF's {path or 'JSON'} {problem}.",
        where={"field": path[:80]},
        remedy=remedy or "Send glTF 2.0 as its specification has it.",
    )


def _whole(value: object, path: str, most: int = 2**32) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= most:
        raise _wrong(path, "is not a whole number in the accepted range")
    return value


def _numbers(value: object, count: int, path: str) -> FloatArray:
    if (
        not isinstance(value, list)
        or len(value) != count
        or any(isinstance(number, bool) or not isinstance(number, int | float) for number in value)
    ):
        raise _wrong(path, f"is not {count} numbers")
    try:
        numbers = np.array([float(number) for number in value])
    except OverflowError:
        numbers = np.full(count, np.inf)
    if not (np.abs(numbers) < 1e9).all():
        raise _wrong(path, "has numbers out of range")
    return numbers


class _Scene:
    """Meshes of the scene of a document."""

    def __init__(self, document: dict[str, Any], chunk: bytes | None) -> None:
        self.document, self.chunk = document, chunk
        asset = document.get("asset")
        if not isinstance(asset, dict) or not str(asset.get("version", "")).startswith("2"):
            raise _wrong("asset.version", "is not 2.0")
        required = document.get("extensionsRequired", [])
        for extension in required if isinstance(required, list) else [required]:
            if not isinstance(extension, str) or extension not in _READ_EXTENSIONS:
                raise _wrong(
                    "extensionsRequired",
                    f"has {str(extension)[:60]!r}, which is not supported",
                    "Send the mesh uncompressed, without extensions.",
                )
        self.own = str(asset.get("generator", "")).startswith("gamutcore ")
        extras = asset.get("extras")
        extras = extras if isinstance(extras, dict) else {}
        self.stated = {str(k): v for k, v in extras.items() if isinstance(v, str)}
        self._buffers: dict[int, bytes] = {}
        self.unread = False

    def triangles(self) -> tuple[FloatArray, LongArray, dict[str, FloatArray], list[str]]:
        """Return vertices, faces, device values of the vertices, and warnings."""
        vertices, faces, count, triangles = [], [], 0, 0
        recipes: list[dict[str, FloatArray]] = []
        turned, moved = False, False
        for number, transform in self._placed_meshes():
            turn = np.abs(transform[:3, :3] - LIGHTNESS_UPWARDS).max() < 1e-5
            display = self.own or (turn and not transform[:3, 3].any())
            turned |= bool(display and not self.own)
            moved |= not display and not np.array_equal(transform, np.eye(4))
            for positions, corners, device in self._primitives(number):
                refuse_too_many(count + len(positions), triangles + len(corners))
                if not display:
                    with np.errstate(over="ignore", invalid="ignore"):
                        positions = positions @ transform[:3, :3].T + transform[:3, 3]  # noqa: PLW2901
                beyond = (corners < 0) | (corners >= len(positions))
                if beyond.any():
                    raise _wrong(f"meshes[{number}]", "has an index of a missing vertex")
                vertices.append(positions)
                faces.append(corners + count)
                recipes.append(device)
                count, triangles = count + len(positions), triangles + len(corners)
        warnings = []
        if moved:
            warnings.append(
                "The transforms of the glTF's nodes were applied; the results are used as L*, a*, "
                "b*."
            )
        if turned:
            warnings.append(
                "The glTF's node has a rotation for display, with lightness upwards; the positions "
                "before the rotation are used as L*, a*, b*."
            )
        if not faces:
            raise _wrong("meshes", "have no triangles")
        if self.unread:
            warnings.append(TOO_MANY_DEVICE_VALUES)
        channels = list(recipes[0])
        if any(list(device) != channels for device in recipes):
            channels = []
            warnings.append(
                "The glTF's meshes have different device channels; device values are not used."
            )
        values = {name: np.concatenate([device[name] for device in recipes]) for name in channels}
        return np.concatenate(vertices), np.concatenate(faces), values, warnings

    def _items(self, name: str) -> list[Any]:
        items = self.document.get(name, [])
        if not isinstance(items, list):
            raise _wrong(name, "is not an array")
        return items

    def _item(self, name: str, number: object, path: str) -> dict[str, Any]:
        items = self._items(name)
        index = _whole(number, path)
        if index >= len(items) or not isinstance(items[index], dict):
            raise _wrong(path, f"refers to {name}[{index}], which is missing")
        item: dict[str, Any] = items[index]
        return item

    def _placed_meshes(self) -> list[tuple[int, FloatArray]]:
        """Return the meshes of the scene with the transforms of their nodes."""
        nodes = self._items("nodes")
        scenes = self._items("scenes")
        if not nodes:
            return [
                (number, np.eye(4)) for number in range(min(len(self._items("meshes")), MAX_NODES))
            ]
        roots: object
        if scenes:
            roots = self._item("scenes", self.document.get("scene", 0), "scene").get("nodes", [])
        else:
            roots = self._roots(nodes)
        if not isinstance(roots, list):
            raise _wrong("scenes", "have nodes that are not an array")
        waiting = [(number, np.eye(4)) for number in reversed(roots)]
        found: list[tuple[int, FloatArray]] = []
        seen: set[int] = set()
        while waiting:
            number, outer = waiting.pop()
            path = f"nodes[{number}]"
            node = self._item("nodes", number, path)
            if number in seen:
                raise _wrong(path, "is reached twice; nodes must form trees")
            seen.add(number)
            with np.errstate(over="ignore", invalid="ignore"):
                transform = outer @ _local(node, path)
            if "mesh" in node:
                found.append((_whole(node["mesh"], f"{path}.mesh"), transform))
                if len(found) > MAX_NODES:
                    raise SampleLimitError(
                        f"The glTF has more than {MAX_NODES} meshes.", remedy="Send one mesh."
                    )
            children = node.get("children", [])
            if not isinstance(children, list):
                raise _wrong(f"{path}.children", "is not an array")
            waiting += [(child, transform) for child in reversed(children)]
        return found

    @staticmethod
    def _roots(nodes: list[Any]) -> list[int]:
        inner: set[object] = set()
        for node in nodes:
            children = node.get("children", []) if isinstance(node, dict) else []
            inner |= {child for child in children if isinstance(child, int)}
        return [number for number in range(len(nodes)) if number not in inner]

    def _primitives(
        self, number: int
    ) -> Iterator[tuple[FloatArray, LongArray, dict[str, FloatArray]]]:
        """Yield primitives one by one, so that the caller can limit their sum."""
        mesh = self._item("meshes", number, f"meshes[{number}]")
        primitives = mesh.get("primitives", [])
        if not isinstance(primitives, list):
            raise _wrong(f"meshes[{number}].primitives", "is not an array")
        for index, primitive in enumerate(primitives):
            path = f"meshes[{number}].primitives[{index}]"
            if not isinstance(primitive, dict) or not isinstance(primitive.get("attributes"), dict):
                raise _wrong(path, "has no attributes")
            mode = primitive.get("mode", _TRIANGLES)
            if mode not in (_TRIANGLES, _STRIP, _FAN):  # a list is not hashable
                continue  # points and lines
            positions = self._accessor(
                primitive["attributes"].get("POSITION"), "VEC3", f"{path}.attributes.POSITION"
            )
            if primitive.get("indices") is None:
                indices = np.arange(len(positions))
            else:
                values = self._accessor(primitive["indices"], "SCALAR", f"{path}.indices")
                indices = values.ravel().astype(np.int64)
            corners = _corners(indices, mode, path)
            yield positions, corners, self._device(primitive, mesh, len(positions), path)

    def _device(
        self, primitive: dict[str, Any], mesh: dict[str, Any], count: int, path: str
    ) -> dict[str, FloatArray]:
        """Return the device values of a primitive's vertices by the names of their channels."""
        attributes = primitive["attributes"]
        names = [name for name in attributes if name.startswith(_DEVICE)]
        if not reads_device_values(count, len(names)):
            self.unread = True
            return {}
        extras = mesh.get("extras")
        full = extras.get("device_channels") if isinstance(extras, dict) else None
        found: list[tuple[str, FloatArray]] = []
        for name in names:
            where = f"{path}.attributes.{name}"
            accessor = self._item("accessors", attributes[name], where)
            if accessor.get("type") != "SCALAR" or accessor.get("componentType") != _FLOAT:
                continue  # an attribute of other software
            values = self._accessor(attributes[name], "SCALAR", where, of_floats=True).ravel()
            if len(values) != count:
                raise _wrong(where, f"has {len(values)} values for {count} vertices")
            given = full.get(name) if isinstance(full, dict) else None
            channel = given if isinstance(given, str) else name.removeprefix(_DEVICE)
            found.append((channel, values))
        return by_channel(found)

    def _accessor(
        self, number: object, kind: str, path: str, *, of_floats: bool = False
    ) -> FloatArray:
        accessor = self._item("accessors", number, path)
        path = f"accessors[{number}]"
        component = accessor.get("componentType")
        if accessor.get("type") != kind or component not in tuple(_COMPONENTS):
            raise _wrong(path, f"does not have the type {kind}")
        if "sparse" in accessor:
            raise _wrong(path, "is sparse, which is not supported", "Send plain accessors.")
        count = _whole(accessor.get("count"), f"{path}.count", MAX_VERTICES)
        dtype, width = np.dtype(_COMPONENTS[int(component)]), _WIDTHS[kind]
        if kind == "SCALAR" and dtype.kind != "u" and not of_floats:
            raise _wrong(path, "has indices that are not unsigned integers")
        view = self._item("bufferViews", accessor.get("bufferView"), f"{path}.bufferView")
        content = self._buffer(view.get("buffer"), f"bufferViews of {path}")
        start = _whole(view.get("byteOffset", 0), f"{path}.byteOffset")
        length = _whole(view.get("byteLength"), f"{path}.byteLength")
        offset = start + _whole(accessor.get("byteOffset", 0), f"{path}.byteOffset")
        packed = dtype.itemsize * width
        stride = _whole(view.get("byteStride", packed), f"{path}.byteStride", 65535)
        end = offset + (count - 1) * stride + packed if count else offset
        if stride < packed or end > min(start + length, len(content)):
            raise _wrong(
                path,
                f"needs {end} bytes of a buffer that has {len(content)}",
                "Send the whole file, with accessors inside their buffer views.",
            )
        if not count:
            return np.empty((0, width))
        strides = (stride, dtype.itemsize)
        values = np.ndarray((count, width), dtype, content, offset, strides)
        with np.errstate(invalid="ignore"):  # a signalling NaN becomes a quiet one
            numbers = values.astype(np.float64)
        if accessor.get("normalized") is True and dtype.kind in "iu" and kind == "VEC3":
            numbers = np.maximum(numbers / np.iinfo(dtype).max, -1.0)
        return numbers

    def _buffer(self, number: object, path: str) -> bytes:
        buffer = self._item("buffers", number, path)
        index = _whole(number, path)
        if index in self._buffers:
            return self._buffers[index]
        uri = buffer.get("uri")
        if uri is None:
            if index or self.chunk is None:
                raise _wrong(f"buffers[{index}]", "has no content")
            content = self.chunk
        else:
            head = _DATA_URI.match(uri) if isinstance(uri, str) else None
            if head is None:
                raise _wrong(
                    f"buffers[{index}].uri",
                    "is not embedded; nothing outside the file is read",
                    "Send a .glb, or glTF with its buffers embedded as data: URIs in base64.",
                )
            try:
                content = base64.b64decode(uri[head.end() :], validate=True)
            except (binascii.Error, ValueError):
                raise _wrong(f"buffers[{index}].uri", "is not base64") from None
        self._buffers[index] = content
        return content


def _corners(indices: LongArray, mode: int, path: str) -> LongArray:
    """Return the triangles of a list, strip or fan of vertices (glTF 2.0, 3.7.2.1)."""
    if mode == _TRIANGLES:
        if len(indices) % 3:
            raise _wrong(path, f"has {len(indices)} corners, which is not a multiple of 3")
        return indices.reshape(-1, 3)
    count = max(len(indices) - 2, 0)
    place = np.arange(count)
    if mode == _FAN:
        places = np.stack([place + 1, place + 2, np.zeros(count, np.int64)], axis=1)
    else:
        places = np.stack([place, place + 1 + place % 2, place + 2 - place % 2], axis=1)
    return np.asarray(indices[places], np.int64).reshape(-1, 3)


def _local(node: dict[str, Any], path: str) -> FloatArray:
    """Return a node's own transform (glTF 2.0, 3.5.3)."""
    if "matrix" in node:
        return _numbers(node["matrix"], 16, f"{path}.matrix").reshape(4, 4).T
    x, y, z, w = _numbers(node.get("rotation", [0, 0, 0, 1]), 4, f"{path}.rotation")
    norm = x * x + y * y + z * z + w * w
    if norm <= 0:
        raise _wrong(f"{path}.rotation", "is not a rotation")
    s = 2.0 / norm
    transform = np.eye(4)
    transform[:3, :3] = [
        [1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)],
        [s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)],
        [s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)],
    ]
    transform[:3, :3] *= _numbers(node.get("scale", [1, 1, 1]), 3, f"{path}.scale")
    transform[:3, 3] = _numbers(node.get("translation", [0, 0, 0]), 3, f"{path}.translation")
    return transform
