"""Layers of OpenEXR: which one is the picture, and how another is named."""

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

from gamutcore.characterisation import read_characterisation
from gamutcore.characterisation.pictures import open_raster
from gamutcore.errors import OptionError, UnsupportedPictureError

FIELDS = np.array([[0.5, 0.25, 0.125], [1.0, 0.0, 0.5]], np.float32)
"""The colours of the layer that is to be read; other layers are black."""


@pytest.fixture
def exr(tmp_path):
    """Return a function that writes parts of named channels; those below `wanted` have FIELDS."""

    def write(*parts, wanted, alpha=None):
        specs, pixels = [], []
        for title, names in parts:
            spec = oiio.ImageSpec(2, 1, len(names), "float")
            spec.channelnames = names
            if len(parts) > 1:
                spec.attribute("oiio:subimagename", title)
            samples = np.zeros((1, 2, len(names)), np.float32)
            for place, name in enumerate(names):
                layer, _, last = name.rpartition(".")
                if (layer or (title if len(parts) > 1 else "")) != wanted:
                    continue
                if last.upper() in "RGB":
                    samples[0, :, place] = FIELDS[:, "RGB".index(last.upper())]
                elif last == "Y":
                    samples[0, :, place] = FIELDS[:, 0]
                elif last == "A":
                    samples[0, :, place] = alpha
            specs.append(spec)
            pixels.append(samples)
        path = tmp_path / "layers.exr"
        output = oiio.ImageOutput.create(str(path))
        if len(specs) > 1:
            assert output.open(str(path), specs)
        else:
            assert output.open(str(path), specs[0])
        for number, (spec, samples) in enumerate(zip(specs, pixels, strict=True)):
            if number:
                assert output.open(str(path), spec, "AppendSubimage")
            assert output.write_image(samples)
        assert output.close()
        return path.read_bytes()

    return write


def layer(name, channels="RGB"):
    return [f"{name}.{channel}" if name else channel for channel in channels]


def read(data, name=None):
    """Return the pixels and warnings of a layer: counting distinct colours would take longer."""
    with open_raster(data, "exr", name) as raster:
        return np.concatenate([colours for _, colours, _ in raster.bands]), raster.warnings


def is_fields(pixels):
    return pixels.shape == FIELDS.shape and np.array_equal(pixels, FIELDS)


@pytest.mark.parametrize(
    ("names", "wanted"),
    [
        (["ViewLayer.AO", "ViewLayer.Combined"], "ViewLayer.Combined"),
        (["Composite.Combined", "ViewLayer.Combined"], "Composite.Combined"),
        (["albedo", "beauty", "specular"], "beauty"),
        (["diffuse", "rgba"], "rgba"),
        (["", "diffuse"], ""),
        (["AO", ""], ""),
        (["left", "right"], "left"),
        (["N", "fill"], "fill"),
        (["ViewLayer.CryptoObject00", "ViewLayer.Image"], "ViewLayer.Image"),
    ],
)
def test_the_whole_picture_is_read_and_all_layers_are_named(exr, names, wanted):
    data = exr(("", [channel for name in names for channel in layer(name)]), wanted=wanted)
    pixels, warnings = read(data)
    assert is_fields(pixels)
    warning = next(warning for warning in warnings if "layers" in warning)
    assert all((name or "(unnamed)") in warning for name in names)
    assert f"; {wanted or '(unnamed)'} is used" in warning


def test_layers_of_data_are_not_the_picture(exr):
    names = [*layer("View.Combined"), *layer("View.Normal", "XYZ"), "View.Depth.Z"]
    pixels, warnings = read(exr(("", names), wanted="View.Combined"))
    assert is_fields(pixels)
    assert any("View.Depth" in warning and "View.Normal" in warning for warning in warnings)
    with pytest.raises(UnsupportedPictureError) as caught:
        read(exr(("", layer("View.Normal", "XYZ")), wanted="View.Normal"))
    assert caught.value.where == {"field": "channels"}


def test_lower_case_channels_of_masks_are_no_colours(exr):
    names = [*layer("Scene.CryptoAsset00", "rgba"), *layer("Scene.Combined")]
    assert is_fields(read(exr(("", names), wanted="Scene.Combined"))[0])


def test_parts_of_the_light_alone_are_refused_with_their_names(exr):
    data = exr(("", [*layer("diffuse"), *layer("specular")]), wanted="specular")
    with pytest.raises(UnsupportedPictureError, match="diffuse, specular") as caught:
        read(data)
    assert caught.value.where == {"field": "layer"}
    assert "--layer" in caught.value.remedy
    assert is_fields(read(data, "specular")[0])


@pytest.mark.parametrize("name", ["ViewLayer.Emit", "viewlayer.emit", "Emit"])
def test_a_layer_is_named_in_full_or_by_its_end(exr, name):
    names = [*layer("ViewLayer.Combined"), *layer("ViewLayer.Emit")]
    data = exr(("", names), wanted="ViewLayer.Emit")
    assert is_fields(read(data, name)[0])


@pytest.mark.parametrize("name", ["Diffuse", "ViewLayer", "Combined.R"])
def test_an_unknown_layer_is_refused_with_the_names(exr, name):
    data = exr(("", [*layer("A.Combined"), *layer("B.Combined")]), wanted="A.Combined")
    with pytest.raises(OptionError) as caught:
        read(data, name)
    assert caught.value.where == {"field": "layer", "available": ["A.Combined", "B.Combined"]}


def test_a_name_that_two_layers_end_with_is_refused(exr):
    data = exr(("", [*layer("A.Combined"), *layer("B.Combined")]), wanted="B.Combined")
    with pytest.raises(OptionError, match="Several layers"):
        read(data, "Combined")
    assert is_fields(read(data, "B.Combined")[0])


def test_files_without_layers_refuse_a_name(png, noise):
    for data in (png(noise(4, 4, 3), 8, 2), b"SAMPLE_ID,R,G,B,L,a,b\n1,0,0,0,0,0,0\n"):
        with pytest.raises(OptionError) as caught:
            read_characterisation(data, layer="rgba")
        assert caught.value.where == {"field": "layer"}


@pytest.mark.parametrize(
    ("parts", "wanted"),
    [
        ([("depth", ["Z"]), ("rgba", list("RGB"))], "rgba"),
        ([("rgba", list("RGB")), ("depth", ["Z"])], "rgba"),
        ([("AO", list("RGB")), ("beauty", list("RGB"))], "beauty"),
        ([("View.AO", layer("View.AO")), ("View.Combined", layer("View.Combined"))],
         "View.Combined"),
    ],
)  # fmt: skip
def test_files_of_several_parts(exr, parts, wanted):
    pixels, warnings = read(exr(*parts, wanted=wanted))
    assert is_fields(pixels)
    assert any(f"{wanted} is used" in warning for warning in warnings)


def test_alpha_is_that_of_the_layer(exr):
    names = [*layer("AO", "RGBA"), *layer("Combined", "RGBA")]
    data = exr(("", names), wanted="Combined", alpha=(1.0, 0.0))
    found = read_characterisation(data)
    np.testing.assert_allclose(found.values, FIELDS[:1], atol=1e-3)
    assert found.provenance["pixels"]["transparent"] == 1


def test_gray_is_read_where_there_are_no_colours(exr):
    pixels, _ = read(exr(("", ["Y", "Depth.Z"]), wanted=""))
    np.testing.assert_array_equal(pixels, FIELDS[:, :1])
