"""MJCF, MuJoCo's own format -> mechanism.

What the dynamics of a tree with springs, dampers and closures need is read as MuJoCo means it
(MuJoCo documentation, "XML Reference" and "Modeling"); tests compare mass matrix, bias and passive
forces with MuJoCo's. What they do without (contacts, actuators, sensors) is listed in
`Mechanism.about`; what would change them and is not read is refused by name.
"""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError
from mecanique.model.bodies import Body
from mecanique.model.bodies.shape import Shape
from mecanique.model.bodies.tensor import entries_of, tensor_of
from mecanique.model.bodies.visuals import Box, Cylinder, Geometry, Sphere, Visual
from mecanique.model.constraints.loops import Loop
from mecanique.model.coordinates import Coordinates
from mecanique.model.expression import Scalar, coordinate, symbols_in
from mecanique.model.force_base import AnyForce
from mecanique.model.forces import Force, JointDamper, JointSpring
from mecanique.model.joint_base import Limits
from mecanique.model.joints import Fixed, Floating, Joint, Prismatic, Revolute, Spherical
from mecanique.model.mechanism import Mechanism
from mecanique.model.placement import Placement, rpy_of
from mecanique.urdf.findings import Report
from mecanique.urdf.markup import Element
from mecanique.urdf.names import Names
from mecanique.urdf.parse import MOST_BYTES, parse

_GROUND = "world"
_MOST_FILES = 100
_MOST_ELEMENTS = 100_000

_SECTIONS = {
    "actuator": "actuators",
    "asset": "",
    "compiler": "",
    "contact": "contacts",
    "custom": "",
    "default": "",
    "equality": "",
    "keyframe": "keyframes",
    "option": "",
    "sensor": "sensors",
    "size": "",
    "statistic": "",
    "tendon": "tendons",
    "visual": "",
    "worldbody": "",
}
"""Sections below <mujoco>, and what the dynamics do without of them, in words."""

_ORIENTATIONS = ("quat", "axisangle", "xyaxes", "zaxis", "euler")
_IN_PARTS = {"size", "polycoef"}
"""Attributes of which an element may give the first numbers, and its class the rest."""

_READ = {
    "body": "name childclass pos gravcomp mocap quat axisangle xyaxes zaxis euler | user sleep",
    "inertial": "pos mass diaginertia fullinertia quat axisangle xyaxes zaxis euler",
    "joint": "name class type pos axis ref springref stiffness damping range limited armature "
    "frictionloss align springdamper | group user margin solreflimit solimplimit solreffriction "
    "solimpfriction actuatorfrcrange actuatorfrclimited actuatorgravcomp",
    "freejoint": "name align | group user",
    "geom": "name class type size pos fromto mass density shellinertia group rgba mesh quat "
    "axisangle xyaxes zaxis euler | contype conaffinity condim priority friction solmix solref "
    "solimp margin gap material hfield user fluidshape fluidcoef fitscale",
    "frame": "name childclass pos quat axisangle xyaxes zaxis euler",
    "connect": "name class active body1 body2 anchor site1 site2 | solref solimp",
    "weld": "name class active body1 body2 anchor relpose site1 site2 | torquescale solref solimp",
    "equality.joint": "name class active joint1 joint2 polycoef | solref solimp",
    "compiler": "angle eulerseq autolimits inertiafromgeom inertiagrouprange boundmass "
    "boundinertia balanceinertia settotalmass coordinate alignfree | meshdir texturedir assetdir "
    "fusestatic discardvisual strippath usethread convexhull fitaabb exactmeshinertia saveinertial",
    "option": "gravity density viscosity | timestep impratio wind magnetic integrator cone "
    "jacobian solver iterations tolerance ls_iterations ls_tolerance noslip_iterations "
    "noslip_tolerance ccd_iterations ccd_tolerance mpr_iterations mpr_tolerance sdf_iterations "
    "sdf_initpoints o_margin o_solref o_solimp o_friction actuatorgroupdisable apirate collision "
    "sleep_tolerance",
}
"""Attributes of elements: those that are read, and behind the bar those without a part in M, bias
and passive forces."""


def read_mjcf(path_or_text: str | os.PathLike[str]) -> Mechanism:
    """Return the mechanism that an MJCF file or text describes.

    Args:
        path_or_text: the path of the file, or its text.

    Raises:
        UrdfError: if it is not well-formed XML.
        InputError: if it holds what is not read, with its line.
    """
    file = None if isinstance(path_or_text, str) and "<" in path_or_text else Path(path_or_text)
    return _Reader(file).read(path_or_text)


