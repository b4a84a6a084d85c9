"""Find singularity loci over a plane of two coordinates: curves of true zeros, met from random
configurations and traced.

Over two pose coordinates the loci belong to poses; over two actuated joints they bound the regions
in which the number of real assembly modes is constant, and have cusps where three modes meet.
Seeds: random configurations over the plane are closed, lifted by null vectors of small singular
values (`locus_system`) and brought onto the curve by Levenberg-Marquardt; then the curve is traced
(`curve`). A closed curve that no seed reaches is missed: `starts` says how many random
configurations there were, `hits` how many of them led to each curve.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Unpack

import numpy as np

from symkin.closure.closure import build_closure
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.position.pose_conditions import condition_sentence
from symkin.position.problem import actuated_names
from symkin.position.solution import Solution
from symkin.singularities.loci import LOST_OVER_PLANE, MISSING, NONE_MET, Loci
from symkin.singularities.locus import Locus, make_locus, merged
from symkin.singularities.locus_search import seeds_of, traced_curves
from symkin.singularities.locus_system import LocusSystem, Plane, locus_systems, plane_of
from symkin.singularities.motion_ranks import generic_ranks
from symkin.singularities.options import LociOptions
from symkin.velocity.roles import Roles
from symkin.verb import verb
from symkin.verb_options import check_seed

DEFAULT_STARTS = 200
MOST_STARTS = 100_000
_FEW_HITS = 2
"""Where some curve was met by no more starts than this, another may have been met by none."""


@verb(LociOptions)
def singular_loci(solution: Solution, plane: Sequence[str], **options: Unpack[LociOptions]) -> Loci:
    """Find the curves of singular configurations over two coordinates, or the points over one, all
    others as in `solution`.

    A curve is F = 0, J w = 0, w.w = 1 over the plane's coordinates (u, v), the free ones and w,
    with J the part of dF/d(q, x, X) that loses rank: type 2 for all unknowns of the direct problem,
    type 1 for one limb's joints (Gosselin and Angeles 1990). Every equation is solved at every
    point. A closed curve that no start reaches is missed: `Loci.notes` say so.

    `solution` is a configuration, from `symkin.solve` or `symkin.modes`; its working mode is the
    one that `Locus.in_mode` names. `plane` names two actuated joints or two pose coordinates, with
    the same meaning as in `symkin.sweep`: x, y, z, gamma (about z, from the reference), or the
    rotation vector rx, ry, rz (base frame, before the orientation of `solution`). `ranges` are two
    pairs in the mechanism's units, by default half the size or half a turn to both sides; `kinds`
    the curves that are sought; `starts` (1 to 100,000, default 200) the random configurations,
    `seed` (default 0) which. Raises InputError for values that do not fit.

    `given` names all coordinates that are known, as many as the mobility; the plane's are then two
    of them, or one, and the curves, or points, are where they do not decide the others (type 2).
    For a graph of links these are the actuated joints, if none are named.

        >>> import symkin
        >>> platform = symkin.load("zhang2009")
        >>> home = symkin.solve(platform).solution
        >>> loci = symkin.singular_loci(home, ("x", "y"), kinds=("type 2",), starts=10)
        >>> {curve.kind for curve in loci.curves}
        {'type 2'}
        >>> corner = loci.given(loci.curves[0].points[0])
        >>> symkin.singularity(platform, **corner).kinds
        ('type 2',)
        >>> slider = symkin.solve(symkin.load("slider_crank")).solution
        >>> dead = symkin.singular_loci(
        ...     slider, ["piston"], given=["piston"], ranges=[(0.0, 200.0)], starts=50
        ... )
        >>> [round(float(point.points[0, 0]), 6) for point in dead.curves]
        [45.0, 125.0]
    """
    if not isinstance(solution, Solution):
        raise InputError(
            f"solution is of type {type(solution).__name__}; a Solution is needed, such as "
            f"symkin.solve(mechanism).solution"
        )
    kinds = options["kinds"]
    starts = DEFAULT_STARTS if options["starts"] is None else options["starts"]
    seed = 0 if options["seed"] is None else options["seed"]
    chosen = plane_of(solution, plane, options["given"])
    _check(chosen, kinds, starts, seed)
    window = _window(chosen, options["ranges"])
    curves: list[Locus] = []
    notes: list[str] = []
    for system in locus_systems(chosen, kinds):
        found, said = _curves(system, window, starts, np.random.default_rng(seed))
        curves.extend(found)
        notes.extend(said)
    sides = tuple(
        (chosen.mechanism.value_out(c, low), chosen.mechanism.value_out(c, high))
        for c, (low, high) in zip(chosen.coordinates, window.tolist(), strict=True)
    )
    kept = merged(curves, np.ptp(sides, axis=1))
    if any(curve.hits <= _FEW_HITS and (not curve.is_point or len(sides) == 1) for curve in kept):
        notes.append(MISSING)
    if not kept and not any(note.endswith(LOST_OVER_PLANE) for note in notes):
        notes.append(NONE_MET)
    return Loci(
        chosen, sides, curves=kept, starts=starts, seed=seed, notes=tuple(dict.fromkeys(notes))
    )


def _check(plane: Plane, kinds: Sequence[str], starts: int, seed: int) -> None:
    check_seed(seed)
    if not 1 <= starts <= MOST_STARTS:
        raise InputError(f"starts = {starts}; allowed: 1 to {MOST_STARTS}")
    if not kinds or any(kind not in ("type 1", "type 2") for kind in kinds):
        raise InputError(f"kinds = {', '.join(kinds)!r}; allowed: type 1, type 2")
    if plane.by_name and "type 2" not in kinds:
        raise InputError(
            "kinds = 'type 1': over given coordinates curves are type 2, where these do not decide "
            "the others"
        )
    if plane.of_pose:
        check_poses_vary(plane.closure.mechanism, plane.names)


def check_poses_vary(machine: Mechanism, names: Sequence[str]) -> None:
    """Raise InputError unless every pose near a configuration is one that the machine takes."""
    freedoms = generic_ranks(Roles.of_limbs(machine)).outputs
    wanted = sum(c.freedom for c in build_closure(machine).role("pose"))
    if freedoms < wanted:
        joints = f"one or two of the actuated joints {', '.join(actuated_names(machine))}"
        sentence = condition_sentence(
            machine, "pose coordinates in general", joints, freedoms, wanted
        )
        raise InputError(f"plane = {', '.join(names)!r}: {sentence}")


def _window(plane: Plane, ranges: Sequence[Sequence[float]] | None) -> np.ndarray:
    """Sides (2, 2), or (1, 2) over one coordinate, in inside units."""
    if ranges is None:
        size = plane.closure.characteristic_length
        half = np.array([[np.pi if c.is_angular else 0.5 * size] for c in plane.coordinates])
        sides = np.array([[c.reference[0]] for c in plane.coordinates]) + [-1.0, 1.0] * half
    else:
        sides = (
            np.array([_side(plane, k, r) for k, r in enumerate(ranges)])
            if len(ranges) == len(plane.names)
            else np.zeros((0, 2))
        )
        if len(sides) != len(plane.names):
            needed = (
                "two are needed, one for each of" if len(plane.names) == 2 else "one is needed, for"
            )
            raise InputError(f"ranges: {len(ranges)} given, {needed} {', '.join(plane.names)}")
    for k, c in enumerate(plane.coordinates):
        if c.least is not None:
            sides[k, 0] = max(sides[k, 0], c.least) + 0.0
            if not sides[k, 0] < sides[k, 1]:
                raise InputError(
                    f"range of {plane.names[k]} ends at {sides[k, 1]:g} "
                    f"{plane.mechanism.length_unit}; allowed: above "
                    f"{c.least + 0.0:g}, where the rod has no length"
                )
    return sides


def _side(plane: Plane, k: int, given: Sequence[float]) -> tuple[float, float]:
    low, high = (float(v) for v in given) if len(given) == 2 else (0.0, 0.0)
    if not (np.isfinite([low, high]).all() and low < high):
        raise InputError(
            f"range of {plane.names[k]} = {list(given)}; two numbers are needed, the lower one "
            f"first"
        )
    c, mechanism = plane.coordinates[k], plane.mechanism
    return mechanism.value_in(c, low), mechanism.value_in(c, high)


# --- curves ---------------------------------------------------------------------------------------


def _curves(
    system: LocusSystem, window: np.ndarray, starts: int, rng: np.random.Generator
) -> tuple[list[Locus], list[str]]:
    """Distinct curves through the seeds, and what to say of the search."""
    found = seeds_of(system, window, starts, rng)
    if not found.closed:
        return [], [f"{system.name}: none of {starts} starts closes over the window"]
    notes = _permanent_motions(system)
    if found.lost_everywhere:
        return [], [*notes, f"{system.name}: {LOST_OVER_PLANE}"]
    traced, isolated = traced_curves(system, found, window)
    if isolated:
        notes.append(
            f"{system.name}: {isolated} starts ended on no curve (crossings, isolated points, or "
            f"sets of more than one dimension)"
        )
    return [make_locus(t.system, t.curve, t.cusps, t.in_mode, len(t.starts)) for t in traced], notes


def _permanent_motions(system: LocusSystem) -> list[str]:
    """What moves at every configuration: curves are where more does."""
    count = system.loss.free_motions
    if not count:
        return []
    motions = (
        f"{count} freedom{'' if count == 1 else 's'} everywhere; curves are where there are more"
    )
    if system.kind == "type 1":
        return [f"{system.name}: its joints move with the platform at rest in {motions}"]
    return [f"{system.name}: the mechanism moves with the actuated joints held in {motions}"]
