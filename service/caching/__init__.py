"""Caches and shared work that any part of the service uses."""
