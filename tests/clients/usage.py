"""What a client in Python does with the generated code: type-checked, and run against a service.

Arguments: the service's address and a file to post. Prints what was found as JSON.
"""

import json
import sys
from pathlib import Path

import httpx
from gamut_client import Client
from gamut_client.api.gamuts import create_gamut, describe_gamut, describe_levels, download_history
from gamut_client.api.meshes import download_mesh, download_mesh_file
from gamut_client.models import (
    DescribeLevelsSide,
    DownloadMeshFileSide,
    DownloadMeshFileSuffix,
    ErrorCurve,
    GamutDescription,
    GamutOptions,
    MultipartSubmission,
    MultipartSubmissionSpace,
    ProblemDocument,
)
from gamut_client.types import File
from gamut_models import GamutDescription as GamutModel


def main(url: str, path: Path) -> dict[str, object]:
    client = Client(base_url=url, timeout=httpx.Timeout(120))
    with path.open("rb") as opened:
        body = MultipartSubmission(
            file=File(payload=opened, file_name=path.name),
            space=MultipartSubmissionSpace.OKLAB,
            surface_samples=2000,
            centre="[0.5, 0, 0]",
            options=GamutOptions.from_dict({"gamma": 0.5, "centre": [0.5, 0, 0]}),
        )
        built = create_gamut.sync(client=client, body=body)
    if not isinstance(built, GamutDescription):
        raise TypeError(built)
    described = describe_gamut.sync(built.id, client=client)
    levels = describe_levels.sync(built.id, client=client, side=DescribeLevelsSide.INSIDE)
    mesh = download_mesh.sync(built.id, client=client, triangles=500)
    ply = download_mesh_file.sync(
        built.id,
        DownloadMeshFileSuffix.PLY,
        client=client,
        max_mismatch=0.05,
        side=DownloadMeshFileSide.OUTSIDE,
    )
    history = download_history.sync(built.id, client=client)
    missing = describe_gamut.sync("0" * 64, client=client)
    if not isinstance(described, GamutDescription) or not isinstance(levels, ErrorCurve):
        raise TypeError(described, levels)
    if not isinstance(missing, ProblemDocument):
        raise TypeError(missing)
    luminance = GamutOptions.from_dict({"space": "ICtCp", "luminance": 100.0}).luminance
    downloads = (mesh, ply, history)
    files = [each.payload.read() for each in downloads if isinstance(each, File)]
    model = GamutModel.model_validate(described.to_dict())
    return {
        "id": model.id,
        "options": described.options.to_dict(),
        "levels": [level.triangles for level in levels.levels],
        "signatures": [content[:4].decode("latin-1") for content in files],
        "history_bytes": [len(files[2]), model.history_bytes],
        "problem": missing.code,
        "luminance": luminance,
    }


if __name__ == "__main__":
    sys.stdout.write(json.dumps(main(sys.argv[1], Path(sys.argv[2]))))
