"""Does OK of generated C mean the machine, on the branch of the guess, and can it be held?

    python codegen/bench/branches.py [NAME|FILE ...] [--given A,B --find C,D] [--all] [--random N]
        [--part 1/1] [--jobs 1] [--keep FILE] [--range RANGE ...] [--count N] [--legs 2]
        [--steps 400] [--real double] [--seed 0] [--write]

Goals of a range are asked for, and each line from the guess's values to the goal is walked in small
steps by C of its own (walk.c). What is OK must be where the line leads; asked for once more, from
itself, it must be OK too, where the line is regular: none of its steps shorter than 1/25600 of it,
no limb past a dead centre. Ranges:

- small, middle, widest, or PART,TURN (of the size, rad): random goals about home in `--legs`, the
  next from an answer of the one before where that was right, one more from beside the folds at
  which lines stopped. A fifth of what is refused is walked, and tells how many regular lines are.
- anywhere, folds: of arms, from joints anywhere to poses of joints anywhere, and to such at which
  lines graze folds.
- paths: `--count` smooth paths in `--steps`, of maps both ways. Stuck is what is refused on a
  regular line far from singularities, to an answer that tells where it stands, no limb beside a
  dead centre. Anew is a map's answer whose values do not tell where the path stands: it begins at
  home again.
- grazes: lines to where the code refuses, and ever nearer (grazes.py). No OK there may be refused
  as a guess that is not even read.
- closes: values that the machine can take, and others, against the closures of
  tests/oracle/plain_*.py (closes.py); the folder's own test is run first.

Without `--range`: small, middle, widest, of arms anywhere and folds too; of maps and with `--all`
paths, grazes and closes. Without names: those of README.md's table; `--all`: 60 machines, shipped
or not, maps, and random ones (`--random`: so many); `--part 1/4`: every fourth. `--keep FILE` holds
what each came to, and what it holds of the same `--seed` and sizes is not asked again: an
interrupted run goes on, and the lines of several parts' files make one table. Whatever is wrong is
printed with all that repeats it. Exit status 1 where anything is wrong, stuck, unread, does not
stand still, fails its own test, or does not compile.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import sys
import tempfile
from collections import defaultdict
from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from functools import partial
from itertools import islice
from multiprocessing import Pool
from pathlib import Path
from typing import Any

import numpy as np

from asked import Asked
from closes import closes
from directions import PLAIN, directions
from generate import REALS
from grazes import grazed
from ranges import RANGES, range_of
from readme import table, written
from rows import Row, judged
from subjects import STUDIED, drawn, machine_of, named
from symkin.codegen.folder.folder import write_folder
from symkin.errors import InputError

HELD = ("paths", "grazes", "closes")
"""Ranges of all kinds of machines."""
ARMS = ("anywhere", "folds")
"""Ranges of arms alone."""
COUNTS = {"closes": 60, "grazes": 200}
"""Configurations, and lines."""
MACHINES = 60
OWN_TEST = "own test fails"
"""What a refusal says of code that was not written because its test fails."""
SECONDS = 150
"""Processor time after which a machine is left out of a range: formulas of random ones may be
long.
"""
Record = dict[str, Any]
"""What one machine's code of one type came to in one range: `of`, `rows` by what solves its
problems, why it was `left_out`, whether its code `failed` to compile or its own test, and
processor `seconds`, compilers' among them.
"""


# --- one machine ----------------------------------------------------------------------------------


def records(task: tuple[Asked, Sequence[str]], chosen: argparse.Namespace) -> list[Record]:
    """Ask one machine's code of one type in some ranges; what is not in time is left out."""
    asked, words = task
    signal.signal(signal.SIGPROF, _late)
    found = []
    for word in words:
        begun, rows, reason, failed = sum(os.times()[:4]), {}, "", False
        signal.setitimer(signal.ITIMER_PROF, 0 if chosen.named else SECONDS)
        try:
            rows = {by: row.kept() for by, row in _rows(asked, word, chosen)}
        except (InputError, TimeoutError, RuntimeError) as error:
            reason = str(error)[:200]
            failed = isinstance(error, RuntimeError) or OWN_TEST in str(error)
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)
        told = {"of": _key(asked, word, chosen), "left_out": reason, "failed": failed}
        seconds = round(sum(os.times()[:4]) - begun, 1)
        found.append({**told, "seconds": seconds, "rows": rows})
    return found


def _late(*_: object) -> None:
    raise TimeoutError("not in time")


def _key(asked: Asked, word: str, chosen: argparse.Namespace) -> list[Any]:
    """What a record is of."""
    sizes = [chosen.seed, chosen.count, chosen.legs, chosen.steps]
    sides = [*asked.options.given, *asked.options.find]
    return [asked.mechanism.name, asked.options.real, word, *sizes, *sides]


def _rows(asked: Asked, word: str, chosen: argparse.Namespace) -> Iterator[tuple[str, Row]]:
    """What solves a problem, and what the range came to, of a map both ways."""
    count, seed = chosen.count or COUNTS.get(word, 0), chosen.seed
    if word == "closes":
        with tempfile.TemporaryDirectory() as folder:
            write_folder(asked.mechanism, Path(folder), asked.options)
        yield "closures", closes(asked, count, np.random.default_rng(seed))
    elif word == "grazes":
        for lines in directions(asked, PLAIN):
            yield lines.solved_by, grazed(lines, count, np.random.default_rng(seed))
    else:
        sent = range_of(word, chosen.legs, chosen.steps)
        for lines in directions(asked, sent.longest):
            goals = sent.outcomes(lines, count or sent.count, np.random.default_rng(seed))
            yield lines.solved_by, judged(lines, goals)


