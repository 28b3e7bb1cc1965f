"""Lets schemathesis play with a real server, by its OpenAPI document: `--seconds 600 --seed 1`.

Requests are made up from the document, right ones and wrong ones, and, by the document's links, in
chains: a gamut is built, looked at, downloaded, deleted and asked for again. Every answer is
compared with the document: its status, media type, header fields and schema; nothing may be a 5xx.
Ends with status 1, and schemathesis' report on the output, where anything is not as documented.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

from serving import serving  # noqa: E402 - a program beside this one


def main() -> int:
    """Run it, and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=int, default=600)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--phases", default="examples,coverage,fuzzing,stateful")
    parser.add_argument("--examples", type=int, default=0, help="per operation; else by the time")
    parsed = parser.parse_args()
    # Builds are waited for, or a chain would seldom come to a gamut; the queue is never full,
    # because an answer of 503 or 429 shows nothing.
    with serving(build_queue=1000, cors_origins="*") as server:
        command = [
            *(sys.executable, "-m", "schemathesis.cli"),
            *("--config-file", str(HERE / "schemathesis.toml")),
            *("run", f"{server.url}/openapi.json"),
            *("--phases", parsed.phases),
            *("--max-time", str(parsed.seconds)),
            *("--seed", str(parsed.seed)),
            *(("--max-examples", str(parsed.examples)) if parsed.examples else ()),
            *("--generation-database", "none"),
            *("--suppress-health-check", "all"),
            *("--warnings", "off"),
            "--continue-on-failure",
            "--no-color",
        ]
        environment = {**os.environ, "PYTHONWARNINGS": "ignore"}
        status = subprocess.run(
            command, check=False, cwd=server.log.parent, env=environment
        ).returncode
        if "Traceback" in (log := server.log.read_text()):
            sys.stderr.write(log[-5000:])
            return 1
    return status


if __name__ == "__main__":
    sys.exit(main())
