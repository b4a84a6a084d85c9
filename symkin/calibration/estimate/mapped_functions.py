"""Evaluate CasADi functions of one configuration at n configurations: by CasADi's own map, and by
compiled C once that pays.

Libraries are kept in the cache folder (see `numeric.c_library`) and used from there at once; a new
one is compiled when as much time has gone into the map as the compiler is likely to take.
SYMKIN_ENGINE = numpy forbids compiled code, as it does for path tracking.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np

from symkin.computed_once import cached_property, computing
from symkin.homotopy.compiled import OFF
from symkin.numeric.c_library import CompilerError, find_compilers, load_library
from symkin.numeric.cache_folder import cache_folder
from symkin.numeric.mapped import Mapped

_INTERPRETED_BEFORE_COMPILING = 30000
"""A library is compiled when each of its instructions has been interpreted this often: about as
long as compiling it.
"""
_MAX_INSTRUCTIONS = 30000
"""Functions of more instructions than this are not compiled: the compiler would take longer than
the fit.
"""
_C_LOOP = """
int {name}_map(int n, const int* stride, const double** in, double** out) {{
  const double* arg[{args}]; double* res[{outs}]; casadi_int iw[{iw}]; double w[{w}]; int i, k;
  static const int sizes[{outs}] = {{{sizes}}};
  for (i = 0; i < n; ++i) {{
    for (k = 0; k < {n_in}; ++k) arg[k] = in[k] + (size_t)i * stride[k];
    for (k = 0; k < {n_out}; ++k) res[k] = out[k] + (size_t)i * sizes[k];
    {name}(arg, res, iw, w, 0);
  }}
  return 0;
}}
"""


class CompiledLibrary:
    """The compiled library of some functions: None until it is found or compiled."""

    def __init__(self, functions: Sequence[ca.Function]) -> None:
        self.functions = functions
        self.size = sum(f.n_instructions() for f in functions)
        self.library: ctypes.CDLL | None = None
        self.left = float("inf")
        if os.environ.get("SYMKIN_ENGINE", "") != OFF and self.size <= _MAX_INSTRUCTIONS:
            self.left = float(_INTERPRETED_BEFORE_COMPILING) * self.size
            self._load(build=False)

    def spend(self, instructions: int) -> ctypes.CDLL | None:
        """Count interpreted instructions, and compile the library when there were enough; return
        it.
        """
        self.left -= instructions
        if self.left <= 0.0:
            self.compile()
        return self.library

    def compile(self) -> None:
        """Compile now; without a compiler nothing changes."""
        with computing((id(self), "library")):
            if self.library is None and self.left < float("inf"):
                self._load(build=True)
            self.left = float("inf")

    def _load(self, *, build: bool) -> None:
        try:
            found = find_compilers(os.environ.get("CC", ""), os.environ.get("PATH", ""))
            quick = (
                replace(c, flags=tuple("-O1" if flag == "-O2" else flag for flag in c.flags))
                for c in found
            )
            symbols = [f"{f.name()}_map" for f in self.functions]
            sources = {"postures.c": _c_source(self.functions)}
            self.library = load_library(
                quick, sources, "postures.c", symbols, cache_folder(), build=build
            )
        except CompilerError:
            self.library = None


@dataclass(frozen=True, eq=False)
class MappedFunction:
    """A function of columns at n configurations at once: inputs (n, width) or (width,) for all;
    outputs (n, rows, columns).
    """

    function: ca.Function
    engine: CompiledLibrary

    def __call__(self, count: int, inputs: Sequence[np.ndarray]) -> list[np.ndarray]:
        cost, shapes = self._cost_and_shapes
        if self.engine.spend(count * cost) is None:
            return self._interpreted(*inputs)
        results = [np.empty((count, *shape)) for shape in shapes]
        inputs = [np.ascontiguousarray(a, dtype=float) for a in inputs]
        strides = (0 if a.ndim == 1 else a.shape[1] for a in inputs)
        pointers, ends = (
            (ctypes.c_void_p * len(arrays))(*(a.ctypes.data for a in arrays))
            for arrays in (inputs, results)
        )
        self._run(count, (ctypes.c_int * len(inputs))(*strides), pointers, ends)
        return [result.transpose(0, 2, 1) for result in results]

    @cached_property
    def _cost_and_shapes(self) -> tuple[int, list[tuple[int, int]]]:
        f = self.function
        shapes = [(f.size2_out(k), f.size1_out(k)) for k in range(f.n_out())]
        return int(f.n_instructions()), shapes

    @cached_property
    def _run(self) -> Any:
        return getattr(self.engine.library, f"{self.function.name()}_map")

    @cached_property
    def _interpreted(self) -> Mapped:
        return Mapped(self.function)


def map_functions(functions: Sequence[ca.Function]) -> list[MappedFunction]:
    """Map functions over configurations, with one library for all of them."""
    engine = CompiledLibrary(functions)
    return [MappedFunction(f, engine) for f in functions]


def _c_source(functions: Sequence[ca.Function]) -> str:
    generator = ca.CodeGenerator("postures.c", {"casadi_int": "int"})
    for f in functions:
        generator.add(f)
    loops = [
        _C_LOOP.format(
            name=f.name(),
            args=max(f.sz_arg(), 1),
            outs=max(f.sz_res(), 1),
            iw=max(f.sz_iw(), 1),
            w=max(f.sz_w(), 1),
            n_in=f.n_in(),
            n_out=f.n_out(),
            sizes=", ".join(str(f.numel_out(k)) for k in range(f.n_out())),
        )
        for f in functions
    ]
    return "\n".join(["#include <stddef.h>", str(generator.dump()), *loops])
