"""Client of the gamut boundary service.

`Client` and `AsyncClient` build, find and list gamuts. A `Gamut` and an `AsyncGamut` have the
methods of `gamutcore.Gamut`, answered by the service. Colours travel as ``.npy`` files.

Modules: `errors`; `results` and `meshes`, what methods return; `arrays`, colours to rows and back;
`transport`, requests with retries; `gamuts` and `clients`, what each method sends, and the classes.
"""

from gamutclient.clients import AsyncClient, Client
from gamutclient.errors import (
    ConnectionLostError,
    GamutClientError,
    InvalidPointsError,
    ServiceError,
)
from gamutclient.gamuts import AsyncGamut, Gamut
from gamutclient.meshes import Mesh
from gamutclient.transport import Retries

__all__ = [
    "AsyncClient",
    "AsyncGamut",
    "Client",
    "ConnectionLostError",
    "Gamut",
    "GamutClientError",
    "InvalidPointsError",
    "Mesh",
    "Retries",
    "ServiceError",
]
