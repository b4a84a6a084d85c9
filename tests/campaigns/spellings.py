"""One machine in many spellings: are its modes, its counts, statements, certificates and times one?

    python tests/campaigns/spellings.py [--machine NAME ...] [--spelling NAME ...] [--json]
        [--direction direct inverse] [--seed 0] [--jobs 1] [--limit 120]

Each machine is asked in both directions, in every spelling that it has: limbs and graph, with the
motion declared and without, joints and DH, MJCF and URDF, R R for U, another unit, order, place,
reference and size, a named point. Modes are compared as places of links, turned back to the first
spelling of their kind. Times are processor times of warm calls, medians of batches, told with their
ratio to the least of their kind. Where two lists of modes differ, independent closures and
random starts (`twin_oracle`) say of each mode whether it closes and of each configuration found
whether it is listed. Exit status 1 where modes, statements, complex counts or certificates differ.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import tempfile
import time
import tomllib
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import symkin
from campaigns.children import run_each
from campaigns.twin_oracle import CLOSED, Oracle, numbers_only, oracle_of
from campaigns.twin_oracle import SAME as SAME_FEATURES
from helpers.spellings import MACHINES, Machine, Spelling, lacking, named, spellings

DIRECTIONS = ("direct", "inverse")
BATCHES, BATCH_S = 5, 0.1
"""Batches of warm calls whose median is told, and seconds of each, one call at least."""
STARTS = 600
"""Random starts of the independent search."""


@dataclass
class Answer:
    """What one spelling answers in one direction; `away` tells how many modes it lacks of the first
    spelling of its kind, and how many more it has.
    """

    machine: str
    direction: str
    spelling: str
    kind: str
    modes: int = 0
    complex_count: int | None = None
    completeness: str = ""
    certified: int = 0
    method: str = ""
    first_s: float = 0.0
    warm_s: float = float("nan")
    ratio: float = float("nan")
    away: tuple[int, int] = (0, 0)
    notes: tuple[str, ...] = ()
    fault: str | None = None
    verdict: str = ""
    places: dict[str, np.ndarray] = field(default_factory=dict)

    @property
    def claims(self) -> tuple[Any, ...]:
        """What must be the same in all spellings of a kind."""
        told = (self.modes, self.complex_count, self.completeness, self.certified)
        return (*told, self.fault is None)


def asked(machine: Machine, spelling: Spelling, direction: str) -> Answer:
    """What a spelling answers, with the processor time that it takes."""
    inverse = direction == "inverse"
    begin = time.process_time()
    found = spelling.modes(machine, inverse=inverse)
    first = time.process_time() - begin
    return Answer(
        machine.name,
        direction,
        spelling.name,
        spelling.kind,
        modes=len(found),
        complex_count=found.complex_count,
        completeness=found.completeness,
        certified=sum(bool(mode.certified) for mode in found),
        method=found.method,
        first_s=first,
        warm_s=_warm(lambda: spelling.modes(machine, inverse=inverse)),
        notes=found.notes,
        places=spelling.configurations(machine, found),
    )


def _warm(call: Callable[[], object]) -> float:
    """The processor time of a call: the median of batches that coarse clocks can tell."""
    times = []
    for _ in range(BATCHES):
        begin, now, calls = time.process_time(), time.perf_counter(), 0
        while not calls or time.perf_counter() < now + BATCH_S:
            call()
            calls += 1
        times.append((time.process_time() - begin) / calls)
    return statistics.median(times)


# --- who is right ---------------------------------------------------------------------------------


def judged(machine: Machine, spelling: Spelling, direction: str) -> str:
    """What an independent closure of a spelling says of its list: modes that do not close, and
    configurations from random starts that it lacks.
    """
    data = numbers_only(tomllib.loads(spelling.mechanism.to_toml()))
    oracle = oracle_of(data)
    found = spelling.modes(machine, inverse=direction == "inverse")
    fits = [oracle.fitted(_printed(mode)) for mode in found]
    still_open = sum(not left < CLOSED for left, _ in fits)
    listed = [oracle.features(x) for _, x in fits]
    searched = list(oracle.others(_given(oracle, found), STARTS))
    missing = sum(
        all(np.max(np.abs(f - one)) > SAME_FEATURES for one in listed)
        for f in map(oracle.features, searched)
    )
    return (
        f"{still_open} of {len(found)} modes do not close; {STARTS} starts find {len(searched)}, "
        f"{missing} of them missing"
    )


def _printed(mode: symkin.Solution) -> dict[str, Any]:
    pose = [*map(float, mode.position), *map(float, mode.quaternion)]
    return {"pose": pose, "joints": mode.held_joints}


def _given(oracle: Oracle, found: symkin.Modes) -> dict[str, Any]:
    told = found.given
    if "joints" not in told or not isinstance(told["joints"], dict):
        return told
    return {"joints": [told["joints"][name] for name in oracle.actuated]}


# --- the table ------------------------------------------------------------------------------------


def answers(options: argparse.Namespace) -> Iterator[list[Answer]]:
    """The answers of each machine in each direction."""
    for name in options.machine or MACHINES:
        machine = replace(MACHINES[name](), seed=options.seed)
        with tempfile.TemporaryDirectory() as folder:
            spelled = named(list(spellings(machine, Path(folder))), options.spelling)
        for direction in options.direction:
            yield _in_children(machine, spelled, direction, options)


def _in_children(
    machine: Machine, spelled: Sequence[Spelling], direction: str, options: argparse.Namespace
) -> list[Answer]:
    """The answers of all spellings, each in a process of its own, compared and judged."""

    def ask(place: int, send: Callable[[Any], None]) -> None:
        try:
            send(asked(machine, spelled[place], direction))
        except symkin.SymkinError as error:
            send(_empty(machine, spelled[place], direction, f"refused: {error}"))

    found: dict[int, Answer] = {}
    for ended in run_each(range(len(spelled)), ask, options.jobs, options.limit):
        found[ended.task] = (
            ended.sent[0]
            if ended.sent
            else _empty(machine, spelled[ended.task], direction, ended.fault or "no answer")
        )
    table = [found[place] for place in range(len(spelled))]
    first: dict[str, Answer] = {}
    for answer in table:
        alike = (a.warm_s for a in table if a.fault is None and a.kind == answer.kind)
        answer.ratio = answer.warm_s / max(min(alike, default=float("nan")), 1e-9)
        if answer.fault is None:
            home = first.setdefault(answer.kind, answer)
            answer.away = _away(home, answer)
    _judge(machine, spelled, direction, table, options)
    return table


def _away(home: Answer, other: Answer) -> tuple[int, int]:
    counts = (home.modes, other.modes)
    return (
        len(lacking(home.places, other.places, counts)),
        len(lacking(other.places, home.places, counts[::-1])),
    )


def _judge(
    machine: Machine,
    spelled: Sequence[Spelling],
    direction: str,
    table: list[Answer],
    options: argparse.Namespace,
) -> None:
    """Add what the third method says of the first spelling of a kind and of those with other
    modes.
    """
    kinds = {a.kind for a in table if any(a.away)}
    seen: set[tuple[Any, ...]] = set()
    doubtful = []
    for place, answer in enumerate(table):
        key = (answer.kind, answer.away, answer.modes)
        if answer.kind in kinds and answer.fault is None and key not in seen:
            seen.add(key)
            doubtful.append(place)

    def judge(place: int, send: Callable[[Any], None]) -> None:
        try:
            send(judged(machine, spelled[place], direction))
        except Exception as error:
            send(f"the third method failed: {type(error).__name__}: {error}")

    for ended in run_each(doubtful, judge, options.jobs, options.limit):
        table[ended.task].verdict = ended.sent[0] if ended.sent else str(ended.fault)


def _empty(machine: Machine, spelling: Spelling, direction: str, fault: str) -> Answer:
    return Answer(machine.name, direction, spelling.name, spelling.kind, fault=fault)


def differing(table: Sequence[Answer]) -> set[int]:
    """Places of answers that are not those of most spellings of their kind."""
    usual: dict[str, tuple[Any, ...]] = {}
    for kind in {a.kind for a in table}:
        counted = Counter(a.claims for a in table if a.kind == kind)
        usual[kind] = counted.most_common(1)[0][0]
    return {k for k, a in enumerate(table) if a.claims != usual[a.kind] or any(a.away)}


def printed(table: Sequence[Answer]) -> None:
    """Write a table, differences marked."""
    marked = differing(table)
    print(f"\n{table[0].machine}, {table[0].direction}: {len(marked)} of {len(table)} differ")
    for place, a in enumerate(table):
        claims = f"{a.modes:4d} of {a.complex_count!s:>5}  {a.completeness:15} {a.certified:4d}"
        times = f"{1e3 * a.warm_s:9.2f} ms {a.ratio:6.2f}  first {a.first_s:6.2f} s"
        mark = "*" if place in marked else " "
        line = f"{mark} {a.spelling:24} {a.kind:9} "
        line += a.fault[:90] if a.fault else f"{claims}  {times}  {a.method}"
        if any(a.away):
            line += f"; lacks {a.away[0]}, has {a.away[1]} more"
        print(line + (f"\n    {a.verdict}" if a.verdict else ""), flush=True)


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--machine", nargs="*", choices=MACHINES, default=[])
    parser.add_argument("--spelling", nargs="*", default=[], help="names of spellings")
    parser.add_argument("--direction", nargs="*", choices=DIRECTIONS, default=list(DIRECTIONS))
    parser.add_argument("--seed", type=int, default=0, help="of the input")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--limit", type=float, default=120.0, help="seconds a spelling")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(arguments)
    count, told = 0, []
    for table in answers(options):
        count += len(differing(table))
        if options.json:
            told += [{k: v for k, v in asdict(a).items() if k != "places"} for a in table]
        else:
            printed(table)
    if options.json:
        print(json.dumps(told))
    return int(bool(count))


if __name__ == "__main__":
    sys.exit(main())
