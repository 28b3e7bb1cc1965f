"""Array types of the signatures of this package."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]
"""Colours and geometry in double precision."""

Float32Array: TypeAlias = NDArray[np.float32]
"""Positions in delivered precision."""

PositionArray: TypeAlias = NDArray[np.floating[Any]]
"""Positions in working (float64) or delivered (float32) precision."""

IndexArray: TypeAlias = NDArray[np.int32]
"""Indices of vertices, faces and corners."""

LongArray: TypeAlias = NDArray[np.int64]
"""Numbers that may exceed int32."""

BooleanArray: TypeAlias = NDArray[np.bool_]
"""One answer for each row."""

ByteArray: TypeAlias = NDArray[np.uint8]
"""Flags and small numbers."""

ShortArray: TypeAlias = NDArray[np.int16]
"""Device values as whole numbers of steps."""
