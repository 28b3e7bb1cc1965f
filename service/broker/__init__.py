"""Builds on other machines: jobs are sent to workers through Celery."""
