"""Queries over HTTP: the table of operations, forms of bodies and answers, execution."""
