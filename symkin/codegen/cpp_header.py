"""Write a header for C++17 and later over the C: a namespace, sizes known to the compiler, arrays
or spans, results with their status.
"""

from __future__ import annotations

from dataclasses import dataclass

from symkin.codegen.program import Program
from symkin.codegen.text.templates import fill

_KEYWORDS = frozenset(
    [
        "alignas",
        "alignof",
        "and",
        "and_eq",
        "asm",
        "auto",
        "bitand",
        "bitor",
        "bool",
        "break",
        "case",
        "catch",
        "char",
        "char8_t",
        "char16_t",
        "char32_t",
        "class",
        "compl",
        "concept",
        "const",
        "consteval",
        "constexpr",
        "constinit",
        "const_cast",
        "continue",
        "co_await",
        "co_return",
        "co_yield",
        "decltype",
        "default",
        "delete",
        "do",
        "double",
        "dynamic_cast",
        "else",
        "enum",
        "explicit",
        "export",
        "extern",
        "false",
        "float",
        "for",
        "friend",
        "goto",
        "if",
        "inline",
        "int",
        "long",
        "mutable",
        "namespace",
        "new",
        "noexcept",
        "not",
        "not_eq",
        "nullptr",
        "operator",
        "or",
        "or_eq",
        "private",
        "protected",
        "public",
        "register",
        "reinterpret_cast",
        "requires",
        "return",
        "short",
        "signed",
        "sizeof",
        "static",
        "static_assert",
        "static_cast",
        "std",
        "struct",
        "switch",
        "template",
        "this",
        "thread_local",
        "throw",
        "true",
        "try",
        "typedef",
        "typeid",
        "typename",
        "union",
        "unsigned",
        "using",
        "virtual",
        "void",
        "volatile",
        "wchar_t",
        "while",
        "xor",
        "xor_eq",
    ]
)
"""Words that no namespace can be called."""


@dataclass(frozen=True)
class _Wrapped:
    """A function of C: what it takes in C++, the result's type, and the arguments of the call, of
    which `found` is the result's.
    """

    name: str
    takes: str
    result: str
    call: str
    comment: str


