"""Generated transmissions of ros2_control, compiled against its own headers and run through its
handles. The loader needs ROS, and is not compiled.
"""

import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from click.testing import CliRunner

import symkin
from helpers import firmware_tools as tools
from helpers.inside import JointMap, Options, Real, app, with_twins, write_folder
from symkin import InputError

HEADERS = Path(__file__).parents[1] / "data" / "ros2_control"
INCLUDES = [
    flag
    for part in ("transmission_interface", "hardware_interface", "rcpputils")
    for flag in ("-isystem", str(HEADERS / part / "include"))
]
JOINT = """[[joint]]
name = "{}"
type = "R"
links = ["{}", "{}"]
point = [{}, 0.0, 0.0]
axis = [0.0, 0.0, 1.0]
"""
LINEAR = (
    'format = 1\nname = "linear"\nlength_unit = "m"\nangle_unit = "rad"\n'
    + JOINT.format("joint1", "base", "upper", 0.0)
    + JOINT.format("joint2", "upper", "lower", 1.0)
    + JOINT.format("motor1", "base", "pulley1", 2.0)
    + JOINT.format("motor2", "base", "pulley2", 3.0)
    + '[[coupling]]\njoint = "joint1"\nof = { motor1 = 1.0 }\n'
    + '[[coupling]]\njoint = "joint2"\nof = { motor1 = -1.0, motor2 = 1.0 }\n'
)
"""Two motors in the base, two joints in a row, the second one driven by a belt past the first."""
SLIDER = ("slider_crank", ("crank",), ("piston",))
ANKLE = ("ankle", ("upper_motor", "lower_motor"), ("ankle.1", "ankle.2"))

