"""Laws of the graph solver of `tests/oracle` that judges modes: derivatives, starts, idle freedoms,
forms of a file; and what it finds for the shipped graphs, against the table in `data/gallery.json`.
"""

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest

from helpers.gate import in_gate
from helpers.shipped import TWELVE
from oracle.plain_graph import CLOSED, Graph, configurations, random_starts, read, structure
from oracle.plain_graph_file import Reader, number

ROOT = Path(__file__).resolve().parents[2]
MECHANISMS = ROOT / "symkin" / "mechanisms"
GALLERY = json.loads((Path(__file__).parents[1] / "data" / "gallery.json").read_text())
CASES = [(name, k) for name, entry in GALLERY.items() for k in range(len(entry["cases"]))]
SEARCHED = [case for case in CASES if case[0] != "hexapod_stack"]
STARTS_A_MODE = 40
"""Enough to meet each mode: the rarest of these mechanisms is met by one start in a hundred."""

HEAD = 'format = 1\nname = "m"\nlength_unit = "mm"\nangle_unit = "deg"\n'
CHAIN = """
[[joint]]
name = "r"
type = "R"
links = ["base", "a"]
point = [0, 0, 10]
axis = [0, 1, 2]
zero = 30
[[joint]]
name = "c"
type = "C"
links = ["b", "a"]
point = [20, 5, 10]
axis = [1, 1, 0]
[[joint]]
name = "u"
type = "U"
links = ["b", "c"]
point = [20, 30, 10]
axis = [1, 0, 0]
axis2 = [0, 1, 1]
[[joint]]
name = "h"
type = "H"
links = ["c", "d"]
point = [50, 30, 10]
axis = [0, 0, 1]
pitch = 12
[[joint]]
name = "s"
type = "S"
links = ["e", "d"]
point = [50, 30, 40]
[[joint]]
name = "p"
type = "P"
links = ["e", "f"]
axis = [1, 2, 3]
zero = 4
[[joint]]
name = "w"
type = "weld"
links = ["f", "g"]
point = [60, 20, 40]
[[coupling]]
joint = "p"
of = "h"
polynomial = [4, 0.1, 0.02]
[[coupling]]
joint = "c.slide"
of = { r = 0.5, h = -0.25 }
offset = -15
"""
CLOSING_ROD = """
[[rod]]
name = "rod"
links = ["base", "g"]
from = [40, -20, 0]
to = [60, 20, 60]
actuated = true
offset = 5
"""


def graph(text: str, given: tuple[str, ...] = ()) -> Graph:
    """The graph of a file's text."""
    return Graph(**vars(Reader(tomllib.loads(HEAD + text), given).graph()))


def test_arithmetic_of_files():
    """Trigonometry is in the angle unit; a power binds more tightly than a sign and to the
    right.
    """
    assert number("2*cos(60) - sqrt(4)/2", np.pi / 180) == pytest.approx(0.0, abs=1e-15)
    assert number("-2^2") == -4
    assert number("2^3^2") == 512
    with pytest.raises((ValueError, KeyError)):
        number("abs(3)")


def test_derivatives_are_finite_differences():
    """All joint types, rods, couplings and pose coordinates, at random open configurations."""
    platform = '[platform]\nlink = "g"\nposition = [60, 20, 80]\nquaternion = [0.6, 0, 0.8, 0]\n'
    g = graph(CHAIN + CLOSING_ROD + platform, ("x", "tilt"))
    rng = np.random.default_rng(0)
    x = g.move(random_starts(g, 5, {}, rng), 0.1 * rng.normal(size=(5, g.freedom)))
    step, h = rng.normal(size=(5, g.freedom)), 1e-6
    for value in (g.closure, g.observed):
        change = (value(g.move(x, h * step))[0] - value(g.move(x, -h * step))[0]) / (2 * h)
        expected = np.einsum("nrf,nf->nr", value(x)[1], step)
        if value == g.observed:
            turns = len(g.coordinates)  # two numbers stand for each
            change, expected = change[:, 2 * turns :], expected[:, turns:]
        assert change == pytest.approx(expected, abs=1e-7)


def test_starts_of_a_tree_are_closed():
    """Without loops the links carried along a tree of joints close every row, whichever end of a
    joint comes first.
    """
    g = graph(CHAIN)
    for seed in range(5):
        rows, _ = g.closure(random_starts(g, 20, {}, np.random.default_rng(seed)))
        assert np.max(np.abs(rows)) < 1e-12


