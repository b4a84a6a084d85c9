"""Threads: every verb may be called from several at once, on one mechanism or many.

What eight threads find is what one finds, bit for bit. The threads run in a process of their own,
since a fault of native code ends the process.
"""

import json
import os
import re
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from helpers.inside import cached_property, lru_cache, not_waiting

WORK = Path(__file__).parents[1] / "helpers" / "thread_work.py"


def _run(folder, *arguments, code=None):
    folder.mkdir(parents=True)
    command = [
        sys.executable,
        "-X",
        "faulthandler",
        *(["-c", code] if code else [str(WORK), *arguments, str(folder)]),
    ]
    environment = os.environ | {
        "SYMKIN_CACHE": str(folder.parent / "cache"),
        "SYMKIN_ENGINE": "numpy",
        "PYTHONPATH": str(WORK.parents[1]),
    }
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=600, env=environment, check=False
    )
    assert done.returncode == 0, f"status {done.returncode}: {done.stderr[-2000:]}"
    return folder / "found.json"


@pytest.mark.long
@pytest.mark.slow
def test_eight_threads_find_what_one_finds(tmp_path):
    """All verbs on a shared mechanism and on others, from a first call that all threads make
    together.
    """
    many = json.loads(_run(tmp_path / "many", "8").read_text())
    one = json.loads(_run(tmp_path / "one", "1").read_text())
    assert many.keys() == one.keys()
    assert [key for key in one if many[key] != one[key]] == []


SOLVING = """
import sys, threading
import symkin
sys.setswitchinterval(1e-5)
platform = symkin.load("zhang2009")
problems = [[144.6 + 0.01 * k, 347.0, 110.3, 178.6, 277.6, 269.4] for k in range(20)]
found = {}
def solve(number):
    found[number] = [symkin.solve(platform, joints=q,
      solver=SOLVER).solution.position.tolist() for q in problems]
threads = [threading.Thread(target=solve, args=(number,)) for number in range(8)]
[t.start() for t in threads]
[t.join() for t in threads]
solve("alone")
sys.exit(any(found[number] != found["alone"] for number in range(8)))
"""


@pytest.mark.slow
@pytest.mark.parametrize("solver", ["newton", "fast_newton", "ipopt"])
def test_solvers_are_not_called_by_two_threads_at_once(tmp_path, solver):
    """Eight threads solve twenty problems of one platform each, from the first call on."""
    _run(tmp_path / solver, code=f"SOLVER = {solver!r}\n{SOLVING}")


# --- caches ---------------------------------------------------------------------------------------


def _in_threads(call, count=8):
    barrier, values = threading.Barrier(count), [None] * count

    def run(k):
        barrier.wait()
        values[k] = call(k)

    threads = [threading.Thread(target=run, args=(k,)) for k in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(30)
    return values


def test_a_cached_value_is_computed_once_for_all_threads():
    """Threads that miss together get one object, of one computation; other keys are other
    values.
    """
    calls = []

    @lru_cache(maxsize=4)
    def value(key):
        calls.append(key)
        time.sleep(0.05)
        return object()

    found = _in_threads(lambda k: value(k % 2))
    assert sorted(calls) == [0, 1]
    assert len(set(map(id, found))) == 2
    assert [found[k] is value(k % 2) for k in range(8)] == [True] * 8


def test_a_cached_property_is_computed_once_and_leaves_no_lock_behind():
    class Holder:
        calls = 0

        @cached_property
        def value(self):
            Holder.calls += 1
            time.sleep(0.05)
            return object()

    holder = Holder()
    found = _in_threads(lambda _: holder.value)
    assert Holder.calls == 1
    assert len(set(map(id, found))) == 1
    assert list(vars(holder)) == ["value"]


def test_a_failed_computation_is_tried_again():
    tries = []

    @lru_cache(maxsize=4)
    def value():
        tries.append(0)
        if len(tries) == 1:
            raise ValueError("first")
        return len(tries)

    with pytest.raises(ValueError, match="first"):
        value()
    assert value() == value() == 2


def test_a_thread_that_holds_a_lock_does_not_wait_for_one_that_wants_it():
    """A value that needs a lock is asked for by a thread that holds it: both get the value that was
    kept first.
    """
    lock, begun = threading.RLock(), threading.Event()

    @lru_cache(maxsize=4)
    def value():
        begun.set()
        with lock:
            return object()

    def hold(_):
        with lock, not_waiting():
            other.start()
            assert begun.wait(10)
            return value()

    later = []
    other = threading.Thread(target=lambda: later.append(value()))
    held = _in_threads(hold, 1)[0]
    other.join(10)
    assert later == [held]
    assert value() is held


FORKING = """
import os, sys, threading, time, warnings
from helpers.inside import cached_property, drawing, lru_cache

warnings.simplefilter("ignore", DeprecationWarning)  # a fork beside threads

@lru_cache(maxsize=4)
def value():
    begun.set()
    time.sleep(0.0 if os.getpid() != parent else 60.0)
    return 1

class Holder:
    @cached_property
    def value(self):
        return value()

def draw():
    with drawing():
        begun.set()
        time.sleep(60.0)

parent, holder = os.getpid(), Holder()
compute = lambda: holder.value
for target, in_child in ((compute, compute), (draw, lambda: drawing().__enter__())):
    begun = threading.Event()
    threading.Thread(target=target, daemon=True).start()
    assert begun.wait(30)
    child = os.fork()
    if child == 0:
        in_child()
        os._exit(7)
    for _ in range(300):
        pid, status = os.waitpid(child, os.WNOHANG)
        if pid:
            break
        time.sleep(0.1)
    else:
        os.kill(child, 9)
        sys.exit("the child waits for a thread that it does not have")
    assert os.waitstatus_to_exitcode(status) == 7
os._exit(0)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
def test_a_forked_child_waits_for_no_thread_of_its_parent(tmp_path):
    """A thread of the parent computes a value, or draws; the child does both by itself."""
    _run(tmp_path / "forked", code=FORKING)


def test_no_cache_of_functools_is_used():
    """They may compute a value twice, and give two threads two sets of symbols;
    `symkin.computed_once` has what stands for them.
    """
    package = Path(__file__).parents[2] / "symkin"
    pattern = re.compile(r"^from functools import .*(cache|cached_property)|functools\.cache", re.M)
    assert [p.name for p in package.rglob("*.py") if pattern.search(p.read_text())] == []
