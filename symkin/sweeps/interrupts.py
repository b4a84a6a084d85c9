"""Ctrl-C at a moment that does no harm: not within a call of Zarr, and not in a worker that is
being started.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def interrupts_held() -> Iterator[None]:
    """Ctrl-C waits until the block ends; a second one does not.

    Zarr reads and writes in threads of its own: of a call that is cut short the rest goes on in
    them, into the end of the process. Usable as a decorator; without effect in other threads than
    the main one, where no KeyboardInterrupt is raised.
    """
    former = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or former is None:
        yield
        return
    pressed = False

    def hold(*_: object) -> None:
        nonlocal pressed
        pressed = True
        signal.signal(signal.SIGINT, former)

    signal.signal(signal.SIGINT, hold)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, former)
        if pressed:
            signal.raise_signal(signal.SIGINT)


@contextmanager
def interrupts_kept_from_children() -> Iterator[None]:
    """Processes started in the block do not hear Ctrl-C, which a terminal sends to all: this
    process ends them. One that comes meanwhile is heard after the block. Without effect on Windows.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    former = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, former)
