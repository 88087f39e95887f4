"""Meaning of SDF against Drake itself, where it is installed: mass matrix, bias and forces."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import mecanique as mq
from mecanique.formats.sdf import read_sdf
from mecanique.model.joints import Floating, Spherical

INERTIA = (
    "<inertia><ixx>0.3</ixx><iyy>0.2</iyy><izz>0.4</izz><ixy>0.01</ixy><iyz>0.02</iyz></inertia>"
)
MASS = f"<inertial><pose>0.1 0.2 0.3 0.1 0.2 0.3</pose><mass>2</mass>{INERTIA}</inertial>"
"""Of every link."""


def model(inside: str, version: str = "1.9", more: str = "") -> str:
    return f'<sdf version="{version}"><model name="m"{more}>{inside}</model></sdf>'


def link(name: str, pose: str = "", more: str = "") -> str:
    return f'<link name="{name}">{pose}{MASS}{more}</link>'


def joint(name: str, parent: str, child: str, axis: str = "", more: str = "") -> str:
    axis = axis or "<axis><xyz>0.1 1 0.2</xyz></axis>"
    ends = f"<parent>{parent}</parent><child>{child}</child>"
    return f'<joint name="{name}" type="revolute">{more}{ends}{axis}</joint>'


A = link("a", "<pose>0 0 1 0.1 0.2 0.3</pose>")
B = link("b", "<pose>0.5 0.1 1 0.4 0 0.2</pose>")
ROOT = joint("q", "world", "a", more="<pose>0 0.1 -0.2 0.3 0 0</pose>")
TWO = A + B + ROOT
AXIS = "<axis><xyz{}>0 1 0.5</xyz></axis>"


def dynamics(text: str) -> str:
    return f"<axis><xyz>0 1 0</xyz><dynamics>{text}</dynamics></axis>"


DAMPED = (
    "<damping>0.3</damping><spring_stiffness>2</spring_stiffness>"
    "<spring_reference>0.4</spring_reference>"
)


def collision(name: str, pose: str, shape: str, more: str = "") -> str:
    geometry = f"<geometry>{shape}</geometry>"
    return f'<collision name="{name}"><pose>{pose}</pose>{more}{geometry}</collision>'


SOLIDS = (
    collision("box", "0.1 0 0 0.1 0.2 0.3", "<box><size>0.1 0.2 0.3</size></box>")
    + collision("ball", "0 1 0 0 0 0", "<sphere><radius>0.2</radius></sphere>")
    + collision(
        "can",
        "0 0 1 1 0 0",
        "<cylinder><radius>0.2</radius><length>0.4</length></cylinder>",
        "<density>500</density>",
    )
    + collision(
        "pill", "0 0 1 1 2 0", "<capsule><radius>0.2</radius><length>0.4</length></capsule>"
    )
    + collision("egg", "1 0 1 1 2 0", "<ellipsoid><radii>0.1 0.2 0.3</radii></ellipsoid>")
)

TEXTS = {
    "free": model(A),
    "without inertia": model('<link name="a"/>'),
    "two free": model(A + B),
    "hinge": model(A + ROOT),
    "chain": model(TWO + joint("r", "a", "b")),
    "slide": model(TWO + joint("r", "a", "b").replace("revolute", "prismatic")),
    "continuous": model(TWO + joint("r", "a", "b").replace("revolute", "continuous")),
    "weld": model(TWO + joint("r", "a", "b").replace("revolute", "fixed")),
    **{
        f"{kind} of a parent that hangs on its child": model(
            A + B + joint("r", "b", "a", dynamics(DAMPED)).replace("revolute", kind) + ROOT
        )
        for kind in ("revolute", "prismatic", "fixed")
    },
    "two links that hang on the last child": model(
        A + B + link("c") + joint("r", "b", "c") + joint("s", "c", "a") + ROOT
    ),
    "free chain": model(A + B + joint("r", "a", "b")),
    "static": model(
        f"<static>true</static>{A}{B}{joint('r', 'a', 'b').replace('revolute', 'fixed')}"
    ),
    "link by link": model(
        A + link("b", '<pose relative_to="a">0 0 1 0 0.3 0</pose>') + ROOT + joint("r", "a", "b")
    ),
    "link by joint": model(
        A
        + link("b", '<pose relative_to="r">0 0 1 0 0.3 0</pose>')
        + ROOT
        + joint("r", "a", "b", more='<pose relative_to="a">0 0 0.5 0 0 0.4</pose>')
    ),
    "frame": model(
        TWO
        + '<frame name="f" attached_to="a"><pose>0 1 0 0 0 0.5</pose></frame>'
        + joint("r", "f", "b", more='<pose relative_to="f"/>')
    ),
    "frame of a frame": model(
        A + '<frame name="f"><pose>0 1 0 0 0 0.5</pose></frame>'
        '<frame name="g" attached_to="f"><pose>0 1 0 0.4 0 0.5</pose></frame>'
        + link("b", '<pose relative_to="g"/>')
        + ROOT
        + joint("r", "a", "b")
    ),
    "frame as child": model(
        TWO
        + '<frame name="f" attached_to="b"><pose>0 1 0 0 0 0.5</pose></frame>'
        + joint("r", "a", "f")
    ),
    "axis in a frame": model(TWO + joint("r", "a", "b", AXIS.format(' expressed_in="__model__"'))),
    "axis in a link": model(TWO + joint("r", "a", "b", AXIS.format(' expressed_in="a"'))),
    "axis of old": model(
        TWO
        + joint(
            "r",
            "a",
            "b",
            "<axis><xyz>0 1 0.5</xyz><use_parent_model_frame>1</use_parent_model_frame></axis>",
        ),
        "1.6",
    ),
    "moved model": model(f"<pose>1 2 3 0.4 0.5 0.6</pose>{TWO}{joint('r', 'a', 'b')}"),
    "moved by a frame": model(
        f"<pose>1 2 3 0.4 0.5 0.6</pose>{TWO}{joint('r', 'a', 'b')}", more=' placement_frame="b"'
    ),
    "degrees": model(
        A + link("b", '<pose degrees="true">0 0 1 10 20 30</pose>') + ROOT + joint("r", "a", "b")
    ),
    "quaternion": model(
        A
        + link("b", '<pose rotation_format="quat_xyzw">0 0 1 0.1 0.5 0.7 0.5</pose>')
        + ROOT
        + joint("r", "a", "b")
    ),
    "nested": model(
        A
        + ROOT
        + f'<model name="n"><pose>0 0 1 0 0.2 0</pose>{B}</model>'
        + joint("r", "a", "n::b")
    ),
    "nested twice": model(
        A
        + ROOT
        + f'<model name="n"><model name="o"><pose>0 0 1 0 0.2 0</pose>{B}</model></model>'
        + joint("r", "a", "n::o::b")
    ),
    "nested by a frame": model(
        A
        + ROOT
        + f'<model name="n"><pose relative_to="a">0 0 1 0 0.2 0</pose>{B}</model>'
        + joint("r", "a", "n::b", AXIS.format(' expressed_in="n"'))
    ),
    "nested joints": model(
        A
        + ROOT
        + f'<model name="n">{B}{link("c")}{joint("s", "b", "c")}</model>'
        + joint("r", "a", "n::b")
    ),
    "damping": model(TWO + joint("r", "a", "b", dynamics("<damping>0.7</damping>"))),
    "spring": model(
        TWO
        + joint(
            "r",
            "a",
            "b",
            dynamics(
                "<spring_stiffness>3</spring_stiffness><spring_reference>0.4</spring_reference>"
            ),
        )
    ),
    "friction": model(TWO + joint("r", "a", "b", dynamics("<friction>0.7</friction>"))),
    "rotor": model(
        TWO
        + joint(
            "r",
            "a",
            "b",
            more="<drake:rotor_inertia>0.1</drake:rotor_inertia>"
            "<drake:gear_ratio>3</drake:gear_ratio>",
        )
    ).replace("<sdf ", '<sdf xmlns:drake="http://drake.mit.edu" '),
    "limits": model(
        TWO
        + joint(
            "r",
            "a",
            "b",
            "<axis><xyz>0 1 0</xyz><limit><lower>-1</lower><upper>2</upper>"
            "<effort>3</effort><velocity>4</velocity></limit></axis>",
        )
    ),
    "universal": model(
        TWO
        + joint(
            "r", "a", "b", "<axis><xyz>0 1 0</xyz></axis><axis2><xyz>1 0 0</xyz></axis2>"
        ).replace("revolute", "universal")
    ),
    "universal with damping": model(
        TWO
        + joint(
            "r",
            "a",
            "b",
            f"{dynamics('<damping>0.3</damping>')}<axis2><xyz>1 0 0</xyz></axis2>",
            "<pose>0.1 0.2 0.3 0.4 0.5 0.6</pose>",
        ).replace("revolute", "universal")
    ),
    "ball with damping": model(
        TWO + joint("r", "a", "b", dynamics("<damping>0.3</damping>")).replace("revolute", "ball")
    ),
    "ball of the world with damping": model(
        A + joint("r", "world", "a", dynamics("<damping>0.3</damping>")).replace("revolute", "ball")
    ),
    "inertia of collisions": model(
        f'<link name="a"><inertial auto="true"><density>300</density></inertial>{SOLIDS}</link>'
        f"{ROOT}",
        "1.11",
    ),
    "inertia of collisions by mass": model(
        f'<link name="a"><inertial auto="true"><mass>7</mass></inertial>{SOLIDS}</link>{ROOT}',
        "1.11",
    ),
    "world": f'<sdf version="1.9"><world name="w"><gravity>1 2 -3</gravity>'
    f'<model name="m">{TWO}{joint("r", "a", "b")}</model></world></sdf>',
    "two models": f'<sdf version="1.9"><world name="w"><model name="m">{TWO}'
    f'{joint("r", "a", "b")}</model><model name="n">{A}{ROOT}</model></world></sdf>',
    "joint of the world": f'<sdf version="1.10"><world name="w"><model name="m">{A}{B}'
    f'{joint("r", "a", "b")}</model><joint name="j" type="fixed"><parent>world</parent>'
    "<child>m::a</child></joint></world></sdf>",
    "old": model(TWO + joint("r", "a", "b"), "1.4"),
    "new": model(TWO + joint("r", "a", "b"), "1.11"),
}


def norm(text: str, mechanism: mq.Mechanism, q: Any, v: Any) -> tuple[Any, Any, Any]:
    """Drake's mass matrix, bias and inverse dynamics in this package's velocities."""
    from pydrake.common.eigen_geometry import Quaternion
    from pydrake.math import RollPitchYaw, RotationMatrix
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.multibody.tree import JointIndex, MultibodyForces

    plant = MultibodyPlant(0.0)
    Parser(plant).AddModelsFromString(text, "sdf")
    plant.mutable_gravity_field().set_gravity_vector(mechanism.evaluate_all(mechanism.gravity))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    joints: dict[str, Any] = {}
    carriers: dict[str, Any] = {}
    for k in range(plant.num_joints()):
        each = plant.get_joint(JointIndex(k))
        for named, item in ((joints, each), (carriers, each.child_body())):
            model_name = plant.GetModelInstanceName(item.model_instance())
            name = f"{model_name}::{item.name()}"
            named[name] = named[name.removeprefix("m::")] = each
            named.setdefault(item.name(), each)
    names, rates = list(mechanism.coordinates), list(mechanism.velocities)
    place = np.array(plant.GetPositions(context))
    turn, extra = np.zeros((len(v), len(v))), np.zeros(len(v))
    for ours in mechanism.joints:
        columns = [rates.index(rate) for rate in ours.velocities]
        at = [names.index(name) for name in ours.coordinates]
        if not at:
            continue
        theirs = carriers[ours.child] if isinstance(ours, Floating) else joints[ours.name]
        start, row = theirs.position_start(), theirs.velocity_start()
        if isinstance(ours, Spherical):  # Drake's has three angles, and turns in the parent's axes
            pose = RotationMatrix(Quaternion(np.roll(q[at], 1)))
            place[start : start + 3] = RollPitchYaw(pose).vector()
            turn[row : row + 3, columns] = pose.matrix()
            continue
        if not isinstance(ours, Floating):
            place[start : start + len(at)] = q[at]
            turn[range(row, row + len(at)), columns] = 1.0
            continue
        quaternion = np.roll(q[at[3:]], 1)
        matrix = RotationMatrix(Quaternion(quaternion)).matrix()
        place[start : start + 7] = [*quaternion, *q[at[:3]]]
        turn[row : row + 3, columns[3:]] = turn[row + 3 : row + 6, columns[:3]] = matrix
        extra[row + 3 : row + 6] = matrix @ np.cross(v[columns[3:]], v[columns[:3]])
    plant.SetPositions(context, place)
    plant.SetVelocities(context, turn @ v)
    mass = plant.CalcMassMatrix(context)
    bias = plant.CalcBiasTerm(context) - plant.CalcGravityGeneralizedForces(context)
    forces = MultibodyForces(plant)
    plant.CalcForceElementsContribution(context, forces)
    whole = plant.CalcInverseDynamics(context, np.zeros(len(v)), forces)
    more = mass @ extra
    return turn.T @ mass @ turn, turn.T @ (bias + more), turn.T @ (whole + more)


@pytest.mark.parametrize("name", TEXTS)
def test_mass_bias_and_forces_are_drakes(name: str) -> None:
    pytest.importorskip("pydrake")
    mechanism = read_sdf(TEXTS[name])
    random = np.random.default_rng(3)
    engine, bare = mq.Reference(mechanism), mq.Reference(replace(mechanism, forces=()))
    for _ in range(3):
        q = mechanism.neutral() + random.uniform(-1, 1, mechanism.nq)
        for each in mechanism.joints:
            if each.quaternion:
                start = list(mechanism.coordinates).index(each.quaternion[0])
                q[start : start + 4] /= np.linalg.norm(q[start : start + 4])
        v = random.uniform(-1, 1, mechanism.nv)
        mass, bias, whole = norm(TEXTS[name], mechanism, q, v)
        still = np.zeros(mechanism.nv)
        size = max(np.abs(bias).max(initial=0.0), np.abs(mass).max(initial=0.0))
        for ours, theirs in (
            (engine.mass_matrix(q), mass),
            (bare.inverse_dynamics(q, v, still), bias),
            (engine.inverse_dynamics(q, v, still), whole),
        ):
            assert np.abs(np.asarray(ours) - theirs).max(initial=0.0) <= 1e-12 * size


def test_the_spring_of_a_screw_is_left_out_as_drake_does_and_told() -> None:
    spring = "<dynamics><spring_stiffness>5</spring_stiffness></dynamics></axis>"
    text = model(TWO.replace("revolute", "screw").replace("</axis>", spring))
    whole = mq.read(text.replace('"1.9"', '"1.10"'))
    assert not mq.verify(whole, samples=2, engines=["drake"]).readings[-1].differs
    assert "without springs in screws, which Drake leaves out (1)" in whole.about
    coil = mq.JointSpring("coil", "q", 5.0)
    conversion = mq.convert(replace(whole, forces=(coil,)), "SDF", states=3)
    assert conversion.lost == ("spring coil: engines of SDF read none in a screw",)
    assert conversion.proved
