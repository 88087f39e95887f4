"""What readers of descriptions in XML share: files, refusals by line, numbers, poses.

`mecanique.formats.mjcf` and `mecanique.formats.sdf` build on it.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError
from mecanique.files import name_file
from mecanique.model.bodies import Body
from mecanique.model.bodies.visuals import Box, Cylinder, Geometry, Sphere, Visual
from mecanique.model.constraints.loops import Loop
from mecanique.model.coordinates import Coordinates
from mecanique.model.expression import Scalar, coordinate, symbols_in, velocity
from mecanique.model.force_base import AnyForce
from mecanique.model.forces import (
    Force,
    JointDamper,
    JointForce,
    JointSpring,
    Potential,
    Torque,
)
from mecanique.model.joints import Floating, Joint, Universal
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.validation import inertia_fault
from mecanique.model.placement import Placement, pose_at, pose_of, rpy_of, turn_about
from mecanique.urdf.findings import Report
from mecanique.urdf.markup import Element
from mecanique.urdf.names import Names
from mecanique.urdf.parse import MOST_BYTES, parse
from mecanique.urdf.reading.expressions import rename
from mecanique.urdf.reading.fields import LARGEST

GROUND = "world"
MOST_FILES = 100
MOST_ELEMENTS = 100_000
MOST_FOLLOWED = 300
_TIME = "t"
"""The letter of time, which no coordinate has."""


@final
class Given(dict[str, str]):
    """The attributes of an element, over what they are by default: numbers or refusals."""

    def __init__(self, source: Source, element: Element, texts: Mapping[str, str]) -> None:
        super().__init__(texts)
        self.element = element
        self._source = source

    def refuse(self, message: str) -> InputError:
        """Return an error that names the file and the line of the element."""
        return self._source.refuse(self.element, message)

    def numbers(
        self, name: str, default: Sequence[float] | Array, *, least: int | None = None
    ) -> Array:
        """Return as many numbers as the default has, which ends them where some are left out."""
        count, values = len(default), np.array(default, dtype=float)
        if name in self:
            wanted = f"expected {count} finite {'number' if count == 1 else 'numbers'}"
            wanted = f"{wanted} for {name} of <{self.element.tag}>"
            given = self._source.split(self.element, self[name], wanted)
            if not (count if least is None else least) <= len(given) <= count:
                raise self.refuse(f"{wanted}, got {self[name][:60]!r}")
            values[: len(given)] = given
        return values

    def number(self, name: str, default: float) -> float:
        """Return a number."""
        return float(self.numbers(name, (default,))[0])

    def aim(self, name: str, values: Array) -> Array:
        """Return the direction of an attribute's numbers as a vector of length one."""
        try:
            return unit_vector(values)
        except InputError as error:
            raise self.refuse(f"{name} of <{self.element.tag}>: {error}") from None


@contextmanager
def refuse_overflow(file: Path | None) -> Iterator[None]:
    """Refuse a text whose numbers cannot be computed with."""
    try:
        with np.errstate(over="raise"):
            yield
    except ArithmeticError:
        where = f"{name_file(str(file))}: " if file is not None else ""
        raise InputError(
            f"{where}a number is too large to compute with, or zero where it divides; mend it"
        ) from None


