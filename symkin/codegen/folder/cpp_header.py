"""Write a header for C++17 and later over the C: a namespace, sizes known to the compiler, arrays
or spans, results with their status.
"""

from __future__ import annotations

from symkin.codegen.map.program import Program
from symkin.codegen.map.signature import cpp_function
from symkin.codegen.text.templates import fill

_WORDS = """\
alignas alignof and and_eq asm auto bitand bitor bool break case catch char char8_t char16_t
char32_t class compl concept const consteval constexpr constinit const_cast continue
co_await co_return co_yield decltype default delete do double dynamic_cast else enum
explicit export extern false float for friend goto if inline int long mutable namespace new
noexcept not not_eq nullptr operator or or_eq private protected public register
reinterpret_cast requires return short signed sizeof static static_assert static_cast std
struct switch template this thread_local throw true try typedef typeid typename union
unsigned using virtual void volatile wchar_t while xor xor_eq
"""
_KEYWORDS = frozenset(_WORDS.split())
"""Words that no namespace can be called."""


_DERIVATIVES = """using matrix = std::array<real, joint_count * joint_count>;
struct derivatives {
    matrix jacobian;
    std::array<real, joint_count * joint_count * joint_count> second;
};"""
_TWIST = """using twist_values = std::array<real, 6>;
using matrix = std::array<real, 6 * joint_count>;"""


def cpp_text(program: Program) -> str:
    """NAME.hpp."""
    name = program.mechanism.name
    struct = program.options.geometry == "struct"
    is_map = program.options.is_map
    shown = program.values | {
        "namespace": f"{name}_kinematics" if name in _KEYWORDS else name,
        "functions": "\n".join(
            cpp_function(f, program.values, struct=struct) for f in program.functions
        ),
        "pose": "" if is_map else f"using pose = ::{name}_pose;",
        "arrays": _DERIVATIVES if is_map else _TWIST,
        "geometry_type": f"using geometry = ::{name}_geometry;" if struct else "",
        "limit": f"inline constexpr real track_limit = {name.upper()}_TRACK_LIMIT;"
        if f"{name.upper()}_TRACK_LIMIT" in program.header
        else "",
        "all": fill("all.hpp", program.values) if f"{name}_inverse_all(" in program.header else "",
    }
    return fill("header.hpp", shown)
