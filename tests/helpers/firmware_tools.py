"""Compiling and running generated C in tests."""

from __future__ import annotations

import importlib
import json
import os
import pickle
import shutil
import subprocess
import sys
from collections.abc import Callable, Mapping
from hashlib import sha256
from pathlib import Path
from tempfile import NamedTemporaryFile
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from helpers import inside

HELPERS = Path(__file__).parent
CODEGEN = HELPERS.parents[1] / "codegen"


def bench_module(name: str) -> ModuleType:
    """A script of codegen or codegen/bench as a module; its neighbours are found beside it."""
    sys.path += {str(CODEGEN), str(CODEGEN / "bench")} - set(sys.path)
    return importlib.import_module(name)


def study(asked: Any, count: int, reach: Any = None, seed: int = 0, **how: Any) -> Any:
    """What the campaign of codegen/bench says of random goals about home, `count` a leg."""
    ranges, lines = bench_module("ranges"), bench_module("directions").directions(asked)[0]
    how.setdefault("legs", 1)
    goals = ranges.by_legs(lines, count, np.random.default_rng(seed), reach or ranges.MIDDLE, **how)
    return bench_module("rows").judged(lines, goals)


FOLDERS: list[str] = bench_module("generate").FOLDERS
"""Folders that codegen/generate.py writes."""
COMMITTED: list[str] = sorted(bench_module("generate").COMMITTED)
"""Those of them that are committed; `folder` writes the others."""
POSES = [name for name in FOLDERS if not name.startswith("ankle_")]
"""Folders of platforms and arms, not of maps between joints."""
KINDS = [
    "ankle_float",
    "delta_double",
    "ren2008_float",
    "scara_float",
    "ur5e_double",
    "zhang2009_double_struct",
    "zhang2009_float_home_relative",
    "zhao2000_double",
]
"""One of the folders of each kind, for laws that the gate tries on these alone."""
STRICT = [
    "-std=c99",
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Wdouble-promotion",
    "-Wshadow",
    "-Wmissing-prototypes",
    "-pedantic",
    "-Werror",
    "-fno-math-errno",
    "-ffp-contract=off",
]


def kept_files(
    write: Callable[..., dict[str, str]], mechanism: object, *options: object
) -> dict[str, str]:
    """The files that `write` makes of a mechanism with options, made once for all workers of a
    run.
    """
    told = [option for option in options if option is not None]
    key = sha256(pickle.dumps((write.__name__, mechanism, told))).hexdigest()
    place = Path(os.environ["SYMKIN_FOLDERS"]) / "files" / key
    if not place.exists():
        files = write(mechanism, *options)
        place.parent.mkdir(parents=True, exist_ok=True)
        with NamedTemporaryFile("w", dir=place.parent, delete=False) as file:
            json.dump(files, file)
        Path(file.name).replace(place)
    return dict(json.loads(place.read_text()))


def write_untested(mechanism: object, folder: Path, options: object) -> None:
    """Write the files of a mechanism for a test that compiles and runs the folder's own test
    itself.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in inside.codegen_folder.folder_files(mechanism, options).items():
        (folder / name).write_text(text)


def write_code(mechanism: object, folder: Path, options: object) -> None:
    """Write source and header of a mechanism for a test that calls the functions itself: vectors
    for the folder's own test take longer than the code.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in kept_files(_code_files, mechanism, options).items():
        (folder / name).write_text(text)


def _code_files(mechanism: object, options: object) -> dict[str, str]:
    """Source and header by their names."""
    program = inside.codegen_program.build_program(mechanism, options)
    name = program.mechanism.name
    return {f"{name}.h": program.header, f"{name}.c": program.source}


def tested_once(
    run: Callable[[str, Mapping[str, str]], None], name: str, files: Mapping[str, str]
) -> None:
    """Run the own test of a folder's files unless these have passed it in this run with the same
    compiler.
    """
    tested = [text for file, text in sorted(files.items()) if file.endswith((".c", ".h"))]
    compiler = [os.environ.get(name, "") for name in ("CC", "PATH")]
    key = sha256(json.dumps([name, compiler, tested]).encode()).hexdigest()
    passed = Path(os.environ["SYMKIN_FOLDERS"]) / "tested" / key
    if not passed.exists():
        run(name, files)
        passed.parent.mkdir(parents=True, exist_ok=True)
        passed.touch()


class KeptKinds:
    """What a process has derived of machines with options, of the last 40 of them."""

    def __init__(self, derive: Callable[[object, object], object]) -> None:
        self._derive = derive
        self._kept: dict[bytes, object] = {}

    def __call__(self, mechanism: object, options: object) -> object:
        key = sha256(pickle.dumps((mechanism, options))).digest()
        kind = self._kept.pop(key, None) or self._derive(mechanism, options)
        self._kept[key] = kind
        if len(self._kept) > 40:
            del self._kept[next(iter(self._kept))]
        return kind


def folder(name: str) -> Path:
    """A folder of generated C, committed or written for this run."""
    return Path(bench_module("generate").folder_of(name))


def at_hand(names: list[str]) -> list[object]:
    """Parameters of a test that takes no time but for writing what is not committed: one folder of
    each kind is slow, the others are long.
    """
    marks = {
        name: pytest.mark.slow if name in KINDS else pytest.mark.long
        for name in names
        if name not in COMMITTED
    }
    return [pytest.param(name, marks=marks[name]) if name in marks else name for name in names]


def manifest(name: str) -> dict[str, Any]:
    """The manifest of a folder of generated C."""
    return dict(json.loads((folder(name) / "manifest.json").read_text()))


def compiler(name: str) -> str:
    """A compiler's (or emulator's) path; where it is absent the test is skipped, in CI it fails."""
    found = shutil.which(name)
    if found is None and os.environ.get("CI") == "true":
        pytest.fail(f"{name} is not installed; CI must run this test")
    if found is None:
        pytest.skip(f"{name} is not installed")
    return found


def built(cc: str, folder: Path, sources: list[str], output: str, *flags: str) -> Path:
    """Compiles and links in a folder; warnings are errors."""
    command = [compiler(cc), *STRICT, *flags, *sources, "-lm", "-o", output]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder / output


def passed(program: Path) -> str:
    """Output of a program that must end with status 0."""
    done = subprocess.run(
        [str(program)], cwd=program.parent, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout
