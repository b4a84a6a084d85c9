"""Read the files of `static/`, of which the page is made."""

from __future__ import annotations

from importlib.resources import files

from jinja2 import Environment, PackageLoader, StrictUndefined, Template

from symkin.computed_once import lru_cache


def static_text(name: str) -> str:
    """A file as it is."""
    return files("symkin.page").joinpath("static", *name.split("/")).read_text(encoding="utf-8")


@lru_cache(maxsize=4)
def static_template(name: str) -> Template:
    """A file with statements of Jinja, what is put in escaped; a name without a value is an
    error.
    """
    loader = PackageLoader("symkin.page", "static")
    environment = Environment(
        loader=loader, undefined=StrictUndefined, autoescape=True, trim_blocks=True
    )
    return environment.get_template(name)
