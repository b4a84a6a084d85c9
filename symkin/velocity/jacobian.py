"""Symbolic Jacobians of a mechanism: expressions of named variables, their time derivative and
their Hessian.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Unpack

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure
from symkin.computed_once import cached_property, lru_cache
from symkin.errors import InputError
from symkin.machine.limbs import with_limbs
from symkin.machine.lower import arm_or_limbs
from symkin.model.mechanism import Mechanism, require_mechanism
from symkin.position.given import checked_names, given_coordinates
from symkin.position.problem import actuated_names, build_problem
from symkin.position.solution import Solution
from symkin.position.solve_result import SolveError
from symkin.position.transfer import many_of_machine, own_closure
from symkin.result import Result, Summary, json_fields
from symkin.spatial.backend import stacked
from symkin.text import not_among
from symkin.velocity.differential import variable_rates
from symkin.velocity.equations import VelocityEquations, velocity_equations
from symkin.velocity.jacobian_names import KINDS, Matrix, Variable, variables_read
from symkin.velocity.kinds import driven_places, matrix_of
from symkin.velocity.options import JacobianOptions
from symkin.velocity.rates import Rates, graph_rates, rates_by_name
from symkin.verb import verb

Values = Solution | Mapping[str, Any] | np.ndarray
"""A configuration: a Solution, its `values`, or the vector of the closure's variables."""


