"""Bound what a call of generated C takes: iterations and operations, by the text that was written,
templates included.

Every loop ends after a number of passes that its text tells: between two numbers, or as many as a
config allows. A call takes at most the sum of its statements, the larger side of each choice, and
loops as often as they can go. A number on either side of `?` counts, and so do the few additions of
whole numbers outside indices: what is said is never less than what is done.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

from symkin.computed_once import lru_cache

USUAL_ITERATIONS = 100
"""What a call without a config may take (NAME_MAX_STEPS)."""
LARGEST_ITERATIONS = 255
"""The most that a config can allow, whose number is a byte."""
ITERATIONS = "iterations"
_ARITHMETIC = {"+": "additions", "-": "additions", "*": "multiplications", "/": "divisions"}
_COUNTED = ("sqrt", "sin", "cos", "atan2")
_COLUMNS = (*dict.fromkeys(_ARITHMETIC.values()), *_COUNTED)
_TYPE = re.compile(
    r"(const|static|int|unsigned|double|float|bool|void|return|\w+_(t|real|pose|config|info|work|status|geometry))$"
)
_NAME = re.compile(r"[A-Za-z_]\w*$")
_LEFT_OUT = re.compile(r"/\*.*?\*/|^[ \t]*#(?:\\\n|[^\n])*", re.S | re.M)
_TOKEN = re.compile(
    r"0[xX][0-9a-fA-F.]+(?:[pP][-+]?\d+)?[a-zA-Z]*|(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?[a-zA-Z]*|[A-Za-z_]\w*|"
    r"->|\+\+|--|<<|>>|&&|\|\||[-+*/%<>=!&|^]=|\S"
)
_VALUE = re.compile(r"[\w.)\]]")
"""What begins a token that ends a value: a sign behind it has two sides."""
_TYPED = 4
"""Words of a declaration among which its type is."""

Tokens = tuple[Any, ...]
"""Words and signs, and what stands in brackets: a tuple of its own behind the opening one."""
Count = Counter[str]
Known = Mapping[str, int]


class NotDerivedError(Exception):
    """A loop or a call whose effort the text does not tell."""


class _Allowed(int):
    """A number of iterations that a config allows."""


@dataclass(frozen=True)
class Bound:
    """The most that a call takes: iterations (passes of loops that a config bounds) and operations
    by name.
    """

    iterations: int
    operations: dict[str, int]


def bounds(source: str, iterations: Sequence[int]) -> list[dict[str, Bound | None]]:
    """The bound of each function that others can call, for a config with each of these iterations;
    None where the text does not tell it.
    """
    functions = {f.name: f for f in _functions(source)}
    public = [name for name, f in functions.items() if f.is_public]
    first = _Counter(functions, iterations[0])
    counters = (replace(first, iterations=count) for count in iterations)
    return [{name: counter.bound(name) for name in public} for counter in counters]


# --- text -----------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Function:
    """A function's name, the names of its parameters, whether other files can call it, and its
    body.
    """

    name: str
    parameters: tuple[str, ...]
    is_public: bool
    body: Tokens


def _functions(source: str) -> Iterator[_Function]:
    """The functions that a file defines, in its order."""
    tokens, begin = _nested(iter(_TOKEN.findall(_LEFT_OUT.sub(" ", source)))), 0
    for k, token in enumerate(tokens):
        if token[0] == "{" and tokens[k - 1][0] == "(":
            parts, head = _parts(tokens[k - 1][1:], ","), tokens[begin : k - 1]
            names = tuple(next(t for t in part[::-1] if t[0].isidentifier()) for part in parts)
            yield _Function(head[-1], names, "static" not in head, token[1:])
        if token == ";" or token[0] == "{":
            begin = k + 1


def _nested(tokens: Iterator[str]) -> Tokens:
    """Tokens up to a bracket that closes, those within brackets in tuples of their own."""
    found = list[Any]()
    for token in tokens:
        if token in (")", "]", "}"):
            break
        found.append((token, *_nested(tokens)) if token in ("(", "[", "{") else token)
    return tuple(found)


@lru_cache(maxsize=1 << 14)
def _words(tokens: Tokens) -> frozenset[str]:
    """All tokens, those in brackets too."""
    return frozenset().union(*(_words(t) if isinstance(t, tuple) else (t,) for t in tokens))


def _is_cast(token: str | Tokens) -> bool:
    """Whether it is a type in brackets."""
    inside = token[1:] if token[0] == "(" else ()
    return bool(inside) and all(isinstance(t, str) and (t == "*" or _TYPE.match(t)) for t in inside)


def _parts(tokens: Tokens, mark: str) -> list[Tokens]:
    """A list's parts between marks."""
    places = [-1, *(k for k, t in enumerate(tokens) if t == mark), len(tokens)]
    return [tokens[a + 1 : b] for a, b in pairwise(places)] if tokens else []


