"""Run what a foreign library makes of a file in a child process, which may take some time and
memory and may end in any way.

This file is both ends: `answer_of` is called here, and the child runs the file itself. Task and
answer are JSON, so that nothing in an answer is ever run. The child loads the worker by its file,
and so imports no more than the worker needs.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Mapping
from contextlib import suppress
from importlib.util import module_from_spec, spec_from_file_location
from multiprocessing import spawn
from pathlib import Path
from typing import Any

SECONDS = 20.0
"""Time that a file may take: the largest robots that are published take less than two."""
MEMORY = 2e9
"""Bytes of address space of the child, where the system bounds it: what the libraries map
themselves is a tenth.
"""
_LONGEST = 50_000_000
"""Characters of an answer: bodies and joints of a thousand parts take a million."""
_NO_MEMORY = 77
"""Exit status of a child whose memory did not suffice."""
_ONE_THREAD = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL")}


class ChildError(Exception):
    """A child that gave no answer; the text says why, as the end of a sentence."""


def answer_of(worker: Path, task: Mapping[str, Any]) -> Any:
    """What the function `work` of the file `worker` returns for a task, worked out in a child
    process.

    Raises ChildError where the child takes too long or too much memory, or ends otherwise.
    """
    order = {
        "path": sys.path,
        "worker": str(worker),
        "task": task,
        "seconds": SECONDS,
        "memory": MEMORY,
    }
    command = [os.fsdecode(spawn.get_executable()), "-P", "-W", "ignore", __file__]
    try:
        done = subprocess.run(
            command,
            input=json.dumps(order).encode(),
            capture_output=True,
            timeout=SECONDS,
            check=False,
            env=os.environ | _ONE_THREAD,
        )
    except subprocess.TimeoutExpired:
        raise ChildError(f"gave no answer within {SECONDS:g} s") from None
    except (OSError, ValueError) as error:
        raise ChildError(f"could not be started ({error})") from None
    if (
        done.returncode == _NO_MEMORY
        or b"MemoryError" in done.stderr
        or b"bad_alloc" in done.stderr
    ):
        raise ChildError(f"needed more than {MEMORY / 1e9:g} GB of memory")
    try:
        if done.returncode == 0:
            return json.loads(done.stdout)
    except ValueError:
        pass
    raise ChildError(f"ended without an answer ({_ending(done.returncode)})")


def _ending(status: int) -> str:
    """How a process ended: the signal's name, or its exit status."""
    with suppress(ValueError):
        if status < 0:
            return signal.Signals(-status).name
    return f"status {status}"


# --- the child ------------------------------------------------------------------------------------


def _child() -> None:
    """Read the order, bound this process, work, and write the answer where the worker's own prints
    do not go.
    """
    order = json.loads(sys.stdin.buffer.read())
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    _bound_this_process(order["seconds"], order["memory"])
    sys.path[:] = order["path"]
    try:
        text = json.dumps(_loaded(order["worker"]).work(order["task"]))
    except MemoryError:
        os._exit(_NO_MEMORY)
    if len(text) > _LONGEST:
        os._exit(_NO_MEMORY)
    answers.write(text.encode())
    answers.flush()
    os._exit(0)


def _bound_this_process(seconds: float, memory: float) -> None:
    """Bound processor time (the parent may be gone), memory and core files, where the system knows
    such limits.
    """
    try:
        import resource
    except ImportError:
        return
    for kind, most in (
        (resource.RLIMIT_CPU, seconds + 1),
        (resource.RLIMIT_AS, memory),
        (resource.RLIMIT_CORE, 0),
    ):
        with suppress(ValueError, OSError):
            hard = resource.getrlimit(kind)[1]
            wanted = int(most) if hard == resource.RLIM_INFINITY else min(int(most), hard)
            resource.setrlimit(kind, (wanted, wanted))


def _loaded(file: str) -> Any:
    spec = spec_from_file_location("worker", file)
    if spec is None or spec.loader is None:
        raise ImportError(file)
    module = module_from_spec(spec)
    sys.modules["worker"] = module
    spec.loader.exec_module(module)
    return module


if __name__ == "__main__":
    _child()
