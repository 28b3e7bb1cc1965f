"""Draw docs/pictures/architecture.svg from the imports of gamutcore and service.

Run by ``make architecture``. A box is a folder or a module at the top of a package. An arrow leads
from a box to a box that it imports. Boxes lie above everything that they import. Arrows that follow
from two others are left out (transitive reduction). ``tests/test_architecture.py`` fails where the
picture differs from the imports.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable
from functools import cache
from graphlib import TopologicalSorter
from html import escape
from pathlib import Path

__all__ = ["draw_architecture", "find_imports"]

ROOT = Path(__file__).parents[2]
PICTURE = Path(__file__).with_suffix(".svg")
PACKAGES = ("service", "gamutcore")
"""One column each, from left to right; a package imports only from those on its right."""

FOUNDATION = "gamutcore.*"
"""One box for the modules at the top of gamutcore that import no folder of gamutcore."""

BOX_WIDTH, BOX_HEIGHT, GAP, ROW = 112, 30, 14, 68
MARGIN = 30


def find_imports(root: Path = ROOT) -> dict[str, set[str]]:
    """Map each folder or top module, such as ``service.routes``, to those that it imports."""
    files = {
        ".".join(file.relative_to(root).with_suffix("").parts).removesuffix(".__init__"): file
        for package in PACKAGES
        for file in sorted((root / package).rglob("*.py"))
    }
    found: dict[str, set[str]] = {}
    for module, file in files.items():
        found.setdefault(top(module), set())
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and node.module:
                submodules = [f"{node.module}.{alias.name}" for alias in node.names]
                names = [name if name in files else node.module for name in submodules]
            else:
                continue
            found[top(module)] |= {top(name) for name in names if name in files}
    # The packages' own __init__ modules only give names of others a second address.
    for package in PACKAGES:
        found.pop(package, None)
    return {box: found[box] - {box, *PACKAGES} for box in sorted(found)}


def top(module: str) -> str:
    """Return the first two parts of a module's name."""
    return ".".join(module.split(".")[:2])


def merge_foundation(imports: dict[str, set[str]], root: Path = ROOT) -> dict[str, set[str]]:
    """Replace the modules that everything rests on by one box."""
    inside: set[str] = set()
    core = [box for box in imports if box.startswith("gamutcore.")]
    modules = {box for box in core if not (root / box.replace(".", "/")).is_dir()}
    while added := {box for box in modules - inside if imports[box] <= inside}:
        inside |= added
    merged: dict[str, set[str]] = {FOUNDATION: set()}
    for box, targets in imports.items():
        if box not in inside:
            merged[box] = {FOUNDATION if target in inside else target for target in targets}
    return merged


def reduce_transitively(imports: dict[str, set[str]]) -> dict[str, set[str]]:
    """Leave out every import that is also reached through another one."""

    @cache
    def reached(box: str) -> frozenset[str]:
        return frozenset(imports[box]).union(*(reached(target) for target in imports[box]))

    return {
        box: {
            target
            for target in targets
            if not any(target in reached(other) for other in targets - {target})
        }
        for box, targets in imports.items()
    }


def find_rows(imports: dict[str, set[str]]) -> dict[str, int]:
    """Number the rows from the bottom: one above the highest import in the same package."""
    rows: dict[str, int] = {}
    for box in TopologicalSorter(imports).static_order():  # raises CycleError
        package = box.split(".")[0]
        below = [rows[target] for target in imports[box] if target.startswith(f"{package}.")]
        rows[box] = 1 + max(below, default=-1)
    return rows


def find_positions(
    imports: dict[str, set[str]], rows: dict[str, int]
) -> dict[str, tuple[int, int]]:
    """Return the upper left corner of each box: a column per package, rows centred in it."""
    height = 1 + max(rows.values())
    lines = {
        package: [
            sorted(box for box in imports if rows[box] == row and box.startswith(f"{package}."))
            for row in range(height)
        ]
        for package in PACKAGES
    }
    positions: dict[str, tuple[int, int]] = {}
    left = MARGIN
    for package in PACKAGES:
        boxes = max(map(len, lines[package]))
        width = boxes * (BOX_WIDTH + GAP) - GAP
        for row, line in enumerate(lines[package]):

            def importers_centre(box: str) -> float:
                """Mean position of what a box imports, so that arrows cross less."""
                xs = [positions[target][0] for target in imports[box] if target in positions]
                return sum(xs) / len(xs) if xs else 0.0

            indent = (width - len(line) * (BOX_WIDTH + GAP) + GAP) // 2
            for column, box in enumerate(sorted(line, key=importers_centre)):
                x = left + indent + column * (BOX_WIDTH + GAP)
                positions[box] = (x, MARGIN + (height - row) * ROW)
        left += width + 4 * MARGIN
    return positions


def arrow(start: tuple[int, int], end: tuple[int, int], color: str) -> str:
    """Return a curve from the bottom of one box to the top of another."""
    x1, y1 = start[0] + BOX_WIDTH // 2, start[1] + BOX_HEIGHT
    x2, y2 = end[0] + BOX_WIDTH // 2, end[1]
    bend = max(30, abs(y2 - y1) // 2)
    path = f"M{x1},{y1} C{x1},{y1 + bend} {x2},{y2 - bend} {x2},{y2}"
    return f'<path d="{path}" stroke="{color}" marker-end="url(#head)"/>'


def draw_architecture(root: Path = ROOT) -> str:
    """Return the picture as SVG."""
    imports = merge_foundation(find_imports(root), root)
    rows = find_rows(imports)
    positions = find_positions(imports, rows)
    width = MARGIN + BOX_WIDTH + max(x for x, _ in positions.values())
    height = MARGIN + BOX_HEIGHT + max(y for _, y in positions.values())
    colors = {"service": "#2a6f97", "gamutcore": "#9a3b3b"}
    arrows = [
        arrow(positions[box], positions[target], colors[box.split(".")[0]])
        for box, targets in reduce_transitively(imports).items()
        for target in sorted(targets)
    ]
    return "\n".join([*head(width, height), *arrows, "</g>", *boxes(positions, colors), "</svg>\n"])


def head(width: int, height: int) -> Iterable[str]:
    """Yield the beginning of the picture, up to the arrows."""
    yield f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-size="13"'
    yield 'font-family="sans-serif" text-anchor="middle">'
    yield '<rect width="100%" height="100%" fill="white"/>'
    yield '<marker id="head" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="7" orient="auto">'
    yield '<path d="M0,0 L8,4 L0,8 z" fill="#555"/></marker>'
    yield '<g fill="none" stroke-opacity="0.55">'


def boxes(positions: dict[str, tuple[int, int]], colors: dict[str, str]) -> Iterable[str]:
    """Yield the boxes with their names, and the name of each package above its column."""
    for package in PACKAGES:
        xs = [x for box, (x, _) in positions.items() if box.startswith(f"{package}.")]
        middle = (min(xs) + max(xs) + BOX_WIDTH) // 2
        yield (
            f'<text x="{middle}" y="{MARGIN}" font-size="20" '
            f'fill="{colors[package]}">{package}</text>'
        )
    for box, (x, y) in positions.items():
        package, name = box.split(".")
        label = "base modules" if box == FOUNDATION else name
        yield (
            f'<rect x="{x}" y="{y}" width="{BOX_WIDTH}" height="{BOX_HEIGHT}" rx="4" '
            f'fill="white" stroke="{colors[package]}"/>'
        )
        yield f'<text x="{x + BOX_WIDTH // 2}" y="{y + 20}">{escape(label)}</text>'


if __name__ == "__main__":
    PICTURE.write_text(draw_architecture())
