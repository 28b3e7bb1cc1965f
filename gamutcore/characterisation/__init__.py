"""characterisation."""
