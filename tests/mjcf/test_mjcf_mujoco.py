"""What is read of MJCF against MuJoCo itself: mass matrix, bias and passive forces."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

import mecanique as mq
from mecanique.mjcf import read_mjcf

TIP = '<body name="b" pos="0.1 0.2 -0.3">{}</body>'


def world(inside: str, before: str = "") -> str:
    return f'<mujoco model="m">{before}<worldbody>{inside}</worldbody></mujoco>'


def body(inside: str, before: str = "") -> str:
    return world(TIP.format(inside), before)


HINGE = '<joint name="h" axis="0.3 -1 0.2" pos="0.1 0 0.2"/>'
GEOM = '<geom type="box" size="0.1 0.2 0.3" pos="0.1 -0.1 0.4" euler="20 30 40"/>'
SECOND = (
    '<body pos="0.3 0 0" euler="10 20 30"><joint name="s" type="slide" axis="1 1 0"/>'
    '<geom type="capsule" fromto="0 0 0 0.1 0.2 0.5" size="0.05"/></body>'
)

TEXTS = {
    "plain": body(HINGE + GEOM + SECOND),
    "sphere": body(HINGE + '<geom size="0.1" pos="0.2 0.1 0" mass="2"/>'),
    "ellipsoid": body(HINGE + '<geom type="ellipsoid" size="0.1 0.2 0.3" density="300"/>'),
    "cylinder": body(HINGE + '<geom type="cylinder" size="0.1 0.4" quat="1 2 3 4" pos="0.1 0 0"/>'),
    "capsule": body(HINGE + '<geom type="capsule" size="0.1 0.4" zaxis="1 2 3"/>'),
    "box of two points": body(HINGE + '<geom type="box" size="0.1" fromto="0 0 0 0 -1 -2"/>'),
    "down": body(HINGE + '<geom type="cylinder" size="0.1" fromto="0 0 1 0 0 0"/>'),
    "several": body(HINGE + GEOM + '<geom size="0.2" pos="-0.3 0 0"/>'),
    "inertial": body(
        HINGE
        + '<inertial pos="0.1 0 0.2" mass="2" diaginertia="0.3 0.2 0.4" euler="10 20 30"/>'
        + GEOM
    ),
    "full inertia": body(
        HINGE + '<inertial pos="0.1 0 0.2" mass="2" fullinertia="0.3 0.2 0.4 0.01 0.02 -0.03"/>'
    ),
    "inertia from geoms": body(
        HINGE + '<inertial pos="0 0 0" mass="9" diaginertia="1 1 1"/>' + GEOM,
        '<compiler inertiafromgeom="true"/>',
    ),
    "groups": body(
        HINGE + GEOM + '<geom size="0.5" group="3"/>', '<compiler inertiagrouprange="0 2"/>'
    ),
    "bounds": body(
        HINGE + '<inertial pos="0.1 0 0" mass="0.01" diaginertia="0.001 0.002 0.0025"/>',
        '<compiler boundmass="0.5" boundinertia="0.0022"/>',
    ),
    "balance": body(
        HINGE + '<inertial pos="0.1 0 0" mass="1" diaginertia="0.1 0.1 0.9"/>',
        '<compiler balanceinertia="true"/>',
    ),
    "total": body(HINGE + GEOM + SECOND, '<compiler settotalmass="7"/>'),
    "radian": body(
        '<joint axis="0 1 0" ref="0.3" springref="0.1" stiffness="2"/><geom size="0.1" '
        'pos="0 0 1" euler="0.1 0.2 0.3"/>',
        '<compiler angle="radian"/>',
    ),
    "references": body(
        '<joint name="a" axis="0 1 1" pos="0.1 0.2 0" ref="40" springref="10" stiffness="2"/>'
        '<joint name="b" type="slide" axis="1 2 0" ref="0.2" springref="-0.1" stiffness="9"/>'
        + GEOM
        + SECOND
    ),
    "three joints": body(
        '<joint name="x" axis="1 0 0" pos="0.1 0 0"/><joint name="y" axis="0 2 0"/>'
        '<joint name="z" axis="0 0 1" pos="0 0.3 0.1"/>' + GEOM + SECOND
    ),
    "slides and a hinge": body(
        '<joint name="x" type="slide" axis="1 0 0"/><joint name="z" type="slide" axis="0 0 1"/>'
        '<joint name="q" axis="0 1 0"/>' + GEOM + SECOND
    ),
    "ball": body('<joint name="b" type="ball" pos="0.1 0.2 0.3"/>' + GEOM + SECOND),
    "free": body("<freejoint/>" + GEOM + SECOND),
    "free by joint": body('<joint type="free"/>' + GEOM + SECOND),
    "welded": body(HINGE + GEOM + '<body pos="1 0 0" euler="0 0 90">' + GEOM + "</body>"),
    "armature": body('<joint axis="0 1 0" armature="0.61" damping="0.4" frictionloss="3"/>' + GEOM),
    "gravity": body(HINGE + GEOM, '<option gravity="1 2 -3"/>'),
    "no gravity": body(HINGE + GEOM, '<option><flag gravity="disable"/></option>'),
    "no springs": body(
        '<joint axis="0 1 0" stiffness="3" damping="2"/>' + GEOM,
        '<option><flag spring="disable"/></option>',
    ),
    "gravcomp": world(f'<body gravcomp="0.7">{HINGE}{GEOM}{SECOND}</body>'),
    "euler sequence": world(
        f'<body euler="10 20 30">{HINGE}{GEOM}{SECOND}</body>', '<compiler eulerseq="zYx"/>'
    ),
    "fixed axes": world(
        f'<body euler="10 20 30">{HINGE}{GEOM}{SECOND}</body>', '<compiler eulerseq="XYZ"/>'
    ),
    "axes": world(
        f'<body xyaxes="1 1 0 -1 2 0.5"><body axisangle="1 2 3 50">{HINGE}{GEOM}</body></body>'
    ),
    "frames": world(
        '<frame pos="0 0 1" euler="0 30 0"><body pos="0.1 0 0"><frame euler="20 0 0" pos="0 1 0">'
        f"{HINGE}{GEOM}{SECOND}</frame></body></frame>"
    ),
    "defaults": body(
        '<joint name="a"/><geom class="heavy"/><body childclass="heavy"><joint name="b" '
        'axis="0 0 1"/><geom pos="0 0.2 0"/><geom class="main" size="0.3"/></body>',
        '<default><joint axis="0 1 0" damping="2"/><geom type="box" size="0.1 0.1 0.2"/>'
        '<default class="heavy"><geom density="5000"/><joint armature="0.1"/></default></default>',
    ),
}


def norm(text: str, q: Any, v: Any) -> tuple[Any, Any, Any]:
    """MuJoCo's mass matrix, bias and passive forces in this package's velocities."""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    ours, rates, turn, extra = np.array(q), np.array(v), np.eye(model.nv), np.zeros(model.nv)
    for k in range(model.njnt):
        at, dof = int(model.jnt_qposadr[k]), int(model.jnt_dofadr[k])
        if int(model.jnt_type[k]) == int(mujoco.mjtJoint.mjJNT_BALL):
            ours[at : at + 4] = np.roll(q[at : at + 4], 1)
        if int(model.jnt_type[k]) == int(mujoco.mjtJoint.mjJNT_FREE):
            ours[at + 3 : at + 7] = np.roll(q[at + 3 : at + 7], 1)
            matrix = np.zeros(9)
            mujoco.mju_quat2Mat(matrix, ours[at + 3 : at + 7])
            turn[dof : dof + 3, dof : dof + 3] = matrix.reshape(3, 3)
            extra[dof : dof + 3] = np.cross(v[dof + 3 : dof + 6], v[dof : dof + 3])
    data.qpos[:], data.qvel[:] = ours, turn @ rates
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))
    for column, unit in zip(mass, np.eye(model.nv), strict=True):
        mujoco.mj_mulM(model, data, column, unit)
    bias = turn.T @ (data.qfrc_bias + mass @ turn @ extra)
    return turn.T @ mass @ turn, bias, turn.T @ data.qfrc_passive


def close(ours: Any, theirs: Any, mass: Any) -> None:
    size = max(np.abs(theirs).max(initial=0.0), np.abs(mass).max())
    assert np.abs(np.asarray(ours) - theirs).max(initial=0.0) < 1e-9 * size


@pytest.fixture(autouse=True)
def _log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """MuJoCo writes its warnings into a file where it is."""
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("name", TEXTS)
def test_mass_bias_and_passive_forces_are_mujocos(name: str) -> None:
    mechanism = read_mjcf(TEXTS[name])
    random = np.random.default_rng(3)
    engine, bare = mq.Reference(mechanism), mq.Reference(replace(mechanism, forces=()))
    for _ in range(5):
        q = mechanism.neutral() + random.uniform(-1, 1, mechanism.nq)
        for joint in mechanism.joints:
            if joint.quaternion:
                start = list(mechanism.coordinates).index(joint.quaternion[0])
                q[start : start + 4] /= np.linalg.norm(q[start : start + 4])
        v = random.uniform(-1, 1, mechanism.nv)
        mass, bias, passive = norm(TEXTS[name], q, v)
        still = np.zeros(mechanism.nv)
        close(engine.mass_matrix(q), mass, mass)
        total = engine.inverse_dynamics(q, v, still)
        alone = bare.inverse_dynamics(q, v, still)
        close(alone, bias, mass)
        close(np.asarray(alone) - total, passive, mass)
