"""The mechanism file: round trips, and one clear line for every mistake."""

import copy
import math
import re
import tomllib

import pytest
import tomlkit
from hypothesis import given, settings
from hypothesis import strategies as st

import symkin
from helpers.inside import mechanism_file, parse, text_fault
from helpers.mistakes import assert_refused_in_one_line
from helpers.samples import BENNETT, delta, pieper
from symkin import (
    DHRow,
    DHTable,
    Example,
    InputError,
    Joint,
    Limb,
    Mechanism,
    MechanismError,
    Rod,
    RodLimb,
    SymkinError,
    serial_arm_from_dh,
)

# --- round trips ----------------------------------------------------------------------------------

lengths = st.floats(-1e4, 1e4)
vectors = st.tuples(lengths, lengths, lengths)
directions = vectors.filter(lambda v: math.hypot(*v) > 1e-3)
quaternions = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: math.hypot(*q) > 0.1)
unit_quaternions = quaternions.map(lambda q: tuple(c / math.hypot(*q) for c in q))
TEXTS = st.text(st.characters(exclude_categories=["Cs"]), max_size=20).filter(
    lambda text: text_fault(text) is None
)
MOTIONS = ["spatial", "schoenflies", "planar", "translation", "spherical"]


def ranges(values):
    return st.none() | st.tuples(values, values).filter(lambda r: r[0] != r[1]).map(sorted)


def angles(unit):
    """Radians that a user can write in the file's unit."""
    return st.floats(-720, 720).map(math.radians) if unit == "deg" else st.floats(-12, 12)


@st.composite
def joints(draw, name, unit, kinds="RPHCUS", *, actuated=None):
    kind = draw(st.sampled_from(kinds))
    value = angles(unit) if kind in "RH" else lengths
    fields = {"point": draw(vectors)}
    if kind != "S":
        fields["axis"] = draw(directions)
    if kind == "U":
        axis = fields["axis"]
        fields["axis2"] = (axis[1] + 1e3, axis[2] - 2e3, -axis[0] + 3e4)
    if kind in "RPH":
        fields |= {"zero": draw(value), "limits": draw(ranges(value))}
        fields["actuated"] = draw(st.booleans()) if actuated is None else actuated
    if kind == "H":
        fields["pitch"] = draw(lengths)
    try:
        return Joint(name, kind, **fields)
    except MechanismError:
        spare = ("S", fields["point"]) if actuated is None else ("R", fields["point"], (0, 0, 1))
        return Joint(name, *spare, actuated=bool(actuated))


@st.composite
def limbs(draw, k, unit):
    name = draw(st.sampled_from(["limb", "leg ", "Ärm.", 'q"uote', "a\\b"])) + str(k)
    if draw(st.booleans()):
        kind, offset = draw(st.sampled_from(["SPS", "UPS", "SPU"])), draw(lengths)
        return RodLimb(name, draw(vectors), draw(vectors), offset, draw(ranges(lengths)), kind)
    chain = [draw(joints(f"j{k}{i}", unit)) for i in range(draw(st.integers(1, 4)))]
    lengths_of_rods = st.none() | st.floats(0.1, 100)
    rods = draw(st.lists(st.builds(Rod, vectors, vectors, lengths_of_rods), max_size=2))
    return Limb(name, chain, rods)


