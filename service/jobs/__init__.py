"""Jobs: their documents in the store, and their event streams."""
