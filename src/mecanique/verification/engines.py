"""Read the original file with engines, so that a fault in it does not escape.

Pinocchio gets a mechanism as the text that mecanique writes anew. Here each engine reads the
original with its own parser, and its mass matrix, bias and passive forces are compared with those
of the tree that mecanique reads: every joint free, also those that mimic. The engines are compared
with one another, too, so that of several one that stands alone is named.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import EngineError, UnknownNameError
from mecanique.formats.mjcf import read_mjcf
from mecanique.formats.read import read
from mecanique.formats.scope import SCOPES, list_lengths
from mecanique.model import AnyForce, Coordinates, Fixed, Floating, Joint, Mechanism
from mecanique.model.mechanism.origin import Finding, Origin
from mecanique.plugins import list_plugins, load_plugin
from mecanique.reference import Reference
from mecanique.reference.engine.package import has_pinocchio
from mecanique.reference.originals import drake, exudyn, mujoco, pinocchio
from mecanique.reference.originals.original import ByJoint, Original
from mecanique.urdf.dialect import SCREW
from mecanique.urdf.findings import Report
from mecanique.urdf.lint import lint
from mecanique.urdf.parse import parse
from mecanique.urdf.read import read_urdf
from mecanique.urdf.reading.letters import with_armature
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
        rotors: whether it reads the rotors that `drake:` tags of URDF state.
    """

    title: str
    package: str
    read: Callable[[bytes, Sequence[float], ByJoint, ByJoint], Original]
    rotors: bool = False


ENGINES: dict[str, Engine] = {
    "pinocchio": Engine("Pinocchio", "pin", pinocchio.read),
    "mujoco": Engine("MuJoCo", "mujoco", mujoco.read),
    "drake": Engine("Drake", "drake", drake.read, rotors=True),
    "exudyn": Engine("Exudyn", "exudyn", exudyn.read),
}
"""Each engine by its name."""

_SCREWS = re.compile(f"<{SCREW}[^>]*/>")
_STATES = 5
"""Number of random states at which an engine's reading is compared."""


def read_by(mechanism: Mechanism, engines: Sequence[str], seed: int) -> tuple[EngineReading, ...]:
    """Compare what engines read from a mechanism's file; nothing if it is from no file."""
    chosen, origin = _choose(engines), mechanism.origin
    if origin is None:
        return ()
    whole = read_as_engines(mechanism, origin)
    passive = passive_forces(whole, origin.form)
    if origin.form == "URDF" and len(passive) < len(whole.forces):
        return _compare_all(whole, origin, chosen, seed)  # with tags of one engine
    return _compare_all(whole, origin, chosen, seed, passive=passive)


def passive_forces(mechanism: Mechanism, form: str) -> tuple[AnyForce, ...]:
    """Return the springs, dampers and the like that a format's engines compute."""
    (kinds,) = (scope.passive for scope in SCOPES.values() if scope.form == form)
    return tuple(f for f in mechanism.forces if kinds is None or isinstance(f, kinds))


def read_text_by(
    mechanism: Mechanism,
    origin: Origin,
    engines: Sequence[str],
    seed: int,
    states: int,
    passive: Sequence[AnyForce] | None,
) -> tuple[EngineReading, ...]:
    """Compare what engines read from a text with what mecanique read from it."""
    return _compare_all(mechanism, origin, _choose(engines), seed, states, passive)


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


def read_as_engines(mechanism: Mechanism, origin: Origin) -> Mechanism:
    """Return what the file of a mechanism says to engines, with its gravity and root.

    The screws of a URDF are slides and hinges to them.
    """
    text = origin.text.decode("utf-8-sig", "replace")
    x, y, z = mechanism.evaluate_all(mechanism.gravity)
    if origin.form != "URDF":
        whole = read(origin.file or text, package_path=origin.package_path)
        return replace(whole, gravity=(x, y, z))
    text = _SCREWS.sub("", text)
    whole = read_urdf(text, gravity=(x, y, z))
    if whole.ground == mechanism.ground:
        return whole
    return read_urdf(text, gravity=(x, y, z), root="floating")