def _cut(tokens: Tokens, sign: str) -> tuple[Tokens, Tokens]:
    """What stands before and after a sign; nothing after where there is none."""
    found = _parts(tokens, sign)
    return (found[0], found[1]) if len(found) == 2 else (tokens, ())


def _conjuncts(tokens: Tokens) -> list[Tokens]:
    """The parts of a condition that all hold, without their brackets."""
    whole = _bare(tokens)
    found = _parts(whole, "&&")
    return [whole] if len(found) == 1 else [inner for part in found for inner in _conjuncts(part)]


def _bare(tokens: Tokens) -> Tokens:
    """Without brackets around all of it, casts and stars before it."""
    while tokens:
        if len(tokens) == 1 and tokens[0][0] == "(":
            tokens = tokens[0][1:]
        elif tokens[0] == "*" or _is_cast(tokens[0]):
            tokens = tokens[1:]
        else:
            break
    return tokens


@dataclass(frozen=True)
class _Statement:
    """A statement by the word that leads it, "" of a plain one: its head, or all of it, and what it
    leads to.
    """

    word: str
    head: Tokens
    body: Tokens = ()
    other: Tokens = ()


@lru_cache(maxsize=1 << 14)
def _statements(tokens: Tokens) -> tuple[_Statement, ...]:
    """The statements of a block, one after the other; of one in brackets, those inside."""
    found, at = list[_Statement](), 0
    while at < len(tokens):
        statement, at = _statement(tokens, at)
        found.append(statement)
    return tuple(found)


def _statement(tokens: Tokens, at: int) -> tuple[_Statement, int]:
    """The statement that begins at a place, and where the next one does."""
    word = tokens[at]
    if word[0] == "{":
        return _Statement("{", (), word[1:]), at + 1
    if word in ("do", "switch", "goto", "case", "continue"):
        raise ValueError(f"C text: {word!r} is not read here")
    if word not in ("if", "while", "for"):
        end = tokens.index(";", at)
        return _Statement("", tokens[at:end]), end + 1
    _, after = _statement(tokens, at + 2)
    body, other = tokens[at + 2 : after], Tokens()
    if word == "if" and tokens[after : after + 1] == ("else",):
        begin = after + 1
        _, after = _statement(tokens, begin)
        other = tokens[begin:after]
    return _Statement(word, tokens[at + 1][1:], body, other), after


# --- counts ---------------------------------------------------------------------------------------


