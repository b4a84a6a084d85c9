"""Values that are computed once, however many threads ask for them at the same time.

The caches of functools may compute a value twice when two threads miss it together, and give each
thread its own. That will not do here: a closure that is built twice has two sets of symbols, and
expressions of the one know nothing of the other. Here all threads get the same value. Those that
come second wait for the first, each key by itself; values depend on each other without cycles, so
that no two threads wait for each other. A thread that holds a lock which a value may need does not
wait (see `not_waiting`): it computes the value too, and takes what was kept first.
"""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from typing import Any, Generic, ParamSpec, TypeVar, overload

from symkin.locks import Lock

Arguments = ParamSpec("Arguments")
Value = TypeVar("Value")
_MISSING: Any = object()


def lru_cache(maxsize: int) -> Callable[[Callable[Arguments, Value]], Callable[Arguments, Value]]:
    """Keep the last `maxsize` results by their arguments, as functools.lru_cache does, the same for
    all threads.
    """

    def decorate(function: Callable[Arguments, Value]) -> Callable[Arguments, Value]:
        entries = functools.lru_cache(maxsize)(lambda *_, **__: _Entry())
        guard = Lock()

        @functools.wraps(function)
        def cached(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Value:
            entry = entries(*args, **kwargs)  # type: ignore[arg-type]  # unhashable arguments raise TypeError
            if entry.value is _MISSING:
                # of two threads that miss it together one entry is kept, which both find here
                with guard.held:
                    entry = entries(*args, **kwargs)  # type: ignore[arg-type]
                with computing(id(entry)):
                    if entry.value is _MISSING:
                        value = function(*args, **kwargs)
                        entry.keep(value)
            return entry.value

        return cached

    return decorate


class cached_property(Generic[Value]):  # noqa: N801  # the name of what it stands for in functools
    """A property computed at its first use and kept in the instance's `__dict__`, the same for all
    threads. The instance holds the value alone and no lock, so that it can be pickled.
    """

    waits = True

    def __init__(self, function: Callable[[Any], Value]) -> None:
        self.function = function
        self.name = function.__name__
        self.__doc__ = function.__doc__

    @overload
    def __get__(self, instance: None, owner: type | None = None) -> cached_property[Value]: ...
    @overload
    def __get__(self, instance: object, owner: type | None = None) -> Value: ...
    def __get__(
        self, instance: object | None, owner: type | None = None
    ) -> cached_property[Value] | Value:
        if instance is None:
            return self
        kept = vars(instance)
        if not self.waits:
            return kept.setdefault(self.name, self.function(instance))
        with computing((id(instance), self.name)):
            if self.name not in kept:
                kept.setdefault(self.name, self.function(instance))
            return kept[self.name]


class unshared_property(cached_property[Value]):  # noqa: N801  # as the one above
    """The same of a value that two threads may compute: none waits, which would take 5 us."""

    waits = False


@contextmanager
def not_waiting() -> Iterator[None]:
    """In this block the thread waits for no value that another thread computes: for blocks that
    hold a lock.
    """
    before = set_waiting(waits=False)
    try:
        yield
    finally:
        set_waiting(waits=before)


def set_waiting(*, waits: bool) -> bool:
    """Whether this thread waits for values that others compute, from now on; what held before. For
    `not_waiting`, and where that is called too often to be a generator.
    """
    before = _is_waiting()
    _this_thread.waits = waits
    return before


_this_thread = threading.local()


def _is_waiting() -> bool:
    return getattr(_this_thread, "waits", True)


class _Entry:
    """Place of one value in a cache."""

    __slots__ = ("value",)

    def __init__(self) -> None:
        self.value: Any = _MISSING

    def keep(self, value: object) -> None:
        """Keep the first value that comes."""
        with _turns_guard:
            if self.value is _MISSING:
                self.value = value


class _Turn:
    """The lock of a value that is being computed, and how many threads use it."""

    __slots__ = ("lock", "users")

    def __init__(self) -> None:
        self.lock = Lock()
        self.users = 0


_turns: dict[Hashable, _Turn] = {}
_idle: list[_Turn] = []
"""Turns that no thread uses, to be taken again."""
_turns_guard = Lock()


class computing:  # noqa: N801  # stands in a `with`, as a function would
    """Hold the lock of a key, so that one thread computes what it names; it is the key's only while
    threads use it. A thread that does not wait goes on without it where another holds it.
    """

    __slots__ = ("key", "taken", "turn")

    def __init__(self, key: Hashable) -> None:
        self.key = key

    def __enter__(self) -> None:
        with _turns_guard.held:
            turn = _turns.get(self.key)
            if turn is None:
                turn = _turns[self.key] = _idle.pop() if _idle else _Turn()
            turn.users += 1
        self.turn, self.taken = turn, False
        try:
            self.taken = turn.lock.acquire(blocking=_is_waiting())
        except BaseException:
            self._left()
            raise

    def __exit__(self, *_: object) -> None:
        if self.taken:
            self.turn.lock.release()
        self._left()

    def _left(self) -> None:
        """Give the turn back, for good where no other thread uses it."""
        with _turns_guard.held:
            self.turn.users -= 1
            if self.turn.users == 0:
                del _turns[self.key]
                _idle.append(self.turn)