@st.composite
def mechanisms(draw):
    unit, form = (
        draw(st.sampled_from(["deg", "rad"])),
        draw(st.sampled_from(["limbs", "joints", "dh"])),
    )
    options = {
        "angle_unit": unit,
        "length_unit": draw(st.sampled_from(["m", "mm"])),
        "title": draw(TEXTS),
        "source": draw(TEXTS),
    }
    frame = {"platform_position": draw(vectors), "platform_quaternion": draw(unit_quaternions)}
    count = draw(st.integers(1, 4))
    if form == "limbs":
        made = [draw(limbs(k, unit)) for k in range(count)]
        mechanism = Mechanism(
            "sample", made, **frame, **options, motion=draw(st.sampled_from(MOTIONS))
        )
    elif form == "joints":
        chain = [draw(joints(f"q{k}", unit, "RPH", actuated=True)) for k in range(count)]
        mechanism = Mechanism("sample", [Limb("sample", chain)], **frame, **options, serial=True)
    else:
        rows = []
        for k in range(count):
            kind = draw(st.sampled_from("RP"))
            numbers = draw(st.tuples(angles(unit), lengths, lengths, angles(unit)))
            rows.append(
                DHRow(
                    f"d{k}", kind, *numbers, draw(ranges(angles(unit) if kind == "R" else lengths))
                )
            )
        mechanism = serial_arm_from_dh(
            "sample", DHTable(draw(st.sampled_from(["standard", "modified"])), rows), **options
        )
    if draw(st.booleans()):
        values = st.tuples(
            *(
                lengths.map(lambda v, c=c: v if c.least is None else max(v, c.least))
                for c in mechanism.actuated
            )
        )
        shown = draw(
            st.builds(Example, joints=values)
            | st.builds(Example, pose=st.tuples(vectors, unit_quaternions).map(sum_up))
        )
        mechanism = Mechanism(
            **{n: getattr(mechanism, n) for n in mechanism.__dataclass_fields__}
            | {"example": shown}
        )
    return mechanism


def sum_up(parts):
    return (*parts[0], *parts[1])


@pytest.mark.parametrize("name", symkin.shipped_names())
def test_shipped_files_come_back_equal(name):
    """parse(m.to_toml()) == m, and the second writing is the first, byte for byte."""
    mechanism = symkin.load(name)
    assert parse(mechanism.to_toml()) == mechanism
    assert parse(mechanism.to_toml()).to_toml() == mechanism.to_toml()


@pytest.mark.slow
@given(mechanisms())
def test_any_mechanism_comes_back_equal(mechanism):
    """parse(m.to_toml()) == m for every joint type, limb form, unit and motion, to the last bit."""
    assert parse(mechanism.to_toml()) == mechanism


@pytest.mark.parametrize(
    "make", [delta, pieper, lambda: parse(BENNETT)], ids=["delta", "pieper", "bennett"]
)
def test_sample_mechanisms_come_back_equal(make):
    """The same for mechanisms made in Python and for arithmetic in the file."""
    assert parse(make().to_toml()) == make()


def test_a_shipped_mechanism_is_read_once_and_a_file_whenever_it_is_asked_for(tmp_path):
    """What comes with symkin does not change while a process runs; a file of one's own may."""
    assert symkin.load("four_bar") is symkin.load("four_bar")
    path, text = tmp_path / "own.toml", symkin.load("four_bar").to_toml()
    path.write_text(text, encoding="utf-8")
    before = symkin.load(path)
    path.write_text(text.replace('"four_bar"', '"other"'), encoding="utf-8")
    assert (before.name, symkin.load(path).name) == ("four_bar", "other")


def test_files_are_read_from_disk(tmp_path):
    """load of a path (text or Path) is parse of its text; a byte order mark and CRLF do not
    matter.
    """
    mechanism = symkin.load("zhang2009")
    path = tmp_path / "my robot.toml"
    path.write_text(mechanism.to_toml(), encoding="utf-8")
    assert symkin.load(path) == symkin.load(str(path)) == mechanism
    path.write_bytes(b"\xef\xbb\xbf" + mechanism.to_toml().replace("\n", "\r\n").encode())
    assert symkin.load(path) == mechanism


def test_arithmetic_is_a_number():
    """A string of arithmetic stands wherever a number does, trigonometry in the file's angle
    unit.
    """
    text = PARALLEL.replace(
        "base = [0.0, 0.0, 0.0]", 'base = ["240/sqrt(3)", "100*sin(30)", "2^3"]'
    ).replace("= 5.0", '= "10/2"')
    limb = parse(text).limbs[0]
    assert limb.base == pytest.approx((240 / math.sqrt(3), 50.0, 8.0))
    assert limb.offset == 5.0
    joint = parse(ARM.replace("zero = 90.0", 'zero = "180/2"')).limbs[0].joints[0]
    assert joint.zero == math.pi / 2


