"""A gamut-mapping microservice: it maps batches of CIELAB colours into one press.

    GAMUT_SERVICE=http://127.0.0.1:8000 uvicorn --app-dir examples mapping_service:app --port 8001
    curl --data-binary @colours.npy 'http://127.0.0.1:8001/map?method=clip-hue' -o mapped.npy

The gamut service does the computation. This process keeps connections open, bounds the number of
requests in flight, and waits as the gamut service asks it to when that is busy.
"""

import asyncio
import contextlib
import io
import os
from collections.abc import AsyncIterator
from pathlib import Path

import httpx
import numpy as np
from fastapi import FastAPI, HTTPException, Request, Response
from gamutclient import AsyncClient, InvalidPointsError, ServiceError

PRESS = Path(os.environ.get("PRESS", Path(__file__).with_name("FOGRA39L.ti3")))
IN_FLIGHT = asyncio.Semaphore(8)


@contextlib.asynccontextmanager
async def lifespan(app: FastAPI) -> AsyncIterator[None]:
    """Build the gamut of the press, or find it, before the first request."""
    limits = httpx.Limits(max_connections=8)
    async with AsyncClient(os.environ["GAMUT_SERVICE"], limits=limits) as client:
        app.state.press = await client.build(PRESS, ink_limit=300)
        yield


app = FastAPI(lifespan=lifespan)


@app.post("/map")
async def map_colours(request: Request, method: str = "clip-hue") -> Response:
    """Map the rows of an .npy file; the answer is an .npy file of the same shape."""
    try:
        file = io.BytesIO(await request.body())
        colours = np.lib.format.read_array(file, allow_pickle=False)
    except (ValueError, MemoryError) as error:
        raise HTTPException(422, f"The body is not an .npy file: {error}") from error
    try:
        async with IN_FLIGHT:
            mapped = await request.app.state.press.map(colours, method, max_error=0.5)
    except InvalidPointsError as error:
        raise HTTPException(422, {"code": error.code, "detail": str(error)}) from error
    except ServiceError as error:
        raise HTTPException(error.status, {"code": error.code, "detail": str(error)}) from error
    file = io.BytesIO()
    np.save(file, mapped.points)
    return Response(file.getvalue(), media_type="application/x-npy")