COMMON = """
#include "NAME_transmission.hpp"
#include "transmission_interface/four_bar_linkage_transmission.hpp"
#include <cstdio>
#include <cstdlib>
#include <new>

static long allocated = 0;
void * operator new(std::size_t size)
{
  ++allocated;
  void * const found = std::malloc(size);
  if (found == nullptr) { throw std::bad_alloc(); }
  return found;
}
void operator delete(void * place) noexcept { std::free(place); }
void operator delete(void * place, std::size_t) noexcept { std::free(place); }

using namespace transmission_interface;
constexpr std::size_t N = NAME_transmission::count;
static const char * const kinds[3] = {"position", "velocity", "effort"};
static int failures = 0;
static void expect(bool right, const char * what)
{
  if (!right) { ++failures; std::printf("failed: %s\\n", what); }
}
static bool near(double a, double b, double bound)
{
  return std::abs(a - b) <= bound * (1.0 + std::abs(a));
}
static double number() { return 2.0 * std::rand() / RAND_MAX - 1.0; }

/* Values of one side, and handles to some of its kinds, the last name first. */
template <typename Handle> struct Values
{
  double value[3][N] = {};
  std::vector<Handle> handles(const NAME_transmission::names & names, const char * wanted = "pve")
  {
    std::vector<Handle> found;
    for (int kind = 0; kind < 3; ++kind)
      for (std::size_t i = N; i-- > 0;)
        if (std::string(wanted).find("pve"[kind]) != std::string::npos)
          found.emplace_back(names[i], kinds[kind], &value[kind][i]);
    return found;
  }
};
template <typename Configure> static std::string refused(Configure configure)
{
  try { configure(); } catch (const Exception & error) { return error.what(); }
  return "";
}
"""
LAWS = """
int main()
{
  const NAME_transmission::names motors{MOTORS}, joints{JOINTS};
  const NAME_transmission::values home{HOME};
  NAME_transmission::Transmission forth, back, still;
  Values<ActuatorHandle> act, again, held;
  Values<JointHandle> joint, at;
  forth.configure(joint.handles(joints), act.handles(motors));
  back.configure(joint.handles(joints), again.handles(motors));
  /* a controller of efforts: positions of the joints, efforts out */
  still.configure(at.handles(joints, "pe"), held.handles(motors, "e"));
  for (int k = 0; k < 2000; ++k)
  {
    for (std::size_t i = 0; i < N; ++i)
    {
      /* walks of small steps, and leaps */
      const double last = act.value[0][i];
      act.value[0][i] = (k % 3 == 0) ? home[i] + REACH * number() : last + 1e-3 * number();
      act.value[1][i] = number();
      act.value[2][i] = 10.0 * number();
    }
    const long before = allocated;
    forth.actuator_to_joint();
    back.joint_to_actuator();
    double power = 0.0, size = 0.0;
    for (std::size_t i = 0; i < N; ++i)
    {
      at.value[0][i] = joint.value[0][i];
      at.value[2][i] = joint.value[2][i];
      power += act.value[1][i] * act.value[2][i] - joint.value[1][i] * joint.value[2][i];
      size += std::abs(act.value[1][i] * act.value[2][i]);
      size += std::abs(joint.value[1][i] * joint.value[2][i]);
    }
    still.joint_to_actuator();
    expect(allocated == before, "nothing is allocated after configure");
    expect(forth.status() == UPPER_OK, "status of actuator_to_joint");
    expect(back.status() == UPPER_OK && still.status() == UPPER_OK, "status of joint_to_actuator");
    expect(std::abs(power) <= 1e-12 * size, "power is the same on both sides");
    for (std::size_t i = 0; i < N; ++i)
    {
      for (int kind = 0; kind < 3; ++kind)
        expect(near(again.value[kind][i], act.value[kind][i], 1e-9), kinds[kind]);
      expect(near(held.value[2][i], act.value[2][i], 1e-9), "effort at the joints' positions");
    }
    /* the velocity is the position's rate */
    Values<ActuatorHandle> moved = act;
    Values<JointHandle> ends[2];
    for (int end = 0; end < 2; ++end)
    {
      for (std::size_t i = 0; i < N; ++i)
        moved.value[0][i] = act.value[0][i] + (2 * end - 1) * 1e-5 * act.value[1][i];
      NAME_transmission::Transmission there;
      there.configure(ends[end].handles(joints), moved.handles(motors));
      there.actuator_to_joint();
    }
    for (std::size_t i = 0; i < N && k % 20 == 0; ++i)
    {
      const double moved_by = ends[1].value[0][i] - ends[0].value[0][i];
      expect(near(moved_by / 2e-5, joint.value[1][i], 1e-6), "velocity");
    }
  }
  act.value[0][0] = std::nan("");
  forth.actuator_to_joint();
  expect(forth.status() == UPPER_NONFINITE, "NaN is told");
  for (int kind = 0; kind < 3; ++kind) expect(std::isnan(joint.value[kind][0]), "NaN stays NaN");
  act.value[0][0] = home[0];
  forth.actuator_to_joint();
  expect(forth.status() == UPPER_OK && std::isfinite(joint.value[0][0]), "and is left again");
  expect(refused([&] { forth.configure({}, {}); }).find("No interface") == 0, "no handles");
  expect(refused([&] { forth.configure(joint.handles(joints, "e"), act.handles(motors, "e")); })
    .find("depend on the position") != std::string::npos, "efforts alone");
  auto few = joint.handles(joints);
  few.pop_back();
  const auto without = refused([&] { forth.configure(few, act.handles(motors)); });
  expect(N == 1 || without.find("of some joints only") != std::string::npos, "too few handles");
  const auto zero = NAME_transmission::all(0.0);
  const auto none = refused([&] { NAME_transmission::Transmission wrong(motors, joints, zero); });
  expect(!none.empty(), "a reduction of zero");
  std::printf("%d failures\\n", failures);
  return failures == 0 ? 0 : 1;
}
"""
BESIDE = """
int main()
{
  const NAME_transmission::names motors{MOTORS}, joints{JOINTS};
  Values<ActuatorHandle> act, its_act;
  Values<JointHandle> joint, its_joint;
  NAME_transmission::Transmission ours(motors, joints, {5.0, -3.0}, {1.0, 2.0}, {0.25, -0.5});
  FourBarLinkageTransmission its({5.0, -3.0}, {1.0, 2.0}, {0.25, -0.5});
  ours.configure(joint.handles(joints), act.handles(motors));
  its.configure(its_joint.handles(joints), its_act.handles(motors));
  for (int k = 0; k < 200; ++k)
  {
    for (int kind = 0; kind < 3; ++kind)
      for (std::size_t i = 0; i < N; ++i) act.value[kind][i] = its_act.value[kind][i] = number();
    ours.actuator_to_joint();
    its.actuator_to_joint();
    for (int kind = 0; kind < 3; ++kind)
      for (std::size_t i = 0; i < N; ++i)
        expect(near(joint.value[kind][i], its_joint.value[kind][i], 1e-9), kinds[kind]);
    ours.joint_to_actuator();
    its.joint_to_actuator();
    for (int kind = 0; kind < 3; ++kind)
      for (std::size_t i = 0; i < N; ++i)
        expect(near(act.value[kind][i], its_act.value[kind][i], 1e-9), kinds[kind]);
  }
  NAME_transmission::Transmission plain;
  plain.configure(joint.handles(joints), act.handles(motors));
  act.value[2][0] = 2.0;
  act.value[2][1] = 3.0;
  plain.actuator_to_joint();
  expect(near(joint.value[2][0], 5.0, 1e-12), "tau_j1 = tau_a1 + tau_a2");
  expect(near(joint.value[2][1], 3.0, 1e-12), "tau_j2 = tau_a2");
  std::printf("%d failures\\n", failures);
  return failures == 0 ? 0 : 1;
}
"""


FMT = pytest.mark.skipif(
    not Path("/usr/include/fmt/format.h").exists(), reason="libfmt's headers are not installed"
)