def test_quaternion_off_by_less_than_a_hundredth_is_normalised():
    """(1.005, 0, 0, 0) is the identity."""
    assert parse(MIXED.replace("[1.0, 0.0, 0.0, 0.0]", "[1.005, 0, 0, 0]")).platform_quaternion == (
        1.0,
        0.0,
        0.0,
        0.0,
    )


# --- mistakes -------------------------------------------------------------------------------------

HEAD = """format = 1
name = "robot"
length_unit = "mm"
angle_unit = "deg"
"""
PARALLEL = (
    HEAD
    + """
[[limb]]
name = "leg1"
type = "SPS"
base = [0.0, 0.0, 0.0]
platform = [0.0, 0.0, 100.0]
offset = 5.0
limits = [10.0, 400.0]

[example]
joints = [95.0]
"""
)
MIXED = (
    HEAD
    + """
[platform]
position = [0.0, 0.0, 100.0]
quaternion = [1.0, 0.0, 0.0, 0.0]
motion = "spatial"

[[limb]]
name = "arm"
[[limb.joint]]
name = "waist"
type = "R"
point = [0.0, 0.0, 0.0]
axis = [0.0, 0.0, 1.0]
actuated = true
zero = 90.0
limits = [-180.0, 180.0]
[[limb.joint]]
name = "ball"
type = "S"
point = [50.0, 0.0, 0.0]

[[limb]]
name = "arm2"
[[limb.joint]]
name = "slide"
type = "P"
axis = [0.0, 0.0, 1.0]
[[limb.rod]]
from = [0.0, 1.0, 0.0]
platform = [0.0, 0.0, 0.0]
length = 20.0
"""
)
ARM = (
    HEAD
    + """
[[joint]]
name = "q1"
type = "R"
point = [0.0, 0.0, 0.0]
axis = [0.0, 0.0, 1.0]
zero = 90.0

[tool]
position = [0.0, 0.0, 100.0]
"""
)
DH = HEAD + (
    '\n[dh]\nconvention = "standard"\n'
    'rows = [ { type = "R", theta = 0.0, d = 10.0, a = 5.0, alpha = 90.0 } ]\n'
)
OFF = "[1.02, 0.0, 0.0, 0.0]"


def test_the_texts_to_spoil_are_right():
    """Each base text is accepted as it stands."""
    for text in (PARALLEL, MIXED, ARM, DH):
        assert parse(text).name == "robot"


def swap(text, old, new):
    assert old in text
    return text.replace(old, new, 1)


