"""The HTTP service: builds each gamut once, keeps it, and serves any level of it.

All colour and geometry computations are in `gamutcore`. Start reading in
`service.application`.
"""
