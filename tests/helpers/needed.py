"""Modules that some tests need and that take long to load: looked for at collection, loaded when
they are used.
"""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import Any

import pytest


def needs(name: str) -> pytest.MarkDecorator:
    """Return the mark of tests that are skipped where a module is not installed."""
    return pytest.mark.skipif(find_spec(name) is None, reason=f"{name} is not installed")


class Later:
    """Stands for a module, which is loaded at the first use of a name of it."""

    def __init__(self, module: str) -> None:
        self.module = module

    def __getattr__(self, name: str) -> Any:
        return getattr(import_module(self.module), name)
