"""Who computes the chunks: local processes, a Dask scheduler, any other executor, or this process
itself.

At most a bounded number of chunks is under way. Where a local process is killed, the pool is built
anew and the chunks that were under way are computed again.
"""

from __future__ import annotations

import logging
import multiprocessing
import os
import signal
import sys
import threading
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from dataclasses import dataclass, field
from typing import Any

from symkin.errors import InputError
from symkin.sweeps.interrupts import interrupts_kept_from_children

_UNDER_WAY = 2
"""Chunks under way for each worker, so that none waits for the next."""
_MOST_LOSSES = 3
"""Times that a chunk may be lost with its worker before the sweep is stopped."""
_PATIENCE_S = 10.0
"""Seconds in which a Dask scheduler must answer and show a worker."""
_ENDING_S = 5.0
"""Seconds given to a pool to end once its processes are; one left in the middle of it writes into
closed pipes.
"""
_KEPT = "what is done is kept, and the same sweep goes on from there"
_GUARD = (
    "a script that sweeps must do so under `if __name__ == '__main__':`, and a worker needs memory "
    "enough"
)


_DASK_LOGGERS = (
    "distributed",
    "distributed.client",
    "distributed.comm",
    "distributed.core",
    "distributed.utils",
    "distributed.batched",
    "tornado",
    "tornado.application",
    "tornado.general",
    "asyncio",
)
"""Loggers of Dask's client and of the event loop in which it runs."""


class Here(Executor):
    """Computes in this process, at once."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


@dataclass(eq=False)
class Crew:
    """An executor, how many chunks it has under way, and how it is made again when it breaks (None:
    not at all); `beginning` is around what may start its processes.
    """

    executor: Executor
    under_way: int
    make: Callable[[], Executor] | None = None
    beginning: Callable[[], AbstractContextManager[None]] = nullcontext
    losses: Counter[int] = field(default_factory=Counter)
    _lost: list[int] = field(default_factory=list)
    _pending: dict[Future[Any], int] = field(default_factory=dict)

    def results(
        self, function: Callable[..., Any], job: bytes, chunks: Iterable[int]
    ) -> Iterator[tuple[int, Any]]:
        """Chunks and their results `function(job, chunk)`, in the order in which they are done."""
        left = iter(chunks)
        while self._fill(function, job, left):
            done, _ = wait(self._pending, return_when=FIRST_COMPLETED)
            for future in done:
                index = self._pending.pop(future)
                if self._is_good(future, index):
                    self.losses.clear()
                    yield index, future.result()
            if self._lost and _is_broken(self.executor):
                self._rebuild("a worker process ended")

    def _fill(self, function: Callable[..., Any], job: bytes, left: Iterator[int]) -> bool:
        """Submit as many chunks as may be under way, lost ones first; whether any is."""
        while len(self._pending) < self.under_way:
            index = self._lost.pop() if self._lost else next(left, None)
            if index is None:
                break
            try:
                with interrupts_kept_from_children(), self.beginning():
                    future = self.executor.submit(function, job, index)
            except BrokenExecutor as error:
                self._lost.append(index)
                self._rebuild(str(error))
            else:
                self._pending[future] = index
        return bool(self._pending)

    def _is_good(self, future: Future[Any], index: int) -> bool:
        """Whether a future has a result; a chunk that was lost with its worker is kept for later.
        Other errors are raised.
        """
        if future.cancelled():
            raise InputError(f"the executor has cancelled its work; {_KEPT}")
        error = future.exception()
        if error is None:
            return True
        if not (isinstance(error, BrokenExecutor) or _is_killed_worker(error)):
            raise error
        self._lost.append(index)
        if _is_killed_worker(error):
            self._count([index], str(error))
        return False

    def _rebuild(self, reason: str) -> None:
        """The executor is broken: make another, to which all that was under way is given."""
        self._lost += self._pending.values()
        self._pending.clear()
        if self.make is None:
            raise InputError(f"the executor broke ({reason}); {_KEPT}")
        self._count(self._lost, reason)
        self.executor.shutdown(wait=False, cancel_futures=True)
        self.executor = self.make()

    def _count(self, chunks: list[int], reason: str) -> None:
        self.losses.update(chunks)
        if max(self.losses.values()) > _MOST_LOSSES:
            raise InputError(f"workers end abruptly, again and again ({reason}); {_GUARD}")


def _is_broken(executor: Executor) -> bool:
    """Whether a process pool takes no more work, by the standard library's own flag."""
    return bool(getattr(executor, "_broken", False))


