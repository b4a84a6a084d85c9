"""Generic roots that all blocks of one structure share: found once, and the same solutions as from
a block's own.
"""

from __future__ import annotations

from functools import partial

import casadi as ca
import numpy as np
import pytest

import symkin
from helpers.gate import in_gate
from helpers.inside import (
    AlgebraicSystem,
    Coordinate,
    Fibre,
    agreeing_searches,
    block_paths,
    build_problem,
    closed_configurations,
    complex_normal,
    group_solvers,
    known_values,
    link_poses,
    make_solution,
    monodromy,
    parse,
    random_known,
    structure,
    structure_groups,
    structure_of,
    system_of,
    vectorise,
)
from oracle.plain_graph import configurations, read

group_paths = partial(group_solvers._group_paths.__wrapped__, _folder="")
HEAD = 'format = 1\nname = "bars"\nlength_unit = "mm"\nangle_unit = "deg"\n'


def joint(
    name: str,
    links: tuple[str, str],
    point: np.ndarray,
    *,
    actuated: bool = False,
    kind: str = "R",
    axis: str = "0, 0, 1",
) -> str:
    text = (
        f'[[joint]]\nname = "{name}"\ntype = "{kind}"\nlinks = ["{links[0]}", "{links[1]}"]\n'
        f"point = {point.tolist()}\naxis = [{axis}]\n"
    )
    return text + ("actuated = true\n" if actuated else "")


def four_bar(points: np.ndarray) -> symkin.Mechanism:
    """A crank and a dyad whose joints lie anywhere in the plane."""
    p = np.column_stack([points, np.zeros(4)])
    links = (("base", "crank"), ("crank", "coupler"), ("coupler", "follower"), ("follower", "base"))
    return parse(
        HEAD + "".join(joint(f"j{k}", pair, p[k], actuated=k == 0) for k, pair in enumerate(links))
    )


def groups(mechanism: symkin.Mechanism) -> list:
    return list(
        structure_groups(
            build_problem(mechanism, "given", tuple(c.name for c in mechanism.actuated))
        )
    )


def drawn(seed: int) -> symkin.Mechanism:
    return four_bar(np.random.default_rng(seed).uniform(-100, 100, (4, 2)))


@pytest.fixture
def _empty_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("SYMKIN_CACHE", str(tmp_path))
    # as in a process that has not met these blocks
    monkeypatch.setattr(group_solvers, "group_paths", group_paths)
    # blocks that have a closed form take their paths here
    monkeypatch.setattr(group_solvers, "closed_block", lambda *_: None)


# --- the polynomials ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name", ["jansen_leg", "stephenson_six_bar", "ankle", "parallel_gripper", "klann_leg"]
)
def test_the_structures_rows_are_those_of_the_block_at_complex_points(name):
    """F(z, k) of the block is F(z, C(k)) of its structure, at random complex unknowns and known
    values.
    """
    rng = np.random.default_rng(5)
    looked = 0
    for group in groups(symkin.load(name)):
        system = system_of(group)
        found = structure_of(group, system)
        if found is None:
            continue
        z = complex_normal(4 * system.width, rng).reshape(system.width, 4)
        k = np.array(
            [known_values(group, random_known(group, rng, near=False)) for _ in range(4)]
        ).T
        own, shared = system.linearise(z, k)[0], found.system.linearise(z, found.known(k))[0]
        assert np.max(np.abs(own - shared)) < 1e-9 * np.max(np.abs(own))
        looked += 1
    assert looked


def test_blocks_that_are_no_such_polynomials_have_no_structure():
    """A body in Study coordinates beside a joint, and loops with more rows than unknowns."""
    for name in ("double_wishbone", "bennett"):
        (first, *_) = groups(symkin.load(name))
        assert structure_of(first, system_of(first)) is None


# --- one search -----------------------------------------------------------------------------------


