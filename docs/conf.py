"""The site: `python -m sphinx -W docs OUT` (extra `symkin[docs]`). Everything is made here, without
network.
"""

import shutil
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from _site.docstrings import docstring_as_rst  # noqa: E402
from _site.gallery import write_gallery  # noqa: E402
from _site.pictures import draw_pictures, with_pictures  # noqa: E402
from _site.program import api_page, help_page, tolerances_page  # noqa: E402
from _site.verdicts import papers_page  # noqa: E402
from pygments.lexers.special import TextLexer  # noqa: E402
from sphinx.application import Sphinx  # noqa: E402

import symkin  # noqa: E402

SHORT = ("zhao2000", "four_bar", "ur5e")
"""Mechanisms of the gallery with `-t short`, which builds all other pages as they are."""

project = "symkin"
author = "the symkin team"
release = symkin.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx_design", "_site.mathml"]
myst_enable_extensions = ["dollarmath", "deflist", "colon_fence"]
myst_heading_anchors = 4
exclude_patterns = ["robots", "_site", "notebooks", "generated/extra"]
html_theme = "furo"
html_title = "symkin"
html_show_copyright = False
html_math_renderer = "mathml"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_extra_path = ["generated/extra"]
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
highlight_language = "none"
pygments_style = "default"


def write_pages(folder: Path, short: bool) -> None:
    """Pages that are made from the program, its mechanisms and its studies."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    (folder / "extra").mkdir(exist_ok=True)
    (folder / "help.md").write_text(help_page(), encoding="utf-8")
    (folder / "api.md").write_text(api_page(), encoding="utf-8")
    (folder / "tolerances.md").write_text(tolerances_page(), encoding="utf-8")
    (folder / "papers.md").write_text(papers_page(HERE / "papers"), encoding="utf-8")
    if not short:
        draw_pictures(sorted((HERE / "tutorials").glob("*.md")), folder / "pictures")
    names = SHORT if short else symkin.shipped_names()
    write_gallery(folder / "gallery", HERE.parent / "studies", names, moving=not short)


write_pages(HERE / "generated", short=tags.has("short"))  # type: ignore[name-defined]  # noqa: F821


def setup(app: Sphinx) -> None:
    """Diagrams in text need no colours; docstrings are plain text."""
    for diagram in ("layers", "mermaid"):
        app.add_lexer(diagram, TextLexer)
    app.connect("source-read", set_pictures)
    app.connect("autodoc-process-docstring", set_docstring)


def set_pictures(app, page: str, source: list[str]) -> None:  # type: ignore[no-untyped-def]  # noqa: ARG001
    """What the commands of a tutorial draw."""
    if page.startswith("tutorials/"):
        source[0] = with_pictures(
            page.removeprefix("tutorials/"), source[0], HERE / "generated" / "pictures"
        )


def set_docstring(app, what, name, obj, options, lines: list[str]) -> None:  # type: ignore[no-untyped-def]  # noqa: ARG001
    """What autodoc shows of a docstring."""
    lines[:] = docstring_as_rst(lines)
