"""Meshes of robots are references: kept with pose and scale, never read, of no effect on the
mechanism; a scale that is none is refused.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.command_line import run
from helpers.inside import read_robot
from symkin import MechanismError, Pose, ReadOptions, load

TETRAHEDRON = "v 0 0 0\nv 300 0 0\nv 0 200 0\nv 0 0 100\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
"""A mesh in millimetres, as an OBJ file."""
CORNERS = np.array([[0, 0, 0], [300, 0, 0], [0, 200, 0], [0, 0, 100]], dtype=float)
URDF = """<robot name='r'><link name='a'/>
<link name='b'><visual><origin xyz='0.1 0.2 0.3' rpy='0 0 1.5707963267948966'/><geometry>
<mesh filename='{file}' {scale}/></geometry></visual></link>
<link name='tip'><visual><geometry><mesh filename='tip.stl'/></geometry></visual></link>
<joint name='j' type='revolute'><parent link='a'/><child link='b'/><origin xyz='1 0 0'/>
<axis xyz='0 1 0'/></joint>
<joint name='f' type='fixed'><parent link='b'/><child link='tip'/><origin xyz='0 0 2'/></joint>
</robot>"""
SDF = """<sdf version='1.9'><model name='r'><link name='a'/><frame name='f' attached_to='b'>
<pose>0.1 0.2 0.3 0 0 0</pose></frame>
<link name='b'><pose>1 0 0 0 0 0</pose><visual name='v'>
<pose relative_to='f'>0 0 0 0 0 1.5707963267948966</pose><geometry>
<mesh><uri>{file}</uri>{scale}</mesh></geometry></visual></link>
<joint name='j' type='revolute'><parent>a</parent><child>b</child><axis><xyz>0 1 0</xyz></axis>
</joint></model></sdf>"""
MJCF = """<mujoco><asset><mesh name='m' file='{file}' {scale}/></asset>
<worldbody><body name='b' pos='1 0 0'><joint name='j' axis='0 1 0'/>
<geom type='mesh' mesh='m' pos='0.1 0.2 0.3' euler='0 0 90'/></body></worldbody></mujoco>"""
FORMATS = {
    "urdf": (URDF, "scale='{}'"),
    "sdf": (SDF, "<scale>{}</scale>"),
    "xml": (MJCF, "scale='{}'"),
}


def robot_file(
    folder: Path, suffix: str, file: str = "none.stl", scale: str = "0.001 0.001 0.002"
) -> Path:
    text, form = FORMATS[suffix]
    path = folder / f"r.{suffix}"
    path.write_text(text.format(file=file, scale=form.format(scale)), encoding="utf-8")
    return path


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_mesh_that_is_missing_is_kept_with_pose_and_scale(suffix: str, tmp_path: Path) -> None:
    """In the link's frame of the robot, and in the base frame of the mechanism: link b stands at
    (1, 0, 0).
    """
    if suffix == "xml":
        pytest.importorskip("mujoco")
    path = robot_file(tmp_path, suffix)
    (own,) = read_robot(path).meshes["b"]
    wanted = Pose.from_euler((0.1, 0.2, 0.3), (0, 0, np.pi / 2), "xyz")
    np.testing.assert_allclose(own.pose.matrix, wanted.matrix, atol=1e-15)
    mesh = next(mesh for mesh in load(path).link_meshes if mesh.link == "b")
    assert (mesh.file, mesh.scale) == ("none.stl", (0.001, 0.001, 0.002))
    np.testing.assert_allclose(
        mesh.pose.matrix, (Pose.from_euler((1, 0, 0), (0, 0, 0), "xyz") @ wanted).matrix, atol=1e-15
    )


def test_meshes_of_merged_links_stand_where_their_links_do(tmp_path: Path) -> None:
    tip = load(robot_file(tmp_path, "urdf")).link_meshes[-1]
    assert (tip.link, tip.file, tip.position) == ("b", "tip.stl", (1.0, 0.0, 2.0))


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("scale", ["0 1 1", "nan 1 1"])
def test_a_scale_that_is_none_is_refused_with_its_place(
    suffix: str, scale: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if suffix == "xml":
        pytest.importorskip("mujoco")
    status, _, err = run(capsys, "show", robot_file(tmp_path, suffix, scale=scale))
    assert status == 2
    assert f"r.{suffix}: line " in err
    assert "<mesh" in err or "<scale>" in err
    assert err.count("\n") == 1


def test_a_mesh_of_a_package_is_found(tmp_path: Path) -> None:
    package = tmp_path / "lib" / "parts"
    package.mkdir(parents=True)
    (package / "b.obj").write_text(TETRAHEDRON, encoding="utf-8")
    path = robot_file(tmp_path, "urdf", "package://parts/b.obj")
    assert read_robot(path).meshes["b"][0].file == "package://parts/b.obj"
    found = read_robot(path, ReadOptions(packages=[package.parent]))
    assert Path(found.meshes["b"][0].file).read_text(encoding="utf-8") == TETRAHEDRON


def test_meshes_change_nothing_of_the_mechanism(tmp_path: Path) -> None:
    """The mechanism is equal to, and writes the same file as, one without meshes; its file reads
    back to an equal one.
    """
    path = robot_file(tmp_path, "urdf")
    with_meshes = load(path)
    path.write_text(
        path.read_text(encoding="utf-8").replace("<mesh", "<box").replace("stl", "none"),
        encoding="utf-8",
    )
    without = load(path)
    assert len(with_meshes.link_meshes) == 2
    assert not without.link_meshes
    assert with_meshes == without
    assert hash(with_meshes) == hash(without)
    assert with_meshes.to_toml() == without.to_toml()
    output = tmp_path / "r.toml"
    output.write_text(with_meshes.to_toml(), encoding="utf-8")
    assert symkin.load(output) == with_meshes


@pytest.mark.parametrize(
    "more", ["", "refpos='20 -30 40'", "refpos='20 -30 40' refquat='0.8 0 0.6 0'"]
)
def test_vertices_stand_where_mujoco_has_them(more: str, tmp_path: Path) -> None:
    """The file's own numbers, scaled and placed by the reference, are the vertices of MuJoCo's
    model.
    """
    mujoco = pytest.importorskip("mujoco")
    (tmp_path / "b.obj").write_text(TETRAHEDRON, encoding="utf-8")
    path = robot_file(tmp_path, "xml", "b.obj", "0.001 0.001 0.001")
    path.write_text(
        path.read_text(encoding="utf-8").replace("name='m'", f"name='m' {more}"), encoding="utf-8"
    )
    (mesh,) = load(path).link_meshes
    found = np.array([mesh.pose.apply(np.array(mesh.scale) * corner) for corner in CORNERS])
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    vertices = np.array(model.mesh_vert) @ data.geom_xmat[0].reshape(3, 3).T + data.geom_xpos[0]
    for corner in found:
        assert np.min(np.linalg.norm(vertices - corner, axis=1)) < 1e-6
    assert len(vertices) == len(found)


def test_a_mesh_without_a_file_name_is_refused(tmp_path: Path) -> None:
    path = robot_file(tmp_path, "urdf", "")
    with pytest.raises(MechanismError, match=r"line 3: <mesh>: the attribute filename is empty"):
        load(path)
