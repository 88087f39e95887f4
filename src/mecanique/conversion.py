"""Convert a description to another format, and prove it: the result is read and compared."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from importlib.util import find_spec
from typing import Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError, UrdfError
from mecanique.formats.mjcf import read_mjcf, write_mjcf
from mecanique.formats.scope import (
    SCOPES,
    Form,
    leave_out,
    list_balls,
    list_lengths,
    list_losses,
    list_omissions,
    start_at_ground,
    weld_constants,
)
from mecanique.formats.sdf import name_in_sdf, read_sdf, write_sdf
from mecanique.model import Coordinates, Floating, Joint, Limits, Mechanism, Spring
from mecanique.model.joint_base import Elementary, Single
from mecanique.model.mechanism.origin import Origin
from mecanique.model.placement import Placement
from mecanique.model.random_positions import draw_positions
from mecanique.reference import Reference
from mecanique.urdf.dialect import UNBOUNDED
from mecanique.urdf.read import read_urdf
from mecanique.urdf.write import axial_steps, chains, law_of_follower, write_urdf
from mecanique.verification.engines import passive_forces, read_as_engines, read_text_by
from mecanique.verification.verdict import EngineReading
from mecanique.wording import Legible, say_count

_STATES = 100
"""Number of random states at which source and result are compared."""

_ALIKE = 1e-12
"""Largest relative difference of a conversion that is proved."""

_READERS: Mapping[Form, Callable[[str], Mechanism]] = {
    "URDF": read_urdf,
    "MJCF": read_mjcf,
    "SDF": read_sdf,
}
_WRITERS: Mapping[Form, Callable[[Mechanism], str]] = {
    "URDF": write_urdf,
    "MJCF": write_mjcf,
    "SDF": write_sdf,
}


@final
@dataclass(frozen=True, repr=False)
class Conversion(Legible):
    """A description in another format, with the proof.

    Args:
        form: the format, "URDF", "MJCF" or "SDF".
        text: the description.
        lost: in a line each, what the format cannot express.
        worst: the largest relative difference in mass matrix, inverse dynamics, limits and places
            of loops' ends between the source, without what is lost, and the result as mecanique
            reads it.
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
        """Whether the result says what the source says, to an engine of its format, too."""
        return self.worst <= _ALIKE and not self._doubt

    @property
    def differs(self) -> bool:
        """Whether the result is not proved, for other causes than that no engine is installed."""
        return not self.worst <= _ALIKE or bool(self._doubt and self._asked)

    @property
    def _asked(self) -> bool:
        """Whether an engine of the format has said something of the result."""
        return any(reading.worst is not None or reading.refused for reading in self.readings)

    @property
    def _doubt(self) -> str:
        """Why an engine's reading proves nothing; empty if it does."""
        otherwise = [reading.engine for reading in self.readings if reading.differs]
        refusing = [reading.engine for reading in self.readings if reading.refused]
        if otherwise:
            return f"read otherwise by {' and '.join(otherwise)}"
        if any(reading.worst is not None for reading in self.readings):
            return ""
        if refusing:
            return f"refused by {' and '.join(refusing)}"
        return f"no engine of {self.form} itself is installed, mecanique alone read the result"

    def __str__(self) -> str:
        lines = [f"{self.form} cannot express: {line}" for line in self.lost]
        for reading in self.readings if self._asked else ():
            lines += reading.sentences() or [f"{reading.engine} reads the result alike."]
        rest = " but for what is listed" if self.lost else ""
        verdict = "differs from" if self.worst > _ALIKE else "says the same as"
        doubt = f"; not proved: {self._doubt}" if self._doubt else ""
        lines.append(
            f"The {self.form} {verdict} the source{rest}: "
            f"largest relative difference {self.worst:.1e} at {self.states} states{doubt}."
        )
        return "\n".join(lines)


