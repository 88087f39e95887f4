"""Random damage to URDF texts, and what must hold of the outcome."""

from __future__ import annotations

import math
import random
import re
from collections.abc import Iterator

import mecanique as mq
from mecanique.urdf.lint import as_json, as_sarif, as_text, lint, mend
from mecanique.urdf.read import read_urdf

_ATTRIBUTE = re.compile(r"\s[\w:]+\s*=\s*(?:\"[^\"]*\"|'[^']*')")
_VALUE = re.compile(r"=\s*(\"[^\"]*\"|'[^']*')")
_TAG = re.compile(r"<[^<>]*>")

STRANGE = (
    *(
        "nan",
        "inf",
        "-inf",
        "-1",
        "0",
        "-0",
        "1e400",
        "-1e308",
        "1e308",
        "1e154",
        "1e49",
        "1e-320",
        "5e-324",
        "1e-170",
    ),
    *(
        "1e9",
        "1e16",
        "abc",
        "1,5",
        "1.5kg",
        "",
        " ",
        "0 0 0",
        "1 2 3",
        "1e-9 0 0",
        "nan 0 0",
        "0 0 1e300",
        "1 2",
        "0x10",
    ),
    *(
        "${m}",
        "$(find x)",
        "1_000",
        "١",
        "é手",
        "‮",
        "\u200b",
        "&lt;",
        "&amp;amp;",
        "&#0;",
        "&#xD800;",
        "&lol;",
    ),
    *(
        "../../etc/passwd",
        "package://a/../../../etc/passwd",
        "file:///dev/zero",
        "/dev/stdin",
        "a" * 5000,
        "9" * 999,
    ),
    *(
        "revolute",
        "continuous",
        "prismatic",
        "planar",
        "floating",
        "fixed",
        "ball",
        "universal",
        "screw",
        "universe",
    ),
    *("t", "world", "x'", "base", "j0", "j1", "l0", "l1"),
)

_BOMB = '<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa">' + "".join(
    f'<!ENTITY {chr(98 + k)} "{f"&{chr(97 + k)};" * 10}">' for k in range(9)
)
_PIECES = (
    f"{_BOMB}]>",
    '<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]>',
    "<![CDATA[ <link/> ]]>",
    "<!-- -->",
    "<?pi ?>",
    "<a>" * 100,
    '<mimic joint="j0"/>',
    '<mimic joint="j1" multiplier="-1"/>',
    '<axis xyz="0 0 0"/>',
    '<link name="l9"/>',
    "<inertial/>",
    "<drake:tendon_constraint/>",
    "\0",
    "\ud800",
    "\x0b",
    "</robot>",
    "<robot>",
)


def mutated(text: str, rng: random.Random, count: int) -> str:
    """Return the text after some random mutations."""
    for _ in range(count):
        text = rng.choice(_MUTATIONS)(text, rng)
    return text


def _spans(pattern: re.Pattern[str], text: str, group: int = 0) -> list[tuple[int, int]]:
    return [match.span(group) for match in pattern.finditer(text)]


def _replace(
    pattern: re.Pattern[str], text: str, rng: random.Random, new: str, group: int = 0
) -> str:
    spans = _spans(pattern, text, group)
    if not spans:
        return text
    start, end = rng.choice(spans)
    return text[:start] + new + text[end:]


def _drop_attribute(text: str, rng: random.Random) -> str:
    return _replace(_ATTRIBUTE, text, rng, "")


def _strange_value(text: str, rng: random.Random) -> str:
    return _replace(_VALUE, text, rng, f'"{rng.choice(STRANGE)}"', 1)


def _strange_number(text: str, rng: random.Random) -> str:
    """Damage one number of several."""
    return _replace(
        re.compile(r"(?<=[\s\"])[-+\d.eE]+(?=[\s\"])"), text, rng, rng.choice(STRANGE[:22])
    )


def _drop_tag(text: str, rng: random.Random) -> str:
    return _replace(_TAG, text, rng, "")


def _swap_values(text: str, rng: random.Random) -> str:
    spans = _spans(_VALUE, text, 1)
    if len(spans) < 2:
        return text
    (a, b), (c, d) = sorted(rng.sample(spans, 2))
    return text[:a] + text[c:d] + text[b:c] + text[a:b] + text[d:]


def _copy_value(text: str, rng: random.Random) -> str:
    spans = _spans(_VALUE, text, 1)
    if not spans:
        return text
    start, end = rng.choice(spans)
    return _replace(_VALUE, text, rng, text[start:end], 1)


def _copy_tag(text: str, rng: random.Random) -> str:
    spans = _spans(_TAG, text)
    if not spans:
        return text
    start, end = rng.choice(spans)
    return text[:end] + text[start:end] + text[end:]


def _copy_line(text: str, rng: random.Random) -> str:
    lines = text.splitlines(keepends=True)
    if not lines:
        return text
    lines.insert(rng.randrange(len(lines) + 1), rng.choice(lines))
    return "".join(lines)


def _truncate(text: str, rng: random.Random) -> str:
    return text[: rng.randrange(len(text) + 1)]


def _insert(text: str, rng: random.Random) -> str:
    place = rng.choice([end for _, end in _spans(_TAG, text)] or [0])
    return text[:place] + rng.choice(_PIECES) + text[place:]


def _rename(text: str, rng: random.Random) -> str:
    tags = re.findall(r"</?([\w:]+)", text) or ["robot"]
    return re.sub(rf"(?<=[</]){re.escape(rng.choice(tags))}(?=[\s/>])", rng.choice(tags), text)


