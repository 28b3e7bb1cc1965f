"""Meshes from opened gamuts: search, encoding, caches and the fast path."""
