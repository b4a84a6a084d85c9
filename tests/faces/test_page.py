"""The page that moves, in a real browser: its poses are those of `modes`, it stops where `track`
stops, and it loads nothing.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symkin
from helpers import inside
from helpers.command_line import run
from helpers.gate import in_gate
from helpers.samples import (
    readme_five_bar,
    rus_on_rods,
    three_rrr,
    tricept_of_joints,
    two_four_bars,
    with_actuated,
)
from symkin import InputError, Joint, Limb, RodLimb

sync_api = pytest.importorskip("playwright.sync_api")
CHROMIUM = next(
    (
        found
        for name in ("chromium", "chromium-browser", "google-chrome")
        if (found := shutil.which(name))
    ),
    None,
)
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium")
ARTEFACTS = Path(__file__).parents[2] / "artefacts"
"""Screenshots, to be looked at; not committed."""
LARGEST = 1.5e6
"""Bytes of a page without meshes."""
SAME = 1e-9
"""Distance of a pose of the page from that of `modes`: lengths over the size, angles in radians."""
INPUTS = {"zhang2009": 40, "delta": 60, "ankle": 50, "ur5e": 50}
"""Random inputs of each mechanism: 200 in all."""
SET_ALL = """rows => rows.map(row => {
  const values = Object.fromEntries(symkin.names.map((name, k) => [name, row[k]]));
  const {reached} = symkin.set(values);
  return {reached, solution: symkin.solution(), count: symkin.modes().length};
})"""


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    arguments = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    with sync_api.sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=CHROMIUM, args=arguments)
        yield started
        started.close()


class Tab:
    """The one page of the browser, what it told of errors, and what it asked for."""

    def __init__(self, page: Any) -> None:
        self.page, self.told, self.asked = page, list[str](), list[str]()
        self.page.on(
            "console",
            lambda message: self.told.append(message.text) if message.type == "error" else None,
        )
        self.page.on("pageerror", lambda error: self.told.append(str(error)))
        self.page.on("request", lambda request: self.asked.append(request.url))


@pytest.fixture(scope="module")
def tab(browser: Any) -> Tab:
    return Tab(browser.new_page())


@pytest.fixture
def open_page(tab: Tab, tmp_path: Path) -> Iterator[Callable[..., Any]]:
    """Open a text in place of the last one, at a width; at the end nothing has told an error or
    asked for anything beyond its own file.
    """
    tab.told.clear()
    tab.asked.clear()

    def opened(html: str, width: int = 960, height: int = 600) -> Any:
        place = tmp_path / "opened.html"
        place.write_text(html, encoding="utf-8")
        tab.page.set_viewport_size({"width": width, "height": height})
        tab.page.goto(place.as_uri())
        tab.page.wait_for_selector("html[data-ready]", state="attached")
        return tab.page

    yield opened
    tab.page.goto("about:blank")
    assert not tab.told
    assert all(url.startswith(("file:", "blob:", "data:", "about:")) for url in tab.asked)


def page_of(machine: symkin.Mechanism | str) -> str:
    """The page of a mechanism without options, made once for all tests here."""
    return _page(symkin.load(machine) if isinstance(machine, str) else machine)


@cache
def _page(mechanism: symkin.Mechanism) -> str:
    return str(symkin.view(mechanism).html)


def apart(mechanism: symkin.Mechanism, solution: symkin.Solution, told: dict[str, Any]) -> float:
    """How far the page's solution is from one of symkin's: pose and joints, lengths over the size,
    angles without whole turns.
    """
    size, gaps = mechanism.characteristic_length, []
    if mechanism.platform_link is not None:
        gaps += list(np.abs(solution.position - told["position"]) / size)
        q = np.array(told["quaternion"])
        gaps.append(
            2.0
            * min(np.linalg.norm(solution.quaternion - q), np.linalg.norm(solution.quaternion + q))
        )
    angular = {c.name for c in mechanism.coordinates if c.is_angular}
    for name, value in solution.joints.items():
        if not isinstance(value, float):
            continue
        gap = value - told["joints"][name]
        gaps.append(
            abs(np.angle(np.exp(1j * mechanism.angle_in(gap))))
            if name in angular
            else abs(gap) / size
        )
    return float(max(gaps))


def random_rows(
    mechanism: symkin.Mechanism, count: int, seed: int, share: float = 0.04
) -> list[list[float]]:
    rng, start = np.random.default_rng(seed), symkin.solve(mechanism).solution
    rows = []
    for _ in range(count):
        row = []
        for c, value in zip(mechanism.actuated, start.actuated_values, strict=True):
            half = (
                mechanism.angle_out(0.5)
                if c.is_angular
                else share * mechanism.characteristic_length
            )
            low, high = c.limits or (-np.inf, np.inf)
            ends = (
                (mechanism.angle_out(low), mechanism.angle_out(high))
                if c.is_angular
                else (low, high)
            )
            row.append(float(np.clip(value + half * rng.uniform(-1.0, 1.0), *ends)))
        rows.append(row)
    return rows


@pytest.mark.parametrize("name", INPUTS)
def test_poses_at_random_inputs_are_those_of_modes(
    name: str, open_page: Callable[..., Any]
) -> None:
    """What the page shows is one of symkin's modes, and it counts as many, wherever the movement
    reached the values.
    """
    mechanism = symkin.load(name)
    rows = random_rows(mechanism, INPUTS[name], seed=11)
    told = open_page(page_of(name)).evaluate(SET_ALL, rows)
    reached = [k for k, one in enumerate(told) if one["reached"]]
    found = symkin.modes(mechanism, joints=[rows[k] for k in reached])
    assert len(reached) > 0.5 * len(rows)
    for k, every in zip(reached, found, strict=True):
        assert min(apart(mechanism, solution, told[k]["solution"]) for solution in every) < SAME
        assert told[k]["solution"]["residual"] < 1e-9 * mechanism.characteristic_length
        assert mechanism.serial or told[k]["count"] == len(every)


EQUAL = {
    **{
        name: lambda name=name: symkin.load(name)
        for name in (
            *("zhang2009", "ren2008", "delta", "delta_parallelograms", "zhao2000", "ankle"),
            *("zhao2000_links", "four_bar", "stephenson_six_bar", "spherical_wrist"),
        )
    },
    "3-RRR": lambda: three_rrr("planar"),
    "Tricept with 192 complex solutions": lambda: tricept_of_joints(pairs=False),
}
"""Of every way of finding modes: formulas, paths, both in turn, half turns of joints."""
SEARCH_ALL = """rows => rows.map(row => {
  symkin.set(Object.fromEntries(symkin.names.map((name, k) => [name, row[k]])));
  const {joints} = symkin.solution();
  return {at: symkin.names.map(name => joints[name]), modes: symkin.modes()};
})"""


@pytest.mark.parametrize("name", in_gate(EQUAL, ["delta", "zhao2000_links", "3-RRR"]))
def test_modes_are_those_of_symkin(name: str, open_page: Callable[..., Any]) -> None:
    """At 40 inputs each mode of either list stands in the other, to rounding that its condition
    multiplies."""
    mechanism = EQUAL[name]()
    rows = random_rows(mechanism, 40, seed=11, share=0.1)
    told = open_page(page_of(mechanism)).evaluate(SEARCH_ALL, rows)
    found = symkin.modes(mechanism, joints=[one["at"] for one in told])
    for one, every in zip(told, found, strict=True):
        assert len(one["modes"]) == len(every)
        for mode in every:
            gap = min(apart(mechanism, mode, other) for other in one["modes"])
            assert gap < 1e-12 + 1e-15 * mode.condition


def test_modes_appear_and_vanish_as_those_of_symkin_do(open_page: Callable[..., Any]) -> None:
    """Pairs of modes meet and vanish within these ranges: the page counts as many as symkin
    wherever it says that none may be missing.
    """
    mechanism = symkin.load("ren2008")
    rows = random_rows(mechanism, 20, seed=5, share=0.25)
    page = open_page(page_of("ren2008"))
    told = [
        one for one in zip(rows, page.evaluate(SET_ALL, rows), strict=True) if one[1]["reached"]
    ]
    found = symkin.modes(mechanism, joints=[row for row, _ in told])
    assert [one["count"] for _, one in told] == [len(every) for every in found]
    assert len({len(every) for every in found}) > 1


STOPS = {
    "zhang2009": (
        [144.6, 347.0, 110.3, 178.6, 277.6, 269.4],
        [144.6, 500.0, 110.3, 178.6, 277.6, 269.4],
    ),
    "zhao2000": ([81.6, -157.2, -29.4, 105.2], [81.6, -157.2, 150.0, 105.2]),
}


@pytest.mark.parametrize("name", STOPS)
def test_it_stops_where_track_stops(name: str, open_page: Callable[..., Any]) -> None:
    """At a singularity: just before it, with a sentence and the motion that shows it."""
    start, end = STOPS[name]
    mechanism = symkin.load(name)
    tracked = symkin.track(mechanism, joints=[start, end], limits=False)
    assert tracked.stop is not None
    page = open_page(page_of(name))
    values = dict(zip([c.name for c in mechanism.actuated], end, strict=True))
    told = page.evaluate("values => symkin.set(values)", values)
    assert not told["reached"]
    assert told["share"] == pytest.approx(tracked.stop.u, abs=1e-6)
    assert told["stop"]["kind"] == "singularity"
    assert np.linalg.norm(told["stop"]["motion"]) > 0.0
    assert page.locator("#status").inner_text() == told["stop"]["sentence"]
    ARTEFACTS.mkdir(exist_ok=True)
    page.wait_for_timeout(300)
    page.screenshot(path=str(ARTEFACTS / f"stop_{name}.png"))


@pytest.mark.parametrize("name", ["crank_pin", "follower_pin", "follower"])
def test_limits_of_passive_joints_stop_it_where_they_stop_track(
    name: str, open_page: Callable[..., Any], tmp_path: Path
) -> None:
    """Of joints at which the loop is cut too, whose angles the closure leaves out."""
    text = (Path(symkin.__file__).parent / "mechanisms" / "four_bar.toml").read_text()
    before, joint, after = text.partition(f'name = "{name}"\n')
    assert joint
    (tmp_path / "limited.toml").write_text(f"{before}{joint}limits = [-8.0, 8.0]\n{after}")
    mechanism = symkin.load(tmp_path / "limited.toml")
    page = open_page(page_of(mechanism))
    for end in (150.0, 30.0):
        tracked = symkin.track(mechanism, joints=[[90.0], [end]])
        assert tracked.stop is not None
        assert tracked.stop.kind == "limit"
        told = page.evaluate("crank => symkin.set({crank})", end)
        assert told["share"] == pytest.approx(tracked.stop.u, abs=1e-6)
        assert told["stop"]["limit"]["name"] == name
        assert abs(told["stop"]["limit"]["value"]) == pytest.approx(8.0)
        assert page.evaluate("crank => symkin.set({crank})", 90.0)["reached"]


@pytest.mark.parametrize(
    ("name", "joint", "end"), [("parallel_gripper", "left", -30.0), ("sarrus", "foot_x", 160.0)]
)
def test_it_stops_where_branches_meet(
    name: str, joint: str, end: float, open_page: Callable[..., Any]
) -> None:
    """At bifurcations, through which a mode would go on straight; from there it comes back."""
    mechanism = symkin.load(name)
    start = symkin.solve(mechanism).solution.joints[joint]
    tracked = symkin.track(mechanism, joints=[[start], [end]])
    assert tracked.stop is not None
    assert tracked.stop.kind == "bifurcation"
    page = open_page(page_of(name))
    for target in (end, start + 2.0 * tracked.stop.u * (end - start)):
        told = page.evaluate("values => symkin.set(values)", {joint: target})
        assert not told["reached"]
        assert told["stop"]["kind"] == "singularity"
        assert told["share"] * (target - start) == pytest.approx(
            tracked.stop.u * (end - start), abs=1e-6 * abs(end - start)
        )
        assert page.evaluate("values => symkin.set(values).reached", {joint: start})
    singular = start + tracked.stop.u * (end - start)
    assert page.evaluate("values => symkin.set(values).share", {joint: singular}) > 1.0 - 1e-5
    assert page.evaluate("values => symkin.set(values).reached", {joint: start})


def test_a_limit_is_met_from_any_distance(open_page: Callable[..., Any]) -> None:
    mechanism = symkin.load("ren2008")
    limit = mechanism.actuated[0].limits[1]
    page = open_page(page_of("ren2008"))
    for target in (limit + 0.01, 2000.0):
        told = page.evaluate("leg1 => symkin.set({leg1}).stop", target)
        assert told["limit"] == {"name": "leg1", "value": pytest.approx(limit)}
        assert page.evaluate("symkin.solution().joints.leg1") == pytest.approx(limit, abs=1e-8)
        assert page.evaluate("symkin.set({leg1: 0.5}).reached")


def test_angles_beyond_half_a_turn_are_as_given(
    open_page: Callable[..., Any], tmp_path: Path
) -> None:
    """Paths and sliders begin at 200 and 330 degrees, not a turn away from them."""
    (tmp_path / "path.csv").write_text(
        "theta1[deg],theta2[deg],theta3[deg],op[mm]\n80,200,330,105\n82,203,328,106\n"
    )
    mechanism = symkin.load("zhao2000")
    page = open_page(symkin.view(mechanism, path=tmp_path / "path.csv").html)
    assert page.locator("#given-theta3-number").input_value() == "330"
    page.select_option("#player select", "4")
    page.get_by_role("button", name="Play").click()
    page.wait_for_function(
        "Number(document.querySelector('#player .place').value) === 8", timeout=20_000
    )
    assert page.locator("#status").inner_text() == ""
    told, (mode, *_) = (
        page.evaluate("symkin.solution()"),
        symkin.modes(mechanism, joints=[82, 203, 328, 106]),
    )
    assert apart(mechanism, mode, told) < 1e-9
    page.get_by_role("button", name="Back to the start").click()
    assert page.locator("#given-theta2-number").input_value() == "200"
    assert page.evaluate("symkin.set({theta2: 205}).reached")


def test_poses_of_a_path_lie_on_straight_lines(
    open_page: Callable[..., Any], tmp_path: Path
) -> None:
    """Rows of poses at one height: the platform stays there between them."""
    (tmp_path / "path.csv").write_text("x[mm],y[mm],z[mm]\n-60,0,-148\n60,40,-148\n")
    delta = symkin.load("delta")
    page = open_page(symkin.view(delta, path=str(tmp_path / "path.csv")).html)
    for share in (0.11, 0.377, 0.5, 0.82):
        page.evaluate(
            "t => { const place = document.querySelector('.place'); place.value = t; "
            "place.dispatchEvent(new Event('input')) }",
            8 * share,
        )
        position = page.evaluate("symkin.solution().position")
        assert position == pytest.approx([-60 + 120 * share, 40 * share, -148.0], abs=1e-3)


def test_wrong_numbers_are_kept_until_they_are_mended(open_page: Callable[..., Any]) -> None:
    page = open_page(page_of("zhang2009"))
    field, status = page.locator("#given-leg1-number"), page.locator("#status")
    before = field.input_value()
    for text in ("0x90", "12,3,4", "abc"):
        field.fill(text)
        field.press("Tab")
        assert "is not a number" in status.inner_text()
        assert field.get_attribute("aria-invalid") == "true"
        field.press("Escape")
        assert status.inner_text() == ""
        assert field.input_value() == before


def test_a_singular_start_is_told(open_page: Callable[..., Any]) -> None:
    """Six rods with base and platform in one plane: the platform moves out of it at first order,
    and no slider is followed from there.
    """
    rods = [
        RodLimb(
            f"leg{k}",
            (300 * np.cos(a), 300 * np.sin(a), 0.0),
            (150 * np.cos(b), 150 * np.sin(b), 0.0),
        )
        for k, (a, b) in enumerate(
            np.radians([(10, 50), (110, 70), (130, 170), (230, 190), (250, 290), (350, 310)]),
            start=1,
        )
    ]
    page = open_page(symkin.view(symkin.Mechanism("flat", rods)).html)
    told = page.locator("#status").inner_text()
    assert "This configuration is singular" in told
    assert "as the arrow shows" in told


def test_inputs_that_must_agree_leave_the_page_alive(open_page: Callable[..., Any]) -> None:
    """A structure without mobility, one joint of which is called actuated: paths to other values
    have no end, and are given up.
    """
    turns = [
        Joint("r1", "R", (50, 0, 100), (0.10636, 0.750981, -0.651702)),
        Joint("r2", "R", (50, 0, -100), (-0.108946, 0.987947, -0.109961), actuated=True),
    ]
    slides = [
        Joint("c3", "C", (0, 0, 100), (-0.161586, 0.704548, -0.691015)),
        Joint("c4", "C", (-50, 100, 50), (0.971493, 0.215036, -0.0998007)),
    ]
    page = open_page(
        symkin.view(
            symkin.Mechanism(
                "rigid", [Limb("a", turns), Limb("b", slides)], platform_position=(-100, 0, 0)
            )
        ).html
    )
    assert page.evaluate("symkin.modes().length") == 1
    page.wait_for_function(
        "document.querySelector('#modes').innerText.includes('must perhaps agree')"
    )
    assert not page.evaluate("symkin.set({r2: 0.1}).reached")


def test_joints_that_move_at_a_stop_are_named(open_page: Callable[..., Any]) -> None:
    """A delta's platform too low: each motor turns a little while the platform stands, with its arm
    and rods in one line.
    """
    page = open_page(
        symkin.view(symkin.load("delta"), given={"x": 0.0, "y": 0.0, "z": -200.0}).html
    )
    stop = page.evaluate("symkin.set({x: 0, y: 0, z: -700}).stop")
    assert stop["kind"] == "singularity"
    assert stop["motion"] is None
    assert (
        "motor1, motor2, motor3 can move a little while the given values are held"
        in stop["sentence"]
    )


def test_sliders_and_fields_move_it(open_page: Callable[..., Any]) -> None:
    page = open_page(page_of("four_bar"))
    slider, field = page.locator("#given-crank"), page.locator("#given-crank-number")
    slider.focus()
    before = page.evaluate("symkin.solution().joints.crank")
    page.keyboard.press("ArrowRight")
    page.wait_for_function("before => symkin.solution().joints.crank > before", arg=before)
    field.fill("75.5")
    field.press("Enter")
    page.wait_for_function("Math.abs(symkin.solution().joints.crank - 75.5) < 1e-12")
    expected = symkin.modes(symkin.load("four_bar"), given={"crank": 75.5})
    mechanism = symkin.load("four_bar")
    assert min(apart(mechanism, one, page.evaluate("symkin.solution()")) for one in expected) < SAME
    field.fill("seventy")
    field.press("Enter")
    assert "is not a number" in page.locator("#status").inner_text()
    assert slider.get_attribute("aria-valuetext") == "75.5 deg"


def test_a_click_takes_a_mode(open_page: Callable[..., Any]) -> None:
    page = open_page(page_of("zhang2009"))
    page.wait_for_function("document.querySelectorAll('#strip button').length === 4")
    other = page.evaluate("symkin.modes()[2].position")
    page.locator("#strip button").nth(2).click()
    assert page.evaluate("symkin.solution().position") == pytest.approx(other, abs=1e-9)
    assert page.locator("#strip button").nth(2).get_attribute("aria-selected") == "true"
    assert page.evaluate("symkin.choose(0)") is True
    assert page.evaluate("symkin.choose(9)") is False


def test_modes_along_paths_wait_until_nothing_moves(open_page: Callable[..., Any]) -> None:
    """While a hexapod moves its modes are not sought, so that frames stay short, and the page says
    so; once it stands they are told.
    """
    page = open_page(page_of("ren2008"))
    text = "document.querySelector('#modes-text').textContent"
    page.wait_for_function(f"{text}.includes('at these values')")
    moving = """() => new Promise((done) => {
      const name = symkin.names[0], start = symkin.solution().joints[name], told = [];
      const step = () => {
        symkin.set({ [name]: start + 0.01 * told.length });
        told.push(TEXT);
        told.length < 20 ? requestAnimationFrame(step) : done(told.slice(2));
      };
      requestAnimationFrame(step);
    })"""
    assert set(page.evaluate(moving.replace("TEXT", text))) == {
        "Finding all modes once nothing moves …"
    }
    page.wait_for_function(f"{text}.includes('at these values')")


def test_small_views_are_pictures_of_their_modes(open_page: Callable[..., Any]) -> None:
    """Each mode's small view shows something, and no two show the same; the large one stands in
    the mode shown."""
    page = open_page(page_of("zhang2009"))
    page.wait_for_function(
        """() => {
          const views = Array.from(document.querySelectorAll("#strip canvas"));
          const painted = view => view.getContext("2d")
            .getImageData(0, 0, view.width, view.height).data.some(Boolean);
          const pictures = new Set(views.map(view => view.toDataURL()));
          return views.length === 4 && views.every(painted) && pictures.size === 4;
        }"""
    )
    page.locator("#strip button").nth(2).click()
    page.wait_for_timeout(500)
    shown, mode = page.evaluate(
        "[symkinPage.items.at({link: symkinPage.items.links.length - 1,"
        " point: [0, 0, 0]}).toArray(),"
        " symkinPage.poses.slice(-12)]"
    )
    assert shown == pytest.approx([mode[k] for k in (3, 7, 11)], abs=1e-12)


ON_PLATFORM = """() => {
  for (let y = 20; y < 600; y += 8)
    for (let x = 20; x < 900;
      x += 8) if (symkinPage.itemAt(x, y)?.role === "platform") return [x, y];
}"""


def test_the_platform_is_dragged(open_page: Callable[..., Any]) -> None:
    """The joints follow the platform: it goes to the right, and the closure holds."""
    page = open_page(page_of("ren2008"))
    before = page.evaluate("symkin.solution()")
    early = page.locator("#view").bounding_box()
    page.wait_for_function("document.querySelectorAll('#strip button').length > 0")
    page.evaluate("() => new Promise(done => requestAnimationFrame(() => setTimeout(done, 50)))")
    box = page.locator("#view").bounding_box()
    assert abs(box["height"] - early["height"]) < 20.0  # the modes have their room from the start
    place = page.evaluate(ON_PLATFORM)
    x, y = box["x"] + place[0], box["y"] + place[1]
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 12, y, steps=4)
    page.wait_for_function(
        "from => symkin.solution().position.some((v, k) => v !== from[k])", arg=before["position"]
    )
    page.mouse.up()
    after = page.evaluate("symkin.solution()")
    assert after["residual"] < 1e-9 * symkin.load("ren2008").characteristic_length


@pytest.mark.parametrize("width", [1280, 390])
def test_it_is_one_small_file_that_fits(width: int, open_page: Callable[..., Any]) -> None:
    """Nothing is wider than the window; every control has a name; the file is small."""
    html = page_of("zhao2000")
    assert len(html.encode()) < LARGEST
    page = open_page(html, width, 844 if width == 390 else 800)
    assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
    page.locator("#names").click()
    page.locator("#measures").click()
    page.wait_for_timeout(500)
    named = (
        "e => Boolean(e.textContent.trim() || e.getAttribute('aria-label') || "
        "document.querySelector(`label[for='${e.id}']`))"
    )
    assert page.evaluate(
        f"Array.from(document.querySelectorAll('button, input, select')).every({named})"
    )
    top, bottom = (
        f"document.querySelector('{e}').getBoundingClientRect()" for e in (".tools", "p")
    )
    assert page.evaluate(f"innerWidth > 760 || {bottom}.bottom <= {top}.top + 1")
    ARTEFACTS.mkdir(exist_ok=True)
    page.screenshot(path=str(ARTEFACTS / f"zhao2000_{width}.png"))


def test_nothing_is_covered_or_torn_on_narrow_pages(open_page: Callable[..., Any]) -> None:
    """At any width no line ends within an option's name, and the ring of a slider that has the
    keys lies on no text.
    """
    page = open_page(page_of(with_actuated(symkin.load("four_bar"), [])))
    for width in range(300, 420, 4):
        page.set_viewport_size({"width": width, "height": 600})
        assert page.evaluate("document.querySelector('#notes code').getClientRects().length") == 1
    slider = page.locator("#inputs input[type=range]").first
    slider.press("ArrowRight")
    below = """e => {
      const {outlineStyle, outlineWidth, outlineOffset} = getComputedStyle(e);
      const ring = parseFloat(outlineWidth) + parseFloat(outlineOffset);
      return e.getBoundingClientRect().bottom + (outlineStyle === "none" ? 0 : ring);
    }"""
    texts = slider.evaluate(
        "e => e.closest('.input').querySelector('.ends').getBoundingClientRect().top"
    )
    assert slider.evaluate(below) <= texts + 3.5


def test_a_path_is_played(open_page: Callable[..., Any], tmp_path: Path) -> None:
    rows = "".join(f"{0.02 * k},{60 + k}\n" for k in range(21))
    (tmp_path / "path.csv").write_text(f"t[s],crank[deg]\n{rows}", encoding="utf-8")
    file = tmp_path / "four_bar.html"
    assert symkin_view("four_bar", "--path", tmp_path / "path.csv", "--html", file) == 0
    page = open_page(file.read_text(encoding="utf-8"))
    page.get_by_role("button", name="Play").click()
    page.wait_for_function("Math.abs(symkin.solution().joints.crank - 80) < 1e-9")


def symkin_view(*arguments: object) -> int:
    from helpers.inside import _status

    return _status(["view", *map(str, arguments)])


TETRAHEDRON = "v 0 0 0\nv 300 0 0\nv 0 200 0\nv 0 0 100\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
ROBOT = """<robot name='r'><link name='a'/><link name='b'><visual><geometry>
<mesh filename='b.obj' scale='0.01 0.01 0.01'/></geometry></visual>
</link><link name='tip'><visual><geometry><mesh filename='tip.dae'/></geometry></visual></link>
<joint name='j' type='continuous'><parent link='a'/><child link='b'/><axis xyz='0 1 0'/></joint>
<joint name='k' type='continuous'><parent link='b'/><child link='tip'/><origin xyz='0 0 1'/>
<axis xyz='0 1 0'/></joint></robot>"""


def test_meshes_that_are_there_are_shown_and_others_are_told(
    open_page: Callable[..., Any], tmp_path: Path
) -> None:
    (tmp_path / "b.obj").write_text(TETRAHEDRON, encoding="utf-8")
    (tmp_path / "r.urdf").write_text(ROBOT, encoding="utf-8")
    page = open_page(symkin.view(symkin.load(tmp_path / "r.urdf")).html)
    shown = page.evaluate(
        "symkinPage.items.meshes.map(mesh => [mesh.userData.item.name, "
        "mesh.geometry.attributes.position.count])"
    )
    assert shown == [["b", 12]]
    assert (
        "1 file of meshes (tip.dae); there is no such file" in page.locator("#notes").inner_text()
    )
    corner = (
        "symkinPage.items.at({link: 1, point: [3, 0, "
        "0]}).divideScalar(symkinPage.scene.size).project(symkinPage.camera)"
    )
    assert (
        page.evaluate(
            f"(() => {{ const c = {corner}; return Math.max(Math.abs(c.x), Math.abs(c.y)) }})()"
        )
        < 1
    )
    page.locator("#meshes").click()
    assert page.evaluate("symkinPage.items.meshes[0].visible") is False


def test_traces_are_drawn(open_page: Callable[..., Any]) -> None:
    page = open_page(page_of("klann_leg"))
    page.keyboard.press("t")
    page.evaluate("for (let k = 0; k < 9; k++) symkin.set({crank: 180 + 5 * k})")
    count = (
        "symkinPage.extras.children.find(line => line.userData.kind === "
        "'trace').geometry.attributes.position.count"
    )
    assert page.evaluate(count) == 9


def test_results_have_pages(open_page: Callable[..., Any]) -> None:
    """The page of a solution begins there; a track is played; a notebook shows the page in
    place.
    """
    mechanism = symkin.load("zhang2009")
    third = symkin.modes(mechanism)[2]
    view = symkin.view(third)
    assert "<iframe srcdoc=" in view._repr_html_()
    page = open_page(view.html)
    assert apart(mechanism, third, page.evaluate("symkin.solution()")) < SAME
    track = symkin.track(symkin.load("four_bar"), given={"crank": [60.0, 90.0]})
    assert json.loads(track.view().html.split('id="data">')[1].split("</script>")[0])["options"][
        "path"
    ]["names"] == ["crank"]


def test_a_plane_with_singular_curves_is_pointed_at(open_page: Callable[..., Any]) -> None:
    """The mechanism goes where the plane is pointed at, and no further than the first curve."""
    here = symkin.solve(symkin.load("zhao2000")).solution
    loci = symkin.singular_loci(
        here, ("theta1", "op"), ranges=[(20.0, 150.0), (60.0, 160.0)], starts=3
    )
    page = open_page(loci.view().html)
    box = page.locator("#plane svg").bounding_box()
    page.mouse.click(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    page.wait_for_function(
        "Math.abs(symkin.solution().joints.op - 110) < 1 && "
        "Math.abs(symkin.solution().joints.theta1 - 85) < 1"
    )
    ARTEFACTS.mkdir(exist_ok=True)
    page.wait_for_timeout(400)
    page.screenshot(path=str(ARTEFACTS / "plane.png"))


def test_a_sweeps_map_is_pointed_at(open_page: Callable[..., Any], tmp_path: Path) -> None:
    """The five-bar's tip over its workspace: it goes where the map is pointed at, and a sweep's
    counts are those of the page.
    """
    pytest.importorskip("zarr")
    swept = symkin.sweep(
        readme_five_bar("planar"),
        given={"x": np.linspace(-250, 250, 10), "y": np.linspace(-260, 260, 10)},
        directory=tmp_path / "map",
        workers=0,
    )
    page = open_page(swept.view(loci=True).html)
    assert (
        page.locator("#plane p")
        .inner_text()
        .startswith("Number of real modes, singular curves type 2")
    )
    assert page.locator("#plane .legend").last.inner_text().split() == ["4", "none"]
    assert page.evaluate("symkin.modes().length") == 4
    box = page.locator("#plane svg").bounding_box()
    page.mouse.click(box["x"] + 0.5 * box["width"], box["y"] + 0.25 * box["height"])
    page.wait_for_function(
        "symkin.solution().position[1] > 100 && Math.abs(symkin.solution().position[0]) < 5"
    )
    ARTEFACTS.mkdir(exist_ok=True)
    page.screenshot(path=str(ARTEFACTS / "map.png"))


def test_the_map_of_poses_drags_the_platform(open_page: Callable[..., Any], tmp_path: Path) -> None:
    """A slice of a workspace: sliders are those of the motors, and the platform goes where the map
    is pointed at.
    """
    pytest.importorskip("zarr")
    delta, reach = symkin.load("delta"), np.linspace(-120.0, 120.0, 9)
    swept = symkin.sweep(
        delta,
        {"x": reach, "y": reach, "z": [-300.0, -250.0]},
        tmp_path / "map",
        poses=True,
        quantity="conditioning",
        workers=0,
    )
    page = open_page(swept.view(slices={"z": -250.0}).html)
    assert page.evaluate("symkin.names") == [c.name for c in delta.actuated]
    assert "z = -250 mm" in page.locator("#plane p").inner_text()
    box = page.locator("#plane svg").bounding_box()
    page.mouse.click(box["x"] + 0.6 * box["width"], box["y"] + 0.4 * box["height"])
    page.wait_for_function(
        "symkin.solution().position[0] > 15 && symkin.solution().position[1] > 15"
    )
    assert abs(page.evaluate("symkin.solution().position[2]") + 250.0) < 1e-3


def test_maps_without_a_page_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("zarr")
    bars = symkin.load("four_bar")
    symkin.sweep(bars, given={"crank": [10.0, 20.0]}, directory=tmp_path / "line", workers=0)
    symkin.sweep(
        symkin.load("ankle"),
        given={"upper_motor": [0.0, 5.0], "lower_motor": [0.0, 5.0]},
        directory=tmp_path / "ankle",
        workers=0,
    )
    for arguments, part in (
        (("four_bar", "--map", tmp_path / "line"), "is no plane"),
        (("four_bar", "--map", tmp_path / "ankle"), "the sweep is of ankle"),
        (("four_bar", "--map", tmp_path / "none"), "none"),
        (("four_bar", "--map", tmp_path / "line", "--given", "crank=3"), "both --map and --given"),
        (("four_bar", "--loci"), "belongs to the map"),
    ):
        status, _, err = run(capsys, "view", *arguments, "--html", tmp_path / "a.html")
        assert status == 2
        assert part in err
        assert err.count("\n") == 1


def test_wrong_input_is_told_in_a_sentence(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    for arguments, part in (
        (("four_bar", "--html", tmp_path / "page.txt"), ".html"),
        (("four_bar", "--given", "krank=3", "--html", tmp_path / "a.html"), "crank"),
        (("zhang2009", "--joints", "1,900", "--html", tmp_path / "a.html"), "6"),
        (
            ("zhang2009", "--joints", "1,900,1,900,1,900", "--html", tmp_path / "a.html"),
            "no configuration",
        ),
        (("four_bar", "--path", tmp_path / "none.csv", "--html", tmp_path / "a.html"), "none.csv"),
        (("ren2008", "--given", "pose=1,2,3,1,0,0,0", "--html", tmp_path / "a.html"), "--pose"),
        (
            (
                "ren2008",
                "--pose",
                "1,2,3,1,0,0,0",
                "--joints",
                "1,2",
                "--html",
                tmp_path / "a.html",
            ),
            "--joints",
        ),
        (
            ("zhao2000", "--pose", "20,0,700", "--rpy", "0,10,0", "--html", tmp_path / "a.html"),
            "off the platform's",
        ),
        (("ren2008", "--rpy", "0,10,0", "--html", tmp_path / "a.html"), "--pose X,Y,Z"),
    ):
        status, _, err = run(capsys, "view", *arguments)
        assert status == (3 if part in ("no configuration", "off the platform's") else 2)
        assert part in err
        assert err.count("\n") == 1
    with pytest.raises(InputError, match="has no page"):
        symkin.view(3)
    with pytest.raises(InputError, match="has no names"):
        len(symkin.view(symkin.load("four_bar"), given=[60.0]).html)


@pytest.mark.parametrize(("name", "count"), [("ren2008", 28), ("klann_leg", 4)])
def test_every_complex_solution_is_followed(
    open_page: Callable[..., Any], name: str, count: int
) -> None:
    """As many as `modes` counts: of a body on rods from symkin's own, of others by loops wide
    enough to go around branch points.
    """
    assert symkin.modes(symkin.load(name)).complex_count == count
    page = open_page(page_of(name))
    page.wait_for_function("symkin.modes().length > 0")
    page.wait_for_function(
        f"document.body.innerText.includes('{count} complex solutions are followed')"
    )


def test_more_solutions_than_are_followed_are_told(
    open_page: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The page keeps to the mode shown and those of the start."""
    monkeypatch.setattr(inside.model_data, "_MOST_ROOTS", 1)
    page = open_page(symkin.view(symkin.load("klann_leg")).html)
    page.wait_for_function(
        "document.querySelector('#modes').innerText.includes('4 complex solutions are too many')"
    )
    name, value = page.evaluate("[symkin.names[0], symkin.solution().joints[symkin.names[0]]]")
    assert page.evaluate(
        "([name, value]) => symkin.set({[name]: value}).reached", [name, value + 0.01]
    )
    assert page.evaluate("symkin.modes().length") == 1


