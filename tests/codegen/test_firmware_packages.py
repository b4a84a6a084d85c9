"""Generated folders in other projects: CMake's find_package, PlatformIO, Arduino, Zephyr, C++; and
the example's control loop.
"""

from __future__ import annotations

import json
import re
import subprocess

import pytest

import symkin
from helpers import firmware_tools as tools
from helpers.gate import in_gate
from helpers.inside import Options, write_folder

USER = """#include <NAME.h>
int main(void) { NAME_pose pose = { { 0, 0, 0 }, { 2, 0, 0, 0 } }; NAME_real joints[NAME_COUNT];
  return NAME_inverse(&pose, joints) == OUTSIDE ? 0 : 1; }
"""


def run(*command, folder):
    done = subprocess.run(
        [str(part) for part in command], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def user(name):
    """A program of a user's that calls a platform's inverse with a quaternion that is refused."""
    return (
        USER.replace("NAME_COUNT", f"{name.upper()}_JOINTS")
        .replace("OUTSIDE", f"{name.upper()}_OUT_OF_RANGE")
        .replace("NAME", name)
    )


@pytest.fixture(scope="module")
def packaged(tmp_path_factory):
    """A folder with the files of package managers."""
    folder = tmp_path_factory.mktemp("packaged") / "delta"
    write_folder(symkin.load("delta"), folder, Options("float", also=("package", "cpp")))
    return folder


@pytest.mark.long
def test_cmake_find_package(tmp_path):
    """What is installed is found from elsewhere, by name and version, with its header and without
    its example.
    """
    tools.compiler("cmake")
    run("cmake", "-S", tools.folder("delta_double"), "-B", tmp_path / "build", folder=tmp_path)
    run("cmake", "--build", tmp_path / "build", folder=tmp_path)
    run(
        "cmake",
        "--install",
        tmp_path / "build",
        "--prefix",
        tmp_path / "installed",
        folder=tmp_path,
    )
    (tmp_path / "user").mkdir()
    (tmp_path / "user" / "user.c").write_text(user("delta"))
    (tmp_path / "user" / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.13)\nproject(user C)\nfind_package(delta 0.1 REQUIRED)\n"
        "add_executable(user user.c)\n"
        "target_link_libraries(user PRIVATE delta::delta)\n"
    )
    run(
        "cmake",
        "-S",
        "user",
        "-B",
        "user/build",
        f"-DCMAKE_PREFIX_PATH={tmp_path / 'installed'}",
        folder=tmp_path,
    )
    run("cmake", "--build", "user/build", folder=tmp_path)
    run(tmp_path / "user" / "build" / "user", folder=tmp_path)
    assert not list((tmp_path / "installed").rglob("*example*"))


def test_cmake_subdirectory(tmp_path):
    """Two folders in one project: their tests and examples stay out of it."""
    tools.compiler("cmake")
    (tmp_path / "user.c").write_text(user("delta"))
    (tmp_path / "CMakeLists.txt").write_text(
        f"cmake_minimum_required(VERSION 3.13)\nproject(user C)\n"
        f"add_subdirectory({tools.folder('delta_double')} delta)\n"
        f"add_subdirectory({tools.folder('ur5e_double')} ur5e)\nadd_executable(user user.c)\n"
        f"target_link_libraries(user PRIVATE delta::delta ur5e::ur5e)\n"
    )
    run("cmake", "-S", ".", "-B", "build", folder=tmp_path)
    run("cmake", "--build", "build", folder=tmp_path)
    run(tmp_path / "build" / "user", folder=tmp_path)


def test_platformio_compiles_the_source_alone(packaged, tmp_path):
    """The filter leaves test and example, which have a main, out; what PlatformIO requires is
    there.
    """
    library = json.loads((packaged / "library.json").read_text())
    assert {"name", "version"} <= set(library)
    assert re.fullmatch(r"\d+\.\d+\.\d+", library["version"])
    build = library["build"]
    assert build["srcFilter"][0] == "-<*>"
    sources = [packaged / build["srcDir"] / part[2:-1] for part in build["srcFilter"][1:]]
    (tmp_path / "main.c").write_text(user("delta"))
    flags = [*build["flags"], f"-I{packaged / build['includeDir']}"]
    tools.passed(tools.built("gcc", tmp_path, ["main.c", *map(str, sources)], "user", *flags))