@dataclass
class _Counter:
    """Counts the operations of functions, each once for each set of whole numbers that it is called
    with.
    """

    functions: dict[str, _Function]
    iterations: int
    counts: dict[tuple[str, tuple[tuple[str, int], ...]], Count] = field(default_factory=dict)
    active: list[str] = field(default_factory=list)
    straight: dict[Tokens, Count] = field(default_factory=dict)
    """Blocks without loops and calls."""

    def bound(self, name: str) -> Bound | None:
        """The bound of a call; None where the text does not tell it."""
        try:
            count = self.call(name, {})
        except NotDerivedError:
            return None
        return Bound(count[ITERATIONS], {key: count[key] for key in _COLUMNS if count[key]})

    def call(self, name: str, known: Known) -> Count:
        """What a call takes whose parameters are these whole numbers; of a config, its
        iterations.
        """
        function = self.functions[name]
        if name in self.active:
            raise NotDerivedError(f"{name} calls itself")
        numbers = {key: value for key, value in known.items() if key in function.parameters}
        if "config" in function.parameters:
            numbers.setdefault("config", _Allowed(self.iterations))
        key = (name, tuple(sorted(numbers.items())))
        if key not in self.counts:
            self.active.append(name)
            self.counts[key] = self._block(function.body, numbers)
            self.active.pop()
        return self.counts[key]

    def _is_straight(self, tokens: Tokens) -> bool:
        words = _words(tokens)
        return self.functions.keys().isdisjoint(words) and words.isdisjoint(("for", "while"))

    def _block(self, tokens: Tokens, known: Known) -> Count:
        """The sum of statements; what they tell of whole numbers stays within them."""
        if tokens in self.straight:
            return self.straight[tokens]
        total, own = Count(), dict(known)
        for statement in _statements(tokens):
            head = statement.head
            match statement.word:
                case "":
                    self._learn(head, own)
                    total.update(self._expression(head, own))
                case "{":
                    total.update(self._block(statement.body, own))
                case "if":
                    sides = self._block(statement.body, own) | self._block(statement.other, own)
                    total.update(self._expression(head, own) + sides)
                case _:
                    total.update(self._loop(statement, own))
        if self._is_straight(tokens):
            self.straight[tokens] = total
        return total

    # --- loops ------------------------------------------------------------------------------------

    def _loop(self, loop: _Statement, known: Known) -> Count:
        head = _parts(loop.head, ";")
        if loop.word == "for" and head[0]:
            return self._counted_loop(head, loop.body, known)
        passes, test = self._passes(loop, known), Count()
        if loop.word == "while":
            test = self._expression(loop.head, known)
        inside = self._block(loop.body, known) + test
        total = _times(inside, int(passes) + (loop.word == "for")) + test
        total[ITERATIONS] += int(passes) if isinstance(passes, _Allowed) else 0
        return total

    def _counted_loop(self, head: list[Tokens], body: Tokens, known: Known) -> Count:
        """Of a loop from a number to another by one: its variable takes each value, on which inner
        loops may depend.
        """
        declared, begin = _cut(head[0], "=")
        name, first, down = declared[-1], self._whole(begin, known), "--" in head[2]
        found = (self._end(part, name, known) for part in _conjuncts(head[1]))
        ends = [end for end in found if end is not None]
        if first is None or not ends:
            raise NotDerivedError(f"for {name}")
        values = range(first, max(ends) - 1, -1) if down else range(first, min(ends) + 1)
        test = self._expression(head[1], known)
        if name not in _words(body) or self._is_straight(body):
            return _times(self._block(body, known) + test, len(values)) + test
        passes = (self._block(body, {**known, name: value}) + test for value in values)
        return sum(passes, start=Count(test))

    def _end(self, part: Tokens, name: str, known: Known) -> int | None:
        """The last value of a variable for which a part of a condition holds."""
        if len(part) < 3 or part[0] != name or part[1] not in ("<", "<=", ">="):
            return None
        end = self._whole(part[2:], known)
        return None if end is None else end - (part[1] == "<")

    def _passes(self, loop: _Statement, known: Known) -> int:
        """Of `while (count < most)`, or of `for (;;)` that breaks at `count >= most`, whose body
        counts up: `most`.
        """
        inner = _statements(loop.body)
        inner = _statements(inner[0].body) if inner and inner[0].word == "{" else inner
        counted = [_bare(s.head[1:]) for s in inner if s.word == "" and s.head[:1] == ("++",)]
        limits = [_cut(part, "<") for part in _conjuncts(loop.head) if loop.word == "while"]
        limits += [_cut(s.head, ">=") for s in inner if s.word == "if" and _breaks(s.body)]
        for counter, most in limits:
            limit = self._whole(most, known)
            if limit is not None and _bare(counter) in counted:
                return limit
        raise NotDerivedError(loop.word)

    # --- numbers and expressions ------------------------------------------------------------------

    def _learn(self, tokens: Tokens, known: dict[str, int]) -> None:
        """Keeps what a declaration says of a whole number or of a config."""
        declared, value = _cut(tokens, "=")
        kinds = declared[:_TYPED]
        is_config = any(t.endswith("_config") for t in kinds if isinstance(t, str))
        is_read = is_config or "int" in kinds or "uint8_t" in kinds
        if not (value and is_read and "const" in kinds and declared[-1][0].isidentifier()):
            return
        if is_config and value[0][0] == "{":
            found = self._whole(_parts(value[0][1:], ",")[1], known)
        else:
            found = self._of_config(value, known) if is_config else self._whole(value, known)
        if found is not None:
            known[declared[-1]] = _Allowed(found) if is_config else found

    def _of_config(self, tokens: Tokens, known: Known) -> int | None:
        """The most iterations of the configs that an expression may stand for."""
        allowed = (known[t] for t in _words(tokens) if isinstance(known.get(t), _Allowed))
        return max(allowed, default=None)

    def _whole(self, tokens: Tokens, known: Known) -> int | None:
        """The largest value of a whole number, None where the text does not tell it."""
        tokens = _bare(tokens)
        match tokens:
            case (config, "->", "max_iterations"):
                return known.get(config)
            case (first, "+" | "-" | "*" as sign, last):
                a, b = self._whole((first,), known), self._whole((last,), known)
                if a is None or b is None:
                    return None
                return {"+": a + b, "-": a - b, "*": a * b}[sign]
            case (name, ("(", *_)) if name in self.functions:
                return self._returned(tokens, known)
            case (word,):
                if number := re.match(r"(\d+)[uUlL]*$", word):
                    return int(number[1])
                return USUAL_ITERATIONS if word.endswith("_MAX_STEPS") else known.get(word)
        return None

    def _returned(self, tokens: Tokens, known: Known) -> int | None:
        """The largest number that a function returns which counts up from 0 to what it returns."""
        last = _statements(self.functions[tokens[0]].body)[-1].head
        if len(last) != 2 or last[0] != "return":
            return None
        ((name, given), *_) = _operations(tokens)[1]
        return self.call(name, self._arguments(name, given, known))[f"++{last[1]}"] or None

    def _expression(self, tokens: Tokens, known: Known) -> Count:
        """Operations of an expression and of the calls in it."""
        operations, calls = _operations(tokens)
        if not calls:
            return operations
        total = Count(operations)
        for name, given in calls:
            own = name.removesuffix("f")
            if name in self.functions:
                called = self.call(name, self._arguments(name, given, known))
                total.update({n: c for n, c in called.items() if n[0] != "+"})
            elif own in _COUNTED:
                total[own] += 1
            elif own != "fabs" and name != "sizeof":
                raise NotDerivedError(f"{name} is called")
        return total

    def _arguments(self, name: str, given: Sequence[Tokens], known: Known) -> dict[str, int]:
        """What a call hands on of whole numbers and configs."""
        found: dict[str, int] = {}
        for parameter, value in zip(self.functions[name].parameters, given, strict=False):
            is_config = parameter == "config"
            number = self._of_config(value, known) if is_config else self._whole(value, known)
            if number is not None:
                found[parameter] = _Allowed(number) if is_config else number
        return found