@final
@dataclass
class _Settings:
    """What <compiler> and <option> say."""

    degrees: bool = True
    sequence: str = "xyz"
    autolimits: bool = True
    from_geoms: str = "auto"
    groups: tuple[float, float] = (0, 5)
    least_mass: float = 0.0
    least_inertia: float = 0.0
    balance: bool = False
    total: float = -1.0
    gravity: Array = field(default_factory=lambda: np.array([0.0, 0.0, -9.81]))
    springs: bool = True
    dampers: bool = True
    equalities: bool = True


@final
@dataclass
class _Mass:
    """Mass, center and inertia about it, in one frame."""

    mass: float
    center: Array
    inertia: Array

    def move(self, pose: Array) -> _Mass:
        turn = pose[:3, :3]
        return _Mass(self.mass, turn @ self.center + pose[:3, 3], turn @ self.inertia @ turn.T)


@final
@dataclass
class _Link:
    """A body of the tree, in the frame of its last joint's anchor."""

    name: str
    mass: _Mass
    visuals: list[Visual]
    shift: Array
    home: Array
    lift: float = 0.0


@final
class _Reader:
    """One file with those it includes."""

    def __init__(self, file: Path | None) -> None:
        self._file = file
        self._settings = _Settings()
        self._classes: dict[str, dict[str, dict[str, str]]] = {"main": {}}
        self._links: list[_Link] = []
        self._joints: list[Joint] = []
        self._forces: list[AnyForce] = []
        self._sites: dict[str, tuple[str, Array]] = {}
        self._references: dict[str, float] = {}
        self._bodies, self._names = Names([_GROUND]), Names()
        self._rubbing: list[str] = []
        self._omitted: Counter[str] = Counter()
        self._files = self._elements = 0

    def read(self, source: str | os.PathLike[str]) -> Mechanism:
        root = self._parse(self._file if self._file is not None else str(source))
        if root.tag != "mujoco":
            raise self._refuse(
                root, f"expected <mujoco> as the outermost element, not <{root.tag}>"
            )
        root = self._include(root)
        for child in root.children:
            if child.tag not in _SECTIONS:
                raise self._refuse(child, f"<{child.tag}> is not read")
            if (section := _SECTIONS[child.tag]) and child.children:
                self._omitted[section] += len(child.children)
        for child in root.all("compiler"):
            self._compile(child)
        for child in root.all("option"):
            self._set_options(child)
        for child in root.all("default"):
            if child.attributes.get("class", "main") != "main":
                raise self._refuse(child, "expected 'main' for the outermost class of defaults")
            self._define(child, "main", {})
        self._links.append(_Link(_GROUND, _empty(), [], np.eye(4), np.eye(4)))
        for world in root.all("worldbody"):
            self._fill(world, self._links[0], "main", np.eye(4))
        self._refuse_drives(root)
        return self._mechanism(root)

    # files

    def _parse(self, source: Path | str) -> Element:
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
                raise InputError(f"{source}: {error.strerror or error}") from None
        root = parse(data, report)
        report.refuse(strict=False)
        if root is None:
            raise InputError(f"expected MJCF, got {str(source)[:60]!r}")
        return root

    def _include(self, element: Element) -> Element:
        """Return an element with the contents of included files in their places."""
        children: list[Element] = []
        for child in element.children:
            if child.tag != "include":
                children.append(self._include(child))
                continue
            name = child.attributes.get("file", "")
            path = (self._file.parent if self._file else Path()) / name
            if self._file is None or not name or Path(name).is_absolute():
                raise self._refuse(child, f"expected a file beside this one, got {name!r}")
            if self._files > _MOST_FILES:
                raise self._refuse(child, f"more than {_MOST_FILES} files are included")
            included = _note_file(self._parse(path), str(path))
            children += self._include(included).children
        return replace(element, children=tuple(children))

    def _refuse(self, element: Element, message: str) -> InputError:
        place = element.file or (str(self._file) if self._file else "")
        return InputError(
            f"{place}:{element.line}: {message}" if place else f"line {element.line}: {message}"
        )

    # settings and defaults

    def _compile(self, element: Element) -> None:
        texts, s = self._attributes(element, "compiler", {}), self._settings
        s.degrees = texts.get("angle", "degree" if s.degrees else "radian") == "degree"
        s.sequence = texts.get("eulerseq", s.sequence)
        s.autolimits = texts.get("autolimits", str(s.autolimits).lower()) == "true"
        s.from_geoms = texts.get("inertiafromgeom", s.from_geoms)
        low, high = self._numbers(element, texts, "inertiagrouprange", s.groups, 2)
        s.groups = (low, high)
        s.least_mass = self._number(element, texts, "boundmass", s.least_mass)
        s.least_inertia = self._number(element, texts, "boundinertia", s.least_inertia)
        s.balance = texts.get("balanceinertia", str(s.balance).lower()) == "true"
        s.total = self._number(element, texts, "settotalmass", s.total)
        if (
            texts.get("coordinate", "local") != "local"
            or texts.get("alignfree", "false") != "false"
        ):
            raise self._refuse(element, "coordinate and alignfree of <compiler> are not read")

    def _set_options(self, element: Element) -> None:
        texts, s = self._attributes(element, "option", {}), self._settings
        s.gravity = self._numbers(element, texts, "gravity", s.gravity, 3)
        for name in ("density", "viscosity"):
            if self._number(element, texts, name, 0.0):
                raise self._refuse(element, f"forces of a medium ({name} of <option>) are not read")
        for flag in element.all("flag"):
            off = {name for name, text in flag.attributes.items() if text == "disable"}
            if "gravity" in off:
                s.gravity = np.zeros(3)
            s.springs = s.springs and not off & {"spring", "passive"}
            s.dampers = s.dampers and not off & {"damper", "passive"}
            s.equalities = s.equalities and not off & {"equality", "constraint"}

    def _define(self, element: Element, name: str, inherited: dict[str, dict[str, str]]) -> None:
        """Note the defaults of a class, and of those inside it."""
        table = {tag: dict(texts) for tag, texts in (self._classes.get(name) or inherited).items()}
        for child in element.children:
            if child.tag != "default":
                table.setdefault(child.tag, {}).update(child.attributes)
        self._classes[name] = table
        for child in element.all("default"):
            inner = child.attributes.get("class", "")
            if not inner:
                raise self._refuse(child, "a class of defaults inside another needs a name")
            self._define(child, inner, table)

    def _attributes(
        self, element: Element, kind: str, defaults: Mapping[str, str]
    ) -> dict[str, str]:
        """Return an element's attributes over its defaults; refuse what is not read."""
        self._elements += 1
        if self._elements > _MOST_ELEMENTS:
            raise self._refuse(element, f"more than {_MOST_ELEMENTS:,} elements")
        known = _READ[kind].replace("|", " ").split()
        for name in element.attributes:
            if name not in known:
                raise self._refuse(element, f"{name}=… of <{element.tag}> is not read")
        merged = {name: text for name, text in defaults.items() if name in known}
        if element.attributes.keys() & set(_ORIENTATIONS):
            merged = {name: text for name, text in merged.items() if name not in _ORIENTATIONS}
        for name in _IN_PARTS & merged.keys() & element.attributes.keys():
            given, rest = element.attributes[name].split(), merged[name].split()
            merged[name] = " ".join([*given, *rest[len(given) :]])
        whole = {
            k: text for k, text in element.attributes.items() if k not in _IN_PARTS & merged.keys()
        }
        return merged | whole

    def _resolve(self, element: Element, kind: str, inherited: str) -> dict[str, str]:
        name = element.attributes.get("class", inherited)
        if name not in self._classes:
            raise self._refuse(element, f"there is no class of defaults {name!r}")
        return self._attributes(element, kind, self._classes[name].get(element.tag, {}))

    # numbers

    def _numbers(
        self,
        element: Element,
        texts: Mapping[str, str],
        name: str,
        default: Sequence[float] | Array,
        count: int,
        *,
        least: int | None = None,
    ) -> Array:
        """Return an attribute's numbers; what may be left out at its end is that of the default."""
        if name not in texts:
            return np.array(default, dtype=float)
        try:
            values = [float(word) for word in texts[name].split()]
        except ValueError:
            values = []
        if not (count if least is None else least) <= len(values) <= count or not all(
            map(math.isfinite, values)
        ):
            shown = texts[name][:60]
            expected = f"expected {count} finite {'number' if count == 1 else 'numbers'}"
            raise self._refuse(element, f"{expected} for {name} of <{element.tag}>, got {shown!r}")
        return np.array([*values, *list(default)[len(values) :]], dtype=float)

    def _number(
        self, element: Element, texts: Mapping[str, str], name: str, default: float
    ) -> float:
        return float(self._numbers(element, texts, name, (default,), 1)[0])

    def _pose(self, element: Element, texts: Mapping[str, str]) -> Array:
        pose = np.eye(4)
        pose[:3, :3] = self._turn(element, texts)
        pose[:3, 3] = self._numbers(element, texts, "pos", (0, 0, 0), 3)
        return pose

    def _turn(self, element: Element, texts: Mapping[str, str]) -> Array:
        """The rotation matrix of an orientation in any of MuJoCo's five forms."""
        unit = math.radians(1) if self._settings.degrees else 1.0
        given = [name for name in _ORIENTATIONS if name in texts]
        if len(given) > 1:
            raise self._refuse(element, f"expected one orientation, got {' and '.join(given)}")
        match given:
            case ["quat"]:
                return _rotation(self._numbers(element, texts, "quat", (1, 0, 0, 0), 4))
            case ["axisangle"]:
                x, y, z, angle = self._numbers(element, texts, "axisangle", (0,) * 4, 4)
                return _about((x, y, z), angle * unit)
            case ["xyaxes"]:
                axes = self._numbers(element, texts, "xyaxes", (0,) * 6, 6)
                x_axis = _unit(axes[:3])
                y_axis = _unit(axes[3:] - (axes[3:] @ x_axis) * x_axis)
                return np.column_stack([x_axis, y_axis, np.cross(x_axis, y_axis)])
            case ["zaxis"]:
                return _from_z(self._numbers(element, texts, "zaxis", (0, 0, 1), 3))
            case ["euler"]:
                angles = self._numbers(element, texts, "euler", (0, 0, 0), 3) * unit
                turn = np.eye(3)
                for letter, angle in zip(self._settings.sequence, angles, strict=True):
                    step = _about(np.eye(3)["xyz".index(letter.lower())], angle)
                    # small letters turn about axes that turn along, capitals about fixed ones
                    turn = turn @ step if letter.islower() else step @ turn
                return turn
        return np.eye(3)

    # bodies

    def _contents(
        self, element: Element, inherited: str, pose: Array
    ) -> Iterator[tuple[Element, str, Array]]:
        """Yield what stands in a body, with its class of defaults and the frame it stands in."""
        for child in element.children:
            if child.tag != "frame":
                yield child, inherited, pose
                continue
            texts = self._attributes(child, "frame", {})
            inner = texts.get("childclass", inherited)
            yield from self._contents(child, inner, pose @ self._pose(child, texts))

    def _fill(self, element: Element, link: _Link, inherited: str, shift: Array) -> None:
        """Read what stands in a body into its link, then the bodies inside.

        Args:
            element: of the body.
            link: its link.
            inherited: its class of defaults.
            shift: pose of the body's frame in the link's.
        """
        parts: list[_Mass] = []
        given: _Mass | None = None
        inside: list[tuple[Element, str, Array]] = []
        rule = self._settings.from_geoms
        by_geoms = link.name != _GROUND and (
            rule == "true" or (rule == "auto" and element.child("inertial") is None)
        )
        for child, name, frame in self._contents(element, inherited, shift):
            match child.tag:
                case "body":
                    inside.append((child, name, frame))
                case "geom":
                    texts = self._resolve(child, "geom", name)
                    part = self._geom(child, texts, frame, link, by_geoms)
                    if part is not None:
                        parts.append(part)
                case "inertial":
                    given = self._inertial(child).move(frame)
                case "site":
                    site = self._classes[child.attributes.get("class", name)].get("site", {})
                    there = {**site, **child.attributes}
                    if there.get("name"):
                        self._sites[there["name"]] = (link.name, frame @ self._pose(child, there))
                case "joint" | "freejoint":
                    pass  # of the link itself
                case "camera" | "light":
                    self._omitted["cameras and lights"] += 1
                case _:
                    raise self._refuse(child, f"<{child.tag}> is not read")
        if link.name != _GROUND:
            if by_geoms:
                given = _sum(parts)
            link.mass = self._limit(given or _empty())
        for child, name, frame in inside:
            self._body(child, link, name, frame)

    def _body(self, element: Element, parent: _Link, inherited: str, frame: Array) -> None:
        texts = self._attributes(element, "body", {})
        name = self._bodies.free(texts.get("name") or "body")
        if texts.get("mocap") == "true":
            self._omitted["motions of mocap bodies"] += 1
        inherited = texts.get("childclass", inherited)
        pose = frame @ self._pose(element, texts)
        home = parent.home @ pose
        held = [
            (child, kind, place)
            for child, kind, place in self._contents(element, inherited, np.eye(4))
            if child.tag in ("joint", "freejoint")
        ]
        # each joint moves the body's frame about its own anchor; links between are empty
        carrier, origin = parent.name, pose
        shift = np.eye(4)
        for k, (child, kind, place) in enumerate(held):
            last = k == len(held) - 1
            moved = name if last else self._bodies.free(f"{name}_{k + 1}")
            shift = self._joint(child, kind, place, carrier, moved, origin @ shift)
            if not last:
                self._links.append(_Link(moved, _empty(), [], shift, home))
            carrier, origin = moved, np.eye(4)
        if not held:
            weld = self._names.free(f"{name}_weld")
            self._joints.append(Fixed(weld, parent.name, name, origin=_placement(pose)))
        link = _Link(name, _empty(), [], shift, home @ np.linalg.inv(shift))
        link.lift = self._number(element, texts, "gravcomp", 0.0)
        self._links.append(link)
        self._fill(element, link, inherited, shift)

    def _joint(
        self, element: Element, inherited: str, frame: Array, parent: str, child: str, pose: Array
    ) -> Array:
        """Add a joint, and return the pose of the body's frame in that of the joint's child.

        Args:
            element: of the joint.
            inherited: its class of defaults.
            frame: the frame in the body in which it stands.
            parent: what it moves against.
            child: what it moves.
            pose: of the body's frame in the parent before the joint moves.
        """
        kind = "freejoint" if element.tag == "freejoint" else "joint"
        texts = self._resolve(element, kind, inherited)
        form = "free" if kind == "freejoint" else texts.get("type", "hinge")
        name = self._names.free(texts.get("name") or f"{child}_{form}")
        if texts.get("align", "auto") == "true":
            raise self._refuse(element, "align=… of a free joint is not read")
        values = {
            what: self._number(element, texts, what, 0.0)
            for what in ("stiffness", "damping", "armature", "frictionloss")
        }
        if any(self._numbers(element, texts, "springdamper", (0, 0), 2)):
            raise self._refuse(element, "springdamper=… of <joint> is not read")
        if values["frictionloss"]:
            self._rubbing.append(name)
        if form in ("free", "ball"):
            for what in ("stiffness", "damping", "armature"):
                if values[what]:
                    raise self._refuse(element, f"{what} of a {form} joint is not read")
            if form == "free":
                if parent != _GROUND:
                    raise self._refuse(element, "a free joint expects a body of the world")
                self._joints.append(Floating(name, parent, child))
                return np.eye(4)
        at = np.eye(4)
        at[:3, 3] = (frame @ [*self._numbers(element, texts, "pos", (0, 0, 0), 3), 1.0])[:3]
        if form == "ball":
            self._joints.append(Spherical(name, parent, child, origin=_placement(pose @ at)))
            return np.asarray(np.linalg.inv(at))
        if form not in ("hinge", "slide"):
            raise self._refuse(
                element, f"expected a joint of type hinge, slide, ball or free, got {form!r}"
            )
        axis = _unit(frame[:3, :3] @ self._numbers(element, texts, "axis", (0, 0, 1), 3))
        unit = math.radians(1) if self._settings.degrees and form == "hinge" else 1.0
        reference = unit * self._number(element, texts, "ref", 0.0)
        rest = unit * self._number(element, texts, "springref", 0.0)
        limited = texts.get("limited", "auto")
        limits = None
        if limited == "true" or (
            limited == "auto" and self._settings.autolimits and "range" in texts
        ):
            low, high = unit * self._numbers(element, texts, "range", (0, 0), 2)
            limits = Limits(float(low), float(high))
        # the text shows the body where the coordinate is its reference
        back = np.eye(4)
        if form == "hinge":
            back[:3, :3] = _about(axis, -reference)
        else:
            back[:3, 3] = -reference * axis
        make = Revolute if form == "hinge" else Prismatic
        x, y, z = axis.tolist()
        self._joints.append(
            make(
                name,
                parent,
                child,
                origin=_placement(pose @ at @ back),
                axis=(x, y, z),
                limits=limits,
                armature=values["armature"],
            )
        )
        self._references[name] = reference
        if values["stiffness"] and self._settings.springs:
            spring = JointSpring(f"{name}_spring", name, values["stiffness"], rest)
            self._forces.append(spring)
        if values["damping"] and self._settings.dampers:
            self._forces.append(JointDamper(f"{name}_damper", name, values["damping"]))
        return np.asarray(np.linalg.inv(at))

    # masses

    def _inertial(self, element: Element) -> _Mass:
        texts = self._attributes(element, "inertial", {})
        for name in ("pos", "mass"):
            if name not in texts:
                raise self._refuse(element, f"<inertial> has no {name}=…")
        mass = self._number(element, texts, "mass", 0.0)
        pose = self._pose(element, texts)
        if "fullinertia" in texts:
            inertia = tensor_of(self._numbers(element, texts, "fullinertia", (0,) * 6, 6).tolist())
        else:
            inertia = np.diag(self._numbers(element, texts, "diaginertia", (0, 0, 0), 3))
        return _Mass(mass, np.zeros(3), inertia).move(pose)

    def _geom(
        self, element: Element, texts: Mapping[str, str], frame: Array, link: _Link, counts: bool
    ) -> _Mass | None:
        """Note how a geom looks, and return its mass if it counts."""
        form = texts.get("type", "mesh" if "mesh" in texts else "sphere")
        if self._number(element, texts, "contype", 1) or self._number(
            element, texts, "conaffinity", 1
        ):
            self._omitted["contacts of geoms"] += 1
        low, high = self._settings.groups
        counts = counts and low <= self._number(element, texts, "group", 0) <= high
        mass = self._number(element, texts, "mass", -1.0) if "mass" in texts else None
        density = self._number(element, texts, "density", 1000.0)
        if mass == 0 or (mass is None and density == 0):
            counts = False
        if form not in _SIZES:
            if counts and form != "plane":
                raise self._refuse(element, f"the inertia of a geom of type {form!r} is not read")
            return None
        if counts and texts.get("shellinertia") == "true":
            raise self._refuse(element, "shellinertia of a geom is not read")
        size = self._numbers(element, texts, "size", (0, 0, 0), 3, least=1)
        pose = self._pose(element, texts)
        if "fromto" in texts:
            ends = self._numbers(element, texts, "fromto", (0,) * 6, 6)
            arm = ends[:3] - ends[3:]
            length = float(np.linalg.norm(arm)) / 2
            size = np.array(
                [size[0], length, 0.0] if _SIZES[form] == 2 else [size[0], size[0], length]
            )
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = _from_z(arm), (ends[:3] + ends[3:]) / 2
        if not all(size[: _SIZES[form]] > 0):
            raise self._refuse(element, f"expected {_SIZES[form]} positive sizes of a {form}")
        place = frame @ pose
        rgba = tuple(self._numbers(element, texts, "rgba", (0.5, 0.5, 0.5, 1), 4).tolist())
        for geometry, offset in _draw(form, size):
            at = np.eye(4)
            at[2, 3] = offset
            link.visuals.append(Visual(geometry, _placement(place @ at), rgba))
        if not counts:
            return None
        volume, radii = _solid(form, size)
        total = density * volume if mass is None else mass
        return _Mass(total, np.zeros(3), np.diag(total * radii)).move(place)

    def _limit(self, mass: _Mass) -> _Mass:
        """Raise a mass and its principal moments to the least that <compiler> allows."""
        s = self._settings
        total = max(mass.mass, s.least_mass)
        if not (s.least_inertia or s.balance):
            return replace(mass, mass=total)
        moments, axes = np.linalg.eigh(mass.inertia)
        moments = np.maximum(moments, s.least_inertia)
        if s.balance and moments[0] + moments[1] < moments[2]:
            moments = np.full(3, moments.mean())
        return _Mass(total, mass.center, axes @ np.diag(moments) @ axes.T)

    # what is left

    def _refuse_drives(self, root: Element) -> None:
        """Refuse tendons and actuators that enter the mass matrix or the passive forces."""
        for section, names in (
            ("tendon", ("stiffness", "damping", "armature")),
            ("actuator", ("armature",)),
        ):
            for element in (child for part in root.all(section) for child in part.children):
                kind = element.attributes.get("class", "main")
                table = self._classes.get(kind, {})
                general = "tendon" if section == "tendon" else element.tag
                texts = {**table.get(general, {}), **element.attributes}
                for name in names:
                    if any(word.strip("0.") for word in texts.get(name, "0").split()):
                        raise self._refuse(element, f"{name} of <{element.tag}> is not read")
                if element.tag == "plugin" or "plugin" in texts:
                    raise self._refuse(element, "plugins are not read")

    def _close(self, root: Element) -> tuple[list[Loop], dict[str, Scalar]]:
        """Return the loops and the map of joints that the equality constraints make."""
        loops: list[Loop] = []
        follows: dict[str, Scalar] = {}
        names = Names()
        links = {link.name: link for link in self._links}
        for element in (child for part in root.all("equality") for child in part.children):
            kind = element.attributes.get("class", "main")
            defaults = self._classes.get(kind, {}).get("equality", {})
            if {**defaults, **element.attributes}.get("active") == "false" or (
                not self._settings.equalities
            ):
                self._omitted["inactive constraints"] += 1
                continue
            if element.tag not in ("connect", "weld", "joint"):
                raise self._refuse(element, f"<{element.tag}> among the constraints is not read")
            key = "equality.joint" if element.tag == "joint" else element.tag
            texts = self._attributes(element, key, defaults)
            name = names.free(texts.get("name") or element.tag)
            if element.tag == "joint":
                self._follow(element, texts, follows)
                continue
            if "site1" in texts:
                ends = [self._sites.get(texts.get(site, "")) for site in ("site1", "site2")]
                if None in ends:
                    raise self._refuse(element, f"<{element.tag}> names a site that is not there")
                (a, at_a), (b, at_b) = (end for end in ends if end is not None)
            else:
                a, b = texts.get("body1", _GROUND), texts.get("body2", _GROUND)
                if a not in links or b not in links:
                    raise self._refuse(element, f"<{element.tag}> names a body that is not there")
                at_a, at_b = self._meet(element, texts, links[a], links[b])
            if element.tag == "connect":
                points = (tuple(at_a[:3, 3].tolist()), tuple(at_b[:3, 3].tolist()))
                loops.append(Loop.ball(name, a, points[0], b, points[1]))
            else:
                loops.append(Loop.weld(name, a, _placement(at_a), b, _placement(at_b)))
        return loops, follows

    def _meet(
        self, element: Element, texts: Mapping[str, str], a: _Link, b: _Link
    ) -> tuple[Array, Array]:
        """The poses in two links of frames that a constraint keeps together."""
        anchor, relative = np.eye(4), np.eye(4)
        anchor[:3, 3] = self._numbers(element, texts, "anchor", (0, 0, 0), 3)
        if element.tag == "connect":
            at = a.shift @ anchor
            return at, np.linalg.inv(b.home) @ a.home @ at
        numbers = self._numbers(element, texts, "relpose", (0, 1, 0, 0, 0, 0, 0), 7)
        at = b.shift @ anchor
        if not any(numbers[3:]):  # as the text shows the bodies
            return np.linalg.inv(a.home) @ b.home @ at, at
        relative[:3, :3], relative[:3, 3] = _rotation(numbers[3:]), numbers[:3]
        return a.shift @ relative, at  # where the anchor of b goes, MuJoCo counts it in

    def _follow(
        self, element: Element, texts: Mapping[str, str], follows: dict[str, Scalar]
    ) -> None:
        """Note y − y₀ = Σ cₖ (x − x₀)ᵏ of two joints."""
        first, second = texts.get("joint1", ""), texts.get("joint2", "")
        for name in (first, *([second] if second else [])):
            if name not in self._references:
                raise self._refuse(element, f"{name!r} is no hinge or slide")
        factors = self._numbers(element, texts, "polycoef", (0, 1, 0, 0, 0), 5, least=1).tolist()
        law: Scalar = self._references[first] + factors[0]
        if second:
            x = coordinate(second) - self._references[second]
            law = law + sum(c * x**k for k, c in enumerate(factors) if k and c)
        if first in follows or any(first in symbols_in(other) for other in follows.values()):
            raise self._refuse(element, f"joint {first!r} is tied by several constraints")
        for leader, other in follows.items():
            if leader == second:
                law = law.subs({coordinate(leader): other})
        if first in symbols_in(law):
            raise self._refuse(element, f"joint {first!r} would follow itself")
        follows[first] = law

    def _mechanism(self, root: Element) -> Mechanism:
        s = self._settings
        total = sum(link.mass.mass for link in self._links)
        scale = s.total / total if s.total > 0 and total > 0 else 1.0
        loops, follows = self._close(root)
        bodies = []
        for link in self._links:
            mass = link.mass
            x, y, z = mass.center.tolist()
            entries: Any = entries_of(scale * mass.inertia)
            shape = Shape(scale * mass.mass, (x, y, z), entries, tuple(link.visuals))
            bodies.append(Body(link.name, shape))
            if link.lift:
                lift = tuple((-link.lift * scale * mass.mass * s.gravity).tolist())
                self._forces.append(Force(f"{link.name}_gravcomp", link.name, (x, y, z), lift))
        omitted = [f"{count} {what}" for what, count in sorted(self._omitted.items())]
        if self._rubbing:
            omitted.append(f"dry friction of {', '.join(self._rubbing)}")
        return Mechanism(
            root.attributes.get("model", "MuJoCo model"),
            tuple(bodies),
            tuple(self._joints),
            forces=tuple(self._forces),
            loops=tuple(loops),
            coordinates=Coordinates((), tuple(follows.items())),
            gravity=tuple(s.gravity.tolist()),
            ground=_GROUND,
            about=f"Read from MJCF, without {', '.join(omitted)}." if omitted else "",
        )


_SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "ellipsoid": 3, "box": 3}
"""How many sizes each kind of geom has that has a volume."""


def _solid(form: str, size: Array) -> tuple[float, Array]:
    """Volume, and squares of the radii of gyration about the axes."""
    a, b, c = size
    match form:
        case "sphere":
            return 4 / 3 * math.pi * a**3, np.full(3, 2 / 5 * a**2)
        case "ellipsoid":
            squares = np.array([b * b + c * c, a * a + c * c, a * a + b * b])
            return 4 / 3 * math.pi * a * b * c, squares / 5
        case "box":
            squares = np.array([b * b + c * c, a * a + c * c, a * a + b * b])
            return 8 * a * b * c, squares / 3
        case "cylinder":
            across = a * a / 4 + b * b / 3
            return 2 * math.pi * a * a * b, np.array([across, across, a * a / 2])
    # a capsule: a cylinder and two halves of a ball, whose centers lie 3/8 r beyond its ends
    tube, ball = 2 * math.pi * a * a * b, 4 / 3 * math.pi * a**3
    across = tube * (a * a / 4 + b * b / 3) + ball * (2 / 5 * a * a + b * b + 3 / 4 * a * b)
    along = tube * a * a / 2 + ball * 2 / 5 * a * a
    return tube + ball, np.array([across, across, along]) / (tube + ball)


