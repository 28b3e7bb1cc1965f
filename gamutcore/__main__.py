"""Entry point of ``python -m gamutcore``: the commands that need no server."""

import sys

from gamutcore.cli.app import app, run

if __name__ == "__main__":
    sys.exit(run(app))