def _run(folder, mechanism, given, find, text, reach="0.3"):
    """Write the package, compile a program of C++ with it, all warnings errors, and run it."""
    options = Options("double", given=given, find=find, also=("ros2",))
    write_folder(mechanism, folder, options)
    made = JointMap(mechanism, options, Real("double"))
    names = {
        "NAME": mechanism.name,
        "UPPER": mechanism.name.upper(),
        "MOTORS": ", ".join(f'"{name}"' for name in given),
        "JOINTS": ", ".join(f'"{name}"' for name in find),
        "REACH": reach,
        "HOME": ", ".join(str(v) for v in made.reference_of(made.given)),
    }
    for word, value in names.items():
        text = text.replace(word, value)
    (folder / "user.cpp").write_text(text)
    tools.built("gcc", folder, ["-c", f"{mechanism.name}.c"], "map.o")
    strict = [f"-W{name}" for name in ("all", "extra", "pedantic", "conversion", "shadow", "error")]
    flags = ["-std=c++17", "-O1", *strict]
    command = [tools.compiler("g++"), *flags, *INCLUDES, "-DFMT_HEADER_ONLY", "-I.", "-Iros2"]
    done = subprocess.run(
        [*command, "user.cpp", "map.o", "-lm", "-o", "user"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    tools.passed(folder / "user")


@FMT
@pytest.mark.parametrize(("machine", "reach"), [(ANKLE, "0.3"), (SLIDER, "0.5")])
def test_a_transmission_keeps_power_and_leads_back(machine, reach, tmp_path):
    """Through the handles of ros2_control, walks and leaps: positions, velocities and efforts go to
    the joints and come back, power is the same on both sides, velocities are the positions' rates,
    nothing is allocated; what is not finite is NaN with its status and left again.
    """
    name, given, find = machine
    _run(tmp_path, symkin.load(name), given, find, COMMON + LAWS, reach)


@FMT
def test_a_motor_may_be_a_joint_too(tmp_path):
    """A joint that is a motor itself, beside one that follows: the command gives it a twin in C,
    and the laws hold.
    """
    both, motors = "ankle.1", ("upper_motor", "ankle.1")
    machine, twins = with_twins(symkin.load("ankle"), [both])
    assert list(twins) == [both]
    find = (twins[both], "ankle.2")
    _run(tmp_path, machine, motors, find, COMMON + LAWS, "0.08")
    told = ["--motors", ",".join(motors), "--joints", f"{both},ankle.2", "--format", "ros2"]
    ran = CliRunner().invoke(app, ["transmission", "ankle", *told, "-o", str(tmp_path / "told")])
    assert ran.exit_code == 0, ran.output
    assert f"as a joint its name is {find[0]}" in ran.stderr
    texts = [(folder / "ankle.c").read_text() for folder in (tmp_path, tmp_path / "told")]
    assert texts[0].partition("#include")[2] == texts[1].partition("#include")[2]


@FMT
def test_a_linear_transmission_is_that_of_ros2_control(tmp_path):
    """Two motors on two joints in a row, with reductions and offsets: all six maps are those of
    ros2_control's four-bar linkage, and tau_j1 = tau_a1 + tau_a2, tau_j2 = tau_a2.
    """
    (tmp_path / "linear.toml").write_text(LINEAR)
    machine = symkin.load(tmp_path / "linear.toml")
    given, find = ("motor1", "motor2"), ("joint1", "joint2")
    _run(tmp_path / "c", machine, given, find, COMMON + BESIDE)


def test_the_package_names_its_files_and_its_plugin(tmp_path):
    """XML and CMake files that the command writes name the package, the plugin's class and library,
    and one another; poses and floats have no transmission.
    """
    told = ["--given", ",".join(ANKLE[1]), "--find", ",".join(ANKLE[2]), "--ros2"]
    ran = CliRunner().invoke(app, ["firmware", "ankle", *told, "-o", str(tmp_path)])
    assert ran.exit_code == 0, ran.output
    package, plugin, urdf = (
        ET.parse(tmp_path / "ros2" / file).getroot()
        for file in ("package.xml", "ankle_transmission.xml", "ankle_transmission.urdf")
    )
    name = package.findtext("name")
    found = plugin.find("class").attrib
    assert plugin.attrib["path"] == name
    assert urdf.find(".//plugin").text == found["name"] == f"{name}/Transmission"
    assert found["base_class_type"] == "transmission_interface::TransmissionLoader"
    loader = (tmp_path / "ros2" / "ankle_transmission_loader.cpp").read_text()
    space, kind = found["type"].split("::")
    assert f"namespace {space}" in loader
    assert f"class {kind} : public {found['base_class_type']}" in loader
    assert f"PLUGINLIB_EXPORT_CLASS({found['type']}, {found['base_class_type']})" in loader
    assert [j.attrib["name"] for j in urdf.iter("joint")] == list(ANKLE[2])
    assert [a.attrib["name"] for a in urdf.iter("actuator")] == list(ANKLE[1])
    cmake = (tmp_path / "ros2" / "CMakeLists.txt").read_text()
    assert f"add_library({name} SHARED ../ankle.c ankle_transmission_loader.cpp)" in cmake
    for wrong in (
        Options("double", also=("ros2",)),
        Options("float", *[], **_map(), also=("ros2",)),
    ):
        with pytest.raises(InputError, match="--ros2 writes a transmission between joints"):
            write_folder(symkin.load("ankle"), tmp_path / "none", wrong)


def _map():
    return {"given": ANKLE[1], "find": ANKLE[2]}
