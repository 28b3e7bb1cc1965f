"""The layers of OpenEXR files, and the choice of the one that is the picture.

A channel ``ViewLayer.Combined.R`` belongs to the layer ``ViewLayer.Combined`` (OpenEXR, technical
introduction, "Layers"). Files of several parts have a layer for each part. Renderers add layers
that are parts of the light, such as ambient occlusion, or no colours at all, such as normals.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from gamutcore.characterisation.pictures.encoding import text_attribute
from gamutcore.errors import OptionError, UnsupportedPictureError

__all__ = ["Layer", "chosen_layer", "exr_layers", "layer_warning"]

MOST_PARTS = 1024

_UNNAMED = "(unnamed)"
"""Name of the channels without a layer, in messages and in the option."""

_WHOLE = (
    *("composite", "combined", "beauty", "rgba", "rgb", "final", "color", "colour", "default"),
    *("main", "master", "left"),
)
"""Last words of names of whole pictures, the best first: Blender, Arnold, V-Ray, Nuke. The left
view is the usual default of stereo pictures."""

_DATA = re.compile(
    r"crypto.*|normals?|n|ng|p|position|pos|pworld|pref|depth.*|z|uv|st|vector|velocity|"
    r"motion.*|mv|ao|ambient.?occlusion|occlusion|shadows?|masks?|mattes?.*|id|.*index.*|mist|"
    r"denoising.*|debug.*|object.*|material.*"
)
"""Last words of names of layers that are no picture, even with channels R, G, B or X, Y, Z."""

_GRAY = ("Y", "Y'", "L", "I")
_WORST = 1000


@dataclass(frozen=True)
class Layer:
    """The channels of a layer in one part of a file.

    `model` is empty for layers without colours. `channels` are the indices of the colours, and
    `alpha` is that of the alpha, -1 without one. `unused` is the number of its other channels.
    """

    name: str
    part: int
    model: str
    channels: tuple[int, ...]
    alpha: int
    unused: int
    channel_names: tuple[str, ...]

    @property
    def title(self) -> str:
        """The name in messages."""
        return self.name[:60] or _UNNAMED

    @property
    def words(self) -> tuple[str, ...]:
        """The parts of the name in lower case."""
        return tuple(self.name.lower().split("."))

    @property
    def is_data(self) -> bool:
        """Whether the name is that of data, not of a picture."""
        return bool(self.name) and _DATA.fullmatch(self.words[-1]) is not None

    @property
    def rank(self) -> int:
        """0 for channels without a layer, then whole pictures, then others, and data last."""
        if not self.name:
            return 0
        if self.words[-1] in _WHOLE:
            whole = [word for word in self.words if word in _WHOLE]
            return 1 + min(map(_WHOLE.index, whole))
        return _WORST if self.is_data else len(_WHOLE) + 1


def exr_layers(source: Any) -> list[Layer]:  # noqa: ANN401 (an ImageInput)
    """Return the layers of all parts of an opened file, in the order of the file."""
    layers: list[Layer] = []
    parts = 1
    while parts < MOST_PARTS and source.seek_subimage(parts, 0):
        parts += 1
    for part in range(parts):
        source.seek_subimage(part, 0)
        spec = source.spec()
        if spec.deep:
            continue
        title = text_attribute(spec, "oiio:subimagename") if parts > 1 else ""
        groups: dict[str, list[int]] = {}
        for index, channel in enumerate(spec.channelnames):
            groups.setdefault(channel.rpartition(".")[0] or title, []).append(index)
        layers += [_layer(name, part, spec, indices) for name, indices in groups.items()]
    source.seek_subimage(0, 0)
    return layers


def _layer(name: str, part: int, spec: Any, indices: Sequence[int]) -> Layer:  # noqa: ANN401
    shown = tuple(spec.channelnames[index] for index in indices)
    places = {
        channel.rpartition(".")[2].upper(): index
        for channel, index in zip(shown, indices, strict=True)
    }
    alpha = places.pop("A", -1)
    model, channels = "", tuple[int, ...]()
    gray = next((places[word] for word in _GRAY if word in places), None)
    if set("RGB") <= set(places):
        model, channels = "RGB", tuple(places[word] for word in "RGB")
    elif set("XYZ") <= set(places):
        model, channels = "XYZ", tuple(places[word] for word in "XYZ")
    elif gray is not None and not {"RY", "BY", "CB"} & set(places):
        model, channels = "gray", (gray,)
    elif len(places) == 1 and "Z" not in places:
        model, channels = "gray", (next(iter(places.values())),)
    unused = len(indices) - len(channels) - (alpha >= 0)
    return Layer(name, part, model, channels, alpha, unused, shown)


def chosen_layer(layers: Sequence[Layer], name: str | None) -> Layer:
    """Return the named layer, or the one that is the whole picture.

    Without a name it is the channels without a layer, or a layer with the usual name of a whole
    picture, or the only one with colours. Other choices are refused: a part of the light would be
    taken for the picture.
    """
    layer = _whole_picture(layers) if name is None else _named(layers, name)
    if layer is None or not layer.model:
        shown = ", ".join((layer or layers[0]).channel_names[:8])
        title = "picture" if name is None else f"layer {name[:60]}"
        raise UnsupportedPictureError(
            f"The {title} has the channels {shown[:100]}.",
            where={"field": "channels"},
            remedy="Send R, G, B, or X, Y, Z, or one channel of gray. A layer is named by the "
            f"option layer (--layer): {_names(layers)}.",
        )
    return layer


def _named(layers: Sequence[Layer], name: str) -> Layer:
    wanted = "" if name == _UNNAMED else name.lower()
    matches = [layer for layer in layers if layer.name.lower() == wanted]
    matches = [layer for layer in matches if layer.name == name] or matches
    if not matches and wanted:
        matches = [layer for layer in layers if layer.name.lower().endswith(f".{wanted}")]
    if len({layer.name for layer in matches}) == 1:
        return next((layer for layer in matches if layer.model), matches[0])
    message = "Several layers have" if matches else "The picture has no layer of"
    raise OptionError(
        f"{message} the name {name[:60]!r}.",
        where={"field": "layer", "available": [layer.title for layer in layers]},
        remedy=f"Give one of {_names(layers)}.",
    )


def _whole_picture(layers: Sequence[Layer]) -> Layer | None:
    for model in ("RGB", "XYZ", "gray"):
        fitting = [layer for layer in layers if layer.model == model]
        if model != "RGB":  # a vector, or a mask
            fitting = [layer for layer in fitting if not layer.is_data]
        if not fitting:
            continue
        best = min(layer.rank for layer in fitting)
        ranked = [layer for layer in fitting if layer.rank == best]
        if len(ranked) > 1 and best > len(_WHOLE):
            raise UnsupportedPictureError(
                f"The picture has the layers {_names(layers)}, of which none is named as the "
                "whole picture.",
                where={"field": "layer"},
                remedy="Name one by the option layer (--layer).",
            )
        return ranked[0]
    return None


def layer_warning(layers: Sequence[Layer], layer: Layer) -> list[str]:
    """Return a warning with the names of all layers if there are several."""
    if len(layers) == 1:
        return []
    stated = f"The picture has the layers {_names(layers)}; {layer.title} is used."
    return [f"{stated} Name another by the option layer (--layer)."]


def _names(layers: Sequence[Layer]) -> str:
    return ", ".join(dict.fromkeys(layer.title for layer in layers))
