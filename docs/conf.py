"""How the documents become a site: ``make docs``.

The folder of the sources is the repository itself, so that a link from a page to a page, to a heading or to a source file is
one and the same on the code host and on the site.
"""

import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final, cast

from docutils import nodes
from myst_parser.parsers.sphinx_ import MystParser
from pygments.lexers.special import TextLexer
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment

ROOT: Final = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

project = "Kinopix"
author = "The Kinopix authors"
project_copyright = "The Kinopix authors"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_copybutton"]
root_doc = "README"
include_patterns = [
    "*.md",
    "docs/**.md",
    "benchmarks/README.md",
    "examples/**.md",
    "examples/notebooks/*.ipynb",
]
exclude_patterns = [".*", "build", "demo", "*.egg-info"]

myst_heading_anchors = 4
myst_links_external_new_tab = False
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 100
copybutton_prompt_text = "$ "

html_theme = "furo"
html_title = "Kinopix"
html_show_sourcelink = False
html_copy_source = False
html_extra_path = ["site"]

INDEX: Final = "README"
_LINK: Final = re.compile(r"\]\(([^)#:\s]+\.(?:md|ipynb))\)")
_FENCE: Final = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)


def pages_below(docname: str, text: str) -> Iterator[str]:
    """Give the pages that an index page links to and that no index nearer to them does, in its order."""
    links = dict.fromkeys(
        reversed(_LINK.findall(_FENCE.sub("", text)))
    )  # where a page is linked to twice, the second counts
    for link in reversed(links):
        page = (ROOT / docname).parent.joinpath(link).resolve()
        if page.is_file() and _index_above(page) == ROOT / f"{docname}.md":
            yield page.relative_to(ROOT).with_suffix("").as_posix()


def _index_above(page: Path) -> Path | None:
    """Give the nearest index page in the folders above a page."""
    indices = (folder / f"{INDEX}.md" for folder in page.parents if folder.is_relative_to(ROOT))
    return next((index for index in indices if index.is_file() and index != page), None)


def add_contents(_app: Sphinx, docname: str, source: list[str]) -> None:
    """Make of the links of an index page the site's table of contents: a page that no index links to ends the build."""
    if docname.rsplit("/", 1)[-1] == INDEX:
        entries = "\n".join(f"/{page}" for page in pages_below(docname, source[0]))
        source[0] += f"\n\n```{{toctree}}\n:hidden:\n\n{entries}\n```\n"


def told_once(_app: Sphinx, what: str, _name: str, _of: object, _options: object, lines: list[str]) -> None:
    """Leave the fields out of a class's text, as each follows by itself; keep the shape that a field's text begins with.

    What stands before a colon would be taken for its type.
    """
    if what == "class" and "Fields:" in lines:
        del lines[lines.index("Fields:") :]
    if what in {"attribute", "property"} and lines:
        lines[0] = lines[0].replace("``: ", "`` \N{EN DASH} ", 1)


def list_no_members(_app: Sphinx, env: BuildEnvironment) -> None:
    """Beside the pages of Python list classes and functions, not their members: each page that is written walks all lists."""
    for page, contents in cast("dict[str, Any]", env.tocs).items():
        if page.startswith("docs/reference/api/"):
            for names in contents[0][1:]:
                for name in names:
                    del name[1:]


class NotebookParser(MystParser):
    """A notebook as a page: its text, and its cells of code."""

    supported = ("ipynb",)

    def parse(self, inputstring: str, document: nodes.document) -> None:
        """Parse the notebook's cells, one after the other."""
        cells: list[dict[str, Any]] = json.loads(inputstring)["cells"]
        parts = [(cell["cell_type"], "".join(cell["source"])) for cell in cells]
        super().parse(
            "\n\n".join(text if kind == "markdown" else f"```python\n{text}\n```" for kind, text in parts), document
        )


def setup(app: Sphinx) -> None:
    """Join the above to Sphinx."""
    app.add_lexer("rooms", TextLexer)
    app.add_source_suffix(".ipynb", "ipynb")
    app.add_source_parser(NotebookParser)
    app.connect("env-updated", list_no_members)
    app.connect("source-read", add_contents)
    app.connect("autodoc-process-docstring", told_once, priority=400)  # before napoleon
