"""Writing into a folder loses nothing that is not symkin's own, unedited work."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import symkin
from helpers.inside import Options, app, build_program, folder_files, readme_of, write_folder
from symkin import InputError, Joint, Limb, Mechanism

PLATFORM = symkin.load("ren2008")


def _contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["Makefile", "README.md", "ren2008.c", "manifest.json"])
def test_foreign_files_are_kept(name, tmp_path):
    """A file of the user's that has one of the names: a sentence with it, and nothing is
    written.
    """
    (tmp_path / name).write_text("mine")
    with pytest.raises(
        InputError, match=rf"would replace {name}, there already and not written by symkin"
    ):
        write_folder(PLATFORM, tmp_path, Options())
    assert _contents(tmp_path) == {name: b"mine"}


@pytest.mark.slow
def test_edited_files_are_kept(tmp_path):
    """What was written is written again, with other options too; a file edited since is named, and
    nothing is lost.
    """
    write_folder(PLATFORM, tmp_path, Options())
    write_folder(PLATFORM, tmp_path, Options("float"))
    assert json.loads((tmp_path / "manifest.json").read_text())["options"]["real"] == "float"
    example = tmp_path / "example_main.c"
    example.write_text(example.read_text() + "/* mine */\n")
    (tmp_path / "notes.txt").write_text("mine")
    before = _contents(tmp_path)
    with pytest.raises(InputError, match=r"would replace example_main\.c, edited since"):
        write_folder(PLATFORM, tmp_path, Options())
    assert _contents(tmp_path) == before
    example.unlink()
    write_folder(PLATFORM, tmp_path, Options())
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_another_mechanisms_folder_is_kept(tmp_path):
    """The command ends with status 2, names the mechanism that the folder holds, and writes
    nothing.
    """
    write_folder(PLATFORM, tmp_path, Options())
    before = _contents(tmp_path)
    found = CliRunner().invoke(app, ["firmware", "zhao2000", "-o", str(tmp_path)])
    assert isinstance(found.exception, InputError)
    assert "holds the code of 'ren2008'" in str(found.exception)
    assert _contents(tmp_path) == before


@pytest.mark.parametrize("motion", ["planar", "spatial"])
def test_a_reference_at_which_the_joints_hold_nothing_is_told(motion):
    """Three slides of a plane whose lines meet in the middle leave the platform's turn free there,
    and nowhere beside it.
    """
    limbs = []
    for k, turn in enumerate(np.radians([90.0, 210.0, 330.0])):
        out, z = np.array([np.cos(turn), np.sin(turn), 0.0]), (0.0, 0.0, 1.0)
        slide = Joint(f"slide{k}", "P", 60.0 * out, axis=out, actuated=True)
        limbs.append(
            Limb(
                f"limb{k}",
                [Joint(f"a{k}", "R", 100.0 * out, z), slide, Joint(f"b{k}", "R", 30.0 * out, z)],
            )
        )
    made = Mechanism("meeting", limbs, platform_position=(0.0, 0.0, 0.0), motion=motion)
    told = (
        "the reference configuration is singular for the joints slide0, slide1, slide2: .* another "
        "reference"
    )
    with pytest.raises(InputError, match=told):
        folder_files(made, Options("double"))


@pytest.mark.parametrize(
    ("name", "given", "find", "grounds"),
    [
        ("delta", (), (), {"direct": {"proved"}}),
        ("ren2008", (), (), {"direct": {"measured"}}),
        ("scara", (), (), {"inverse": {"proved"}}),
        ("four_bar", ("crank",), ("follower",), {"direct": {"proved"}, "inverse": {"proved"}}),
    ],
)
def test_the_readme_says_how_each_bound_is_known(name, given, find, grounds):
    """A table for each function that follows lines, a row for each thing that it watches, which
    ends in proved, sampled or measured.
    """
    program = build_program(symkin.load(name), Options(given=given, find=find))
    chapter = readme_of(program).split("## What is watched along a line")[1].split("\n## ")[0]
    _, *tables = chapter.rstrip().split("\n\n`")
    assert len(tables) == len(grounds)
    for table, (function, words) in zip(tables, grounds.items(), strict=True):
        rows = [line for line in table.splitlines() if line.startswith("|")][2:]
        assert table.startswith(f"{name}_{function}`")
        assert len(rows) == len(program.watched[function][1]) > 0
        assert {row.rstrip(" |").split("| ")[-1] for row in rows} == words