class Source:
    """One file with those it includes, or a text."""

    def __init__(self, file: Path | None, format_name: str) -> None:
        self.file = file
        self.omitted: Counter[str] = Counter()
        self.rubbing: list[str] = []  # joints with dry friction
        self.laws: dict[str, tuple[Element, Scalar]] = {}  # of joints that follow others
        self.joints: list[Joint] = []
        self.forces: list[AnyForce] = []
        self.gravity = np.array([0.0, 0.0, -9.81])
        self._format = format_name
        self._files = self._elements = 0

    def parse(self, source: Path | str) -> Element:
        """Return the outermost element of a file or a text."""
        self._files += 1
        report = Report(None if isinstance(source, str) else str(source))
        data: bytes | str = source if isinstance(source, str) else b""
        if isinstance(source, Path):
            try:
                if not source.is_file():
                    raise FileNotFoundError(2, "there is no such file")
                with source.open("rb") as stream:
                    data = stream.read(MOST_BYTES + 1)
            except OSError as error:
                raise InputError(f"{name_file(str(source))}: {error.strerror or error}") from None
        root = parse(data, report)
        report.refuse(strict=False)
        if root is None:
            raise InputError(f"expected {self._format}, got {str(source)[:60]!r}")
        return root

    def parse_inclusion(self, element: Element, path: Path, model: str = "") -> Element:
        """Return the outermost element of an included file, which knows its file and model."""
        if self._files > MOST_FILES:
            raise self.refuse(element, f"more than {MOST_FILES} files are included")
        if not path.is_file():
            message = f"<{element.tag}> names {name_file(str(path))}: there is no such file"
            raise self.refuse(element, f"{message}; put it there, or mend its path")
        return _note(self.parse(path), str(path), model)

    def refuse(self, element: Element, message: str) -> InputError:
        """Return an error that names the file and the line of an element."""
        if message.endswith("is not read"):
            by_mass = "inertia" in message or "mesh" in message
            way = "state <inertial> in its body" if by_mass else "leave it out"
            message += f"; {way}, or say the same by what is read"
        place = name_file(element.file or (str(self.file) if self.file else ""))
        return InputError(
            f"{place}:{element.line}: {message}" if place else f"line {element.line}: {message}"
        )

    def count(self, element: Element) -> None:
        """Count an element that is read, and refuse one too many."""
        self._elements += 1
        if self._elements > MOST_ELEMENTS:
            raise self.refuse(element, f"more than {MOST_ELEMENTS:,} elements")

    def split(self, element: Element, text: str, wanted: str) -> list[float]:
        """Return the numbers of a text; the refusal of others begins with what is wanted."""
        try:
            values = [float(word) for word in text.split()]
        except ValueError:
            values = [math.nan]
        if not all(abs(value) <= LARGEST for value in values):
            most = f" of at most {LARGEST:g}" if all(map(math.isfinite, values)) else ""
            raise self.refuse(element, f"{wanted}{most}, got {text[:60]!r}")
        return values

    def resist(
        self,
        name: str,
        joint: str,
        stiffness: Array,
        ends: Array,
        damping: Array,
        factor: float = 1.0,
    ) -> None:
        """Add spring and damper in a joint: Σ kₙ xⁿ⁺¹ beyond two ends, and Σ cₙ |v|ⁿ v."""
        powers = np.arange(2, 5)
        stiffness, damping = stiffness * factor**powers, damping * abs(factor) ** powers
        low, high = sorted((ends / factor).tolist())
        names = Names(force.name for force in self.forces)
        if low != high or any(stiffness[1:]) or stiffness[0] < 0:
            x = beyond(coordinate(joint), low, high)
            V = sum(k * x ** (n + 2) / (n + 2) for n, k in enumerate(stiffness.tolist()))
            if any(stiffness):
                self.forces.append(Potential(names.free(f"{name}_spring"), joint, V))
        elif stiffness[0]:
            spring = JointSpring(names.free(f"{name}_spring"), joint, float(stiffness[0]), low)
            self.forces.append(spring)
        if any(damping[1:]):
            rate = velocity(joint)
            pull = -sum(c * abs(rate) ** n * rate for n, c in enumerate(damping.tolist()) if c)
            self.forces.append(JointForce(names.free(f"{name}_damper"), joint, pull))
        elif damping[0]:
            damper = JointDamper(names.free(f"{name}_damper"), joint, float(damping[0]))
            self.forces.append(damper)

    def lift(self, body: str, word: str, point: Array, mass: float) -> None:
        """Carry the weight of a mass at a point of a body."""
        if mass:
            x, y, z = point.tolist()
            fx, fy, fz = (-mass * self.gravity).tolist()
            self.forces.append(Force(f"{body}_{word}", body, (x, y, z), (fx, fy, fz)))

    def follow(self, element: Element, joint: str, law: Scalar) -> None:
        """Let a joint follow others by a law."""
        if joint in self.laws:
            raise self.refuse(element, f"joint {joint!r} is tied by several constraints")
        self.laws[joint] = element, law

    def compose_laws(self) -> dict[str, Scalar]:
        """Return the laws of all that follow, by joints that follow none."""
        composed: dict[str, Scalar] = {}

        def compose(joint: str, above: tuple[str, ...]) -> Scalar:
            element, law = self.laws[joint]
            if joint in above or len(above) > MOST_FOLLOWED:
                raise self.refuse(element, f"joint {joint!r} would follow itself")
            for leader in sorted(symbols_in(law) & self.laws.keys()):
                if leader not in composed:
                    composed[leader] = compose(leader, (*above, joint))
                law = law.subs({coordinate(leader): composed[leader]})
            return law

        for joint in self.laws:
            composed[joint] = composed[joint] if joint in composed else compose(joint, ())
        return {joint: composed[joint] for joint in self.laws}

    def assemble(
        self,
        name: str,
        bodies: Sequence[Body],
        loops: Sequence[Loop],
        follows: Mapping[str, Scalar],
        *about: str,
    ) -> Mechanism:
        """Return the mechanism of what was read."""
        x, y, z = self.gravity.tolist()
        joints, letters = self.joints, dict[str, str]()
        if any(_TIME in joint.coordinates for joint in joints):
            free = Names(name for joint in joints for name in joint.coordinates).free(_TIME)
            letters = {_TIME: free, f"{_TIME}'": f"{free}'"}
            joints = [j.renamed((free,)) if _TIME in j.coordinates else j for j in joints]
        laws = ((letters.get(k, k), rename(law, letters)) for k, law in follows.items())
        return Mechanism(
            name,
            tuple(bodies),
            tuple(joints),
            forces=tuple(_in_letters(force, letters) for force in self.forces),
            loops=tuple(loops),
            coordinates=Coordinates((), tuple(laws)),
            gravity=(x, y, z),
            ground=GROUND,
            about=self.describe(bodies, *about),
        )

    def describe(self, bodies: Sequence[Body], *more: str) -> str:
        """Say what was left out, how much of it, and what else is to be known."""
        omitted = [f"{what} ({count})" for what, count in sorted((+self.omitted).items())]
        if self.rubbing:
            omitted.append(f"dry friction of {', '.join(self.rubbing)}")
        said = [f"Read from {self._format}, without {', '.join(omitted)}."] if omitted else []
        said += more
        for body in bodies:
            fault = inertia_fault(body.mass, body.inertia) if body.as_given else None
            said += [f"Body {body.name!r}: {fault}; engines refuse or replace it."] if fault else []
        return " ".join(said)


