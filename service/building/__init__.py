"""Builds in worker processes: one process, one runner of jobs, and the engines that use them."""
