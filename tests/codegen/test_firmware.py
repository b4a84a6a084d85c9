"""Generated C: it compiles without a warning, passes its own test, and is the same text every
time.
"""

from __future__ import annotations

import json
from itertools import product

import numpy as np
import pytest

from helpers import firmware_tools as tools
from helpers import samples
from helpers.gate import in_gate, in_gate_but
from helpers.inside import Options, Real, folder_files, snap, write_folder
from symkin import InputError, load

CODEGEN = tools.CODEGEN


@pytest.mark.slow
@pytest.mark.parametrize("folder", tools.COMMITTED)
def test_committed_folders_are_what_the_generator_writes(folder):
    """The same model gives the same bytes."""
    generate = tools.bench_module("generate")
    name, options = next(
        (name, options) for other, name, options in generate.variants() if other == folder
    )
    files = folder_files(load(name), options, generate.MEASURED.get(folder))
    committed = CODEGEN / folder
    assert {path.name for path in committed.iterdir() if path.suffix != ".o"} >= set(files)
    for file, text in files.items():
        assert (committed / file).read_text() == text, (
            f"{folder}/{file} differs: run python codegen/generate.py"
        )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("folder", "cc"),
    in_gate(
        product(tools.FOLDERS, ["gcc", "clang"]),
        [
            (name, ("gcc", "clang")[k % 2])
            for k, name in enumerate(tools.KINDS)
            if name not in ("scara_float", "zhang2009_float_home_relative")  # built elsewhere too
        ],
    ),
)
def test_folders_compile_and_pass(folder, cc, tmp_path):
    """Strict C99 without a warning; every vector and every failure status."""
    source, name = tools.folder(folder), tools.manifest(folder)["mechanism"]
    code = str(tmp_path / "code.o")
    unused = "-Wno-unused-command-line-argument"  # the library of mathematics
    tools.built(cc, source, [f"{name}.c"], code, "-O2", "-I.", "-c", unused)
    for main in (f"{name}_test.c", "example_main.c"):
        out = str(tmp_path / main.removesuffix(".c"))
        tools.passed(tools.built(cc, source, [main, code], out, "-O1", "-I."))


MACHINES = CODEGEN / "bench" / "machines"
SAMPLES = {
    "five_bar": samples.five_bar,
    "three_rrr": samples.three_rrr,
    "three_rrr_planar": lambda: samples.three_rrr("planar"),
    "delta": samples.delta,
    "four_bar": lambda: samples.four_bar()[0],
    "pieper": samples.pieper,
}


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("real", ["float", "double"])
@pytest.mark.parametrize("sample", list(SAMPLES))
def test_other_mechanisms_compile_and_pass(sample, real, tmp_path):
    """Overconstrained, planar, translational and serial mechanisms alike."""
    mechanism = SAMPLES[sample]()
    tools.write_untested(mechanism, tmp_path, Options(real))
    tools.passed(
        tools.built(
            "gcc", tmp_path, [f"{mechanism.name}.c", f"{mechanism.name}_test.c"], "test", "-O1"
        )
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "file",
    in_gate_but(
        sorted(MACHINES.glob("*.toml")),
        [p for p in MACHINES.glob("*.toml") if p.stem != "tricept"],
    ),
    ids=lambda path: path.stem,
)
def test_machines_of_the_bench_compile_and_pass(file, tmp_path):
    """A Tricept too, whose middle limb has rows that say the same and vanish at home in part."""
    tools.write_untested(load(str(file)), tmp_path, Options("double"))
    tools.passed(
        tools.built("gcc", tmp_path, [f"{file.stem}.c", f"{file.stem}_test.c"], "test", "-O1")
    )


@pytest.mark.slow
@pytest.mark.parametrize("geometry", in_gate(["fixed", "struct"], ["fixed"]))
@pytest.mark.parametrize("real", in_gate(["float", "double"], ["float"]))
def test_home_relative_form(real, geometry, tmp_path):
    options = Options(real, home_relative=True, geometry=geometry, home=(0, 0, 420, 1, 0, 0, 0))
    tools.write_untested(load("zhang2009"), tmp_path, options)
    tools.passed(tools.built("gcc", tmp_path, ["zhang2009.c", "zhang2009_test.c"], "test", "-O1"))


def test_manifest_names_what_decides_the_bytes():
    manifest = tools.manifest("zhang2009_float")
    assert manifest["options"]["real"] == "float"
    assert set(manifest) >= {"model_sha256", "symkin", "casadi", "files"}
    assert "time" not in json.dumps(manifest)


@pytest.mark.parametrize("option", [{"home_relative": True}, {"home": (0, 0, 1, 1, 0, 0, 0)}])
def test_options_for_rods_are_refused_elsewhere(option, tmp_path):
    with pytest.raises(InputError, match="six rods"):
        write_folder(load("zhao2000"), tmp_path, Options(**option))


@pytest.mark.parametrize("count", [4, 7])
def test_arms_that_stay_in_a_plane_are_refused(count, tmp_path):
    """More joints than directions: parallel axes move the tool in a plane."""
    from symkin import Joint, Limb, Mechanism

    joints = [Joint(f"q{k}", "R", (10.0 * k, 0, 0), (0, 0, 1), actuated=True) for k in range(count)]
    with pytest.raises(InputError, match="in 3 directions only"):
        write_folder(Mechanism("plane", [Limb("plane", joints)], serial=True), tmp_path, Options())


def test_literals_read_back_exactly():
    """Shortest decimals with the suffix of their type, and hexadecimal bits."""
    rng = np.random.default_rng(0)
    for value in rng.normal(size=200) * 10.0 ** rng.integers(-8, 8, 200):
        text = Real("float").literal(float(value))
        assert text.endswith("f")
        assert np.float32(text[:-1]) == np.float32(value)
        assert float(Real("double").literal(float(value))) == value
        assert float.fromhex(Real("double").hexadecimal(float(value))) == value


def test_constants_are_snapped_only_by_rounding_noise():
    assert snap(float(np.cos(np.pi / 2)), 1.0) == 0.0
    assert snap(float(np.sin(np.pi / 6))) == 0.5
    assert snap(125 * 3**0.5) == 125 * 3**0.5
    assert snap(1e-9) == 1e-9
