"""Loci where a rank falls below its generic one: redundant joints, nearly parallel joints, several
ranks lost at once.
"""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from helpers.gate import in_gate
from helpers.inside import LOST_OVER_PLANE, NONE_MET, Locus, configuration, figure_of_loci, merged
from helpers.laws import act, joint_displacement
from helpers.samples import DELTA, delta, delta_directions
from symkin import Joint, Limb, Loci, Mechanism, singular_loci

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def arm(name: str, spec: list[tuple], tool: tuple[float, float, float]) -> Mechanism:
    joints = [Joint(f"q{k}", *rest, actuated=True) for k, rest in enumerate(spec, start=1)]
    return Mechanism(name, [Limb(name, joints)], serial=True, platform_position=tool)


def srs(upper: float, fore: float) -> Mechanism:
    """Seven revolutes: three through a shoulder at 340, an elbow, three through a wrist."""
    elbow, wrist = 340 + upper, 340 + upper + fore
    heights, axes = (340, 340, 340, elbow, wrist, wrist, wrist), (Z, Y, Z, Y, Z, Y, Z)
    return arm(
        "srs",
        [("R", (0.0, 0.0, h), a) for h, a in zip(heights, axes, strict=True)],
        (0.0, 0.0, wrist + 120.0),
    )


def scara(last: str) -> Mechanism:
    """Links of 400 and 300, a third parallel revolute, and along its axis a screw of small pitch,
    or a slide.
    """
    joints = [
        Joint(f"j{k}", "R", (x, 0.0, 0.0), Z, actuated=True)
        for k, x in ((1, 0.0), (2, 400.0), (3, 700.0))
    ]
    pitch = {"pitch": 20.0} if last == "H" else {}
    joints.append(Joint("j4", last, (700.0, 0.0, 0.0), Z, actuated=True, **pitch))  # type: ignore[arg-type]
    return Mechanism(
        "scara", [Limb("scara", joints)], serial=True, platform_position=(700.0, 0.0, -100.0)
    )


def loci_at(
    mechanism: Mechanism, joints: list[float], plane: tuple[str, str], **options: object
) -> Loci:
    return singular_loci(configuration(mechanism, joints=joints), plane, **options)  # type: ignore[arg-type]


def joint_screws(mechanism: Mechanism, joints: dict[str, float]) -> np.ndarray:
    """Unit twists of an arm's revolutes (rows; angular velocity, velocity of the base origin over
    1000), by matrices.
    """
    frame, screws = np.eye(4), []
    for _, joint in mechanism.joints:
        point, axis = act(frame, joint.point), frame[:3, :3] @ np.array(joint.axis)
        screws.append(np.concatenate([axis, np.cross(point, axis) / 1000]))
        frame = frame @ joint_displacement(joint, [joints[joint.name]])
    return np.array(screws)


def assert_whole_lines(loci: Loci, name: str, multiples: set[int]) -> None:
    """The curves are the lines on which a joint is one of these multiples of a half turn, from side
    to side of the window.
    """
    k = loci.plane.names.index(name)
    (low, high), reached = loci.ranges[1 - k], {}
    for curve in loci.curves:
        assert curve.kind == "type 1"
        assert curve.largest_row < 1e-8 * loci.plane.closure.characteristic_length
        assert not curve.is_point
        value = curve.points[:, k] / math.pi
        assert np.abs(value - np.round(value)).max() < 1e-9
        reached.setdefault(round(value[0]), []).append(curve.points[:, 1 - k])
    assert set(reached) == multiples
    for parts in reached.values():
        places = np.sort(np.concatenate([[low, high], *parts]))
        assert np.diff(places).max() < 0.05 * (high - low)


# --- redundant arms -------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    ("upper", "fore"),
    in_gate([(400.0, 300.0), (400.0, 400.0)], [(400.0, 400.0)]),
    ids=["one rank", "folded loses two"],
)
@pytest.mark.parametrize(
    "plane", [("q2", "q4"), pytest.param(("q4", "q6"), marks=pytest.mark.long)], ids="-".join
)
def test_an_arm_of_seven_joints_is_singular_where_its_elbow_is_stretched_or_folded(
    upper: float, fore: float, plane: tuple[str, str]
) -> None:
    """Rank 5 or less of 6 x 7 on whole lines q4 = 0 and a half turn, and there only: equal links
    fold the wrist's centre onto the shoulder's, where the rank is 4.
    """
    mechanism = srs(upper, fore)
    joints = [0.2, 0.3, 0.5, 0.7, 0.9, 1.0, 1.2]
    loci = loci_at(mechanism, joints, plane, starts=60)
    assert_whole_lines(loci, "q4", {0, 1})
    assert not any("actuated joint decides" in note or note == NONE_MET for note in loci.notes)
    assert any("in 1 freedom everywhere" in note for note in loci.notes)
    for curve in loci.curves:
        values = dict(zip((c.name for c in mechanism.actuated), joints, strict=True)) | dict(
            zip(plane, curve.points[7], strict=True)
        )
        expected = 4 if upper == fore and curve.points[7][plane.index("q4")] > 1 else 5
        assert np.linalg.matrix_rank(joint_screws(mechanism, values), tol=1e-8) == expected


@pytest.mark.slow
def test_a_redundant_wrist_of_fewer_freedoms_than_its_tool() -> None:
    """Four axes through one point, the last two in line (rank 3 of 4 joints and 6 rows): rank 2
    where the second is 0 or a half turn.
    """
    wrist = arm("wrist", [("R", (0.0, 0.0, 0.0), a) for a in (Z, Y, Z, Z)], (0.0, 0.0, 50.0))
    assert_whole_lines(loci_at(wrist, [0.1, 0.8, 0.3, 0.2], ("q2", "q3"), starts=40), "q2", {0, 1})