CRANKS = """
[[joint]]
name = "a"
type = "R"
links = ["base", "arm"]
point = [0, 0, 0]
axis = [0, 0, 1]
[[joint]]
name = "b"
type = "R"
links = ["base", "rocker"]
point = [100, 0, 0]
axis = [0, 1, 1]
"""


def rod(actuated: bool) -> str:
    """A rod between the two cranks."""
    text = (
        '[[rod]]\nname = "rod"\nlinks = ["arm", "rocker"]\nfrom = [0, 40, 0]\nto = [120, 70, 10]\n'
    )
    return CRANKS + text + ("actuated = true\n" if actuated else "")


def strut(kind: str) -> str:
    """The same of a link, or of two with a joint along the line between the spherical ends."""
    ends = (
        ("near", "arm", "strut", [0, 40, 0]),
        ("far", "rocker", "strut2" if kind else "strut", [120, 70, 10]),
    )
    balls = "".join(
        f'[[joint]]\nname = "{n}"\ntype = "S"\nlinks = ["{a}", "{b}"]\npoint = {p}\n'
        for n, a, b, p in ends
    )
    middle = (
        f'[[joint]]\nname = "middle"\ntype = "{kind}"\nlinks = ["strut", "strut2"]\n'
        f"point = [60, 55, 5]\naxis = [12, 3, 1]\n"
    )
    return CRANKS + balls + (middle if kind else "")


def test_a_rod_is_a_link_between_two_spherical_joints():
    """Both give the same configurations; the link's spin is idle and no mobility."""
    found = [configurations(graph(text), {"a": 20}, 100) for text in (rod(False), strut(""))]
    followers = [np.sort(np.cos(f.x[:, -1])) for f in found]
    assert followers[0] == pytest.approx(followers[1], abs=1e-9)


@pytest.mark.parametrize(
    ("text", "mobility", "idle"),
    [
        (rod(False), 1, 0),
        (strut(""), 1, 1),
        (rod(True), 2, 0),
        (strut("P"), 2, 1),
        (strut("C"), 2, 2),
        (strut("R"), 1, 2),
    ],
)
def test_spins_of_struts_are_idle(text, mobility, idle):
    """A joint along a strut between spherical ends lets its halves spin alone; its slide is a
    freedom of the mechanism.
    """
    s = structure(graph(text))
    assert (s.mobility, s.idle) == (mobility, idle)


@pytest.mark.parametrize(
    ("name", "mobility"),
    [
        ("zhao2000_links", 4),
        pytest.param("zhao2000", 4, marks=pytest.mark.long),
        pytest.param("ren2008", 6, marks=pytest.mark.long),
        ("zhang2009", 6),
    ],
)
def test_limbs_are_graphs(name, mobility):
    """Limbs of joints and of rods are read as links and joints; the mobility is the published
    one.
    """
    assert structure(read(MECHANISMS / f"{name}.toml")).mobility == mobility


@pytest.mark.parametrize("name", in_gate(GALLERY, TWELVE))
def test_structure_of_shipped_graphs(name):
    """The reference is closed to 1e-12 of the size; loops and mobility are the table's."""
    g, entry = read(MECHANISMS / f"{name}.toml"), GALLERY[name]
    assert np.max(np.abs(g.closure(g.reference()[None])[0])) < 1e-12
    s = structure(g)
    assert {key: getattr(s, key) for key in entry if key != "cases"} == {
        k: v for k, v in entry.items() if k != "cases"
    }


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "case"),
    in_gate(
        SEARCHED,
        [c for c in SEARCHED if c[0] in TWELVE and c[0] not in ("jansen_leg", "spherical_wrist")],
    ),
)
def test_configurations_of_shipped_graphs(name, case):
    """Random starts find the table's number of configurations, all closed and isolated."""
    entry = GALLERY[name]["cases"][case]
    g = read(MECHANISMS / f"{name}.toml", list(entry["given"]))
    found = configurations(g, entry["given"], STARTS_A_MODE * entry["count"], seed=3)
    assert len(found.x) == entry["count"]
    assert found.isolated.all()
    assert np.max(np.abs(g.closure(found.x)[0])) < CLOSED
