"""Write a header for C++17 and later over the C: a namespace, sizes known to the compiler, arrays
or spans, results with their status.
"""

from __future__ import annotations

from symkin.codegen.map.program import Program
from symkin.codegen.map.signature import Function
from symkin.codegen.text.templates import rendered, substitute

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


def cpp_text(program: Program) -> str:
    """NAME.hpp."""
    name = program.mechanism.name

    def words(function: Function) -> str:
        """The first sentence of what a function does."""
        return (
            " ".join(substitute(function.about, program.values).split()).split(". ")[0].rstrip(".")
        )

    return rendered(
        "header.hpp",
        **program.values,
        namespace=f"{name}_kinematics" if name in _KEYWORDS else name,
        functions=program.functions,
        words=words,
        is_map=program.options.is_map,
        struct=program.options.geometry == "struct",
        limit=f"{name.upper()}_TRACK_LIMIT" in program.header,
        branches=f"{name}_inverse_all(" in program.header,
    )