def convert(
    mechanism: Mechanism, form: Form, *, states: int = _STATES, seed: int = 0
) -> Conversion:
    """Return a mechanism in a format, read again and compared with what it came from.

    Args:
        mechanism: what to write.
        form: "URDF", "MJCF" or "SDF".
        states: number of random states at which source and result are compared.
        seed: of the random states.

    Returns:
        The conversion with its verdict.

    Raises:
        InputError: if there is no such format, or the number of states is none.

    Example:
        >>> mq.convert(mq.textbook.load("rigid_bar_pendulum"), "SDF", states=5).lost
        ()
    """
    if form not in SCOPES:
        known = ", ".join(map(repr, SCOPES))
        raise InputError(f"expected one of {known} for the format, got {form!r}")
    if not isinstance(states, int) or states < 1:
        raise InputError(f"expected a number of states from 1, got {states!r}")
    joints = mechanism.joints
    mechanism = weld_constants(mechanism, form)
    welded = sum(a is not b for a, b in zip(joints, mechanism.joints, strict=True))
    mechanism, counting = start_at_ground(mechanism, form)
    lost = list_losses(mechanism, form)
    mechanism = leave_out(mechanism, form)
    text = _WRITERS[form](mechanism)
    try:
        result = _READERS[form](text)
    except (InputError, UrdfError) as error:
        message = f"what was written is not read as {form}, so nothing is proved"
        raise InputError(f"{message}; {error}") from None
    if form == "URDF":  # which does not state it
        x, y, z = mechanism.evaluate_all(mechanism.gravity)
        result = replace(result, gravity=(x, y, z))
    worst = _difference(mechanism, result, states, seed, form, whole=not lost)
    # which is written in a tag of Drake's
    by_drake = form == "URDF" and any(list_balls(mechanism))
    engines = ("drake",) if by_drake else SCOPES[form].engines
    installed = [name for name in engines if find_spec(name) is not None]
    by_engines, read_again = Origin(None, text.encode(), form=form), result
    if form == "URDF":
        read_again = read_as_engines(result, by_engines)
    elif form == "SDF" and result.loops:
        # Drake builds trees alone
        read_again = replace(result, loops=())
        tree = write_sdf(replace(mechanism, loops=()))
        by_engines = replace(by_engines, text=tree.encode())
    bare = replace(read_again, switching=())
    passive = None if by_drake else passive_forces(result, form)  # as springs are tags, too
    readings = read_text_by(bare, by_engines, installed, seed, states, passive)
    counted = (f"joint {name}: its coordinates count from the world's frame" for name in counting)
    unstated = (*counted, *list_omissions(mechanism, form))
    if welded:
        named = say_count(welded, "joint")
        unstated += (f"the constant coordinates of {named}: welds in their place",)
    return Conversion(form, text, (*lost, *unstated), worst, states, readings)


def _difference(
    mechanism: Mechanism, result: Mechanism, states: int, seed: int, form: Form, *, whole: bool
) -> float:
    """Return the largest relative difference of the trees' matrices and inverse dynamics."""
    if form != "URDF":  # in which free bodies count from where they start
        counted = (
            replace(joint, origin=Placement()) if isinstance(joint, Floating) else joint
            for joint in mechanism.joints
        )
        mechanism = replace(mechanism, joints=tuple(counted))
    steps = axial_steps(mechanism)
    laws = [
        law_of_follower(mechanism, steps, name, SCOPES[form].degree)
        for name in mechanism.coordinates.driven.keys() - list_lengths(mechanism).keys()
    ]
    mapped = None not in laws
    source, target = (
        _comparable(side, form, whole=whole, mapped=mapped) for side in (mechanism, result)
    )
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
    differences = [_relative(mass, mass_target), _relative(tau, tau_target)]
    differences += _bounds_apart(mechanism, result)
    if whole:
        gaps = [_gaps(*side) for side in ((mechanism, ours, q), (result, theirs, q_target))]
        if gaps[0].shape != gaps[1].shape:
            return float("inf")
        differences.append(_relative(*gaps))
    return max(differences)