def _draw(form: str, size: Array) -> list[tuple[Geometry, float]]:
    """What shows a geom, and where along its z axis."""
    a, b, c = size.tolist()
    match form:
        case "sphere":
            return [(Sphere(a), 0.0)]
        case "box":
            return [(Box((2 * a, 2 * b, 2 * c)), 0.0)]
        case "cylinder":
            return [(Cylinder(a, 2 * b), 0.0)]
        case "capsule":
            return [(Cylinder(a, 2 * b), 0.0), (Sphere(a), b), (Sphere(a), -b)]
    return []


def _empty() -> _Mass:
    return _Mass(0.0, np.zeros(3), np.zeros((3, 3)))


def _sum(parts: Sequence[_Mass]) -> _Mass:
    total = sum(part.mass for part in parts)
    if not total > 0:
        return _empty()
    center = sum((part.mass * part.center for part in parts), np.zeros(3)) / total
    inertia = np.zeros((3, 3))
    for part in parts:
        arm = part.center - center
        inertia += part.inertia + part.mass * ((arm @ arm) * np.eye(3) - np.outer(arm, arm))
    return _Mass(total, center, inertia)


def _placement(pose: Array) -> Placement:
    x, y, z = pose[:3, 3].tolist()
    return Placement((x, y, z), rpy_of(pose[:3, :3]))


