"""Builds in worker processes: one process, one performer of jobs, and the engines that use them."""
