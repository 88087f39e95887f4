"""Reading URDF: every joint type, mass, picture, mimic and tag, and each refusal."""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mecanique as mq
from mecanique.urdf.read import read_urdf
from mecanique.urdf.reading.packages import MeshSearch, OutsideError
from mecanique.urdf.robots import robot, robots
from mecanique.urdf.write import write_urdf

ARM = """<robot name="arm">
  <link name="base"/>
  <link name="upper">
    <inertial>
      <origin xyz="0.1 0 -0.2" rpy="0 0 1.5707963267948966"/>
      <mass value="2"/>
      <inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
  <joint name="shoulder" type="{type}">
    <origin xyz="0 0 1" rpy="0 0.5 0"/>
    <parent link="base"/>
    <child link="upper"/>
    <axis xyz="0 -2 0"/>
    <limit lower="-1" upper="2" effort="30" velocity="4"/>
    {more}
  </joint>
</robot>
"""


def arm(kind: str = "revolute", more: str = "") -> str:
    return ARM.replace("{type}", kind).replace("{more}", more)


def chain(joints: str, count: int, extra: str = "") -> str:
    """A chain of links l0 … lcount, of which all but the first weigh something."""
    mass = '<mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    links = "".join(
        f'<link name="l{k}">{f"<inertial>{mass}</inertial>" if k else ""}</link>\n'
        for k in range(count + 1)
    )
    return f'<robot name="chain">\n{links}{joints}{extra}</robot>'


def joint(
    k: int, more: str = '<axis xyz="0 0 1"/>', kind: str = "continuous", tag: str = "joint"
) -> str:
    ends = f'<parent link="l{k}"/><child link="l{k + 1}"/>'
    return f'<{tag} name="j{k}" type="{kind}">{ends}{more}</{tag}>\n'


def test_revolute_joint() -> None:
    mechanism = read_urdf(arm())
    (shoulder,) = mechanism.joints
    assert isinstance(shoulder, mq.Revolute)
    assert (shoulder.parent, shoulder.child) == ("base", "upper")
    assert shoulder.axis == (0, -1, 0)
    assert shoulder.origin == mq.Placement((0, 0, 1), (0, 0.5, 0))
    assert shoulder.limits == mq.Limits(-1, 2, 30, 4)
    assert tuple(mechanism.coordinates) == ("shoulder",)
    assert (mechanism.ground, mechanism.gravity) == ("base", (0, 0, -9.81))


def test_inertia_is_turned_into_the_axes_of_the_link() -> None:
    body = read_urdf(arm()).body("upper")
    assert (body.mass, body.center) == (2, (0.1, 0, -0.2))
    assert body.inertia == (0.03, 0.02, 0.04, 0, 0, 0)


@pytest.mark.parametrize(
    ("kind", "expected", "coordinates"),
    [
        ("continuous", mq.Revolute, ("shoulder",)),
        ("prismatic", mq.Prismatic, ("shoulder",)),
        ("fixed", mq.Fixed, ()),
        ("planar", mq.Planar, ("shoulder_x", "shoulder_y", "shoulder_theta")),
        (
            "floating",
            mq.Floating,
            tuple(f"shoulder_{c}" for c in ("x", "y", "z", "qx", "qy", "qz", "qw")),
        ),
    ],
)
def test_joint_types(kind: str, expected: type, coordinates: tuple[str, ...]) -> None:
    mechanism = read_urdf(arm(kind))
    assert type(mechanism.joints[0]) is expected
    assert tuple(mechanism.coordinates) == coordinates


def test_planar_joint_keeps_its_axis() -> None:
    (shoulder,) = read_urdf(arm("planar")).joints
    assert isinstance(shoulder, mq.Planar)
    assert shoulder.axis == (0, -1, 0)


@pytest.mark.parametrize(
    ("kind", "expected"),
    [("ball", mq.Spherical), ("universal", mq.Universal), ("planar", mq.Planar)],
)
def test_drake_joints(kind: str, expected: type) -> None:
    mechanism = read_urdf(chain(joint(0, "", kind, "drake:joint"), 1))
    assert type(mechanism.joints[0]) is expected
    if isinstance(mechanism.joints[0], mq.Planar):
        assert mechanism.joints[0].axis == (0, 0, 1)