def _compare_all(
    whole: Mechanism,
    origin: Origin,
    engines: Sequence[Engine],
    seed: int,
    states: int = _STATES,
    passive: Sequence[AnyForce] | None = None,
) -> tuple[EngineReading, ...]:
    """Compare what engines read with what mecanique read, and with one another."""
    # the bare tree: no forces, loops or mimic joints, but the tendons' rotors
    free, names = whole, list_lengths(whole)
    if names and origin.form == "MJCF":  # whose joints lengthen a tendon also where they follow
        text = origin.text.decode("utf-8-sig", "replace")
        free = read_mjcf(origin.file or text, tied=False)
    lengths = {name: free.coordinates.driven[name] for name in names}
    coordinates = Coordinates((), lengths)
    bare: dict[str, Any] = dict.fromkeys(("forces", "loops", "contacts", "elements"), ())
    tree, rotors = replace(whole, coordinates=coordinates, **bare), dict[str, float]()
    if origin.form == "URDF":  # where they stand in tags of one engine
        rotors = {j.name: tree.evaluate(getattr(j, "armature", 0.0)) for j in tree.joints}
        tree = with_armature(tree, 0.0)
    moving = (j for j in tree.joints if j.nv and j.name not in tree.coordinates.driven)
    ours = {joint.name: joint for joint in moving}
    random = np.random.default_rng(seed)
    q = {name: _draw_place(tree, joint, states, random) for name, joint in ours.items()}
    v = {
        name: random.uniform(-1.0, 1.0, (states, len(_rates(tree, joint))))
        for name, joint in ours.items()
    }
    # passive forces are stated in the coordinates that lead
    led = _follow(whole, tree, ours, q, v) if passive else None
    loaded = None if passive is None else replace(tree, forces=tuple(passive))
    asked = _Asked(tree, loaded, origin, ours, rotors, q, v, led)
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
                for name, answer in answers.items()
                if name != reading.engine and asked.alike(original, answer)
            ]
            alike += [] if reading.differs else [OURS]
            readings[k] = replace(reading, alike=tuple(alike))
    return tuple(readings)


def _rates(tree: Mechanism, joint: Joint) -> list[str]:
    """Names of a joint's velocities that follow no others, as a screw's travel does."""
    return [rate for rate in joint.velocities if rate in tree.velocities]


def _follow(
    whole: Mechanism,
    free: Mechanism,
    ours: Mapping[str, Joint],
    q: dict[str, Array],
    v: dict[str, Array],
) -> Array | None:
    """Place joints that follow others where these lead them.

    Returns how each velocity of the free tree follows from those that lead, shape (n, nv, nv); None
    if no joint follows.
    """
    laws = whole.coordinates.driven
    led = [name for name, joint in ours.items() if {*joint.coordinates} <= laws.keys()]
    if not led:
        return None
    bare: dict[str, Any] = dict.fromkeys(("forces", "loops", "contacts", "elements"), ())
    tree = replace(whole, **bare)
    joints = [joint for name, joint in ours.items() if name not in led]
    place, speed, _ = _join(tree, joints, q, v)
    engine = Reference(tree)
    values = engine.followers(place, speed)
    slopes = np.tile(np.eye(free.nv), (len(place), 1, 1))
    for name in led:
        (coordinate,), (rate,) = ours[name].coordinates, ours[name].velocities
        q[name], v[name] = values[coordinate][:, None], values[rate][:, None]
        slopes[:, free.velocities.index(rate)] = 0.0
    for leader, unit in zip(tree.velocities, np.eye(tree.nv), strict=True):
        values = engine.followers(place, np.tile(unit, (len(place), 1)))
        for (rate,) in (ours[name].velocities for name in led):
            slopes[:, free.velocities.index(rate), free.velocities.index(leader)] = values[rate]
    return slopes


def _join(
    tree: Mechanism, joints: Sequence[Joint], q: Mapping[str, Array], v: Mapping[str, Array]
) -> tuple[Array, Array, list[int]]:
    """Return positions and velocities by joint as those of a tree, and which rates they are."""
    states = max(map(len, q.values()), default=_STATES)
    place, speed = np.tile(tree.neutral(), (states, 1)), np.zeros((states, tree.nv))
    at: list[int] = []
    for joint in joints:
        rates = [tree.velocities.index(rate) for rate in _rates(tree, joint)]
        free = [tree.coordinates.index(c) for c in joint.coordinates if c in tree.coordinates]
        place[:, free], speed[:, rates] = q[joint.name], v[joint.name]
        at += rates
    return place, speed, at


