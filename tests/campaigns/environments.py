"""Hostile environments: Ctrl-C at any moment, small stacks, large machines and large tables.

    python tests/campaigns/environments.py [NAME ...] [--count 100] [--seed 0]

Each part runs commands or scripts in processes of their own and says what went otherwise than
docs/reference/python.md promises; exit status 1 where anything did. `interrupts` takes `--count`
presses; what a press meets before a line of symkin has run is Python's own start.
"""

from __future__ import annotations

import argparse
import random
import resource
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

TESTS = Path(__file__).resolve().parents[1]
START_S = 0.06
"""Seconds that Python takes to start on an idle machine, before it runs anything of symkin's."""
COMMANDS = (
    ("modes", "ren2008"),
    ("sweep", "four_bar", "--grid", "crank=0:350:2000", "--workers", "2", "-o", "map"),
    ("modes", "klann_leg", "--plot", "picture.png"),
)
CHAIN = """
import sys, threading
import symkin
def chain():
    links = ["base", *(f"link{k}" for k in range(200))]
    joints = [symkin.LinkJoint(symkin.Joint(f"q{k}", "R", (k, 0, 0), (0, 0, 1), actuated=True),
                               (a, b)) for k, (a, b) in enumerate(zip(links, links[1:]))]
    machine = symkin.Mechanism("chain", link_joints=joints)
    assert len(symkin.modes(machine)) == 1
    assert symkin.mobility(machine).mobility == 200
    symkin.load(symkin.convert(machine, sys.argv[1] + "/chain.urdf"))
    done.append(0)
done = []
threading.stack_size(512 * 1024)
thread = threading.Thread(target=chain)
thread.start(); thread.join()
sys.exit(not done)
"""
TABLE = """
import resource, sys
import numpy as np
from helpers.inside import table_rows, write_table
columns = [np.random.default_rng(k).random(10**6) for k in range(20)]
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
write_table(sys.argv[1] + "/table.csv", [f"c{k}" for k in range(20)], table_rows(columns))
more = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
sys.exit(more > 100 and f"{more:.0f} MB more for a table of a million rows")
"""

LOOPS = """
import resource, sys, time
import numpy as np
import symkin
rng, joints = np.random.default_rng(0), []
for k in range(250):
    base, crank, rocker = (size + rng.uniform(-0.2, 0.2) for size in (4.0, 1.0, 2.5))
    a = np.array([10.0 * k, 0.0])
    points = (a, a + [0.0, crank], a + [base, rocker], a + [base, 0.0])
    ends = (("base", f"crank{k}"), (f"crank{k}", f"coupler{k}"), (f"coupler{k}", f"rocker{k}"),
            ("base", f"rocker{k}"))
    for name, point, links in zip("abcd", points, ends):
        joint = symkin.Joint(f"{name}{k}", "R", (*point, 0), (0, 0, 1), actuated=name == "a")
        joints.append(symkin.LinkJoint(joint, links))
machine = symkin.Mechanism("loops", link_joints=joints)
begin = time.process_time()
assert symkin.modes(machine, given={f"a{k}": 0.1 for k in range(250)}).count == 2**250
spent = time.process_time() - begin
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
sys.exit((spent > 10 or peak > 1000) and f"250 loops: {spent:.0f} s, {peak:.0f} MB")
"""


def interrupts(count: int, seed: int) -> Iterator[str]:
    """Ctrl-C at random moments of three commands: one sentence and status 130, or all done."""
    rng, met = random.Random(seed), Counter[str]()
    for k in range(count):
        with TemporaryDirectory() as folder:
            process = subprocess.Popen(
                [sys.executable, "-m", "symkin", *COMMANDS[k % len(COMMANDS)]],
                cwd=folder,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
            )
            time.sleep(START_S + 3.0 * rng.random())
            process.send_signal(signal.SIGINT)
            _, said = process.communicate(timeout=60)
            ends_well = process.returncode == 130 and "symkin: interrupted" in said
            if "Traceback" in said and "symkin" not in said:
                continue  # a loaded machine: Python had not yet begun with symkin
            if "Traceback" in said or not (ends_well or process.returncode == 0):
                met[f"status {process.returncode}: {said.strip()[-200:]}"] += 1
    yield from (f"{number} of {count} presses: {what}" for what, number in met.items())


def small_stacks(_count: int, _seed: int) -> Iterator[str]:
    """Two hundred joints in a thread with 512 kB of stack."""
    yield from _script(CHAIN)


def many_loops(_count: int, _seed: int) -> Iterator[str]:
    """A thousand joints in 250 loops within 10 s of one processor and 1 GB."""
    yield from _script(LOOPS)


def large_tables(_count: int, _seed: int) -> Iterator[str]:
    """A million rows of twenty columns within 100 MB beside the arrays."""
    yield from _script(TABLE)


def _script(code: str) -> Iterator[str]:
    with TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, "-c", code, folder],
            cwd=TESTS,
            capture_output=True,
            text=True,
            check=False,
        )
    if done.returncode:
        yield f"status {done.returncode}: {done.stderr.strip()[-300:]}"


PARTS: dict[str, Callable[[int, int], Iterator[str]]] = {
    part.__name__: part for part in (interrupts, small_stacks, many_loops, large_tables)
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("names", nargs="*", choices=[[], *PARTS], metavar="NAME")
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    wrong = False
    for name in arguments.names or PARTS:
        begin = time.perf_counter()
        found = list(PARTS[name](arguments.count, arguments.seed))
        wrong |= bool(found)
        print(f"{name} (seed {arguments.seed}): {len(found)} faults, {_elapsed(begin)}")
        print("".join(f"  {line}\n" for line in found), end="", flush=True)
    sys.exit(wrong)


def _elapsed(begin: float) -> str:
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    return f"{time.perf_counter() - begin:.0f} s, largest process {peak:.0f} MB"


if __name__ == "__main__":
    main()