def _is_killed_worker(error: BaseException) -> bool:
    """Whether Dask gave a chunk up because its workers died."""
    return type(error).__name__ == "KilledWorker"


# --- local processes ------------------------------------------------------------------------------


@contextmanager
def local_crew(workers: int | None) -> Iterator[Crew]:
    """`workers` processes (default: one for each processor), or none: this process."""
    count = (os.cpu_count() or 1) if workers is None else workers
    if not 0 <= count <= 1024:
        raise InputError(f"workers = {count}; allowed: 0 (this process) to 1024")
    if count == 0:
        yield Crew(Here(), 1)
        return
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        # a worker runs a script that has no guard; the process that began it says so
        sys.exit(1)
    before = set(multiprocessing.active_children())
    crew = Crew(_pool(count), _UNDER_WAY * count, lambda: _pool(count), _processes_needed)
    try:
        yield crew
    except BaseException:
        ending = threading.Thread(
            target=crew.executor.shutdown, kwargs={"cancel_futures": True}, daemon=True
        )
        ending.start()
        for process in set(multiprocessing.active_children()) - before:
            process.terminate()
        ending.join(_ENDING_S)
        raise
    crew.executor.shutdown()


def _pool(workers: int) -> ProcessPoolExecutor:
    with _processes_needed():
        return ProcessPoolExecutor(
            workers, mp_context=multiprocessing.get_context("spawn"), initializer=_begin_worker
        )


@contextmanager
def _processes_needed() -> Iterator[None]:
    """Raise InputError where the system gives no semaphores, threads or processes."""
    try:
        yield
    except BrokenExecutor:
        raise
    except (OSError, ImportError, NotImplementedError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(
            f"worker processes cannot be started ({reason}); workers = 0 (--workers 0) computes in "
            f"this process"
        ) from None


def _begin_worker() -> None:
    """Ctrl-C is the driver's to handle; a worker whose driver was killed ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


# --- others ---------------------------------------------------------------------------------------


@contextmanager
def dask_crew(address: str) -> Iterator[Crew]:
    """The workers of the Dask scheduler at an address. Raises InputError where it does not answer,
    and where it ends.
    """
    try:
        import distributed

        connect: Any = distributed.Client
    except ImportError:
        from symkin.sweeps.store import MISSING

        raise InputError(MISSING) from None
    with _quiet_loggers():
        yield from _dask_crew(connect, address)


def _dask_crew(connect: Any, address: str) -> Iterator[Crew]:
    try:
        client = connect(address, timeout=_PATIENCE_S, set_as_default=False)
    except (OSError, TimeoutError, ValueError, TypeError, KeyError) as error:
        text = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(
            f"no Dask scheduler answers at {address!r} within {_PATIENCE_S:.0f} s ({text})"
        ) from None
    try:
        try:
            client.wait_for_workers(1, timeout=_PATIENCE_S)
        except TimeoutError:
            raise InputError(
                f"the Dask scheduler at {address!r} has no workers; start some with `dask worker "
                f"{address}`"
            ) from None
        yield Crew(
            client.get_executor(pure=False), _UNDER_WAY * max(1, sum(client.ncores().values()))
        )
    except (OSError, TimeoutError, RuntimeError, CancelledError, InputError):
        if client.status == "running":
            raise
        raise InputError(
            f"the Dask scheduler at {address!r} has ended, or cannot be reached any more; {_KEPT}"
        ) from None
    finally:
        with suppress(OSError, TimeoutError, RuntimeError):
            client.close(timeout=_PATIENCE_S)


@contextmanager
def _quiet_loggers() -> Iterator[None]:
    """What Dask's threads log of a lost connection, tracebacks and all, is said once, by the
    error.
    """
    loggers = [logging.getLogger(name) for name in _DASK_LOGGERS]
    former = [logger.disabled for logger in loggers]
    for logger in loggers:
        logger.disabled = True
    try:
        yield
    finally:
        for logger, was in zip(loggers, former, strict=True):
            logger.disabled = was


@contextmanager
def given_crew(executor: Executor) -> Iterator[Crew]:
    """An executor that the caller made and shuts down."""
    workers = getattr(executor, "_max_workers", None) or os.cpu_count() or 1
    yield Crew(executor, _UNDER_WAY * int(workers))
