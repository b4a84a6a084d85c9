"""Describe links and joints as a graph: joints and rods between any two links, couplings of joints,
points of links.

Links have names and no other description: a link is what joints and rods name, and "base" is the
one that is fixed. All points and axes are in the base frame at the reference configuration, so that
every link's own frame is the base frame there.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import lcm
from operator import mul
from typing import Any

import numpy as np

from symkin.computed_once import cached_property
from symkin.errors import MechanismError
from symkin.model.bar import Bar, RodEnd
from symkin.model.joint import Joint, finite, interval, link_pair, vector3
from symkin.model.limb import coincide

MOST_POWERS = 4
"""Highest power of a joint that a coupling may hold, as in the equalities of MJCF."""
MOST_TEETH = 12
"""Largest whole number of a ratio whose wheels are counted modulo whole turns. A wheel of n teeth
has n places beside the same place of its driver; a train of larger ratios is taken to advance, one
place for each value of what drives it.
"""
_RATIO_ROUNDING = 1e-12
"""Of a factor: by how much a ratio of whole numbers may miss it, digits of files and rounding."""


@dataclass(frozen=True)
class LinkJoint:
    """A joint between two links; its coordinate moves the second relative to the first.

    >>> import symkin
    >>> crank = symkin.Joint("crank", "R", [0, 0, 0], [0, 0, 1], actuated=True)
    >>> symkin.LinkJoint(crank, ["base", "arm"]).links
    ('base', 'arm')

    Raises MechanismError for links that are not two.
    """

    joint: Joint
    links: Sequence[str]

    def __post_init__(self) -> None:
        object.__setattr__(self, "links", link_pair(self.links, f"joint {self.joint.name!r}"))

    def turned(self) -> LinkJoint:
        """The joint from its second link to its first."""
        return LinkJoint(self.joint.turned(), self.links[::-1])


@dataclass(frozen=True)
class LinkRod:
    """A rod with spherical ends between two links: |end point - start point| = length, or =
    offset + value where it is actuated.

    `start` (3 numbers) is on the first of the `links`, `end` on the second, both in the base frame
    at the reference configuration; `length` (length unit) is that at the reference where it is not
    given. The coordinate `value` of an actuated rod has its name; `limits` (low, high) are a range
    of it. Raises MechanismError for numbers that are not finite, a length that is not positive, and
    keys that do not go together.

    >>> import symkin
    >>> rod = symkin.LinkRod("pushrod", ["arm", "foot"], start=[0, 0, 0], end=[0, 0, -120])
    >>> rod.reference_length
    120.0
    """

    name: str
    links: Sequence[str]
    start: Sequence[float]
    end: Sequence[float]
    length: float | None = None
    actuated: bool = False
    offset: float = 0.0
    limits: Sequence[float] | None = None

    def __post_init__(self) -> None:
        where = f"rod {self.name!r}"
        object.__setattr__(self, "links", link_pair(self.links, where))
        object.__setattr__(self, "start", vector3(self.start, f"{where}: from"))
        object.__setattr__(self, "end", vector3(self.end, f"{where}: to"))
        object.__setattr__(self, "offset", finite(self.offset, f"{where}: offset"))
        object.__setattr__(self, "limits", interval(self.limits, f"{where}: limits"))
        if self.length is not None:
            object.__setattr__(self, "length", finite(self.length, f"{where}: length"))
        self._check(where)

    def _check(self, where: str) -> None:
        if self.actuated and self.length is not None:
            raise MechanismError(
                f"{where}: length is that of a rod that does not change; an actuated one has "
                f"`offset`"
            )
        if not self.actuated and (self.offset != 0.0 or self.limits is not None):
            raise MechanismError(
                f"{where}: offset and limits are those of an actuated rod; give `length`, or "
                f"actuated = true"
            )
        if self.length is not None and self.length <= 0.0:
            raise MechanismError(f"{where}: length = {self.length!r} must be positive")
        if self.length is None and not self.actuated and coincide(self.start, self.end):
            raise MechanismError(
                f"{where}: its ends `from` and `to` lie at one point at the reference; a rod has a "
                f"length, so part them or give `length`"
            )

    @property
    def reference_length(self) -> float:
        """Distance of the ends at the reference."""
        return float(np.linalg.norm(np.subtract(self.end, self.start)))

    @property
    def bar(self) -> Bar:
        """The rod as the closure takes it."""
        start = RodEnd(f"{self.name}.from", tuple(self.start))
        end = RodEnd(f"{self.name}.to", tuple(self.end))
        bar = Bar(self.name, start, end, self.name, self.length, self.offset)
        return bar.driven(self.limits) if self.actuated else bar


@dataclass(frozen=True)
class Coupling:
    """A gear, a belt, a differential: joint = sum of factor x other joint + offset; or a polynomial
    of one other joint.

    `of` maps names of coordinates to factors, `offset` is added; or `of` is one name and
    `polynomial` its coefficients c0 + c1 q + c2 q^2 + ..., at most of degree 4. Coordinates are in
    radians and the length unit. Raises MechanismError for a coupling of a joint to itself and for
    keys that do not go together. Where all are angles and the ratios are of whole numbers up to 12,
    whole turns of the joints are not told apart, but if it `advances`.

    >>> import symkin
    >>> symkin.Coupling("finger2", {"finger1": -1.0}).terms
    (('finger1', -1.0),)
    """

    joint: str
    of: Mapping[str, float] | str | Sequence[tuple[str, float]]
    offset: float = 0.0
    polynomial: Sequence[float] | None = None
    advances: bool = False

    def __post_init__(self) -> None:
        where = f"coupling of {self.joint!r}"
        object.__setattr__(self, "offset", finite(self.offset, f"{where}: offset"))
        if isinstance(self.of, str):
            self._check_polynomial(where)
        else:
            pairs = self.of.items() if isinstance(self.of, Mapping) else self.of
            terms = tuple((name, finite(factor, f"{where}: of.{name}")) for name, factor in pairs)
            object.__setattr__(self, "of", terms)
            if self.polynomial is not None:
                raise MechanismError(f"{where}: polynomial needs one joint, as in of = 'finger1'")
            if not terms:
                raise MechanismError(
                    f"{where}: of names no joint; give factors, as in of = {{ finger1 = -1.0 }}"
                )
        if self.joint in self.names:
            raise MechanismError(
                f"{where}: of names the joint itself; a joint is coupled to others"
            )

    def _check_polynomial(self, where: str) -> None:
        if self.polynomial is None:
            raise MechanismError(
                f"{where}: of = {self.of!r} needs polynomial, or factors as in of = {{ {self.of} = "
                f"-1.0 }}"
            )
        if self.offset != 0.0:
            raise MechanismError(f"{where}: a polynomial has its offset as the first coefficient")
        coefficients = tuple(
            finite(c, f"{where}: polynomial[{k}]") for k, c in enumerate(self.polynomial)
        )
        if not 2 <= len(coefficients) <= MOST_POWERS + 1:
            raise MechanismError(
                f"{where}: polynomial has {len(coefficients)} coefficients; 2 to {MOST_POWERS + 1} "
                f"are needed, from c0 on"
            )
        object.__setattr__(self, "polynomial", coefficients)

    @property
    def terms(self) -> tuple[tuple[str, float], ...]:
        """Names and factors of a linear coupling; none of a polynomial one."""
        return () if isinstance(self.of, str) else self.of  # type: ignore[return-value]

    @property
    def names(self) -> tuple[str, ...]:
        """The coordinates on which the joint depends."""
        return (self.of,) if isinstance(self.of, str) else tuple(name for name, _ in self.terms)

    @property
    def line(self) -> tuple[tuple[str, float], ...] | None:
        """Names and factors where the joint is linear in the others, polynomials of degree 1
        included; else None.
        """
        if self.polynomial is None:
            return self.terms
        return None if any(self.polynomial[2:]) else ((self.names[0], self.polynomial[1]),)

    @property
    def constant(self) -> float:
        """The joint's value where all others are 0."""
        return self.offset if self.polynomial is None else self.polynomial[0]

    def value(self, values: Mapping[str, Any]) -> Any:
        """The joint where the others have some values: numbers, or expressions."""
        if self.polynomial is not None:
            leader = values[self.names[0]]
            return sum(c * leader**k for k, c in enumerate(self.polynomial))
        return sum((factor * values[name] for name, factor in self.terms), self.offset)

    def renamed(self, names: Mapping[str, str]) -> Coupling:
        """The same of coordinates that are called otherwise."""
        of = (
            names.get(self.of, self.of)
            if isinstance(self.of, str)
            else tuple((names.get(name, name), factor) for name, factor in self.terms)
        )
        return replace(self, joint=names.get(self.joint, self.joint), of=of)

    def counted_from(self, values: Mapping[str, float]) -> Coupling:
        """The same of coordinates that are 0 at these values: y + y0 = c + sum f (x + x0)."""
        own, away = values.get(self.joint, 0.0), [values.get(name, 0.0) for name in self.names]
        if not own and not any(away):
            return self
        if self.polynomial is None:
            factors = [factor for _, factor in self.terms]
            moved = sum(f * x for f, x in zip(factors, away, strict=True))
            return replace(self, offset=self.offset - own + moved)
        told, inner = (np.polynomial.Polynomial(c) for c in (self.polynomial, (away[0], 1.0)))
        powers = [float(c) for c in (told(inner) - own).coef]
        return replace(self, polynomial=[*powers, *[0.0] * (len(self.polynomial) - len(powers))])

    def in_units(
        self, units: Mapping[str, float], times: Callable[[float, float], float] = mul
    ) -> Coupling:
        """The same of coordinates q u, with the unit u of each by its name (1 where it has none):
        q u = sum f' q' u' + c u; `times` multiplies.
        """
        own = units.get(self.joint, 1.0)
        others = [units.get(name, 1.0) for name in self.names]
        if self.polynomial is not None:
            powers = [times(c, _scale(own, others[0], k)) for k, c in enumerate(self.polynomial)]
            return replace(self, polynomial=powers)
        terms = [
            (name, times(factor, _scale(own, other, 1)))
            for (name, factor), other in zip(self.terms, others, strict=True)
        ]
        return replace(self, of=terms, offset=times(self.offset, own))

    @cached_property
    def whole_numbers(self) -> tuple[int, tuple[int, ...]] | None:
        """The least whole numbers (n, (n1, n2, ...)) of n joint = n1 first + n2 second + ... + n
        offset; None where some would be larger than `MOST_TEETH`, and for polynomials.

        >>> import symkin
        >>> symkin.Coupling("slow", {"fast": 0.5, "other": 2 / 3}).whole_numbers
        (6, (3, 4))
        """
        factors = [factor for _, factor in self.line or ()]
        ratios = [Fraction(factor).limit_denominator(MOST_TEETH) for factor in factors]
        own = lcm(*(ratio.denominator for ratio in ratios))
        numbers = tuple(int(own * ratio) for ratio in ratios)
        exact = all(
            abs(f - r) <= _RATIO_ROUNDING * abs(f) for f, r in zip(factors, ratios, strict=True)
        )
        return (
            (own, numbers)
            if numbers and exact and max(own, *map(abs, numbers)) <= MOST_TEETH
            else None
        )

    def advance_reason(self, kinds: Mapping[str, str]) -> str | None:
        """Why whole turns of its angles do not leave it as it is, if they do not: other `kinds` of
        coordinates than angles, or factors that no small whole numbers tell.
        """
        other = next(
            (name for name in (self.joint, *self.names) if kinds.get(name) != "angle"), None
        )
        if other is not None:
            what = "the length" if kinds.get(other) == "length" else "the helical joint"
            return f"the coupling of {self.joint} ties angles to {what} {other}"
        if self.advances:
            return f"the coupling of {self.joint} advances"
        if self.line is None:
            return f"the coupling of {self.joint} is a polynomial"
        if self.whole_numbers is None:
            factors = ", ".join(f"{factor:.6g}" for _, factor in self.line)
            return (
                f"the ratio of the coupling of {self.joint} ({factors}) is none of whole numbers "
                f"up to {MOST_TEETH}"
            )
        return None


def _scale(own: float, other: float, power: int) -> float:
    """What a coefficient c of q / own = c (q' / other)^power + ... is multiplied by: 1 exactly for
    power 1 and like units.
    """
    return own if power == 0 else own / other / other ** (power - 1)


@dataclass(frozen=True)
class LinkPoint:
    """A point of a link, by name: in the base frame at the reference configuration.

    Raises MechanismError for what is not three finite numbers.

    >>> import symkin
    >>> symkin.LinkPoint("foot", "toe", [0, 0, -10]).point
    (0.0, 0.0, -10.0)
    """

    link: str
    name: str
    point: Sequence[float]

    def __post_init__(self) -> None:
        object.__setattr__(
            self, "point", vector3(self.point, f"link {self.link!r}: points.{self.name}")
        )