def _relative(ours: Array, theirs: Array) -> float:
    size = float(np.abs(ours).max(initial=0.0))
    off = float(np.abs(ours - theirs).max(initial=0.0))
    return off / size if size else off


def _bounds_apart(mechanism: Mechanism, result: Mechanism) -> Iterator[float]:
    """Yield the relative differences of positions' limits, of joints with one coordinate."""
    read = {joint.name: joint for joint in result.joints}
    for joint in mechanism.joints:
        back = _find_joint(read, joint.name)
        if isinstance(joint, Single) and isinstance(back, Single):
            sides = [side.limits or Limits() for side in (joint, back)]
            for ours, theirs in zip(*((x.lower, x.upper) for x in sides), strict=True):
                if max(abs(ours), abs(theirs)) < UNBOUNDED:
                    yield abs(ours - theirs) / max(abs(ours), 1.0)


def _gaps(mechanism: Mechanism, engine: Reference, q: Array) -> Array:
    """Return how far each loop is from closed: same gaps, same rank, same forces."""
    poses = []
    # a format may name loops otherwise, but keeps the order of those of a kind
    for loop in sorted(mechanism.loops, key=lambda loop: loop.kind):
        first, second = mechanism.matrix(loop.frame_a), mechanism.matrix(loop.frame_b)
        base, end = (np.asarray(engine.pose(body, q)) for body in loop.bodies)
        relative = np.linalg.inv(base) @ end @ second
        # in the axes of the body, as frames may be turned about what turns freely
        apart = (relative - first)[:, :3]
        if loop.kind == "distance":
            length = mechanism.evaluate(loop.length)
            poses.append(np.linalg.norm(apart[..., 3], axis=1) - length)
        elif loop.kind in ("ball", "hinge"):
            poses.append(apart[..., 3 if loop.kind == "ball" else 2 :])
        else:
            poses.append(np.linalg.inv(first) @ relative)
    flat = [pose.reshape(len(q), -1) for pose in poses]
    return np.hstack(flat) if flat else np.zeros((len(q), 0))


def _comparable(mechanism: Mechanism, form: Form, *, whole: bool, mapped: bool) -> Mechanism:
    """Return the open tree with the forces that a format states; with its map if it is stated."""
    kept = [f for f in mechanism.forces if whole or isinstance(f, SCOPES[form].forces)]
    if not whole and form == "URDF":
        kept = [f for f in kept if not isinstance(f, Spring) or mechanism.evaluate(f.free_length)]
    given: dict[str, Any] = {} if mapped else {"coordinates": Coordinates((), ())}
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


def _find_joint(joints: Mapping[str, Joint], name: str) -> Joint | None:
    """Return a joint by its name, or by what SDF makes of it."""
    return joints.get(name, joints.get(name_in_sdf(name)))


def _pair_names(mechanism: Mechanism, result: Mechanism) -> dict[str, str]:
    """Return the result's name of each coordinate and velocity."""
    read = {joint.name: joint for joint in result.joints}
    free = {joint.child: joint for joint in result.joints if isinstance(joint, Floating)}
    names: dict[str, str] = {}
    for joint in mechanism.joints:
        same = _find_joint(read, joint.name)
        if isinstance(joint, Floating):
            same = _find_joint(free, joint.child)
        pairs: list[tuple[Joint | Elementary, Joint]] = []
        if same is not None and same.nq == joint.nq:
            pairs += [(joint, same)]
        else:
            steps = zip(joint.chain, chains(mechanism)[joint.name], strict=True)
            known = ((motion, _find_joint(read, step.name)) for motion, step in steps)
            pairs += [(motion, joint) for motion, joint in known if joint is not None]
        for ours, theirs in pairs:
            names.update(zip(ours.coordinates, theirs.coordinates, strict=True))
            names.update(zip(ours.velocities, theirs.velocities, strict=True))
    return names
