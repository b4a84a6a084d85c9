"""Files of robots that would crash, block or fill what reads them: each is one sentence and status
2, soon, and this process stays well.

What a foreign library parses is read in a child process; counts are refused before anything is
placed.
"""

from __future__ import annotations

import os
import re
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from helpers.command_line import run
from helpers.inside import child, loops_beside, shown

pytestmark = pytest.mark.usefixtures("own_mujoco")

MJCF = (
    "<mujoco model='r'>{0}<worldbody><body name='b'><joint name='j' axis='0 0 "
    "1'/>{1}</body></worldbody></mujoco>"
)
URDF = "<robot name='r'><link name='l0'/>{}</robot>"
XACRO = "<robot name='r' xmlns:xacro='http://www.ros.org/wiki/xacro'>{}</robot>"
JOINT = (
    "<link name='l{1}'/><joint name='j{1}' type='{2}'><parent link='l{0}'/><child "
    "link='l{1}'/><axis xyz='0 0 1'/></joint>"
)
GRID = "<asset><hfield name='h' nrow='100000' ncol='100000' size='1 1 1 1'/></asset>"
ITSELF = "<asset><model name='m' file='r.xml'/></asset>"
COPIES = (
    "<replicate count='100000000' euler='0 0 1'><body><joint/><geom size='.1'/></body></replicate>"
)
TWICE = (
    "".join(
        f"<xacro:macro name='m{k}' params=''><xacro:m{k + 1}/><xacro:m{k + 1}/></xacro:macro>"
        for k in range(40)
    )
    + "<xacro:macro name='m40' params=''><link name='l'/></xacro:macro><xacro:m0/>"
)
SHORT = 2.0
"""Seconds in place of the usual ones, for files that take for ever."""


def refusal(path: Path, capsys: pytest.CaptureFixture[str]) -> str:
    """The one sentence with which `show` refuses a file."""
    status, out, err = run(capsys, "show", path)
    assert (status, out) == (2, "")
    assert err.count("\n") == 1
    assert len(err) < 2000
    return err


def chain(count: int, kind: str) -> str:
    return URDF.format("".join(JOINT.format(k, k + 1, kind) for k in range(count)))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            MJCF.format(ITSELF, "<attach model='m' body='b' prefix='x'/>"),
            "MuJoCo's compiler ended without an answer",
        ),
        (MJCF.format(GRID, "<geom type='hfield' hfield='h'/>"), "tells no reason"),
        (
            MJCF.format("", COPIES),
            "MuJoCo's compiler (gave no answer within 2 s|needed more than 2 GB)",
        ),
        (MJCF.format("<include file='pipe'/>", ""), "MuJoCo's compiler gave no answer within 2 s"),
    ],
    ids=["attached to itself", "height field", "copies", "FIFO"],
)
@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="limits and FIFOs of POSIX")
def test_what_mujoco_does_not_survive(
    text: str,
    told: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pytest.importorskip("mujoco")
    monkeypatch.setattr(child, "SECONDS", SHORT)
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "r.xml").write_text(text, encoding="utf-8")
    begin = time.perf_counter()
    err = refusal(tmp_path / "r.xml", capsys)
    # a machine under load may take all of its time to begin
    assert re.search(f"{told}|gave no answer", err), err
    assert time.perf_counter() - begin < SHORT + 10.0


def test_a_texture_of_any_size_is_left_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Kinematics does not need it, so none is made."""
    pytest.importorskip("mujoco")
    texture = (
        "<asset><texture name='t' type='2d' builtin='flat' width='100000' height='100000'/></asset>"
    )
    (tmp_path / "r.xml").write_text(MJCF.format(texture, ""), encoding="utf-8")
    assert run(capsys, "show", tmp_path / "r.xml")[0] == 0


@pytest.mark.slow
def test_macros_that_double_forty_times(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("xacro")
    monkeypatch.setattr(child, "SECONDS", SHORT)
    (tmp_path / "r.xacro").write_text(XACRO.format(TWICE), encoding="utf-8")
    assert "xacro gave no answer within 2 s" in refusal(tmp_path / "r.xacro", capsys)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no FIFOs here")
@pytest.mark.parametrize("suffix", ["xml", "urdf", "sdf", "xacro", "toml"])
def test_a_fifo_in_place_of_a_file(
    suffix: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    os.mkfifo(tmp_path / f"r.{suffix}")
    assert "it is no regular file" in refusal(tmp_path / f"r.{suffix}", capsys)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no FIFOs here")
def test_a_fifo_that_xacro_includes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("xacro")
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "r.xacro").write_text(
        XACRO.format("<xacro:include filename='pipe'/>"), encoding="utf-8"
    )
    assert "pipe: the file cannot be read (it is no regular file)" in refusal(
        tmp_path / "r.xacro", capsys
    )


@pytest.mark.parametrize(
    ("kind", "count"), [("revolute", 5000), ("fixed", 3001), ("revolute", 1001)]
)
def test_a_chain_of_too_many_joints_is_refused_before_it_is_placed(
    kind: str, count: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "r.urdf").write_text(chain(count, kind), encoding="utf-8")
    begin = time.process_time()
    assert "allowed: 3000, of which 1000 move" in refusal(tmp_path / "r.urdf", capsys)
    assert time.process_time() - begin < 4.0


def test_bodies_of_mjcf_are_counted_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("mujoco")
    bodies = "<body><joint/></body>" * 1001
    (tmp_path / "r.xml").write_text(MJCF.format("", bodies), encoding="utf-8")
    assert "1002 joints of which move" in refusal(tmp_path / "r.xml", capsys)


def test_includes_that_double_at_each_of_twenty_depths(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A million models from twenty files of two lines."""
    for depth in range(20):
        both = "".join(
            f"<include><uri>m{depth + 1}.sdf</uri><name>{name}</name></include>" for name in "ab"
        )
        text = (
            f"<sdf version='1.9'><model name='r'><link "
            f"name='l'/>{both if depth < 19 else ''}</model></sdf>"
        )
        (tmp_path / f"m{depth}.sdf").write_text(text, encoding="utf-8")
    begin = time.process_time()
    assert "it is include number 1001" in refusal(tmp_path / "m0.sdf", capsys)
    assert time.process_time() - begin < 5.0