def test_floating_root_adds_a_world() -> None:
    mechanism = read_urdf(arm(), root="floating")
    root = mechanism.joints[0]
    assert isinstance(root, mq.Floating)
    assert (root.name, root.parent, root.child) == ("root_joint", "world", "base")
    assert (mechanism.nq, mechanism.nv, mechanism.ground) == (8, 7, "world")


def test_floating_root_of_a_link_called_world() -> None:
    mechanism = read_urdf('<robot name="r"><link name="world"/></robot>', root="floating")
    assert mechanism.ground == "world_2"


def test_gravity_and_arguments() -> None:
    assert read_urdf(arm(), gravity=(0, -1.62, 0)).gravity == (0, -1.62, 0)
    with pytest.raises(
        mq.InputError, match="expected 'fixed' or 'floating' for the root, got 'free'"
    ):
        read_urdf(arm(), root="free")  # type: ignore[arg-type]  # it is the refusal that is tested
    with pytest.raises(mq.InputError, match="expected three components for gravity"):
        read_urdf(arm(), gravity=(0, 0))
    with pytest.raises(mq.InputError, match="path of a URDF file or its text, got ''"):
        read_urdf("")
    with pytest.raises(mq.InputError, match="got 3"):
        read_urdf(3)  # type: ignore[arg-type]  # it is the refusal that is tested
    with pytest.raises(mq.UrdfError, match="gravity is not finite"):
        read_urdf(arm(), gravity=(0, 0, math.nan))


def test_damping_becomes_a_damper_and_dry_friction_is_told() -> None:
    mechanism = read_urdf(arm(more='<dynamics damping="0.7" friction="3"/>'))
    assert mechanism.forces == (mq.JointDamper("shoulder_damper", "shoulder", 0.7),)
    assert mechanism.about == "Read from URDF, without dry friction of shoulder."


def test_unbounded_limits() -> None:
    joints = joint(
        0,
        '<axis xyz="0 0 1"/><limit lower="-1e9" upper="1e16" effort="1e9" velocity="2"/>',
        "revolute",
    )
    (first,) = read_urdf(chain(joints, 1)).joints
    assert isinstance(first, mq.Revolute)
    assert first.limits == mq.Limits(-math.inf, math.inf, math.inf, 2)


def test_mimic_in_any_order_and_in_chains() -> None:
    first = '<axis xyz="0 0 1"/><mimic joint="j1" multiplier="2" offset="0.5"/>'
    second = '<axis xyz="0 0 1"/><mimic joint="j2" multiplier="-3" offset="1"/>'
    mechanism = read_urdf(chain(joint(0, first) + joint(1, second) + joint(2), 3))
    assert tuple(mechanism.coordinates) == ("j2",)
    driven = mechanism.coordinates.driven
    values = {"j2": 0.3}
    assert float(driven["j1"].subs(values)) == pytest.approx(-3 * 0.3 + 1, abs=1e-15)
    assert float(driven["j0"].subs(values)) == pytest.approx(2 * (-3 * 0.3 + 1) + 0.5, abs=1e-15)


def test_mimic_with_multiplier_zero_is_a_constant() -> None:
    still = '<axis xyz="0 0 1"/><mimic joint="j1" multiplier="0" offset="0.5"/>'
    assert read_urdf(chain(joint(0, still) + joint(1), 2)).coordinates.driven == {"j0": 0.5}


def test_joints_called_like_other_coordinates() -> None:
    text = chain(joint(0, kind="planar") + joint(1) + joint(2), 3)
    text = text.replace('"j0"', '"p"').replace('"j1"', '"p_x"').replace('"j2"', '"t"')
    mechanism = read_urdf(text)
    assert tuple(mechanism.coordinates) == ("p_x", "p_y", "p_theta", "p_x_2", "t_2")
    assert [j.name for j in mechanism.joints] == ["p", "p_x", "t"]


