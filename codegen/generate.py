"""Writes the committed folders of C into this directory, and the digests of all others that the
shipped mechanisms have.

    python codegen/generate.py [FOLDER ...]
    python codegen/generate.py --all -o DIR [FOLDER ...]

There is a folder for each shipped mechanism of limbs, each map between joints and real type. Eight
are committed, to be read; the tests compare their bytes. The others are held by digests.json: of
their text without the test's vectors, numbers to nine digits, because the last digits are those of
a processor. `--all` writes all folders. measured.json has what bench/worst.py measured; figures of
another code than the one that is written are left out.
"""

from __future__ import annotations

import argparse
import atexit
import json
import os
import re
import shutil
import tempfile
from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import lru_cache
from pathlib import Path

from symkin.codegen.folder.folder import folder_files, write_folder
from symkin.codegen.map.options import Options
from symkin.files.written_files import MANIFEST, digest
from symkin.formats.load import load
from symkin.model.shipped import shipped_names

HERE = Path(__file__).parent
COMMITTED = (
    "ankle_float",
    "delta_double",
    "gluon_6l3_double",
    "ren2008_float",
    "ur5e_double",
    "yao2020_float",
    "zhang2009_float",
    "zhao2000_double",
)
"""Folders that people read: the machines of five papers, a map between joints, a delta, an arm; one
of each, of either real type.
"""
DIGESTS = HERE / "digests.json"
FOLDERS = sorted([*COMMITTED, *json.loads(DIGESTS.read_text())])
"""Names of all folders."""
PLACE = "SYMKIN_FOLDERS"
"""Environment variable: where several processes share the folders that they write; each has a place
of its own without it.
"""
HOMES = {"zhang2009": (0.0, 0.0, 420.0, 1.0, 0.0, 0.0, 0.0)}
"""Homes where the file's reference is singular: the middle of the bench's workspace."""
MAPS = {"ankle": (("upper_motor", "lower_motor"), ("ankle.1", "ankle.2"))}
"""Maps between joints: given and found coordinates."""
REALS = ("float", "double")
MEASURED = json.loads((HERE / "measured.json").read_text())
"""Figures of each folder."""
_NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d*(?:e[+-]?\d+)?|e[+-]?\d+)")


def variants() -> list[tuple[str, str, Options]]:
    """(folder, mechanism, options) of every folder."""
    plain = [
        (f"{n}_{r}", n, Options(r, home=HOMES.get(n)))
        for n in shipped_names()
        if not load(n).is_graph
        for r in REALS
    ]  # type: ignore[arg-type]
    home = HOMES["zhang2009"]
    return [
        *plain,
        *(
            (f"{n}_{r}", n, Options(r, given=given, find=find))
            for n, (given, find) in MAPS.items()
            for r in REALS
        ),  # type: ignore[arg-type]
        (
            "zhang2009_float_home_relative",
            "zhang2009",
            Options("float", home_relative=True, home=home),
        ),
        ("zhang2009_double_struct", "zhang2009", Options("double", geometry="struct", home=home)),
    ]


def folder_of(name: str) -> Path:
    """A folder by its name; one that is not committed is written when it is first asked for,
    without measured figures: beside its place and moved there whole, because another process may
    be quicker.
    """
    if name in COMMITTED:
        return HERE / name
    place = _place() / name
    if not place.exists():
        place.parent.mkdir(parents=True, exist_ok=True)
        source, options = {folder: (m, o) for folder, m, o in variants()}[name]
        with tempfile.TemporaryDirectory(dir=place.parent) as scratch:
            written = Path(scratch) / name
            write_folder(load(source), written, options)
            try:
                written.rename(place)
            except OSError:
                if not place.exists():
                    raise
    return place


def folders_of(names: Sequence[str]) -> Iterator[Path]:
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


def digest_of(files: Mapping[str, str]) -> str:
    """SHA-256 of what is the same on every processor of a folder's text (without measured
    figures).
    """
    kept = {
        name: text
        for name, text in files.items()
        if name != MANIFEST and not name.endswith("_vectors.h")
    }
    return digest(
        "".join(f"{name}\n{stable(text)}" for name, text in sorted(kept.items())).encode()
    )


def stable(text: str) -> str:
    """A text with its numbers to nine digits."""
    return _NUMBER.sub(lambda found: f"{float(found[0]):.8e}", text)


def write(place: Path, chosen: Collection[str]) -> None:
    """Writes some of the folders, with the figures that were measured of them."""
    for folder, name, options in variants():
        if folder in chosen:
            write_folder(load(name), place / folder, options, MEASURED.get(folder))
            print(folder, flush=True)


def write_digests(chosen: Collection[str]) -> None:
    """Writes digests.json, with new digests of some of the folders."""
    found = json.loads(DIGESTS.read_text())
    for folder, name, options in variants():
        if folder in chosen:
            found[folder] = digest_of(folder_files(load(name), options))
            print(f"{folder} {found[folder]}", flush=True)
    held = {folder for folder, _, _ in variants()} - set(COMMITTED)
    DIGESTS.write_text(
        json.dumps({folder: found[folder] for folder in sorted(held & found.keys())}, indent=1)
        + "\n"
    )


def main() -> None:
    names = [folder for folder, _, _ in variants()]
    parser = argparse.ArgumentParser(
        description=(
            "Write the committed folders of C and the digests of the others, or all folders "
            "elsewhere."
        )
    )
    parser.add_argument("folders", nargs="*", metavar="FOLDER", help="these alone")
    parser.add_argument(
        "--all",
        action="store_true",
        help="write folders that are not committed too, and no digests; needs -o",
    )
    parser.add_argument(
        "-o", type=Path, metavar="DIR", help="where to write (default: beside this script)"
    )
    given = parser.parse_args()
    unknown = sorted(set(given.folders) - set(names))
    if unknown:
        parser.error(f"{', '.join(unknown)}: no such folder; there are {', '.join(names)}")
    if given.all and given.o is None:
        parser.error("--all needs -o DIR: beside this script stand the committed folders alone")
    chosen = set(given.folders or names)
    write(given.o or HERE, chosen if given.all else chosen & set(COMMITTED))
    if given.o is None:
        write_digests(chosen - set(COMMITTED))


if __name__ == "__main__":
    main()
