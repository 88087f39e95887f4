"""What is read of MJCF against MuJoCo itself: mass matrix, bias and passive forces."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

import mecanique as mq
from mecanique.formats.mjcf import read_mjcf
from mecanique.verification.engines import read_by

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
    "contacts that pull": body(HINGE + GEOM.replace("<geom", '<geom adhesion="1.5" gap="0.1"')),
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
    "ball on what turns": body(
        HINGE + GEOM + '<body pos="0.3 0.1 0"><joint type="ball" pos="0.1 0 0.2" armature="0.4" '
        f'stiffness="3 1 0.5" damping="1 0.5 0.2"/>{GEOM}</body>'
    ),
    "free spring": world(
        '<body pos="0.1 0.2 -0.3" euler="9 8 7"><joint type="free" stiffness="3 1 0.5" '
        f'damping="1 0.5 0.2"/>{GEOM}{SECOND}</body>'
    ),
    "aligned free body": world(
        '<site name="w" pos="1 0 0"/><body name="a" pos="0.1 0.2 -0.3" euler="9 8 7"><freejoint/>'
        f'{GEOM}<geom size="0.2" pos="-0.3 0 0.4"/><site name="a" pos="0.3 0 0"/></body>',
        '<compiler alignfree="true"/><tendon><spatial stiffness="9" armature="0.3">'
        '<site site="w"/><site site="a"/></spatial></tendon>',
    ),
    "tendon from a site between two points": body(
        HINGE + GEOM + '<site name="s" type="box" fromto="0.1 0 0 0.3 0.2 0.4" size="0.01"/>',
        '<tendon><spatial stiffness="2"><site site="w"/><site site="s"/></spatial></tendon>',
    ).replace("<body", '<site name="w" pos="1 0 0"/><body', 1),
    "tendon over a ball": body(
        '<joint type="ball"/>' + GEOM + SECOND.replace("<geom", '<site name="s"/><geom', 1),
        '<tendon><spatial stiffness="2 1" damping="0.3" armature="0.2"><site site="w"/>'
        '<site site="s"/></spatial></tendon>',
    ).replace("<body", '<site name="w" pos="1 0 0"/><body', 1),
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
    "springs of balls": body(
        '<joint type="ball" stiffness="3" damping="2"/>'
        + GEOM
        + '<body pos="0 0 1" euler="10 20 30"><joint type="ball" pos="0 0.1 0" stiffness="2"/>'
        + GEOM
        + "</body>"
    ),
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

TETRAHEDRON = 'vertex="0 0 0  1 0 0.1  0 0.7 0  0.1 0.2 0.9"'
FACES = 'face="0 2 1  0 1 3  0 3 2  1 2 3"'
"""With `TETRAHEDRON` a closed surface, counterclockwise from outside."""
DENTED = (
    'vertex="-1 -1 -1  1 -1 -1  1 1 -1  -1 1 -1  0 0 0.2  -1 -1 1  1 -1 1  1 1 1  -1 1 1" '
    'face="0 2 1  0 3 2  0 1 6  0 6 5  1 2 7  1 7 6  2 3 8  2 8 7  3 0 5  3 5 8  '
    '5 6 4  6 7 4  7 8 4  8 5 4"'
)
"""A box of which the top is pulled in, so that the rules differ."""


def mesh(attributes: str, geom: str = "", compiler: str = "") -> str:
    before = f'{compiler}<asset><mesh name="m" {attributes}/></asset>'
    place = 'pos="0.1 0.2 0.3" euler="10 20 30"'
    return body(f'{HINGE}<geom type="mesh" mesh="m" {place} {geom}/>{SECOND}', before)


def drawn(form: str, geom: str) -> str:
    return body(f'{HINGE}<geom type="{form}" shellinertia="true" {geom}/>')


def tendon(tags: str, after: str = "", joint: str = "") -> str:
    inside = f'<site name="w" pos="0.3 0 1"/>{TIP.format(HINGE + GEOM + SITED)}{joint}'
    return f"<mujoco><worldbody>{inside}</worldbody><tendon>{tags}</tendon>{after}</mujoco>"


SITED = SECOND.replace("/></body>", '/><site name="t" pos="0.1 0 0.2"/></body>')
PAIR = TIP.format(HINGE + GEOM + SECOND)
THIRD = f'<body pos="1 0 0"><joint name="k" axis="0 1 0"/>{GEOM}</body>'
ALONG = '<joint joint="h" coef="0.5"/><joint joint="s" coef="-2"/>'
STRAIGHT = '<site site="w"/><site site="t"/>'

TEXTS |= {
    "timed springs with powers": body(
        '<joint axis="0 1 1" springdamper="0.5 0.7" stiffness="2 1 3" damping="1 0.4"/>' + GEOM
    ),
    "a medium around equal least moments": body(
        f'{HINGE}<inertial pos="0 0.1 0" mass="1" diaginertia="0.2 0.25 0.4" '
        'quat="1 0.2 0.3 0.1"/>',
        '<compiler boundinertia="0.3"/><option density="19" viscosity="0.1"/>',
    ),
    "mesh": mesh(f"{TETRAHEDRON} {FACES}"),
    "mesh of points": mesh(TETRAHEDRON),
    "field of distances": mesh(f"{TETRAHEDRON} {FACES}").replace('type="mesh"', 'type="sdf"'),
    "field of heights": body(
        f'{HINGE}{GEOM}<geom type="hfield" hfield="f"/>',
        '<asset><hfield name="f" nrow="2" ncol="2" size="1 1 1 1"/></asset>',
    ),
    "mesh with mass": mesh(f"{TETRAHEDRON} {FACES}", 'mass="3"'),
    "mesh with density": mesh(f"{TETRAHEDRON} {FACES}", 'density="70"'),
    "mesh scaled": mesh(f'{TETRAHEDRON} {FACES} scale="0.5 1 2"'),
    "mesh mirrored": mesh(f'{TETRAHEDRON} {FACES} scale="-1 1 2" inertia="exact"'),
    "mesh moved": mesh(f'{TETRAHEDRON} {FACES} refpos="1 2 3" refquat="1 1 0 2"'),
    "mesh legacy": mesh(DENTED),
    "mesh exact": mesh(f'{DENTED} inertia="exact"'),
    "mesh convex": mesh(f'{DENTED} inertia="convex"'),
    "mesh shell": mesh(f'{DENTED} inertia="shell"'),
    "mesh by class": mesh(
        DENTED, compiler='<default><mesh inertia="exact" scale="1 1 0.5"/></default>'
    ),
    "box for a mesh": mesh(f"{TETRAHEDRON} {FACES}").replace('type="mesh"', 'type="box"'),
    "ball for a mesh": mesh(DENTED).replace('type="mesh"', 'type="sphere" fitscale="1.2"'),
    "capsule for a mesh": mesh(f"{TETRAHEDRON} {FACES}").replace('type="mesh"', 'type="capsule"'),
    "cylinder for a mesh": mesh(f"{TETRAHEDRON} {FACES}").replace('type="mesh"', 'type="cylinder"'),
    "ellipsoid for a mesh": mesh(f"{TETRAHEDRON} {FACES}").replace(
        'type="mesh"', 'type="ellipsoid"'
    ),
    "hollow ball": drawn("sphere", 'size="0.2" pos="0.1 0 0"'),
    "hollow box": drawn("box", 'size="0.1 0.2 0.4" pos="0.1 0 0"'),
    "hollow cylinder": drawn("cylinder", 'size="0.1 0.4" pos="0.1 0 0"'),
    "hollow capsule": drawn("capsule", 'size="0.1 0.4" mass="2"'),
    "hollow ellipsoid": drawn("ellipsoid", 'size="0.1 0.2 0.4" density="20"'),
    "replicate": world(
        f'<replicate count="3" offset="0.1 0.2 0" euler="0 10 20"><body name="b" pos="1 0 0">'
        f"{HINGE}{GEOM}{SECOND}</body></replicate>"
    ),
    "replicate twice": world(
        '<replicate count="2" offset="0 0 1"><replicate count="2" euler="0 0 90"><body pos="1 0 0">'
        f"{HINGE}{GEOM}</body></replicate></replicate>"
    ),
    "replicated geoms": body(
        f'{HINGE}<replicate count="11" offset="0.1 0 0" sep="-"><geom name="g" size="0.1"/>'
        "</replicate>"
    ),
    "spring along joints": tendon(f'<fixed name="f" stiffness="3">{ALONG}</fixed>'),
    "spring of a length": tendon(f'<fixed stiffness="3" springlength="0.4">{ALONG}</fixed>'),
    "damper along joints": tendon(f'<fixed damping="2">{ALONG}</fixed>'),
    "spring along a joint": tendon(
        '<fixed stiffness="3" damping="0.1" springlength="0.4"><joint joint="h" coef="-2"/></fixed>'
    ),
    "spring between sites": tendon(f'<spatial stiffness="30" damping="2">{STRAIGHT}</spatial>'),
    "spring of free length": tendon(
        f'<spatial stiffness="30" springlength="0.3">{STRAIGHT}</spatial>'
    ),
    "spring by class": tendon(f'<fixed class="k">{ALONG}</fixed>').replace(
        "<worldbody>",
        '<default><default class="k"><tendon stiffness="4"/></default></default><worldbody>',
    ),
    "no springs along joints": tendon(f'<fixed stiffness="3">{ALONG}</fixed>').replace(
        "<worldbody>", '<option><flag spring="disable"/></option><worldbody>'
    ),
    "rotor of a drive": tendon(
        "", '<actuator><motor joint="h" armature="0.1" gear="3"/></actuator>'
    ),
    "damping of a drive": tendon(
        "", '<actuator><position joint="s" damping="0.5" gear="2"/></actuator>'
    ),
    "two drives by class": tendon(
        "",
        '<actuator><motor joint="h"/><motor joint="h" gear="2"/></actuator>',
    ).replace("<worldbody>", '<default><general armature="0.2"/></default><worldbody>'),
}

MEDIUM = '<option density="1.2" viscosity="0.03"/>'
TILTED = (
    '<inertial pos="0.1 0.2 -0.1" mass="2" diaginertia="0.3 0.2 0.4" euler="10 20 30"/>'
    '<geom size="0.1"/>'
)

TEXTS |= {
    "ball with a rotor": body(
        '<joint type="ball" armature="0.3" damping="0.1" pos="0.1 0.2 0.3"/>' + GEOM + SECOND
    ),
    "ball with a rotor on a slide": world(
        '<body><joint type="slide" axis="1 0 1"/><body pos="0 0 1"><joint type="ball" '
        f'armature="0.3" damping="0.1"/>{GEOM}</body>{GEOM}</body>'
    ),
    "ball with damping": body(
        '<joint type="ball" damping="0.3" pos="0.1 0.2 0.3"/>' + GEOM + SECOND
    ),
    "ball with damping on a link": body(
        f'{HINGE}{GEOM}<body pos="0.3 0 0" euler="10 20 30"><joint type="ball" damping="0.3"/>'
        f"{GEOM}</body>"
    ),
    "free with damping": body('<joint type="free" damping="0.4"/>' + GEOM + SECOND),
    "free with damping by class": body(
        '<joint type="free"/>' + GEOM + SECOND, '<default><joint damping="0.4"/></default>'
    ),
    "ball without damping by flag": body(
        '<joint type="ball" damping="0.3"/>' + GEOM,
        '<option><flag damper="disable"/></option>',
    ),
    "ball without a spring by flag": body(
        '<joint type="ball" stiffness="3"/>' + GEOM,
        '<option><flag spring="disable"/></option>',
    ),
    "a drone in air": world(f"<body>{TILTED}<freejoint/></body>", MEDIUM),
    "a drone in thin air": world(f"<body>{TILTED}<freejoint/></body>", '<option density="1.2"/>'),
    "a drone in oil": world(f"<body>{TILTED}<freejoint/></body>", '<option viscosity="2"/>'),
    "what stands in air": world(f"<body>{TILTED}<body>{GEOM}</body></body>", MEDIUM).replace(
        "</worldbody>", f"<body><freejoint/>{GEOM}</body></worldbody>"
    ),
    "autolimits off": body(
        '<joint name="a" axis="0 1 0" limited="false" range="-10 20" stiffness="2"/>' + GEOM,
        '<compiler autolimits="false"/>',
    ),
    "degrees of an axis and an angle": world(
        f'<body axisangle="1 2 3 0.7">{HINGE.replace("0.3 -1", "1 -1")}{GEOM}</body>',
        '<compiler angle="radian"/>',
    ),
    "reference in radians": body(
        '<joint axis="1 1 0" ref="0.4" springref="-0.2" stiffness="3" damping="1"/>' + GEOM,
        '<compiler angle="radian"/>',
    ),
    "a slide's reference has no degrees": body(
        '<joint type="slide" axis="1 1 0" ref="0.4" springref="-0.2" stiffness="3"/>' + GEOM
    ),
    "mass over density": body(HINGE + '<geom size="0.1" pos="0.2 0 0" mass="2" density="9"/>'),
    "massless among others": body(HINGE + GEOM + '<geom size="0.4" pos="0.2 0 0" mass="0"/>'),
    "geoms count beside an inertial": body(
        HINGE + '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>' + GEOM,
        '<compiler inertiafromgeom="auto"/>',
    ),
    "class of a class": body(
        f'<joint class="in" axis="0 1 0"/>{GEOM}',
        '<default><default class="out"><joint stiffness="2" armature="0.1"/><default class="in">'
        '<joint stiffness="3"/></default></default></default>',
    ),
    "childclass of a frame": body(
        f'<frame childclass="k"><joint axis="0 1 0"/>{GEOM}</frame>',
        '<default><default class="k"><joint armature="0.3" damping="1"/></default></default>',
    ),
    "frame in a frame": body(
        f'<frame pos="0 0 1" euler="10 0 0"><frame axisangle="1 0 1 40" pos="1 0 0">{HINGE}{GEOM}'
        "</frame></frame>"
    ),
    "two compilers": body(HINGE + GEOM, '<compiler angle="radian"/><compiler eulerseq="zxz"/>'),
    "a mocap body": world(
        f'<body mocap="true" pos="1 0 0"><geom size="0.1"/></body><body>{HINGE}{GEOM}</body>'
    ),
    "gravcomp of a link": body(
        HINGE + GEOM + SECOND.replace("<body ", '<body gravcomp="1.3" '),
        '<option gravity="1 0 -9"/>',
    ),
    "timed springs": body(
        '<joint axis="0 1 1" pos="0.1 0 0.3" ref="20" springref="5" springdamper="0.5 0.7" '
        f'armature="0.1"/>{GEOM}<body pos="0.1 0 -0.3" euler="0 40 0"><joint type="slide" '
        'ref="0.1" springdamper="0.3 1" stiffness="3"/><joint axis="1 0 1" springdamper="0.3 1"/>'
        f'{GEOM}<body><joint type="ball"/><geom size="0.1" pos="0.2 0 0"/></body></body>',
        '<compiler settotalmass="4"/>',
    ),
    "a timed spring on a free body": world(
        f'<body><freejoint/>{GEOM}<body pos="1 0 0"><joint springdamper="0.2 0.5"/>{GEOM}</body>'
        "</body>"
    ),
    "a capsule in a medium": body(
        '<freejoint/><geom type="capsule" size="0.04 0.2" pos="0.05 0 -0.2" euler="0 15 0"/>',
        '<option density="1000" viscosity="0.9" wind="1 0 -2"/>',
    ),
    "a tree in a medium": body(
        f'<joint type="ball" pos="0.1 0 0.2"/>{GEOM}<body pos="0.1 0 -0.3" euler="0 40 0"><joint '
        f'type="slide" axis="1 0 0" ref="0.1"/><joint axis="1 0 1" ref="20"/>{GEOM}<body '
        'pos="0 0 1" euler="20 0 0"><geom size="0.1" pos="0.2 0 0"/></body></body>',
        '<option density="1000" viscosity="0.9" wind="1 2 3"/>',
    ),
    "a free tree in a medium": body(
        f"<freejoint/>{GEOM}{SECOND}", '<option density="1.2" viscosity="0.00002"/>'
    ),
    "polynomials of a spring": body(
        '<joint type="slide" axis="1 1 0" ref="0.1" springref="0.3" stiffness="3 0.5 0.2"/>' + GEOM
    ),
    "polynomials of a damper": body('<joint axis="0 1 0" damping="3 0.5 0.2"/>' + GEOM),
    "polynomials of a class": body(
        '<joint axis="0 1 0" stiffness="3" damping="1"/>' + GEOM,
        '<default><joint stiffness="1 2 3" damping="0 0 4"/></default>',
    ),
    "slack along joints": tendon(
        '<fixed name="t" stiffness="5 1" springlength="-0.1 0.3" damping="0.2 0.1">'
        '<joint joint="h" coef="1"/><joint joint="s" coef="-0.5"/></fixed>'
    ),
    "slack along a joint": tendon(
        '<fixed name="t" stiffness="5" springlength="0 0.3"><joint joint="h" coef="2"/></fixed>'
    ),
    "a length below zero": tendon(
        '<fixed name="t" stiffness="5" springlength="-0.3"><joint joint="h" coef="2"/>'
        '<joint joint="s" coef="1"/></fixed>'
    ),
    "slack between points": tendon(
        '<spatial name="t" stiffness="50" springlength="0 0.4"><site site="w"/><site site="t"/>'
        "</spatial>"
    ),
    "pushed apart": tendon(
        '<spatial name="t" stiffness="50" springlength="2 3"><site site="w"/><site site="t"/>'
        "</spatial>"
    ),
    "armature along a joint": tendon(
        '<fixed name="t" armature="0.3"><joint joint="h" coef="2"/></fixed>',
        '<actuator><motor tendon="t" armature="0.1" gear="3"/></actuator>',
    ),
    "quaternion of any length": world(f'<body quat="2 -1 0.5 3">{HINGE}{GEOM}{SECOND}</body>'),
    "zaxis down": world(f'<body zaxis="0 0 -2">{HINGE}{GEOM}</body>'),
    "zaxis aslant": world(f'<body zaxis="1 2 -2">{HINGE}{GEOM}</body>'),
    "ellipsoid of two points": body(
        HINGE + '<geom type="ellipsoid" size="0.1" fromto="0 0 0 0 -1 -2"/>'
    ),
}

BENT = '<site site="w"/><site site="m"/><site site="t"/>'
SLUNG = SITED.replace("<body ", '<site name="m" pos="0.1 0.1 0.2"/><body ')
"""Between the ends of a tendon another site, so that it is not straight."""


def bent(tags: str, after: str = "", joint: str = HINGE) -> str:
    inside = f'<site name="w" pos="0.3 0 1"/>{TIP.format(joint + GEOM + SLUNG)}'
    return f"<mujoco><worldbody>{inside}</worldbody><tendon>{tags}</tendon>{after}</mujoco>"


STILL = '<flag spring="disable" damper="disable"/>'
NESTED = (
    '<default><geom quat="1 2 0 0"/><default class="out"><joint stiffness="1 2 3"/>'
    '<geom type="capsule" size="0.05 0.1"/><default class="in"><joint stiffness="4"/>'
    '<geom size="0.08" euler="10 20 30"/></default></default></default>'
)

TEXTS |= {
    "parts of a class in a class": body(f'<joint class="in"/>{GEOM}<geom class="in"/>', NESTED),
    "drives of classes": tendon(
        "", '<actuator><position joint="h"/><motor class="k" joint="s"/></actuator>'
    ).replace(
        "<worldbody>",
        '<default><position armature="0.07"/><default class="k"><motor gear="3" armature="0.02"/>'
        "</default></default><worldbody>",
    ),
    "damping of a drive and its powers": tendon(
        '<fixed name="f"><joint joint="s" coef="3"/></fixed>',
        '<actuator><motor joint="h" damping="0.1 0.2 0.3" gear="-2"/>'
        '<motor tendon="f" damping="0.1 0.2" gear="2"/></actuator>',
    ),
    "inertial in a frame": body(
        f'{HINGE}{GEOM}<frame pos="0.1 0 0" euler="0 90 0"><inertial pos="0.1 0.2 0.3" mass="2" '
        'diaginertia="0.1 0.2 0.25"/></frame>'
    ),
    "stated where geoms have no mass": body(
        f'{HINGE}<inertial pos="0.1 0 0" mass="2" diaginertia="0.1 0.1 0.1"/>'
        '<geom size="0.1" mass="0"/>',
        '<compiler inertiafromgeom="true"/>',
    ),
    "least mass of what has none": body(
        f'{HINGE}{GEOM}<body pos="0.1 0.2 0.3"><joint axis="0 0 1" pos="0.3 0 0"/></body>',
        '<compiler boundmass="2" boundinertia="0.1"/>',
    ),
    "neither springs nor dampers": world(
        f'<body gravcomp="1">{HINGE}{GEOM}</body>', f'<option density="1.2">{STILL}</option>'
    ),
    "what is not passive any more": world(
        f'<body gravcomp="1"><joint axis="0 1 0" stiffness="2"/>{GEOM}</body>',
        '<option density="1.2"><flag spring="disable"/></option>',
    ),
    "flags set again": body(
        f'<joint axis="0 1 0" stiffness="3"/>{GEOM}',
        '<option><flag spring="disable" gravity="disable"/></option>'
        '<option><flag spring="enable" gravity="enable"/></option>',
    ),
    "one name of a joint and a tendon": tendon(
        '<fixed name="h" stiffness="2" damping="3"><joint joint="h" coef="2"/></fixed>'
    ).replace('name="h" axis', 'name="h" stiffness="1" damping="1" axis'),
    "powers along a joint": tendon(
        '<fixed stiffness="2 1 0.3" damping="3 0.1 0.2" springlength="0.2">'
        '<joint joint="h" coef="-2"/></fixed>'
    ),
    "armature on separate branches": world(f"{PAIR}{THIRD}").replace(
        "</worldbody>",
        '</worldbody><tendon><fixed name="f" armature="0.3" stiffness="2" damping="0.4">'
        f'{ALONG}<joint joint="k" coef="1.5"/></fixed></tendon><actuator><motor tendon="f" '
        'gear="2" armature="0.1"/></actuator>',
    ),
    "a spring that pushes": body(HINGE.replace('"h"', '"h" stiffness="-2"') + GEOM + SECOND),
    "plugins of drives": body(
        HINGE + GEOM, '<extension><plugin plugin="mujoco.pid"/></extension>'
    ).replace(
        "</worldbody>",
        '</worldbody><actuator><plugin joint="h" plugin="mujoco.pid" armature="0.1"/></actuator>',
    ),
    "armature along joints": tendon(f'<fixed armature="0.3" stiffness="2 1">{ALONG}</fixed>'),
    "drives along joints": tendon(
        f'<fixed name="f">{ALONG}</fixed>',
        '<actuator><motor tendon="f" armature="0.2" gear="2"/><motor tendon="f" armature="0.3" '
        'damping="0.4"/></actuator>',
    ),
    "three sites": bent(f'<spatial stiffness="20" damping="1">{BENT}</spatial>'),
    "three sites, slack": bent(f'<spatial stiffness="20 3" springlength="0.2 1">{BENT}</spatial>'),
    "three sites, heavy": bent(
        f'<spatial armature="0.5" springlength="0.2" damping="1 0.3">{BENT}</spatial>'
    ),
    "pulleys": bent(
        f'<spatial stiffness="20" armature="0.3">{BENT}<pulley divisor="2"/>{STRAIGHT}'
        f'<pulley divisor="3"/><site site="w"/><site site="m"/></spatial>'
    ),
    "powers of a straight tendon": bent(f'<spatial stiffness="20 5 1">{STRAIGHT}</spatial>'),
    "a drive of a straight tendon": bent(
        f'<spatial name="f">{STRAIGHT}</spatial>',
        '<actuator><motor tendon="f" armature="0.3" damping="0.3" gear="2"/></actuator>',
    ),
    "straight where springs are at rest": bent(
        f'<spatial stiffness="3">{STRAIGHT}</spatial>',
        joint='<joint name="h" axis="1 1 0" ref="10" springref="30" stiffness="2"/>',
    ),
    "timed springs and tendons": bent(
        f'<spatial armature="0.5">{BENT}</spatial><fixed armature="0.4">{ALONG}</fixed>',
        joint='<joint name="h" axis="1 1 0" ref="10" springdamper="0.3 0.4"/>',
    ),
    "a tendon on a free body": world(
        f'<body><freejoint/>{GEOM}<site name="w"/><body pos="0.2 0 0">{HINGE}{GEOM}{SLUNG}</body>'
        "</body>"
    ).replace(
        "</worldbody>",
        f'</worldbody><tendon><spatial stiffness="2" armature="0.4">{BENT}</spatial></tendon>',
    ),
    "a straight tendon from a free body": world(
        f'<body><freejoint/>{GEOM}<site name="w"/></body><body pos="1 0 0">{GEOM}'
        '<joint type="ball"/><site name="t" pos="0.1 0.2 0.3"/></body>'
    ).replace(
        "</worldbody>",
        f'</worldbody><tendon><spatial stiffness="2">{STRAIGHT}</spatial></tendon>',
    ),
}


LIMB = (
    '<mujoco model="limb"><compiler angle="radian" eulerseq="zyx" boundmass="0.9"/>'
    '<option gravity="0 0 -1"/><default><joint stiffness="3"/><geom density="500"/>'
    '<default class="soft"><joint stiffness="0.7"/></default></default><asset>'
    '<mesh name="tetrahedron" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset><worldbody>'
    '<geom size="0.3" pos="0.1 0.2 0"/><frame name="f" pos="0 0 5" childclass="soft">'
    '<body name="a" pos="1 2 3" euler="0.1 0.2 0.3"><joint name="j" axis="0 1 0" ref="0.5"/>'
    '<geom type="mesh" mesh="tetrahedron"/><body name="b" pos="0.3 0 0">'
    '<joint name="k" axis="1 1 0"/><geom size="0.1" pos="0 0.2 0.3"/></body></body></frame>'
    '<body name="other"><joint name="p" axis="0 1 0"/><geom size="0.1" pos="1 0 0"/></body>'
    '</worldbody><actuator><motor tendon="pair" gear="2" armature="0.2"/></actuator><tendon>'
    '<fixed name="one" stiffness="2"><joint joint="k" coef="1.5"/></fixed>'
    '<fixed name="pair"><joint joint="j" coef="1"/><joint joint="k" coef="1"/></fixed></tendon>'
    "</mujoco>"
)
ATTACHED = {
    "all of a model": '<attach model="limb" prefix="x_"/>',
    "all without a prefix": '<attach model="limb" prefix=""/>',
    "in a body that moves": f'<body>{HINGE}{GEOM}<attach model="limb" prefix="x_"/></body>',
    "a body": '<frame euler="10 20 30" childclass="main">'
    '<attach model="limb" body="a" prefix="x_"/></frame>',
    "a frame": '<attach model="limb" frame="f" prefix="x_"/>',
    "twice": '<attach model="limb" prefix="x_"/><attach model="limb" body="b" prefix="y_"/>',
    "a model in a model": '<attach model="pair" prefix="y_"/>',
    "in a replicate": '<replicate count="3" offset="1 0 0" euler="0 0 30">'
    '<attach model="limb" body="a" prefix="x_"/></replicate>',
    "all in a replicate": '<replicate count="2" offset="9 0 0" sep="_">'
    '<attach model="limb" prefix="x_"/></replicate>',
    "in a replicated body of a replicate": '<replicate count="2" offset="0 2 0"><replicate '
    f'count="2" euler="0 0 20"><body name="r">{HINGE}{GEOM}<frame pos="1 0 0">'
    '<attach model="limb" frame="f" prefix="x_"/></frame></body></replicate></replicate>',
}


@pytest.mark.parametrize("name", ATTACHED)
def test_models_are_attached_as_mujoco_does(name: str) -> None:
    Path("limb.xml").write_text(LIMB, encoding="utf-8")
    asset = '<compiler boundmass="0.2"/><default><geom density="2000"/></default>'
    asset += '<asset><model name="limb" file="limb.xml"/>{}</asset>'
    pair = world('<attach model="limb" prefix="z_"/><body>' + HINGE + GEOM + "</body>", asset)
    Path("pair.xml").write_text(pair.format(""), encoding="utf-8")
    text = world(ATTACHED[name], asset).format('<model name="pair" file="pair.xml"/>')
    Path("main.xml").write_text(text, encoding="utf-8")
    expect_the_same(read_mjcf("main.xml"), text)


@pytest.mark.parametrize("part", ['body="b"', 'frame="f"'])
def test_a_model_attaches_a_part_of_its_own_as_mujoco_does(part: str) -> None:
    text = world(
        f'<frame name="f" pos="0 0 0.1" euler="0 20 0" childclass="k">{PAIR}</frame>'
        f'<frame pos="0 1 0" euler="0 0 30"><attach {part} prefix="x_"/></frame>',
        '<default><default class="k"><joint damping="0.3"/></default></default>',
    ).replace(
        "</worldbody>",
        f'</worldbody><tendon><fixed name="t" armature="0.2" stiffness="3">{ALONG}</fixed>'
        '</tendon><actuator><motor tendon="t" armature="0.1"/></actuator>',
    )
    expect_the_same(read_mjcf(text), text)


@pytest.mark.parametrize("policy", ["", 'conflict="warning"', 'conflict="merge"'])
def test_options_of_attached_models_count_as_mujoco_lets_them(policy: str) -> None:
    Path("limb.xml").write_text(LIMB, encoding="utf-8")
    asset = f'<compiler {policy}/><asset><model name="limb" file="limb.xml"/></asset>'
    text = world('<attach model="limb" prefix="x_"/>', asset)
    Path("main.xml").write_text(text, encoding="utf-8")
    if "merge" not in policy:
        expect_the_same(read_mjcf("main.xml"), text)
        return
    assert mujoco.MjModel.from_xml_string(text).opt.gravity[2] == -1
    with pytest.raises(mq.InputError, match=r"conflict='merge' of <compiler>, which is not"):
        read_mjcf("main.xml")


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


@pytest.mark.parametrize("form", ["free", "ball"])
def test_armature_and_springs_of_free_and_ball_joints_have_mujocos_energy(form: str) -> None:
    joint = f'<joint type="{form}" armature="0.4" stiffness="2 1 0.5"/>'
    text = world(f'<body name="b" pos="0.1 0.2 -0.3" euler="9 8 7">{joint}{GEOM}{SECOND}</body>')
    mechanism, random = read_mjcf(text), np.random.default_rng(3)
    engine = mq.Reference(mechanism)
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.enableflags = int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    data, offs = mujoco.MjData(model), []
    for _ in range(5):
        q, v = mechanism.neutral(), random.uniform(-1, 1, mechanism.nv)
        q[:-5], turned = random.uniform(-1, 1, len(q) - 5), random.uniform(-1, 1, 4)
        q[-5:-1] = turned / np.linalg.norm(turned)
        mass, bias, passive = norm(text, q, v)
        close(engine.mass_matrix(q), mass, mass)
        close(engine.inverse_dynamics(q, v, np.zeros(mechanism.nv)), bias - passive, mass)
        data.qpos[:] = q
        data.qpos[-5:-1] = np.roll(q[-5:-1], 1)
        mujoco.mj_forward(model, data)
        energy = engine.energy(q, v)
        offs.append(energy.potential - data.energy[0])
    assert np.ptp(offs) < 1e-9


def test_gravity_compensated_by_actuators_is_told() -> None:
    text = '<body gravcomp="1"><joint axis="0 1 0" actuatorgravcomp="true"/>' + GEOM + "</body>"
    mechanism = read_mjcf(world(text))
    assert "bounds of actuators on the compensation of gravity (1)" in mechanism.about
    assert mq.Reference(mechanism).acceleration([0.3]) == pytest.approx([0.0], abs=1e-12)
    (found,) = read_by(mq.read(world(text)), ("mujoco",), 0)
    assert found.alike == ("mecanique",)


def test_springs_of_a_joint_called_as_time_are_timed() -> None:
    text = body(HINGE.replace('"h"', '"t" springdamper="0.3 0.5"') + GEOM + SECOND)
    (reading,) = read_by(mq.read(text), ("mujoco",), 0)
    assert (reading.remarks, reading.alike) == ((), ("mecanique",))


@pytest.mark.parametrize("leader", ["h", "s"])
def test_the_armature_of_a_tendon_acts_where_a_joint_follows(leader: str) -> None:
    ways = '<joint joint="h" coef="0.5"/><joint joint="s" coef="-1.5"/>'
    follower = {"h": "s", "s": "h"}[leader]
    tied = f'<joint joint1="{follower}" joint2="{leader}" polycoef="0.1 0.4 0.2"/>'
    parts = f'<tendon><fixed armature="0.3">{ways}</fixed></tendon><equality>{tied}</equality>'
    text = body(HINGE + GEOM + SECOND).replace("</worldbody>", f"</worldbody>{parts}")
    (reading,) = read_by(mq.read(text), ("mujoco",), 0)
    assert (reading.remarks, reading.alike) == ((), ("mecanique",))


@pytest.mark.parametrize("name", [*(k for k in TEXTS if "sites" in k), "armature along joints"])
def test_the_energy_of_tendons_is_mujocos(name: str) -> None:
    mechanism, random = read_mjcf(TEXTS[name]), np.random.default_rng(3)
    model = mujoco.MjModel.from_xml_string(TEXTS[name])
    model.opt.enableflags = int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    data, offs = mujoco.MjData(model), []
    for q, v in random.uniform(-1, 1, (5, 2, mechanism.nv)):
        data.qpos[:], data.qvel[:] = q, v
        mujoco.mj_forward(model, data)
        energy = mq.Reference(mechanism).energy(q, v)
        potential, kinetic = data.energy.tolist()
        assert energy.kinetic == pytest.approx(kinetic, rel=1e-12)
        offs.append(energy.gravity + energy.springs - potential)
    assert np.ptp(offs) < 1e-9


@pytest.mark.parametrize("name", TEXTS)
def test_mass_bias_and_passive_forces_are_mujocos(name: str) -> None:
    expect_the_same(read_mjcf(TEXTS[name]), TEXTS[name])


def expect_the_same(mechanism: mq.Mechanism, text: str) -> None:
    random = np.random.default_rng(3)
    engine, bare = mq.Reference(mechanism), mq.Reference(replace(mechanism, forces=()))
    for _ in range(5):
        q = mechanism.neutral() + random.uniform(-1, 1, mechanism.nq)
        for joint in mechanism.joints:
            if joint.quaternion:
                start = list(mechanism.coordinates).index(joint.quaternion[0])
                q[start : start + 4] /= np.linalg.norm(q[start : start + 4])
        v = random.uniform(-1, 1, mechanism.nv)
        mass, bias, passive = norm(text, q, v)
        still = np.zeros(mechanism.nv)
        close(engine.mass_matrix(q), mass, mass)
        total = engine.inverse_dynamics(q, v, still)
        alone = bare.inverse_dynamics(q, v, still)
        close(alone, bias, mass)
        close(np.asarray(alone) - total, passive, mass)


def test_the_pull_of_contacts_is_told_and_compared_with_nothing() -> None:
    """MuJoCo counts it among the passive forces, where geoms are near enough."""
    ball = '<geom size="0.5" adhesion="1.5" gap="0.1"/>'
    text = world(f'{ball}<body pos="0.1 0 0">{HINGE}{ball}</body>')
    mechanism = mq.read(text)
    assert "pulls of contacts (2)" in mechanism.about
    (reading,) = read_by(mechanism, ("mujoco",), 0)
    assert reading.worst is not None
    assert reading.worst < 1e-12


def test_the_spring_of_a_ball_rests_where_it_is_not_turned() -> None:
    text = body(
        '<joint type="ball" stiffness="3"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
    )
    mechanism = read_mjcf(text)
    engine = mq.Reference(mechanism)
    assert np.abs(engine.acceleration(mechanism.neutral())).max() < 1e-15
    assert mq.verify(mechanism, samples=5).agrees


@pytest.mark.parametrize("form", ["sphere", "capsule", "cylinder", "ellipsoid", "box"])
def test_a_geom_may_be_fitted_to_the_box_around_a_mesh(form: str) -> None:
    corners = "0 0 0 1 0 0 0 1 0 0 0 4 .3 .4 -2"
    text = body(
        f'{HINGE}<geom type="{form}" mesh="m" fitscale="1.2" pos="0.1 0.2 0" euler="10 20 30"/>'
        f'<geom type="{form}" mesh="m" shellinertia="true" mass="3"/>',
        f'<compiler fitaabb="true"/><asset><mesh name="m" refquat="1 0.2 0.1 0" '
        f'vertex="{corners}"/></asset>',
    )
    expect_the_same(read_mjcf(text), text)


def test_a_capsule_fitted_to_the_box_around_a_cube_is_refused() -> None:
    """MuJoCo refuses it, too: between the caps nothing is left."""
    corners = "0 0 0 1 0 0 0 1 0 0 0 1 1 1 0 1 0 1 0 1 1 1 1 1"
    text = body(
        f'{HINGE}<geom type="{{}}" mesh="m"/>',
        f'<compiler fitaabb="true"/><asset><mesh name="m" vertex="{corners}"/></asset>',
    )
    expect_the_same(read_mjcf(text.format("cylinder")), text.format("cylinder"))
    with pytest.raises(mq.InputError, match="a capsule fitted to a mesh that is wider than long"):
        read_mjcf(text.format("capsule"))


def test_a_capsule_fitted_to_a_mesh_without_a_longest_axis_is_refused() -> None:
    """Of (0, e₁, e₂, e₃) two moments are equal, about (1, 1, 1) the largest: no axis is longest."""
    corners = "0 0 0 1 0 0 0 1 0 0 0 {}"
    asset = f'<asset><mesh name="m" vertex="{corners}"/></asset>'
    text = body('<freejoint/><geom type="{}" mesh="m"/>').replace(
        "<worldbody>", asset + "<worldbody>"
    )
    for form in ("capsule", "cylinder"):
        expect_the_same(read_mjcf(text.format(1.5, form)), text.format(1.5, form))
        with pytest.raises(mq.InputError, match=f"axis of a {form} fitted to a mesh as wide"):
            read_mjcf(text.format(1, form))
    expect_the_same(read_mjcf(text.format(1, "ellipsoid")), text.format(1, "ellipsoid"))
