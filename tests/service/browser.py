"""What a real browser makes of a page: Chromium without a window, a new profile for every page."""

import os
import shutil
import subprocess

NAMES = ("chromium", "chromium-browser", "google-chrome")


class Page:
    """A page after its scripts have run.

    Parameters
    ----------
    document : str
        The HTML that the elements are at last.
    complaints : list of str
        What the browser wrote to its console: scripts that fail, what a policy forbids, requests
        that are refused.
    """

    def __init__(self, document, complaints):
        self.document = document
        self.complaints = complaints


def missing():
    """Why there is no browser; None if there is one."""
    return None if program() else "there is no Chromium: install the package chromium"


def open_page(address, profile):
    """Open an address with an empty directory as the profile, and return the page."""
    result = subprocess.run(
        [
            program(),
            "--headless",
            "--disable-gpu",
            "--disable-dev-shm-usage",
            "--no-first-run",
            # a container's root has no other way to start it
            *(["--no-sandbox"] if os.geteuid() == 0 else []),
            f"--user-data-dir={profile}",
            "--virtual-time-budget=20000",
            "--enable-logging=stderr",
            "--dump-dom",
            address,
        ],
        capture_output=True,
        text=True,
        timeout=600,
        check=True,
    )
    console = [line for line in result.stderr.splitlines() if ":CONSOLE" in line]
    return Page(result.stdout, console)


def program():
    return next(filter(None, map(shutil.which, NAMES)), None)
