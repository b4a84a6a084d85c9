"""All modes by continuation beside a reference kernel in the same process, and beside PHCpack where
it is installed.

    python benchmarks/enumeration.py [--inputs 100] [--seed 0] [--cases 6-6,delta]
        [--engines compiled,numpy] [--peer-timeout 120]

T is the median time of `numpy.linalg.solve` on a batch of 40 complex 8 x 8 systems. It is measured
before each input, and the cases take turns, so that a busy machine slows all alike; multiples of T
are medians of such ratios. Times are those of the processor, so that other programs do not count,
but for first answers. Each engine runs in a process of its own with one thread and an empty cache.
The columns:

  first s    the first answer of a mechanism never seen, at most 3 s for platforms on six rods and
             30 s for others; "kept": the package carries its start
  all        one call of `symkin.modes` once the start is kept, certified, medians over random
             inputs that are drawn before the clock starts; `most`: what it may take, in T
             (! above); of it `paths T` for the paths and `proofs T` for certificates
  each       the same inputs in one call of `symkin.modes` with arrays, of each input
  limit      most that the paths may take, in T
  table      a prototype of one generic engine in NumPy, in T: many instances at once / one instance
  unresolved, miscounted   inputs with an unresolved path, or with another number of complex
             solutions than the generic one
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

import symkin
from cases import QUICK, Case, all_cases
from timing import Figure, ReferenceKernel, verdict

ENGINES = ("compiled", "numpy")
MOST_WHOLE = {True: 130.0, False: 80.0}
"""Most that one certified answer may take once the start is kept, in T: Dietmaier's 40 modes,
others.
"""
FIRST_S = {True: 3.0, False: 30.0}
"""Most that a first answer may take: platforms on six rods, others."""
PEER_S = 120.0
"""Seconds that PHCpack may take for one system, unless an option says otherwise."""
PROOFS_T = 15.0
"""Most that certificates of 40 modes may take, in T."""


def main() -> None:
    options = arguments()
    if options.child:
        run_engine(options)
        return
    print(f"{options.inputs} inputs a case, seed {options.seed}, NumPy {np.__version__}")
    single = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    for engine in options.engines.split(","):
        with tempfile.TemporaryDirectory() as folder:
            own = {"SYMKIN_CACHE": folder} | (
                {"SYMKIN_ENGINE": "numpy"} if engine == "numpy" else {}
            )
            subprocess.run(
                [sys.executable, __file__, *sys.argv[1:], "--child", engine],
                env=os.environ | single | own,
                check=True,
            )
    run_peer(options)


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--inputs", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--cases", default="", help="parts of names, separated by commas; default: all"
    )
    parser.add_argument("--engines", default=",".join(ENGINES), help=f"of {', '.join(ENGINES)}")
    parser.add_argument(
        "--peer-timeout",
        type=float,
        default=PEER_S,
        help="seconds for each system of PHCpack; 0 leaves it out",
    )
    parser.add_argument("--child", choices=ENGINES, help=argparse.SUPPRESS)
    return parser.parse_args()


# --- one engine -----------------------------------------------------------------------------------


@dataclass
class Clock:
    """Seconds spent within functions of the package, and the last arguments of one."""

    seconds: float = 0.0
    arguments: tuple[Any, ...] = ()

    def wrap(self, module: Any, name: str) -> None:
        """Replace a function by one that is timed; nothing where the package has none of this
        name.
        """
        function: Callable[..., Any] | None = getattr(module, name, None)
        if function is None:
            return

        def timed(*args: Any, **named: Any) -> Any:
            begin = time.process_time()
            try:
                return function(*args, **named)
            finally:
                self.seconds += time.process_time() - begin
                self.arguments = args

        setattr(module, name, timed)


@dataclass
class Measured:
    """Of one case: seconds of the first answer, and for each input seconds of all, of paths and of
    proofs, and T.
    """

    case: Case
    first: float = 0.0
    whole: list[float] = field(default_factory=list)
    paths: list[float] = field(default_factory=list)
    proofs: list[float] = field(default_factory=list)
    together: float = float("nan")
    kernel: list[float] = field(default_factory=list)
    certified: list[int] = field(default_factory=list)
    real: list[int] = field(default_factory=list)
    unresolved: int = 0
    miscounted: int = 0
    engine: str = ""

    def in_kernels(self, seconds: list[float]) -> float:
        return statistics.median(s / t for s, t in zip(seconds, self.kernel, strict=True))


def run_engine(options: argparse.Namespace) -> None:
    chosen = [
        c
        for c in all_cases(options.seed)
        if any(part in c.name for part in options.cases.split(","))
    ]
    print_table(options.child, measure(chosen, options.inputs, options.seed))


def measure(chosen: Sequence[Case], inputs: int, seed: int) -> list[Measured]:
    """Time all answers of some cases, which take turns, in this process with its engine and its
    cache.
    """
    from symkin.assembly import block_paths, continuation
    from symkin.assembly.prover import Prover

    paths, proofs, rng = Clock(), Clock(), np.random.default_rng(seed)
    paths.wrap(block_paths, "plain_instances")
    paths.wrap(continuation, "instance")
    for name in ("ends", "proofs"):
        proofs.wrap(Prover, name)
    done = [Measured(case) for case in chosen]
    given = {m.case.name: [m.case.draw(rng) for _ in range(inputs + 1)] for m in done}
    kernel = ReferenceKernel()
    for m in done:
        begin = time.perf_counter()
        symkin.modes(replace(m.case.mechanism, title="benchmark"), **given[m.case.name][0])
        m.first, m.engine = time.perf_counter() - begin, engine_of(paths.arguments)
    for k in range(1, inputs + 1):
        for m in done:
            paths.seconds = proofs.seconds = 0.0
            m.kernel.append(kernel.seconds(20))
            begin = time.process_time()
            found = symkin.modes(m.case.mechanism, **given[m.case.name][k])
            m.whole.append(time.process_time() - begin)
            m.paths.append(paths.seconds)
            m.proofs.append(proofs.seconds)
            m.real.append(len(found))
            m.certified.append(sum(mode.certified is True for mode in found))
            m.unresolved += bool(found.unresolved_paths)
            m.miscounted += found.complex_count != m.case.complex_count
    for m in done:
        begin, rows = time.process_time(), given[m.case.name][1:]
        symkin.modes(m.case.mechanism, **{key: [row[key] for row in rows] for key in rows[0]})
        m.together = (time.process_time() - begin) / len(rows) / statistics.median(m.kernel)
    return done


def figures(*, quick: bool, seed: int) -> Iterator[Figure]:
    """One answer, and each of many in one call, in multiples of T; inputs that were miscounted;
    PHCpack's time.
    """
    chosen = [c for c in all_cases(seed) if not quick or c.name in QUICK]
    done = measure(chosen, 8 if quick else 60, seed)
    for m in done:
        name = f"enumeration: {m.case.name}"
        yield Figure(
            f"{name}, one answer",
            m.in_kernels(m.whole),
            f"T; {1e3 * statistics.median(m.whole):.1f} ms",
        )
        yield Figure(f"{name}, each of many", m.together, "T")
    wrong = sum(m.unresolved + m.miscounted for m in done)
    yield Figure(
        "enumeration: inputs miscounted or unresolved",
        wrong,
        f"of {sum(len(m.whole) for m in done)}",
    )
    yield from peer_figures(done, seed)


def engine_of(instance_arguments: tuple[Any, ...]) -> str:
    """What tracks the system that `instance` was last called with."""
    try:
        from symkin.homotopy.engine import engine_of

        return engine_of(instance_arguments[0])[1]
    except (ImportError, IndexError):
        return "NumPy"


def print_table(engine: str, done: list[Measured]) -> None:
    kernel = statistics.median(t for m in done for t in m.kernel)
    print(f"\nengine {engine}: T = {1e6 * kernel:.1f} us (median)")
    head = (
        f"{'case':18}{'first s':>9} {'':6}{'all ms':>8}{'all T':>7} "
        f"{'most':>5}{'paths T':>9}{'limit':>7} {'':6}{'proofs T':>9}"
        f"{'each T':>8}  {'table':>15}{'complex':>9}{'real':>6}"
        f"{'certified':>11}{'unresolved':>12}{'miscounted':>12}  tracked by"
    )
    print(head)
    for m in done:
        print_row(engine, m)
    print(f"certificates of 40 modes may take {PROOFS_T:.0f} T", flush=True)


def print_row(engine: str, m: Measured) -> None:
    case, inputs = m.case, len(m.whole)
    limit, table = case.limit(engine), case.table()
    whole, paths = 1e3 * statistics.median(m.whole), m.in_kernels(m.paths)
    first = "kept" if case.shipped else verdict(m.first <= FIRST_S[case.six_distances])
    bound = "" if limit is None else f"{limit:.0f}"
    within = "" if limit is None else verdict(paths <= limit)
    figures = "" if table is None else f"{table[0]:.0f} / {table[1]:.0f}"
    most = MOST_WHOLE[case.name == "dietmaier1998"]
    slow = "" if m.in_kernels(m.whole) <= most else "!"
    print(
        f"{case.name:18}{m.first:9.2f} {first:6}{whole:8.1f}{m.in_kernels(m.whole):7.0f}{slow:1}"
        f"{most:5.0f}{paths:9.0f}{bound:>7} {within:6}"
        f"{m.in_kernels(m.proofs):9.1f}{m.together:8.1f}  "
        f"{figures:>15}{case.complex_count:9d}{statistics.mean(m.real):6.1f}"
        f"{sum(m.certified):6d}/{sum(m.real):<5d}{m.unresolved:6d}/{inputs:<5d}"
        f"{m.miscounted:6d}/{inputs:<5d}  {m.engine}"
    )


# --- the peer -------------------------------------------------------------------------------------


def peer_figures(done: Sequence[Measured], seed: int) -> Iterator[Figure]:
    """One answer over PHCpack's, for platforms on six rods."""
    import phcpack

    for m in (m for m in done if m.case.six_distances):
        name = f"enumeration: {m.case.name}, one answer over PHCpack's"
        if not phcpack.installed():
            yield Figure(name, None, "PHCpack is not installed (Debian package phcpack)")
            continue
        legs = np.asarray(m.case.draw(np.random.default_rng(seed))["joints"])
        answer = phcpack.solve(m.case.mechanism, legs, seed, PEER_S)
        if answer is None:
            yield Figure(name, None, f"PHCpack has no answer within {PEER_S:.0f} s")
        else:
            yield Figure(
                name, statistics.median(m.whole) / answer.seconds, f"{answer.seconds:.2f} s there"
            )


def run_peer(options: argparse.Namespace) -> None:
    import phcpack

    if options.peer_timeout <= 0:
        return
    if not phcpack.installed():
        print("\nPHCpack is not installed (Debian package phcpack): no peer in this run")
        return
    platforms = [
        c
        for c in all_cases(options.seed)
        if c.six_distances and any(p in c.name for p in options.cases.split(","))
    ]
    rng, kernel = np.random.default_rng(options.seed), ReferenceKernel()
    print(
        "\n"
        "peer: PHCpack (phc -b), one run each in a process of its own, first input of each platform"
    )
    for case in platforms:
        legs = np.asarray(case.draw(rng)["joints"])
        unit, answer = (
            kernel.seconds(300),
            phcpack.solve(case.mechanism, legs, options.seed, options.peer_timeout),
        )
        if answer is None:
            print(f"{case.name:18}no answer within {options.peer_timeout:.0f} s")
            continue
        found = f"{answer.complex_count} complex poses of {case.complex_count}, {answer.real} real"
        print(
            f"{case.name:18}{answer.seconds:8.2f} s {answer.seconds / unit:10.0f} T   {found}   "
            f"{answer.version}",
            flush=True,
        )


if __name__ == "__main__":
    main()
