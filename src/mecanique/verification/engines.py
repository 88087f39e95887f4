"""Read the original file with engines, so that a fault in it does not escape.

Pinocchio gets a mechanism as the text that mecanique writes anew. Here each engine reads the
original with its own parser, and its mass matrix and bias are compared with those of the tree that
mecanique reads: its root fixed, every joint with one coordinate free, also those that mimic, and
joints with several velocities, such as balls, at rest and named.
The engines are compared with one another, too, so that of several one that stands alone is named.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import EngineError, UnknownNameError
from mecanique.formats.read import read
from mecanique.formats.scope import list_lengths
from mecanique.model.coordinates import Coordinates
from mecanique.model.force_base import AnyForce
from mecanique.model.joint_base import Single
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.origin import Finding, Origin
from mecanique.plugins import list_plugins, load_plugin
from mecanique.reference import Reference
from mecanique.reference.engine.package import has_pinocchio
from mecanique.reference.originals import drake, exudyn, mujoco, pinocchio
from mecanique.reference.originals.original import ByJoint, Original
from mecanique.urdf.findings import Report
from mecanique.urdf.lint import lint
from mecanique.urdf.parse import parse
from mecanique.urdf.read import read_urdf
from mecanique.verification.rows import differ_by
from mecanique.verification.verdict import OURS, READ_ALIKE, EngineReading


@final
@dataclass(frozen=True)
class Engine:
    """An engine that reads URDF files; other packages add theirs to `mecanique.engines`.

    Args:
        title: what it is called.
        package: the package that holds it.
        read: returns what it makes of a file's bytes, from gravity, and positions and velocities
            by joint; raises `EngineError` if it refuses the file.
    """

    title: str
    package: str
    read: Callable[[bytes, Sequence[float], ByJoint, ByJoint], Original]


ENGINES: dict[str, Engine] = {
    "pinocchio": Engine("Pinocchio", "pin", pinocchio.read),
    "mujoco": Engine("MuJoCo", "mujoco", mujoco.read),
    "drake": Engine("Drake", "drake", drake.read),
    "exudyn": Engine("Exudyn", "exudyn", exudyn.read),
}
"""Each engine by its name."""

_STATES = 5
"""Number of random states at which an engine's reading is compared."""


def read_by(mechanism: Mechanism, engines: Sequence[str], seed: int) -> tuple[EngineReading, ...]:
    """Compare what engines read from a mechanism's file; nothing if it is from no file."""
    chosen, origin = _choose(engines), mechanism.origin
    if origin is None:
        return ()
    x, y, z = mechanism.evaluate_all(mechanism.gravity)
    tree = _open_tree(origin, (x, y, z))
    return _compare_all(tree, origin, chosen, seed)


def read_text_by(
    mechanism: Mechanism,
    text: str,
    engines: Sequence[str],
    seed: int,
    states: int,
    passive: Sequence[AnyForce],
) -> tuple[EngineReading, ...]:
    """Compare what engines read from a text with what mecanique read from it.

    Args:
        mechanism: what mecanique read.
        text: what the engines read.
        engines: their names.
        seed: of the random states.
        states: number of them.
        passive: the springs and dampers that engines compute, if they compute any.
    """
    tree, origin = _strip(mechanism), Origin(None, text.encode())
    loaded = replace(tree, forces=tuple(passive))
    return _compare_all(tree, origin, _choose(engines), seed, states, loaded)


def _choose(engines: Sequence[str]) -> list[Engine]:
    # a verdict without Pinocchio says so in its first line
    return [engine_of(name) for name in engines if name != "pinocchio" or has_pinocchio()]


def engine_of(name: str) -> Engine:
    """Return an engine by its name."""
    if name in ENGINES:
        return ENGINES[name]
    if name in list_plugins("engines"):
        return load_plugin("engines", name, Engine)
    raise UnknownNameError("engine", name, [*ENGINES, *list_plugins("engines")])


def _open_tree(origin: Origin, gravity: tuple[float, float, float]) -> Mechanism:
    """Return the bare tree of a file: no forces, loops or mimic joints.

    Of a URDF, whose rotors stand in tags of one engine, it has none.
    """
    text = origin.text.decode("utf-8-sig", "replace")
    if origin.form == "URDF":
        return _strip(read_urdf(text, gravity=gravity, armature=0.0))
    return _strip(replace(read(origin.file or text), gravity=gravity))


