"""Test a server with schemathesis and its OpenAPI document: ``--seconds 600 --seed 1``.

Schemathesis generates valid and invalid requests from the document. It also follows the links of
the document: a gamut is built, described, downloaded, deleted and requested again. Status, media
type, header fields and schema of each answer must match the document, and no answer may be a 5xx.
Otherwise the program prints the report of schemathesis and exits with 1.
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
    """Run schemathesis and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=int, default=600)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--phases", default="examples,coverage,fuzzing,stateful")
    parser.add_argument("--examples", type=int, default=0, help="per operation; else by the time")
    parsed = parser.parse_args()
    # The queue is never full, because answers 503 and 429 test nothing.
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