def test_a_page_begins_at_a_pose(
    open_page: Callable[..., Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """At the first of the working modes there, with sliders for the motors; roll, pitch and yaw as
    Euler's angles about fixed axes.
    """
    page_file, pose = tmp_path / "page.html", ["--pose", "0.02,0.01,0.7", "--rpy", "5,-3,20"]
    assert run(capsys, "view", "ren2008", *pose, "--html", page_file)[0] == 0
    page = open_page(page_file.read_text())
    told = page.evaluate("symkin.solution()")
    mechanism = symkin.load("ren2008")
    at = symkin.Pose.from_euler((0.02, 0.01, 0.7), (5, -3, 20), "xyz", angle_unit="deg")
    (mode,) = symkin.modes(mechanism, pose=at)
    assert apart(mechanism, mode, told) < 1e-9
    assert page.evaluate("symkin.names") == [c.name for c in mechanism.actuated]


PARTS = """async () => {
  const [{createSolver}, generated, {leastSquares, relativeChange, singularPair}] =
    await Promise.all(['solver', 'generated', 'solver-algebra'].map(name => import(name)));
  const {model} = JSON.parse(document.getElementById('data').textContent);
  const system = createSolver(model, generated).system, {parts, unknown} = system,
    n = unknown.length, m = model.rows;
  const whole = x => { generated.system(x, system.values, system.gradients);
    return Float64Array.from({length: m * n}, (_,
      k) => system.gradients[Math.floor(k / n) * model.width + unknown[k % n]]) };
  const x = Float64Array.from(model.start), other = x.map((v, k) => v + 0.01 * Math.sin(k));
  const right = Float64Array.from({length: m}, (_, k) => Math.cos(k)), pair = singularPair(whole(x),
    m, n);
  return {sizes: parts.map(part => part.columns.length),
    solutions: [system.solve(system.linearise(x), right), leastSquares(whole(x), right.slice(), n)]
      .map(y => Array.from(y)),
    changes: [system.change(x, other), relativeChange(whole(x), whole(other), n)],
    ratios: [system.singularPair(x).ratio, pair.least / pair.most]};
}"""


LEGS = Path(__file__).parents[1] / "data" / "models" / "urdf_loop_joint" / "strandbeest.urdf"
PARTED = {
    "twelve legs on one crank": (lambda: symkin.load(LEGS), 12 * [6]),
    "two four-bars on one crank": (two_four_bars, [2, 2]),
    "a platform": (lambda: symkin.load("zhang2009"), [7]),
    "a platform of links": (lambda: symkin.load("zhao2000_links"), [16]),
}
"""Machines and how many unknowns their parts have; platforms are one part each."""


@pytest.mark.parametrize("name", in_gate(PARTED, ["two four-bars on one crank", "a platform"]))
def test_parts_that_share_nothing_are_solved_as_the_whole(
    name: str, open_page: Callable[..., Any]
) -> None:
    """Least squares, change of the Jacobian and singular values are the same."""
    made, sizes = PARTED[name]
    found = open_page(page_of(made())).evaluate(PARTS)
    assert found["sizes"] == sizes
    np.testing.assert_allclose(
        *found["solutions"], rtol=1e-7, atol=1e-9 * np.abs(found["solutions"][1]).max()
    )
    np.testing.assert_allclose(*found["changes"], rtol=1e-7)
    np.testing.assert_allclose(*found["ratios"], rtol=1e-7)


def test_joints_that_begin_beyond_limits_do_not_hold_what_leaves_them_there(
    open_page: Callable[..., Any],
) -> None:
    """The Kangaroo's file begins with both lengths and femurs beyond their limits: other joints
    move, these inwards only.
    """
    mechanism = symkin.load(
        Path(__file__).parents[1] / "data" / "models" / "mjcf" / "kangaroo_lower_body.xml"
    )
    page = open_page(page_of(mechanism))
    assert page.evaluate("symkin.solution().within_limits") is False
    names = page.evaluate("symkin.names")
    stops = {}
    for name in names:
        for step in (0.02, -0.02):
            found = page.evaluate(
                "([name, v]) => { const r = symkin.set({[name]: v}); symkin.set({[name]: 0}); "
                "return r }",
                [name, step],
            )
            if not found["reached"]:
                stops[name, step] = found["stop"]
    assert 0 < len(stops) <= 2
    for (name, _), stop in stops.items():
        assert stop["sentence"].startswith(f"Stopped at once: {name} lies beyond its limit of ")
    page.get_by_role("button", name="Limits").click()
    page.get_by_role("button", name="Back to the start").click()
    name, step = next(iter(stops))
    found = page.evaluate("([name, v]) => symkin.set({[name]: v})", [name, step])
    assert found["reached"], found["stop"]


def test_a_page_without_a_configuration_is_not_found(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """As `modes` has it: status 3, one line, and no file."""
    file = tmp_path / "page.html"
    status, out, err = run(capsys, "view", "slider_crank", "--given", "piston=1e4", "--html", file)
    assert (status, out) == (3, "")
    assert "has no configuration at these values" in err
    assert len(err.splitlines()) == 1
    assert not file.exists()


def test_a_stop_at_a_limit_is_the_last(open_page: Callable[..., Any]) -> None:
    """Asked again and again, a slide stays where it stopped, within its limits, and the value of
    the stop is told.
    """
    page = open_page(page_of("scara"))
    first = page.evaluate("symkin.set({slide: 1e3}).stop")
    stopped = page.evaluate("symkin.solution().joints.slide")
    assert first["kind"] == "limit"
    assert first["sentence"].startswith("Stopped at slide = ")
    for _ in range(5):
        assert not page.evaluate("symkin.set({slide: 1e3})")["reached"]
    assert page.evaluate("symkin.solution().joints.slide") == stopped
    assert page.evaluate("symkin.solution().within_limits") is True


def test_where_branches_meet_it_is_said(open_page: Callable[..., Any]) -> None:
    """A parallelogram passes its flat configuration as one or as a crossed one; a six-rod
    platform's modes end in each other.
    """
    page = open_page(page_of("parallel_gripper"))
    assert "branches meet here" in page.evaluate("symkin.set({left: -20}).stop.sentence")
    page = open_page(page_of("zhang2009"))
    assert "beyond it this mode does not go on" in page.evaluate(
        "symkin.set({leg1: 700}).stop.sentence"
    )


def test_a_symmetric_start_loses_no_modes(open_page: Callable[..., Any]) -> None:
    """A 3-RRR with equal limbs: at zero all but two of six complex solutions are at infinity,
    elsewhere they are modes.
    """
    start = three_rrr("planar")
    page = open_page(symkin.view(start).html)
    page.wait_for_function("!document.querySelector('#modes-text').textContent.includes('Finding')")
    rng = np.random.default_rng(4)
    home = page.evaluate("symkin.names.map((name) => symkin.solution().joints[name])")
    for _ in range(6):
        values = (np.array(home) + rng.uniform(-0.6, 0.6, 3)).tolist()
        if not page.evaluate(
            "v => symkin.set(Object.fromEntries(symkin.names.map((n, k) => [n, v[k]]))).reached",
            values,
        ):
            continue
        assert len(page.evaluate("symkin.modes()")) == len(symkin.modes(start, joints=values))


def test_a_path_of_poses_is_played_in_its_mode(
    open_page: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The delta below its base and not above it, where the same motor angles also close."""
    monkeypatch.setattr(inside.played_path, "_POSE_SAMPLES", 20)
    file = tmp_path / "poses.csv"
    file.write_text(
        "x[mm],y[mm],z[mm],qw,qx,qy,qz\n0,0,-300,1,0,0,0\n20,10,-320,1,0,0,0\n", encoding="utf-8"
    )
    page = open_page(symkin.view(symkin.load("delta"), path=file).html)
    np.testing.assert_allclose(
        page.evaluate("symkin.solution().position"), [0.0, 0.0, -300.0], atol=1e-9
    )


def test_keys_that_come_fast_all_count(open_page: Callable[..., Any]) -> None:
    page = open_page(page_of("four_bar"))
    page.locator("#given-crank").focus()
    before = page.evaluate("symkin.solution().joints.crank")
    page.evaluate(
        "() => { const slider = document.querySelector('#given-crank');"
        " for (let k = 0; k < 8; k++) slider.dispatchEvent(new KeyboardEvent('keydown', { key: "
        "'ArrowRight', bubbles: true })); }"
    )
    low, high = (float(page.locator("#given-crank").get_attribute(end)) for end in ("min", "max"))
    page.wait_for_function(
        "at => Math.abs(symkin.solution().joints.crank - at) < 1e-9",
        arg=before + 8 * (high - low) / 200,
    )
    page.locator("#given-crank-number").fill("1,000")
    page.locator("#given-crank-number").press("Enter")
    assert "may be two numbers" in page.locator("body").inner_text()


def test_a_value_out_of_reach_is_not_called_singular(open_page: Callable[..., Any]) -> None:
    """UR5e: a serial arm has no singularity of the direct problem, whatever is typed; with limits
    it stops there.
    """
    page = open_page(page_of("ur5e"))
    name = page.evaluate("symkin.names[0]")
    assert page.evaluate(f"symkin.set({{{name}: 0.3}}).reached")
    for value in (1e9, -1e12, 1e200):
        found = page.evaluate("([name, v]) => symkin.set({[name]: v})", [name, value])
        assert not found["reached"]
        assert found["stop"]["kind"] in ("limit", "lost")
        assert "singular" not in found["stop"]["sentence"]


def test_a_cut_joint_has_its_own_unit_whatever_its_name(tmp_path: Path) -> None:
    pytest.importorskip("zarr")
    text = symkin.load("spherical_wrist").to_toml().replace('"motor1"', '"x"')
    grid = {"x": [0.0, 10.0], "motor2": [0.0, 5.0, 10.0], "motor3": [0.0, 5.0, 10.0]}
    swept = symkin.sweep(inside.parse(text), grid, tmp_path / "map", workers=0)
    plane = swept.view(slices={"x": 10.0}).plane
    assert plane is not None
    assert plane["held"] == "x = 10 deg"


def test_a_planar_map_of_poses_tells_its_angle(tmp_path: Path) -> None:
    pytest.importorskip("zarr")
    machine, ends = three_rrr("planar"), [-5.0, 0.0, 5.0]
    swept = symkin.sweep(machine, {"x": ends, "y": ends}, tmp_path / "map", poses=True, workers=0)
    plane = swept.view().plane
    assert plane is not None
    assert plane["held"] == f"gamma = 0 {machine.angle_unit}"


@pytest.mark.parametrize("limbs", in_gate([2, 6], [2]))
def test_different_machines_stand_before_half_turns(
    limbs: int, open_page: Callable[..., Any]
) -> None:
    """Of 8 or 128 modes at two poses, which differ in U joints otherwise, the first two are at the
    two poses.
    """
    page = open_page(symkin.view(rus_on_rods(limbs)).html)
    heights = [mode["position"][2] for mode in page.evaluate("symkin.modes()")]
    poses = len({round(height, 3) for height in heights})
    assert len(heights) > poses > 1
    assert len({round(height, 3) for height in heights[:poses]}) == poses
