"""Test a server with schemathesis and its OpenAPI document: ``--seconds 600 --seed 1``.

Schemathesis generates valid and invalid requests from the document. It also follows the links of
the document: a gamut is built, described, downloaded, deleted and requested again. Status, media
type, header fields and schema of each answer must match the document, and no answer may be a 5xx.
Otherwise the program prints the report of schemathesis and exits with 1.
"""

import argparse
import os
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

from serving import PATIENCE, serving  # noqa: E402 - a program beside this one


def main():
    """Run schemathesis and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=int, default=600)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--phases", default="examples,coverage,fuzzing,stateful")
    parser.add_argument("--examples", type=int, default=0, help="per operation; else by the time")
    parser.add_argument(
        "--stateful-examples", type=int, default=0, help="links, apart from the time"
    )
    parsed = parser.parse_args()
    # The queue is never full, because answers 503 and 429 test nothing.
    with serving(build_queue=1000, cors_origins="*") as server:
        bounds = ["--max-time", str(parsed.seconds)]
        bounds += ["--max-examples", str(parsed.examples)] if parsed.examples else []
        runs = [["--phases", parsed.phases, *bounds]]
        if parsed.stateful_examples:
            runs += [["--phases", "stateful", "--max-examples", str(parsed.stateful_examples)]]
        command = [
            *(sys.executable, "-m", "schemathesis.cli"),
            *("--config-file", str(HERE / "schemathesis.toml")),
            *("run", f"{server.url}/openapi.json"),
            *("--request-timeout", str(PATIENCE)),
            *("--seed", str(parsed.seed)),
            *("--generation-database", "none"),
            *("--suppress-health-check", "all"),
            *("--warnings", "off"),
            "--continue-on-failure",
            "--no-color",
        ]
        environment = {**os.environ, "PYTHONWARNINGS": "ignore"}
        folder = server.log_path.parent
        ends = [
            subprocess.run([*command, *run], check=False, cwd=folder, env=environment)
            for run in runs
        ]
        if "Traceback" in server.log():
            sys.stderr.write(server.log()[-5000:])
            return 1
    return max(end.returncode for end in ends)


if __name__ == "__main__":
    sys.exit(main())