def _in_letters(force: AnyForce, letters: Mapping[str, str]) -> AnyForce:
    """Return a force with other letters for some in its expressions."""
    match force:
        case Potential():
            return replace(force, potential=rename(force.potential, letters))
        case JointForce():
            return replace(force, force=rename(force.force, letters))
        case Force():
            x, y, z = (rename(part, letters) for part in force.force)
            return replace(force, force=(x, y, z))
        case Torque():
            x, y, z = (rename(part, letters) for part in force.torque)
            return replace(force, torque=(x, y, z))
    return force


def placement_at(pose: Array) -> Placement:
    """Return the placement of a pose, shape (4, 4)."""
    x, y, z = pose[:3, 3].tolist()
    return Placement((x, y, z), rpy_of(pose[:3, :3]))


def resist_rates(joint: Joint, damping: Sequence[float]) -> Iterator[Force | Torque]:
    """Yield the resistance Σ cₙ |v|ⁿ v to each velocity v of a ball, universal or free joint.

    It acts on both bodies. Velocities of a free joint's origin are those in the world's axes.
    """
    rates = np.array([coordinate(name) for name in joint.velocities[-3:]])
    axes, turn = joint.child, np.eye(3)
    if isinstance(joint, Universal):  # whose second axis the first one turns, both in the parent
        from sympy import cos, sin

        first = coordinate(joint.coordinates[0])
        axes, turn = joint.parent, pose_of(joint.origin)[:3, :3]
        rates = np.array([rates[0], rates[1] * cos(first), rates[1] * sin(first)])

    def resist(rates: Array) -> Array:
        return -sum((c * abs(rates) ** n * rates for n, c in enumerate(damping)), 0 * rates)

    if not any(damping):
        return
    x, y, z = turn @ resist(rates)
    yield Torque(f"{joint.name}_damper", joint.child, (x, y, z), axes=axes)
    if joint.parent != GROUND:
        name = f"{joint.name}_damper_on_{joint.parent}"
        yield Torque(name, joint.parent, (-x, -y, -z), axes=axes)
    if isinstance(joint, Floating):
        x, y, z, w = (coordinate(name) for name in joint.quaternion)
        R = turn_of_unit(w, x, y, z) if any(damping[1:]) else np.eye(3)
        fx, fy, fz = R.T @ resist(R @ [coordinate(name) for name in joint.velocities[:3]])
        yield Force(f"{joint.name}_drag", joint.child, (0.0, 0.0, 0.0), (fx, fy, fz), axes=axes)