_POSE = "found.value"
_ARRAY = "found.value.data()"
_PLATFORM = (
    _Wrapped(
        "direct",
        "view<joint_count> joints, const pose &guess, const config *settings = nullptr",
        "pose",
        f"settings, joints.data(), &guess, &{_POSE}, &found.details",
        "The pose that the machine reaches from the guess.",
    ),
    _Wrapped(
        "track",
        "view<joint_count> joints, const pose &last",
        "pose",
        f"joints.data(), &{_POSE}, &found.details",
        "One step from the last pose; details.residual is the predicted error, to be compared "
        "with track_limit.",
    ),
    _Wrapped(
        "inverse", "const pose &at", "joint_values", f"&at, {_ARRAY}", "Joint values of a pose."
    ),
    _Wrapped(
        "jacobian",
        "const pose &at",
        "matrix",
        f"&at, {_ARRAY}",
        "Row-major: joint rates = jacobian * twist.",
    ),
    _Wrapped(
        "line",
        "const pose &from, const pose &to, const config *settings = nullptr",
        "bool",
        "settings, &from, &to, &found.details",
        "Whether joints keep their limits along the straight line between two poses.",
    ),
    _Wrapped(
        "rates",
        "const pose &at, view<6> twist",
        "joint_values",
        f"&at, twist.data(), {_ARRAY}",
        "Joint rates of a twist.",
    ),
    _Wrapped(
        "twist",
        "const pose &at, view<joint_count> rates",
        "twist_values",
        f"&at, rates.data(), {_ARRAY}",
        "The twist of joint rates.",
    ),
    _Wrapped(
        "feed",
        "const pose &at, view<6> twist, view<joint_count> rate_limits",
        "real",
        f"&at, twist.data(), rate_limits.data(), &{_POSE}",
        "The largest factor, up to 1, that keeps the limits of joint rates.",
    ),
)
_TOGETHER = "view<joint_count> joints, view<joint_count> at"
_MAP = (
    _Wrapped(
        "direct",
        "view<joint_count> joints, view<joint_count> guess, const config *settings = nullptr",
        "joint_values",
        f"settings, joints.data(), guess.data(), {_ARRAY}, &found.details",
        "The found values that the machine reaches from the guess.",
    ),
    _Wrapped(
        "inverse",
        "view<joint_count> at, view<joint_count> guess, const config *settings = nullptr",
        "joint_values",
        f"settings, at.data(), guess.data(), {_ARRAY}, &found.details",
        "The joints that the machine reaches from the guess when the found values are these.",
    ),
    _Wrapped(
        "track",
        "view<joint_count> joints, const joint_values &last",
        "joint_values",
        f"joints.data(), {_ARRAY}, &found.details",
        "One step from the last found values; details.residual is the predicted error, to be "
        "compared with track_limit.",
    ),
    _Wrapped(
        "track_inverse",
        "view<joint_count> at, const joint_values &last",
        "joint_values",
        f"at.data(), {_ARRAY}, &found.details",
        "One step from the last joints to those of the found values.",
    ),
    *(
        _Wrapped(name, _TOGETHER, "matrix", f"joints.data(), at.data(), {_ARRAY}", comment)
        for name, comment in (
            ("jacobian", "Row-major: found rates = jacobian * joint rates."),
            ("inverse_jacobian", "Row-major: joint rates = inverse jacobian * found rates."),
        )
    ),
    _Wrapped(
        "second",
        _TOGETHER,
        "derivatives",
        "joints.data(), at.data(), found.value.jacobian.data(), found.value.second.data()",
        "Jacobian, and second derivatives of each found value by each two joints.",
    ),
    *(
        _Wrapped(
            name,
            f"{_TOGETHER}, view<joint_count> {given}",
            result,
            f"joints.data(), at.data(), {given}.data(), {_ARRAY}",
            comment,
        )
        for name, given, result, comment in (
            ("rates", "joint_rates", "joint_values", "Found rates of joint rates."),
            ("torques", "found_torques", "joint_values", "Joint torques that hold found ones."),
            ("inertia", "joint_inertias", "matrix", "The joints' inertias at the found values."),
            ("torque_limits", "joint_limits", "joint_values", "Largest found torques, each alone."),
            ("rate_limits", "joint_limits", "joint_values", "Largest found rates, each alone."),
        )
    ),
)
_DERIVATIVES = """using matrix = std::array<real, joint_count * joint_count>;
struct derivatives {
    matrix jacobian;
    std::array<real, joint_count * joint_count * joint_count> second;
};"""
_TWIST = """using twist_values = std::array<real, 6>;
using matrix = std::array<real, 6 * joint_count>;"""
_ARM = (
    _Wrapped(
        "direct",
        "view<joint_count> joints",
        "pose",
        f"joints.data(), &{_POSE}",
        "Tool pose of joint values.",
    ),
    _Wrapped(
        "inverse",
        "const pose &at, view<joint_count> guess, const config *settings = nullptr",
        "joint_values",
        f"settings, &at, guess.data(), {_ARRAY}, &found.details",
        "The joint values that the arm reaches from the guess.",
    ),
    _Wrapped(
        "inverse_nearest",
        "const pose &at, view<joint_count> guess",
        "joint_values",
        f"&at, guess.data(), {_ARRAY}",
        "The joint values nearest to the guess, by formulas.",
    ),
    _Wrapped(
        "inverse_branch",
        "const pose &at, unsigned int branch",
        "joint_values",
        f"&at, branch, {_ARRAY}",
        "The joint values of one branch, by formulas.",
    ),
    _Wrapped(
        "jacobian",
        "view<joint_count> joints",
        "matrix",
        f"joints.data(), {_ARRAY}",
        "Row-major: twist = jacobian * joint rates.",
    ),
)


def cpp_text(program: Program) -> str:
    """NAME.hpp."""
    name, serial = program.mechanism.name, program.mechanism.serial
    struct = program.options.geometry == "struct"
    is_map = program.options.is_map
    wrapped = _MAP if is_map else _ARM if serial else _PLATFORM
    functions = [f for f in wrapped if f"{name}_{f.name}(" in program.header]
    shown = program.values | {
        "namespace": f"{name}_kinematics" if name in _KEYWORDS else name,
        "functions": "\n".join(_function(name, f, struct=struct) for f in functions),
        "pose": "" if is_map else f"using pose = ::{name}_pose;",
        "arrays": _DERIVATIVES if is_map else _TWIST,
        "geometry_type": f"using geometry = ::{name}_geometry;" if struct else "",
        "limit": f"inline constexpr real track_limit = {name.upper()}_TRACK_LIMIT;"
        if f"{name.upper()}_TRACK_LIMIT" in program.header
        else "",
        "all": fill("all.hpp", program.values) if f"{name}_inverse_all(" in program.header else "",
    }
    return fill("header.hpp", shown)


def _function(name: str, wrapped: _Wrapped, *, struct: bool) -> str:
    """One function."""
    first, passed = ("const geometry &numbers, ", "&numbers, ") if struct else ("", "")
    begun = {"track": "last", "track_inverse": "last", "line": "true"}.get(wrapped.name)
    begin = f"\n    found.value = {begun};" if begun else ""
    return f"""/// {wrapped.comment}
[[nodiscard]] inline outcome<{wrapped.result}> {wrapped.name}({first}{wrapped.takes}) noexcept
{{
    outcome<{wrapped.result}> found{{}};{begin}
    found.state = static_cast<status>(::{name}_{wrapped.name}({passed}{wrapped.call}));
    return found;
}}
"""
