"""CxF3 files for the tests of the modules that read them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

NAMESPACE = "http://colorexchangeformat.com/CxF3-core"


@pytest.fixture(scope="session")
def cxf_file() -> Callable[..., bytes]:
    """Return a function that puts a CxF3 file together from objects and specifications."""

    def make(objects: Sequence[str], specifications: Sequence[str] = ()) -> bytes:
        return (
            f'<?xml version="1.0"?>\n<cc:CxF xmlns:cc="{NAMESPACE}">\n<cc:Resources>'
            "<cc:ObjectCollection>\n" + "\n".join(objects) + "\n</cc:ObjectCollection>"
            "<cc:ColorSpecificationCollection>"
            + "".join(specifications)
            + "</cc:ColorSpecificationCollection></cc:Resources></cc:CxF>"
        ).encode()

    return make


@pytest.fixture(scope="session")
def cxf_object() -> Callable[..., str]:
    """Return a function that writes an object: device values, colours, tags."""

    def make(
        device: str = "", colours: str = "", kind: str = "", name: str = "", **tags: object
    ) -> str:
        written = "".join(f'<cc:Tag Name="{tag}" Value="{value}"/>' for tag, value in tags.items())
        return (
            f'<cc:Object ObjectType="{kind}" Name="{name}" Id="i">'
            + (f"<cc:ColorValues>{colours}</cc:ColorValues>" if colours else "")
            + (f"<cc:DeviceColorValues>{device}</cc:DeviceColorValues>" if device else "")
            + f'<cc:TagCollection Name="x">{written}</cc:TagCollection></cc:Object>'
        )

    return make


@pytest.fixture(scope="session")
def cxf_specification() -> Callable[..., str]:
    """Return a function that writes a colour specification."""

    def make(
        identifier: str,
        *,
        illumination: str = "",
        backing: str = "",
        kind: str = "Spectrum_Reflectance",
        illuminant: str = "D50",
        observer: int = 2,
        device: str = "",
        increment: int = 10,
    ) -> str:
        if illumination:
            device += f"<cc:DeviceIllumination>{illumination}</cc:DeviceIllumination>"
        return (
            f'<cc:ColorSpecification Id="{identifier}"><cc:TristimulusSpec><cc:Illuminant>'
            f"{illuminant}</cc:Illuminant><cc:Observer>{observer}_Degree</cc:Observer>"
            "</cc:TristimulusSpec><cc:MeasurementSpec>"
            f"<cc:MeasurementType>{kind}</cc:MeasurementType>"
            f'<cc:WavelengthRange StartWL="380" Increment="{increment}"/>'
            + (f"<cc:Backing>{backing}</cc:Backing>" if backing else "")
            + (f"<cc:Device>{device}</cc:Device>" if device else "")
            + "</cc:MeasurementSpec></cc:ColorSpecification>"
        )

    return make


@pytest.fixture(scope="session")
def cxf_lab() -> Callable[..., str]:
    """Return a function that writes a CIELAB colour."""

    def make(lightness: float, a: float, b: float, specification: str = "S") -> str:
        return (
            f'<cc:ColorCIELab ColorSpecification="{specification}"><cc:L>{lightness}</cc:L>'
            f"<cc:A>{a}</cc:A><cc:B>{b}</cc:B></cc:ColorCIELab>"
        )

    return make


@pytest.fixture(scope="session")
def cxf_spectrum() -> Callable[..., str]:
    """Return a function that writes a reflectance spectrum of 36 equal bands."""

    def make(value: float, specification: str = "S", kind: str = "Reflectance") -> str:
        return (
            f'<cc:{kind}Spectrum StartWL="380" ColorSpecification="{specification}">'
            + " ".join([f"{value:g}"] * 36)
            + f"</cc:{kind}Spectrum>"
        )

    return make