def _noise(text: str, rng: random.Random) -> str:
    place = rng.randrange(len(text) + 1)
    return (
        text[:place]
        + chr(rng.choice((0, 9, 34, 38, 39, 60, 62, 127, 233, 0x202E, 0xFFFF)))
        + text[place:]
    )


_MUTATIONS = (
    *(_strange_value, _strange_number, _swap_values, _copy_value, _drop_attribute) * 4,
    *(_drop_tag, _copy_tag, _copy_line, _insert, _rename, _noise, _truncate),
)


def outcome(text: str) -> str:
    """Read and lint a text; return "read" or "refused", or fail if anything else comes of it."""
    if not text:
        return "refused"  # nothing is neither a path nor a text
    findings = lint(text)
    errors = [finding for finding in findings if finding.severity == "error"]
    assert all(finding.line >= 1 for finding in findings)
    assert as_text(findings)
    assert as_json(findings)
    assert as_sarif(findings)
    mended = mend(text)
    if mended != text:
        assert len([f for f in lint(mended) if f.severity == "error"]) <= len(errors)
    try:
        read_urdf(text, strict=True)
    except mq.UrdfError:
        assert errors
    else:
        assert not errors
    try:
        mechanism = read_urdf(text)
    except mq.UrdfError:
        assert any(finding.stops for finding in errors)
        return "refused"
    assert not any(finding.stops for finding in errors)
    assert all(map(math.isfinite, _numbers(mechanism)))
    assert len(mechanism.tree) == len(mechanism.joints) == len(mechanism.bodies) - 1
    assert len(set(mechanism.coordinates)) == mechanism.nq
    return "read"


def _numbers(mechanism: mq.Mechanism) -> Iterator[float]:
    for body in mechanism.bodies:
        yield from (body.mass, *body.center, *body.inertia)
    for joint in mechanism.joints:
        yield from (*joint.origin.xyz, *joint.origin.rpy)
        if isinstance(joint, (mq.Revolute, mq.Prismatic)):
            yield from (*joint.axis, joint.armature)
    for force in mechanism.forces:
        yield from (value for value in vars(force).values() if isinstance(value, float))


SAMPLE = """<?xml version="1.0"?>
<robot name="sample" xmlns:drake="http://drake.mit.edu">
  <material name="red"><color rgba="1 0 0 1"/></material>
  <link name="l0"><visual><geometry>\
<mesh filename="package://a/b.stl" scale="1 1 1"/></geometry></visual></link>
  <link name="l1">
    <inertial><origin xyz="0 0 0.5" rpy="0.1 0.2 0.3"/><mass value="1"/>
      <inertia ixx="0.1" iyy="0.1" izz="0.02" ixy="0.001" ixz="0" iyz="0"/></inertial>
    <visual><origin xyz="0 0 0.5"/><geometry><box size="0.1 0.1 1"/></geometry>\
<material name="red"/></visual>
    <collision><geometry><sphere radius="0.1"/></geometry></collision>
  </link>
  <link name="l2">
    <inertial><origin xyz="0 0 0.1"/><mass value="0.5"/>
      <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><cylinder radius="0.1" length="0.3"/></geometry></visual>
  </link>
  <link name="l3"/>
  <joint name="j0" type="revolute">
    <origin xyz="0 0 0.2" rpy="0 0 1"/><parent link="l0"/><child link="l1"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="10" velocity="5"/><dynamics damping="0.1" friction="0.2"/>
  </joint>
  <joint name="j1" type="continuous">
    <origin xyz="0 0 1"/><parent link="l1"/><child link="l2"/><axis xyz="0 0 1"/>
    <mimic joint="j0" multiplier="2" offset="0.1"/>
  </joint>
  <drake:joint name="j2" type="ball"><parent link="l2"/><child link="l3"/></drake:joint>
  <transmission name="t"><type>transmission_interface/SimpleTransmission</type><joint name="j0"/>
    <actuator name="m"><drake:rotor_inertia value="0.01"/>\
<drake:gear_ratio value="10"/></actuator></transmission>
  <frame name="A" link="l0" xyz="0 0 0.2" rpy="0 0 1"/>
  <drake:linear_bushing_rpy>
    <drake:bushing_frameA name="A"/><drake:bushing_frameC name="l1"/>
    <drake:bushing_torque_stiffness value="1 2 3"/><drake:bushing_torque_damping value="0 1 0"/>
    <drake:bushing_force_stiffness value="0 0 0"/><drake:bushing_force_damping value="0 0 0"/>
  </drake:linear_bushing_rpy>
  <drake:linear_spring_damper>
    <drake:linear_spring_damper_body_A name="l0"/><drake:linear_spring_damper_p_AP value="0 0 0"/>
    <drake:linear_spring_damper_body_B name="l2"/><drake:linear_spring_damper_p_BQ value="0 0 1"/>
    <drake:linear_spring_damper_free_length value="1"/>
    <drake:linear_spring_damper_stiffness value="8"/>\
<drake:linear_spring_damper_damping value="0.5"/>
  </drake:linear_spring_damper>
  <drake:ball_constraint>
    <drake:ball_constraint_body_A name="l0"/><drake:ball_constraint_p_AP value="0 0 0"/>
    <drake:ball_constraint_body_B name="l3"/><drake:ball_constraint_p_BQ value="0 0 1"/>
  </drake:ball_constraint>
</robot>
"""
"""A robot that uses every word of the dialect."""