def test_a_version_of_five_thousand_digits(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "r.sdf").write_text(
        f"<sdf version='1.{'9' * 5000}'><model name='r'/></sdf>", encoding="utf-8"
    )
    assert "is unknown; allowed: 1.4 to 1.12" in refusal(tmp_path / "r.sdf", capsys)


NINES = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]\n" for k in range(1, 11)
)
MERGED = "a0: &a0 {x: 1, y: 2}\n" + "".join(
    f"a{k}: &a{k} {{<<: [{', '.join([f'*a{k - 1}'] * 9)}]}}\n" for k in range(1, 11)
)


@pytest.mark.parametrize(
    ("loops", "told"),
    [
        (f"closed_loop: [[a, b]]\ntype: [{'9' * 5000}]", "r.yaml"),
        (
            f"closed_loop: [[a, b]]\ntype: [0x{'f' * 5000}]",
            "type = [a whole number of 20000 bits] is no list of names",
        ),
        (f"closed_loop: [[a, 0x{'f' * 5000}]]\ntype: [6d]", "a whole number of 20000 bits"),
        (
            f"{NINES}closed_loop: *a10\ntype: [6d]",
            "its aliases (*name) make more than 100000 values",
        ),
        (f"{MERGED}closed_loop: []\ntype: []", "its aliases (*name) make more than 100000 values"),
        ("closed_loop: &a [*a]\ntype: [6d]", "its aliases (*name) make more than 100000 values"),
        (f"closed_loop: {'[' * 2000}", "not YAML"),
        (f"closed_loop: []\ntype: [{'a, ' * 100_000}]", "the file has more than 0.2 MB"),
    ],
    ids=["digits", "number", "name", "aliases", "merged", "itself", "deep", "long"],
)
def test_yaml_beside_a_urdf(
    loops: str, told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("yaml")
    (tmp_path / "r.urdf").write_text(chain(1, "revolute"), encoding="utf-8")
    (tmp_path / "r.yaml").write_text(loops, encoding="utf-8")
    begin = time.process_time()
    assert told in refusal(tmp_path / "r.urdf", capsys)
    assert time.process_time() - begin < 3.0


def test_other_keys_that_are_numbers(tmp_path: Path) -> None:
    """A note names them."""
    pytest.importorskip("yaml")
    (tmp_path / "r.yaml").write_text(
        f"closed_loop: []\ntype: []\n? 0x{'f' * 5000}\n: 1\n", encoding="utf-8"
    )
    assert "a whole number of 20000 bits" in loops_beside(tmp_path / "r.urdf").notes[0]


def nested(depth: int, build: Callable[[object], object]) -> object:
    value: object = 0
    for _ in range(depth):
        value = build(value)
    return value


def test_a_value_in_a_message_is_begun_only() -> None:
    """What is short is shown as Python writes it; of what is endless a beginning."""
    for value in ([], (1,), {"a": [1, "b"]}, [1.5, None], "it's", 12345678901234567890):
        assert shown(value) == repr(value)
    endless: list[object] = []
    endless.append(endless)
    for value in (
        endless,
        nested(40, lambda v: [v] * 9),
        nested(40, lambda v: {1: v, 2: v}),
        [10**5000],
        "x" * 10**6,
    ):
        assert len(shown(value)) < 100


# --- the child ------------------------------------------------------------------------------------


def worker(folder: Path, body: str) -> Path:
    path = folder / "worker.py"
    path.write_text(f"import os, sys\ndef work(task):\n    {body}\n", encoding="utf-8")
    return path


def test_an_answer_comes_back_whatever_the_worker_prints(tmp_path: Path) -> None:
    task = {"numbers": [0.1, float("inf")], "text": "\udcff é"}
    body = "print('noise'); os.system('echo more'); return task | {'pid': os.getpid()}"
    answer = child.answer_of(worker(tmp_path, body), task)
    assert answer.pop("pid") != os.getpid()
    assert answer == task


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ("os._exit(3)", r"ended without an answer \(status 3\)"),
        ("raise ValueError", r"ended without an answer \(status 1\)"),
        ("os.abort()", "ended without an answer"),
        ("return 'x' * 60_000_000", "needed more than 2 GB"),
        ("os.write(1, b'{}'); os._exit(0)", "ended without an answer"),
    ],
)
def test_a_worker_that_gives_no_answer(body: str, told: str, tmp_path: Path) -> None:
    with pytest.raises(child.ChildError, match=told):
        child.answer_of(worker(tmp_path, body), {})


def test_a_worker_without_end_is_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(child, "SECONDS", 0.5)
    with pytest.raises(child.ChildError, match=r"gave no answer within 0\.5 s"):
        child.answer_of(worker(tmp_path, "while True: pass"), {})


@pytest.mark.skipif(
    os.name != "posix" or os.uname().sysname != "Linux", reason="Linux bounds the address space"
)
def test_a_worker_that_wants_much_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(child, "MEMORY", 5e8)
    with pytest.raises(child.ChildError, match=r"needed more than 0\.5 GB of memory"):
        child.answer_of(worker(tmp_path, "return len(bytearray(10**9))"), {})
