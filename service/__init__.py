"""The HTTP service: builds each gamut once, keeps it, and serves any level of it.

All colour and geometry computations are in `gamutcore`. Start reading in `service.application`.
"""

import os

# Every request and every build has a thread or a process already. Threads of OpenBLAS beside them
# spin while they wait: to test a million rows of XYZ took 0.33 s of processor time instead of
# 0.13 s. NumPy reads the variable when it is imported, so this comes first.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
