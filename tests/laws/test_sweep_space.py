"""Which points a sweep has, and what is refused before anything is computed."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import symkin
from helpers.inside import (
    Blocks,
    check_slices,
    labels,
    make_plan,
    make_space,
    read_values,
    slices_from,
)
from helpers.laws import ball_turn
from helpers.samples import Z, five_bar
from symkin import InputError, Joint, Limb, Mechanism


def test_a_small_sweep_of_formulas_is_one_chunk():
    """Its files take longer to write than its points to solve; distances from singularities do
    not, and of these a run that is stopped loses little.
    """
    swept = {c.name: np.linspace(80.0, 90.0, 100) for c in five_bar().actuated}
    space = make_space(five_bar(), swept)
    assert len(make_plan(space).blocks) == 1
    assert len(make_plan(space, quantity="conditioning").blocks) > 10


@given(st.lists(st.integers(1, 9), min_size=1, max_size=4), st.integers(1, 200))
def test_chunks_cover_every_point_once(shape, chunk):
    """The blocks of an array are disjoint, hold at most `chunk` points and cover it."""
    blocks, seen = Blocks(tuple(shape), chunk), np.zeros(shape, dtype=int)
    for i in range(len(blocks)):
        seen[blocks[i]] += 1
        assert seen[blocks[i]].size <= chunk
    assert (seen == 1).all()


@given(st.lists(st.integers(1, 5), min_size=2, max_size=2), st.integers(1, 30))
def test_grid_points_are_the_product_of_the_axes(counts, chunk):
    """Point (i, j) of a grid has the i-th value of the first axis and the j-th of the second,
    however it is cut.
    """
    first, second = (np.linspace(0, 10, n) if n > 1 else np.array([5.0]) for n in counts)
    space = make_space(five_bar(), {"q1": first, "q2": second})
    blocks, made = Blocks(space.shape, chunk), np.full((*space.shape, 2), np.nan)
    for i in range(len(blocks)):
        block = blocks[i]
        made[block] = space.points(block).reshape(*(p.stop - p.start for p in block), 2)
    assert np.array_equal(made[:, :, 0], np.repeat(first[:, None], len(second), axis=1))
    assert np.array_equal(made[:, :, 1], np.repeat(second[None], len(first), axis=0))


def test_random_points_do_not_depend_on_chunks():
    """A random point depends on the seed and its place; all lie within the bounds and differ
    between seeds.
    """
    space = make_space(five_bar(), {"q1": (-10, 10), "q2": (5, 6)}, sample=50, seed=3)
    whole = space.points((slice(0, 50),))
    assert np.array_equal(
        np.concatenate(
            [space.points((slice(i, i + 7 if i < 49 else 50),)) for i in range(0, 50, 7)]
        )[:50],
        whole,
    )
    assert (whole >= [-10, 5]).all()
    assert (whole <= [10, 6]).all()
    assert not np.array_equal(
        whole,
        make_space(five_bar(), {"q1": (-10, 10), "q2": (5, 6)}, sample=50, seed=4).points(
            (slice(0, 50),)
        ),
    )


def test_what_is_not_swept_keeps_its_value():
    """Inputs that are not swept have the value of `at`, else the example's, else the
    reference's.
    """
    platform = symkin.load("zhang2009")
    legs = list(platform.example.joints)
    assert make_space(platform, {"leg2": [5.0]}).given([7.0]) == {
        "joints": [legs[0], 7.0, *legs[2:]]
    }
    assert make_space(platform, {"leg2": [5.0]}, at=[1, 2, 3, 4, 5, 6]).given([7.0]) == {
        "joints": [1, 7, 3, 4, 5, 6]
    }
    assert make_space(five_bar(), {"q1": [5.0]}).given([7.0])["joints"] == pytest.approx(
        [7.0, 90.0]
    )


@given(st.lists(st.floats(-200, 200), min_size=3, max_size=3))
def test_rotation_vectors_turn_the_pose_in_the_base_frame(turn):
    """R = exp([r]) R_at, with r in the file's angle unit; x, y, z replace those of `at`."""
    at = [1, 2, 3, 0.5, -0.5, 0.5, 0.5]
    space = make_space(
        symkin.load("zhang2009"),
        {"y": [0.0], "rx": [0.0], "ry": [0.0], "rz": [0.0]},
        over="poses",
        at=at,
    )
    pose = space.given([9.0, *turn])["pose"]
    r = np.radians(turn)
    angle = float(np.linalg.norm(r))
    k = np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])
    exp = (
        np.eye(3)
        + np.sinc(angle / math.pi) * k
        + 0.5 * np.sinc(angle / (2 * math.pi)) ** 2 * (k @ k)
    )
    assert np.allclose(pose.position, [1, 9, 3])
    assert np.allclose(pose.rotation, exp @ ball_turn(at[3:]), atol=1e-12)


def test_ranges_as_text():
    """NAME=LOW:HIGH:COUNT is a linear space, NAME=VALUE one value, and a sample has its ends."""
    found = read_values("a=0:1:5, b = 2 ,c=3:3:1", "grid")
    assert list(found) == ["a", "b", "c"]
    assert np.array_equal(found["a"], [0, 0.25, 0.5, 0.75, 1])
    assert (found["b"], found["c"]) == ([2.0], [3.0])
    assert np.array_equal(read_values("a=0:1", "grid", sampled=True)["a"], [0, 1])
    assert slices_from("a=1,b=2e1", "rad") == {"a": 1.0, "b": 20.0}