@pytest.mark.usefixtures("_empty_cache")
def test_a_dyad_is_never_searched_twice(monkeypatch):
    """The second four-bar, of other lengths at other places, finds its roots without a search, also
    in a new process's memory.
    """
    searched = []
    search = structure._searched
    monkeypatch.setattr(
        structure, "_searched", lambda system: searched.append(system) or search(system)
    )
    monkeypatch.setattr(
        block_paths, "start_of", lambda *_: pytest.fail("the block's own roots were sought")
    )
    for seed in (1, 2, 3):
        (group,) = groups(drawn(seed))
        paths = group_paths(group)
        assert paths is not None
        assert paths.most_roots == 2
    assert len(searched) == 1


@pytest.mark.usefixtures("_empty_cache")
@pytest.mark.parametrize("seed", in_gate(range(4), [0]))
def test_shared_roots_give_the_modes_that_own_ones_give(seed, monkeypatch):
    """Modes of random four-bars, from the structure's roots and from the mechanism's own."""
    mechanism = drawn(10 + seed)
    shared = symkin.modes(mechanism, joints=[7.0 * seed])
    monkeypatch.setattr(group_solvers, "structure_of", lambda *_: None)
    own = symkin.modes(mechanism, joints=[7.0 * seed])
    assert (len(shared), shared.complex_count, shared.completeness) == (
        len(own),
        own.complex_count,
        own.completeness,
    )
    for a, b in zip(shared, own, strict=True):
        assert [float(v) for v in a.joints.values()] == pytest.approx(
            [float(v) for v in b.joints.values()], abs=1e-8
        )


@pytest.mark.usefixtures("_empty_cache")
def test_a_part_that_nothing_moves_is_complete_too():
    """A frame of three bars carries a four-bar: the frame's two forms do not depend on the crank,
    and both are found.
    """
    a, b, c = np.array([0.0, 0, 0]), np.array([100.0, 0, 0]), np.array([30.0, 80, 0])
    frame = (
        joint("f1", ("base", "bar1"), a)
        + joint("f2", ("bar1", "bar2"), c)
        + joint("f3", ("bar2", "base"), b)
    )
    loop = joint("crank", ("base", "arm"), a - [40, 0, 0], actuated=True) + joint(
        "g1", ("arm", "coupler"), a + [-40, 30, 0]
    )
    text = (
        HEAD
        + frame
        + loop
        + joint("g2", ("coupler", "follower"), c + [0, 60, 0])
        + joint("g3", ("follower", "bar1"), c / 4)
    )
    found = symkin.modes(parse(text), joints=[0.0])
    assert found.completeness == "proved"
    turns = {round(abs(mode.joints["f1"]), 6) for mode in found}
    # the triangle as drawn, and turned over about the line of its feet
    assert turns == {0.0, round(2 * np.degrees(np.arctan2(80, 30)), 6)}


def test_a_tilted_frame_without_freedom_has_its_two_forms():
    """Three bars in a plane of any direction: as drawn, and turned over about the line of the feet;
    nothing is given, at which the machine in its own plane is told.
    """
    across = np.array([0.0, 0.6, 0.8])
    places = np.zeros(3), np.array([3.0, 3.2, -2.4]), np.array([6.0, 0.0, 0.0])
    links = ("base", "b"), ("b", "d"), ("d", "base")
    text = HEAD + "".join(
        joint(name, pair, place, axis=str(across.tolist())[1:-1])
        for name, pair, place in zip("ace", links, places, strict=True)
    )
    found = symkin.modes(parse(text))
    assert found.completeness == "proved"
    turns = sorted(abs(mode.joints["a"]) for mode in found)
    assert turns == pytest.approx([0.0, 2 * np.degrees(np.arctan2(4, 3))])