@dataclass(frozen=True, eq=False, repr=False)
class Jacobian(Result):
    """A Jacobian of a mechanism as an expression of its closure's variables, at any regular closed
    configuration.

    kind         matrix                                                              shape
    "direct"     t = J q', the twist t = (velocity of the platform's or tool's       6 x n
                 origin; angular velocity), both in the base frame
    "inverse"    q' = J^-1 t for feasible twists t, 0 for those orthogonal to all    n x 6
                 feasible ones (angular velocities times the mechanism's size)
    "analytic"   rates of the pose coordinates = Ja q': x, y, z and the unit         k x n
                 quaternion; x, y, z, gamma or fewer for restricted motions; of a
                 serial arm's quaternion as a continuous function of its joints
    "passive"    x' = Jp q', the passive joints, but for those of links that may     p x n
                 spin between two balls; a spherical joint has its angular
                 velocity in the frame before the joint
    "rates"      rates of the coordinates in `rows` by those in `columns`, told by
                 name

    Lengths are in the mechanism's length unit, angles in rad. `expression` reads the `symbols` of
    `inputs` (coordinates) and of `parameters` (empty where the geometry is bound); `rows` and
    `columns` name the matrix's. With more actuated joints than freedoms, "direct" takes rates that
    no motion has by least squares of the closure's rows, and where an arm's joints have more
    freedom than its tool, "inverse" gives the shortest rates. Poles: see
    `symkin.velocity.equations`. `at` evaluates the matrix, `function` is a CasADi
    function, `plot(at=...)` draws the matrix at a configuration.

    >>> import symkin
    >>> platform = symkin.load("zhang2009")
    >>> J = symkin.jacobian(platform, "inverse")
    >>> J.at(symkin.solve(platform, pose=[10, 20, 300, 1, 0, 0, 0]).solution).shape
    (6, 6)
    """

    mechanism: Mechanism
    kind: str
    expression: ca.SX
    inputs: tuple[Variable, ...]
    parameters: tuple[Variable, ...]
    rows: tuple[str, ...]
    columns: tuple[str, ...]
    expressions: Rates

    @property
    def closure(self) -> Closure:
        return self.expressions.closure

    @property
    def shape(self) -> tuple[int, int]:
        return len(self.rows), len(self.columns)

    @property
    def symbols(self) -> ca.SX:
        """Inputs, then parameters, as one column."""
        parts = [self.closure.variables[v.index] for v in self.inputs] + [
            self.closure.parameters[v.index] for v in self.parameters
        ]
        return stacked(parts)

    @cached_property
    def function(self) -> ca.Function:
        """A CasADi function of one scalar for each input and parameter, by name, with the output
        `jacobian`.
        """
        names = [v.name for v in (*self.inputs, *self.parameters)]
        outputs = [ca.densify(self.expression)]
        name = ca.Function.fix_name(f"{self.mechanism.name}_{self.kind}_jacobian")
        inputs = ca.vertsplit(self.symbols) if names else []
        return ca.Function(name, inputs, outputs, names, ["jacobian"], {"cse": True})

    def at(self, values: Values, parameters: np.ndarray | None = None) -> np.ndarray:
        """The matrix at a closed configuration: a Solution, its `values` (those of the inputs
        suffice), or the closure's vector (radians, length unit). `parameters` are all of the
        closure's (`closure.parameter_names`); nominal without. Raises SolveError where coordinates
        that are told by name do not decide the rates that are asked for, which all coordinates
        tell.
        """
        geometry = (
            self.closure.parameter_values
            if parameters is None
            else np.asarray(parameters, dtype=float)
        )
        if geometry.shape != self.closure.parameter_values.shape:
            raise InputError(
                f"parameters: {geometry.size} values given, {self.closure.parameter_values.size} "
                f"are needed"
            )
        z = variables_of(self.closure, values, {v.coordinate for v in self.inputs})
        for v in self.inputs:
            if not np.isfinite(z[v.index]):
                raise InputError(f"values: {v.source} = {z[v.index]:g} is not finite")
        found = np.asarray(self._value(z, geometry))
        if self.expressions.limbs is None:
            if np.isfinite(z).all():
                self.expressions.refuse_singular(z, self.rows if self.kind == "rates" else ())
            if not np.isfinite(found).all():
                raise SolveError(
                    f"{self.mechanism.name}: {self._what}: not defined at this configuration: it "
                    f"is singular"
                )
        return found

    # --- second order -----------------------------------------------------------------------------

    @cached_property
    def rates(self) -> ca.SX:
        """Symbols of the rates that `time_derivative` reads: (q'; x'; t), n + p + 6 numbers; of
        coordinates told by name all rates, the known ones first.
        """
        return ca.SX.sym("rate", self.expressions.following.shape[0])

    @cached_property
    def time_derivative(self) -> ca.SX:
        """dJ/dt over the variables and `rates`: the sum of dJ/dz z' over the variables z,
        quaternions with q' = (0, w) q / 2.
        """
        return self._along(self.rates)

    @cached_property
    def hessian(self) -> tuple[ca.SX, ...]:
        """dJ/dq_k for each actuated joint, all others held and the loops kept closed: n matrices of
        J's shape. With more actuated joints than freedoms one joint cannot move alone; x' and t are
        then those of "passive" and "direct".
        """
        following = self._by_driven
        return tuple(self._along(following[:, k]) for k in range(following.shape[1]))

    def time_derivative_at(self, values: Values, rates: Sequence[float] | np.ndarray) -> np.ndarray:
        """dJ/dt at a configuration; `rates` are n actuated ones (the others follow from them) or
        all of (q'; x'; t).
        """
        given, z = np.asarray(rates, dtype=float), variables_of(self.closure, values)
        all_rates, n = self._by_driven.shape
        if given.shape == (n,):
            given = np.asarray(self._following(z, self._geometry)) @ given
        if given.shape != (all_rates,):
            raise InputError(
                f"rates: {given.size} values given; allowed are {n} (the actuated joints') or "
                f"{all_rates} (actuated, passive, twist)"
            )
        return np.asarray(self._rate(z, self._geometry, given))

    def hessian_at(self, values: Values) -> np.ndarray:
        """(n, rows, columns): dJ/dq_k along the closure."""
        stacked = np.asarray(self._curvature(variables_of(self.closure, values), self._geometry))
        return stacked.reshape(-1, *self.shape)

    @property
    def _geometry(self) -> np.ndarray:
        return self.closure.parameter_values

    @cached_property
    def _value(self) -> ca.Function:
        return self._made("value", [], [self.expression])

    @cached_property
    def _rate(self) -> ca.Function:
        return self._made("rate", [self.rates], [self.time_derivative])

    @cached_property
    def _curvature(self) -> ca.Function:
        return self._made("curvature", [], [ca.vertcat(*self.hessian)])

    @cached_property
    def _following(self) -> ca.Function:
        return self._made("following", [], [self._by_driven])

    @property
    def _by_driven(self) -> ca.SX:
        """All rates by those of the known coordinates, in the order of the description."""
        following = self.expressions.following
        if self.kind == "rates":
            return following
        return following[:, list(driven_places(self.expressions, self.mechanism).values())]

    def _made(self, name: str, more: list[ca.SX], outputs: list[ca.SX]) -> ca.Function:
        inputs = [self.closure.variables, self.closure.parameters, *more]
        return ca.Function(name, inputs, [ca.densify(output) for output in outputs], {"cse": True})

    def _along(self, rates: ca.SX) -> ca.SX:
        speeds = variable_rates(self.closure, self.expressions.split(rates))
        flat = ca.jtimes(ca.vec(ca.densify(self.expression)), self.closure.variables, speeds)
        return ca.reshape(flat, *self.expression.shape)

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        """Pickle as the mechanism and what is asked, from which the expression is built anew."""
        names = (self.rows, self.columns) if self.kind == "rates" else ((), ())
        return _built, (self.mechanism, self.kind, bool(self.parameters), *names)

    # --- as text and as JSON ----------------------------------------------------------------------

    def to_dict(self) -> dict[str, Any]:
        """What the matrix relates: kind, names of rows and columns, and what each entry reads."""
        return {
            "mechanism": self.mechanism.name,
            **json_fields(self, "kind", "rows", "columns"),
            "inputs": [json_fields(v, "name", "source", "unit") for v in self.inputs],
            "parameters": [v.source for v in self.parameters],
        }

    def summary(self, most_rows: int | None = None) -> Summary:  # noqa: ARG002 - there is no table
        """The matrix' kind and shape, and the names of what it reads."""
        inputs = ", ".join(v.name for v in self.inputs) or "nothing"
        rows, columns = self.shape
        return Summary([f"{self.mechanism.name}: {self._what}, {rows} x {columns}, of {inputs}"])

    @property
    def _what(self) -> str:
        if self.kind != "rates":
            return f"{self.kind} Jacobian"
        return f"rates of {', '.join(self.rows)} by those of {', '.join(self.columns)}"