def test_visuals(tmp_path: Path) -> None:
    visuals = """<visual name="a"><origin xyz="1 2 3"/><geometry><box size="1 2 3"/></geometry>
      <material name="red"/></visual>
    <visual><geometry><cylinder radius="1" length="2"/></geometry>
      <material name="own"><color rgba="0 1 0 1"/></material></visual>
    <visual><geometry><sphere radius="1"/></geometry></visual>
    <visual><geometry><mesh filename="shape.stl" scale="1 1 2"/></geometry></visual>"""
    text = f"""<robot name="r"><material name="red"><color rgba="1 0 0 0.5"/></material>
    <link name="base">{visuals}</link></robot>"""
    (tmp_path / "shape.stl").write_text("solid", encoding="utf-8")
    (tmp_path / "robot.urdf").write_text(text, encoding="utf-8")
    a, b, c, d = read_urdf(tmp_path / "robot.urdf").body("base").visuals
    assert a == mq.Visual(mq.Box((1, 2, 3)), mq.Placement((1, 2, 3)), (1, 0, 0, 0.5), "a")
    assert b == mq.Visual(mq.Cylinder(1, 2), rgba=(0, 1, 0, 1))
    assert c == mq.Visual(mq.Sphere(1))
    assert d == mq.Visual(mq.Mesh("shape.stl", tmp_path / "shape.stl", (1, 1, 2)))


def _mesh(tmp_path: Path, uri: str, **arguments: str) -> mq.Mesh:
    file = tmp_path / "here" / "robot.urdf"
    file.parent.mkdir(exist_ok=True)
    visual = f'<visual><geometry><mesh filename="{uri}"/></geometry></visual>'
    file.write_text(f'<robot name="r"><link name="base">{visual}</link></robot>', encoding="utf-8")
    geometry = read_urdf(file, **arguments).body("base").visuals[0].geometry  # type: ignore[arg-type]  # strings fit
    assert isinstance(geometry, mq.Mesh)
    return geometry


def test_mesh_search(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    package = tmp_path / "elsewhere" / "things"
    package.mkdir(parents=True)
    (package / "a.STL").write_text("solid", encoding="utf-8")
    uri = "package://things/a.STL"
    assert _mesh(tmp_path, uri) == mq.Mesh(uri, None)
    assert _mesh(tmp_path, uri, package_path=str(package.parent)).path == package / "a.STL"
    assert _mesh(tmp_path, uri, package_path=str(package)).path == package / "a.STL"
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"/nowhere:{package.parent}")
    assert _mesh(tmp_path, uri).path == package / "a.STL"
    assert _mesh(tmp_path, f"file://{package}/a.STL").path == package / "a.STL"


def test_packages_around_the_file_are_searched(tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "a.dae").write_text("<x/>", encoding="utf-8")
    assert (
        _mesh(tmp_path, f"package://{tmp_path.name}/meshes/a.dae").path
        == tmp_path / "meshes" / "a.dae"
    )
    assert _mesh(tmp_path, "package://meshes/a.dae").path == tmp_path / "meshes" / "a.dae"
    (tmp_path / "package.xml").write_text("<package/>", encoding="utf-8")
    assert _mesh(tmp_path, "../meshes/a.dae").path == tmp_path / "meshes" / "a.dae"


@pytest.mark.parametrize(
    "uri",
    [
        "package://things/../../secret.stl",
        "package://../secret.stl",
        "../../secret.stl",
        "..\\..\\secret.stl",
        "file://../../secret.stl",
        "model://a/b/../../../secret.stl",
    ],
)
def test_mesh_paths_that_climb_are_never_opened(tmp_path: Path, uri: str) -> None:
    (tmp_path.parent / "secret.stl").write_text("solid", encoding="utf-8")
    assert _mesh(tmp_path, uri).path is None