def _strip(mechanism: Mechanism) -> Mechanism:
    """Return the bare tree: no forces, loops or mimic joints, but the tendons' rotors."""
    lengths = {name: mechanism.coordinates.driven[name] for name in list_lengths(mechanism)}
    coordinates = Coordinates((), lengths)
    bare: dict[str, Any] = dict.fromkeys(("forces", "loops", "contacts", "elements"), ())
    return replace(mechanism, coordinates=coordinates, **bare)


def _compare_all(
    tree: Mechanism,
    origin: Origin,
    engines: Sequence[Engine],
    seed: int,
    states: int = _STATES,
    loaded: Mechanism | None = None,
) -> tuple[EngineReading, ...]:
    """Compare what engines read with what mecanique read, and with one another."""
    singles = (joint for joint in tree.joints if isinstance(joint, Single))
    ours = {j.name: j for j in singles if j.name not in tree.coordinates.driven}
    random = np.random.default_rng(seed)
    q = {name: random.uniform(-1.0, 1.0, states).tolist() for name in ours}
    v = {name: random.uniform(-1.0, 1.0, states).tolist() for name in ours}
    asked = _Asked(tree, loaded, origin, ours, q, v)
    readings: list[EngineReading] = []
    answers: dict[str, Original] = {}
    for engine in engines:
        reading, original = _compare(asked, engine)
        readings.append(reading)
        if original is not None:
            answers[reading.engine] = original
    for k, reading in enumerate(readings):
        if reading.engine in answers:
            original = answers[reading.engine]
            alike = [
                name
                for name, other in answers.items()
                if name != reading.engine and _read_alike(original, other)
            ]
            alike += [] if reading.differs else [OURS]
            readings[k] = replace(reading, alike=tuple(alike))
    return tuple(readings)


@final
@dataclass(frozen=True)
class _Asked:
    """What engines are asked, and what mecanique read."""

    tree: Mechanism
    loaded: Mechanism | None  # with springs and dampers
    origin: Origin
    ours: Mapping[str, Single]
    q: ByJoint
    v: ByJoint


def _read_alike(a: Original, b: Original) -> bool:
    """Whether two engines read the same."""
    if {*a.joints} != {*b.joints}:
        return False
    order = [b.joints.index(joint) for joint in a.joints]
    pairs = [
        ("mass matrix", a.mass, b.mass[:, order][:, :, order]),
        ("bias", a.bias, b.bias[:, order]),
    ]
    return _difference(pairs, a.mass) <= READ_ALIKE


def _compare(asked: _Asked, engine: Engine) -> tuple[EngineReading, Original | None]:
    """Compare what an engine reads with what mecanique read; return what it answers, too."""
    title, package = engine.title, engine.package
    tree, origin, ours = asked.tree, asked.origin, asked.ours
    try:
        title = f"{title} {version(package)}"
    except PackageNotFoundError:
        return EngineReading(title, None, missing=f"pip install {package}"), None
    try:
        with _beside(origin):
            original = engine.read(origin.text, tree.evaluate_all(tree.gravity), asked.q, asked.v)
    except EngineError as error:
        return EngineReading(title, None, str(error), tuple(_traps(origin, engine))), None
    joints = [ours[name] for name in original.joints if name in ours]
    lost = sorted(ours.keys() - set(original.joints))
    order = [original.joints.index(joint.name) for joint in joints]
    others, offs = original.mass[:, order][:, :, order], original.bias[:, order]
    mass, bias = _answers(tree, joints, asked.q, asked.v)
    pairs = [("mass matrix", mass, others), ("bias", bias, offs)]
    if asked.loaded is not None and original.passive is not None:
        held = _answers(asked.loaded, joints, asked.q, asked.v)[1]
        pairs.append(("bias", held, offs - original.passive[:, order]))
    remarks = [f"{title} has no joint {name!r}" for name in lost]
    worst = np.inf if lost else _difference(pairs, mass)
    several = tuple(joint.name for joint in tree.joints if len(joint.velocities) > 1)
    reading = EngineReading(title, worst, uncompared=several)
    if reading.differs:
        remarks += [*_places(tree, joints, mass, others), *_traps(origin, engine)]
        remarks += [f"{title.split()[0]} said: {said}" for said in original.complaints]
    return replace(reading, remarks=tuple(remarks)), original


@contextmanager
def _beside(origin: Origin) -> Iterator[None]:
    """Work where a file of MJCF or SDF is, as engines seek there the files that its text names."""
    if origin.file is None or origin.form == "URDF":
        yield
        return
    before = Path.cwd()
    os.chdir(Path(origin.file).resolve().parent)
    try:
        yield
    finally:
        os.chdir(before)


