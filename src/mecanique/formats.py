"""Descriptions of robots by their content: URDF, xacro or MJCF."""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from mecanique.errors import InputError
from mecanique.mjcf import read_mjcf
from mecanique.model.forces import JointDamper
from mecanique.model.mechanism import Mechanism
from mecanique.urdf.findings import Report
from mecanique.urdf.parse import MOST_BYTES, parse
from mecanique.urdf.read import read_urdf
from mecanique.urdf.reading.letters import with_armature, with_letters


def read(
    path_or_text: str | os.PathLike[str],
    *,
    damping: bool = True,
    armature: float | Mapping[str, float] | None = None,
    parameters: str | Collection[str] = (),
    **of_urdf: Any,
) -> Mechanism:
    """Return the mechanism that a file describes: URDF or xacro, or MJCF, MuJoCo's own format.

    The format follows from the content. Of MJCF are read: settings of the compiler, classes of
    defaults, files included, bodies with any joints, frames, replicates, inertias as written or
    from geoms and meshes by each of MuJoCo's rules, springs, dampers and rotors in joints, along
    tendons and of actuators, gravity compensation, and the constraints `connect`, `weld`, `joint`
    and `tendon`. Coordinates are MuJoCo's, quaternions with w last;
    velocities of a free body are in its own axes. A body's frame stands at the anchor of its last
    joint. What the dynamics do without is listed in `mechanism.about`.

    Args:
        path_or_text: the path of the file, or its text.
        damping: whether the damping of joints is read.
        armature: inertia of the rotors seen at the joints, instead of what is written: one number
            for all joints with one coordinate, or by name of the joint [kg·m² or kg].
        parameters: what gets letters, as in `read_urdf`.
        of_urdf: further arguments of `read_urdf`, for URDF and xacro alone.

    Returns:
        The mechanism.

    Raises:
        UrdfError: if the text is not well-formed, or URDF with errors.
        InputError: if an argument is not what is expected, or the text holds what is not read.
        UnknownNameError: if a joint of the armatures, a letter or an argument does not exist.
        MechanismError: if what is described is not sound.

    Example:
        >>> pendulum = '''<mujoco><worldbody><body name="rod"><joint name="q" axis="0 -1 0"/>
        ... <geom type="capsule" size="0.01" fromto="0 0 0 0 0 -1" mass="1"/>
        ... </body></worldbody></mujoco>'''
        >>> mq.read(pendulum).nv
        1
    """
    if not isinstance(path_or_text, (str, os.PathLike)) or not os.fspath(path_or_text):
        raise InputError(f"expected the path of a file or a text, got {path_or_text!r}")
    if not is_mjcf(path_or_text):
        options = {"damping": damping, "armature": armature, "parameters": parameters}
        return read_urdf(path_or_text, **options, **of_urdf)  # type: ignore[arg-type]
    if of_urdf:
        raise InputError(f"{', '.join(of_urdf)} can be given for URDF and xacro alone, not MJCF")
    mechanism = read_mjcf(path_or_text)
    if not damping:
        kept = tuple(force for force in mechanism.forces if not isinstance(force, JointDamper))
        mechanism = replace(mechanism, forces=kept)
    return with_letters(with_armature(mechanism, armature), parameters)


def is_mjcf(path_or_text: str | os.PathLike[str]) -> bool:
    """Return whether a file or text is MJCF, by its outermost element."""
    data: str | bytes
    if isinstance(path_or_text, str) and "<" in path_or_text:
        data = path_or_text
    else:
        path = Path(path_or_text)
        if not path.is_file():
            return False
        with path.open("rb") as file:
            data = file.read(MOST_BYTES + 1)
        if b"<mujoco" not in data:
            return False
    root = parse(data, Report(None))
    return root is not None and root.tag == "mujoco"
