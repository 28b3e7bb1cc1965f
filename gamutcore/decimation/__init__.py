"""decimation."""