def test_arduino_compiles_src_alone(packaged, tmp_path):
    """Every file of src/ together with a sketch in C++; the properties are those that Arduino
    requires.
    """
    lines = dict(
        line.split("=", 1) for line in (packaged / "library.properties").read_text().splitlines()
    )
    assert {
        "name",
        "version",
        "author",
        "maintainer",
        "sentence",
        "paragraph",
        "category",
        "url",
        "architectures",
    } <= set(lines)
    assert all(lines.values())
    for source in packaged.glob("src/*.c"):
        subprocess.run(
            [
                tools.compiler("gcc"),
                "-std=gnu11",
                "-Wall",
                "-Werror",
                "-c",
                source,
                "-o",
                "library.o",
            ],
            cwd=tmp_path,
            check=True,
        )
    (tmp_path / "sketch.cpp").write_text(user("delta"))
    command = [
        tools.compiler("g++"),
        "-std=gnu++17",
        f"-I{packaged / 'src'}",
        "sketch.cpp",
        "library.o",
        "-lm",
        "-o",
        "sketch",
    ]
    subprocess.run(command, cwd=tmp_path, check=True)
    tools.passed(tmp_path / "sketch")


def test_zephyr_module(packaged, tmp_path):
    """module.yml names the folder of CMake and Kconfig; with the option of Kconfig, and only then,
    the source is compiled.
    """
    tools.compiler("cmake")
    module = (packaged / "zephyr" / "module.yml").read_text()
    assert re.search(r"^name: delta$", module, re.M)
    assert re.search(r"^  cmake: zephyr$", module, re.M)
    assert re.search(r"^  kconfig: zephyr/Kconfig$", module, re.M)
    kconfig = (packaged / "zephyr" / "Kconfig").read_text()
    assert re.match(r'config DELTA\n\tbool "[^"\n]+"\n', kconfig)
    (tmp_path / "main.c").write_text(user("delta"))
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.20)\nproject(app C)\nadd_executable(app main.c)\n"
        "macro(zephyr_library)\n  add_library(module STATIC)\nendmacro()\n"
        "macro(zephyr_library_sources)\n  target_sources(module PRIVATE ${ARGN})\nendmacro()\n"
        "macro(zephyr_library_compile_options)\n  target_compile_options(module PRIVATE ${ARGN})\n"
        "endmacro()\n"
        "macro(zephyr_include_directories)\n  target_include_directories(module PUBLIC ${ARGN})\n"
        "  target_link_libraries(app PRIVATE module m)\nendmacro()\n"
        f"add_subdirectory({packaged / 'zephyr'} module)\n"
    )
    run("cmake", "-S", ".", "-B", "build", "-DCONFIG_DELTA=y", folder=tmp_path)
    run("cmake", "--build", "build", folder=tmp_path)
    run(tmp_path / "build" / "app", folder=tmp_path)
    run("cmake", "-S", ".", "-B", "without", folder=tmp_path)
    assert not list((tmp_path / "without").rglob("*module.dir"))


