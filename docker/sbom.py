"""Print the software bill of materials of the image: CycloneDX 1.6, as JSON.

It runs inside the image, with the Python whose packages it lists. Debian's packages come from the
database of dpkg. Libraries inside wheels, such as decoders of pictures, are components of their
package. They come from the wheel's own bills (PEP 770), from its list of files, and from
OpenImageIO itself, whose wheel has no bill. Hashes of packages are those of the lock file, one for
each architecture; pip has verified one of them. The document has neither a time nor a serial
number: equal images have equal documents.
"""

from __future__ import annotations

import base64
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
LOCK = Path(__file__).with_name("requirements.txt")
BUNDLED = re.compile(r"[^/]+\.libs/|.*/lib/lib[^/]+\.so")
"""Paths of shared libraries that a wheel brings along: where auditwheel puts them, or ``lib/``."""
BILL = re.compile(r"[^/]+\.dist-info/sboms/[^/]+\.json")


def normalized(name: str) -> str:
    """Return the normalized name of a Python package (PEP 503)."""
    return re.sub(r"[-_.]+", "-", name).lower()


def locked_hashes() -> dict[str, list[str]]:
    """Return the SHA-256 of the wheels in the lock file, by name and version."""
    text = LOCK.read_text().replace("\\\n", " ")
    pins = re.findall(r"^([^=#\s]+)==(\S+)(.*)$", text, re.MULTILINE)
    return {
        f"{normalized(name)}@{version}": re.findall(r"sha256:([0-9a-f]{64})", rest)
        for name, version, rest in pins
    }


def sha256_hashes(digests: list[str]) -> dict[str, Any]:
    """Return the hashes of a component; no member without any."""
    return {"hashes": [{"alg": "SHA-256", "content": each} for each in digests]} if digests else {}


def licences(package: Distribution) -> dict[str, Any]:
    """Return the licences of a component: the expression, else classifiers, else the old field."""
    metadata = package.metadata
    if "License-Expression" in metadata:
        return {"licenses": [{"expression": metadata["License-Expression"]}]}
    prefix = "License :: "
    found = [each for each in metadata.get_all("Classifier") or [] if each.startswith(prefix)]
    names = [each.rpartition(" :: ")[2] for each in found]
    if not names and metadata.get("License"):
        names = [metadata["License"].strip().splitlines()[0]]
    return {"licenses": [{"license": {"name": each}} for each in names]} if names else {}


def bundled_components(package: Distribution, address: str) -> list[dict[str, Any]]:
    """Return the libraries inside a wheel as components, with unique references."""
    found: dict[str, dict[str, Any]] = {}
    for file in package.files or ():
        path = file.as_posix()
        if BILL.fullmatch(path):
            bill = json.loads(file.read_text())
            stated = [bill.get("metadata", {}).get("component"), *bill.get("components", ())]
            for each in filter(None, stated):
                # Only what stands alone: other members refer to the rest of the wheel's bill.
                members = ("type", "name", "version", "purl", "licenses", "hashes")
                component = {name: each[name] for name in members if name in each}
                if normalized(component["name"]) != normalized(package.metadata["Name"]):
                    found[f"{component['name']}@{component.get('version', '')}"] = component
        elif BUNDLED.match(path) and file.hash is not None:
            digest = base64.urlsafe_b64decode(f"{file.hash.value}=").hex()
            found[path] = {"type": "file", "name": path, **sha256_hashes([digest])}
    if normalized(package.metadata["Name"]) == "openimageio":
        for name, version in openimageio_libraries():
            component = {"type": "library", "name": name, "version": version}
            found[f"{name}@{version}"] = component
    return [{**part, "bom-ref": f"{address}#{quote(key)}"} for key, part in sorted(found.items())]


def openimageio_libraries() -> list[tuple[str, str]]:
    """Return names and versions of the decoders and libraries that OpenImageIO is linked with."""
    import OpenImageIO  # noqa: PLC0415 - only where it is installed

    text = OpenImageIO.get_string_attribute("build:dependencies")
    pairs = [each.rpartition(" ")[::2] for each in text.split(";")]
    return [
        (name, version)
        for name, version in pairs
        if name and version != "NONE" and name != "Python3"  # the one that built the wheel
    ]


def python_component(package: Distribution, hashes: dict[str, list[str]]) -> dict[str, Any]:
    """Return a Python package as a component."""
    name = normalized(package.metadata["Name"])
    address = f"pkg:pypi/{name}@{quote(package.version)}"
    component = {
        "type": "application" if name == PROJECT else "library",
        "bom-ref": address,
        "name": name,
        "version": package.version,
        "purl": address,
        **sha256_hashes(hashes.get(f"{name}@{package.version}", [])),
        **licences(package),
    }
    parts = bundled_components(package, address)
    return component | ({"components": parts} if parts else {})


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
    hashes = locked_hashes()
    packages = [python_component(each, hashes) for each in distributions()]
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
