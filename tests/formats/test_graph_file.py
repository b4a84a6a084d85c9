"""Files of graphs (form e): what is written reads back as an equal mechanism, and every mistake is
one clear line.
"""

import json
from dataclasses import replace
from pathlib import Path

import pytest

import symkin
from helpers.inside import parse
from helpers.mistakes import assert_refused_in_one_line
from symkin import Coupling, Joint, Limb, LinkJoint, LinkPoint, LinkRod, Mechanism, RodLimb

GALLERY = sorted(json.loads((Path(__file__).parents[1] / "data" / "gallery.json").read_text()))


def everything(unit: str) -> Mechanism:
    """A graph with every kind of entry and key that the format has."""
    z = (0.0, 0.0, 1.0)
    joints = [
        LinkJoint(
            Joint("r", "R", (0, 0, 0), z, actuated=True, zero=0.3, limits=(-1.0, 2.5)),
            ("base", "arm"),
        ),
        LinkJoint(Joint("c", "C", (5, 0, 0), (1.0, 2.0, 3.0)), ("arm", "cart")),
        LinkJoint(
            Joint("u", "U", (9, 0, 0), z, (1.0, 0.0, 0.0), actuated=True), ("cart", "platform")
        ),
        LinkJoint(Joint("screw", "H", (3, 1, 0), z, pitch=4.0, zero=0.1), ("base", "nut")),
        LinkJoint(Joint("rail", "P", (3, 1, 7), z, zero=2.0, limits=(-4.0, 4.0)), ("nut", "end")),
        LinkJoint(Joint("ball", "S", (1, 2, 3)), ("end", "knob")),
        LinkJoint(Joint("glue", "weld"), ("knob", "cap")),
    ]
    rods = [
        LinkRod("bar", ("nut", "platform"), (1, 2, 3), (4, 5, 6), length=5.25),
        LinkRod(
            "jack",
            ("base", "cart"),
            (1, 2, 3),
            (4, 5, 16),
            actuated=True,
            offset=2.0,
            limits=(1.0, 30.0),
        ),
    ]
    limbs = [
        RodLimb("leg", (0, 1, 0), (2, 3, 4), offset=1.0, links=("arm", "platform")),
        Limb(
            "chain",
            [Joint("k1", "R", (0, 4, 0), z), Joint("k2", "S", (0, 8, 0))],
            links=("base", "cap"),
        ),
    ]
    couplings = [
        Coupling("rail", {"r": 2.5, "screw": -0.7}, offset=0.4),
        Coupling("k1", "r", polynomial=(0.1, -1.25, 0.03)),
        Coupling("screw", {"jack": 0.01, "u.1": -1.25}, offset=-0.2),
    ]
    points = [
        LinkPoint("arm", "tip", (1, 2, 3)),
        LinkPoint("cap", "top", (0, 0, 9)),
        LinkPoint("arm", "nose", (7, 8, 9)),
    ]
    return Mechanism(
        "everything",
        limbs,
        (1.0, 2.0, 3.0),
        (0.8, 0.6, 0.0, 0.0),
        length_unit="mm",
        angle_unit=unit,
        title="All of it",
        source="a test",
        link_joints=joints,
        link_rods=rods,
        couplings=couplings,
        link_points=points,
        platform_link="platform",
    )


# --- round trips ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", GALLERY)
def test_shipped_graphs_are_written_and_read_back_as_equal_ones(name):
    mechanism = symkin.load(name)
    again = parse(mechanism.to_toml())
    assert again == mechanism
    assert again.digest == mechanism.digest
    assert again.is_graph


def test_every_entry_of_a_graph_is_written_and_read_back():
    mechanism = everything("rad")
    again = parse(mechanism.to_toml())
    assert again == mechanism
    assert again.digest == mechanism.digest


def test_a_file_in_degrees_reads_back_as_it_was_read():
    once = parse(everything("deg").to_toml())
    assert parse(once.to_toml()) == once


def test_factors_of_like_units_are_read_as_they_are_written():
    """A gear's factor has no unit where both coordinates have the same one."""
    gear = symkin.load("planetary_gear")
    assert dict(gear.couplings[0].terms) == {"sun": -1.25, "carrier": 1.25}


