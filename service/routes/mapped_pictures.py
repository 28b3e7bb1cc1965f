"""Pictures that are posted to ``/map``: the form of the answer, and the files for the process."""

from __future__ import annotations

import asyncio
import contextlib
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from fastapi.responses import Response

from gamutcore.arguments import Choice
from gamutcore.characterisation.icc import looks_like_icc
from gamutcore.characterisation.pictures import picture_format
from gamutcore.pictures import DEVICE_VALUES as DEVICE
from gamutcore.pictures import PICTURE_PARAMETERS
from gamutcore.questions import Parameter
from service.access.rate_limits import client_of
from service.admission import Work
from service.container import service_of
from service.http.representations import preferred_media_type
from service.http.request_context import timed
from service.openapi.documentation import binary_content, header
from service.problems.problem import JsonResponse, Problem, ProblemError
from service.questions.answers import warning_header
from service.questions.parameter_models import parameter_model
from service.questions.pictures import MappingRequest, report_header
from service.routes.dependencies import NamedGamuts, checked_gamut
from service.storage.blobs import SCRATCH_FOLDER, BlobNotFoundError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from fastapi import Request

    from service.container import ServiceContainer
    from service.http.bodies import Body

__all__ = [
    "PARAMETERS",
    "answer_picture",
    "document_pictures",
    "is_picture",
    "with_picture_parameters",
]

PICTURES = {"image/png": "png", "image/tiff": "tif", "image/jpeg": "jpg", "image/x-exr": "exr"}
"""Media types of the answers, and the suffixes of their files. OpenEXR has no registered one."""

_OWN = {"png": "image/png", "tiff": "image/tiff", "jpeg": "image/jpeg", "exr": "image/x-exr"}
_DEEP = {"hdr": "image/x-exr", "jpeg-xl": "image/tiff", "jpeg-2000": "image/tiff"}
_DEEP |= {"dpx": "image/tiff"}
"""Media types that keep the depth of formats that are not written."""

PARAMETERS = (
    *PICTURE_PARAMETERS,
    Parameter(
        "result",
        Annotated[str, Choice(("picture", "heat-map", "report"))],
        "What is returned. `heat-map`: the colour difference of each pixel as PNG. `report`: the "
        "numbers of the header field Gamut-Mapped as JSON.",
        default="picture",
    ),
)

_Query = parameter_model("picture_query", PARAMETERS)


def is_picture(request: Request) -> bool:
    """Return whether the body is declared as a picture."""
    return request.headers.get("content-type", "").strip().lower().startswith("image/")


async def answer_picture(request: Request, gamut_id: str) -> Response:
    """Return the picture of the body, mapped."""
    service = service_of(request)
    named = NamedGamuts.of(request)
    values = dict(_Query.of_query(named.items, named.options))
    answer, source = values.pop("result"), values.pop("source")
    if source is not None:
        source = await checked_gamut(request, source, "query", "source")
    client, library = client_of(request.scope), service.library
    with service.bodies.body(request, client) as arriving:
        with timed("body"):
            await arriving.receive(service.settings.max_body_bytes)
        media_type = _media_type(request, arriving.read(0, 64), answer, values["to"])
        of_device = values["to"] == DEVICE
        ids = [gamut_id] if source is None else [gamut_id, source]
        gamuts = [await library.gamut(each, client) for each in ids]
        conditions, record = gamuts[0].gamut.conditions.header, gamuts[0].record
        gamuts.clear()  # they may go while the picture waits

        def need() -> int:
            return library.model_need(record) if of_device else 0

        effort = _BYTE_EFFORT * arriving.size
        place = library.admission.place(Work.HEAVY, client, need, effort)
        with await place as taken, _files(service) as files:
            picture = files.folder / "picture"
            await asyncio.to_thread(_copy, arriving, picture)
            arriving.close()
            model, profile = await files.device(gamut_id) if of_device else (None, None)
            histories = [await files.history(each) for each in ids]
            suffix = "tif" if of_device else PICTURES.get(media_type, "png")
            mapping = MappingRequest(
                picture,
                files.folder / f"mapped.{suffix}",
                histories[0],
                {name: value for name, value in values.items() if value is not None},
                model,
                profile,
                None if source is None else histories[1],
                files.folder / "heat-map.png" if answer == "heat-map" else None,
            )
            report = await service.pictures.mapped(mapping, taken)
            fields = {
                "Cache-Control": "no-store",
                "Vary": "Accept",
                "Gamut-Mapped": report_header(report),
                "Gamut-Conditions": conditions,
                **warning_header(report["warnings"]),
            }
            if answer == "report":
                return JsonResponse(report, 200, fields)
            content = await asyncio.to_thread((mapping.heat_map or mapping.output).read_bytes)
            response = Response(content, 200, fields, media_type)
            return library.admission.hold_response(response, client)