def test_roots_that_no_loop_moves_are_found(tmp_path):
    """Two spherical loops without freedom: two of their roots are the same whatever the angles
    between the axes are, and no loop of these leads from the others to them.
    """
    axes = (
        *((1, 2, -1), (1, 0, -1), (1, -2, 1), (-2, 1, 0)),
        *((1, 0, 1), (1, 0, 1), (2, -2, 1)),
    )
    links = (
        *(("base", "link1"), ("link1", "link2"), ("link2", "link3"), ("link3", "base")),
        *(("link2", "link4"), ("link4", "link5"), ("link5", "base")),
    )
    file = tmp_path / "loops.toml"
    file.write_text(
        HEAD
        + "".join(
            joint(f"j{k}", pair, 50.0 * np.array(axis), axis=str(axis)[1:-1])
            for k, (pair, axis) in enumerate(zip(links, axes, strict=True), start=1)
        )
    )
    found = symkin.modes(symkin.load(file), given={"j6": 20.0})
    judge = configurations(read(file, ["j6"]), {"j6": 20.0}, 300)
    assert judge.isolated.all()
    assert len(found) == len(judge.isolated)
    assert found.completeness == "probability one"


@pytest.mark.usefixtures("_empty_cache")
def test_a_root_that_stays_at_a_half_turn_is_found():
    """A kite on a sphere closes in two ways: one of its joints stays at a half turn in the second,
    whatever the given angle is, so that no loop leads there, and rows are far from zero where
    Newton's method starts.
    """
    system = structure._system(("angle",), (((0, 0, 1), (1, 0, 1), (2, 1, 1)),))
    found, why = structure._searched(system)
    assert found is not None, why
    assert sorted(np.abs(np.cos(found.z[0]) + 1.0) > 1e-6) == [False, True]
    axes = ((-1, 1, 2), (2, 2, 1), (0, 1, 0), (-2, 2, -1), (0, 0, -1), (-1, 1, 0), (1, 0, 2))
    links = (
        *(("base", "link1"), ("link1", "link2"), ("link2", "link3"), ("link3", "base")),
        *(("link2", "link4"), ("link4", "link5"), ("link5", "base")),
    )
    kite = "".join(
        joint(f"j{k}", pair, 50.0 * np.array(axis), axis=str(axis)[1:-1])
        for k, (pair, axis) in enumerate(zip(links, axes, strict=True), start=1)
    )
    modes = symkin.modes(parse(HEAD + kite), given={"j4": -5.0})
    # two ways of each of its two loops
    assert len(modes) == 4
    assert modes.completeness == "probability one"
    assert sum(abs(abs(mode.joints["j3"]) - 180.0) < 1e-9 for mode in modes) == 2


@pytest.mark.usefixtures("_empty_cache")
def test_a_loop_of_two_slides_between_two_turns_is_complete():
    """P C U C with the slide of one C given: translations are linear in the two other slides."""
    rng = np.random.default_rng(4)
    axes, points = rng.normal(size=(4, 3)), 60.0 * rng.normal(size=(4, 3))
    other = np.cross(axes[2], rng.normal(size=3))
    ends = (("base", "a"), ("a", "b"), ("b", "c"), ("c", "base"))
    loop = [
        joint(f"j{k}", pair, points[k], kind=kind, axis=str(axes[k].tolist())[1:-1])
        for k, (pair, kind) in enumerate(zip(ends, "PCUC", strict=True))
    ]
    loop[2] += f"axis2 = {other.tolist()}\n"
    found = symkin.modes(parse(HEAD + "".join(loop)), given={"j3.slide": 1.0})
    assert found.completeness == "probability one"
    assert found.complex_count == 8


@pytest.mark.usefixtures("_empty_cache")
def test_a_block_with_fewer_roots_than_its_structure_is_searched_for_itself(monkeypatch):
    """Where a path of the structure's roots does not arrive at a generic instance, the block's own
    roots are sought.
    """
    (group,) = groups(drawn(1))
    monkeypatch.setattr(
        structure, "plain_instances", lambda *_: (np.zeros((1, 2, 2)), np.array([False]))
    )
    paths = group_paths(group)
    assert paths is not None
    assert paths.shared is None
    assert paths.most_roots == 2


