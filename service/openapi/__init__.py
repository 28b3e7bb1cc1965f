"""The OpenAPI document: models, examples and descriptions."""
