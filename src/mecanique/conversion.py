"""Convert a description to another format, and prove it: the result is read and compared."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from importlib.util import find_spec
from typing import Any, Literal, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError
from mecanique.formats.mjcf import read_mjcf
from mecanique.formats.mjcf_write import write_mjcf
from mecanique.model.coordinates import Coordinates
from mecanique.model.force_base import BodyLoad
from mecanique.model.forces import JointForce, Spring
from mecanique.model.joint_base import Single
from mecanique.model.mechanism import Mechanism
from mecanique.model.random_positions import draw_positions
from mecanique.reference import Reference
from mecanique.urdf.read import read_urdf
from mecanique.urdf.write import chains, load_lines, write_urdf
from mecanique.verification.engines import read_text_by
from mecanique.verification.verdict import EngineReading
from mecanique.wording import Legible

_STATES = 100
"""Number of random states at which source and result are compared."""

_ALIKE = 1e-12
"""Largest relative difference of a conversion that is proved."""

_ENGINES = {"URDF": ("pinocchio", "mujoco"), "MJCF": ("mujoco",)}
"""The engines of each format that read the result by themselves, where they are installed."""


@final
@dataclass(frozen=True, repr=False)
class Conversion(Legible):
    """A description in another format, with the proof.

    Args:
        form: the format, "URDF" or "MJCF".
        text: the description.
        lost: in a line each, what the format cannot express.
        worst: the largest relative difference in mass matrix and inverse dynamics between the
            source, without what is lost, and the result as mecanique reads it.
        states: number of states at which they were compared.
        readings: what the format's own engines make of the result.

    Example:
        >>> mq.convert(mq.textbook.load("rigid_bar_pendulum"), "URDF", states=5).worst
        0.0
    """

    form: str
    text: str
    lost: tuple[str, ...]
    worst: float
    states: int
    readings: tuple[EngineReading, ...]

    @property
    def _caption(self) -> str:
        return str(self).splitlines()[-1]

    @property
    def proved(self) -> bool:
        """Whether the result, but for what is lost, says what the source says."""
        refused = any(reading.refused or reading.differs for reading in self.readings)
        return self.worst <= _ALIKE and not refused

    def __str__(self) -> str:
        lines = [f"{self.form} cannot express: {line}" for line in self.lost]
        for reading in self.readings:
            lines += reading.sentences() or [f"{reading.engine} reads the result alike."]
        if not any(reading.worst is not None or reading.refused for reading in self.readings):
            lines.append(
                f"No engine of {self.form} itself is installed; mecanique read the result."
            )
        rest = " but for what is listed" if self.lost else ""
        verdict = "says the same as" if self.proved else "differs from"
        lines.append(
            f"The {self.form} {verdict} the source{rest}: largest relative difference "
            f"{self.worst:.1e} at {self.states} states."
        )
        return "\n".join(lines)


def convert(
    mechanism: Mechanism, form: Literal["URDF", "MJCF"], *, states: int = _STATES, seed: int = 0
) -> Conversion:
    """Return a mechanism in a format, read again and compared with what it came from.

    Args:
        mechanism: what to write.
        form: "URDF" or "MJCF".
        states: number of random states at which source and result are compared.
        seed: of the random states.

    Returns:
        The conversion with its verdict.

    Raises:
        InputError: if there is no such format, or the number of states is none.

    Example:
        >>> mq.convert(mq.textbook.load("rigid_bar_pendulum"), "MJCF", states=5).lost
        ()
    """
    if form not in _ENGINES:
        raise InputError(f"expected 'URDF' or 'MJCF' for the format, got {form!r}")
    if not isinstance(states, int) or states < 1:
        raise InputError(f"expected a number of states from 1, got {states!r}")
    if form == "MJCF":
        text, lost = write_mjcf(mechanism)
        result = read_mjcf(text)
    else:
        text, lost = write_urdf(mechanism), tuple(_list_losses(mechanism))
        result = read_urdf(text, gravity=tuple(mechanism.evaluate_all(mechanism.gravity)))
    worst = _difference(mechanism, result, states, seed, whole=not lost)
    installed = [name for name in _ENGINES[form] if find_spec(name) is not None]
    bare = result if form == "MJCF" else _without_rotors(result)
    readings = read_text_by(replace(bare, switching=()), text, installed, seed)
    return Conversion(form, text, lost, worst, states, readings)


def _without_rotors(mechanism: Mechanism) -> Mechanism:
    """Return it as engines read a URDF: without the rotors of drake: tags."""
    joints = [
        replace(joint, armature=0.0) if isinstance(joint, Single) else joint
        for joint in mechanism.joints
    ]
    return replace(mechanism, joints=tuple(joints))


def _list_losses(mechanism: Mechanism) -> Iterator[str]:
    """Say what a URDF of the mechanism has in comments alone."""
    yield from load_lines(mechanism)
    for force in mechanism.forces:
        if isinstance(force, Spring) and not mechanism.evaluate(force.free_length) > 0:
            yield f"spring {force.name}: a free length of zero"
    result = read_urdf(write_urdf(mechanism))
    of_joints = {name for joint in mechanism.joints for name in joint.coordinates}
    if result.nv != mechanism.nv or not of_joints >= set(mechanism.coordinates):
        for name, law in mechanism.coordinates.driven.items():
            yield f"{name} = {law}"


def _difference(
    mechanism: Mechanism, result: Mechanism, states: int, seed: int, *, whole: bool
) -> float:
    """Return the largest relative difference of the trees' matrices and inverse dynamics."""
    source, target = _comparable(mechanism, whole=whole), _comparable(result, whole=whole)
    names = _pair_names(mechanism, result)
    if source.nv != target.nv or not set(source.coordinates) <= names.keys():
        return float("inf")
    at = [target.coordinates.index(names[name]) for name in source.coordinates]
    rates = [target.velocities.index(names[rate]) for rate in source.velocities]
    random = np.random.default_rng(seed)
    q = draw_positions(source, states, random, 1.0)
    v, a = random.uniform(-1.0, 1.0, (2, states, source.nv))
    q_target, v_target, a_target = np.empty_like(q), np.empty_like(v), np.empty_like(a)
    q_target[:, at], v_target[:, rates], a_target[:, rates] = q, v, a
    ours, theirs = Reference(source), Reference(target)
    mass = np.asarray(ours.mass_matrix(q))
    mass_target = np.asarray(theirs.mass_matrix(q_target))[:, rates][:, :, rates]
    tau = np.asarray(ours.inverse_dynamics(q, v, a))
    tau_target = np.asarray(theirs.inverse_dynamics(q_target, v_target, a_target))[:, rates]
    return max(_relative(mass, mass_target), _relative(tau, tau_target))