def test_no_absolute_path_stands_in_a_package(tmp_path: Path) -> None:
    (tmp_path / "things").mkdir()
    secret = tmp_path / "secret.stl"
    secret.write_text("solid", encoding="utf-8")
    assert _mesh(tmp_path, f"package://things/{secret}").path is None
    (tmp_path / "things" / "a.stl").write_text("solid", encoding="utf-8")
    assert _mesh(tmp_path, "package://things//a.stl").path == tmp_path / "things" / "a.stl"


@pytest.mark.parametrize("uri", ["package://things/C:/secret.stl", "package://C:/secret.stl"])
def test_no_drive_of_windows_stands_in_a_package(tmp_path: Path, uri: str) -> None:
    with pytest.raises(OutsideError):
        MeshSearch(tmp_path / "a.urdf").find(uri)


def test_other_files_are_never_opened(tmp_path: Path) -> None:
    (tmp_path / "here").mkdir()
    (tmp_path / "here" / "secret.txt").write_text("secret", encoding="utf-8")
    (tmp_path / "secret.stl").write_text("solid", encoding="utf-8")
    for uri in (
        "secret.txt",
        str(tmp_path / "secret.stl"),
        "http://x.example/a.stl",
        "/etc/passwd",
        "a" * 5000,
    ):
        assert _mesh(tmp_path, uri).path is None


SPRING = """<drake:linear_spring_damper>
  <drake:linear_spring_damper_body_A name="l0"/><drake:linear_spring_damper_p_AP value="1 2 3"/>
  <drake:linear_spring_damper_body_B name="l1"/><drake:linear_spring_damper_p_BQ value="4 5 6"/>
  <drake:linear_spring_damper_free_length value="0.5"/>
  <drake:linear_spring_damper_stiffness value="8"/>\
<drake:linear_spring_damper_damping value="0.25"/>
</drake:linear_spring_damper>
"""


def test_drake_springs_and_dampers() -> None:
    points = "l0", (1, 2, 3), "l1", (4, 5, 6)
    mechanism = read_urdf(chain(joint(0), 1, SPRING + SPRING))
    assert mechanism.forces == (
        mq.Spring("l0_l1_spring", *points, 8, 0.5),
        mq.Damper("l0_l1_damper", *points, 0.25),
        mq.Spring("l0_l1_spring_2", *points, 8, 0.5),
        mq.Damper("l0_l1_damper_2", *points, 0.25),
    )


def test_drake_loops() -> None:
    ball = SPRING.replace("linear_spring_damper", "ball_constraint")
    rod = SPRING.replace("linear_spring_damper", "distance_constraint").replace(
        "free_length", "distance"
    )
    mechanism = read_urdf(chain(joint(0), 1, ball + rod))
    points = "l0", (1, 2, 3), "l1", (4, 5, 6)
    assert mechanism.loops == (
        mq.Loop.ball("l0_l1_ball", *points),
        mq.Loop.distance("l0_l1_rod", *points, 0.5),
    )


KINDS = {
    "hinge": mq.Loop.hinge("l", "l0", (1, 0, 0), "l1", (0, 0.5, 0), (0, 1, 0), (0, 0, 1)),
    "weld": mq.Loop.weld(
        "l", "l0", mq.Placement((1, 2, 3), (0.1, 0.2, 0.3)), "l1", mq.Placement((0, 0, 1))
    ),
    "pin": mq.Loop.pin("l", "l0", (1, 0, 0), "l1", (0, 0.5, 0)),
    "plate": mq.Loop.plate("l", "l0", (1, 0, 0), "l1", (0, 0.5, 0), (0, 0.6, 0.8)),
}


@pytest.mark.parametrize("kind", KINDS)
def test_our_own_loops_are_read_as_they_were_written(kind: str) -> None:
    mechanism = replace(read_urdf(chain(joint(0), 1, "")), loops=(KINDS[kind],))
    assert read_urdf(write_urdf(mechanism)).loops == mechanism.loops


