"""Locks of the process, which a child that is forked finds free, and objects that one thread at a
time may use.

A fork copies the memory and the thread that forks, not the others: a lock that another thread holds
would stay held in the child for ever. Here the child has new ones, but for those that its own
thread holds.
"""

from __future__ import annotations

import os
import threading
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Generic, TypeVar


class Lock:
    """A lock that its holder may take again, free in a forked child unless the thread that forks
    holds it.
    """

    __slots__ = ("__weakref__", "held")

    def __init__(self) -> None:
        self.held = threading.RLock()
        """What is taken, for those that take it too often to ask this object."""
        _locks.add(self)

    def acquire(self, blocking: bool = True) -> bool:
        """Take the lock; whether it was taken."""
        return self.held.acquire(blocking=blocking)

    def release(self) -> None:
        """Give it back, once for each time that it was taken."""
        self.held.release()

    def __enter__(self) -> None:
        self.held.acquire()

    def __exit__(self, *_: object) -> None:
        self.held.release()

    def renew(self) -> None:
        """Be free, where this thread is not the holder."""
        if not self.held._is_owned():  # type: ignore[attr-defined]
            self.held = threading.RLock()


_locks: weakref.WeakSet[Lock] = weakref.WeakSet()


def _renew_all() -> None:
    for lock in list(_locks):
        lock.renew()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_renew_all)


Item = TypeVar("Item")


class Pool(Generic[Item]):
    """Equal objects that one thread at a time may use, lent to as many threads as ask, made when
    all others are lent.

    CasADi's functions of expressions may be called by any number of threads at once: each call
    has its own work vectors. Its rootfinders and nlpsols may not: a call works in memory that
    belongs to the object, and two calls at once end in a segmentation fault. (Expressions may
    be built in threads with CasADi from 3.7 on as its wheels are built, with thread-safe
    symbolics; before 3.7 a call holds the interpreter's lock.)
    """

    def __init__(self, make: Callable[[], Item]) -> None:
        self._make = make
        self._idle: list[Item] = []

    @contextmanager
    def borrowed(self) -> Iterator[Item]:
        """An object that no other thread has until the block ends."""
        item = self.take()
        try:
            yield item
        finally:
            self.give(item)

    def take(self) -> Item:
        """An object that no other thread has until it is given back. One that never is is made
        anew.
        """
        try:
            return self._idle.pop()
        except IndexError:
            return self._make()

    def give(self, item: Item) -> None:
        """Give back what was taken."""
        self._idle.append(item)
