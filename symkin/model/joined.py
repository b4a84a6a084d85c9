"""Which of several things are joined, one pair after another, and by which way."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Generic, Protocol, TypeVar

Item = TypeVar("Item", bound=Hashable)


class Pair(Protocol):
    """What joins two links."""

    @property
    def links(self) -> Sequence[str]: ...


PairType = TypeVar("PairType", bound=Pair)


def tree_from(ends: Iterable[tuple[Item, Item]], root: Item) -> dict[Item, tuple[int, Item]]:
    """All items to which pairs lead from a root, the nearest first, with the number of the pair
    that leads to each, and the item before it; -1 and itself for the root.
    """
    beside: dict[Item, list[tuple[int, Item]]] = {}
    for number, (first, second) in enumerate(ends):
        beside.setdefault(first, []).append((number, second))
        beside.setdefault(second, []).append((number, first))
    found = {root: (-1, root)}
    for item in (reached := [root]):
        for number, other in beside.get(item, ()):
            if other not in found:
                found[other] = number, item
                reached.append(other)
    return found


def back(tree: Mapping[Item, tuple[int, Item]], item: Item) -> list[tuple[int, Item]]:
    """The pairs from an item back to the root of its tree, each with the item before it."""
    found = []
    while tree[item][0] >= 0:
        found.append(tree[item])
        item = tree[item][1]
    return found


def way(pairs: Sequence[PairType], begin: str, end: str) -> list[PairType] | None:
    """What joins two links in order, as few as possible; None where nothing does."""
    tree = tree_from(((pair.links[0], pair.links[1]) for pair in pairs), begin)
    return [pairs[k] for k, _ in reversed(back(tree, end))] if end in tree else None


def along(pairs: Iterable[PairType], begin: str) -> Iterator[tuple[PairType, bool]]:
    """Each pair of a way from a link, and whether the way takes it from its first link to its
    second.
    """
    at = begin
    for pair in pairs:
        forward = pair.links[0] == at
        at = pair.links[forward]
        yield pair, forward


def outward(
    pairs: Iterable[PairType], roots: Sequence[str], *, deep: bool = False
) -> list[tuple[PairType, bool]]:
    """The pairs that lead from roots to other links, each behind the one that leads to its first,
    and whether it is taken from its first link to its second: all of a link's before those behind
    them, or, where `deep`, before those of other links.
    """
    at: dict[str, list[PairType]] = {}
    for pair in pairs:
        for link in pair.links:
            at.setdefault(link, []).append(pair)
    seen, found = set(roots), []
    todo = deque(roots)
    while todo:
        link, behind = todo.popleft(), []
        for pair in at.get(link, ()):
            forward = pair.links[0] == link
            other = pair.links[forward]
            if other not in seen:
                seen.add(other)
                behind.append(other)
                found.append((pair, forward))
        if deep:
            todo.extendleft(reversed(behind))
        else:
            todo.extend(behind)
    return found


def spanning(
    pairs: Iterable[PairType], rank: Callable[[PairType], int], together: Sequence[str] = ()
) -> list[PairType]:
    """A tree of the pairs (Kruskal), those of low rank before others; links that are `together` are
    joined already.
    """
    joined = Joined[str]()
    for first, second in pairwise(together):
        joined.join(first, second)
    return [pair for pair in sorted(pairs, key=rank) if joined.join(*pair.links)]


def joined_to(pairs: Iterable[Pair], begin: str) -> set[str]:
    """A link, and all that pairs join to it."""
    joined, links = Joined[str](), {begin}
    for pair in pairs:
        joined.join(*pair.links)
        links |= set(pair.links)
    return {link for link in links if joined.head(link) == joined.head(begin)}


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
        """Join two items; False where they were joined before."""
        first, second = self.head(first), self.head(second)
        self._above[first] = second
        return first != second