LOOP = (
    """<mecanique:loop name="l" type="{kind}"><mecanique:frame_a link="{a}"/>{b}</mecanique:loop>"""
)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"kind": "ring"}, "expected a type among hinge, weld, pin, plate, got 'ring'"),
        ({"a": "wall"}, "'wall' is no link"),
        ({"a": "l1"}, "both of its ends are on link 'l1'"),
        ({"b": ""}, "it has no <mecanique:frame_b>"),
    ],
)
def test_faults_of_our_own_loops_are_told(given: dict[str, str], message: str) -> None:
    values = {"kind": "pin", "a": "l0", "b": '<mecanique:frame_b link="l1" xyz="1 0 0"/>', **given}
    with pytest.raises(mq.UrdfError, match=message):
        read_urdf(chain(joint(0), 1, LOOP.format(**values)))


BUSHING = """<frame name="A" link="l0" xyz="{a}" rpy="{turn_a}"/>\
<frame name="C" link="l1" rpy="{turn_c}" xyz="{c}"/>
<drake:linear_bushing_rpy><drake:bushing_frameA name="A"/><drake:bushing_frameC name="C"/>
<drake:bushing_torque_stiffness value="1 2 3"/><drake:bushing_torque_damping value="4 5 6"/>
<drake:bushing_force_stiffness value="10 20 30"/><drake:bushing_force_damping value="40 50 60"/>
</drake:linear_bushing_rpy>
"""


def bushing(
    a: str = "0 0 1", c: str = "0 0 0", turn_a: str = "0 0 0", turn_c: str = "0 0 0"
) -> str:
    return BUSHING.format(a=a, c=c, turn_a=turn_a, turn_c=turn_c)


@pytest.mark.parametrize(
    ("kind", "axis", "frames", "stiffness", "damping", "reference"),
    [
        ("continuous", "1 0 0", bushing(), 1, 4, 0),
        ("continuous", "0 -1 0", bushing(), 2, 5, 0),
        ("continuous", "0 0 1", bushing(turn_a="0 0 0.4"), 3, 6, 0.4),
        ("continuous", "0 0 -1", bushing(turn_c="0 0 0.3"), 3, 6, 0.3),
        ("prismatic", "0 1 0", bushing(c="0 0.25 0"), 20, 50, -0.25),
        ("prismatic", "-1 0 0", bushing(a="0.5 0 1"), 10, 40, -0.5),
    ],
)
def test_bushing_as_a_joint_spring(
    kind: str, axis: str, frames: str, stiffness: float, damping: float, reference: float
) -> None:
    limit = '<limit effort="1" velocity="1" lower="-1" upper="1"/>'
    more = f'<origin xyz="0 0 1"/><axis xyz="{axis}"/>{limit}'
    spring, damper = read_urdf(chain(joint(0, more, kind), 1, frames)).forces
    assert isinstance(spring, mq.JointSpring)
    assert (spring.name, spring.joint, spring.stiffness) == ("j0_spring", "j0", stiffness)
    assert spring.reference == pytest.approx(reference, abs=1e-15)
    assert damper == mq.JointDamper("j0_damper", "j0", damping)


@pytest.mark.parametrize(
    ("frames", "message"),
    [
        (bushing(a="0 0 0"), "do not coincide"),
        (bushing(a="0 0.1 1", c="0 0.1 0"), "do not coincide on the axis"),
        (bushing(turn_a="0.3 0 0", turn_c="0.3 0 0"), "no axis of its frame"),
        (bushing(turn_c="0.3 0 0"), "differ by a turn"),
        (bushing().replace('link="l1"', 'link="l2"'), "no revolute or prismatic joint"),
    ],
)
def test_bushing_that_is_no_joint_spring(frames: str, message: str) -> None:
    more = '<origin xyz="0 0 1"/><axis xyz="0 0 1"/>'
    with pytest.raises(mq.UrdfError, match=message):
        read_urdf(chain(joint(0, more) + joint(1), 2, frames))


def rotor(
    inertia: str = "0.5", ratio: str = '<drake:gear_ratio value="-4"/>', name: str = "j0"
) -> str:
    return f"""<transmission><type>transmission_interface/SimpleTransmission</type>\
<joint name="{name}"/>
    <actuator name="m"><drake:rotor_inertia value="{inertia}"/>{ratio}</actuator></transmission>"""