@pytest.mark.parametrize(
    "change",
    [
        {"couplings": ()},
        {"link_points": ()},
        {"platform_link": "cap"},
        {"link_rods": (LinkRod("bar", ("nut", "platform"), (1, 2, 3), (4, 5, 6), length=5.5),)},
    ],
)
def test_the_digest_tells_graphs_apart(change):
    mechanism = replace(everything("rad"), couplings=())
    other = (
        replace(everything("rad"), **{"couplings": ()} | change)
        if "couplings" not in change
        else everything("rad")
    )
    assert mechanism.digest != other.digest


# --- mistakes -------------------------------------------------------------------------------------

GRAPH = """format = 1
name = "m"
length_unit = "mm"
angle_unit = "deg"
[[joint]]
name = "crank"
type = "R"
links = ["base", "arm"]
point = [0, 0, 0]
axis = [0, 0, 1]
actuated = true
[[joint]]
name = "elbow"
type = "R"
links = ["arm", "foot"]
point = [30, 0, 0]
axis = [0, 0, 1]
[[rod]]
name = "bar"
links = ["base", "foot"]
from = [100, 0, 0]
to = [100, 50, 0]
[[coupling]]
joint = "elbow"
of = { crank = 2.0 }
[[link]]
name = "foot"
points = { toe = [100, 50, 0] }
[platform]
link = "foot"
"""


def swap(old: str, new: str) -> str:
    assert old in GRAPH
    return GRAPH.replace(old, new, 1)


BALL = '[[joint]]\nname = "knee"\ntype = "S"\nlinks = ["foot", "toe_link"]\npoint = [1, 2, 3]\n'
LIMB = (
    '[[limb]]\nname = "leg"\n[[limb.joint]]\nname = "k1"\ntype = "R"\npoint = [1, 2, 3]\n'
    "axis = [0, 0, 1]\n"
)
ISLAND = (
    '[[joint]]\nname = "j"\ntype = "R"\nlinks = ["left", "right"]\npoint = [1, 2, 3]\n'
    "axis = [0, 0, 1]\n"
)

