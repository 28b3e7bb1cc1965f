"""Jobs: the documents in the store, and what clients are told of them."""