def test_rotor_inertia_counts_by_the_ratio_squared() -> None:
    (first,) = read_urdf(chain(joint(0), 1, rotor() + rotor(ratio=""))).joints
    assert isinstance(first, mq.Revolute)
    assert first.armature == 0.5 * 16 + 0.5


def test_all_errors_are_told_at_once() -> None:
    text = (
        arm()
        .replace('value="2"', 'value="2kg"')
        .replace('"0 -2 0"', '"0 0 0"')
        .replace('"base"/>', '"bas"/>', 1)
    )
    with pytest.raises(mq.UrdfError) as caught:
        read_urdf(text)
    lines = str(caught.value).splitlines()
    assert lines[0] == "3 errors:"
    assert (
        lines[1]
        == "  line 6: link 'upper': expected a finite number for value of <mass>, got '2kg'"
    )
    assert lines[2] == "  line 10: joint 'shoulder': its parent 'base' is no link"
    assert lines[3] == "  line 14: joint 'shoulder': its axis '0 0 0' has no length"


def test_an_error_names_file_and_line(tmp_path: Path) -> None:
    file = tmp_path / "arm.urdf"
    file.write_text(arm("hinge"), encoding="utf-8")
    with pytest.raises(
        mq.UrdfError, match=r"arm\.urdf:10: joint 'shoulder': expected a type among revolute"
    ) as caught:
        read_urdf(file)
    assert (caught.value.file, caught.value.line) == (str(file), 10)


def test_many_errors_are_counted() -> None:
    text = '<robot name="r"><link name="l"/>\n' + '<joint name="a"/>\n' * 100 + "</robot>"
    with pytest.raises(mq.UrdfError, match=r"300 errors:(?s:.*)… and 260 more"):
        read_urdf(text)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_encodings(tmp_path: Path, encoding: str) -> None:
    file = tmp_path / "Rösti.urdf"
    file.write_bytes('<robot name="π-Arm"><link name="Füße 手"/></robot>'.encode(encoding))
    assert read_urdf(file).ground == "Füße 手"


def test_a_declared_encoding_does_not_matter_in_a_text() -> None:
    assert (
        read_urdf(
            '<?xml version="1.0" encoding="latin-1"?><robot name="é"><link name="a"/></robot>'
        ).name
        == "é"
    )


def test_devices_and_folders_are_not_read(tmp_path: Path) -> None:
    for path in (tmp_path, Path("/dev/zero")):
        with pytest.raises(mq.UrdfError, match="no file but a folder or device"):
            read_urdf(path)
    with pytest.raises(mq.UrdfError, match="No such file"):
        read_urdf("missing.urdf")


def test_numbers_need_no_sympy() -> None:
    code = (
        "import sys\nfrom mecanique.urdf.read import read_urdf\n"
        "from mecanique.urdf.robots import robot\n"
        "read_urdf(robot('kinova'))\nprint(*({'sympy', 'scipy', 'pinocchio'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, encoding="utf-8", check=True
    )
    assert not done.stdout.strip()


@pytest.mark.slow
def test_long_chains_and_long_mimic_chains() -> None:
    count = 5000
    mechanism = read_urdf(chain("".join(joint(k) for k in range(count)), count))
    assert [j.name for j in mechanism.tree] == [f"j{k}" for k in range(count)]
    count = 2000
    follow = "".join(
        joint(k, f'<axis xyz="0 0 1"/><mimic joint="j{k - 1}"/>' if k else "") for k in range(count)
    )
    assert tuple(read_urdf(chain(follow, count)).coordinates) == ("j0",)


