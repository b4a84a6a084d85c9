"""Writes one folder of C for each shipped mechanism of limbs, each map between joints and real type into this directory.

    python codegen/generate.py [-o DIR]

The folders are committed; the tests regenerate them and compare byte for byte. measured.json has what bench/worst.py measured; figures of
another code than the one that is written are left out.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from symkin.codegen.folder import write_folder
from symkin.codegen.options import Options
from symkin.formats.load import load
from symkin.model.file import shipped_names

HERE = Path(__file__).parent
HOMES = {"zhang2009": (0.0, 0.0, 420.0, 1.0, 0.0, 0.0, 0.0)}
"""Homes where the file's reference is singular: the middle of the bench's workspace."""
MAPS = {"ankle": (("upper_motor", "lower_motor"), ("ankle.1", "ankle.2"))}
"""Maps between joints: given and found coordinates."""
REALS = ("float", "double")
MEASURED = json.loads((HERE / "measured.json").read_text())
"""Figures of each folder."""


def variants() -> list[tuple[str, str, Options]]:
    """(folder, mechanism, options) of everything that is committed."""
    plain = [(f"{n}_{r}", n, Options(r, home=HOMES.get(n))) for n in shipped_names() if not load(n).is_graph for r in REALS]  # type: ignore[arg-type]
    home = HOMES["zhang2009"]
    return [
        *plain,
        *((f"{n}_{r}", n, Options(r, given=given, find=find)) for n, (given, find) in MAPS.items() for r in REALS),  # type: ignore[arg-type]
        ("zhang2009_float_home_relative", "zhang2009", Options("float", home_relative=True, home=home)),
        ("zhang2009_double_struct", "zhang2009", Options("double", geometry="struct", home=home)),
    ]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Write the committed folders of C.")
    parser.add_argument("-o", default=str(HERE), metavar="DIR", help="where to write (default: beside this script)")
    for folder, name, options in variants():
        write_folder(load(name), Path(parser.parse_args().o) / folder, options, MEASURED.get(folder))
        print(folder)
