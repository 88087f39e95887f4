"""Descriptions of robots by their content: URDF, xacro, MJCF or SDF."""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

from mecanique.errors import InputError
from mecanique.formats.locate import locate
from mecanique.formats.mjcf import read_mjcf
from mecanique.formats.sdf import read_sdf
from mecanique.model.forces import JointDamper
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.origin import Origin
from mecanique.urdf.findings import Report
from mecanique.urdf.parse import MOST_BYTES, parse
from mecanique.urdf.read import read_urdf
from mecanique.urdf.reading.letters import with_armature, with_letters
from mecanique.urdf.reading.packages import list_folders


def read(
    path_or_text: str | os.PathLike[str],
    *,
    damping: bool = True,
    armature: float | Mapping[str, float] | None = None,
    parameters: str | Collection[str] = (),
    **of_urdf: Any,
) -> Mechanism:
    """Return the mechanism that a file describes: URDF, xacro, MJCF (MuJoCo) or SDF (Gazebo).

    The format follows from the content. Of MJCF are read: settings of the compiler, classes of
    defaults, files included, bodies with any joints, frames, replicates, inertias as written or
    from geoms and meshes by each of MuJoCo's rules, springs, dampers and rotors in joints, along
    tendons and of actuators, gravity compensation, and the constraints `connect`, `weld`, `joint`
    and `tendon`. Coordinates are MuJoCo's, quaternions with w last;
    velocities of a free body are in its own axes. A body's frame stands at the anchor of its last
    joint. What the dynamics do without is listed in `mechanism.about`.

    Of SDF 1.3 to 1.12 are read: models in models or included, frames with all their attributes,
    links with their inertias (1 kg and 1 kg m² where none are stated), all joints but `revolute2`
    and `gearbox`, springs and damping in them, limits, mimics and rotors. A joint to a link that
    another joint carries already closes a loop, unless its parent can hang on it. A model that
    nothing joins to the world floats. A link's frame stands at the joint that carries it.

    Args:
        path_or_text: the path of the file, or its text; also what else names a robot: a folder with
            one (as in MuJoCo's menagerie), a zip archive or a file in it, `package://…`, `model://…`,
            or a name of the package robot_descriptions, where that is installed.
        damping: whether the damping of joints is read.
        armature: inertia of the rotors seen at the joints, instead of what is written: one number
            for all joints with one coordinate, or by name of the joint [kg·m² or kg].
        parameters: what gets letters, as in `read_urdf`.
        of_urdf: further arguments of `read_urdf`, for URDF and xacro alone; `package_path` for all
            formats.

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
    if not (isinstance(path_or_text, str) and "<" in path_or_text):
        path_or_text = locate(path_or_text, of_urdf.get("package_path")) or path_or_text
    form = name_format(path_or_text)
    if form == "URDF":
        options = {"damping": damping, "armature": armature, "parameters": parameters}
        return read_urdf(path_or_text, **options, **of_urdf)  # type: ignore[arg-type]
    folders = list_folders(of_urdf.pop("package_path", None))
    if of_urdf:
        raise InputError(f"{', '.join(of_urdf)} can be given for URDF and xacro alone, not {form}")
    mechanism = read_sdf(path_or_text, folders) if form == "SDF" else read_mjcf(path_or_text)
    if not damping:
        kept = tuple(force for force in mechanism.forces if not isinstance(force, JointDamper))
        mechanism = replace(mechanism, forces=kept)
    whole = with_letters(with_armature(mechanism, armature), parameters)
    is_text = isinstance(path_or_text, str) and "<" in path_or_text
    text = path_or_text.encode() if isinstance(path_or_text, str) and is_text else b""
    text = text or Path(path_or_text).read_bytes()
    file = None if is_text else str(path_or_text)
    origin = Origin(file, text, form=form, package_path=tuple(map(str, folders)))
    return replace(whole, origin=origin)


def name_format(path_or_text: str | os.PathLike[str]) -> Literal["URDF", "MJCF", "SDF"]:
    """Return the format of a file or text by its outermost element."""
    data: str | bytes
    if isinstance(path_or_text, str) and "<" in path_or_text:
        data = path_or_text
    else:
        path = Path(path_or_text)
        if not path.is_file():
            return "URDF"
        with path.open("rb") as file:
            data = file.read(MOST_BYTES + 1)
        if b"<mujoco" not in data and b"<sdf" not in data:
            return "URDF"
    root = parse(data, Report(None))
    match "" if root is None else root.tag:
        case "mujoco":
            return "MJCF"
        case "sdf":
            return "SDF"
    return "URDF"
