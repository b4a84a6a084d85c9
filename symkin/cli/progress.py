"""What a command says of long work: a bar on a terminal, else a line on stderr now and then."""

from __future__ import annotations

import logging
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from symkin.cli.streams import say

_FIRST, _EVERY = 5.0, 15.0
"""Seconds before the first line off a terminal, and between two lines that say the same."""
Show = Callable[[int, int], None]


@contextmanager
def progress_bar(what: str) -> Iterator[Show | None]:
    """A bar with counts, rate and remaining time on stderr where that is a terminal, else lines;
    `symkin`'s log says what is being done.
    """
    if sys.stderr is None:
        yield None
    elif sys.stderr.isatty():
        with _bar(what) as show:
            yield show
    else:
        with _lines(what) as show:
            yield show


@contextmanager
def _bar(what: str) -> Iterator[Show]:
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(),
    )
    moves = _started(threading.Thread(target=int))
    with Progress(
        *columns, console=Console(stderr=True), transient=True, auto_refresh=moves
    ) as bar:
        task = bar.add_task(what, total=None, rate="")

        def show(done: int, total: int) -> None:
            if bar.tasks[0].total is None:  # what an earlier run has done is of no rate
                bar.reset(task, total=total, completed=done, rate="")
                return
            speed = bar.tasks[0].speed
            rate = "" if speed is None else f"{speed:.3g}/s"
            bar.update(task, completed=done, total=total, rate=rate)

        with _logged(lambda text: bar.update(task, description=text)):
            yield show


@contextmanager
def _lines(what: str) -> Iterator[Show]:
    state, ended = _State(what), threading.Event()
    thread = threading.Thread(target=state.write_lines, args=(ended,), daemon=True)
    begun = _started(thread)
    try:
        with _logged(state.say):
            yield state.count
    finally:
        ended.set()
        if begun:
            thread.join()


def _started(thread: threading.Thread) -> bool:
    """Start a thread; False where the system allows no more: the work goes on without it."""
    try:
        thread.start()
    except RuntimeError:
        return False
    return True


class _State:
    """What is being done, how much of it is done, and since when."""

    def __init__(self, what: str) -> None:
        self.what, self.share = what, ""
        self.begin = time.monotonic()

    def say(self, text: str) -> None:
        self.what, self.share = text, ""

    def count(self, done: int, total: int) -> None:
        self.share = f", {done} of {total}"

    def write_lines(self, ended: threading.Event) -> None:
        """A line after a few seconds, then one for each new work and one now and then, until the
        work ends.
        """
        said, last, wait = "", 0.0, _FIRST
        while not ended.wait(wait):
            wait, now = 1.0, time.monotonic()
            if self.what != said or now - last >= _EVERY:
                with suppress(OSError, ValueError):
                    print(
                        f"symkin: {self.what}{self.share} ({now - self.begin:.0f} s)",
                        file=sys.stderr,
                        flush=True,
                    )
                said, last = self.what, now


@contextmanager
def _logged(say: Callable[[str], object]) -> Iterator[None]:
    """Hear what symkin logs in the block."""
    handler = _Handler(say)
    logger = logging.getLogger("symkin")
    before = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(before)


class _Handler(logging.Handler):
    def __init__(self, say: Callable[[str], object]) -> None:
        super().__init__()
        self.say = say

    def emit(self, record: logging.LogRecord) -> None:
        text = record.getMessage()
        if record.levelno >= logging.WARNING:
            say(f"note: {text}")
        else:
            self.say(text)