def beyond(x: Scalar, low: float, high: float) -> Scalar:
    """How far x is above an interval, or below it as a negative number."""
    if low == high:
        return x - low
    above, below = x - high, low - x
    return (above + abs(above)) / 2 - (below + abs(below)) / 2


def draw(form: str, size: Array, pose: Array, rgba: Any = None) -> Iterator[Visual]:
    """Yield what shows a solid by half its sizes; a capsule is a cylinder between two balls."""
    a, b, c = size.tolist()
    shown: list[tuple[Geometry, float]] = []
    if form == "box" and size.min() > 0:
        shown.append((Box((2 * a, 2 * b, 2 * c)), 0.0))
    if form in ("cylinder", "capsule") and min(a, b) > 0:
        shown.append((Cylinder(a, 2 * b), 0.0))
    if form in ("sphere", "capsule") and a > 0:
        ends = {"sphere": [0.0], "capsule": [b, -b]}[form]
        shown += [(Sphere(a), end) for end in ends]
    for geometry, offset in shown:
        at = pose_at((0, 0, offset))
        yield Visual(geometry, placement_at(pose @ at), rgba)


def unit_vector(vector: Array | Sequence[float]) -> Array:
    """Return a direction as a vector of length one."""
    length = float(np.linalg.norm(vector))
    if not length > 1e-14:
        raise InputError(f"expected a direction with a length, got {np.array(vector).tolist()}")
    return np.asarray(vector, dtype=float) / length


def turn_of(quaternion: Array) -> Array:
    """The rotation matrix of a quaternion (w, x, y, z) of any length but zero."""
    return turn_of_unit(*unit_vector(quaternion))


def turn_of_unit(w: Scalar, x: Scalar, y: Scalar, z: Scalar) -> Array:
    """The rotation matrix of a unit quaternion, in numbers or letters."""
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + 2 * w * k + 2 * k @ k)


def turn_from_z(direction: Array) -> Array:
    """The smallest turn that takes z to a direction."""
    axis = np.cross([0.0, 0.0, 1.0], direction)
    if not np.linalg.norm(axis) > 1e-10 * np.linalg.norm(direction):
        return np.eye(3) if direction[2] > 0 else np.diag([1.0, -1.0, -1.0])
    return turn_about(axis, math.atan2(float(np.linalg.norm(axis)), float(direction[2])))


def _note(element: Element, file: str, model: str) -> Element:
    children = tuple(_note(child, file, model) for child in element.children)
    return replace(element, children=children, file=file, model=model)
