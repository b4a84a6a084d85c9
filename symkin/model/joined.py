"""Which of several things are joined, one pair after another."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Generic, TypeVar

Item = TypeVar("Item", bound=Hashable)


class Joined(Generic[Item]):
    """Sets of items that pairs have joined so far; each has a head."""

    def __init__(self) -> None:
        self._above: dict[Item, Item] = {}

    def head(self, item: Item) -> Item:
        """The same item for all that are joined."""
        while (above := self._above.setdefault(item, item)) != item:
            self._above[item] = self._above[above]
            item = self._above[item]
        return item

    def join(self, first: Item, second: Item) -> bool:
        """Join two items; False where they were joined before. Taken in order of preference, the
        pairs that join are a spanning tree (Kruskal).
        """
        first, second = self.head(first), self.head(second)
        self._above[first] = second
        return first != second
