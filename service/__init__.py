"""The HTTP service: builds each gamut once, keeps it, and serves any level of it.

It computes no colour and no geometry itself; all of that is `gamutcore`. Start reading in
`service.application`.
"""
