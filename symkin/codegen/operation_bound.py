"""Bound what a call of generated C takes: iterations and operations, by reading the C that was
written.

Every loop ends after a number of passes that its text tells: between two numbers, or as many as a
config allows. A call takes at most the sum of its statements, the larger side of each choice, and
loops as often as they can go. A number on either side of `?` counts, and so do the few additions of
whole numbers outside indices: what is said is never less than what is done.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field

from symkin.codegen.c_reader import CFunction, Statement, Tokens, closing, functions_of, parts

USUAL_ITERATIONS = 100
"""What a call without a config may take (NAME_MAX_STEPS)."""
LARGEST_ITERATIONS = 255
"""The most that a config can allow, whose number is a byte."""
ITERATIONS = "iterations"
_ARITHMETIC = {"+": "additions", "-": "additions", "*": "multiplications", "/": "divisions"}
_COUNTED = ("sqrt", "sin", "cos", "atan2")
_FREE = ("fabs",)
_TYPE = re.compile(
    r"(const|static|int|unsigned|double|float|bool|void|return|\w+_(t|real|pose|config|info|work|status|geometry))$"
)
_NAME = re.compile(r"[A-Za-z_]\w*$")
_WHOLE = re.compile(r"(\d+)[uUlL]*$")

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


def bounds(source: str, iterations: int) -> dict[str, Bound | None]:
    """The bound of each function that others can call, for a config with these iterations; None
    where the text does not tell it.
    """
    counter = _Counter(functions_of(source), iterations)
    found: dict[str, Bound | None] = {}
    for function in counter.functions.values():
        if function.is_public:
            try:
                count = counter.call(function.name, {})
            except NotDerivedError:
                found[function.name] = None
            else:
                operations = {
                    key: count[key]
                    for key in (*dict.fromkeys(_ARITHMETIC.values()), *_COUNTED)
                    if count[key]
                }
                found[function.name] = Bound(count[ITERATIONS], operations)
    return found


@dataclass
class _Counter:
    """Counts the operations of functions, each once for each set of whole numbers that it is called
    with.
    """

    functions: dict[str, CFunction]
    iterations: int
    _counts: dict[tuple[str, tuple[tuple[str, int], ...]], Count] = field(default_factory=dict)
    _active: list[str] = field(default_factory=list)
    _plain: dict[Tokens, Count] = field(default_factory=dict)

    def call(self, name: str, known: Known) -> Count:
        """What a call takes whose parameters are these whole numbers; of a config, its
        iterations.
        """
        function = self.functions[name]
        if name in self._active:
            raise NotDerivedError(f"{name} calls itself")
        numbers = {key: value for key, value in known.items() if key in function.parameters}
        if "config" in function.parameters and "config" not in numbers:
            numbers["config"] = _Allowed(self.iterations)
        key = (name, tuple(sorted(numbers.items())))
        if key not in self._counts:
            self._active.append(name)
            self._counts[key] = self._block(function.body, dict(numbers))
            self._active.pop()
        return self._counts[key]

    def _block(self, statements: tuple[Statement, ...], known: dict[str, int]) -> Count:
        total: Count = Counter()
        for statement in statements:
            total += self._statement(statement, known)
        return total

    def _statement(self, statement: Statement, known: dict[str, int]) -> Count:
        if statement.kind == "plain":
            self._learn(statement.head[0], known)
            return self._expression(statement.head[0], known)
        if statement.kind == "if":
            sides = self._block(statement.body, dict(known)) | self._block(
                statement.other, dict(known)
            )
            return self._expression(statement.head[0], known) + sides
        return self._loop(statement, known)

    # --- loops ------------------------------------------------------------------------------------

    def _loop(self, loop: Statement, known: dict[str, int]) -> Count:
        if loop.kind == "for" and loop.head[0]:
            return self._counted_loop(loop, known)
        passes, test = (
            (self._passes_while(loop, known), loop.head[0])
            if loop.kind == "while"
            else (self._passes_broken(loop, known), ())
        )
        inside = self._block(loop.body, dict(known)) + self._expression(test, known)
        total = _times(inside, int(passes) + (loop.kind == "for")) + self._expression(test, known)
        total[ITERATIONS] += int(passes) if isinstance(passes, _Allowed) else 0
        return total

    def _counted_loop(self, loop: Statement, known: dict[str, int]) -> Count:
        """Of a loop from a number to another by one: its variable takes each value, on which inner
        loops may depend.
        """
        declared, _, begin = _cut(loop.head[0], "=")
        name, condition = declared[-1], loop.head[1]
        first, down = self._whole(begin, known), "--" in loop.head[2]
        ends = [
            end
            for part in _conjuncts(condition)
            if (end := self._end(part, name, known)) is not None
        ]
        if first is None or not ends:
            raise NotDerivedError(f"for ({' '.join(condition)})")
        values = range(first, max(ends) - 1, -1) if down else range(first, min(ends) + 1)
        test = self._expression(condition, known)
        if name not in _deciding(loop.body):
            return _times(self._block(loop.body, dict(known)) + test, len(values)) + test
        total = Counter(test)
        for value in values:
            total += self._block(loop.body, {**known, name: value}) + test
        return total

    def _end(self, part: Tokens, name: str, known: Known) -> int | None:
        """The last value of a variable for which a part of a condition holds."""
        if len(part) < 3 or part[0] != name or part[1] not in ("<", "<=", ">="):
            return None
        end = self._whole(part[2:], known)
        return None if end is None else end - (part[1] == "<")

    def _passes_while(self, loop: Statement, known: Known) -> int:
        """Of `while (count < most)` whose body counts up: `most`."""
        for part in _conjuncts(loop.head[0]):
            counter, sign, most = _cut(part, "<")
            limit = self._whole(most, known)
            if sign and limit is not None and _counts_up(loop.body, counter):
                return limit
        raise NotDerivedError(f"while ({' '.join(loop.head[0])})")

    def _passes_broken(self, loop: Statement, known: Known) -> int:
        """Of `for (;;)` that breaks at `count >= most` and counts up: `most`."""
        for statement in loop.body:
            if (
                statement.kind == "if"
                and statement.body
                and statement.body[-1].head == (("break",),)
            ):
                counter, sign, most = _cut(statement.head[0], ">=")
                limit = self._whole(most, known)
                if sign and limit is not None and _counts_up(loop.body, counter):
                    return limit
        raise NotDerivedError("for (;;)")

    # --- numbers and expressions ------------------------------------------------------------------

    def _learn(self, tokens: Tokens, known: dict[str, int]) -> None:
        """Keeps what a declaration says of a whole number or of a config."""
        declared, sign, value = _cut(tokens, "=")
        if not sign or "const" not in declared or not _NAME.match(declared[-1]):
            return
        if any(t.endswith("_config") for t in declared):
            inside = value[0] == "{"
            limit = (
                self._whole(parts(value[1:-1], ",")[1], known)
                if inside
                else self._of_config(value, known)
            )
            if limit is not None:
                known[declared[-1]] = _Allowed(limit)
        elif any(t in ("int", "uint8_t") for t in declared):
            found = self._whole(value, known)
            if found is not None:
                known[declared[-1]] = found

    def _of_config(self, tokens: Tokens, known: Known) -> int | None:
        """The most iterations of the configs that an expression may stand for."""
        return max((known[t] for t in tokens if isinstance(known.get(t), _Allowed)), default=None)

    def _whole(self, tokens: Tokens, known: Known) -> int | None:
        """The largest value of a whole number, None where the text does not tell it."""
        tokens = _bare(tokens)
        if len(tokens) == 3 and tokens[1:] == ("->", "max_iterations"):
            return known.get(tokens[0])
        if len(tokens) == 3 and tokens[1] in ("+", "-", "*"):
            a, b = self._whole(tokens[:1], known), self._whole(tokens[2:], known)
            if a is None or b is None:
                return None
            return {"+": a + b, "-": a - b, "*": a * b}[tokens[1]]
        if len(tokens) > 2 and tokens[0] in self.functions and tokens[1] == "(":
            return self._returned(tokens, known)
        if len(tokens) != 1:
            return None
        number = _WHOLE.match(tokens[0])
        if number:
            return int(number[1])
        return USUAL_ITERATIONS if tokens[0].endswith("_MAX_STEPS") else known.get(tokens[0])

    def _returned(self, tokens: Tokens, known: Known) -> int | None:
        """The largest number that a function returns which counts up from 0 to what it returns."""
        last = self.functions[tokens[0]].body[-1].head[0]
        if len(last) != 2 or last[0] != "return":
            return None
        return self.call(tokens[0], self._arguments(tokens, 0, known))[f"++{last[1]}"] or None

    def _expression(self, tokens: Tokens, known: Known) -> Count:
        """Operations of an expression and of the calls in it."""
        if tokens not in self._plain:
            self._plain[tokens] = _operations(tokens, self.functions)
        total = self._plain[tokens]
        for k, token in enumerate(tokens):
            if token in self.functions and tokens[k + 1 : k + 2] == ("(",):
                called = self.call(token, self._arguments(tokens, k, known))
                total = total + Counter(
                    {key: n for key, n in called.items() if not key.startswith("++")}
                )
        return total

    def _arguments(self, tokens: Tokens, k: int, known: Known) -> dict[str, int]:
        """What a call hands on of whole numbers and configs."""
        given = parts(tokens[k + 2 : closing(tokens, k + 1)], ",")
        found: dict[str, int] = {}
        for name, value in zip(self.functions[tokens[k]].parameters, given, strict=False):
            number = (
                self._of_config(value, known) if name == "config" else self._whole(value, known)
            )
            if number is not None:
                found[name] = _Allowed(number) if name == "config" else number
        return found


def _operations(tokens: Tokens, functions: Mapping[str, CFunction]) -> Count:
    """Operations of an expression, without the functions of the file that it calls."""
    total: Count = Counter()
    k = 0
    while k < len(tokens):
        token, before = tokens[k], tokens[k - 1] if k else ""
        if token == "[":
            k = closing(tokens, k)
        elif token[0] in _ARITHMETIC and token not in ("++", "--", "->"):
            if token.endswith("=") or _is_operand(before, tokens[:k]):
                total[_ARITHMETIC[token[0]]] += 1
        elif token == "++":
            total[f"++{tokens[-1]}"] += 1
        elif (
            tokens[k + 1 : k + 2] == ("(",)
            and _NAME.match(token)
            and token not in functions
            and not _TYPE.match(token)
        ):
            name = token.removesuffix("f")
            if name in _COUNTED:
                total[name] += 1
            elif name not in _FREE and token not in ("sizeof",):
                raise NotDerivedError(f"{token} is called")
        k += 1
    return total


def _is_operand(token: str, before: Tokens) -> bool:
    """Whether what stands before a sign is a value, so that the sign has two sides."""
    if token == ")":
        opening = len(before) - 1
        depth = 0
        while True:
            depth += (before[opening] == ")") - (before[opening] == "(")
            if depth == 0:
                break
            opening -= 1
        inside = before[opening + 1 : -1]
        return not inside or not all(_TYPE.match(t) or t == "*" for t in inside)
    return bool(token == "]" or re.match(r"[\w.]", token)) and not _TYPE.match(token)


def _times(count: Count, factor: int) -> Count:
    return Counter({key: n * factor for key, n in count.items()})


def _cut(tokens: Tokens, sign: str) -> tuple[Tokens, Tokens, Tokens]:
    """What stands before and after a sign outside brackets; nothing after where there is none."""
    found = parts(tokens, sign)
    return (found[0], (sign,), found[1]) if len(found) == 2 else (tokens, (), ())


def _conjuncts(tokens: Tokens) -> list[Tokens]:
    """The parts of a condition that all hold, without their brackets."""
    whole = _bare(tokens)
    found = parts(whole, "&&")
    return [whole] if len(found) == 1 else [inner for part in found for inner in _conjuncts(part)]


def _bare(tokens: Tokens) -> Tokens:
    """Without brackets around all of it, casts and stars before it."""
    while tokens:
        end = closing(tokens, 0) if tokens[0] == "(" else -1
        if end == len(tokens) - 1:
            tokens = tokens[1:-1]
        elif end > 0 and all(_TYPE.match(t) for t in tokens[1:end]):
            tokens = tokens[end + 1 :]
        elif tokens[0] == "*":
            tokens = tokens[1:]
        else:
            break
    return tokens


def _counts_up(body: tuple[Statement, ...], counter: Tokens) -> bool:
    """Whether each pass counts a variable up."""
    name = _bare(counter)
    return any(
        s.kind == "plain" and s.head[0][:1] == ("++",) and _bare(s.head[0][1:]) == name
        for s in body
    )


def _deciding(body: tuple[Statement, ...]) -> set[str]:
    """Names on which loops and calls in a body may depend."""
    found: set[str] = set()
    for statement in body:
        if statement.kind == "plain":
            found |= set(statement.head[0]) if "(" in statement.head[0] else set()
        else:
            found |= {
                t for part in statement.head for t in part if statement.kind != "if" or "(" in part
            }
        found |= _deciding(statement.body) | _deciding(statement.other)
    return found