def variables_of(
    closure: Closure,
    values: Values,
    needed: Collection[str] | None = None,
) -> np.ndarray:
    """The full vector of a closure's variables from a Solution, its `values`, or the vector itself;
    coordinates that are not `needed` may be missing, and are NaN then.
    """
    named: Any = values
    if isinstance(values, Solution):
        low = None if values.mechanism == closure.mechanism else arm_or_limbs(values.mechanism)
        if (values.mechanism if low is None else low.machine) == closure.mechanism:
            own = own_closure(values)
            named = many_of_machine(closure, own, values.variables[None], low)[0]
        else:
            named = values.all_values
    if isinstance(named, Mapping):
        names = [c.name for c in closure.coordinates if needed is None or c.name in needed]
        missing = [name for name in names if name not in named]
        if missing:
            raise InputError(f"values: {missing[0]} is missing; needed are {', '.join(names)}")
        parts = [
            np.atleast_1d(np.asarray(named.get(c.name, [np.nan] * c.width), dtype=float))
            for c in closure.coordinates
        ]
        named = np.concatenate(parts)
    vector = np.asarray(named, dtype=float)
    if vector.shape != closure.reference.shape:
        raise InputError(
            f"values: shape {vector.shape} given, the closure has {closure.reference.size} "
            f"variables"
        )
    return vector