def _unit(vector: Array | Sequence[float]) -> Array:
    length = float(np.linalg.norm(vector))
    if not length > 1e-14:
        raise InputError(f"expected a direction with a length, got {list(vector)}")
    return np.asarray(vector, dtype=float) / length


def _about(axis: Array | Sequence[float], angle: float) -> Array:
    """Rodrigues' formula: R = 1 + sin α K + (1 − cos α) K²."""
    x, y, z = _unit(axis)
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + math.sin(angle) * k + (1 - math.cos(angle)) * k @ k)


def _rotation(quaternion: Array) -> Array:
    """The rotation matrix of a quaternion (w, x, y, z) of any length but zero."""
    w, x, y, z = _unit(quaternion)
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + 2 * w * k + 2 * k @ k)


def _from_z(direction: Array) -> Array:
    """The smallest turn that takes z to a direction."""
    axis = np.cross([0.0, 0.0, 1.0], direction)
    if not np.linalg.norm(axis) > 1e-10 * np.linalg.norm(direction):
        return np.eye(3) if direction[2] > 0 else np.diag([1.0, -1.0, -1.0])
    return _about(axis, math.atan2(float(np.linalg.norm(axis)), float(direction[2])))


def _note_file(element: Element, file: str) -> Element:
    children = tuple(_note_file(child, file) for child in element.children)
    return replace(element, children=children, file=file)