def _draw_place(tree: Mechanism, joint: Joint, states: int, random: np.random.Generator) -> Array:
    """Return random coordinates of a joint, shape (states, nq), its quaternion of length 1."""
    free = sum(coordinate in tree.coordinates for coordinate in joint.coordinates)
    place = random.uniform(-1.0, 1.0, (states, free))
    if joint.quaternion:
        turn = random.normal(size=(states, 4))
        place[:, -4:] = turn / np.linalg.norm(turn, axis=1, keepdims=True)
    return place


@final
@dataclass(frozen=True)
class _Asked:
    """What engines are asked, and what mecanique read."""

    tree: Mechanism
    loaded: Mechanism | None  # with springs and dampers
    origin: Origin
    ours: Mapping[str, Joint]
    rotors: Mapping[str, float]
    q: Mapping[str, Array]
    v: Mapping[str, Array]
    slopes: Array | None  # of all velocities by those that lead

    def of_engines(self) -> tuple[ByJoint, ByJoint]:
        """Positions and velocities as engines are asked: free bodies are placed in the world."""
        placed = dict(self.q)
        for name, joint in self.ours.items():
            if isinstance(joint, Floating):
                placed[name] = _in_world(self.tree, joint, self.q[name])
        return _as_lists(placed), _as_lists(self.v)

    def starts(self, original: Original) -> dict[str, int]:
        """Where the velocities of each joint begin among an engine's."""
        widths = [self.v[name].shape[1] if name in self.v else 1 for name in original.joints]
        return dict(zip(original.joints, np.cumsum([0, *widths]).tolist(), strict=False))

    def without_rotors(self, original: Original) -> Original:
        """Return the results without what rotors of tags of one engine add to them."""
        mass = original.mass.copy()
        for name, start in self.starts(original).items():
            mass[:, start, start] -= self.rotors.get(name, 0.0)
        return replace(original, mass=mass)

    def select(self, original: Original, names: Sequence[str]) -> tuple[Array, Array, Array | None]:
        """Mass matrix, bias and passive forces of an engine in some joints, in that order."""
        starts = self.starts(original)
        at = [starts[name] + k for name in names for k in range(self.v[name].shape[1])]
        passive = None if original.passive is None else original.passive[:, at]
        return original.mass[:, at][:, :, at], original.bias[:, at], passive

    def alike(self, a: Original, b: Original) -> bool:
        """Whether two engines read the same."""
        if {*a.joints} != {*b.joints}:
            return False
        names = [name for name in a.joints if name in self.ours]
        mass, bias, held = self.select(a, names)
        mass_b, bias_b, held_b = self.select(b, names)
        if self.loaded is not None and held is not None and held_b is not None:
            bias, bias_b = bias - held, bias_b - held_b
        pairs = [("mass matrix", mass, mass_b), ("bias", bias, bias_b)]
        return _difference(pairs, mass) <= READ_ALIKE

    def answers(self, names: Sequence[str], *, loaded: bool) -> tuple[Array, Array]:
        """M and the forces without acceleration as mecanique reads the file, in some joints."""
        tree = self.loaded if loaded and self.loaded is not None else self.tree
        engine = Reference(tree)
        place, speed, at = _join(tree, [self.ours[name] for name in names], self.q, self.v)
        mass = np.asarray(engine.mass_matrix(place))
        bias = np.asarray(engine.inverse_dynamics(place, speed, np.zeros_like(speed)))
        return mass[:, at][:, :, at], bias[:, at]

    def lead(self, names: Sequence[str], forces: Array) -> Array:
        """Return forces in some joints as those on the velocities that lead."""
        if self.slopes is None:
            return forces
        _, _, at = _join(self.tree, [self.ours[name] for name in names], self.q, self.v)
        return np.asarray(np.einsum("sij,si->sj", self.slopes[:, at][:, :, at], forces))


def _as_lists(values: Mapping[str, Array]) -> ByJoint:
    """Numbers where a joint has one coordinate, lists where it has several."""
    return {name: (x[:, 0] if x.shape[1] == 1 else x).tolist() for name, x in values.items()}


