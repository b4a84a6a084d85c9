"""What every result offers: a short repr, HTML for notebooks, the JSON of the command line, a
picture; and joints by name.
"""

from __future__ import annotations

import json
import math
from dataclasses import replace
from functools import lru_cache
from html.parser import HTMLParser
from itertools import combinations
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import numpy as np
import pytest

import symkin
from helpers import inside
from helpers.command_line import run, run_json
from helpers.inside import LONGEST_REPR, Result, Summary
from helpers.known_roots import DIETMAIER, dietmaier
from helpers.samples import five_bar
from symkin import InputError

MOST_CHARACTERS = 3000
"""Characters of a result's repr: a screen of a terminal."""
PLATFORM = symkin.load("zhao2000")
GIVEN = [81.6, 202.8, 330.6, 105.2]
NAMED = dict(reversed(list(zip(("theta1", "theta2", "theta3", "op"), GIVEN, strict=True))))
BARS = five_bar()


@lru_cache(maxsize=1)
def results() -> dict[str, Result]:
    """One of each type, long ones where results can be long."""
    here = symkin.solve(PLATFORM, joints=GIVEN)
    arm = symkin.load("gluon_6l3")
    joints = np.radians(np.random.default_rng(4).uniform(-90.0, 90.0, (30, 6)))
    tips = np.array([symkin.solve(arm, joints=np.degrees(q)).solution.position for q in joints])
    readings = symkin.Measurements(joints, position=tips, position_sigma=0.01)
    bar = symkin.solve(BARS, joints=[80.0, 100.0]).solution
    return {
        "modes": symkin.modes(dietmaier(), joints=DIETMAIER["legs"]),
        "no modes": symkin.modes(symkin.load("zhang2009"), joints=[1, 900, 1, 900, 1, 900]),
        "solve": here,
        "solution": here.solution,
        "failed": symkin.solve(
            symkin.load("zhang2009"), joints=[1, 900, 1, 900, 1, 900], check=False
        ),
        "track": symkin.track(PLATFORM, joints=[GIVEN, [85.0, *GIVEN[1:]]], samples=1000),
        "singularity": symkin.singularity(
            symkin.load("zhang2009"), pose=[0, 0, 300, math.sqrt(0.5), 0, 0, math.sqrt(0.5)]
        ),
        "loci": symkin.singular_loci(bar, ("q1", "q2"), starts=4),
        "mode graph": symkin.mode_graph(
            BARS, [("q1", 80, 90), ("q2", 90, 100)], 3, joints=[85.0, 95.0]
        ),
        "mobility": symkin.mobility(symkin.load("zhao2000_links")),
        "jacobian": symkin.jacobian(arm),
        "calibration": symkin.calibrate(arm, readings),
        "passive rates": symkin.jacobian(symkin.load("four_bar"), "passive"),
        "rates": symkin.jacobian(symkin.load("four_bar"), of=["follower"], by=["crank"]),
        "closed": symkin.close("four_bar"),
        "sweep": symkin.sweep(
            symkin.load("four_bar"),
            given={"crank": [0.0, 60.0, 90.0]},
            directory=mkdtemp() + "/s",
            workers=0,
        ),
        "plan": symkin.plan_measurements(
            arm, 8, {"angles": 1e-4, "position": 0.05}, groups=0, readings=["position"]
        ),
        "transmission": symkin.transmission(symkin.load("four_bar"), ["crank"], ["follower"]),
        "transmissions": symkin.transmission(symkin.load("four_bar")),
    }


NAMES = (
    "modes",
    "no modes",
    "solve",
    "solution",
    "failed",
    "track",
    "singularity",
    "loci",
    "mode graph",
    "mobility",
    "jacobian",
    "calibration",
    "plan",
    "passive rates",
    "rates",
    "closed",
    "sweep",
    "transmission",
    "transmissions",
)