@lru_cache(maxsize=1 << 14)
def _operations(tokens: Tokens) -> tuple[Count, list[tuple[str, list[Tokens]]]]:
    """Operations of an expression, and what it calls with which arguments. A sign behind a value
    has two sides; what stands before a cast tells of one behind it.
    """
    total, calls, before = Count(), list[tuple[str, list[Tokens]]](), ""
    for token in tokens:
        if isinstance(token, tuple):
            if token[0] == "(" and _NAME.match(before) and before != "return":
                calls.append((before, _parts(token[1:], ",")))
            elif _is_cast(token):
                continue
            if token[0] != "[":
                inside, called = _operations(token[1:])
                total.update(inside)
                calls += called
            before = ")"
            continue
        if token == "++":
            total[f"++{tokens[-1]}"] += 1
        elif token[0] in _ARITHMETIC and token not in ("--", "->"):
            is_value = _VALUE.match(before) and not _TYPE.match(before)
            total[_ARITHMETIC[token[0]]] += token.endswith("=") or bool(is_value)
        before = token
    return +total, calls


def _breaks(body: Tokens) -> bool:
    """Whether a block ends by leaving its loop."""
    return bool(body[-1][-2:] == ("break", ";"))


def _times(count: Count, factor: int) -> Count:
    return Counter({key: n * factor for key, n in count.items()})
