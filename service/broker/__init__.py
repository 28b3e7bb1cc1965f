"""Builds on other machines: jobs sent through Celery."""