class Checker(HTMLParser):
    """Counts rows, and refuses what is not a table or a paragraph, or not closed."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.rows = 0
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[Any]) -> None:
        assert tag in ("table", "thead", "tbody", "tr", "th", "td", "p")
        assert not attrs
        self.open.append(tag)
        self.rows += tag == "tr"

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


def checked(html: str) -> Checker:
    checker = Checker()
    checker.feed(html)
    checker.close()
    assert not checker.open
    return checker


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_the_repr_is_a_short_table(name: str) -> None:
    """Law: below 3,000 characters whatever the result holds, beginning as what print writes, and
    not Python's own of a dataclass.
    """
    result = results()[name]
    assert len(repr(result)) < MOST_CHARACTERS
    assert repr(result).splitlines()[0][:40] == str(result).splitlines()[0][:40]
    assert not repr(result).startswith(type(result).__name__ + "(")


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_the_html_is_a_table_without_scripts(name: str) -> None:
    assert checked(results()[name]._repr_html_()).rows >= 1


@pytest.mark.parametrize("name", NAMES)
def test_the_dictionary_is_json(name: str) -> None:
    """Law: it goes through JSON, without NaN and infinity, as it is."""
    made = results()[name].to_dict()
    assert json.loads(json.dumps(made, allow_nan=False)) == made


def test_every_type_of_result_is_tried_here() -> None:
    """Each class that is a Result has one above, so that the laws of this module hold for all of
    them.
    """

    def below(kind: type) -> set[type]:
        return {kind, *(each for sub in kind.__subclasses__() for each in below(sub))}

    kinds = {kind for kind in below(Result) - {Result} if kind.__module__.startswith("symkin.")}
    assert {kind.__name__ for kind in kinds} == {
        type(result).__name__ for result in results().values()
    }


@pytest.mark.parametrize("name", [n for n in NAMES if n != "failed"])
def test_the_picture_is_drawn_and_written(name: str, tmp_path: Path) -> None:
    """plot() returns the figure of every result, and writes it."""
    from matplotlib.figure import Figure

    figure = results()[name].plot(tmp_path / "picture.svg")
    assert isinstance(figure, Figure)
    assert figure.axes
    assert (tmp_path / "picture.svg").read_text().startswith("<?xml")


@pytest.mark.parametrize("seed", range(3))
def test_numbers_of_a_plan_cover_nothing(seed: int) -> None:
    """Wherever the configurations are, no number lies over another one, a point or the axes'
    edge.
    """
    plan = results()["plan"]
    rng, poses = np.random.default_rng(seed), plan.configurations.poses.copy()
    poses[:, :3] = rng.normal(size=(len(poses), 3)) ** 3
    figure = replace(plan, configurations=replace(plan.configurations, poses=poses)).plot()
    figure.canvas.draw()
    for ax, axes in zip(figure.axes[:2], ([0, 1], [0, 2]), strict=True):
        points, area = ax.transData.transform(poses[:, axes]), ax.get_window_extent()
        boxes = [text.get_window_extent() for text in ax.texts]
        said = [int(number) for text in ax.texts for number in text.get_text().split(", ")]
        assert sorted(said) == [*range(1, 1 + len(poses))]
        assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))
        assert not any(box.contains(*point) for box in boxes for point in points)
        assert all(area.contains(*corner) for box in boxes for corner in box.get_points())


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("failed", {}),
        ("plan", {"names": "all"}),
        ("modes", {"size": 3}),
        ("calibration", {"what": "x"}),
    ],
)
def test_a_picture_that_cannot_be_is_one_sentence(name: str, options: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="plot: "):
        results()[name].plot(**options)


def test_long_tables_are_cut_and_say_so() -> None:
    found = results()["modes"]
    assert "the first 10 of 40 modes" in repr(found)
    assert checked(found._repr_html_()).rows == 41
    assert len(str(found).splitlines()) > 40


def test_text_of_others_is_escaped_in_html() -> None:
    """Law: no markup of a title, a name or a value reaches the page."""
    hostile = "<script>alert(1)</script>&\x1b[2J"
    for summary in (
        Summary([hostile], [hostile], [[hostile]], [hostile]),
        Summary([f"{hostile}: {hostile}"]),
    ):
        checker = checked(summary.html())
        assert "<script>alert(1)</script>&" in checker.text
        assert "\x1b" not in checker.text


def test_no_repr_is_longer_than_a_screen() -> None:
    """Law: sentences of any length are cut."""

    class Long(Result):
        def summary(self, most_rows: int | None = None) -> Summary:
            return Summary(
                [200 * "word "],
                ["#"],
                [["1"]] * (1000 if most_rows is None else most_rows),
                100 * ["more words"] * 3,
            )

    assert len(repr(Long())) <= LONGEST_REPR + 3


# --- the command line -----------------------------------------------------------------------------


def _less_time(value: dict[str, Any]) -> dict[str, Any]:
    return {key: part for key, part in value.items() if key != "elapsed_s"}


@pytest.mark.slow
def test_dictionaries_are_the_json_of_commands(capsys) -> None:
    """Law: what Python returns and what a command prints are one object."""
    joints = ["--joints", ",".join(map(str, GIVEN))]
    ends = ["--from", joints[1], "--to", "85,202.8,330.6,105.2"]
    here = symkin.solve(PLATFORM, joints=GIVEN)
    pairs = [
        (["modes", "zhao2000", *joints], symkin.modes(PLATFORM, joints=GIVEN)),
        (["solve", "zhao2000", *joints], here),
        (["singularities", "zhao2000", *joints], symkin.singularity(PLATFORM, joints=GIVEN)),
        (
            [
                "singularities",
                "zhao2000",
                *joints,
                "--plane",
                "theta1,op",
                "--range",
                "20:150,1:200",
                "--starts",
                "5",
            ],
            symkin.singular_loci(
                here.solution, ("theta1", "op"), ranges=[(20.0, 150.0), (1.0, 200.0)], starts=5
            ),
        ),
        (
            ["track", "zhao2000", *ends, "--samples", "3"],
            symkin.track(PLATFORM, joints=[GIVEN, [85.0, *GIVEN[1:]]], samples=3),
        ),
        (["show", "zhao2000"], symkin.mobility(PLATFORM)),
    ]
    for arguments, result in pairs:
        _, printed = run_json(capsys, *arguments)
        assert _less_time(printed) == json.loads(json.dumps(_less_time(result.to_dict()))), (
            arguments[0]
        )


def test_show_as_json_counts_links_and_loops(capsys) -> None:
    """Closed forms: a planar four-bar has 4 links, 4 joints, 1 loop; 3-TRT+SPS, by links, 16, 18
    and 3. Loops = joints - links + 1.
    """
    _, shown = run_json(capsys, "show", "zhao2000_links")
    assert (shown["links"], shown["joints"], shown["loops"]) == (16, 18, 3)
    assert shown["mobility"] == shown["generic"]["mobility"] == 4
    assert shown["actuated"] == ["theta1", "theta2", "theta3", "op"]
    status, _, err = run(capsys, "show", "zhao2000", "--json", "--latex")
    assert status == 2
    assert "both --latex and --json" in err


# --- joints by name -------------------------------------------------------------------------------


@pytest.mark.slow
def test_joints_by_name_are_joints_in_order() -> None:
    """Law: in every verb that takes joints, values by name, in any order, give what values in file
    order give.
    """
    pose = symkin.solve(PLATFORM, joints=GIVEN).solution.pose
    further = [v + 1.0 for v in GIVEN]
    columns = {name: [value, value + 1.0] for name, value in NAMED.items()}
    verbs: list[tuple[Any, dict[str, Any], dict[str, Any]]] = [
        (symkin.modes, {"joints": NAMED}, {"joints": GIVEN}),
        (symkin.solve, {"joints": NAMED}, {"joints": GIVEN}),
        (symkin.solve, {"pose": pose, "start": NAMED}, {"pose": pose, "start": GIVEN}),
        (symkin.singularity, {"joints": NAMED}, {"joints": GIVEN}),
        (symkin.track, {"joints": columns}, {"joints": [GIVEN, further]}),
        (symkin.track, {"joints": [NAMED, further]}, {"joints": [GIVEN, further]}),
        (
            symkin.track,
            {"poses": [pose, pose], "start": NAMED},
            {"poses": [pose, pose], "start": GIVEN},
        ),
    ]
    for verb, named, ordered in verbs:
        one, other = (_less_time(verb(PLATFORM, **given).to_dict()) for given in (named, ordered))
        assert one == other, verb.__name__
    axes = [("theta1", 80.0, 82.0), ("op", 105.0, 106.0)]
    graphs = [
        symkin.mode_graph(PLATFORM, axes, 2, joints=given).to_dict() for given in (NAMED, GIVEN)
    ]
    assert graphs[0] == graphs[1]
    many = symkin.modes(PLATFORM, joints=columns)
    assert [m.given for m in many] == [{"joints": GIVEN}, {"joints": further}]


@pytest.mark.slow
def test_sweeps_hold_joints_by_name(tmp_path) -> None:
    arrays = []
    for k, at in enumerate((NAMED, GIVEN)):
        symkin.sweep(PLATFORM, {"theta1": [80.0, 81.0]}, tmp_path / str(k), at=at, workers=0)
        arrays.append(
            symkin.sweep(
                PLATFORM, {"theta1": [80.0, 81.0]}, tmp_path / str(k), at=at, workers=0
            ).open()
        )
    assert arrays[0].equals(arrays[1])


@pytest.mark.parametrize(
    ("joints", "said"),
    [
        (
            {"theta1": 80.0},
            "joints: no value is given for theta2, theta3, op; the actuated joints of zhao2000 are",
        ),
        (
            {**NAMED, "leg1": 1.0},
            "joints: 'leg1' is unknown; the actuated joints of zhao2000 are theta1, theta2, "
            "theta3, op",
        ),
        ({**NAMED, "op": "long"}, "joints: value 4 = 'long' is not a number"),
        ({}, "no value is given for theta1, theta2, theta3, op"),
    ],
)
def test_names_that_do_not_fit_are_one_sentence(joints: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        symkin.modes(PLATFORM, joints=joints)


def test_joint_names_are_no_pose() -> None:
    with pytest.raises(InputError, match="start: values by name are given"):
        symkin.solve(PLATFORM, joints=GIVEN, start=NAMED)
    with pytest.raises(InputError, match="columns have different counts of values"):
        symkin.track(
            PLATFORM, joints={name: [value] * (1 + (name == "op")) for name, value in NAMED.items()}
        )


def test_commands_take_joints_by_name(capsys) -> None:
    named = ",".join(f"{name} = {value}" for name, value in NAMED.items())
    for command in (["solve"], ["modes"], ["singularities"]):
        (_, one), (_, other) = (
            run_json(capsys, *command, "zhao2000", "--joints", text)
            for text in (named, "81.6,202.8,330.6,105.2")
        )
        assert _less_time(one) == _less_time(other)
    for text, said in (
        ("theta1=1,2", "'2' has no name"),
        ("theta1=1,theta1=2", "'theta1' is given twice"),
        ("theta1=1", "no value is given for theta2"),
        ("theta1=x", "theta1 = 'x' is not a number"),
    ):
        status, _, err = run(capsys, "solve", "zhao2000", "--joints", text)
        assert status == 2
        assert said in err
        assert err.count("\n") == 1


def test_what_modes_read_is_found_for_all_of_them_at_once(monkeypatch):
    """Joints that the closure leaves out, and named points: the same as of each mode alone, from
    one evaluation.
    """
    machine = symkin.load("klann_leg")
    together, alone = symkin.modes(machine), symkin.modes(machine)
    one_by_one = [mode.to_dict() for mode in alone]
    calls = []
    placed = inside.solution.link_poses
    monkeypatch.setattr(
        inside.solution, "link_poses", lambda *a: calls.append(len(a[1])) or placed(*a)
    )
    told = together.to_dict()["modes"]
    assert calls == [len(together)]
    assert len(together) > 1
    for a, b in zip(told, one_by_one, strict=True):
        assert a["joints"] == pytest.approx(b["joints"], abs=1e-9)
        for name, point in b["points"].items():
            assert a["points"][name] == pytest.approx(point, abs=1e-9)
