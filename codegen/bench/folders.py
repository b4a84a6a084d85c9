"""Folders of generated C for tests and benches: the committed ones where they stand, the others
written into a temporary place.
"""

from __future__ import annotations

import atexit
import importlib
import json
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator, Sequence
from functools import lru_cache
from pathlib import Path
from types import ModuleType

CODEGEN = Path(__file__).resolve().parents[1]
_HELD = tuple(json.loads((CODEGEN / "digests.json").read_text()))
COMMITTED = sorted({path.parent.name for path in CODEGEN.glob("*/manifest.json")} - set(_HELD))
FOLDERS = sorted([*COMMITTED, *_HELD])
"""Names of all folders that generate.py writes."""
PLACE = "SYMKIN_FOLDERS"
"""Environment variable: a folder in which several processes share what they write; each has its own
without it.
"""


@lru_cache(maxsize=1)
def generate() -> ModuleType:
    """The script generate.py as a module."""
    if str(CODEGEN) not in sys.path:
        sys.path.append(str(CODEGEN))
    return importlib.import_module("generate")


def folder_of(name: str) -> Path:
    """A folder by its name; one that is not committed is written when it is first asked for,
    without measured figures: beside its place and moved there whole, because another process may
    be quicker.
    """
    if name in COMMITTED:
        return CODEGEN / name
    if name not in FOLDERS:
        raise ValueError(f"{name}: no such folder; there are {', '.join(FOLDERS)}")
    place, made = _place() / name, generate()
    if not place.exists():
        place.parent.mkdir(parents=True, exist_ok=True)
        source, options = next((m, o) for folder, m, o in made.variants() if folder == name)
        with tempfile.TemporaryDirectory(dir=place.parent) as scratch:
            written = Path(scratch) / name
            made.write_folder(made.load(source), written, options)
            try:
                written.rename(place)
            except OSError:
                if not place.exists():
                    raise
    return place


def chosen(names: Sequence[str]) -> Iterator[Path]:
    """Folders by name, or wherever one stands; all without names."""
    for name in names or FOLDERS:
        yield folder_of(name) if name in FOLDERS else Path(name).resolve()


@lru_cache(maxsize=1)
def _place() -> Path:
    """Where folders are written: the shared place, or one of this process, which is removed when it
    ends.
    """
    shared = os.environ.get(PLACE)
    if shared:
        return Path(shared)
    own = Path(tempfile.mkdtemp(prefix="symkin-folders-"))
    atexit.register(shutil.rmtree, own, ignore_errors=True)
    return own
