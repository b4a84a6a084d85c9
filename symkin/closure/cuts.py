"""Choose the joint at which a branch that closes a loop is cut."""

from __future__ import annotations

from collections.abc import Sequence

from symkin.closure.branches import Element
from symkin.model.joint import Joint


def middle_turn(elements: Sequence[Element]) -> int | None:
    """The revolute joint nearest the middle of a limb: cut there, an unknown joint leaves the rows,
    and both sides are short. None where it is the only joint: then nothing would be left to solve
    for.
    """
    if len(elements) == 1:
        return None
    turns = [
        i
        for i, element in enumerate(elements)
        if isinstance(element.part, Joint) and element.part.type == "R"
    ]
    return min(turns, key=lambda i: abs(2 * i - len(elements) + 1), default=None)


def cut_index(elements: Sequence[Element], kept: frozenset[str]) -> int | None:
    """The passive joint of most freedom, the last of equals; helical joints are never cut (their
    angle stays), nor those that are kept.
    """
    best: int | None = None
    most = 0
    for i, element in enumerate(elements):
        joint = element.part
        if not isinstance(joint, Joint) or joint.actuated or joint.form.kept is None:
            continue
        if any(c.name in kept for c in joint.coordinates):
            continue
        # >= takes the last of equals, so that the chain from the base is the longer one
        if joint.freedom >= most:
            best, most = i, joint.freedom
    return best