def test_ranges_may_be_arithmetic():
    """Bounds and values are the numbers of mechanism files: sin, cos and tan in the file's angle
    unit.
    """
    found = read_values("a=-pi/2:2*pi:5,b=sqrt(16)", "grid", angle_unit="rad")
    assert np.array_equal(found["a"], np.linspace(-math.pi / 2, 2 * math.pi, 5))
    assert found["b"] == [4.0]
    assert read_values("a=cos(60):sin(90)", "grid", sampled=True, angle_unit="deg")[
        "a"
    ] == pytest.approx([0.5, 1.0])
    assert slices_from("a=2*sin(pi/6)", "rad") == pytest.approx({"a": 1.0})


@pytest.mark.parametrize(
    ("slices", "sampled", "said"),
    [
        ({"a": 70.0}, False, "a = 70 lies outside.*0 to 10"),
        ({"a": -1e-6}, False, "outside"),
        ({"b": 1.0}, False, "'b' is not swept.*a, c"),
        ({"c": 4.0}, False, "outside.*allowed: 5$"),
        ({"a": float("nan")}, False, "outside"),
        ({"a": 1.0}, True, "no slices"),
    ],
)
def test_slices_that_are_refused(slices, sampled, said):
    """A slice lies on a swept axis, within its values; the last digits of arithmetic do not
    matter.
    """
    swept = {"a": np.array([0.0, 5.0, 10.0]), "c": np.array([5.0])}
    with pytest.raises(InputError, match=said):
        check_slices(slices, swept, sampled=sampled)
    check_slices({"a": 10.0 + 1e-12, "c": 5.0}, swept, sampled=False)


@pytest.mark.parametrize(
    ("text", "sampled", "said"),
    [
        ("a=2:1:5", False, "reversed"),
        ("a=2:1", True, "reversed"),
        ("a=1:2:0", False, "0 values"),
        ("a=1:2:-3", False, "-3 values"),
        ("a=1:2:1", False, "one value"),
        ("a=1:1:4", False, "one value"),
        ("a=1:2:2.5", False, "whole number"),
        ("a=nan:2:3", False, "finite"),
        ("a=inf", False, "finite"),
        ("a=x", False, "not a number"),
        ("a=1/0", False, "no value"),
        ("a=1:2", False, "COUNT"),
        ("a=1:2:3", True, "NAME=LOW:HIGH"),
        ("a", False, "form"),
        ("", False, "form"),
        ("=1", False, "form"),
        ("a=1,a=2", False, "twice"),
    ],
)
def test_ranges_that_are_refused(text, sampled, said):
    """Each mistake is a sentence that names it."""
    with pytest.raises(InputError, match=said):
        read_values(text, "grid", sampled=sampled)


@pytest.mark.parametrize(
    ("ranges", "options", "said"),
    [
        ({"leg9": [1.0]}, {}, "no 'leg9'.*leg1, leg2"),
        ({"x": [1.0]}, {}, "--poses"),
        ({"leg1": [1.0]}, {"over": "poses"}, "x, y, z, rx"),
        ({}, {}, "nothing is swept"),
        ({"leg1": []}, {}, "no values"),
        ({"leg1": [1, float("nan")]}, {}, "not finite"),
        ({"leg1": [2, 1]}, {}, "do not rise"),
        ({"leg1": [1, 1]}, {}, "do not rise"),
        ({"leg1": [-1, 1]}, {}, "length -1"),
        ({"leg1": ["a"]}, {}, "no list of numbers"),
        ({"leg1": [1, 2, 3]}, {"sample": 4}, "least and the largest"),
        ({"leg1": [1, 2]}, {"sample": 0}, "random = 0"),
        ({"leg1": [1, 2]}, {"seed": -1}, "seed"),
        ({"leg1": [2, 1]}, {"sample": 4}, "reversed"),
        ({"leg1": [1]}, {"at": [1, 2]}, "at: 2 values"),
        ({"x": [1]}, {"at": [1, 2], "over": "poses"}, "at: 2 values"),
        ({"leg1": np.arange(1e5), "leg2": np.arange(1e5)}, {}, "10000000000 points"),
    ],
)
def test_spaces_that_are_refused(ranges, options, said):
    """Each mistake is a sentence that names it, before anything is computed."""
    with pytest.raises(InputError, match=said):
        make_space(symkin.load("zhang2009"), ranges, **options)


def test_joints_may_have_the_names_of_arrays():
    """Labels of axes are distinct, no array's or dimension's own, and hold no separator of
    paths.
    """
    made = labels(["count", "leg1", "a/b", "a b", ".x", "joint.count"])
    assert made[:2] == ["joint.count", "leg1"]
    assert len(set(made)) == 6
    assert not any("/" in name or name.startswith(".") for name in made)
    arm = Mechanism(
        "arm",
        [Limb("l", [Joint("mode", "R", (0, 0, 0), Z, actuated=True)])],
        serial=True,
        platform_position=(1, 0, 0),
    )
    assert make_space(arm, {"mode": [0.0, 1.0]}).shape == (2,)
