"""The parsers that are fuzzed, by name."""

from targets import meshes, pictures, profiles, texts

TARGETS = {**texts.TARGETS, **meshes.TARGETS, **pictures.TARGETS, **profiles.TARGETS}
