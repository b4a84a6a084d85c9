"""Golden figures of generated C: operations of each function, accepted and refused goals, digests
of the folders that are not committed.
"""

from __future__ import annotations

import json

import pytest

from helpers import firmware_tools as tools
from helpers.gate import in_gate

GOLDEN = tools.bench_module("golden")
GENERATE = tools.bench_module("generate")
HELD = [name for name in tools.FOLDERS if name not in tools.COMMITTED]
QUICK = [
    ("five_bar", "float"),
    ("three_rrr", "double"),
    ("slider_crank", "float"),
    ("zhang2009", "double"),
    ("scara", "float"),
]
"""A platform that formulas solve, one that is iterated, a map, a platform on rods, an arm."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("machine", "real"), in_gate([(m, r) for m in GOLDEN.MACHINES for r in GOLDEN.REALS], QUICK)
)
def test_the_code_does_what_it_did(machine, real):
    """No function takes more or fewer operations than the golden ones, and the same goals are
    accepted and refused.
    """
    tools.compiler("gcc")
    told = GOLDEN.differences(
        machine, real, GOLDEN.kept().get(machine, {}).get(real), GOLDEN.found(machine, real)
    )
    assert not told, "\n" + "\n".join(told)


def test_committed_folders_have_the_golden_operations():
    """Manifests state the same numbers as the golden file."""
    kept = GOLDEN.kept()
    for folder in tools.COMMITTED:
        manifest = tools.manifest(folder)
        golden = kept[manifest["mechanism"]][manifest["options"]["real"]]["operations"]
        stated = {
            function: bound["usual"] for function, bound in manifest["worst_case"]["bound"].items()
        }
        assert set(golden) == set(stated)
        for function, bound in stated.items():
            row = [
                bound["iterations"],
                *(bound["operations"].get(name, 0) for name in GOLDEN.COLUMNS[1:]),
            ]
            assert golden[function] == row, (
                f"{folder}, {function}: {GOLDEN.accepting(manifest['mechanism'])}"
            )


def test_the_golden_file_has_every_machine_and_nothing_else():
    """What is read is what was written, in the same bytes."""
    kept = GOLDEN.kept()
    assert set(kept) == set(GOLDEN.MACHINES)
    assert len(kept) == 25
    assert all(set(parts) == set(GOLDEN.REALS) for parts in kept.values())
    assert GOLDEN.golden_text(kept) == GOLDEN.GOLDEN.read_text()


def test_accepted_and_refused_goals_are_both_there():
    """Of each type of numbers and most machines: else the golden statuses would say little."""
    kept = GOLDEN.kept()
    for real in GOLDEN.REALS:
        said = {
            machine: "".join(parts[real]["statuses"].values())
            for machine, parts in kept.items()
            if parts[real]["statuses"]
        }
        assert len(said) == 18
        assert all("O" in letters for letters in said.values())
        assert sum(len(set(letters)) > 1 for letters in said.values()) >= 16
        assert set("".join(said.values())) >= set("OMRW")


def test_a_difference_is_a_sentence():
    """It says machine, type, function, old and new count, goals, and the command that accepts
    it.
    """
    old = {
        "operations": {"direct": [100, 5, 7, 0, 0, 0, 0, 0], "line": "-", "gone": [0] * 8},
        "statuses": {"small": "OOW"},
    }
    new = {
        "operations": {"direct": [100, 5, 9, 1, 0, 0, 0, 0], "line": [0] * 8, "feed": [0] * 8},
        "statuses": {"small": "ORW"},
    }
    accepts = "`python codegen/bench/golden.py delta --write` accepts it"
    assert GOLDEN.differences("delta", "float", old, new) == [
        f"delta float, direct: 7 -> 9 multiplications, 0 -> 1 divisions; {accepts}",
        f"delta float, line: is bounded now; {accepts}",
        f"delta float, gone: is there no more; {accepts}",
        f"delta float, feed: is new; {accepts}",
        f"delta float, small goals: number 1 O -> R; in all 2 -> 1 O, 0 -> 1 R; {accepts}",
    ]
    assert GOLDEN.differences("delta", "float", old, old) == []
    assert GOLDEN.differences("delta", "float", None, new) == [
        f"delta float has no golden figures; {accepts}"
    ]


@pytest.mark.slow
@pytest.mark.parametrize("folder", in_gate(HELD, [*tools.KINDS, "ren2008_true_float"]))
def test_folders_that_are_not_committed_have_their_digest(folder):
    """Their text is the one that the digest is of; the gate tries each machine in one type of
    numbers.
    """
    files = {
        path.name: path.read_text() for path in tools.folder(folder).iterdir() if path.is_file()
    }
    digest = json.loads((tools.CODEGEN / "digests.json").read_text())[folder]
    assert GENERATE.digest_of(files) == digest, (
        f"{folder} is another text: run python codegen/generate.py"
    )


def test_committed_and_held_folders_are_all_that_there_are():
    """Each variant of generate.py once; at most eight are committed."""
    assert sorted(folder for folder, _, _ in GENERATE.variants()) == tools.FOLDERS
    assert len(tools.COMMITTED) <= 8
    assert (
        sorted(path.parent.name for path in tools.CODEGEN.glob("*/manifest.json"))
        == tools.COMMITTED
    )


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("x = -3.0533016766960284 * w->x[3];", "x = -3.053301676696029 * w->x[3];"),
        ("const float a = 1e-09f;", "const float a = 1.0e-09f;"),
        ("0x1.8p+1, 12U, x[10]", "0x1.8p+1, 12U, x[10]"),
    ],
)
def test_last_digits_make_no_other_digest(one, other):
    stable = GENERATE.stable
    assert stable(one) == stable(other)
    assert stable(one) != stable(one.replace("3", "4").replace("a", "b").replace("12", "13"))