# --- the campaign ---------------------------------------------------------------------------------


def machines_of(chosen: argparse.Namespace, scratch: Path) -> Iterator[Asked]:
    """The named machines; else all kinds, random ones among them."""
    if chosen.named:
        for name in chosen.names or STUDIED:
            yield machine_of(name, chosen.given, chosen.find)
        return
    number, count = (int(v) for v in chosen.part.split("/"))
    every = list(named()) if chosen.all else []
    drawn_count = MACHINES - len(every) if chosen.random is None else chosen.random
    yield from [*every, *islice(drawn(chosen.seed, scratch), drawn_count)][number - 1 :: count]


def ranges_of(asked: Asked, chosen: argparse.Namespace) -> list[str]:
    """The ranges in which a machine is asked."""
    if chosen.range:
        return [w for w in chosen.range if w not in ARMS or asked.kind == "arm"]
    if not chosen.named or asked.kind == "map":
        return list(HELD)
    return [*RANGES, *(ARMS if asked.kind == "arm" else ())]


def tasks(
    chosen: argparse.Namespace, kept: Sequence[Record], scratch: Path
) -> Iterator[tuple[Asked, list[str]]]:
    """Machines of each type, and the ranges of which nothing is kept."""
    done = [record["of"] for record in kept]
    for machine in machines_of(chosen, scratch):
        for asked in map(machine.of, chosen.real):
            words = ranges_of(asked, chosen)
            yield asked, [word for word in words if _key(asked, word, chosen) not in done]


def said(record: Record) -> str:
    """What is printed of one record."""
    head = " ".join(record["of"][:3])
    if record["left_out"]:
        return f"{head}: left out: {record['left_out']}"
    lines = []
    for by, row in record["rows"].items():
        told = (f"{name} {cell}" for name, cell in Row.of(row).cells().items() if cell)
        lines += [", ".join([f"{head}, {by}", *told, f"{record['seconds']} s"])]
        lines += [f"    {words}" for words in row["said"]]
    return "\n".join(lines)


def campaign_table(found: Sequence[Record], *, by_range: bool) -> tuple[str, Row]:
    """The table of all records, ranges apart or together, and the sum of its rows."""
    rows, total = defaultdict[tuple[str, ...], Row](Row), Row()
    for record in found:
        name, real, word = record["of"][:3]
        for by, row in record["rows"].items():
            rows[(name, by, real, word)[: 4 if by_range else 3]].add(Row.of(row))
            total.add(Row.of(row))
    names = ("machine", "solved by", "type", "range")[: 4 if by_range else 3]
    heads = [head for head, cell in total.cells().items() if cell]
    told = [*sorted(rows.items()), (("all", *("" for _ in names[1:])), total)]
    cells = ([*key, *(row.cells()[head] for head in heads)] for key, row in told)
    return table([*names, *heads], cells), total


def asked_for() -> argparse.Namespace:
    """The options of the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*")
    parser.add_argument("--given")
    parser.add_argument("--find")
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--random", type=int)
    parser.add_argument("--part", default="1/1")
    parser.add_argument("--keep", type=Path, metavar="FILE")
    parser.add_argument("--range", nargs="*", metavar="RANGE")
    for option, usual in (("jobs", 1), ("count", 0), ("legs", 2), ("steps", 400), ("seed", 0)):
        parser.add_argument(f"--{option}", type=int, default=usual)
    parser.add_argument("--real", nargs="*", choices=REALS, default=list(REALS))
    parser.add_argument("--write", action="store_true", help="the table of codegen/README.md")
    chosen = parser.parse_args()
    chosen.named = not chosen.all and not chosen.random
    return chosen


def kept_in(file: Path) -> list[dict]:
    """Records of a run before; a last line that it had no time to end is cut off."""
    whole = "".join(line for line in file.read_text().splitlines(True) if line.endswith("\n"))
    file.write_text(whole)
    return list(map(json.loads, whole.splitlines()))


def main() -> int:
    chosen = asked_for()
    found = kept_in(chosen.keep) if chosen.keep and chosen.keep.exists() else []
    ignored = partial(signal.signal, signal.SIGINT, signal.SIG_IGN)
    many = Pool(chosen.jobs, ignored) if chosen.jobs > 1 else nullcontext()
    with tempfile.TemporaryDirectory() as scratch, many as pool:
        asking = list(tasks(chosen, found, Path(scratch)))
        each = pool.imap_unordered if pool else map
        try:
            for some in each(partial(records, chosen=chosen), asking):
                found += some
                for record in some:
                    print(said(record), flush=True)
                if chosen.keep:
                    with chosen.keep.open("a") as file:
                        file.writelines(f"{json.dumps(record)}\n" for record in some)
        except KeyboardInterrupt:
            print("interrupted")
    told, total = campaign_table(found, by_range=chosen.named)
    failed = sorted({" ".join(record["of"][:2]) for record in found if record["failed"]})
    print(f"{told}\nown test fails, or a compiler: {', '.join(failed) or 'none'}")
    print(f"seed {chosen.seed}; {sum(record['seconds'] for record in found):,.0f} s of processors")
    if chosen.write:
        written("branches", f"Seed {chosen.seed}, {chosen.count or 2000:,} goals a leg.\n\n{told}")
    return 0 if total.is_good and not failed else 1


if __name__ == "__main__":
    sys.exit(main())
