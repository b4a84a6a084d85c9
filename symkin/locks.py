"""Locks of the process, which a child that is forked finds free.

A fork copies the memory and the thread that forks, not the others: a lock that another thread holds
would stay held in the child for ever. Here the child has new ones, but for those that its own
thread holds.
"""

from __future__ import annotations

import os
import threading
import weakref


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
