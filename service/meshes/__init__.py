"""Meshes from opened gamuts: search, encoding and caches."""
