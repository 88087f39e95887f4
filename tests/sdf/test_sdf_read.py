"""SDF without another engine: the same robot stated in other words, loops, files, refusals."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from test_sdf_drake import MASS, ROOT, TWO, A, B, dynamics, joint, link, model

import mecanique as mq
from mecanique.cli import app
from mecanique.formats.sdf import read_sdf
from mecanique.model.bodies.tensor import tensor_of
from mecanique.model.placement import pose_of

PLAIN = model(TWO + joint("r", "a", "b", "<axis><xyz>0 1 0</xyz></axis>"))


def test_a_pendulum_has_its_closed_form() -> None:
    text = model(
        '<link name="a"><pose>0 0 -0.5 0 0 0</pose><inertial><mass>3</mass><inertia><ixx>0.1</ixx>'
        "<iyy>0.2</iyy><izz>0.1</izz></inertia></inertial></link>"
        + joint("q", "world", "a", "<axis><xyz>0 1 0</xyz></axis>", "<pose>0 0 0.5 0 0 0</pose>")
    )
    engine = mq.Reference(mq.read(text))
    assert engine.mass_matrix([0.3]).item() == pytest.approx(0.2 + 3 * 0.25, rel=1e-14)
    bias = engine.bias([0.3], [0.0])
    assert bias == pytest.approx([3 * 9.81 * 0.5 * np.sin(0.3)], rel=1e-14)


@pytest.mark.parametrize(
    "text",
    [
        model(
            A
            + '<frame name="f"><pose>0.5 0.1 1 0.4 0 0.2</pose></frame>'
            + link("b", '<pose relative_to="f"/>')
            + ROOT
            + joint("r", "a", "b", "<axis><xyz>0 1 0</xyz></axis>")
        ),
        model(TWO + joint("r", "a", "b", '<axis><xyz expressed_in="b">0 1 0</xyz></axis>')),
        model(TWO + joint("r", "a", "b", "<axis><xyz>0 7 0</xyz></axis>")),
        model(
            TWO
            + '<frame name="f" attached_to="b"/>'
            + joint("r", "a", "f", "<axis><xyz>0 1 0</xyz></axis>")
        ),
    ],
)
def test_frames_say_the_same_in_other_words(text: str) -> None:
    plain, stated = (mq.Reference(read_sdf(each)) for each in (PLAIN, text))
    q, v = [0.4, -0.7], [1.3, 0.6]
    assert stated.mass_matrix(q) == pytest.approx(plain.mass_matrix(q), rel=1e-13)
    assert stated.bias(q, v) == pytest.approx(plain.bias(q, v), rel=1e-13)


@pytest.mark.parametrize(
    ("kind", "loop"), [("revolute", "hinge"), ("ball", "ball"), ("fixed", "weld")]
)
def test_a_second_joint_closes_a_loop_where_the_file_shows_it(kind: str, loop: str) -> None:
    second = joint("c", "world", "b").replace("revolute", kind)
    mechanism = read_sdf(model(TWO + joint("r", "a", "b") + second))
    (closure,) = mechanism.loops
    assert closure.kind == loop
    engine = mq.Reference(mechanism)
    poses = [
        engine.pose(body, [0.0, 0.0]) @ pose_of(frame)
        for body, frame in (
            (closure.body_a, closure.frame_a),
            (closure.body_b, closure.frame_b),
        )
    ]
    gap = poses[0][:3, 3] - poses[1][:3, 3]
    assert np.abs(gap).max() < 1e-14
    if kind != "ball":
        assert np.abs(poses[0][:3, 2] - poses[1][:3, 2]).max() < 1e-14


@pytest.mark.parametrize("kind", ["revolute", "prismatic", "ball"])
def test_a_joint_with_a_spring_or_damper_may_close_a_loop(kind: str) -> None:
    bars = "".join(
        link(name, f"<pose>{at} 0 0 0</pose>")
        for name, at in (("a", "0 0 0"), ("b", "0 0 1"), ("c", "1.2 0 1"))
    )
    stated = "<damping>2</damping>"
    stated += "" if kind == "ball" else "<spring_stiffness>30</spring_stiffness>"
    axis = "<axis><xyz>0 1 0</xyz></axis>"
    along = dynamics(stated).replace("0 1 0", "1 0 0" if kind == "prismatic" else "0 1 0")
    loaded = joint("s", "b", "c", along).replace("revolute", kind)
    plain = joint("u", "world", "c", axis, "<pose>-0.2 0 -1 0 0 0</pose>")
    chain = bars + joint("p", "world", "a", axis) + joint("r", "a", "b", axis)
    answers = []
    for text in (chain + loaded + plain, chain + plain + loaded):
        mechanism = read_sdf(model(text))
        assert mq.degrees_of_freedom(mechanism).N == 1
        engine, home = mq.Reference(mechanism), mechanism.neutral()
        *_, free = np.linalg.svd(engine.constraint_jacobian(home))
        first = mechanism.velocities.index("p'")
        v = free[-1] / free[-1][first]
        answers.append(engine.acceleration(home, v)[first])
    assert answers[0] == pytest.approx(answers[1], rel=1e-11)
    still = read_sdf(model(chain + plain + loaded.replace(stated, "")))
    assert len(still.loops) == 1
    assert mq.verify(mechanism, samples=3).agrees


@pytest.mark.parametrize("also", ["", "<name>arm</name><sdf>arm.sdf</sdf>"])
def test_a_model_whose_file_is_not_there_is_told_with_the_file(tmp_path: Path, also: str) -> None:
    (tmp_path / "arm").mkdir()
    if also:
        (tmp_path / "arm" / "model.config").write_text(f"<model>{also}</model>", "utf-8")
    main = tmp_path / "main" / "m.sdf"
    main.parent.mkdir()
    main.write_text(model("<include><uri>model://arm</uri></include>"), "utf-8")
    missing = tmp_path / "arm" / ("arm.sdf" if also else "model.sdf")
    said = f"m.sdf:1: the model 'model://arm' would be {missing}: there is no such file; put it"
    with pytest.raises(mq.InputError, match=re.escape(said)):
        read_sdf(main)


def test_a_joint_may_be_called_as_time_is() -> None:
    loaded = dynamics("<damping>2</damping><spring_stiffness>3</spring_stiffness>")
    text = model(TWO + joint("{}", "a", "b", loaded))
    plain, named = (read_sdf(text.format(name)) for name in ("r", "t"))
    assert named.coordinates.names == ("q", "t_2")
    q, v = [0.4, -0.7], [1.3, 0.6]
    accelerations = [mq.Reference(each).acceleration(q, v) for each in (plain, named)]
    assert accelerations[0].tolist() == accelerations[1].tolist()


def test_a_mimic_follows_from_its_reference() -> None:
    axis = (
        '<axis><xyz>0 1 0</xyz><mimic joint="q"><multiplier>3</multiplier><offset>0.5</offset>'
        "<reference>0.2</reference></mimic></axis>"
    )
    mechanism = read_sdf(model(TWO + joint("r", "a", "b", axis)))
    assert mechanism.nv == 1
    law = mechanism.coordinates.driven["r"]
    assert float(law.subs({"q": 0.7})) == pytest.approx(2.0, rel=1e-14)


def test_mimics_of_mimics_follow_the_joint_that_moves() -> None:
    def follow(leader: str) -> str:
        law = "<multiplier>2</multiplier><offset>0.1</offset><reference>0.3</reference>"
        return f'<axis><xyz>0 1 0</xyz><mimic joint="{leader}">{law}</mimic></axis>'

    third = link("c", '<pose relative_to="b">0 0 1 0 0 0</pose>')
    parts = TWO + third + joint("s", "b", "c", follow("r"))
    mechanism = read_sdf(model(parts + joint("r", "a", "b", follow("q"))))
    at = mechanism.coordinates.driven["s"].subs({"q": 0.7})
    assert float(at) == pytest.approx(2 * (2 * 0.4 + 0.1 - 0.3) + 0.1, rel=1e-14)
    with pytest.raises(mq.InputError, match="would follow itself"):
        read_sdf(model(parts + joint("r", "a", "b", follow("s"))))


def test_an_inertia_of_no_real_body_is_read_as_given_and_told() -> None:
    moments = "<ixx>0.1</ixx><iyy>0.2</iyy><izz>0.9</izz>"
    inertial = f"<inertial><mass>2</mass><inertia>{moments}</inertia></inertial>"
    mechanism = read_sdf(model(f'<link name="a">{inertial}</link>' + ROOT))
    tensor = tensor_of(mechanism.evaluate_all(mechanism.bodies[1].inertia))
    assert np.linalg.eigvalsh(tensor) == pytest.approx([0.1, 0.2, 0.9], rel=1e-14)
    assert "Body 'a': its principal moments break the triangle inequality" in mechanism.about


def test_a_link_without_gravity_weighs_nothing() -> None:
    text = model(A.replace("</link>", "<gravity>0</gravity></link>") + ROOT)
    assert read_sdf(text).about == "<gravity> of a is off, which Drake ignores."
    engine = mq.Reference(read_sdf(text))
    assert np.abs(engine.inverse_dynamics([0.3], [0.0], [0.0])).max() < 1e-14


def test_comments_may_hold_hyphens_and_places_stay() -> None:
    text = model(f"<!-- gz sim --record -->\n<!---->{A}").replace(
        "<model", "<world name='w'><actor name='b'/><!-- -- --><model"
    )
    mechanism = read_sdf(text.replace("</sdf>", "</world></sdf>"))
    assert mechanism.nv == 6
    assert mq.read("<mujoco><!-- a -- b --><worldbody/></mujoco>").nv == 0
    with pytest.raises(mq.InputError, match="line 3: <cat> in <model>"):
        read_sdf(model("<!-- --\n-- -->\n<cat/>"))
    with pytest.raises(mq.UrdfError, match="not well-formed"):
        mq.read("<robot name='a'><!-- a -- b --><link name='b'/></robot>")


def test_a_capsule_is_drawn_as_a_cylinder_between_two_balls() -> None:
    shape = "<capsule><radius>0.1</radius><length>0.4</length></capsule>"
    visual = f'<visual name="v"><pose>1 0 0 0 0 0</pose><geometry>{shape}</geometry></visual>'
    drawn = read_sdf(model(f'<link name="a">{MASS}{visual}</link>')).bodies[1].visuals
    assert [(each.geometry, each.placement.xyz) for each in drawn] == [
        (mq.Cylinder(0.1, 0.4), (1.0, 0.0, 0.0)),
        (mq.Sphere(0.1), (1.0, 0.0, 0.2)),
        (mq.Sphere(0.1), (1.0, 0.0, -0.2)),
    ]


def test_models_are_included_from_files(tmp_path: Path) -> None:
    folder = tmp_path / "parts" / "arm"
    folder.mkdir(parents=True)
    (folder / "model.sdf").write_text(model(B), encoding="utf-8")
    main = tmp_path / "robot.sdf"
    text = model(
        A
        + ROOT
        + "<include><uri>parts/arm</uri><name>n</name><pose>0 0 1 0 0.2 0</pose></include>"
        + joint("r", "a", "n::b")
    )
    main.write_text(text, encoding="utf-8")
    nested = f'<model name="n"><pose>0 0 1 0 0.2 0</pose>{B}</model>'
    same = read_sdf(model(A + ROOT + nested + joint("r", "a", "n::b")))
    assert read_sdf(main) == same
    (folder / "model.sdf").rename(folder / "arm-1_10.sdf")
    for old in ("a.sdf", "arm-1_9.sdf"):
        (folder / old).write_text(model(A), encoding="utf-8")
    named = "".join(f'<sdf version="1.{k}">arm-1_{k}.sdf</sdf>' for k in (9, 10))
    (folder / "model.config").write_text(f"<model>{named}</model>", encoding="utf-8")
    assert read_sdf(main) == same
    for other in ("model.config", "a.sdf", "arm-1_9.sdf"):
        (folder / other).unlink()
    main.write_text(text.replace("parts/arm", "model://arm"), encoding="utf-8")
    assert read_sdf(main, package_path=tmp_path / "parts") == same
    main.write_text(text.replace("parts/arm", "robot.sdf"), encoding="utf-8")
    with pytest.raises(mq.InputError, match="models are nested deeper than 20"):
        read_sdf(main)
    (folder / "arm-1_10.sdf").rename(folder / "model.sdf")
    (folder / "model.sdf").write_text(model("\n<cat/>"), encoding="utf-8")
    main.write_text(text, encoding="utf-8")
    said = re.escape(f"{folder / 'model.sdf'}:2: <cat> in <model> is not read")
    with pytest.raises(mq.InputError, match=said):
        read_sdf(main)


def test_an_included_model_merges_into_the_one_that_includes_it(tmp_path: Path) -> None:
    inside = B + '<frame name="f" attached_to="b"><pose>0 0.2 0 0 0 0.3</pose></frame>'
    (tmp_path / "part.sdf").write_text(model(inside), encoding="utf-8")
    main = tmp_path / "robot.sdf"
    merged = '<include merge="true"><uri>part.sdf</uri><pose>0 0 1 0 0.2 0</pose></include>'
    main.write_text(model(A + ROOT + merged + joint("r", "a", "f")), encoding="utf-8")
    nested = f'<model name="n"><pose>0 0 1 0 0.2 0</pose>{inside}</model>'
    apart = read_sdf(model(A + ROOT + nested + joint("r", "a", "n::f")))
    mechanism = read_sdf(main)
    assert [body.name for body in mechanism.bodies] == ["world", "a", "b"]
    assert mechanism.joints[1].origin == apart.joints[1].origin
    assert mechanism.bodies[2].center == apart.bodies[2].center
    main.write_text(model(A + B + merged), encoding="utf-8")
    with pytest.raises(mq.InputError, match="the name 'b' is there already"):
        read_sdf(main)


def test_models_of_gazebo_stand_beside_its_worlds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for folder in ("robots/models/arm", "more/leg", "robots/worlds/test"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "robots" / "models" / "arm" / "model.sdf").write_text(model(A), "utf-8")
    (tmp_path / "more" / "leg" / "model.sdf").write_text(model(A), "utf-8")
    uris = ("model://arm", "arm", "model://leg")
    inside = "".join(
        f"<include><uri>{uri}</uri><name>{k}</name></include>" for k, uri in enumerate(uris)
    )
    world = tmp_path / "robots" / "worlds" / "test" / "w.sdf"
    world.write_text(f'<sdf version="1.7"><world name="w">{inside}</world></sdf>', "utf-8")
    said = f"w.sdf:1: the model 'model://leg' is not found in {world.parent} and above; name the "
    with pytest.raises(mq.InputError, match=re.escape(said)):
        read_sdf(world)
    monkeypatch.setenv("GZ_SIM_RESOURCE_PATH", str(tmp_path / "more"))
    assert read_sdf(world).nv == 18


def test_axes_are_the_models_only_where_their_version_can_say_so(tmp_path: Path) -> None:
    choice = "<axis><xyz>0 1 0.5</xyz><use_parent_model_frame>1</use_parent_model_frame></axis>"
    turned = A + link("b", "<pose>0 0 1 0.3 0.2 0.1</pose>") + joint("r", "a", "b", choice)
    plain = A + link("b", "<pose>0 0 1 0.3 0.2 0.1</pose>")
    plain += joint("r", "a", "b", "<axis><xyz>0 1 0.5</xyz></axis>")

    def axes(mechanism: mq.Mechanism) -> dict[str, Any]:
        return {j.name: j.axis for j in mechanism.joints if isinstance(j, mq.Revolute)}

    new, old = read_sdf(model(turned, "1.7")), read_sdf(model(turned, "1.6"))
    assert axes(new) == axes(read_sdf(model(plain, "1.7"))) != axes(old)
    assert "choices of the model's axes, which SDF 1.7 has no more (1)" in new.about
    # a model that is included has a version of its own, and no other
    (tmp_path / "new.sdf").write_text(model(turned, "1.7"), "utf-8")
    main = tmp_path / "main.sdf"
    included = "<include><uri>new.sdf</uri><name>n</name></include>"
    main.write_text(model(turned + included, "1.6"), "utf-8")
    assert axes(read_sdf(main)) == {**axes(old), "n::r": axes(new)["r"]}


def test_drakes_mimic_is_a_law_of_one_joint() -> None:
    tied = '<drake:mimic joint="q" multiplier="-2" offset="0.1"/>'
    text = model(TWO + joint("r", "a", "b", more=tied))
    mechanism = read_sdf(text.replace("<sdf ", '<sdf xmlns:drake="http://drake.mit.edu" '))
    assert float(mechanism.coordinates.driven["r"].subs({"q": 0.5})) == pytest.approx(
        -0.9, rel=1e-12
    )


def test_lint_says_what_is_wrong_with_it(tmp_path: Path) -> None:
    file, moments = tmp_path / "robot.sdf", "<ixx>0.1</ixx><iyy>0.2</iyy><izz>0.9</izz>"
    inertial = f"<inertial><mass>2</mass><inertia>{moments}</inertia></inertial>"
    sound, broken = PLAIN, model(f'<link name="a">{inertial}</link>' + ROOT)
    for text, code, said in (
        (sound, 0, "all of it is read, and no body is impossible"),
        (sound.replace("</model>", '<plugin name="p"/></model>'), 0, "without plugins (1)"),
        (broken, 1, "Body 'a': its principal moments break the triangle inequality"),
        (model("\n<cat/>"), 2, "robot.sdf:2: <cat> in <model> is not read"),
    ):
        file.write_text(text, encoding="utf-8")
        result = CliRunner().invoke(app, ["lint", str(file)])
        assert (result.exit_code, said in result.output) == (code, True), result.output
    result = CliRunner().invoke(app, ["lint", str(file), "--json"])
    assert result.exit_code == 2
    assert "expected URDF with --fix, --json, --sarif or --meshes, got SDF" in result.output


LIMITED = "<axis><xyz>0 0 1</xyz><limit><velocity>2.5{}</velocity></limit></axis>"


def test_a_stray_quotation_mark_is_read_over_as_libsdformat_does() -> None:
    text = model(TWO + joint("r", "a", "b", LIMITED))
    plain, stray = (read_sdf(text.format(mark)) for mark in ("", '"'))
    assert "stray quotation marks (1)" in stray.about
    assert replace(stray, about=plain.about) == plain


def test_the_oldest_version_and_sounds_are_read_as_drake_does() -> None:
    old = PLAIN.replace(PLAIN[PLAIN.index("<sdf") : PLAIN.index(">") + 1], '<sdf version="1.3">')
    assert read_sdf(old) == read_sdf(old.replace("1.3", "1.4"))
    start, end = old.index("<model"), old.index("</sdf>")
    world = f'{old[:start]}<world name="w"><audio/>{old[start:end]}</world></sdf>'
    assert read_sdf(world).about == "Read from SDF, without sounds (1)."


def test_decays_of_velocity_are_left_out_as_by_drake_and_told() -> None:
    text = model(link("a", more="<velocity_decay><linear>1</linear></velocity_decay>"))
    assert read_sdf(text).about == "Read from SDF, without decays of velocity (1)."


def test_commands_take_it_and_say_what_is_left_out(tmp_path: Path) -> None:
    file = tmp_path / "robot.sdf"
    extra = '<plugin name="p" filename="f"/><sensor name="s" type="imu"/>'
    file.write_text(PLAIN.replace("</model>", f"{extra}</model>"), encoding="utf-8")
    assert mq.read(file).about == "Read from SDF, without plugins (1), sensors (1)."
    result = CliRunner().invoke(app, ["verify", str(file), "--samples", "5"])
    assert result.exit_code == 0
    assert result.output.rstrip().endswith("without plugins (1), sensors (1).")
    with pytest.raises(mq.InputError, match="root can be given for URDF and xacro alone, not SDF"):
        mq.read(file, root="floating")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("<mujoco/>", "line 1: expected <sdf> as the outermost element, not <mujoco>"),
        ('<sdf version="2.0"/>', "expected version 1.3 to 1.12, got '2.0'"),
        ('<sdf version="1.9"/>', "expected one <model> or <world>, got 0"),
        (model("<cat/>"), "<cat> in <model> is not read; leave it out, or say the same by what is"),
        (model('<link name="world"/>'), "line 1: the name 'world' is reserved; give it another"),
        (model('<link name="__a__"/>'), "line 1: the name '__a__' is reserved; give it another"),
        (model("<link/>"), "<link> has no name"),
        (model(A + A), "the name 'a' is there already"),
        (
            model(A + '<frame name="f" attached_to="g"/>'),
            "there is no link, frame or joint 'g' here",
        ),
        (
            model(link("a", "<inertial><mass>1e308</mass></inertial>")),
            "expected 1 finite number in <mass> of at most 1e+50, got '1e308'",
        ),
        (
            model(link("a", "<inertial><mass>inf</mass></inertial>")),
            "expected 1 finite number in <mass>, got 'inf'",
        ),
        (model(link("a", "<pose>0 0 1</pose>")), "expected 6 finite numbers in <pose>"),
        (model(link("a", "<pose>0 0 x 0 0 0</pose>")), "expected 6 finite numbers in <pose>"),
        (
            model(link("a", '<pose rotation_format="quat_xyzw">0 0 0 1 1 1 1</pose>')),
            "expected a unit quaternion",
        ),
        (model(link("a", '<pose relative_to="z"/>')), "there is no link, frame or joint 'z' here"),
        (
            model(link("a", '<pose relative_to="b"/>') + link("b", '<pose relative_to="a"/>')),
            "frames are stated relative to one another in a circle",
        ),
        (
            model(A + '<frame name="f" attached_to="f"/>' + joint("q", "world", "f")),
            "frames are attached to one another in a circle",
        ),
        (model(A.replace("<inertial>", '<inertial auto="true">')), "the collisions have no mass"),
        (
            model(
                '<link name="a"><inertial auto="true"/><collision name="c"><geometry><mesh/>'
                "</geometry></collision></link>"
            ),
            "the inertia of a <mesh> as <collision> is not computed",
        ),
        (
            model(
                TWO
                + joint("r", "a", "b", dynamics("<spring_stiffness>1</spring_stiffness>")).replace(
                    "revolute", "ball"
                )
            ),
            "spring_stiffness of a ball joint is not read",
        ),
        (model(A.replace("<mass>2", "<mass>two")), "expected 1 finite number in <mass>"),
        (model(A + joint("q", "a", "world")), "a joint whose child is the world is not read"),
        (model(A + joint("q", "a", "a")), "it joins link 'a' to itself"),
        (model(A + B + joint("q", "a", "b") + joint("r", "b", "a")), "hangs on itself"),
        (
            model(TWO + joint("r", "a", "b", "<sensor/>")),
            "a joint of type 'revolute' has no <axis>",
        ),
        (
            model(TWO + joint("r", "a", "b", "<axis><xyz>0 0 0</xyz></axis>")),
            "expected a direction with a length",
        ),
        (
            model(TWO + joint("r", "a", "b").replace("revolute", "gearbox")),
            "a joint of type 'gearbox' is not read",
        ),
        (
            model(TWO + joint("r", "a", "b") + joint("s", "world", "b").replace("olute", "olute2")),
            "a loop closed by a joint of type",
        ),
        (
            model(TWO + joint("r", "a", "b", '<axis><xyz>0 1 0</xyz><mimic joint="z"/></axis>')),
            "joint 'r' mimics 'z', which is not there",
        ),
        (model("<include><uri>https://x.y/z</uri></include>"), "https:// are not fetched"),
        (
            model("<include><uri>a.sdf</uri></include>"),
            "the model 'a.sdf' is not found in the empty search path; name the folder that ",
        ),
        (model(A.replace("<mass>2", "<mass>0")), "expected a positive <mass>, got 0: engines take"),
        (model(f'<link name="a">{MASS}<kinematic>1</kinematic></link>'), "a kinematic link"),
    ],
)
def test_what_is_not_read_is_refused_by_name(text: str, said: str) -> None:
    with pytest.raises(mq.InputError, match=re.escape(said)):
        read_sdf(text)


@pytest.mark.parametrize("how", ["attached_to", "relative_to"])
def test_chains_of_frames_are_followed_to_an_end(how: str) -> None:
    """The tenth-of-a-meter steps of 400 frames add up; 3,000 are refused."""

    def chain(count: int) -> str:
        frames = ["<frame name='f0'/>"]
        for k in range(1, count):
            pose = f"<pose relative_to='f{k - 1}'>0.1 0 0 0 0 0</pose>"
            attached = f"attached_to='f{k - 1}'" if how == "attached_to" else ""
            frames.append(f"<frame name='f{k}' {attached}>{pose}</frame>")
        link = f"<link name='a'><pose relative_to='f{count - 1}'/></link>"
        return f"<sdf version='1.8'><model name='m'>{link}{''.join(frames)}</model></sdf>"

    placed = mq.read(chain(400).replace("<model name='m'>", "<model name='m'><static>1</static>"))
    assert placed.home_poses["a"][0, 3] == pytest.approx(39.9, rel=1e-12)
    with pytest.raises(mq.InputError, match="to one another through more than 500 others"):
        mq.read(chain(3000))