def _copy(body: Body, path: Path) -> None:
    """Write a body to a file without holding all of it in memory."""
    with path.open("wb") as file:
        for start in range(0, body.size, _PIECE):
            file.write(body.read(start, _PIECE))


_BYTE_EFFORT = 100
"""Effort of a byte of a picture: as long as preparing so many bytes."""

_PIECE = 1 << 20
"""Bytes that are copied at a time."""


class _Files:
    """The files of a picture that is mapped, in a folder that is removed afterwards."""

    def __init__(self, service: ServiceContainer, folder: Path) -> None:
        self.service, self.folder = service, folder

    async def history(self, gamut_id: str) -> Path:
        """Write the history file of a gamut, and return its path."""
        path = self.folder / f"{gamut_id}.gamut"
        _, content = await asyncio.to_thread(self.service.store.content, gamut_id)
        await asyncio.to_thread(path.write_bytes, content)
        return path

    async def device(self, gamut_id: str) -> tuple[Path, Path | None]:
        """Write the device model of a gamut, and the profile that it was built from if it is kept.

        The caller holds the bytes; see `Library.model_need`. Raise `DeviceModelError` if there is
        no model.
        """
        opened = await self.service.library.load_device_model(gamut_id)
        path = self.folder / "model"
        await asyncio.to_thread(lambda: path.write_bytes(opened.gamut.device_model.to_bytes()))
        with contextlib.suppress(BlobNotFoundError):
            return path, await asyncio.to_thread(self._profile, gamut_id)
        return path, None

    def _profile(self, gamut_id: str) -> Path | None:
        input_file = self.service.store.input_path(gamut_id)
        try:
            content = input_file.read_bytes()
        finally:
            input_file.unlink(missing_ok=True)
        if not looks_like_icc(content):
            return None
        path = self.folder / "profile"
        path.write_bytes(content)
        return path


@contextlib.contextmanager
def _files(service: ServiceContainer) -> Iterator[_Files]:
    with tempfile.TemporaryDirectory(
        dir=service.scratch_directory, prefix=SCRATCH_FOLDER, ignore_cleanup_errors=True
    ) as folder:
        yield _Files(service, Path(folder))


def _media_type(request: Request, start: bytes, answer: str, to: str) -> str:
    """Return the media type of the answer: that of the picture unless `Accept` prefers another."""
    if answer == "report":
        return "application/json"
    file_format = picture_format(start) or ""
    own = _OWN.get(file_format) or _DEEP.get(file_format, "image/png")
    offered = [own, *(each for each in PICTURES if each != own)]
    if answer == "heat-map":
        offered = ["image/png"]
    elif to == DEVICE:
        offered = ["image/tiff"]
    accept = ",".join(request.headers.getlist("accept")) or "*/*"
    media_type = preferred_media_type(accept, offered)
    if media_type is None:
        detail = f"The answer is not available as {accept[:200]}."
        raise ProblemError(
            Problem("not-acceptable", detail, {"header": "Accept", "available": offered})
        )
    return media_type


def with_picture_parameters(parameters: Sequence[Parameter]) -> tuple[Parameter, ...]:
    """Return the parameters for colours and those for pictures, to be documented together."""
    of_pictures = {parameter.name: parameter for parameter in PARAMETERS}
    both = [
        of_pictures["method"] if parameter.name == "method" else parameter
        for parameter in parameters
    ]
    names = {parameter.name for parameter in both}
    both += [
        replace(parameter, description=f"For pictures: {parameter.description}")
        for name, parameter in of_pictures.items()
        if name not in names
    ]
    return tuple(both)


def document_pictures(body: dict[str, Any], answer: dict[str, Any]) -> None:
    """Add pictures to the OpenAPI description of the route for colours."""
    body["description"] += (
        " A picture of gray or RGB is recognised by its content: any media type image/* stands for "
        "every format that is read. Its parameters are in the query string."
    )
    body["content"] |= _files_described({"image/*": "A picture of gray or RGB"})
    answer["content"] |= _files_described(dict.fromkeys(PICTURES, "The mapped picture"))
    answer["headers"]["Gamut-Mapped"] = header(
        "For pictures: numbers of pixels and distinct colours, in all, out of gamut and moved, and "
        "colour differences CIEDE2000, as a dictionary (RFC 9651).",
        "pixels=6000000, outside=120000, moved=120000, missed=0, colours=400000, "
        "colours-outside=9000, delta-e=0.0500, delta-e-95=0.2000",
    )


def _files_described(summaries: Mapping[str, str]) -> dict[str, Any]:
    """Return the content of bodies that are files, from descriptions by media type."""
    content = binary_content(summaries)
    return {media_type: content[media_type] for media_type in summaries}