# case: (text, what the message must hold beside the file's name)
BAD = {
    "a link that nothing holds": (
        GRAPH + ISLAND,
        ["link 'left'", "nothing holds it to the base", "nor 1 more", "join it"],
    ),
    "no link is the base": (
        GRAPH.replace('"base"', '"frame"'),
        ["names the link 'base'", "fixed link"],
    ),
    "a table of a link that nothing holds": (
        swap('[[link]]\nname = "foot"', '[[link]]\nname = "fooot"'),
        ["link[0] (fooot)", "nothing holds it", "do you mean 'foot'?"],
    ),
    "a coupling of an unknown joint": (
        swap('joint = "elbow"\nof', 'joint = "elbo"\nof'),
        [
            "coupling: joint = 'elbo'",
            "unknown",
            "do you mean 'elbow'?",
            "coordinates are crank, elbow",
        ],
    ),
    "a coupling to an unknown joint": (
        swap("{ crank = 2.0 }", "{ cranky = 2.0 }"),
        ["coupling of 'elbow'", "'cranky'", "unknown", "do you mean 'crank'?"],
    ),
    "a circle of couplings": (
        GRAPH + '[[coupling]]\njoint = "crank"\nof = { elbow = 0.5 }\n',
        ["coupling of 'elbow'", "circle", "leave one of them out"],
    ),
    "a joint coupled to itself": (
        swap("{ crank = 2.0 }", "{ elbow = 2.0 }"),
        ["coupling of 'elbow'", "itself"],
    ),
    "a joint coupled twice": (
        GRAPH + '[[coupling]]\njoint = "elbow"\nof = { crank = 0.5 }\n',
        ["coupling of 'elbow'", "twice", "once"],
    ),
    "a coupling of a ball": (
        GRAPH + BALL + '[[coupling]]\njoint = "crank"\nof = { knee = 0.5 }\n',
        ["coupling of 'crank'", "'knee' is a spherical joint", "allowed"],
    ),
    "a coupling to nothing": (
        swap("{ crank = 2.0 }", "{}"),
        ["coupling of 'elbow'", "no joint", "factors"],
    ),
    "a coupling to a number": (
        swap("{ crank = 2.0 }", "3"),
        ["coupling[0].of = 3", "name of a joint", "factors"],
    ),
    "points in a list": (
        swap("{ toe = [100, 50, 0] }", "[100, 50, 0]"),
        ["link[0] (foot).points", "a table"],
    ),
    "a polynomial of several": (
        swap("{ crank = 2.0 }", "{ crank = 2.0 }\npolynomial = [0, 1]"),
        ["coupling of 'elbow'", "polynomial", "one joint"],
    ),
    "a polynomial without coefficients": (
        swap("{ crank = 2.0 }", '"crank"'),
        ["coupling of 'elbow'", "needs polynomial"],
    ),
    "a polynomial of too many": (
        swap("{ crank = 2.0 }", '"crank"\npolynomial = [0, 1, 2, 3, 4, 5]'),
        ["coupling of 'elbow'", "6 coefficients", "2 to 5"],
    ),
    "a joint from a link to itself": (
        swap('["arm", "foot"]', '["arm", "arm"]'),
        ["joint 'elbow'", "'arm' to itself", "two links"],
    ),
    "a rod from a link to itself": (
        swap('["base", "foot"]', '["foot", "foot"]'),
        ["rod 'bar'", "'foot' to itself", "two links"],
    ),
    "a joint of three links": (
        swap('["arm", "foot"]', '["arm", "foot", "x"]'),
        ["joint[1] (elbow).links", "3 entries", "2 needed"],
    ),
    "two joints of one name": (swap('name = "elbow"', 'name = "crank"'), ["'crank'", "unique"]),
    "a rod named as a joint": (swap('name = "bar"', 'name = "crank"'), ["'crank'", "unique"]),
    "two points of one name": (
        swap(
            "{ toe = [100, 50, 0] }",
            "{ toe = [100, 50, 0] }\n[[link]]\nname = 'arm'\npoints = { toe = [0, 0, 0] }",
        ),
        ["two points are named 'toe'", "unique"],
    ),
    "an actuated S": (
        GRAPH + BALL.replace('"S"', '"S"\nactuated = true'),
        ["joint 'knee'", "actuated = true", "not for S", "three R joints"],
    ),
    "an actuated weld": (
        GRAPH + BALL.replace('"S"', '"weld"\nactuated = true').replace("point = [1, 2, 3]\n", ""),
        ["joint 'knee'", "actuated = true", "not for weld"],
    ),
    "a platform link that is the base": (
        swap('link = "foot"\n', 'link = "base"\n'),
        ["platform.link = 'base'", "does not move"],
    ),
    "a platform link that is unknown": (
        swap('link = "foot"\n', 'link = "foots"\n'),
        ["platform.link = 'foots'", "unknown", "do you mean 'foot'?"],
    ),
    "a platform frame on no link": (
        swap('link = "foot"\n', "position = [1, 2, 3]\n"),
        ["platform.link is missing", "carries the platform frame"],
    ),
    "an unknown key of a joint": (
        swap("actuated", "actuate"),
        ["joint[0] (crank).actuate", "unknown key", "do you mean 'actuated'?"],
    ),
    "an unknown key of a rod": (swap("from =", "form ="), ["rod[0] (bar)"]),
    "an unknown key of a rod more": (
        swap("from =", "lenght = 5\nfrom ="),
        ["rod[0] (bar).lenght", "do you mean 'length'?"],
    ),
    "an unknown key of a coupling": (
        swap("of =", "off = 2.0\nof ="),
        ["coupling[0].off", "unknown key", "allowed"],
    ),
    "an unknown key of a link": (
        swap("points =", "point ="),
        ["link[0] (foot).point", "do you mean 'points'?"],
    ),
    "an unknown key of the platform": (
        swap('link = "foot"\n', 'links = "foot"\n'),
        ["platform.links", "do you mean 'link'?"],
    ),
    "joints with and without links": (
        swap('links = ["arm", "foot"]\n', ""),
        ["joint 'elbow'", "links is missing", "names the two links"],
    ),
    "a weld in a limb": (
        GRAPH + LIMB.replace('"R"', '"weld"'),
        ["limb[0] (leg).joint[0] (k1).type", "'weld'", "left out"],
    ),
    "links of a limb's joint": (
        GRAPH + LIMB + 'links = ["base", "foot"]\n',
        ["limb[0] (leg).joint[0] (k1).links", "unknown key", "at the top of the file"],
    ),
    "a limb from a link to itself": (
        GRAPH + LIMB.replace('name = "leg"', 'name = "leg"\nlinks = ["foot", "foot"]'),
        ["limb 'leg'", "'foot' to itself"],
    ),
    "a rod without length": (
        swap("to = [100, 50, 0]", "to = [100, 0, 0]"),
        ["rod 'bar'", "one point", "has a length"],
    ),
    "a rod of negative length": (
        swap("from =", "length = -3\nfrom ="),
        ["rod 'bar'", "length = -3.0", "positive"],
    ),
    "a length of an actuated rod": (
        swap("from =", "length = 3\nactuated = true\nfrom ="),
        ["rod 'bar'", "length", "`offset`"],
    ),
    "an offset of a rigid rod": (
        swap("from =", "offset = 3\nfrom ="),
        ["rod 'bar'", "offset", "actuated = true"],
    ),
    "a point that is none": (
        swap("[100, 50, 0] }", "[100, 50] }"),
        ["link[0] (foot).points.toe", "2 entries", "3 needed"],
    ),
    "a name of a link that is none": (GRAPH.replace('"arm"', '"ar\\tm"'), ["ar\\tm"]),
    "a DH table beside joints": (
        GRAPH + '[dh]\nconvention = "standard"\nrows = [ { type = "R" } ]\n',
        ["dh", "stands alone"],
    ),
    "a tool beside a graph": (GRAPH + "[tool]\nposition = [0, 0, 0]\n", ["tool"]),
    "a type that is none": (
        swap('type = "R"', 'type = "Pa"'),
        ["joint[0] (crank).type", "'Pa'", "weld", "two rods"],
    ),
}


