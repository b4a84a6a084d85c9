"""Closure rows over the complex numbers: a system F(z, k) = 0 whose roots are tracked while k moves.

z holds angles, lengths / size and, where the pose is unknown, a projective point: Study coordinates (e, g / size), or
a quaternion. Rows are divided by the size. Evaluation is vectorised over paths: the SX graph is walked once into
straight-line NumPy code, in which every value is an array over the paths.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import casadi as ca
import numpy as np

from symkin.model.closure import AlgebraicClosure, build_algebraic_closure
from symkin.model.joint import Coordinate
from symkin.position.problem import Problem
from symkin.position.system import components
from symkin.spatial.rotation import conjugate, multiply

_BINARY = {ca.OP_ADD: "+", ca.OP_SUB: "-", ca.OP_MUL: "*", ca.OP_DIV: "/"}
_UNARY = {
    ca.OP_SIN: "sin({})", ca.OP_COS: "cos({})", ca.OP_TAN: "tan({})", ca.OP_SQRT: "sqrt({})", ca.OP_EXP: "exp({})",
    ca.OP_NEG: "-{}", ca.OP_SQ: "{0}*{0}", ca.OP_TWICE: "2.0*{}", ca.OP_INV: "1.0/{}", ca.OP_ASSIGN: "{}",
}  # fmt: skip


def vectorise(function: ca.Function) -> Callable[..., None]:
    """f(inputs..., outputs...): each input an array (length, n), each output a dense array (n, rows, columns) that is
    filled at the function's nonzeros. Raises NotImplementedError for an operation without a complex form."""
    lines, places = [], []
    for o in range(function.n_out()):
        rows, columns = function.sparsity_out(o).get_triplet()
        places.append(list(zip(rows, columns, strict=True)))
    for k in range(function.n_instructions()):
        op, i, o = function.instruction_id(k), function.instruction_input(k), function.instruction_output(k)
        if op == ca.OP_INPUT:
            lines.append(f"w{o[0]} = i{i[0]}[{i[1]}]")
        elif op == ca.OP_CONST:
            lines.append(f"w{o[0]} = {function.instruction_constant(k)!r}")
        elif op == ca.OP_OUTPUT:
            row, column = places[o[0]][o[1]]
            lines.append(f"o{o[0]}[:, {row}, {column}] = w{i[0]}")
        elif op in _BINARY:
            lines.append(f"w{o[0]} = w{i[0]} {_BINARY[op]} w{i[1]}")
        elif op in _UNARY:
            lines.append(f"w{o[0]} = " + _UNARY[op].format(f"w{i[0]}"))
        else:
            raise NotImplementedError(f"CasADi operation {op} has no complex form here")
    arguments = [f"i{k}" for k in range(function.n_in())] + [f"o{k}" for k in range(function.n_out())]
    source = f"def evaluate({', '.join(arguments)}):\n    " + "\n    ".join(lines or ["pass"])
    scope = {"sin": np.sin, "cos": np.cos, "tan": np.tan, "sqrt": np.sqrt, "exp": np.exp}
    exec(compile(source, "<closure>", "exec"), scope)
    evaluate: Callable[..., None] = scope["evaluate"]
    return evaluate