REFUSED = {
    "alex_psyonic_hands": "it mimics 'index_q1', which is no joint",
    "ur3": "the robot has no link",
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_robot_or_unclear_is_refused(name: str) -> None:
    with pytest.raises(mq.UrdfError, match=REFUSED[name]):
        read_urdf(robot(name))


FLAWED = {
    "alex_psyonic_hands": "it mimics 'index_q1', which is no joint",
    "allegro_left_hand": "break the triangle inequality",
    "allegro_right_hand": "break the triangle inequality",
    "anymal-kinova": "break the triangle inequality",
    "anymal_b_simple/anymal": "break the triangle inequality",
    "anymal_c_simple/anymal": "break the triangle inequality",
    "b1": "break the triangle inequality",
    "b1-z1": "break the triangle inequality",
    "go1": "break the triangle inequality",
    "hyq_no_sensors": "break the triangle inequality",
    "pr2": "break the triangle inequality",
    "romeo_laas_small": "negative principal moment",
    "romeo_small": "break the triangle inequality",
    "tiago": "negative principal moment",
    "tiago_dual": "negative principal moment",
    "tiago_no_hand": "negative principal moment",
}
"""What only a strict reader refuses."""


def poses(mechanism: mq.Mechanism, r: dict[str, float]) -> dict[str, np.ndarray]:
    """Where each body is, for joints with one coordinate: Rodrigues' formula along the tree."""
    placed = {mechanism.ground: np.eye(4)}
    for j in mechanism.tree:
        step = np.eye(4)
        step[:3, :3], step[:3, 3] = j.origin.rotation, j.origin.xyz
        motion = np.eye(4)
        if isinstance(j, mq.Revolute):
            x, y, z = j.axis
            k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
            angle = r[j.coordinate]
            motion[:3, :3] += math.sin(angle) * k + (1 - math.cos(angle)) * k @ k
        elif isinstance(j, mq.Prismatic):
            motion[:3, 3] = r[j.coordinate] * np.array(j.axis)
        placed[j.child] = placed[j.parent] @ step @ motion
    return placed


@pytest.mark.engine
@pytest.mark.parametrize("name", [name for name in robots() if name not in REFUSED])
def test_every_robot_is_read_as_by_pinocchio(name: str) -> None:
    import pinocchio as pin

    if name in FLAWED:
        with pytest.raises(mq.UrdfError, match=FLAWED[name]):
            read_urdf(robot(name), strict=True)
    mechanism = read_urdf(robot(name), strict=name not in FLAWED)
    assert mechanism.origin is not None
    assert bool(mechanism.origin.flaws) == (name in FLAWED)
    model = pin.buildModelFromUrdf(str(robot(name)))
    rng = np.random.default_rng(0)
    q, r = pin.neutral(model), {}
    for j in mechanism.joints:
        if isinstance(j, (mq.Revolute, mq.Prismatic)):
            there = model.joints[model.getJointId(j.name)]
            r[j.coordinate] = angle = float(rng.uniform(-1, 1))
            q[there.idx_q : there.idx_q + there.nq] = (
                angle if there.nq == 1 else (math.cos(angle), math.sin(angle))
            )
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    placed = poses(mechanism, r)
    for body in mechanism.bodies:
        there = data.oMf[model.getFrameId(body.name, pin.FrameType.BODY)].homogeneous
        assert placed[body.name] == pytest.approx(there, abs=1e-12)
    # mass, first moment and inertia of everything about the world's origin, in this position
    ours = sum(_spatial(body, placed[body.name]) for body in mechanism.bodies)
    theirs = sum(data.oMi[k].act(inertia).matrix() for k, inertia in enumerate(model.inertias))
    assert ours == pytest.approx(theirs, abs=1e-9 * max(1.0, np.abs(theirs).max()))


def _spatial(body: mq.Body, pose: np.ndarray) -> np.ndarray:
    """Spatial inertia about the world's origin, linear first.

    R. Featherstone, Rigid Body Dynamics Algorithms, 2008.
    """
    ixx, iyy, izz, ixy, ixz, iyz = body.inertia
    turned = (
        pose[:3, :3]
        @ np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
        @ pose[:3, :3].T
    )
    x, y, z = pose[:3, :3] @ np.array(body.center) + pose[:3, 3]
    c = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    m = body.mass
    return np.block([[m * np.eye(3), -m * c], [m * c, turned + m * c @ c.T]])
