"""Configuration of Sphinx for `make docs`; docs/decisions/documentation.md gives the reasons.

The source directory is the root of the repository. A relative link between documents therefore
works on the site and on a page of the repository. The front page is docs/start.md, and the table of
contents is made of the links of docs/README.md.
"""

from __future__ import annotations

import posixpath
import re
from pathlib import Path
from typing import TYPE_CHECKING

from sphinx.errors import ExtensionError

from gamutcore import Gamut, reference
from gamutcore.version import __version__

if TYPE_CHECKING:
    from sphinx.application import Sphinx

ROOT = Path(__file__).parents[2]

project = "Gamut boundary service"
project_copyright = "The authors. Apache License 2.0"
release = __version__

extensions = ["myst_nb", "numpydoc", "sphinx.ext.autodoc", "sphinx.ext.autosummary"]
root_doc = "docs/start"
# the first is that of autosummary
source_suffix = {".rst": "restructuredtext", ".md": "myst-nb", ".ipynb": "myst-nb"}
include_patterns = ["*.md", "docs/**", "examples/*.md"]
exclude_patterns = ["docs/site"]
templates_path = [str(Path(__file__).parent / "templates")]  # autosummary looks in another folder

CONTENTS = {root_doc: "docs/README.md", "docs/decisions/README": "docs/decisions/README.md"}
"""Pages with a table of contents, and the documents whose links it is made of."""

LIVE_VIEWER = re.compile(r"<!-- live viewer -->\n!\[.*\n")
"""Comment and picture in a document; a frame with the viewer on the site."""

FRAME = """```{raw} html
<iframe class="live-viewer" loading="lazy" src="../_static/FOGRA39L.html"
  title="Viewer of the gamuts of coated offset printing and of sRGB"></iframe>
```
"""

ROOT_CELL = """```{code-cell}
:tags: [remove-cell]

%cd -q ../..
```

"""
"""First cell of a recipe, whose paths run from the root of the repository."""

# --- documents and recipes ---

myst_heading_anchors = 4
default_role = "py:obj"
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 600  # seconds of a cell, beside other checks
nb_merge_streams = True

# --- reference of the Python package ---

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # numpydoc states the types
autosummary_ignore_module_all = False
numpydoc_class_members_toctree = False
numpydoc_show_class_members = False

# --- pages ---

html_theme = "pydata_sphinx_theme"
html_title = f"{project} {release}"
html_copy_source = False
html_extra_path = ["extra"]
html_static_path = ["static"]
html_css_files = ["site.css"]
html_sidebars = {"**": ["contents.html"]}
html_theme_options = {
    "logo": {"text": f"{project} {release}"},  # each page says for which version it is
    "navbar_center": [],
    "navbar_end": ["theme-switcher"],
    "navbar_persistent": ["search-button"],
    "secondary_sidebar_items": ["page-toc"],
    "show_prev_next": False,
    "footer_start": ["copyright"],
    "footer_center": [],
    "footer_end": [],
}


def toctrees(page: str, document: str) -> str:
    """Return a hidden toctree for each section of a document that lists documents.

    Parameters
    ----------
    page : str
        Name of the page that gets the toctrees.
    document : str
        Path of a Markdown document with a heading of second order above each list.
    """
    folder = posixpath.relpath(posixpath.dirname(document), posixpath.dirname(page) or ".")
    trees = []
    for section in (ROOT / document).read_text().split("\n## ")[1:]:
        caption = section.splitlines()[0]
        links = re.findall(r"\]\(([\w./-]+)\.(?:md|ipynb)\)", section)
        pages = [posixpath.normpath(posixpath.join(folder, link)) for link in links]
        # in place of the page itself, the document
        itself, listed_document = posixpath.basename(page), f"/{document.removesuffix('.md')}"
        listed = [listed_document if link == itself else link for link in pages]
        lines = ["```{toctree}", ":hidden:", f":caption: {caption}", "", *listed, "```"]
        trees.append("\n".join(lines))
    return "\n\n".join(trees)


def complete_source(_app: Sphinx, page: str, source: list[str]) -> None:
    """Add the table of contents, the frame of the viewer and the first cell of a recipe."""
    source[0] = LIVE_VIEWER.sub(FRAME, source[0])
    if page.startswith("docs/recipes/"):
        source[0] = source[0].replace("```{code-cell}", f"{ROOT_CELL}```{{code-cell}}", 1)
    if page in CONTENTS:
        source[0] += f"\n\n{toctrees(page, CONTENTS[page])}\n"


def write_viewer(app: Sphinx, failure: Exception | None) -> None:
    """Write the viewer of the front page, one file as `gamutcore.Gamut.to_html` gives it."""
    if failure is None:
        few = {"surface_samples": 5000}  # a third of the bytes of 20,000
        press = Gamut(ROOT / "examples" / "FOGRA39L.ti3", **few)
        page = press.to_html(["FOGRA39L", "sRGB"], reference("srgb", **few))
        (Path(app.outdir) / "_static" / "FOGRA39L.html").write_bytes(page)


def refuse_other_hosts(app: Sphinx, failure: Exception | None) -> None:
    """Raise an error where a page loads a script, a style sheet or a picture from another host."""
    for page in [] if failure else sorted(Path(app.outdir).rglob("*.html")):
        loaded = re.search(
            r"""(?:\bsrc=|<link\b[^>]*\bhref=)["'](?:https?:)?//[^"']*""", page.read_text()
        )
        if loaded:
            raise ExtensionError(f"{page.relative_to(app.outdir)} loads from a host: {loaded[0]}")


def setup(app: Sphinx) -> None:
    """Connect the functions of this file with Sphinx."""
    app.connect("source-read", complete_source)
    app.connect("build-finished", write_viewer)
    app.connect("build-finished", refuse_other_hosts)