def test_coefficients_are_those_of_the_rows_for_a_circle():
    """Of a dyad's rows each product has the coefficient that the rows have there: two of each
    angle, one constant a row.
    """
    (group,) = groups(drawn(4))
    found = structure_of(group, system_of(group))
    assert found is not None
    assert (found.system.count, found.system.width) == (2, 2)
    code, numbers = (
        vectorise(found.data),
        np.zeros((1, int(found.system.k.shape[0]), 1), dtype=complex),
    )
    code(np.ones((1, 1), dtype=complex), numbers)
    assert np.isfinite(numbers).all()


# --- bodies on six distances ----------------------------------------------------------------------


def test_a_platform_on_a_platform_is_held_by_six_distances():
    """Each of the two has 40 complex solutions, the most that there are (Ronga and Vust 1992), on a
    base that moves too.
    """
    for group in groups(symkin.load("hexapod_stack")):
        system = system_of(group)
        found = structure_of(group, system)
        assert found is not None
        paths = group_solvers.group_paths(group)
        assert paths is not None
        assert paths.most_roots == 40


def test_distances_of_a_moving_base_are_those_between_the_points():
    """L, b and m that are read from the rows at a real pose of the lower platform: b is where the
    rod stands on it.
    """
    mechanism = symkin.load("hexapod_stack")
    group = groups(mechanism)[1]
    found = structure_of(group, system_of(group))
    assert found is not None
    size = mechanism.characteristic_length
    for values in closed_configurations(group.closure, 0)[:3]:
        known = group.select_values(values, group.known_coordinates)
        k = found.known(known_values(group, known)[:, None])[:, 0].real.reshape(6, 7)
        solution = make_solution(
            build_problem(mechanism, "given", tuple(c.name for c in mechanism.actuated)), values
        )
        rods = [rod for rod in mechanism.link_rods if rod.name.startswith("upper")]
        poses = link_poses(group.closure, values[None]).at(0)
        for row, rod in zip(k, rods, strict=True):
            start = poses[rod.links[0]].apply(np.array(rod.start))
            assert size * row[1:4] == pytest.approx(start, abs=1e-9 * size)
            length = solution.joints[rod.name] + rod.offset
            assert size * row[0] == pytest.approx(length, abs=1e-9 * size)


@pytest.mark.parametrize(
    "found", ["nothing", "roots of which one is lost", "the same roots", "the same roots, far off"]
)
def test_a_second_search_must_come_to_all_roots_of_the_first(found, monkeypatch):
    """Of z^2 = k: one that finds nothing, or loses a root on the way to the first's base, agrees
    with nothing. Far roots, whose last Newton step is rounding of 1e-9, are the same where they
    come to those that are known: two of a free delta's 512 were called lost.
    """
    if "far" in found:
        settled = monodromy.newton
        monkeypatch.setattr(
            monodromy, "newton", lambda *asked: (settled(*asked)[0], np.full(2, 1.4e-9))
        )
    z, k = ca.SX.sym("z"), ca.SX.sym("k")
    system = AlgebraicSystem(1.0, (Coordinate("x", "length", "passive"),), z, k, z**2 - k, ())

    def fibre(base: complex, lost: int) -> Fibre:
        roots = np.sqrt(base) * np.array([[1.0, -1.0]])
        roots[0, :lost] = np.nan
        return Fibre(roots, np.array([base]), np.zeros(2, dtype=int), 9.0, 9, 0)

    def search(seed, known, enough):
        if seed == 0 or known is not None:
            return fibre(1.0 + 1.0j, 0)
        return None if found == "nothing" else fibre(2.0 - 1.0j, int("lost" in found))

    agreed, reason = agreeing_searches(system, search, lambda first, _: first.z[:, :0], 2)
    assert (agreed is not None) == ("the same roots" in found)
    assert bool(reason) == (agreed is None)