CPP = {
    "zhang2009": """
    namespace m = zhang2009;
    const m::geometry numbers = ZHANG2009_NOMINAL;
    const m::pose home{{0, 0, 420}, {1, 0, 0, 0}};
    const auto joints = m::inverse(numbers, home);
    const auto back = m::direct(numbers, joints.value, home);
    const auto step = m::track(numbers, joints.value, back.value);
    const m::joint_values limits{1, 1, 1, 1, 1, 1};
    const auto feed = m::feed(numbers, home, m::twist_values{0, 0, 100, 0, 0, 0}, limits);
    const m::pose wrong{{0, 0, 420}, {2, 0, 0, 0}};
    return joints && back && step && feed && feed.value < 0.1 &&
      step.details.residual < m::track_limit
        && m::inverse(numbers, wrong).state == m::status::out_of_range && m::joint_count == 6 ?
          0 : 1;""",
    "ur5e": """
    namespace m = ur5e;
    const m::joint_values joints{0.1, -1.2, 1.3, -1.0, 0.8, 0.4};
    const auto pose = m::direct(joints);
    const auto again = m::inverse(pose.value, m::joint_values{0.12, -1.21, 1.31, -1.0, 0.81, 0.4});
    const auto all = m::inverse_all(pose.value);
    const auto near = m::inverse_nearest(pose.value, joints);
    const auto rates = m::rates(joints, m::twist_values{1, 0, 0, 0, 0, 0});
    const auto twist = m::twist(joints, rates.value);
    const auto step = m::track(pose.value, joints);
    if (!rates || !twist || !step || std::abs(twist.value[0] - 1.0) > 1e-9) { return 1; }
    return pose && again && near && all.count == 8 && m::branch_count == 8 &&
      std::abs(again.value[2] - 1.3) < 1e-9
        && std::abs(near.value[4] - 0.8) < 1e-9 ? 0 : 1;""",
    "ankle": """
    namespace m = ankle;
    const m::joint_values joints{0.1, -0.2}, ones{1.0, 1.0};
    const auto found = m::direct(joints, m::joint_values{});
    const auto back = m::inverse(found.value, m::joint_values{});
    const auto step = m::track(joints, found.value);
    const auto again = m::track_inverse(found.value, joints);
    const auto both = m::second(joints, found.value);
    const auto jacobian = m::jacobian(joints, found.value);
    const auto inverse = m::inverse_jacobian(joints, found.value);
    const auto inertia = m::inertia(joints, found.value, ones);
    const auto torques = m::torque_limits(joints, found.value, ones);
    const auto rates = m::rate_limits(joints, found.value, ones);
    const auto moved = m::rates(joints, found.value, ones);
    const auto held = m::torques(joints, found.value, ones);
    return found && back && step && again && both && inertia && torques && rates && moved && held
        && std::abs(back.value[1] + 0.2) < 1e-9 && both.value.jacobian == jacobian.value
        && std::abs(jacobian.value[0] * inverse.value[0] + jacobian.value[1] * inverse.value[2]
            - 1.0) < 1e-9
        && m::direct(ones, m::joint_values{9e9, 0}).state == m::status::out_of_range ? 0 : 1;""",
}
MAP = {"given": ("upper_motor", "lower_motor"), "find": ("ankle.1", "ankle.2")}


@pytest.mark.parametrize("name", in_gate(CPP, ["zhang2009", "ankle"]))
def test_cpp_header(name, tmp_path):
    """With g++ and clang++, as C++17 and C++20, with all warnings as errors: the same answers and
    statuses.
    """
    options = (
        {"geometry": "struct", "home": (0.0, 0.0, 420.0, 1.0, 0.0, 0.0, 0.0)}
        if name == "zhang2009"
        else MAP
        if name == "ankle"
        else {}
    )
    write_folder(symkin.load(name), tmp_path, Options("double", also=("cpp",), **options))
    (tmp_path / "user.cpp").write_text(
        f'#include "{name}.hpp"\n#include <cmath>\nint main()\n{{{CPP[name]}\n}}\n'
    )
    subprocess.run(
        [tools.compiler("gcc"), "-O1", "-c", f"{name}.c", "-o", "n.o"], cwd=tmp_path, check=True
    )
    for compiler in ("g++", "clang++"):
        for standard in ("-std=c++17", "-std=c++20"):
            flags = [
                standard,
                "-Wall",
                "-Wextra",
                "-Werror",
                "-pedantic",
                "-Wconversion",
                "-Wshadow",
            ]
            subprocess.run(
                [tools.compiler(compiler), *flags, "user.cpp", "n.o", "-lm", "-o", "user"],
                cwd=tmp_path,
                check=True,
            )
            tools.passed(tmp_path / "user")


@pytest.mark.parametrize(
    "folder", in_gate(tools.POSES, ["delta_double", "ur5e_double", "zhang2009_float_home_relative"])
)
def test_the_example_loses_nothing(folder, tmp_path):
    """The loop answers every cycle but those it must hold: readings that are not numbers; a gap is
    bridged by the whole line.
    """
    name = tools.manifest(folder)["mechanism"]
    sources = [str(tools.folder(folder) / file) for file in ("example_main.c", f"{name}.c")]
    said = tools.passed(tools.built("gcc", tmp_path, sources, "example", "-O1"))
    counts = {
        word: int(number)
        for number, word in re.findall(r"(\d+) (tracked|recovered|moved|held)", said)
    }
    assert counts["held"] == 1
    assert counts.get("moved", 99) == 99
    if "tracked" in counts:
        assert counts["recovered"] + counts["tracked"] == 69