def _in_world(tree: Mechanism, joint: Floating, places: Array) -> Array:
    """Return positions and quaternions of a free body in what carries it and moves, or the world.

    Shapes: places (n, 7).
    """
    from scipy.spatial.transform import Rotation

    carriers = {held.child: held for held in tree.joints}
    pose, parent = tree.matrix(joint.origin), joint.parent
    while isinstance(carrier := carriers.get(parent), Fixed):
        pose, parent = tree.matrix(carrier.origin) @ pose, carrier.parent
    turned = Rotation.from_matrix(pose[:3, :3])
    turns = turned * Rotation.from_quat(places[:, 3:])
    return np.hstack([turned.apply(places[:, :3]) + pose[:3, 3], turns.as_quat()])


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
            gravity = tree.evaluate_all(tree.gravity)
            original = engine.read(origin.text, gravity, *asked.of_engines())
        if engine.rotors:
            original = asked.without_rotors(original)
    except EngineError as error:
        return EngineReading(title, None, str(error), tuple(_traps(origin, engine))), None
    names = [name for name in original.joints if name in ours]
    lost = sorted(ours.keys() - {*names})
    others, offs, held = asked.select(original, names)
    if held is not None and asked.loaded is not None:
        offs = offs - held
    mass, bias = asked.answers(names, loaded=held is not None)
    if held is not None:
        bias, offs = (asked.lead(names, forces) for forces in (bias, offs))
    pairs = [("mass matrix", mass, others), ("bias", bias, offs)]
    remarks = [f"{title} has no joint {name!r}" for name in lost]
    remarks += [f"{title} has a joint {name!r} more" for name in original.others]
    reading = EngineReading(title, np.inf if remarks else _difference(pairs, mass))
    if reading.differs:
        remarks += [
            *_places(tree, [ours[name] for name in names], mass, others),
            *_traps(origin, engine),
        ]
        remarks += [f"{title.split()[0]} said: {said}" for said in original.complaints]
    return replace(reading, remarks=tuple(remarks)), original


@contextmanager
def _beside(origin: Origin) -> Iterator[None]:
    """Work where a file of MJCF or SDF is, as engines seek there the files that its text names.

    They seek models in the folders that were named to its reader, too.
    """
    if origin.file is None or origin.form == "URDF":
        yield
        return
    before, path = Path.cwd(), os.environ.get("ROS_PACKAGE_PATH")
    if origin.package_path:
        folders = [*origin.package_path, *([path] if path else [])]
        os.environ["ROS_PACKAGE_PATH"] = os.pathsep.join(folders)
    os.chdir(Path(origin.file).resolve().parent)
    try:
        yield
    finally:
        os.chdir(before)
        if path is None:
            os.environ.pop("ROS_PACKAGE_PATH", None)
        else:
            os.environ["ROS_PACKAGE_PATH"] = path


def _difference(pairs: Sequence[tuple[str, Array, Array]], mass: Array) -> float:
    """Return the largest relative difference of the quantities, scaled as in a verdict."""
    if not mass.size:
        return 0.0
    return max(float(differ_by(quantity, a, b, mass).max()) for quantity, a, b in pairs)


def _places(tree: Mechanism, joints: Sequence[Joint], mass: Array, others: Array) -> Iterator[str]:
    """Name the outermost joints whose inertia differs: it depends on what they carry alone."""
    a, b = (np.diagonal(m, axis1=1, axis2=2)[0].tolist() for m in (mass, others))
    wrong: dict[str, tuple[str, float, float, str]] = {}
    for joint in joints:
        for rate in _rates(tree, joint):
            x, y = a.pop(0), b.pop(0)
            if not np.isclose(x, y, rtol=READ_ALIKE, atol=0.0):
                unit = "kg" if rate in joint.linear_velocities else "kg·m²"
                wrong.setdefault(joint.child, (joint.name, x, y, unit))
    parents = {joint.child: joint.parent for joint in tree.joints}
    inner: set[str] = set()
    for body in wrong:
        while body in parents and parents[body] not in inner:
            body = parents[body]
            inner.add(body)
    for body, (name, here, there, unit) in wrong.items():
        if body not in inner:
            yield f"link {body!r} at joint {name!r}: {there:.6g} {unit} instead of {here:.6g}"


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
"""What engines read of a format without effect (pin 4.1.0, drake 1.51.1, mujoco 4.0.0)."""