def _relative(ours: Array, theirs: Array) -> float:
    size = float(np.abs(ours).max(initial=0.0))
    off = float(np.abs(ours - theirs).max(initial=0.0))
    return off / size if size else off


def _comparable(mechanism: Mechanism, *, whole: bool) -> Mechanism:
    """Return the open tree with its springs and dampers; with its map if nothing of it is lost."""
    kept = [f for f in mechanism.forces if whole or not isinstance(f, BodyLoad | JointForce)]
    if not whole:
        kept = [f for f in kept if not isinstance(f, Spring) or mechanism.evaluate(f.free_length)]
    given: dict[str, Any] = {} if whole else {"coordinates": Coordinates((), ())}
    return replace(
        mechanism,
        forces=tuple(kept),
        loops=(),
        contacts=(),
        velocity_constraints=(),
        elements=(),
        switching=(),
        **given,
    )


def _pair_names(mechanism: Mechanism, result: Mechanism) -> dict[str, str]:
    """Return the result's name of each coordinate and velocity."""
    read = {joint.name: joint for joint in result.joints}
    names: dict[str, str] = {}
    for joint in mechanism.joints:
        own = [*joint.coordinates, *joint.velocities]
        theirs: list[str] = []
        steps = [read[step.name] for step in chains(mechanism)[joint.name] if step.name in read]
        for step in steps:
            theirs += step.coordinates
        for step in steps:
            theirs += step.velocities
        if len(own) == len(theirs):
            names.update(zip(own, theirs, strict=True))
    return names
