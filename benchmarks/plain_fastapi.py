"""A FastAPI application as its tutorial has it: the peer of the service for a repeated mesh.

It answers every mesh with the same bytes, which are those of a file.
"""

from __future__ import annotations

import sys
from pathlib import Path

import uvicorn
from fastapi import FastAPI, Response

app = FastAPI()


@app.get("/readyz")
def ready() -> dict[str, str]:
    """Say that the server answers."""
    return {"status": "ready"}


@app.get("/v1/gamuts/{identifier}/mesh")
async def mesh(identifier: str, triangles: int = 1000) -> Response:  # noqa: ARG001 - parsed, as the service does
    """Return the bytes of the mesh."""
    return Response(app.state.content, media_type="model/gltf-binary")


if __name__ == "__main__":
    app.state.content = Path(sys.argv[1]).read_bytes()
    uvicorn.run(app, host="127.0.0.1", port=0, access_log=False)
