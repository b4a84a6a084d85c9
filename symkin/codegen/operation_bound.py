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
from dataclasses import dataclass, field
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
_DECLARED = re.compile(
    r"(?:static )?const (?:unsigned )?(int|uint8_t|\w+_config) (?:const )?(\w+) = "
)
"""A declaration of a whole number or a config, without stars."""
_VALUE = re.compile(r"[\w.)\]]")
"""What begins a token that ends a value: a sign behind it has two sides."""

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
    counters = [_Counter(functions, count) for count in iterations]
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
    """Tokens up to a bracket that closes, those within brackets in tuples of their own; types in
    brackets are left out.
    """
    found = list[Any]()
    for token in tokens:
        if token in (")", "]", "}"):
            break
        found.append((token, *_nested(tokens)) if token in ("(", "[", "{") else token)
    return tuple(found)


def _flat(tokens: Tokens) -> str:
    """Words and signs one after the other, without casts, round brackets and stars."""
    kept = (t for t in tokens if t not in ("(", "*") and not _is_cast(t))
    return " ".join(_flat(t) if isinstance(t, tuple) else t for t in kept)


def _is_cast(token: str | Tokens) -> bool:
    """Whether it is a type in brackets."""
    inside = token[1:] if token[0] == "(" else ()
    return bool(inside) and all(isinstance(t, str) and (t == "*" or _TYPE.match(t)) for t in inside)


def _parts(tokens: Tokens, mark: str) -> list[Tokens]:
    """A list's parts between marks."""
    places = [-1, *(k for k, t in enumerate(tokens) if t == mark), len(tokens)]
    return [tokens[a + 1 : b] for a, b in pairwise(places)] if tokens else []


def _end(tokens: Tokens, at: int) -> int:
    """Where the statement ends that begins at a place."""
    word = tokens[at]
    if word[0] == "{":
        return at + 1
    if word in ("do", "switch", "goto", "case", "continue"):
        raise ValueError(f"C text: {word!r} is not read here")
    if word not in ("if", "while", "for"):
        return tokens.index(";", at) + 1
    end = _end(tokens, at + 2)
    return _end(tokens, end + 1) if tokens[end : end + 1] == ("else",) else end


def _statements(tokens: Tokens) -> Iterator[Tokens]:
    """The statements of a block, one after the other."""
    at = 0
    while at < len(tokens):
        end = _end(tokens, at)
        yield tokens[at:end]
        at = end


# --- counts ---------------------------------------------------------------------------------------


