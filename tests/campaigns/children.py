"""Run tasks in processes of their own, a few at a time, each with a limit of processor time.

A task that hangs, crashes or is killed ends with a sentence; the others go on. What a task has sent
before its end is kept.
"""

from __future__ import annotations

import math
import multiprocessing
import resource
import signal
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from typing import Any

WALL = 20.0
"""A process that takes so many times its limit of processor time by the clock is ended: it waits
for something."""
POLL_S = 1.0
"""Seconds after which clocks of processes are looked at though none of them has said anything."""

Work = Callable[[Any, Callable[[Any], None]], None]
"""What a child does with its task; it sends its results one by one."""


@dataclass
class Ended:
    """A task with what its process sent, and why the process came to no end of its own (None where
    it did); `late` where that is its limit."""

    task: Any
    sent: list[Any] = field(default_factory=list)
    fault: str | None = None
    late: bool = False


class _Child:
    """One process and the pipe from it."""

    def __init__(self, task: Any, work: Work, limit_s: float) -> None:
        self.ended, self.limit_s = Ended(task), limit_s
        context = multiprocessing.get_context("fork")
        self.pipe, theirs = context.Pipe(duplex=False)
        self.process = context.Process(target=_run, args=(theirs, task, work, limit_s))
        self.process.start()
        theirs.close()
        self.stop = time.monotonic() + WALL * limit_s

    def read(self) -> bool:
        """Take what was sent; whether the child is done."""
        try:
            while self.pipe.poll():
                self.ended.sent.append(self.pipe.recv())
        except (EOFError, OSError):
            self.process.join()
            return True
        return time.monotonic() > self.stop

    def close(self) -> Ended:
        """End the process and say how it ended."""
        late = self.process.is_alive()
        if late:
            self.process.kill()
        self.process.join()
        self.pipe.close()
        code = self.process.exitcode
        self.ended.late = late or code in (-signal.SIGXCPU, -signal.SIGKILL)
        if self.ended.late:
            self.ended.fault = f"no end within {self.limit_s:g} s of processor time"
        elif code:
            self.ended.fault = f"the process ended with {code}"
        return self.ended


def run_each(tasks: Sequence[Any], work: Work, jobs: int, limit_s: float) -> Iterator[Ended]:
    """Do each task in a process, `jobs` at a time, and yield it as soon as it has ended."""
    waiting, running = list(reversed(tasks)), list[_Child]()
    while waiting or running:
        while waiting and len(running) < jobs:
            running.append(_Child(waiting.pop(), work, limit_s))
        wait([child.pipe for child in running], timeout=POLL_S)
        for child in [c for c in running if c.read()]:
            running.remove(child)
            yield child.close()


def _run(pipe: Connection, task: Any, work: Work, limit_s: float) -> None:
    seconds = math.ceil(limit_s + time.process_time())
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 5))
    try:
        work(task, pipe.send)
    except BaseException:
        traceback.print_exc()
        raise SystemExit(1) from None
    finally:
        pipe.close()