# case: (text, what the message must hold beside the file's name)
BAD = {
    "not TOML": ("format = = 1", ["TOML"]),
    "not closed": ("[limb", ["TOML"]),
    "key twice": ("a = 1\na = 2", ["TOML"]),
    "empty": ("", ["empty"]),
    "only comments": ("# nothing\n", ["empty"]),
    "no limb": (HEAD, ["no limb", "[[limb]]"]),
    "format 2": (swap(PARALLEL, "format = 1", "format = 2"), ["format", "2", "1"]),
    "format as text": (swap(PARALLEL, "format = 1", 'format = "1"'), ["format", "'1'", "1"]),
    "format true": (swap(PARALLEL, "format = 1", "format = true"), ["format", "True"]),
    "format 1.0": (swap(PARALLEL, "format = 1", "format = 1.0"), ["format", "1.0"]),
    "missing format": (swap(PARALLEL, "format = 1\n", ""), ["format", "missing"]),
    "missing name": (swap(PARALLEL, 'name = "robot"\n', ""), ["name", "missing"]),
    "missing length unit": (swap(PARALLEL, 'length_unit = "mm"\n', ""), ["length_unit", "missing"]),
    "unknown length unit": (
        swap(PARALLEL, '"mm"', '"inch"'),
        ["length_unit", "'inch'", "'m'", "'mm'"],
    ),
    "unknown angle unit": (
        swap(PARALLEL, '"deg"', '"gon"'),
        ["angle_unit", "'gon'", "'deg'", "'rad'"],
    ),
    "name no C identifier": (
        swap(PARALLEL, '"robot"', '"3-rps"'),
        ["name", "'3-rps'", "C identifier"],
    ),
    "name a number": (swap(PARALLEL, '"robot"', "3"), ["name", "3"]),
    "name empty": (swap(PARALLEL, '"robot"', '""'), ["name", "''"]),
    "title a number": (
        swap(PARALLEL, "format = 1", "format = 1\ntitle = 3"),
        ["title = 3", "a text"],
    ),
    "platform a number": (
        PARALLEL.replace("format = 1", "format = 1\nplatform = 3"),
        ["platform = 3", "a table"],
    ),
    "base a number": (
        swap(PARALLEL, "base = [0.0, 0.0, 0.0]", "base = 3"),
        ["limb[0] (leg1).base = 3", "a list of 3 numbers"],
    ),
    "limb a number": (HEAD + "limb = 3\n", ["limb", "3"]),
    "limb a list of numbers": (HEAD + "limb = [3]\n", ["limb[0]", "3"]),
    "limb a table": (swap(PARALLEL, "[[limb]]", "[limb]"), ["limb", "[[limb]]"]),
    "joint a table": (swap(ARM, "[[joint]]", "[joint]"), ["joint"]),
    "unknown key at the top": (
        swap(PARALLEL, "format = 1", "format = 1\ncolour = 3"),
        ["colour", "unknown", "angle_unit"],
    ),
    "unknown key of a rod limb": (
        swap(PARALLEL, "offset", "ofset"),
        ["limb[0]", "leg1", "ofset", "unknown", "offset"],
    ),
    "unknown key of the platform": (
        swap(MIXED, "motion", "motions"),
        ["platform.motions", "unknown", "motion"],
    ),
    "unknown key of a joint": (
        swap(MIXED, "actuated", "active"),
        ["arm", "waist", "active", "unknown", "actuated"],
    ),
    "unknown key of a limb": (
        swap(MIXED, 'name = "arm"', 'name = "arm"\nbase = 3'),
        ["arm", "base", "unknown", "joint"],
    ),
    "unknown key of a rod": (
        swap(MIXED, "length = 20.0", "width = 2.0"),
        ["arm2", "rod[0]", "width", "unknown", "length"],
    ),
    "unknown key of a dh row": (
        swap(DH, "d = 10.0", "D = 10.0"),
        ["dh.rows[0]", "D", "unknown", "alpha"],
    ),
    "unknown key of dh": (
        swap(DH, "convention", "rule = 1\nconvention"),
        ["dh.rule", "unknown", "convention"],
    ),
    "unknown key of the example": (
        swap(PARALLEL, "joints = ", "joint = "),
        ["example.joint", "unknown", "joints"],
    ),
    "unknown key of the tool": (
        ARM + 'motion = "planar"',
        ["tool.motion", "unknown", "quaternion"],
    ),
    "couplings": (
        MIXED + '\n[[coupling]]\njoint = "waist"\nof = { slides = 2.0 }',
        [
            "coupling of 'waist'",
            "of = 'slides' is unknown",
            "do you mean 'slide'?",
            "coordinates are waist, slide",
        ],
    ),
    "a mimicking joint": (
        swap(MIXED, 'type = "R"', 'type = "R"\nmimic = "a"'),
        ["joint[0] (waist).mimic", "[[coupling]]"],
    ),
    "links of a joint": (
        swap(MIXED, 'type = "R"', 'type = "R"\nlinks = ["base", "a"]'),
        ["joint[0] (waist).links", "unknown", "stands at the top of the file"],
    ),
    "named links": (MIXED + '\n[[link]]\nname = "foot"', ["link[0] (foot)", "nothing holds it"]),
    "a loop within a limb": (
        MIXED + '\n[[limb.limb]]\nname = "inner"',
        ["limb[1] (arm2).limb", "unknown", "allowed"],
    ),
    "a table of loops": (
        MIXED + '\n[[loop]]\nname = "inner"',
        ["loop", "loops have no table", "links"],
    ),
    "rods between links": (MIXED + '\n[[rod]]\nname = "a"', ["rod[0] (a).links", "missing"]),
    "two platforms": (
        swap(MIXED, "[platform]", "[[platform]]"),
        ["platform", "one link of a file", "points"],
    ),
    "platform twice": (
        MIXED + "\n[platform]\nposition = [0, 0, 0]",
        ["[platform] stands twice", "one link of a file"],
    ),
    "a welded joint": (
        swap(MIXED, '"R"', '"weld"'),
        ["waist", "type", "'weld'", "in a limb it is left out"],
    ),
    "an actuated universal joint with limits": (
        swap(MIXED, 'type = "R"', 'type = "U"\naxis2 = [1, 0, 0]'),
        ["waist", "zero, limits and motor", "one coordinate (R, P, H)"],
    ),
    "unknown joint type": (
        swap(MIXED, '"R"', '"Q"'),
        ["arm", "waist", "type", "'Q'", "'R', 'P', 'H', 'C', 'U', 'S'"],
    ),
    "unknown rod type": (
        swap(PARALLEL, '"SPS"', '"RPR"'),
        ["leg1", "type", "'RPR'", "'SPS', 'UPS', 'SPU'"],
    ),
    "unknown motion": (
        swap(MIXED, '"spatial"', '"free"'),
        ["platform.motion", "'free'", "'schoenflies'"],
    ),
    "unknown convention": (
        swap(DH, '"standard"', '"craig"'),
        ["dh.convention", "'craig'", "'modified'"],
    ),
    "zero axis": (
        swap(MIXED, "[0.0, 0.0, 1.0]", "[0, 0, 0]"),
        ["waist", "axis", "zero", "[0.0, 0.0, 0.0]"],
    ),
    "no axis": (swap(MIXED, "axis = [0.0, 0.0, 1.0]\n", ""), ["waist", "axis", "missing"]),
    "no point": (swap(MIXED, "point = [0.0, 0.0, 0.0]\n", ""), ["waist", "point", "missing"]),
    "axis of two": (
        swap(MIXED, "[0.0, 0.0, 1.0]", "[0.0, 1.0]"),
        ["waist", "axis", "[0.0, 1.0]", "3"],
    ),
    "base of four": (
        swap(PARALLEL, "base = [0.0, ", "base = [0.0, 0.0, "),
        ["leg1", "base", "4", "3"],
    ),
    "base is text": (
        swap(PARALLEL, "base = [0.0,", 'base = ["wide",'),
        ["leg1", "base[0]", "'wide'", "sqrt"],
    ),
    "base divided by zero": (
        swap(PARALLEL, "base = [0.0,", 'base = ["1/0",'),
        ["leg1", "base[0]", "'1/0'"],
    ),
    "base is true": (
        swap(PARALLEL, "base = [0.0,", "base = [true,"),
        ["leg1", "base[0]", "True", "number"],
    ),
    "base is a date": (
        swap(PARALLEL, "base = [0.0,", "base = [2020-01-01,"),
        ["leg1", "base[0]", "number"],
    ),
    "NaN": (swap(PARALLEL, "base = [0.0,", "base = [nan,"), ["leg1", "base[0]", "nan", "finite"]),
    "infinity": (
        swap(MIXED, "position = [0.0,", "position = [-inf,"),
        ["platform.position[0]", "inf", "finite"],
    ),
    "huge integer": (
        swap(PARALLEL, "offset = 5.0", f"offset = {10**400}"),
        ["leg1", "offset", "finite"],
    ),
    "quaternion norm": (
        swap(MIXED, "[1.0, 0.0, 0.0, 0.0]", OFF),
        ["platform.quaternion", "1.02", "0.01"],
    ),
    "zero quaternion": (
        swap(MIXED, "[1.0, 0.0, 0.0, 0.0]", "[0, 0, 0, 0]"),
        ["platform.quaternion", "norm"],
    ),
    "tool quaternion norm": (ARM + f"quaternion = {OFF}", ["tool.quaternion", "1.02", "0.01"]),
    "quaternion of three": (
        swap(MIXED, "[1.0, 0.0, 0.0, 0.0]", "[1, 0, 0]"),
        ["platform.quaternion", "[1, 0, 0]", "4"],
    ),
    "negative rod length": (
        swap(MIXED, "20.0", "-20.0"),
        ["arm2", "rod", "length", "-20.0", "positive"],
    ),
    "limits reversed": (
        swap(MIXED, "[-180.0, 180.0]", "[180.0, -180.0]"),
        ["waist", "limits", "180", "low < high"],
    ),
    "rod limits reversed": (
        swap(PARALLEL, "[10.0, 400.0]", "[400.0, 10.0]"),
        ["leg1", "limits", "400", "low < high"],
    ),
    "limits of one": (
        swap(PARALLEL, "[10.0, 400.0]", "[400.0]"),
        ["leg1", "limits", "[400.0]", "2"],
    ),
    "two limbs of one name": (swap(MIXED, '"arm2"', '"arm"'), ["'arm'", "unique"]),
    "two joints of one name": (swap(MIXED, '"slide"', '"waist"'), ["'waist'", "unique"]),
    "limb name empty": (swap(PARALLEL, '"leg1"', '""'), ["limb[0]", "name", "''"]),
    "limb without joints": (HEAD + '[[limb]]\nname = "arm"\njoint = []\n', ["arm", "joint", "[]"]),
    "limb of rods only": (HEAD + '[[limb]]\nname = "arm"\nrod = []\n', ["arm", "joint", "missing"]),
    "limb of a name only": (HEAD + '[[limb]]\nname = "arm"\n', ["arm", "missing"]),
    "actuated ball": (
        swap(MIXED, 'type = "S"', 'type = "S"\nactuated = true'),
        ["'ball'", "actuated", "R, P, H, C and U", "three R joints"],
    ),
    "actuated is text": (
        swap(MIXED, "actuated = true", 'actuated = "yes"'),
        ["waist", "actuated", "'yes'", "true or false"],
    ),
    "passive joint of an arm": (swap(ARM, "zero = 90.0", "actuated = false"), ["'q1'", "actuated"]),
    "ball in an arm": (
        swap(ARM, 'type = "R"', 'type = "S"').replace("axis = [0.0, 0.0, 1.0]\nzero = 90.0\n", ""),
        ["'q1'", "R, P"],
    ),
    "dh and limb": (
        DH + PARALLEL[len(HEAD) :].split("[example]")[0],
        ["limb", "dh", "exactly one"],
    ),
    "joint and limb": (
        ARM.split("[tool]")[0] + PARALLEL[len(HEAD) :].split("[example]")[0],
        ["limb", "joint", "exactly one"],
    ),
    "tool with dh": (DH + "[tool]\nposition = [0, 0, 1]\n", ["tool", "[dh]", "[[joint]]"]),
    "tool with limbs": (MIXED + "[tool]\nposition = [0, 0, 1]\n", ["tool", "[[joint]]"]),
    "platform with an arm": (ARM + "[platform]\nposition = [0, 0, 1]\n", ["platform", "serial"]),
    "no platform": (
        MIXED.split("[platform]")[0] + "[[limb]]" + MIXED.split("[[limb]]", 1)[1],
        ["platform", "missing"],
    ),
    "no platform position": (
        swap(MIXED, "position = [0.0, 0.0, 100.0]\n", ""),
        ["platform.position", "missing"],
    ),
    "empty dh": (HEAD + '[dh]\nconvention = "standard"\nrows = []\n', ["dh.rows", "[]"]),
    "dh row of a ball": (swap(DH, '"R"', '"S"'), ["dh.rows[0]", "type", "'S'", "'R', 'P'"]),
    "dh limits reversed": (
        swap(DH, "alpha = 90.0", "limits = [2, 1]"),
        ["dh.rows[0].limits", "low < high"],
    ),
    "example count": (
        swap(PARALLEL, "joints = [95.0]", "joints = [95.0, 1.0]"),
        ["example.joints", "2", "1"],
    ),
    "example start count": (
        swap(PARALLEL, "[95.0]", "[95.0]\nstart = [1.0, 2.0]"),
        ["example.start", "2", "7"],
    ),
    "example pose count": (
        swap(PARALLEL, "joints = [95.0]", "pose = [1.0]"),
        ["example.pose", "[1.0]", "7"],
    ),
    "example pose norm": (
        swap(PARALLEL, "joints = [95.0]", "pose = [0, 0, 0, 2, 0, 0, 0]"),
        ["example.pose", "norm 2"],
    ),
    "example of both": (
        swap(PARALLEL, "[95.0]", "[95.0]\npose = [0, 0, 0, 1, 0, 0, 0]"),
        ["example", "joints", "pose"],
    ),
    "example empty": (swap(PARALLEL, "joints = [95.0]\n", ""), ["example", "joints", "pose"]),
    "example NaN": (
        swap(PARALLEL, "joints = [95.0]", "joints = [nan]"),
        ["example.joints[0]", "nan", "finite"],
    ),
    "example rod too short": (
        swap(PARALLEL, "joints = [95.0]", "joints = [-6.0]"),
        ["example.joints", "leg1", "-6"],
    ),
    "example a list": (
        swap(PARALLEL, "[example]\njoints = [95.0]", "[[example]]\njoints = [95.0]"),
        ["example"],
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_a_mistake_is_one_line_with_file_key_and_value(case, tmp_path):
    """MechanismError: the file's path first, then the key path, the value, what is allowed; one
    line.
    """
    text, fragments = BAD[case]
    assert_refused_in_one_line(tmp_path / "robot.toml", text, fragments)


@pytest.mark.parametrize("name", ["zhang", "ZHANG2009", "zhang2009/", "\x00", "a" * 50])
def test_an_unknown_mechanism_is_named_with_the_choice(name):
    """InputError: the name as given, a path to a .toml, and every shipped name."""
    with pytest.raises(InputError) as error:
        symkin.load(name)
    assert all(
        shipped in str(error.value) for shipped in (repr(name), ".toml", *symkin.shipped_names())
    )


def test_files_that_cannot_be_read(tmp_path):
    """No such file, a directory, bytes that are no text: one line that names the path."""
    folder, binary = tmp_path / "folder.toml", tmp_path / "binary.toml"
    folder.mkdir()
    binary.write_bytes(bytes(range(256)))
    cases = [
        folder,
        binary,
        tmp_path / "missing.toml",
        binary / "inside.toml",
        tmp_path / ("a" * 300 + ".toml"),
    ]
    for path in [*cases, "nul\x00.toml"]:
        with pytest.raises(SymkinError) as error:
            symkin.load(path)
        assert "\n" not in str(error.value)
        assert re.sub(r"\x00", r"\\x00", str(path)) in str(error.value).replace("\x00", "\\x00")


# --- anything at all ------------------------------------------------------------------------------

RAW = {
    name: (mechanism_file.SHIPPED / f"{name}.toml").read_text(encoding="utf-8")
    for name in symkin.shipped_names()
}
SOURCES = [*RAW.values(), BENNETT, PARALLEL, MIXED, ARM, DH, delta().to_toml()]
junk = st.sampled_from(
    [
        "",
        "x",
        "R",
        "S",
        "H",
        "pi",
        "1/0",
        "2^9^9",
        "name",
        "spatial",
        "planar",
        True,
        False,
        0,
        1,
        -1,
        3,
        10**400,
        0.0,
        -1.5,
        1e-320,
        1e100,
        math.nan,
        math.inf,
        [],
        [0],
        [1.0, 2.0],
        [0.0, 0.0, 0.0],
        [1, 0, 0, 0],
        [[1, 2, 3]],
        ["a", "b", "c"],
        {},
        {"name": "x"},
        {"x": 1},
        [{}],
        [{"name": "x", "type": "R"}],
    ]
)
keys = st.sampled_from(
    [
        "name",
        "type",
        "joint",
        "limb",
        "rod",
        "dh",
        "tool",
        "platform",
        "example",
        "point",
        "axis",
        "axis2",
        "pitch",
        "limits",
        "zero",
        "actuated",
        "x",
        "",
        "from",
        "length",
        "rows",
        "motion",
        "start",
        "pose",
    ]
)


def read(text):
    """The mechanism and no message, or no mechanism and SymkinError's message; any other exception
    leaves.
    """
    try:
        return parse(text, "spoilt.toml"), None
    except SymkinError as error:
        return None, str(error)


def places(node, path=()):
    """Every key path of parsed data."""
    children = (
        node.items()
        if isinstance(node, dict)
        else enumerate(node)
        if isinstance(node, list)
        else ()
    )
    for key, value in children:
        yield (*path, key)
        yield from places(value, (*path, key))


def mutate(data, draw):
    """Replace, remove, rename or copy one entry anywhere."""
    found = list(places(data))
    if not found:
        return
    *way, last = found[draw(st.integers(0, len(found) - 1))]
    node = data
    for key in way:
        node = node[key]
    match draw(st.sampled_from(["replace", "replace", "remove", "rename", "copy"])):
        case "replace":
            node[last] = copy.deepcopy(draw(junk))
        case "remove":
            del node[last]
        case "rename" if isinstance(node, dict):
            node[draw(keys)] = node.pop(last)
        case "copy" if isinstance(node, list):
            node.append(copy.deepcopy(node[last]))
        case _ if isinstance(node, dict):
            node[draw(keys)] = copy.deepcopy(draw(junk))


@pytest.mark.slow
@given(st.data())
def test_spoilt_data_is_refused_in_one_line_or_taken(data):
    """Whatever is replaced, removed or renamed in a right file: SymkinError in one line, or a
    mechanism that comes back.
    """
    refused_or_taken(data)


@pytest.mark.long
@settings(max_examples=100)
@given(st.data())
def test_more_spoilt_data_is_refused_in_one_line_or_taken(data):
    """The same of more files."""
    refused_or_taken(data)


def refused_or_taken(data):
    spoilt = tomllib.loads(data.draw(st.sampled_from(SOURCES)))
    for _ in range(data.draw(st.integers(1, 3))):
        mutate(spoilt, data.draw)
    mechanism, message = read(tomlkit.dumps(spoilt))
    if mechanism is None:
        assert message.startswith("spoilt.toml: ")
        assert "\n" not in message
    else:
        assert str(mechanism)
        assert mechanism.characteristic_length > 0
        assert parse(mechanism.to_toml()) == mechanism


@settings(max_examples=75)
@given(
    st.sampled_from(SOURCES),
    st.floats(0, 1),
    st.integers(0, 12),
    st.text(max_size=4) | st.sampled_from('[]{}"=.,\n#'),
)
def test_spoilt_text_is_refused_in_one_line_or_taken(text, where, cut, put):
    """The same for text cut and pasted anywhere."""
    at = int(where * len(text))
    mechanism, message = read(text[:at] + put + text[at + cut :])
    assert mechanism is not None or (message.startswith("spoilt.toml: ") and "\n" not in message)


ODD = {
    "deep list": "x = " + "[" * 5000,
    "deep tables": "[" * 5000,
    "deep inline table": "x = " + "{a=" * 5000,
    "deep key": "a." * 5000 + "b = 1",
    "long integer": "x = " + "9" * 5000,
    "long float": "x = 0." + "9" * 5000,
    "long string": "x = '" + "9" * 100_000 + "'",
    "control character": "x = '\x00'",
}


@pytest.mark.parametrize("case", ODD)
def test_odd_texts_are_refused_in_one_line(case):
    """Texts that exhaust a parser's recursion or digits are mistakes like others."""
    with pytest.raises(MechanismError) as error:
        parse(ODD[case], "odd.toml")
    assert str(error.value).startswith("odd.toml: ")
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 500
