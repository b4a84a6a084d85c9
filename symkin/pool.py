"""Objects that one thread at a time may use, lent to as many threads as ask.

CasADi's functions of expressions may be called by any number of threads at once: each call has its
own work vectors. Its rootfinders and nlpsols may not: a call works in memory that belongs to the
object, and two calls at once end in a segmentation fault. (Expressions may be built in threads with
CasADi from 3.7 on as its wheels are built, with thread-safe symbolics; before 3.7 a call holds the
interpreter's lock.)
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Generic, TypeVar

Item = TypeVar("Item")


class Pool(Generic[Item]):
    """Equal objects, made when all others are lent."""

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
