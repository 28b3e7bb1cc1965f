"""Print the software bill of materials of the image: CycloneDX 1.6, as JSON.

It runs inside the image, with the Python whose packages it lists. Debian's packages come from the
database of dpkg. The document has neither a time nor a serial number: equal images have equal
documents.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator
from importlib.metadata import Distribution, distributions
from pathlib import Path
from typing import Any
from urllib.parse import quote

__all__: list[str] = []

PROJECT = "gamut-boundary-service"
DPKG = Path("/var/lib/dpkg/status")


def normalized(name: str) -> str:
    """Return the normalized name of a Python package (PEP 503)."""
    return re.sub(r"[-_.]+", "-", name).lower()


def python_component(package: Distribution) -> dict[str, Any]:
    """Return a Python package as a component."""
    name, metadata = normalized(package.metadata["Name"]), package.metadata
    address = f"pkg:pypi/{name}@{quote(package.version)}"
    component = {
        "type": "application" if name == PROJECT else "library",
        "bom-ref": address,
        "name": name,
        "version": package.version,
        "purl": address,
    }
    if "License-Expression" in metadata:
        return component | {"licenses": [{"expression": metadata["License-Expression"]}]}
    prefix = "License :: "
    found = [each for each in metadata.get_all("Classifier") or [] if each.startswith(prefix)]
    named = [{"license": {"name": each.rpartition(" :: ")[2]}} for each in found]
    return component | ({"licenses": named} if named else {})


def debian_components() -> Iterator[dict[str, Any]]:
    """Iterate over the installed packages of Debian as components."""
    for stanza in DPKG.read_text().split("\n\n") if DPKG.exists() else ():
        fields = dict(re.findall(r"^([A-Za-z-]+): (.*)$", stanza, re.MULTILINE))
        if fields.get("Status", "").endswith(" installed"):
            name, version = fields["Package"], fields["Version"]
            address = f"pkg:deb/debian/{name}@{quote(version)}?arch={fields['Architecture']}"
            yield {
                "type": "library",
                "bom-ref": address,
                "name": name,
                "version": version,
                "purl": address,
            }


def main() -> None:
    """Write the document to standard output."""
    packages = [python_component(each) for each in distributions()]
    (project,) = [each for each in packages if each["name"] == PROJECT]
    version = ".".join(map(str, sys.version_info[:3]))
    python = {"type": "platform", "bom-ref": "python", "name": "CPython", "version": version}
    others = [each for each in packages if each is not project]
    document = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": {"component": project},
        "components": [
            python,
            *sorted([*others, *debian_components()], key=lambda each: each["bom-ref"]),
        ],
    }
    json.dump(document, sys.stdout, indent=1, sort_keys=True)
    sys.stdout.write("\n")


if __name__ == "__main__":
    main()
