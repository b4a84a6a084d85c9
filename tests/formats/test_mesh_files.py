"""Meshes of COLLADA files: their places, and what is told where one is not read. The page shows
them in `test_page.py`.
"""

from __future__ import annotations

import base64
import re
import sys
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers import inside
from helpers.inside import LinkMesh, UnreadMeshError, mesh_item, read_triangles

COLLADA = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2026-01-01</created><modified>2026-01-01</modified>
<unit name="millimeter" meter="0.001"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="12">0 0 0 3 0 0 3 2 0 0 2 0</float_array>
<technique_common>
<accessor source="#a" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/>
</accessor></technique_common></source><vertices id="v"><input semantic="POSITION" source="#p"/>
</vertices>
<polylist count="1"><input semantic="VERTEX" source="#v" offset="0"/><vcount>4</vcount>
<p>0 1 2 3</p></polylist></mesh></geometry>
</library_geometries><library_visual_scenes><visual_scene id="s"><node id="outer">
<translate>0 0 7</translate>
<node id="n"><rotate>0 0 1 90</rotate><instance_geometry url="#g"/></node></node></visual_scene>
</library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


def test_collada_is_read_in_metres_and_in_its_own_axes(tmp_path: Path) -> None:
    """The rectangle 3 x 2 mm is turned by a quarter about z and stands at z = 7 mm; Y_UP turns
    nothing, as in RViz and Gazebo. Files hold floats.
    """
    (tmp_path / "plate.DAE").write_text(COLLADA, encoding="utf-8")
    triangles = read_triangles(tmp_path / "plate.DAE")
    sides = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]) / 2
    np.testing.assert_allclose(sides.sum(axis=0), [0, 0, 6e-6], atol=1e-12)
    np.testing.assert_allclose(triangles.reshape(-1, 3).min(axis=0), [-2e-3, 0, 7e-3], atol=1e-9)
    np.testing.assert_allclose(triangles.reshape(-1, 3).max(axis=0), [0, 3e-3, 7e-3], atol=1e-9)


@pytest.mark.parametrize(
    "content",
    [
        "",
        "<COLLADA/>",
        COLLADA[:900],
        COLLADA.replace("#p", "#q"),
        COLLADA.replace("0 1 2 3", "0 1 2 9"),
    ],
)
def test_broken_collada_is_told(tmp_path: Path, content: str) -> None:
    (tmp_path / "plate.dae").write_text(content, encoding="utf-8")
    with pytest.raises(UnreadMeshError, match=r"^no triangles could be read there"):
        read_triangles(tmp_path / "plate.dae")


def test_collada_without_its_package_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "plate.dae").write_text(COLLADA, encoding="utf-8")
    monkeypatch.setattr("importlib.util.find_spec", lambda _name: None)
    with pytest.raises(UnreadMeshError, match=r"symkin\[meshes\]"):
        read_triangles(tmp_path / "plate.dae")


NO_END = "def work(task):\n    while True:\n        pass\n"
DEATH = "import os, signal\ndef work(task):\n    os.kill(os.getpid(), signal.SIGSEGV)\n"
GREEDY = "def work(task):\n    return [bytearray(10**9) for _ in range(9)]\n"


@pytest.mark.skipif(sys.platform == "win32", reason="limits of POSIX")
@pytest.mark.parametrize(
    ("worker", "told"),
    [
        (NO_END, "gave no answer within 1 s"),
        (DEATH, "ended without an answer (SIGSEGV)"),
        (GREEDY, "needed more than 2 GB of memory"),
    ],
    ids=["no end", "death", "memory"],
)
def test_what_pycollada_does_not_survive_is_told(
    worker: str, told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The page goes without the mesh, and this process stays well."""
    (tmp_path / "plate.dae").write_text(COLLADA, encoding="utf-8")
    (tmp_path / "worker.py").write_text(worker, encoding="utf-8")
    monkeypatch.setattr(inside.mesh_files, "_WORKER", tmp_path / "worker.py")
    monkeypatch.setattr(inside.child, "SECONDS", 1.0 if worker is NO_END else 20.0)
    with pytest.raises(UnreadMeshError, match=f"^pycollada {re.escape(told)}"):
        read_triangles(tmp_path / "plate.dae")


def test_packed_meshes_are_the_files_triangles(tmp_path: Path) -> None:
    """Unpacked as the page does, corners stand where the file's stand, to half a step of the box;
    triangles without area are left out.
    """
    rng = np.random.default_rng(3)
    points = rng.normal(size=(50, 3)) * (1.0, 0.01, 30.0)
    faces = [rng.choice(50, 3, replace=False) for _ in range(80)]
    lines = (
        [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
        + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces]
        + ["f 1 1 2"]
    )
    (tmp_path / "m.obj").write_text("\n".join(lines), encoding="utf-8")
    turned = symkin.Pose([3.0, 4.0, 5.0], [0.5, 0.5, -0.5, 0.5])
    mesh = LinkMesh(
        "a", str(tmp_path / "m.obj"), turned.position, turned.quaternion, (2.0, 1.0, -1.0)
    )
    item = mesh_item(mesh, 1)
    places = np.frombuffer(base64.b64decode(str(item["places"])), "<u2").reshape(-1, 3)
    triangles = np.frombuffer(base64.b64decode(str(item["triangles"])), "<u2").reshape(-1, 3)
    low, span = np.array(item["low"]), np.array(item["span"])
    shown = (low + places / 65535 * span)[triangles]
    expected = (points * (2.0, 1.0, -1.0)) @ np.asarray(turned.rotation).T + turned.position
    assert shown.shape == (80, 3, 3)
    assert len(places) <= 50
    assert (np.abs(shown - expected[np.array(faces)]) <= 0.5001 * span / 65535).all()


def test_meshes_without_bounds_are_told(tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_text("v 0 0 0\nv 1e300 0 0\nv 0 1 0\nf 1 2 3\n", encoding="utf-8")
    for scale in (1.0, 1e100):
        with pytest.raises(UnreadMeshError):
            mesh_item(LinkMesh("a", str(tmp_path / "m.obj"), scale=(scale, 1.0, 1.0)), 1)


def test_why_a_mesh_is_not_shown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(inside.mesh_files, "_LARGEST", 10)
    for name, content, reason in (
        ("a.glb", "x", "read are .stl, .obj, .dae"),
        ("a.stl", "x" * 11, "files up to 1e-05 MB are read"),
        ("b.stl", "", "no triangles could be read there"),
        ("c.obj", "v 0 0 0", "no triangles could be read there"),
    ):
        (tmp_path / name).write_text(content, encoding="utf-8")
        with pytest.raises(UnreadMeshError, match=f"^{reason}"):
            read_triangles(tmp_path / name)
    with pytest.raises(UnreadMeshError, match=r"^there is no such file"):
        read_triangles(tmp_path / "none.stl")
