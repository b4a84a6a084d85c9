"""Read the C that was generated as a tree of statements, as far as a count of its operations needs
it.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

_LEFT_OUT = re.compile(r"/\*.*?\*/|^[ \t]*#(?:\\\n|[^\n])*", re.S | re.M)
_TOKEN = re.compile(
    r"0[xX][0-9a-fA-F.]+(?:[pP][-+]?\d+)?[a-zA-Z]*|(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?[a-zA-Z]*|[A-Za-z_]\w*|"
    r"->|\+\+|--|<<|>>|&&|\|\||[-+*/%<>=!&|^]=|\S"
)
_CLOSING = {"(": ")", "[": "]", "{": "}"}

Tokens = tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Statement:
    """`kind` is "plain", "if", "for" or "while"; `head` its expression or declaration, of a `for`
    begin and condition; `body` and `other` what it leads to.
    """

    kind: str
    head: tuple[Tokens, ...]
    body: tuple[Statement, ...] = ()
    other: tuple[Statement, ...] = ()


@dataclass(frozen=True, eq=False)
class CFunction:
    """A function's name, the names of its parameters, and whether other files can call it."""

    name: str
    parameters: tuple[str, ...]
    is_public: bool
    body: tuple[Statement, ...]


def functions_of(source: str) -> dict[str, CFunction]:
    """The functions that a file defines, in its order."""
    tokens = tuple(_TOKEN.findall(_LEFT_OUT.sub(" ", source)))
    found: dict[str, CFunction] = {}
    begin = k = 0
    while k < len(tokens):
        if tokens[k] == "{":
            end = closing(tokens, k)
            if tokens[k - 1] == ")":
                function = _function(tokens[begin:k], tokens[k + 1 : end])
                found[function.name] = function
                begin = end + 1
            k = end + 1
        else:
            if tokens[k] == ";":
                begin = k + 1
            k += 1
    return found


def closing(tokens: Tokens, k: int) -> int:
    """Where the bracket at k closes."""
    depth, opening = 0, tokens[k]
    for at in range(k, len(tokens)):
        depth += (tokens[at] == opening) - (tokens[at] == _CLOSING[opening])
        if depth == 0:
            return at
    raise ValueError(f"C text: {opening!r} is not closed")


def parts(tokens: Tokens, mark: str) -> list[Tokens]:
    """A list's parts between marks outside brackets."""
    found: list[Tokens] = []
    begin = k = 0
    while k < len(tokens):
        if tokens[k] in _CLOSING:
            k = closing(tokens, k)
        elif tokens[k] == mark:
            found.append(tokens[begin:k])
            begin = k + 1
        k += 1
    return [*found, tokens[begin:]] if tokens else []


def _function(head: Tokens, body: Tokens) -> CFunction:
    opening = head.index("(")
    names = [
        [t for t in _without_indices(part) if re.match(r"[A-Za-z_]", t)]
        for part in parts(head[opening + 1 : -1], ",")
    ]
    return CFunction(
        head[opening - 1], tuple(n[-1] for n in names), "static" not in head, _Reader(body).all()
    )


def _without_indices(tokens: Tokens) -> Tokens:
    return tokens[: tokens.index("[")] if "[" in tokens else tokens


@dataclass
class _Reader:
    """Reads statements one after the other."""

    tokens: Tokens
    at: int = field(default=0)

    def all(self) -> tuple[Statement, ...]:
        found: list[Statement] = []
        while self.at < len(self.tokens):
            found += self._next()
        return tuple(found)

    def _next(self) -> list[Statement]:
        word = self.tokens[self.at]
        if word == "{":
            end = closing(self.tokens, self.at)
            inner = _Reader(self.tokens[self.at + 1 : end]).all()
            self.at = end + 1
            return list(inner)
        if word in ("if", "while", "for"):
            return [self._led(word)]
        if word in ("do", "switch", "goto", "case", "continue"):
            raise ValueError(f"C text: {word!r} is not read here")
        end = self.at
        while self.tokens[end] != ";":
            end = closing(self.tokens, end) + 1 if self.tokens[end] in _CLOSING else end + 1
        statement = Statement("plain", (self.tokens[self.at : end],))
        self.at = end + 1
        return [statement]

    def _led(self, word: str) -> Statement:
        end = closing(self.tokens, self.at + 1)
        inside = self.tokens[self.at + 2 : end]
        head = tuple(parts(inside, ";")) if word == "for" else (inside,)
        self.at = end + 1
        body = tuple(self._next())
        other: tuple[Statement, ...] = ()
        if word == "if" and self.at < len(self.tokens) and self.tokens[self.at] == "else":
            self.at += 1
            other = tuple(self._next())
        return Statement(word, head, body, other)
