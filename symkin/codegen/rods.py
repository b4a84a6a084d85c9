"""C of platforms on six rods: explicit inverse, direct problem by Newton on the pose, no trigonometry."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.closure.snapping import snap
from symkin.codegen.emit import Emitter, Real, indent, indexed
from symkin.codegen.factor import curvature
from symkin.codegen.kernel import Kernel, Rods, rod_geometry, rod_kernel, rod_vectors
from symkin.codegen.options import Options
from symkin.codegen.source import KernelSource, common_values, copy, factored, fill, kernel_source
from symkin.model.limb import RodLimb
from symkin.model.mechanism import Mechanism
from symkin.spatial.backend import cross, dot
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import conjugate, multiply

_FIELDS = ("base", "platform", "offset")
_TARGET, _DRIVER = "/* Known values aimed at", "/* Newton's method along"


@dataclass(frozen=True, eq=False)
class RodPlatform:
    """A platform on six rods with its options: what the emitters read."""

    mechanism: Mechanism
    options: Options
    home: Pose
    real: Real

    @property
    def name(self) -> str:
        return self.mechanism.name

    @property
    def parameters(self) -> ca.SX:
        """Symbols of the geometry struct, limb by limb: base, platform, offset; none where the geometry is fixed."""
        return ca.SX.sym("g", 42) if self.options.geometry == "struct" else ca.SX(0, 1)

    @property
    def geometry_values(self) -> np.ndarray:
        """The struct's nominal numbers in its order."""
        parts = [[*limb.base, *limb.platform, limb.offset] for limb in self.mechanism.limbs if isinstance(limb, RodLimb)]
        return np.array(parts).ravel()

    @property
    def geometry_names(self) -> list[str]:
        if self.options.geometry != "struct":
            return []
        names: list[str] = []
        for k in range(6):
            names += indexed(f"geometry->base[{k}]", 3) + indexed(f"geometry->platform[{k}]", 3) + [f"geometry->offset[{k}]"]
        return names

    def rods(self, parameters: ca.SX) -> Rods:
        symbols = parameters if self.options.geometry == "struct" else None
        return rod_geometry(self.mechanism, self.home, relative=self.options.home_relative, parameters=symbols)

    def kernel(self) -> Kernel:
        parameters = self.parameters
        return rod_kernel(self.mechanism, self.rods(parameters), parameters, self.home)

    def lengths(self, pose: Pose) -> np.ndarray:
        """Joint values at an absolute pose (length unit)."""
        return rod_values(self.mechanism, pose)

    def stated(self, pose: Pose) -> np.ndarray:
        """The seven numbers by which generated code knows a pose: the pose, or its change from home."""
        if not self.options.home_relative:
            return np.array([*pose.position, *pose.quaternion])
        turn = multiply(pose.quaternion, conjugate(self.home.quaternion))
        return np.array([*(np.asarray(pose.position) - self.home.position), *turn])

    def joint_values(self, pose: Pose) -> np.ndarray:
        """Joint values as generated code takes them."""
        zero = self.lengths(self.home) if self.options.home_relative else 0.0
        return np.asarray(self.lengths(pose) - zero)


def rod_values(mechanism: Mechanism, pose: Pose) -> np.ndarray:
    """Joint values |p + R a - b| - offset of the rods at a pose (length unit)."""
    ends = [pose.apply(np.array(limb.platform)) - np.array(limb.base) for limb in mechanism.limbs]  # type: ignore[union-attr]
    return np.array([float(np.linalg.norm(d)) - limb.offset for d, limb in zip(ends, mechanism.limbs, strict=True)])  # type: ignore[union-attr]


def sample_poses(home: Pose, count: int, reach: float, tilt: float, seed: int) -> list[Pose]:
    """Random poses about home: positions within `reach`, rotation vectors within `tilt` (both per component)."""
    rng = np.random.default_rng(seed)
    poses = []
    for _ in range(count):
        shift, c = rng.uniform(-reach, reach, 3), 0.5 * rng.uniform(-tilt, tilt, 3)
        q = multiply(np.array([1.0, *c]), np.asarray(home.quaternion))
        poses.append(Pose(np.asarray(home.position) + shift, q / np.linalg.norm(q)))
    return poses


def sampled(platform: RodPlatform, kernel: Kernel) -> tuple[np.ndarray, float]:
    """Matrices at poses within a seventh of the size and 0.3 rad of home, and kappa there."""
    size = platform.mechanism.size
    poses = sample_poses(platform.home, 100, size / 7, 0.3, 1)
    geometry = platform.geometry_values if platform.options.geometry == "struct" else np.zeros(0)
    states = [platform.stated(pose) for pose in poses]
    matrices = np.array([kernel.matrix(state, np.zeros(6), geometry) for state in states])
    return matrices, curvature(kernel, states, [np.zeros(6)] * len(states), geometry)