@dataclass(frozen=True, eq=False)
class AlgebraicSystem:
    """Rows of one block of a problem, lengths in units of `size`. `projective` are the places of a homogeneous group in z (a ray), empty if none;
    `unknowns` are the affine coordinates, in order, before it."""

    size: float
    unknowns: tuple[Coordinate, ...]
    z: ca.SX
    k: ca.SX
    rows: ca.SX
    projective: tuple[int, ...]

    @property
    def width(self) -> int:
        return int(self.z.shape[0])

    @property
    def count(self) -> int:
        return int(self.rows.shape[0])

    @cached_property
    def cost(self) -> int:
        """Instructions of one evaluation of the rows and their derivatives."""
        return int(self._function.n_instructions())

    @cached_property
    def _code(self) -> Callable[..., None]:
        return vectorise(self._function)

    @cached_property
    def _function(self) -> ca.Function:
        direction = ca.SX.sym("dk", self.k.shape[0])
        along = ca.jtimes(self.rows, self.k, direction)
        outputs = [self.rows, ca.jacobian(self.rows, self.z), along]
        return ca.Function("f", [self.z, self.k, direction], outputs, {"cse": True})

    @cached_property
    def _residual(self) -> Callable[..., None]:
        return vectorise(ca.Function("r", [self.z, self.k], [self.rows, ca.jacobian(self.rows, self.z)], {"cse": True}))

    def evaluate(self, z: np.ndarray, k: np.ndarray, dk: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """F (n, rows), dF/dz (n, rows, width) and dF/dk dk (n, rows) at z (width, n), k (known, n), dk (known,)."""
        n = z.shape[1]
        f, j, t = (np.zeros((n, self.count, c), dtype=complex) for c in (1, self.width, 1))
        self._code(z, k, dk, f, j, t)
        return f[:, :, 0], j, t[:, :, 0]

    def linearise(self, z: np.ndarray, k: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """F and dF/dz at z (width, n), k (known, n)."""
        n = z.shape[1]
        f, j = (np.zeros((n, self.count, c), dtype=complex) for c in (1, self.width))
        self._residual(z, k, f, j)
        return f[:, :, 0], j

    def features(self, z: np.ndarray) -> np.ndarray:
        """Coordinates (n, any) in which equal roots are equal: cos and sin of angles, squares of rod lengths, the
        projector of the ray."""
        parts: list[np.ndarray] = []
        for i, c in enumerate(self.unknowns):
            if c.kind == "angle":
                parts += [np.cos(z[i]), np.sin(z[i])]
            else:
                parts.append(z[i] if c.least is None else (z[i] - c.least / self.size) ** 2)
        if self.projective:
            ray = z[list(self.projective)]
            ray = ray / np.linalg.norm(ray, axis=0)
            parts += list((ray[:, None] * np.conj(ray[None])).reshape(-1, ray.shape[1]))
        return np.array(parts).T

    def normalise(self, z: np.ndarray) -> np.ndarray:
        """Rays to unit length, angles into (-pi, pi]."""
        z = z.copy()
        if self.projective:
            p = list(self.projective)
            z[p] = z[p] / np.linalg.norm(z[p], axis=0)
        for i, c in enumerate(self.unknowns):
            if c.kind == "angle":
                z[i] -= 2 * np.pi * np.round(z[i].real / (2 * np.pi))
        return z


@lru_cache(maxsize=64)
def algebraic_systems(problem: Problem) -> tuple[AlgebraicSystem, ...]:
    """The blocks of a problem over the complex numbers."""
    algebraic = build_algebraic_closure(problem.mechanism, "study" if problem.kind == "direct" else "homogeneous")
    closure, size = problem.closure, problem.closure.size
    joints = closure.role("actuated", "passive")
    roles = ("passive",) if problem.kind == "direct" else ("actuated", "passive")
    unknowns = tuple(c for c in joints if c.role in roles)
    symbols = {c.name: algebraic.joints[k] for k, c in enumerate(joints)}
    z_parts, k_parts = [symbols[c.name] for c in unknowns], [symbols[c.name] for c in joints if c not in unknowns]
    scale_z = [1.0 if c.is_angular else size for c in unknowns]
    scale_k = [1.0 if c.is_angular else size for c in joints if c not in unknowns]
    pose_scale = _pose_scale(algebraic, closure.role("pose"), size)
    pose_unknown = problem.kind == "direct"
    rows = list(ca.vertsplit(algebraic.rows))
    projective: tuple[int, ...] = ()
    affine = unknowns
    if pose_unknown:
        if algebraic.form is None:
            affine = (*unknowns, *closure.role("pose"))
        else:
            width = int(algebraic.pose.shape[0])
            projective = tuple(range(len(unknowns), len(unknowns) + width))
            if width == 8:
                rows.append(ca.dot(algebraic.pose[:4], algebraic.pose[4:]))
        z_parts.append(algebraic.pose)
        scale_z += pose_scale
    else:
        k_parts.append(algebraic.pose)
        scale_k += pose_scale
    z, k = ca.vertcat(*z_parts), ca.vertcat(*k_parts)
    expression = ca.substitute(ca.vertcat(*rows) / size, ca.vertcat(z, k), ca.vertcat(z * ca.DM(scale_z), k * ca.DM(scale_k)))
    return _blocks(AlgebraicSystem(size, affine, z, k, expression, projective))


def _blocks(whole: AlgebraicSystem) -> tuple[AlgebraicSystem, ...]:
    """Independent parts; rows without unknowns (conditions on the given values) belong to none."""
    if whole.projective:
        return (whole,)
    pattern = np.asarray(ca.DM(ca.jacobian_sparsity(whole.rows, whole.z), 1)) != 0
    blocks = []
    for group in components([set(np.flatnonzero(row).tolist()) for row in pattern], whole.width):
        places = sorted(group)
        rows = [i for i in range(whole.count) if pattern[i, places].any()]
        unknowns = tuple(whole.unknowns[i] for i in places)
        blocks.append(AlgebraicSystem(whole.size, unknowns, whole.z[places], whole.k, whole.rows[rows, 0], ()))
    return tuple(blocks)


def _pose_scale(algebraic: AlgebraicClosure, pose: Sequence[Coordinate], size: float) -> list[float]:
    if algebraic.form is None:
        return [1.0 if c.is_angular else size for c in pose]
    width = int(algebraic.pose.shape[0])
    if width == 4:
        return [1.0] * 4
    return [1.0] * 4 + [size] * 4 if width == 8 else [size] * 3 + [1.0] * 4


def known_values(problem: Problem, known: np.ndarray) -> np.ndarray:
    """Known values of a problem as the algebraic system takes them."""
    size = problem.closure.size
    coordinates = problem.known_coordinates
    scale = np.concatenate([np.full(c.width, 1.0 if c.is_angular or c.kind == "quaternion" else size) for c in coordinates])
    return np.asarray(known / scale)


def real_values(system: AlgebraicSystem, z: np.ndarray) -> dict[str, np.ndarray]:
    """Coordinates of the block (radians, length unit, unit quaternion) from a root that is real up to rounding."""
    size = system.size
    values = {c.name: np.array([z[i].real * (1.0 if c.is_angular else size)]) for i, c in enumerate(system.unknowns)}
    if system.projective:
        ray = _real_ray(z[list(system.projective)])
        length = np.linalg.norm(ray[:4])
        values["pose.quaternion"] = ray[:4] / length
        if len(ray) == 8:
            position = 2 * size * multiply(ray[4:] / length, conjugate(ray[:4] / length))[1:]
            values |= {f"pose.{axis}": position[i : i + 1] for i, axis in enumerate("xyz")}
    return values


def algebraic_point(system: AlgebraicSystem, values: dict[str, np.ndarray]) -> np.ndarray:
    """z of a real root given as coordinates of the block: the inverse of `real_values`."""
    z = [values[c.name] / (1.0 if c.is_angular else system.size) for c in system.unknowns]
    if system.projective:
        e = values["pose.quaternion"]
        z.append(e)
        if len(system.projective) == 8:
            t = np.concatenate([[0.0], *(values[f"pose.{axis}"] / system.size for axis in "xyz")])
            z.append(0.5 * multiply(t, e))
    return np.concatenate(z).astype(complex)


def imaginary_part(system: AlgebraicSystem, z: np.ndarray) -> np.ndarray:
    """How far each root (width, n) is from being real: largest imaginary part, rays turned to their best phase."""
    affine = [i for i in range(system.width) if i not in set(system.projective)]
    parts = [np.abs(z[affine].imag)]
    if system.projective:
        ray = z[list(system.projective)]
        parts.append(np.abs((ray / ray[np.argmax(np.abs(ray), axis=0), np.arange(ray.shape[1])]).imag))
    return np.asarray(np.max(np.concatenate(parts), axis=0, initial=0.0))


def rotation_share(system: AlgebraicSystem, z: np.ndarray) -> np.ndarray:
    """|e| over the length of the ray (e, g): zero where a root is at infinity."""
    if not system.projective:
        return np.ones(z.shape[1])
    ray = z[list(system.projective)]
    return np.asarray(np.linalg.norm(ray[:4], axis=0) / np.linalg.norm(ray, axis=0))


def _real_ray(ray: np.ndarray) -> np.ndarray:
    return np.asarray((ray / ray[np.argmax(np.abs(ray))]).real)
