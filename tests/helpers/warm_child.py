"""Answer what MuJoCo's compiler says of a file from a process that has loaded it, in place of one
that is started for each file.

This file is both ends. `answer_of` asks a process that forks for each question, so that what a file
does to the compiler harms no other question. Where a fork gives no answer, the question goes to the
child of the package itself (`formats/child.py`), and its words are what the caller hears.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

_STARTED: dict[str, subprocess.Popen[str]] = {}
"""The process of each worker's file, as long as the tests run."""


def answer_of(
    cold: Callable[[Path, Mapping[str, Any]], Any], worker: Path, task: Mapping[str, Any]
) -> Any:
    """Return what `work` of a worker's file returns; `cold` is asked where a fork ends without an
    answer.
    """
    served = _STARTED.get(str(worker))
    if served is None or served.poll() is not None:
        command = [
            sys.executable,
            "-P",
            "-W",
            "ignore",
            __file__,
            str(worker),
            json.dumps(sys.path),
        ]
        served = _STARTED[str(worker)] = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            cwd="/",
        )
    assert served.stdin is not None
    assert served.stdout is not None
    served.stdin.write(json.dumps({"folder": os.getcwd(), "task": task}) + "\n")
    served.stdin.flush()
    line = served.stdout.readline()
    return json.loads(line) if line.strip() else cold(worker, task)


# --- the process that is asked --------------------------------------------------------------------


def _of_a_fork(child: Any, worker: Any, order: Mapping[str, Any]) -> bytes:
    """Return the answer of a fork of this process, bound as symkin's child is; nothing where it has
    none.
    """
    end, begin = os.pipe()
    fork = os.fork()
    if not fork:
        try:
            os.chdir(order["folder"])
            child._bound_this_process(child.SECONDS, child.MEMORY)
            text = json.dumps(worker.work(order["task"])).encode()
            with os.fdopen(begin, "wb") as pipe:
                pipe.write(text)
            os._exit(0)
        finally:
            os._exit(1)
    os.close(begin)
    with os.fdopen(end, "rb") as pipe:
        text = pipe.read()
    _, status = os.waitpid(fork, 0)
    return text if status == 0 else b""


def _loaded(file: Path) -> Any:
    """Return a module by its file, without the package around it."""
    spec = spec_from_file_location(file.stem, file)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _serve() -> None:
    """Load what the worker needs, then answer a line for each line that is read."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    file = Path(sys.argv[1])
    sys.path[:] = json.loads(sys.argv[2])
    child, worker = _loaded(file.with_name("child.py")), _loaded(file)
    import_module("mujoco")
    for line in sys.stdin:
        answers.write(_of_a_fork(child, worker, json.loads(line)) + b"\n")
        answers.flush()


if __name__ == "__main__":
    _serve()
