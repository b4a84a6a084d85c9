"""Warnings of other packages, kept from the user."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

_filters = threading.RLock()
"""Held while the filters are changed, which belong to the process: two threads would restore each other's."""


@contextmanager
def warnings_ignored(message: str = "") -> Iterator[None]:
    """Ignore warnings whose text matches the regular expression `message`, all by default."""
    with _filters, warnings.catch_warnings():
        warnings.filterwarnings("ignore", message)
        yield