@dataclass
class _Counter:
    """Counts the operations of functions, each once for each set of whole numbers that it is called
    with.
    """

    functions: dict[str, _Function]
    iterations: int
    counts: dict[tuple[str, frozenset[tuple[str, int]]], Count] = field(default_factory=dict)
    active: list[str] = field(default_factory=list)

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
        function, numbers = self.functions[name], dict(known)
        if name in self.active:
            raise NotDerivedError(f"{name} calls itself")
        if "config" in function.parameters:
            numbers.setdefault("config", _Allowed(self.iterations))
        key = (name, frozenset(numbers.items()))
        if key not in self.counts:
            self.active.append(name)
            self.counts[key] = self._block(function.body, numbers)
            self.active.pop()
        return self.counts[key]

    def _block(self, tokens: Tokens, known: Known) -> Count:
        """The sum of statements; what they tell of whole numbers stays within them."""
        total, own = Count(), dict(known)
        for statement in _statements(tokens):
            word, *others = statement
            if word[0] == "{":
                total.update(self._block(word[1:], own))
            elif word == "if":
                end = _end(statement[2:], 0) + 2
                sides = self._block(statement[2:end], own) | self._block(statement[end + 1 :], own)
                total.update(self._expression(others[0][1:], own) + sides)
            elif word in ("for", "while"):
                total.update(self._loop(word, others[0][1:], statement[2:], own))
            else:
                self._learn(statement[:-1], own)
                total.update(self._expression(statement[:-1], own))
        return total

    # --- loops ------------------------------------------------------------------------------------

    def _loop(self, word: str, head: Tokens, body: Tokens, known: Known) -> Count:
        """Passes of a loop from a number to another by one, whose variable takes each value, on
        which inner loops may depend; else as many as its text allows.
        """
        begin, asked, *_ = _parts(head, ";") if word == "for" else ((), head)
        test = self._expression(asked, known)
        if begin:
            name, values = self._values(_flat(begin), asked, "--" in head, known)
            if name not in _flat(body).split():
                return _times(self._block(body, known) + test, len(values)) + test
            passes = (self._block(body, {**known, name: value}) + test for value in values)
            return sum(passes, start=Count(test))
        most = self._most(asked, [_flat(s) for s in _statements(body[0][1:])], known)
        total = _times(self._block(body, known) + test, int(most) + (word == "for")) + test
        total[ITERATIONS] += int(most) if isinstance(most, _Allowed) else 0
        return total

    def _values(self, begin: str, asked: Tokens, down: bool, known: Known) -> tuple[str, range]:
        """The variable that a loop counts, and its values: up to the least end that is told."""
        declared, first = begin.split(" = ")
        name, start = declared.split()[-1], self._number(first, known)
        ends = [
            end - (sign == "<")
            for part in _parts(asked, "&&")
            for sign, told in re.findall(rf"^{name} (<=?|>=) (.+)$", _flat(part))
            if (end := self._number(told, known)) is not None
        ]
        if start is None or not ends:
            raise NotDerivedError(f"for {name}")
        return name, range(start, max(ends) - 1, -1) if down else range(start, min(ends) + 1)

    def _most(self, asked: Tokens, body: Sequence[str], known: Known) -> int:
        """Of `while (count < most)`, or of `for (;;)` that breaks at `count >= most`, whose body
        counts up: `most`.
        """
        tests = [re.fullmatch(r"(\w+) < (.+)", _flat(part)) for part in _parts(asked, "&&")]
        tests += [re.fullmatch(r"if (\w+) >= ([^{]+) { (?:.* )?break ;", text) for text in body]
        for found in tests:
            most = self._number(found[2], known) if found else None
            if found and most is not None and f"++ {found[1]} ;" in body:
                return most
        raise NotDerivedError("while")

    # --- numbers and expressions ------------------------------------------------------------------

    def _learn(self, tokens: Tokens, known: dict[str, int]) -> None:
        """Keeps what a declaration says of a whole number or of a config."""
        if found := _DECLARED.match(_flat(tokens)):
            value = tokens[tokens.index("=") + 1 :]
            number = self._whole(value, known, is_config=found[1].endswith("config"))
            if number is not None:
                known[found[2]] = number

    def _whole(self, tokens: Tokens, known: Known, *, is_config: bool) -> int | None:
        """The largest value of a whole number, or the most iterations of the configs that an
        expression may stand for; None where the text does not tell it.
        """
        text = _flat(tokens)
        if not is_config:
            is_call = len(tokens) == 2 and tokens[0] in self.functions
            return self._returned(tokens, known) if is_call else self._number(text, known)
        if text.startswith("{"):
            number = self._number(text.split(" , ")[1], known)
            return None if number is None else _Allowed(number)
        allowed = (known[t] for t in text.split() if isinstance(known.get(t), _Allowed))
        return max(allowed, default=None)

    def _number(self, text: str, known: Known) -> int | None:
        match text.split():
            case [config, "->", "max_iterations"]:
                return known.get(config)
            case [first, *sign, last]:
                a, b = self._number(first, known), self._number(last, known)
                if a is None or b is None:
                    return None
                # the star of a product is left out
                return {"+": a + b, "-": a - b, "": a * b}.get("".join(sign))
            case [word]:
                if number := re.match(r"(\d+)[uUlL]*$", word):
                    return int(number[1])
                return USUAL_ITERATIONS if word.endswith("_MAX_STEPS") else known.get(word)
        return None

    def _returned(self, tokens: Tokens, known: Known) -> int | None:
        """The largest number that a function returns which counts up from 0 to what it returns."""
        *_, last = _statements(self.functions[tokens[0]].body)
        if len(last) != 3 or last[0] != "return":
            return None
        ((name, given), *_) = _operations(tokens)[1]
        return self.call(name, self._arguments(name, given, known))[f"++{last[1]}"] or None

    def _expression(self, tokens: Tokens, known: Known) -> Count:
        """Operations of an expression and of the calls in it."""
        operations, calls = _operations(tokens)
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
        told = zip(self.functions[name].parameters, given, strict=False)
        found = {p: self._whole(v, known, is_config=p == "config") for p, v in told}
        return {p: number for p, number in found.items() if number is not None}


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


def _times(count: Count, factor: int) -> Count:
    return Counter({key: n * factor for key, n in count.items()})
