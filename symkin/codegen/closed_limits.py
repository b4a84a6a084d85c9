"""Write the C that asks whether an arm's joints keep their limits between two points of a line: a
joint leaves the straight way between its values there by no more than an eighth of the bound of its
second derivative.
"""

from __future__ import annotations

from dataclasses import dataclass

from symkin.codegen.arm_part import RAISED
from symkin.codegen.closed_source import ClosedCode
from symkin.codegen.steps.joint_ranges import range_of
from symkin.codegen.text.c import indent
from symkin.codegen.text.templates import fill

_WITHOUT = dict.fromkeys(("guess_beyond", "blame", "and_within"), "")


@dataclass(frozen=True)
class LimitCheck:
    """How the line asks whether joints keep their limits: which ones have some, values of names in
    its template, `members` of its work space, statements where a part is `shorter`, and the
    functions that these call.
    """

    joints: tuple[int, ...]
    names: dict[str, str]
    text: str
    members: tuple[str, ...] = ()
    shorter: tuple[str, ...] = ()


def limit_check(code: ClosedCode) -> LimitCheck:
    """The check of an arm's limits along the line; of an arm without limits the plain text."""
    real, p, n = code.real, code.values, len(code.plan.arm)
    prefix, capital, count = p["p"], p["P"], f"{n}U"
    limited = tuple(i for i, c in enumerate(code.coordinates) if c.limits is not None)
    if not limited:
        plain = {"limits_kept": "    return follows;", "refused": f"{capital}_WRONG_BRANCH"}
        return LimitCheck((), _WITHOUT | plain, "")
    beyond = f"    status = {capital}_OUT_OF_RANGE;"
    names = {
        "and_within": ", and the joints keep their limits",
        "guess_beyond": indent(
            [
                "w->beyond = false;",
                f"w->blamed = {prefix}_first_beyond(joints);",
                f"if (w->blamed < {count}) {{",
                beyond,
                "}",
            ]
        ),
        "limits_kept": indent(
            [
                "if (follows) {",
                f"    w->blamed = {prefix}_first_leaving(w, w->joints, w->found);",
                f"    w->beyond = (w->blamed < {count}) && ({prefix}_first_beyond(w->found) < "
                f"{count});",
                "}",
                f"return follows && (w->blamed == {count});",
            ]
        ),
        "refused": f"(w->blamed < {count}) ? {capital}_OUT_OF_RANGE : {capital}_WRONG_BRANCH",
        "blame": indent(
            [
                f"if ((info != NULL) && (status == {capital}_OUT_OF_RANGE)) {{",
                "    info->joint = w->blamed;",
                "}",
            ]
        ),
    }
    ranges = [range_of(c, real, code.plan.arm.size) for c in code.coordinates]
    own = {
        "k": f"{prefix}_inverse",
        "last": n - 1,
        "limited": ", ".join("true" if c.limits is not None else "false" for c in code.coordinates),
        "lows": ", ".join(real.literal(low) for low, _ in ranges),
        "highs": ", ".join(real.literal(high) for _, high in ranges),
        "per_lengths": ", ".join(
            real.literal(1.0 / code.plan.arm.size if screw.slides else 1.0)
            for screw in code.plan.arm.screws
        ),
        "nn": n,
        "four": real.literal(4.0),
        "two": real.literal(2.0),
        "half": real.literal(0.5),
        "raised": real.literal(RAISED),
    }
    members = (
        "uint8_t blamed; /* the joint that leaves its limits */",
        "bool beyond; /* whether it is beyond them where the line is tried */",
    )
    text = fill("closed_limits.c", {**p, **own})
    return LimitCheck(limited, names, text, members, ("if (w->beyond) {", beyond, "}"))