def test_a_plane_that_is_singular_everywhere_is_called_so() -> None:
    """With the elbow held stretched every configuration over two other joints is singular: no
    curves, and no word that some may be missing.
    """
    loci = loci_at(srs(400.0, 300.0), [0.2, 0.3, 0.5, 0.0, 0.9, 1.0, 1.2], ("q2", "q6"), starts=20)
    assert loci.curves == ()
    assert any(note.endswith(LOST_OVER_PLANE) for note in loci.notes)
    assert NONE_MET not in loci.notes
    assert "every configuration in this window is singular" in str(loci)
    assert "no locus" not in str(loci)


# --- several small singular values ----------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("last", in_gate(["H", "P"], ["H"]))
@pytest.mark.parametrize(
    ("plane", "window"),
    [(("j2", "j3"), ((-2.1, 4.1), (-3, 3))), (("j1", "j2"), ((0, 6.28), (-1, 5)))],
    ids=["j2-j3", "j1-j2"],
)
def test_a_nearly_parallel_pair_hides_no_locus(
    last: str, plane: tuple[str, str], window: tuple
) -> None:
    """A SCARA is singular where its two links are in line, whether a slide or a screw of small
    pitch follows; the screw's twist is nearly that of the revolute on its axis everywhere, which is
    no singularity.
    """
    loci = loci_at(scara(last), [0.0, 1.0, 0.0, 0.0], plane, ranges=window, starts=60)
    assert_whole_lines(loci, "j2", {0, 1})
    assert all(curve.hits > 5 for curve in loci.curves)


def test_starts_are_counted_once() -> None:
    """A start that leads to a curve by two null vectors is one start."""
    loci = loci_at(
        scara("P"), [0.0, 1.0, 0.0, 0.0], ("j2", "j3"), ranges=((-2.1, 2.1), (-3, 3)), starts=30
    )
    assert all(1 <= curve.hits <= 30 for curve in loci.curves)


@pytest.mark.long
@pytest.mark.slow
def test_limbs_of_one_joint_lose_their_only_rank() -> None:
    """Type 1 of a delta's limb: its rods in one plane with arm and axis, rod . (axis x arm) = 0,
    every limb with curves.
    """
    d, mechanism = DELTA, delta()
    loci = loci_at(mechanism, [0.0, 0.0, 0.0], ("q1", "q2"), kinds=("type 1",), starts=40)
    assert {curve.limb for curve in loci.curves} == {"limb1", "limb2", "limb3"}
    for curve in loci.curves:
        k = int(str(curve.limb)[-1]) - 1
        outward, tangent = delta_directions(k)
        for point, values in zip(curve.points[::9], curve.configurations[::9], strict=True):
            named = dict(zip(curve.names, values, strict=True))
            q = [*point, 0.0][k]
            along = math.cos(q) * outward - math.sin(q) * np.array(Z)
            centre = np.array([named[f"pose.{axis}"] for axis in "xyz"])
            rod = centre + (d["platform"] - d["base"]) * outward - d["arm"] * along
            assert np.linalg.norm(rod) == pytest.approx(d["rod"], rel=1e-9)
            assert abs(rod @ np.cross(tangent, along)) < 1e-8 * d["rod"]


def sharp(phase: float, above: float = 0.0) -> Locus:
    """A tip of two nearly straight sides, 0.1 s over |s| for s from -1/2 to 1/2, in steps of 1/150
    that begin at a phase.
    """
    s = -0.5 + (np.arange(150) + phase) / 150
    points = np.column_stack([np.abs(s), 0.1 * s + above])
    return Locus(
        "type 2",
        None,
        points,
        False,
        np.ones(len(s), dtype=bool),
        np.zeros((0, 2)),
        (),
        points,
        0.0,
        1,
    )


def test_a_curve_traced_twice_is_listed_once() -> None:
    """Two tracings cut off a sharp tip in different ways and end at different places; a curve
    beside them stays its own.
    """
    sides = np.ones(2)
    assert [curve.hits for curve in merged([sharp(0.0), sharp(0.5)], sides)] == [2]
    assert len(merged([sharp(0.0), sharp(0.5, above=0.002)], sides)) == 2


# --- what is said ---------------------------------------------------------------------------------


def test_no_curve_says_that_some_may_be_missing(tmp_path: Path) -> None:
    """A SCARA whose links stand at a right angle has no locus over its other joints: the result,
    its text, its JSON and its picture say that none was met and that this proves nothing.
    """
    loci = loci_at(scara("P"), [0.0, math.pi / 2, 0.0, 0.0], ("j1", "j3"), starts=10)
    assert loci.curves == ()
    assert NONE_MET in loci.notes
    assert NONE_MET in json.loads(json.dumps(loci.to_dict()))["notes"]
    assert "raise --starts" in str(loci)
    (axes,) = figure_of_loci(loci).axes
    assert "raise --starts" in axes.get_xlabel()
    assert [text.get_text() for text in axes.texts] == ["no locus was met in this window"]
    loci.plot(tmp_path / "none.png")


@pytest.mark.slow
def test_the_picture_writes_over_no_curve() -> None:
    """Where curves may be missing this stands below the axes, and nothing is written inside
    them.
    """
    loci = loci_at(delta(), [0.0, 0.0, 0.0], ("q1", "q2"), starts=6)
    assert loci.curves
    assert any("curves may be missing" in note for note in loci.notes)
    figure = figure_of_loci(loci)
    figure.draw_without_rendering()
    (axes,) = figure.axes
    assert not axes.texts
    assert "curves may be missing" in axes.get_xlabel()
    assert axes.xaxis.label.get_window_extent().y1 < axes.get_window_extent().y0