def _answers(
    tree: Mechanism, joints: Sequence[Single], q: ByJoint, v: ByJoint
) -> tuple[Array, Array]:
    """Return M and the forces without acceleration as mecanique reads the file, in some joints."""
    at = [tree.velocities.index(f"{joint.coordinate}'") for joint in joints]
    engine = Reference(tree)
    states = max(map(len, q.values()), default=_STATES)
    place = np.tile(tree.neutral(), (states, 1))
    speed = np.zeros((states, tree.nv))
    for joint, index in zip(joints, at, strict=True):
        place[:, tree.coordinates.index(joint.coordinate)] = q[joint.name]
        speed[:, index] = v[joint.name]
    mass = engine.mass_matrix(place)
    bias = engine.inverse_dynamics(place, speed, np.zeros_like(speed))
    return np.asarray(mass)[:, at][:, :, at], np.asarray(bias)[:, at]


def _difference(pairs: Sequence[tuple[str, Array, Array]], mass: Array) -> float:
    """Return the largest relative difference of the quantities, scaled as in a verdict."""
    if not mass.size:
        return 0.0
    return max(float(differ_by(quantity, a, b, mass).max()) for quantity, a, b in pairs)


def _places(tree: Mechanism, joints: Sequence[Single], mass: Array, others: Array) -> Iterator[str]:
    """Name the outermost joints whose inertia differs: it depends on what they carry alone."""
    a, b = (np.diagonal(m, axis1=1, axis2=2) for m in (mass, others))
    wrong = {
        joint.child: (joint, float(x[0]), float(y[0]))
        for joint, x, y in zip(joints, a.T, b.T, strict=True)
        if not np.allclose(x, y, rtol=READ_ALIKE, atol=0.0)
    }
    parents = {joint.child: joint.parent for joint in tree.joints}
    inner: set[str] = set()
    for body in wrong:
        while body in parents and parents[body] not in inner:
            body = parents[body]
            inner.add(body)
    for body, (joint, here, there) in wrong.items():
        if body not in inner:
            unit = "kg" if joint.noun == "slide" else "kg·m²"
            yield f"link {body!r} at joint {joint.name!r}: {there:.6g} {unit} instead of {here:.6g}"


def _traps(origin: Origin, engine: Engine) -> Iterator[str]:
    """Name lines that may be the reason: findings of the linter, or what an engine leaves out."""
    text = origin.text.decode("utf-8-sig", "replace")
    if origin.form == "URDF":
        findings: tuple[Finding, ...] = lint(text)
        for finding in findings:
            if finding.code in _REASONS:
                yield f"line {finding.line}: {finding.sentence}"
        return
    root = parse(text, Report(None))
    for element in root.walk() if root is not None else ():
        for tag, attribute in _LEFT_OUT.get((origin.form, engine.title), ()):
            if element.tag == tag and (not attribute or attribute in element.attributes):
                what = f"{attribute}=… of <{tag}>" if attribute else f"<{tag}>"
                yield f"line {element.line}: {engine.title} leaves out {what}"


_REASONS = ("M101", "M105", "M107", "M116", "M202", "M203", "M204", "M305", "M307", "M705", "M706")
"""Rules on what engines read otherwise."""

_LEFT_OUT: Mapping[tuple[str, str], Sequence[tuple[str, str]]] = {
    ("MJCF", "Pinocchio"): (
        ("compiler", "eulerseq"),
        ("compiler", "inertiagrouprange"),
        ("compiler", "settotalmass"),
        ("compiler", "boundmass"),
        ("compiler", "boundinertia"),
        ("compiler", "balanceinertia"),
        ("frame", ""),
        ("replicate", ""),
        ("option", "gravity"),
        ("motor", "armature"),
        ("position", "armature"),
        ("general", "armature"),
    ),
    ("MJCF", "Drake"): (
        ("joint", "armature"),
        ("compiler", "inertiagrouprange"),
        ("compiler", "settotalmass"),
        ("compiler", "boundmass"),
        ("compiler", "boundinertia"),
        ("geom", "shellinertia"),
        ("frame", ""),
        ("replicate", ""),
        ("motor", "armature"),
        ("position", "armature"),
        ("general", "armature"),
    ),
    ("SDF", "Drake"): (("gravity", ""),),
}
"""What engines read of a format without effect (measured: pin 4.1.0, drake 1.51.1)."""