def test_the_text_to_spoil_is_right():
    assert parse(GRAPH).is_graph


JOINT = """[[joint]]
name = "q"
type = "R"
links = LINKS
point = [0, 0, 0]
axis = [0, 0, 1]
"""
ROD_ON_PLATFORM = """[[rod]]
name = "bar"
links = ["platform", "arm"]
from = [1, 2, 3]
to = [4, 5, 6]
"""
HEAD_OF_A_GRAPH = 'format = 1\nname = "g"\nlength_unit = "mm"\nangle_unit = "deg"\n'


@pytest.mark.parametrize(
    "entries",
    [
        JOINT.replace("LINKS", '["base", "platform"]'),
        JOINT.replace("LINKS", '["platform", "base"]'),
        JOINT.replace("LINKS", '["base", "arm"]') + ROD_ON_PLATFORM,
        JOINT.replace("LINKS", '["base", "arm"]')
        + LIMB.replace('name = "leg"', 'name = "leg"\nlinks = ["platform", "arm"]'),
    ],
    ids=["joint to it", "joint from it", "rod", "limb from it"],
)
@pytest.mark.parametrize(
    "frame", ["position = [1, 2, 3]", "", 'position = [1, 2, 3]\nmotion = "planar"']
)
def test_a_link_named_platform_carries_the_frame(entries: str, frame: str) -> None:
    """As the reference says, whatever names the link: the file without `platform.link` is the one
    that has it.
    """
    text = HEAD_OF_A_GRAPH + entries + "[platform]\n"
    found = parse(text + frame)
    assert found == parse(text + f'link = "platform"\n{frame}')
    assert found.platform_link == "platform"
    assert parse(found.to_toml()) == found


@pytest.mark.parametrize("case", BAD)
def test_a_mistake_is_one_line_with_file_key_and_value(case, tmp_path):
    """MechanismError: the file's path first, then what it is about, the value, what is allowed; one
    line.
    """
    text, fragments = BAD[case]
    assert_refused_in_one_line(tmp_path / "robot.toml", text, fragments)


def test_an_actuated_universal_joint_has_two_coordinates():
    actuated = parse(
        swap('type = "R"', 'type = "U"\naxis2 = [1, 0, 0]').replace(
            "{ crank = 2.0 }", '{ "crank.1" = 2.0 }'
        )
    ).actuated
    assert [c.name for c in actuated] == ["crank.1", "crank.2"]