def rod_source(platform: RodPlatform) -> tuple[str, KernelSource, dict[str, object]]:
    """Everything of NAME.c between its beginning and end, the kernel, and the values that other templates need."""
    real, name = platform.real, platform.name
    kernel = platform.kernel()
    rods = platform.rods(kernel.geometry)
    values = common_values(name, real, bool(platform.geometry_names)) | {"nq": 6, "ns": 7}
    matrices, kappa = sampled(platform, kernel)
    source = kernel_source(
        kernel, name, real, platform.geometry_names, matrices, _target(platform, rods, kernel.geometry), kappa,
        again=f"{name}_direct_again({values['ga']}w, to, aim, done);", guess=f"const {name}_pose *guess;", matrix=_matrix(platform),
    )  # fmt: skip
    literal = real.literal
    values |= {
        "least_norm": literal(0.98), "most_norm": literal(1.0201), "copy_joints": indent(copy("joints", "w.k", 6), 3),
        "enter": indent(["w->guess = guess;", f"status = {name}_unit(guess, w->x);"], 2),
        "leave": indent([*copy("pose->position", "w->x", 3), *(f"pose->quaternion[{i}] = w->x[{3 + i}];" for i in range(4))]),
        "agrees": "", "towards": "", "to": "joints", "whole": "", "track_factor": factored(kernel, f"{name}_direct", "&w", str(values["ga"])),
        "kappa": literal(float(np.sqrt(source.tuning.kappa2))), "track2": literal((platform.mechanism.size / 24) ** 2),
    }  # fmt: skip
    legs = _legs(platform, rods, kernel.geometry, values)
    before, after = source.text.split(_TARGET, 1)
    target, driver = after.split(_DRIVER, 1)
    text = fill("unit.c", values) + _check(platform, values) + before + legs + _TARGET + target
    text += fill("again.c", values | {"legs": indent(_leg_lines(platform, rods, kernel.geometry, values), 2)}) + _DRIVER + driver
    text += fill("direct.c", values) + "\n" + _inverse(platform, rods, kernel.geometry, values)
    return text, source, values


def _target(platform: RodPlatform, rods: Rods, geometry: ca.SX) -> list[str]:
    """w->k: squared lengths (2 L0 + dL) dL or L^2."""
    real = platform.real
    joints = ca.SX.sym("j", 6)
    if platform.options.home_relative:
        values = [(2 * rods.home_lengths[i] + joints[i]) * joints[i] for i in range(6)]
    else:
        values = [(joints[i] + rods.offsets[i]) ** 2 for i in range(6)]
    function = ca.Function("target", [joints, geometry], [ca.vertcat(*values)], {"cse": True})
    return _rolled(function, [indexed("to", 6), platform.geometry_names], real, "w->k")


def _rolled(function: ca.Function, names: list[list[str]], real: Real, target: str) -> list[str]:
    """Statements target[i] = output i: a loop where all six are alike, which takes less room."""
    each = []
    for i in range(6):
        emitter = Emitter(function, names, real, prefix="t")
        text = emitter.value(0, i)
        each.append([line.replace(f"[{i}]", "[i]") for line in [*emitter.lines, f"{target}[{i}] = {text};"]])
    if all(lines == each[0] for lines in each):
        return ["for (int i = 0; i < 6; ++i) {", *("    " + line for line in each[0]), "}"]
    unrolled = []
    for i in range(6):
        emitter = Emitter(function, names, real, prefix=f"t{i}_")
        text = emitter.value(0, i)
        unrolled += [*emitter.lines, f"{target}[{i}] = {text};"]
    return unrolled


def _matrix(platform: RodPlatform) -> list[str]:
    """Statements for [d, 4 b x d] in a loop: the fallback's matrix, where time does not matter but room does. The table
    holds 4 b without coordinates that are zero for all bases."""
    real = platform.real
    struct = platform.options.geometry == "struct"
    rows = platform.geometry_values.reshape(6, 7)[:, :3]
    kept = [k for k in range(3) if struct or np.any(rows[:, k] != 0.0)] or [0]
    numbers = ", ".join("{ " + ", ".join(real.literal(4.0 * snap(float(row[k]))) for k in kept) + " }" for row in rows)
    table = [] if struct else [f"static const {real.type} base[6][{len(kept)}] = {{ {numbers} }}; /* 4 b */"]
    b = "geometry->base[i]" if struct else "base[i]"
    four = f"{real.literal(4.0)} * " if struct else ""
    entries = [f"row[{k}] = d[{k}];" for k in range(3)]
    for k, m, n in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        plus = f"{four}b[{kept.index(m)}] * d[{n}]" if m in kept else ""
        minus = f"{four}b[{kept.index(n)}] * d[{m}]" if n in kept else ""
        text = f"{plus} - {minus}" if plus and minus else plus or (f"-({minus})" if minus else real.literal(0.0))
        entries.append(f"row[{3 + k}] = {text};")
    return [*table, "for (int i = 0; i < 6; ++i) {", f"    const {real.type} *const b = {b};", f"    const {real.type} *const d = &w->d[3 * i];",
            f"    {real.type} *const row = &w->a[6 * i];", *("    " + text for text in entries), "}"]  # fmt: skip