@verb(JacobianOptions)
def jacobian(
    mechanism: Mechanism, kind: str | None = None, **options: Unpack[JacobianOptions]
) -> Jacobian:
    """Build a symbolic Jacobian of a mechanism from its velocity equations A t + P x' + B q' = 0.

    `kind` is "direct" (t = J q', the default), "inverse" (q' = J^-1 t), "analytic" (rates of the
    pose coordinates) or "passive" (x' = Jp q'), as `Jacobian` says with shapes and units. With
    `parameters` the geometry stays symbols, else it is bound as numbers. Passive joints are
    eliminated with orthogonal projections, in parts that share none (see
    `symkin.velocity.equations`); of a graph of links with a platform link, group by group, with
    geometry as numbers. `of` and `by` name coordinates of any mechanism, a graph of links too:
    joints, passive ones too, and x, y, z, azimuth, tilt, torsion of the platform; the matrix is
    that of the rates of `of` by those of `by`, which are as many as the mobility. Raises InputError
    for a kind that is unknown or that the mechanism lacks, and for names that nothing has or that
    do not decide the motion.

        >>> import symkin
        >>> arm = symkin.load("gluon_6l3")
        >>> direct = symkin.jacobian(arm)
        >>> direct.shape, direct.columns[:2]
        ((6, 6), ('q1', 'q2'))
        >>> home = symkin.solve(arm, joints=[10, 20, 30, 40, 50, 60]).solution
        >>> bool(abs(direct.at(home) @ symkin.jacobian(arm, "inverse").at(home) - 1)[0, 0] < 1e-9)
        True
    """
    parameters, of, by = options["parameters"], options["of"], options["by"]
    require_mechanism(mechanism)
    if of is not None or by is not None:
        if kind is not None or parameters or of is None or by is None:
            raise InputError(
                "of and by (--of, --by) name the coordinates whose rates are related: give both, "
                "and neither kind (--kind) nor parameters"
            )
        known = given_coordinates(mechanism)
        rows = checked_names(mechanism, of, "of", known)
        return _built(mechanism, "rates", False, rows, checked_names(mechanism, by, "by", known))
    kind = "direct" if kind is None else kind
    if kind not in KINDS:
        raise InputError(f"kind = {not_among(kind, KINDS)}")
    if parameters:
        with_limbs(
            mechanism,
            "a Jacobian with symbols for the geometry",
            "leave parameters out",
            arms_only=True,
        )
    if not mechanism.actuated:
        raise InputError(
            f"{mechanism.name} has no actuated joint, and a Jacobian relates their rates: mark "
            f"joints `actuated = true`"
        )
    return _built(mechanism, kind, parameters)


@lru_cache(maxsize=128)
def _built(
    mechanism: Mechanism,
    kind: Any,
    parameters: bool,
    of: tuple[str, ...] = (),
    by: tuple[str, ...] = (),
) -> Jacobian:
    low = None if of else arm_or_limbs(mechanism)
    if kind == "passive" and mechanism.is_graph and low is not None and not low.machine.serial:
        low = None  # rates of joints alone need no pose
    if low is None:
        if of:
            return _with_inputs(mechanism, kind, *rates_by_name(mechanism, of, by))
        named = graph_rates(mechanism, kind)
        return _with_inputs(mechanism, kind, named, matrix_of(named, kind, mechanism))
    equations = velocity_equations(
        low.machine, mechanism.characteristic_length, bound=not parameters
    )
    _check_defined(equations, kind)
    made = Rates(build_problem(low.machine, actuated_names(low.machine)), equations)
    matrix = matrix_of(made, kind, mechanism)
    return _with_inputs(mechanism, kind, made, matrix, parameters=parameters)


def _with_inputs(
    mechanism: Mechanism,
    kind: str,
    expressions: Rates,
    matrix: Matrix,
    *,
    parameters: bool = False,
) -> Jacobian:
    limbs = expressions.limbs
    explicit = limbs is not None and limbs.differential.explicit
    expression = ca.sparsify(matrix.expression)
    inputs, numbers = variables_read(expressions.closure, expression, explicit=explicit)
    return Jacobian(
        mechanism=mechanism,
        kind=kind,
        expression=expression,
        inputs=inputs,
        parameters=numbers if parameters else (),
        rows=matrix.rows,
        columns=matrix.columns,
        expressions=expressions,
    )


def _check_defined(equations: VelocityEquations, kind: str) -> None:
    mechanism = equations.closure.mechanism
    if kind != "inverse" and equations.freedom:
        raise InputError(
            f"{mechanism.name}: the {kind} Jacobian is not defined; with its "
            f"{len(mechanism.actuated)} actuated joints held the "
            f"platform keeps {equations.freedom} of its freedoms: actuate more joints, or declare "
            f"its motion"
        )
