"""The user's cache folder: starts and compiled closures of his own mechanisms."""

from __future__ import annotations

import os
from pathlib import Path


def cache_folder() -> Path:
    """SYMKIN_CACHE, else the platform's folder for caches."""
    named = os.environ.get("SYMKIN_CACHE")
    if named:
        return Path(named)
    from platformdirs import user_cache_path

    return Path(user_cache_path("symkin"))