def _check(platform: RodPlatform, values: dict[str, object]) -> str:
    """Ranges: the limbs' own, and lengths that are positive. In float, where room counts, a loop where all are alike."""
    tests = _range_tests(platform)
    shown: dict[str, object] = {"before": "", "ranges": "\n        && ".join(tests)}
    alike = {test.replace(f"[{i}]", "[i]") for i, test in enumerate(tests)}
    if platform.real.name == "float" and len(tests) == 6 and len(alike) == 1:
        loop = [
            "bool inside = true;",
            "for (int i = 0; i < 6; ++i) {",
            f"    if (!{alike.pop()}) {{",
            "        inside = false;",
            "    }",
            "}",
        ]
        shown = {"before": indent(loop), "ranges": "inside"}
    return fill("joints.c", values | shown | {"positive": " and rods longer than zero"})


def _range_tests(platform: RodPlatform) -> list[str]:
    """C conditions that joint values must all satisfy, joint by joint."""
    real, size = platform.real, platform.mechanism.size
    slack = max(1e-9, 16 * real.epsilon) * size
    zero = platform.lengths(platform.home) if platform.options.home_relative else np.zeros(6)
    tests = []
    for i, limb in enumerate(platform.mechanism.limbs):
        assert isinstance(limb, RodLimb)  # noqa: S101 - a rod platform has no other limbs
        low = max(-limb.offset + 1e-6 * size, limb.limits[0] - slack if limb.limits else -np.inf) - zero[i]
        if platform.options.geometry == "struct" and not limb.limits and not platform.options.home_relative:
            tests.append(f"(joints[{i}] + geometry->offset[{i}] >= {real.literal(1e-6 * size)})")
        else:
            tests.append(f"(joints[{i}] >= {real.literal(low)})")
        if limb.limits:
            tests.append(f"(joints[{i}] <= {real.literal(limb.limits[1] + slack - zero[i])})")
    return tests


def _pose_function(rods: Rods, geometry: ca.SX) -> ca.Function:
    """Joint values, squared rod lengths' smallest and the Jacobian's rows at (position, quaternion)."""
    x = ca.SX.sym("x", 7)
    arms, d, delta = rod_vectors(rods, x[:3], x[3:])
    squared = [dot(v, v) for v in d]
    lengths = [ca.sqrt(s) for s in squared]
    if rods.home is None:
        joints = [length - offset for length, offset in zip(lengths, rods.offsets, strict=True)]
    else:
        joints = [
            dot(2 * d0 + change, change) / (length + length0)
            for d0, change, length, length0 in zip(rods.home, delta, lengths, rods.home_lengths, strict=True)
        ]
    rows = []
    for arm, v, length in zip(arms, d, lengths, strict=True):
        inverse = 1 / length
        rows.append(ca.vertcat(v * inverse, cross(arm, v) * inverse))
    smallest = squared[0]
    for s in squared[1:]:
        smallest = smallest * s
    return ca.Function("pose", [x, geometry], [ca.vertcat(*joints), ca.vertcat(*rows), smallest], {"cse": True})


def _leg_lines(platform: RodPlatform, rods: Rods, geometry: ca.SX, values: dict[str, object]) -> list[str]:
    """Joint values from the rows: with w->k = 0 they are -d.d, or -(2 d0 + delta).delta in the home-relative form."""
    real = platform.real
    f = ca.SX.sym("f", 6)
    if rods.home is None:
        joints = [ca.sqrt(-f[i]) - rods.offsets[i] for i in range(6)]
    else:
        joints = [-f[i] / (ca.sqrt(length**2 - f[i]) + length) for i, length in enumerate(rods.home_lengths)]
    function = ca.Function("legs", [f, geometry], [ca.vertcat(*joints)], {"cse": True})
    return [
        *(f"w->k[{i}] = {real.literal(0.0)};" for i in range(6)),
        f"{platform.name}_direct_rows({values['ga']}w);",
        *_rolled(function, [indexed("w->f", 6), platform.geometry_names], real, "w->k"),
    ]  # fmt: skip


def _legs(platform: RodPlatform, rods: Rods, geometry: ca.SX, values: dict[str, object]) -> str:
    """Joint values at a pose as a function, for the inverse problem."""
    body = _leg_lines(platform, rods, geometry, values)
    head = f"/* Joint values at the state, into w->k. */\nstatic void {platform.name}_legs({values['gp']}{platform.name}_direct_work *w)\n{{\n"
    return head + indent(body) + "\n}\n\n"


def _inverse(platform: RodPlatform, rods: Rods, geometry: ca.SX, values: dict[str, object]) -> str:
    emitter = Emitter(_pose_function(rods, geometry), [indexed("x", 7), platform.geometry_names], platform.real)
    shortest = emitter.value(2, 0)
    entries = [emitter.value(1, k) for k in range(36)]
    jacobian = [*emitter.lines, f"const {platform.real.type} shortest = {shortest};"]
    stores = [f"jacobian[{k}] = {text};" for k, text in enumerate(entries)]
    return fill("rods.c", values | {"jacobian": indent(jacobian, 2), "store_jacobian": indent(stores, 3)})
