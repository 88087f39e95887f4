"""MJCF, MuJoCo's own format, read and written.

What the dynamics of a tree with springs, dampers, tendons, rotors and closures need is read as
MuJoCo means it (MuJoCo documentation, "XML Reference" and "Modeling"); tests compare mass matrix,
bias and passive forces with MuJoCo's. What they do without (contacts, drives, sensors) is listed in
`Mechanism.about`; what would change them and is not read is refused by name.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError
from mecanique.formats.scope import (
    LENGTH,
    SCOPES,
    THICKENED,
    is_light,
    is_thin,
    joint_damping,
    joint_spring,
    lifted_share,
    list_lengths,
    passes_on,
    tendon_factors,
)
from mecanique.formats.solids import (
    RULES,
    SIZES,
    faces_of,
    mesh_of,
    principal_axes,
    read_solid,
    shell_of,
)
from mecanique.formats.sources import (
    GROUND,
    MOST_ELEMENTS,
    MOST_FILES,
    Given,
    Source,
    beyond,
    draw,
    placement_at,
    refuse_overflow,
    resist_rates,
    turn_from_z,
    turn_of,
    turn_of_unit,
)
from mecanique.model.bodies import Body
from mecanique.model.bodies.tensor import tensor_of
from mecanique.model.bodies.visuals import Mesh, Visual, measure
from mecanique.model.constraints.loops import Loop
from mecanique.model.expression import (
    DISTANCE,
    Scalar,
    coordinate,
    evaluate,
    plain,
    position,
    symbols_in,
    velocity,
)
from mecanique.model.force_base import AnyForce
from mecanique.model.forces import (
    CentralForce,
    Damper,
    Force,
    JointForce,
    PotentialField,
    Spring,
    Torque,
)
from mecanique.model.joint_base import Limits, Single
from mecanique.model.joints import Fixed, Floating, Joint, Prismatic, Revolute, Spherical
from mecanique.model.mechanism import Mechanism
from mecanique.model.placement import Placement, pose_along, pose_at, pose_of, turn_about
from mecanique.model.quaternions import conjugate, from_matrices
from mecanique.model.states import States
from mecanique.urdf.dialect import UNBOUNDED
from mecanique.urdf.markup import Element, Node, Tag, number, numbers, write_xml
from mecanique.urdf.names import Names
from mecanique.urdf.solids import Corners, Mass, no_mass, solid_of, sum_masses
from mecanique.urdf.write import SimpleJoint, axial_steps, chains, law_of_follower

_SECTIONS = (
    "asset compiler custom default equality extension option size statistic visual worldbody"
)
_COUNTED = ("actuator", "contact", "keyframe", "sensor", "tendon")
"""Sections below <mujoco>; of the latter the dynamics do without a part, which is counted."""

_ORIENTATIONS = ("quat", "axisangle", "xyaxes", "zaxis", "euler")
_MOST_OPERATIONS = 2000
"""Of an expression for the flow at a body, or for a length; each joint multiplies them."""

_NO_MASS = 1e-15
"""MuJoCo's mjMINVAL."""

_NO_TURN = 1e-15
"""Sine of half a turn beside which none has a direction: θ / sin(θ/2) then is 2, as it should."""

_ROUND = 1e-6
"""Relative difference of a mesh's moments, of vertices in single precision, that fixes no axis."""

_IN_PARTS = {"size", "polycoef", "stiffness", "damping"}
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
    "solimp margin gap material hfield user fluidshape fluidcoef fitscale surfacevel "
    "adhesion",
    "attach": "model body frame prefix",
    "frame": "name childclass pos quat axisangle xyaxes zaxis euler",
    "replicate": "count offset euler sep childclass",
    "mesh": "name class file vertex face scale refpos refquat inertia maxhullvert | content_type "
    "normal texcoord smoothnormal material octree_maxdepth needsdf",
    "tendon": "name class stiffness damping armature springlength | group limited range "
    "solreflimit solimplimit solreffriction solimpfriction frictionloss margin width material rgba "
    "user actuatorfrclimited actuatorfrcrange",
    "equality.tendon": "name class active tendon1 tendon2 polycoef | solref solimp",
    "equality.connect": "name class active body1 body2 anchor site1 site2 | solref solimp",
    "equality.weld": "name class active body1 body2 anchor relpose site1 site2 | torquescale "
    "solref solimp",
    "equality.joint": "name class active joint1 joint2 polycoef | solref solimp",
    "compiler": "angle eulerseq autolimits inertiafromgeom inertiagrouprange boundmass "
    "boundinertia balanceinertia settotalmass coordinate alignfree meshdir assetdir fitaabb "
    "strippath conflict | texturedir fusestatic discardvisual usethread convexhull "
    "exactmeshinertia saveinertial",
    "option": "gravity density viscosity wind | timestep impratio magnetic integrator cone "
    "jacobian solver iterations tolerance ls_iterations ls_tolerance noslip_iterations "
    "noslip_tolerance ccd_iterations ccd_tolerance mpr_iterations mpr_tolerance sdf_iterations "
    "sdf_initpoints o_margin o_solref o_solimp o_friction actuatorgroupdisable apirate collision "
    "sleep_tolerance",
}
"""Attributes of elements: those that are read, and behind the bar those without a part in M, bias
and passive forces."""


def read_mjcf(path_or_text: str | os.PathLike[str], *, tied: bool = True) -> Mechanism:
    """Return the mechanism that an MJCF file or text describes."""
    file = None if isinstance(path_or_text, str) and "<" in path_or_text else Path(path_or_text)
    with refuse_overflow(file):
        return _Reader(file, tied=tied).read(path_or_text)


@final
@dataclass
class _Model:
    """What a file and those it includes state for their own elements: settings, classes, assets."""

    file: Path | None
    compiler: Given
    classes: dict[str, dict[str, dict[str, str]]] = field(default_factory=lambda: {"main": {}})
    meshes: dict[str, Given] = field(default_factory=dict)
    solids: dict[str, Mass] = field(default_factory=dict)
    fields: dict[str, Array] = field(default_factory=dict)  # half boxes with the mass of heights


@final
@dataclass
class _Options:
    """What <option> says, of the outermost model alone."""

    density: float = 0.0  # of the medium around
    viscosity: float = 0.0
    wind: Array = field(default_factory=lambda: np.zeros(3))
    flags: dict[str, str] = field(default_factory=dict)

    def has(self, *flags: str) -> bool:
        """Whether no one of these flags is disabled."""
        return all(self.flags.get(flag) != "disable" for flag in flags)

    @property
    def passive(self) -> bool:
        """Whether there are passive forces: MuJoCo computes none without springs and dampers."""
        return self.has("spring") or self.has("damper")


@final
@dataclass
class _Link:
    """A body of the tree, in the frame of its last joint's anchor."""

    name: str
    mass: Mass
    visuals: list[Visual]
    shift: Array
    home: Array
    lift: float = 0.0


class _Flow(NamedTuple):
    """How a frame moves, and the wind, in its own axes: numbers or expressions, shape (3,) each."""

    velocity: Array
    spin: Array
    wind: Array
    depth: int  # how many joints move it

    def move(self, pose: Array) -> _Flow:
        """Return that of a frame with a pose in this one."""
        velocity = self.velocity + np.cross(self.spin, pose[:3, 3])
        velocity, spin, wind = (pose[:3, :3].T @ part for part in (velocity, self.spin, self.wind))
        return _Flow(velocity, spin, wind, self.depth)

    def add(self, velocity: Array, spin: Array) -> _Flow:
        """Return that of a frame which moves in this one."""
        return self._replace(velocity=self.velocity + velocity, spin=self.spin + spin)


_Site: TypeAlias = tuple[str, Array]
"""A place in a link: its name, and the pose in it."""


@final
@dataclass
class _Tendon:
    """A tendon, with the joint whose coordinate times a factor is its length, once it is known."""

    element: Element
    name: str
    factors: dict[str, float] = field(default_factory=dict)  # of joints, if it runs along them
    spans: list[tuple[_Site, _Site, float]] = field(default_factory=list)  # and shares of them
    joint: str = ""
    factor: float = 1.0
    inertial: list[tuple[str, float]] = field(default_factory=list)  # such pairs with armature

    def along(self, joints: Mapping[str, Scalar]) -> Scalar:
        """Its length along joints, Σ cₖ qₖ."""
        return sum((factor * joints[joint] for joint, factor in self.factors.items()), 0.0)


_REFERENCES = (
    *("body", "body1", "body2", "site", "site1", "site2", "joint", "joint1", "joint2"),
    *("jointinparent", "tendon", "tendon1", "tendon2", "cranksite", "slidersite", "geom"),
)
"""Attributes by which elements of tendons, actuators and constraints name others."""

_DRIVES = "general motor position velocity intvelocity damper cylinder muscle adhesion dcmotor"
_DRIVE = "general"
"""Actuators, and under which name classes keep the defaults of all of them as one."""


@final
class _Reader(Source):
    """One file with those it includes."""

    def __init__(self, file: Path | None, *, tied: bool) -> None:
        super().__init__(file, "MJCF")
        self._tied = tied
        self._options = _Options()
        self._unset = Given(self, Element("compiler", {}, (), "", 1, 0), {})
        self._models = {"": _Model(file, self._unset)}  # with those attached
        self._links: list[_Link] = []
        self._sites: dict[str, tuple[str, Array]] = {}
        self._references: dict[str, float] = {}
        self._rests: dict[str, float] = {}
        self._tendons: dict[str, _Tendon] = {}
        self._lengths: dict[str, str] = {}  # bodies of joints that are as far as tendons are long
        self._bodies, self._names = Names([GROUND]), Names()
        self._rotors: dict[str, float] = {}
        self._carried_along: dict[str, float] = {}
        self._drives_lift = False
        self._claimed: set[tuple[str, str]] = set()  # kinds and names of bodies and joints
        self._aligned: set[str] = set()  # free bodies whose frames are those of their inertias
        # stiffness of ball and free joints, and armature of those on bodies that turn
        self._turning: dict[str, tuple[Element, Array, float]] = {}
        # time constant and damping ratio of springs, beside the powers that joints state
        self._timed: dict[str, tuple[Array, Array, Array]] = {}

    def read(self, source: str | os.PathLike[str]) -> Mechanism:
        root = self.parse(self.file if self.file is not None else str(source))
        root = self._compose(root)
        for child in root.children:
            if child.tag in _COUNTED and child.children:
                self.omitted[f"{child.tag}s"] += len(child.children)
        for child in root.all("option"):
            self._set_options(child)
        if not self._options.has("gravity"):
            self.gravity = np.zeros(3)
        self._links.append(_Link(GROUND, no_mass(), [], np.eye(4), np.eye(4)))
        for world in root.all("worldbody"):
            self._fill(world, self._links[0], "main", np.eye(4), np.zeros(3))
        self._spring_balls()
        self._pull_tendons(root)
        self._add_drives(root)
        return self._mechanism(root)

    # files

    def _include(self, element: Element) -> Element:
        """Return an element with the contents of included files in their places."""
        children: list[Element] = []
        for child in element.children:
            if child.tag != "include":
                children.append(self._include(child))
                continue
            inside = self.parse_inclusion(child, self._find_file(child), element.model)
            children += self._include(inside).children
        return replace(element, children=tuple(children))

    def _find_file(self, element: Element) -> Path:
        """Return the file that an element names."""
        name = element.attributes.get("file", "")
        if self.file is None or not name or Path(name).is_absolute():
            raise self.refuse(element, f"expected a file beside this one, got {name!r}")
        return self._beside(element, name)

    def _beside(self, element: Element, name: str | Path, folder: str = "") -> Path:
        """Return a file beside the model's own or, if there is none, beside the one naming it."""
        file = self._models[element.model].file
        main = (file.parent if file else Path()) / folder / name
        near = Path(element.file).parent / name
        return near if element.file and not main.is_file() and near.is_file() else main

    # models in models

    def _compose(self, root: Element) -> Element:
        """Return a model with what it includes and attaches; note its settings and assets."""
        if root.tag != "mujoco":
            raise self.refuse(root, f"expected <mujoco> as the outermost element, not <{root.tag}>")
        root = self._include(root)
        for child in root.children:
            if child.tag not in (*_SECTIONS.split(), *_COUNTED):
                raise self.refuse(child, f"<{child.tag}> is not read")
        for child in root.all("compiler"):
            self._compile(child)
        for child in root.all("default"):
            if child.attributes.get("class", "main") != "main":
                raise self.refuse(child, "expected 'main' for the outermost class of defaults")
            self._define(child, "main", {})
        attachable = {"": root}  # what names no model attaches a part of its own once more
        for asset in (child for part in root.all("asset") for child in part.children):
            if asset.tag == "model":
                model = self._open_model(asset)
                default = model.attributes.get("model", "MuJoCo Model")
                attachable[asset.attributes.get("name", default)] = model
            else:
                self._note_asset(asset)
        sections: list[Element] = []
        children: list[Element] = []
        for child in root.children:
            is_world = child.tag == "worldbody"
            children += self._expand(child, attachable, sections) if is_world else [child]
        return replace(root, children=(*children, *sections))

    def _open_model(self, asset: Element) -> Element:
        """Return the model of a file that may be attached, with what it attaches itself."""
        path, key = self._find_file(asset), f"{len(self._models)}"
        if len(self._models) > MOST_FILES:
            raise self.refuse(asset, f"more than {MOST_FILES} models are attached")
        self._models[key] = _Model(path, self._unset)
        model = self._compose(self.parse_inclusion(asset, path, key))
        if model.child("option") is not None:
            if self._set_in(asset).get("conflict") == "merge":
                why = "the options of attached models count by conflict='merge' of <compiler>"
                raise self.refuse(asset, f"{why}, which is not read: state them in this model")
            self.omitted["options of attached models"] += 1
        return model

    def _expand(
        self, element: Element, models: Mapping[str, Element], sections: list[Element]
    ) -> list[Element]:
        """Return an element with models for <attach>, whose sections are added, and copies.

        Copies of <replicate> stand in frames; a name inside one ends with the number of the copy,
        the innermost first.
        """
        self.count(element)
        if element.tag == "attach":
            return [self._stand(element, models, sections)]
        children: list[Element] = []
        attached: list[Element] = []
        for child in element.children:
            children += self._expand(child, models, attached)
        whole = replace(element, children=tuple(children))
        if element.tag != "replicate":
            sections += attached
            return [whole]
        texts = self._attributes(element, "replicate", {})
        count = texts.number("count", 0.0)
        size = sum(1 for part in (whole, *attached) for _ in part.walk())
        if not (count >= 1 and count == int(count)):
            raise self.refuse(element, f"expected a count of copies, got {texts.get('count')!r}")
        if count * size > MOST_ELEMENTS:
            raise self.refuse(element, f"more than {MOST_ELEMENTS:,} elements")
        offset = texts.numbers("offset", (0, 0, 0))
        angles = texts.numbers("euler", (0, 0, 0))
        place, frames = np.zeros(3), []
        digits = len(str(int(count)))
        for k in range(int(count)):
            end = f"{texts.get('sep', '')}{k:0{digits}d}"
            attributes = {
                "pos": " ".join(map(repr, place.tolist())),
                "euler": " ".join(map(repr, (k * angles).tolist())),
            }
            if "childclass" in texts:
                attributes["childclass"] = texts["childclass"]
            named = tuple(_rename(child, "", end) for child in children)
            sections += [_rename(section, "", end) for section in attached]
            frames.append(replace(element, tag="frame", attributes=attributes, children=named))
            place = (
                place + self._turn(Given(self, element, {"euler": attributes["euler"]})) @ offset
            )
        return frames

    def _stand(
        self, attach: Element, models: Mapping[str, Element], sections: list[Element]
    ) -> Element:
        """Return a frame with what is attached, which keeps settings and classes of its model."""
        texts = self._attributes(attach, "attach", {})
        name, prefix = texts.get("model", ""), texts.get("prefix")
        if prefix is None:
            raise self.refuse(attach, "<attach> has no prefix=…")
        if name not in models or not (name or {"body", "frame"} & texts.keys()):
            known = ", ".join(map(repr, filter(None, models))) or "none"
            message = f"<attach> expects one of the models among the assets, {known}"
            raise self.refuse(attach, f"{message}; got {name!r}")
        whole, kind = models[name], "main"
        inside = [part for world in whole.all("worldbody") for part in world.children]
        part = "frame" if "frame" in texts else "body"
        if part in texts:
            inside, kind = self._find_part(attach, inside, part, texts[part])
        held = {part.attributes.get("name") for top in inside for part in top.walk()} | {GROUND}
        # tendons first: what acts on those that are attached is attached, too
        attached: list[Element] = []
        for section in sorted(whole.children, key=lambda section: section.tag != "tendon"):
            if section.tag in (*_COUNTED, "equality"):
                rows = [
                    row for row in section.children if part not in texts or _refers(row) <= held
                ]
                for row in section.children:
                    if not name and (_refers(row) - held) and (_refers(row) & held - {GROUND}):
                        what = f"<{row.tag}> of line {row.line} refers to a part of it alone"
                        raise self.refuse(attach, f"an <attach> is not read where {what}")
                if section.tag == "tendon":
                    held |= {row.attributes.get("name") for row in rows}
                named = tuple(_rename(row, prefix, "") for row in rows)
                attached.append(replace(section, children=named))
        named = tuple(_rename(part, prefix, "") for part in inside)
        frame = replace(whole, tag="frame", attributes={"childclass": kind}, children=named)
        for element in (frame, *attached):
            for inner in element.walk():
                self.count(inner)
        sections += attached
        return replace(frame, line=attach.line, file=attach.file)

    def _find_part(
        self, attach: Element, elements: Sequence[Element], tag: str, name: str
    ) -> tuple[list[Element], str]:
        """Return the body or frame of a model that is attached alone, and its class of defaults."""
        waiting = [(element, "main") for element in elements]
        while waiting:
            element, kind = waiting.pop(0)
            if element.tag == tag and element.attributes.get("name") == name:
                return [element], kind
            kind = element.attributes.get("childclass", kind)
            waiting += [(inner, kind) for inner in element.children]
        model = attach.attributes.get("model", "")
        raise self.refuse(attach, f"model {model!r} has no {tag} {name!r}")

    # settings and defaults

    def _compile(self, element: Element) -> None:
        before = dict(self._set_in(element))
        if "assetdir" in element.attributes:
            before.pop("meshdir", "")
        texts = self._attributes(element, "compiler", before)
        sequence = texts.get("eulerseq", "xyz")
        if len(sequence) != 3 or not set(sequence) <= set("xyzXYZ"):
            raise texts.refuse(f"expected three of xyz or XYZ for eulerseq, got {sequence!r}")
        if texts.get("coordinate", "local") != "local":
            raise self.refuse(element, "coordinate of <compiler> is not read")
        self._models[element.model].compiler = texts

    def _set_in(self, element: Element) -> Given:
        """What <compiler> says in the model of an element."""
        return self._models[element.model].compiler

    def _degree(self, element: Element) -> float:
        """The unit of angles in the model of an element [rad]."""
        return 1.0 if self._set_in(element).get("angle") == "radian" else math.radians(1)

    def _set_options(self, element: Element) -> None:
        texts, s = self._attributes(element, "option", {}), self._options
        self.gravity = texts.numbers("gravity", self.gravity)
        s.density = texts.number("density", s.density)
        s.viscosity = texts.number("viscosity", s.viscosity)
        s.wind = texts.numbers("wind", s.wind)
        for flag in element.all("flag"):
            whole = flag.attributes.get("passive")  # of MuJoCo until 3.3
            s.flags |= {} if whole is None else {"spring": whole, "damper": whole}
            s.flags |= flag.attributes

    def _define(self, element: Element, name: str, inherited: dict[str, dict[str, str]]) -> None:
        """Note the defaults of a class, and of those inside it."""
        classes = self._models[element.model].classes
        table = {tag: dict(texts) for tag, texts in (classes.get(name) or inherited).items()}
        for child in element.children:
            if child.tag != "default":
                kind = _DRIVE if child.tag in _DRIVES.split() else child.tag
                table[kind] = _overlay(table.get(kind, {}), child.attributes)
        classes[name] = table
        for child in element.all("default"):
            inner = child.attributes.get("class", "")
            if not inner:
                raise self.refuse(child, "a class of defaults inside another needs a name")
            self._define(child, inner, table)

    def _attributes(self, element: Element, kind: str, defaults: Mapping[str, str]) -> Given:
        """Return an element's attributes over its defaults; refuse what is not read."""
        self.count(element)
        known = _READ[kind].replace("|", " ").split()
        for name in element.attributes:
            if name not in known:
                raise self.refuse(element, f"{name}=… of <{element.tag}> is not read")
        inherited = {name: text for name, text in defaults.items() if name in known}
        return Given(self, element, _overlay(inherited, element.attributes))

    def _defaults(self, element: Element, kind: str, inherited: str = "main") -> dict[str, str]:
        """Return what an element's class of defaults says of its kind."""
        name = element.attributes.get("class", inherited)
        classes = self._models[element.model].classes
        if name not in classes:
            raise self.refuse(element, f"there is no class of defaults {name!r}")
        return classes[name].get(kind, {})

    def _resolve(self, element: Element, kind: str, inherited: str) -> Given:
        return self._attributes(element, kind, self._defaults(element, element.tag, inherited))

    # numbers

    def _claim(self, texts: Given) -> None:
        """Refuse an element with the name of another of its kind."""
        kind, name = texts.element.tag.removeprefix("free"), texts.get("name")
        if name and (kind, name) in self._claimed:
            raise texts.refuse(f"another {kind} is named {name!r}, too")
        self._claimed.add((kind, name or ""))

    def _pose(self, texts: Given) -> Array:
        if "fromto" in texts:
            ends = texts.numbers("fromto", (0,) * 6).reshape(2, 3)
            return pose_at(ends.mean(axis=0), turn_from_z(ends[0] - ends[1]))
        turn = self._turn(texts)
        return pose_at(texts.numbers("pos", (0, 0, 0)), turn)

    def _turn(self, texts: Given) -> Array:
        """The rotation matrix of an orientation in any of MuJoCo's five forms."""
        unit = self._degree(texts.element)
        given = [name for name in _ORIENTATIONS if name in texts]
        if len(given) > 1:
            raise texts.refuse(f"expected one orientation, got {' and '.join(given)}")
        match given:
            case ["quat"]:
                return turn_of(texts.aim("quat", texts.numbers("quat", (1, 0, 0, 0))))
            case ["axisangle"]:
                *axis, angle = texts.numbers("axisangle", (0,) * 4)
                return turn_about(texts.aim("axisangle", np.array(axis)), angle * unit)
            case ["xyaxes"]:
                axes = texts.numbers("xyaxes", (0,) * 6)
                x_axis = texts.aim("xyaxes", axes[:3])
                y_axis = texts.aim("xyaxes", axes[3:] - (axes[3:] @ x_axis) * x_axis)
                return np.column_stack([x_axis, y_axis, np.cross(x_axis, y_axis)])
            case ["zaxis"]:
                return turn_from_z(texts.aim("zaxis", texts.numbers("zaxis", (0, 0, 1))))
            case ["euler"]:
                angles = texts.numbers("euler", (0, 0, 0)) * unit
                turn, sequence = np.eye(3), self._set_in(texts.element).get("eulerseq", "xyz")
                for letter, angle in zip(sequence, angles, strict=True):
                    step = turn_about(np.eye(3)["xyz".index(letter.lower())], angle)
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
            yield from self._contents(child, inner, pose @ self._pose(texts))

    def _fill(
        self, element: Element, link: _Link, inherited: str, shift: Array, place: Array
    ) -> None:
        """Read what stands in a body into its link, then the bodies inside."""
        parts: list[Mass] = []
        inside: list[tuple[Element, str, Array]] = []
        contents = [*self._contents(element, inherited, shift)]
        stated = [
            self._inertial(child).move(frame)
            for child, _, frame in contents
            if child.tag == "inertial"
        ]
        if len(stated) > 1:
            raise self.refuse(element, "expected one <inertial> in a body")
        rule = self._set_in(element).get("inertiafromgeom", "auto")
        by_geoms = link.name != GROUND and (rule == "true" or (rule == "auto" and not stated))
        for child, name, frame in contents:
            match child.tag:
                case "body":
                    inside.append((child, name, frame))
                case "geom":
                    texts = self._resolve(child, "geom", name)
                    part = self._geom(texts, frame, link, by_geoms)
                    if part is not None:
                        parts.append(part)
                case "site":
                    there = _overlay(self._defaults(child, "site", name), child.attributes)
                    if there.get("name"):
                        pose = self._pose(Given(self, child, there))
                        self._sites[there["name"]] = (link.name, frame @ pose)
                case "joint" | "freejoint" | "inertial":  # of the link itself
                    if link.name == GROUND:
                        raise self.refuse(child, f"the world has no <{child.tag}>")
                case "camera" | "light":
                    self.omitted["cameras and lights"] += 1
                case _:
                    raise self.refuse(child, f"<{child.tag}> is not read")
        if link.name != GROUND:
            # without geoms MuJoCo takes what is stated; without that, too, it adds to the body's
            # place that place once more, where the least mass then stands
            nothing = replace(no_mass(), center=place).move(shift)
            mass = sum_masses(parts) if parts else [nothing, *stated][-1]
            link.mass = self._limit(mass, self._set_in(element))
        if link.name in self._aligned and not inside:
            self._align(link)
        for child, name, frame in inside:
            self._body(child, link, name, frame)

    def _align(self, link: _Link) -> None:
        """Let the frame of a free body be that of its inertia, in which anchors then are, too."""
        axes = link.mass.axes
        axes = principal_axes(link.mass.inertia) if axes is None else axes
        place = pose_at(link.mass.center, axes)
        back = np.asarray(np.linalg.inv(place))
        link.mass, link.home = link.mass.move(back), link.home @ place
        for visual in link.visuals:
            stands = placement_at(back @ pose_of(visual.placement))
            link.visuals = [*link.visuals[1:], replace(visual, placement=stands)]
        for name, (body, pose) in self._sites.items():
            if body == link.name:
                self._sites[name] = body, back @ pose

    def _body(self, element: Element, parent: _Link, inherited: str, frame: Array) -> None:
        texts = self._attributes(element, "body", {})
        self._claim(texts)
        name = self._bodies.free(texts.get("name") or "body")
        inherited = texts.get("childclass", inherited)
        pose = frame @ self._pose(texts)
        home = parent.home @ pose
        held = [
            (child, kind, place)
            for child, kind, place in self._contents(element, inherited, np.eye(4))
            if child.tag in ("joint", "freejoint")
        ]
        if texts.get("mocap") == "true":
            self.omitted["motions of mocap bodies"] += 1
            if held or parent.name != GROUND:
                raise self.refuse(element, "a mocap body expects the world around it, and no joint")
        # each joint moves the body's frame about its own anchor; links between are empty
        carrier, origin = parent.name, pose
        shift = np.eye(4)
        for k, (child, kind, place) in enumerate(held):
            last = k == len(held) - 1
            moved = name if last else self._bodies.free(f"{name}_{k + 1}")
            shift = self._joint(child, kind, place, (carrier, moved), origin @ shift)
            if not last:
                self._links.append(_Link(moved, no_mass(), [], shift, home))
            carrier, origin = moved, np.eye(4)
        moving = self.joints[len(self.joints) - len(held) :]
        balls = [k for k, joint in enumerate(moving) if isinstance(joint, Spherical)]
        if balls and any(not isinstance(joint, Prismatic) for joint in moving[balls[0] + 1 :]):
            raise self.refuse(element, "after a ball joint, a body's other joints expect to slide")
        if sum(len(joint.velocities) for joint in moving) > 6:
            raise self.refuse(element, "the joints of a body expect 6 velocities at most")
        if not held:
            weld = self._names.free(f"{name}_weld")
            self.joints.append(Fixed(weld, parent.name, name, origin=placement_at(pose)))
        link = _Link(name, no_mass(), [], shift, home @ np.linalg.inv(shift))
        link.lift = texts.number("gravcomp", 0.0)
        self._links.append(link)
        self._fill(element, link, inherited, shift, (np.linalg.inv(parent.shift) @ pose)[:3, 3])

    def _joint(
        self, element: Element, inherited: str, frame: Array, ends: tuple[str, str], pose: Array
    ) -> Array:
        """Add a joint, and return the pose of the body's frame in that of the joint's child."""
        parent, child = ends
        kind = "freejoint" if element.tag == "freejoint" else "joint"
        texts = self._resolve(element, kind, inherited)
        self._claim(texts)
        form = "free" if kind == "freejoint" else texts.get("type", "hinge")
        name = self._names.free(texts.get("name") or f"{child}_{form}")
        armature = texts.number("armature", 0.0)
        stiffness, damping = self._resistance(texts)
        timing = texts.numbers("springdamper", (0, 0))
        if any(timing) and not all(timing > 0):
            raise texts.refuse("expected positive numbers for springdamper")
        if texts.number("frictionloss", 0.0):
            self.rubbing.append(name)
        if texts.get("actuatorgravcomp") == "true":
            self._drives_lift = True
        if form in ("free", "ball"):
            if all(timing > 0):
                raise self.refuse(element, f"springdamper of a {form} joint is not read")
            turns = any(not isinstance(way, Fixed | Prismatic) for way in self._way_to(parent))
            self._turning[name] = element, stiffness, armature if turns else 0.0
            self._rotors[child] = 0.0 if turns else armature
            self._carried_along[child] = armature if form == "free" else 0.0
            if form == "free" and parent != GROUND:
                raise self.refuse(element, "a free joint expects a body of the world")
            align = texts.get("align", "auto")
            align = self._set_in(element).get("alignfree", "false") if align == "auto" else align
            if form == "free" and align == "true":
                self._aligned.add(child)
        at = pose_at((frame @ [*texts.numbers("pos", (0, 0, 0)), 1.0])[:3])
        if form in ("free", "ball"):
            at = np.eye(4) if form == "free" else at
            ball = Spherical(name, parent, child, origin=placement_at(pose @ at))
            joint = Floating(name, parent, child) if form == "free" else ball
            self.joints.append(joint)
            self.forces += resist_rates(joint, damping.tolist())
            return np.asarray(np.linalg.inv(at))
        if form not in ("hinge", "slide"):
            message = f"expected a joint of type hinge, slide, ball or free, got {form!r}"
            raise self.refuse(element, message)
        axis = texts.aim("axis", frame[:3, :3] @ texts.numbers("axis", (0, 0, 1)))
        unit = self._degree(element) if form == "hinge" else 1.0
        reference = unit * texts.number("ref", 0.0)
        rest = unit * texts.number("springref", 0.0)
        # the text shows the body where the coordinate is its reference
        back = pose_along(axis, -reference, form == "hinge")
        x, y, z = axis.tolist()
        stated: dict[str, Any] = {"axis": (x, y, z), "limits": self._limits(texts, unit)}
        stated |= {"armature": armature, "origin": placement_at(pose @ at @ back)}
        make = Revolute if form == "hinge" else Prismatic
        self.joints.append(make(name, parent, child, **stated))
        self._references[name] = reference
        self._rests[name] = rest
        if all(timing > 0):
            self._timed[name] = timing, stiffness, damping
        else:
            self.resist(name, name, stiffness, np.full(2, rest), damping)
        return np.asarray(np.linalg.inv(at))

    def _resistance(self, texts: Given) -> tuple[Array, Array]:
        """Stiffness and damping of an element, each of three powers, as far as MuJoCo has them."""
        stiffness, damping = (
            texts.numbers(what, (0, 0, 0), least=1) for what in ("stiffness", "damping")
        )
        return stiffness * self._options.has("spring"), damping * self._options.has("damper")

    def _time_springs(self, bodies: Sequence[Body]) -> None:
        """Add springs and dampers that the inertia in the position of the text determines.

        It is that of the joint while all others are free, 1/(M⁻¹)ₖₖ.
        """
        if not self._timed:
            return
        from mecanique.derivation.numeric.recursion import Recursion

        laws = {name: self.laws[name][1] for name in self._lengths}
        forces, self.forces = self.forces, []  # the inertia depends on none
        tree = self.assemble("tree", bodies, (), laws)
        self.forces = forces
        letters = {k.name: k.coordinates[0] for k in tree.joints if k.name in self._references}
        at = {letter: self._references[name] for name, letter in letters.items()}
        (M,) = Recursion(tree).mass_matrix(States.of(tree, at))
        inertia = 1 / np.diag(np.linalg.inv(M))
        for joint, ((constant, ratio), stiffness, damping) in self._timed.items():
            effective = inertia[tree.velocities.index(f"{letters[joint]}'")]
            stiffness[0] = self._options.has("spring") * effective / (constant * ratio) ** 2
            damping[0] = self._options.has("damper") * 2 * effective / constant
            self.resist(joint, joint, stiffness, np.full(2, self._rests[joint]), damping)

    def _limits(self, texts: Given, unit: float) -> Limits | None:
        """The bounds of a joint's position, and of its effort where both signs have the same."""
        bounds = {}
        for name, flag, scale in (
            ("range", "limited", unit),
            ("actuatorfrcrange", "actuatorfrclimited", 1.0),
        ):
            limited = texts.get(flag, "auto")
            low, high = (scale * texts.numbers(name, (0, 0))).tolist()
            if limited == "true" and low >= high:
                raise texts.refuse(f"{flag} is true, so {name} expects a lower and an upper bound")
            if limited == "auto" and low < high:
                limited = self._set_in(texts.element).get("autolimits", "true")
                if limited == "false":
                    raise texts.refuse(f"autolimits is false, so {name} expects {flag} beside it")
            if limited == "true":
                bounds[name] = low, high
        lower, upper = bounds.get("range", (-math.inf, math.inf))
        least, effort = bounds.get("actuatorfrcrange", (-math.inf, math.inf))
        if least != -effort:
            self.omitted["limits of effort with one sign"] += 1
            effort = math.inf
        whole = Limits(lower, upper, effort=effort)
        return whole if whole != Limits() else None

    def _immerse(self, option: Element, follows: Mapping[str, Scalar]) -> None:
        """Add the forces of the medium on the boxes that have the inertia of the bodies.

        MuJoCo documentation, "Fluid forces", inertia model.
        """
        from sympy import Abs, Float

        def size_of(x: Scalar) -> Scalar:
            # to be simplified, it would be written over one denominator
            return abs(x) if isinstance(x, (float, Float)) else Abs(x, evaluate=False)

        s, moving = self._options, self._flows(option, follows)
        for link in self._links:
            mass = link.mass
            if link.name not in moving or mass.mass < _NO_MASS:
                continue
            flow = moving[link.name]
            axes = principal_axes(mass.inertia) if mass.axes is None else mass.axes
            moments = np.diagonal(axes.T @ mass.inertia @ axes)
            box = np.sqrt(6 * np.maximum(moments.sum() - 2 * moments, _NO_MASS) / mass.mass)
            size, faces = box.mean(), box.prod() / box
            paddles = box * ((box**4).sum() - box**4) / 64
            slide = axes.T @ (flow.velocity + np.cross(flow.spin, mass.center) - flow.wind)
            spin = axes.T @ flow.spin
            force = -3 * math.pi * size * s.viscosity * slide
            force = axes @ (force - 0.5 * s.density * faces * [*map(size_of, slide)] * slide)
            torque = -math.pi * size**3 * s.viscosity * spin
            torque = axes @ (torque - s.density * paddles * [*map(size_of, spin)] * spin)
            x, y, z = mass.center.tolist()
            on = {"body": link.name, "axes": link.name}
            drag = Force(f"{link.name}_drag", point=(x, y, z), force=tuple(force), **on)
            self.forces += [drag, Torque(f"{link.name}_spin_drag", torque=tuple(torque), **on)]

    def _flows(self, option: Element, follows: Mapping[str, Scalar]) -> dict[str, _Flow]:
        """Return how bodies that move do so, and the wind, in their own axes, as expressions."""
        still = np.zeros(3)
        flows = {GROUND: _Flow(still, still, self._options.wind, 0)}
        for joint in self.joints:
            if joint.name in self._lengths:
                continue
            pose, linear, spin = _motion_of(joint, follows)
            flow = flows[joint.parent].move(pose_of(joint.origin) @ pose).add(linear, spin)
            flow = flow._replace(depth=flow.depth + (not isinstance(joint, Fixed)))
            flows[joint.child] = flow
            self._refuse_long(option, f"forces of a medium on {joint.child!r}", *flow[:2])
        return {name: flow for name, flow in flows.items() if flow.depth}

    # masses

    def _inertial(self, element: Element) -> Mass:
        texts = self._attributes(element, "inertial", {})
        for name in ("pos", "mass"):
            if name not in texts:
                raise self.refuse(element, f"<inertial> has no {name}=…")
        mass = texts.number("mass", 0.0)
        if mass < 0:
            raise texts.refuse("expected no negative mass of <inertial>")
        pose = self._pose(texts)
        if "fullinertia" in texts:
            if also := [name for name in ("diaginertia", *_ORIENTATIONS) if name in texts]:
                raise texts.refuse(f"expected fullinertia without {also[0]}")
            entries = texts.numbers("fullinertia", (0,) * 6).tolist()
            return Mass(mass, np.zeros(3), tensor_of(entries)).move(pose)
        moments = texts.numbers("diaginertia", (0, 0, 0))
        return Mass(mass, np.zeros(3), np.diag(moments), np.eye(3)).move(pose)

    def _geom(self, texts: Given, frame: Array, link: _Link, counts: bool) -> Mass | None:
        """Note how a geom looks, and return its mass if it counts."""
        form = texts.get("type", "mesh" if "mesh" in texts else "sphere")
        form = "mesh" if form == "sdf" and "mesh" in texts else form
        if texts.number("contype", 1) or texts.number("conaffinity", 1):
            self.omitted["contacts of geoms"] += 1
            self.omitted["pulls of contacts"] += "adhesion" in texts
        model = self._models[texts.element.model]
        low, high = self._set_in(texts.element).numbers("inertiagrouprange", (0, 5))
        counts = counts and low <= texts.number("group", 0) <= high
        mass = texts.number("mass", -1.0) if "mass" in texts else None
        density = texts.number("density", 1000.0)
        if counts and (density if mass is None else mass) < 0:
            raise texts.refuse("expected no negative mass or density of <geom>")
        if mass == 0 or (mass is None and density == 0):
            counts = False
        option = self._options
        medium = option.passive and (option.density or option.viscosity)
        if medium and texts.get("fluidshape", "none") != "none":
            raise texts.refuse("fluidshape=… of <geom> is not read")
        shell = texts.get("shellinertia") == "true"
        if "mesh" in texts and form in {*SIZES, "mesh"}:
            return self._mesh_geom(texts, form, frame, link, counts)
        size = texts.numbers("size", (0, 0, 0), least=1)
        drawn = form
        if form == "hfield" and texts.get("hfield") in model.fields:
            form, size = "box", model.fields[texts["hfield"]]
        if form not in SIZES:
            if counts and form != "plane":
                raise texts.refuse(f"the inertia of a geom of type {form!r} is not read")
            if any(not isinstance(joint, Fixed) for joint in self._way_to(link.name)):
                raise texts.refuse(f"a geom of type {form!r} expects a body that does not move")
            return None
        if "fromto" in texts:
            if form == "sphere":
                raise texts.refuse("a sphere has no fromto")
            ends = texts.numbers("fromto", (0,) * 6)
            half = [np.linalg.norm(ends[:3] - ends[3:]) / 2, 0.0]
            size = np.array([size[0], *(half if SIZES[form] == 2 else [size[0], half[0]])])
        if not all(size[: SIZES[form]] > 0):
            raise texts.refuse(f"expected {SIZES[form]} positive sizes of a {form}")
        place = frame @ self._pose(texts)
        rgba = tuple(texts.numbers("rgba", (0.5, 0.5, 0.5, 1)).tolist())
        link.visuals += draw(drawn, size, place, rgba)
        if not counts:
            return None
        volume, radii = shell_of(form, size) if shell else solid_of(form, size)
        total = density * volume if mass is None else mass
        return Mass(total, np.zeros(3), np.diag(total * radii), np.eye(3)).move(place)

    def _mesh_geom(
        self, texts: Given, form: str, frame: Array, link: _Link, counts: bool
    ) -> Mass | None:
        """Note how the geom of a mesh looks, and return its mass if it counts."""
        known = self._models[texts.element.model].meshes.get(texts["mesh"])
        place = frame @ self._pose(texts)
        if known is None and counts:
            raise texts.refuse(f"there is no mesh {texts['mesh']!r} among the assets")
        if known is not None and (counts or form == "mesh"):
            link.visuals += self._show(known, place)
        if known is None or not counts:
            return None
        if form == "mesh" and texts.get("shellinertia") == "true":
            raise texts.refuse("a mesh says whether it is a shell among the assets")
        solid = self._measure(texts["mesh"], known)
        volume, center, moments = solid.mass, solid.center, solid.inertia / solid.mass
        if form != "mesh":
            volume, center, moments = self._fit(texts, form, known, solid)
        total = texts.number("density", 1000.0) * volume
        total = texts.number("mass", total)
        return Mass(total, center, total * moments, solid.axes).move(place)

    def _fit(self, texts: Given, form: str, mesh: Given, solid: Mass) -> tuple[float, Array, Array]:
        """Volume, center and inertia by mass of a geom that takes the place of a mesh."""
        axes, about = solid.axes, np.zeros(3)
        assert axes is not None, "meshes have principal axes, the largest moment first"
        moments = np.diagonal(axes.T @ solid.inertia @ axes) / solid.mass
        alike = moments[:-1] - moments[1:] <= _ROUND * moments[0]
        a, b, c = np.sqrt(6 * np.maximum(moments.sum() - 2 * moments, 0)) / 2
        ball, wide, cap = (a + b + c) / 3, (a + b) / 2, (a + b) / 4
        if by_box := self._set_in(texts.element).get("fitaabb") == "true":
            corners = (self._corners(mesh) - solid.center) @ axes
            low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
            about, (a, b, c) = (low + high) / 2, (high - low) / 2
            ball, wide, cap = max(a, b, c), max(a, b), max(a, b)
        sizes = {
            "sphere": (ball, 0.0, 0.0),
            "capsule": (wide, c - cap, 0.0),
            "cylinder": (wide, c, 0.0),
        }
        settles = alike.any() if by_box else alike[1] and form in ("capsule", "cylinder")
        if settles and not np.isin(np.abs(axes), (0, 1)).all():
            raise texts.refuse(f"the axis of a {form} fitted to a mesh as wide as long is not read")
        size = np.array(sizes.get(form, (a, b, c))) * texts.number("fitscale", 1.0)
        if not all(size[: SIZES[form]] > 0):
            raise texts.refuse(f"a {form} fitted to a mesh that is wider than long has no length")
        shell = texts.get("shellinertia") == "true"
        volume, radii = shell_of(form, size) if shell else solid_of(form, size)
        return volume, solid.center + axes @ about, axes @ np.diag(radii) @ axes.T

    # meshes

    def _note_asset(self, element: Element) -> None:
        model = self._models[element.model]
        if element.tag == "hfield":
            a, b, top, base = Given(self, element, element.attributes).numbers("size", (0,) * 4)
            name = element.attributes.get("name") or Path(element.attributes.get("file", "")).stem
            model.fields[name] = np.array([a, b, top / 4 + base / 2])  # as MuJoCo weighs it
        if element.tag == "mesh":
            texts = _overlay(self._defaults(element, "mesh"), element.attributes)
            name = texts.get("name") or Path(texts.get("file", "")).stem
            model.meshes[name] = Given(self, element, texts)

    def _file_of(self, texts: Given) -> Path:
        name = Path(texts["file"].replace("\\", "/"))
        stated = self._set_in(texts.element)
        name = Path(name.name) if stated.get("strippath") == "true" else name
        folder = stated.get("meshdir", stated.get("assetdir", ""))
        return self._beside(texts.element, name, folder)

    def _show(self, texts: Given, place: Array) -> Iterator[Visual]:
        """Yield what a page shows of a mesh, if it is a file that stands as it is."""
        if "file" in texts and not {"refpos", "refquat"} & texts.keys():
            path, (x, y, z) = self._file_of(texts), texts.numbers("scale", (1, 1, 1)).tolist()
            if path.suffix.lower() in (".stl", ".obj") and path.is_file():
                yield Visual(Mesh(texts["file"], path, (x, y, z)), placement_at(place))

    def _measure(self, name: str, texts: Given) -> Mass:
        """Return the volume and inertia of a mesh of the assets."""
        solids = self._models[texts.element.model].solids
        if name in solids:
            return solids[name]
        self._attributes(texts.element, "mesh", {})
        rule = texts.get("inertia", "legacy")
        if rule not in RULES:
            raise texts.refuse(f"inertia={rule!r} of <mesh> is not read")
        drawn = "file" in texts or "face" in texts
        if "maxhullvert" in texts and (rule == "convex" or not drawn):
            raise texts.refuse("the inertia of a hull with maxhullvert=… is not read")
        for child in texts.element.children:
            raise self.refuse(child, f"<{child.tag}> in <mesh> is not read")
        try:
            solids[name] = mesh_of(self._corners(texts), RULES[rule])
        except InputError as error:
            place = texts.refuse("")
            if str(error).startswith(str(place)):
                raise
            raise texts.refuse(f"mesh {name!r}: {error}") from None
        return solids[name]

    def _corners(self, texts: Given) -> Corners:
        """Return the triangles of a mesh of the assets, turned and scaled as it says."""
        drawn = read_solid(self._file_of(texts)) if "file" in texts else self._list_corners(texts)
        corners = drawn - texts.numbers("refpos", (0, 0, 0))
        scale = texts.numbers("scale", (1, 1, 1))
        corners = corners @ turn_of(texts.numbers("refquat", (1, 0, 0, 0))) * scale
        return corners if np.prod(scale) >= 0 else corners[:, ::-1]

    def _list_corners(self, texts: Given) -> Corners:
        """Return the triangles that a mesh lists itself."""
        lists = {}
        for name in ("vertex", "face"):
            wanted = f"expected triples of numbers for {name} of <mesh>"
            values = self.split(texts.element, texts.get(name, ""), wanted)
            if len(values) % 3:
                raise texts.refuse(f"{wanted}, got {len(values)} numbers")
            lists[name] = np.array(values).reshape(-1, 3)
        points = lists["vertex"].astype(np.float32).astype(float)
        return faces_of(points, lists["face"].astype(np.int64))

    def _limit(self, mass: Mass, stated: Given) -> Mass:
        """Raise a mass and its principal moments to the least that <compiler> allows."""
        total = max(mass.mass, stated.number("boundmass", 0.0))
        least = stated.number("boundinertia", 0.0)
        balance = stated.get("balanceinertia") == "true"
        if not (least or balance):
            return replace(mass, mass=total)
        axes = principal_axes(mass.inertia) if mass.axes is None else mass.axes
        moments = np.maximum(np.diagonal(axes.T @ mass.inertia @ axes), least)
        if balance and 2 * moments.max() > moments.sum():
            moments = np.full(3, moments.mean())
        return Mass(total, mass.center, axes @ np.diag(moments) @ axes.T, axes)

    # what is left

    def _spring_balls(self) -> None:
        """Add springs and rotors of ball and free joints: by joints that follow their quaternions.

        A spring resists the angle from home, by the shorter way; |ω|² is 4 |p'|² of a quaternion p.
        """
        from sympy import Abs, atan, sqrt

        from mecanique.derivation.tree.poses import quaternion_product

        for joint in [joint for joint in self.joints if joint.name in self._turning]:
            element, stiffness, armature = self._turning[joint.name]
            for name in joint.quaternion if armature else ():
                self._trail(element, f"{name}_rotor", coordinate(name), 4 * armature)
            if not any(stiffness):
                continue
            home = self._home_of(joint)
            if isinstance(joint, Floating):
                way = sqrt(((np.array(position()) - home[:3]) ** 2).sum())
                V = sum(k * way ** (n + 2) / (n + 2) for n, k in enumerate(stiffness.tolist()) if k)
                self.forces.append(PotentialField(f"{joint.name}_pull", joint.child, (0.0,) * 3, V))
            p = [coordinate(name) for name in joint.quaternion]
            *sines, cosine = quaternion_product(conjugate(home[-4:]).tolist(), p)
            sine = sqrt(sum(part**2 for part in sines) + _NO_TURN**2)
            angle = self._trail(element, f"{joint.name}_angle", 2 * atan(sine / Abs(cosine)))
            self.resist(joint.name, angle, stiffness, np.zeros(2), np.zeros(3))

    def _home_of(self, joint: Joint) -> Array:
        """The coordinates of a ball or free joint where the text shows its body."""
        homes = {link.name: link.home for link in self._links}
        home = homes[joint.child] if isinstance(joint, Floating) else np.eye(4)
        return np.array([*home[:3, 3], *from_matrices(home[:3, :3])])[-joint.nq :]

    def _trail(self, element: Element, name: str, law: Scalar, armature: float = 0.0) -> str:
        """Add a joint that moves nothing and follows a law; return its name."""
        name = self._names.free(name)
        self._lengths[name] = self._bodies.free(name)
        self.joints.append(Prismatic(name, GROUND, self._lengths[name], armature=armature))
        self.follow(element, name, law)
        return name

    def _pull_tendons(self, root: Element) -> None:
        """Read the tendons, and the springs and dampers along them."""
        names = Names()
        for element in (child for part in root.all("tendon") for child in part.children):
            texts = self._attributes(element, "tendon", self._defaults(element, "tendon"))
            tendon = _Tendon(element, names.free(texts.get("name") or "tendon"))
            self._tendons[tendon.name] = tendon
            if element.tag == "fixed":
                tendon.factors |= self._factors_of(element)
            armature = texts.number("armature", 0.0)
            stiffness, damping = self._resistance(texts)
            ends = texts.numbers("springlength", (-1, -1), least=1)
            if len(texts.get("springlength", "").split()) == 1:
                ends[1] = ends[0]
            if not (armature or any(stiffness) or any(damping)):
                continue
            if element.tag != "fixed":
                tendon.spans += self._spans_of(element)
            if not (tendon.factors or tendon.spans):
                continue
            if (ends == -1).all():
                ends[:] = self._rest_length(tendon)
            simple = not armature and not any(stiffness[1:]) and not any(damping[1:])
            if simple and len(tendon.spans) == 1 and tendon.spans[0][2] == 1:
                self._stretch(tendon, float(stiffness[0]), ends, float(damping[0]))
                continue
            self._load(tendon, armature)
            if any(stiffness) or any(damping):
                joint, factor = self._measure_along(tendon)
                self.resist(tendon.name, joint, stiffness, ends, damping, factor)

    def _factors_of(self, element: Element) -> dict[str, float]:
        factors: dict[str, float] = {}
        for child in element.all("joint"):
            joint = child.attributes.get("joint", "")
            if joint not in self._references:
                raise self.refuse(child, f"{joint!r} is no hinge or slide")
            if factor := Given(self, child, child.attributes).number("coef", 0.0):
                factors[joint] = factors.get(joint, 0.0) + factor
        return factors

    def _spans_of(self, element: Element) -> list[tuple[_Site, _Site, float]]:
        """Return the straight parts of a tendon; a pulley begins a branch that counts less."""
        spans: list[tuple[_Site, _Site, float]] = []
        before, share = None, 1.0
        for child in element.children:
            if child.tag == "pulley":
                before = None
                share = 1 / Given(self, child, child.attributes).number("divisor", 1.0)
                continue
            if child.tag != "site":
                raise self.refuse(child, f"a tendon around a <{child.tag}> is not read")
            site = self._sites.get(child.attributes.get("site", ""))
            if site is None:
                raise self.refuse(child, f"<{element.tag}> names a site that is not there")
            if before is not None:
                spans.append((before, site, share))
            before = site
        return spans

    def _length(self, tendon: _Tendon) -> Scalar:
        """The length of a tendon in letters."""
        from sympy import sqrt

        length = tendon.along({joint: coordinate(joint) for joint in tendon.factors})
        for (a, at_a), (b, at_b), share in tendon.spans:
            ways = [self._way_to(body) for body in (a, b)]
            shared = sum(1 for pair in zip(*ways, strict=False) if pair[0] is pair[1])
            ends = []
            for way, site in zip(ways, (at_a, at_b), strict=True):
                end = site[:, 3]
                for joint in reversed(way[shared:]):
                    end = pose_of(joint.origin) @ _motion_of(joint, {})[0] @ end
                ends.append(end[:3])
            length = length + share * sqrt(sum((ends[1] - ends[0]) ** 2))
        what = f"armature, branches and powers of tendon {tendon.name!r}"
        self._refuse_long(tendon.element, what, [length])
        return length

    def _refuse_long(self, element: Element, what: str, *vectors: Iterable[Scalar]) -> None:
        """Refuse what takes minutes to compute with."""
        from sympy import count_ops

        if sum(int(count_ops(part)) for vector in vectors for part in vector) > _MOST_OPERATIONS:
            raise self.refuse(element, f"{what}, over so many joints, are not read")

    def _rest_length(self, tendon: _Tendon) -> float:
        """The length of a tendon where the springs in joints are at rest."""
        if tendon.spans and self._rests != self._references:
            rests = dict(self._rests)
            for joint in self.joints:
                if joint.quaternion:
                    rests |= zip(joint.coordinates, self._home_of(joint).tolist(), strict=True)
            return float(evaluate(self._length(tendon), rests))
        homes = {link.name: link.home for link in self._links}
        length = float(tendon.along(self._rests))
        for (a, at_a), (b, at_b), share in tendon.spans:
            length += share * float(np.linalg.norm((homes[b] @ at_b - homes[a] @ at_a)[:3, 3]))
        return length

    def _way_to(self, body: str) -> list[Joint]:
        """The joints from the world to a body."""
        carriers = {joint.child: joint for joint in self.joints}
        way: list[Joint] = []
        while body in carriers:
            way.insert(0, carriers[body])
            body = carriers[body].parent
        return way

    def _measure_along(self, tendon: _Tendon) -> tuple[str, float]:
        """Return the joint of a tendon's length and a factor; if there is none, one follows."""
        if not tendon.joint and len(tendon.factors) == 1:
            ((tendon.joint, tendon.factor),) = tendon.factors.items()
        elif not tendon.joint:
            law = self._length(tendon)
            tendon.joint = self._trail(tendon.element, f"{tendon.name}{LENGTH}", law)
        return tendon.joint, tendon.factor

    def _load(self, tendon: _Tendon, armature: float) -> None:
        """Add the armature of a tendon.

        MuJoCo's mass matrix has entries for joints alone of which one carries the other, so a
        tendon along separate chains of joints counts as one along each.
        """
        if not armature:
            return
        if not tendon.inertial:
            chains = self._split_in_chains(tendon)
            if len(chains) <= 1:
                tendon.inertial = [self._measure_along(tendon)]
            else:
                self.omitted["armature of tendons that couples joints on separate branches"] += 1
                for joints in chains:
                    factors = {joint: tendon.factors[joint] for joint in joints}
                    part = _Tendon(tendon.element, f"{tendon.name}_{joints[0]}", factors)
                    tendon.inertial.append(self._measure_along(part))
        for joint, factor in tendon.inertial:
            self._add_armature(joint, factor**2 * armature)

    def _split_in_chains(self, tendon: _Tendon) -> list[tuple[str, ...]]:
        """Return the joints that move a tendon, those together of which one carries another."""
        ways = {joint.name: self._way_to(joint.child) for joint in self.joints}
        joints = {name: ways[name][-1] for name in tendon.factors}
        for (a, _), (b, _), _ in tendon.spans:
            ends = self._way_to(a), self._way_to(b)
            moved = (j for way, other in (ends, ends[::-1]) for j in way if j not in other)
            joints |= {joint.name: joint for joint in moved if joint.velocities}
        chains: dict[tuple[str, ...], None] = {}
        for name, joint in joints.items():
            related = (k for k in joints if joint in ways[k] or joints[k] in ways[name])
            chains[tuple(related)] = None
        apart = sum(map(len, chains)) == len(joints)
        if len(chains) <= 1 or (apart and not tendon.spans):
            return [*chains]
        what = f"armature of tendon {tendon.name!r}, of which MuJoCo drops what couples branches"
        raise self.refuse(tendon.element, f"{what}, is not read")

    def _add_armature(self, name: str, armature: float) -> None:
        (place,) = (k for k, joint in enumerate(self.joints) if joint.name == name)
        joint = self.joints[place]
        assert isinstance(joint, Single), "rotors turn with hinges and slides"
        self.joints[place] = replace(joint, armature=joint.armature + armature)

    def _stretch(self, tendon: _Tendon, stiffness: float, ends: Array, damping: float) -> None:
        """Add a spring and a damper between the two sites of a straight tendon."""
        (((a, at_a), (b, at_b), _),), name = tendon.spans, tendon.name
        low, high = ends.tolist()
        points = (a, tuple(at_a[:3, 3].tolist()), b, tuple(at_b[:3, 3].tolist()))
        if stiffness and low == high:
            self.forces.append(Spring(f"{name}_spring", *points, stiffness, low))
        elif stiffness:
            V = stiffness * beyond(coordinate(DISTANCE), low, high) ** 2 / 2
            self.forces.append(CentralForce(f"{name}_spring", *points, V))
        if damping:
            self.forces.append(Damper(f"{name}_damper", *points, damping))

    def _add_drives(self, root: Element) -> None:
        """Add the rotor inertia and the damping of actuators at the joints they drive."""
        for element in (child for part in root.all("actuator") for child in part.children):
            texts = Given(
                self, element, _overlay(self._defaults(element, _DRIVE), element.attributes)
            )
            armature = texts.number("armature", 0.0)
            damping = self._resistance(texts)[1]
            if not armature and not any(damping):
                continue
            name, factor = texts.get("joint", texts.get("jointinparent", "")), 1.0
            gears = self.split(element, texts.get("gear", "1"), "expected numbers for gear")
            square = gears[0] ** 2 if gears else 1.0  # which MuJoCo takes for powers of v as well
            if (tendon := self._tendons.get(texts.get("tendon", ""))) is not None:
                if tendon.element.tag != "fixed" and not tendon.spans:
                    tendon.spans += self._spans_of(tendon.element)
                self._load(tendon, square * armature)
                if any(damping):
                    name, factor = self._measure_along(tendon)
            elif name in self._references:
                self._add_armature(name, square * armature)
            else:
                named = " and ".join(what for what in ("armature", "damping") if what in texts)
                raise self.refuse(element, f"{named} of <{element.tag}> at no hinge or slide")
            none = np.zeros(3)
            self.resist(f"{name}_drive", name, none, none[:2], square * damping, factor)

    def _close(self, root: Element) -> list[Loop]:
        """Return the loops that the equality constraints make, and note which joints follow."""
        loops: list[Loop] = []
        names = Names()
        links = {link.name: link for link in self._links}
        for element in (child for part in root.all("equality") for child in part.children):
            defaults = self._defaults(element, "equality")
            inactive = {**defaults, **element.attributes}.get("active") == "false"
            if inactive or not self._options.has("equality", "constraint"):
                self.omitted["inactive constraints"] += 1
                continue
            if (kind := f"equality.{element.tag}") not in _READ:
                raise self.refuse(element, f"<{element.tag}> among the constraints is not read")
            texts = self._attributes(element, kind, defaults)
            name = names.free(texts.get("name") or element.tag)
            if element.tag in ("joint", "tendon"):
                if self._tied:
                    self._follow(texts)
                continue
            if "site1" in texts:
                ends = [self._sites.get(texts.get(site, "")) for site in ("site1", "site2")]
                if None in ends:
                    raise self.refuse(element, f"<{element.tag}> names a site that is not there")
                (a, at_a), (b, at_b) = (end for end in ends if end is not None)
            else:
                a, b = texts.get("body1", GROUND), texts.get("body2", GROUND)
                if a not in links or b not in links:
                    raise self.refuse(element, f"<{element.tag}> names a body that is not there")
                at_a, at_b = self._meet(texts, links[a], links[b])
            if element.tag == "connect":
                points = (tuple(at_a[:3, 3].tolist()), tuple(at_b[:3, 3].tolist()))
                loops.append(Loop.ball(name, a, points[0], b, points[1]))
            else:
                loops.append(Loop.weld(name, a, placement_at(at_a), b, placement_at(at_b)))
        return loops

    def _meet(self, texts: Given, a: _Link, b: _Link) -> tuple[Array, Array]:
        """The poses in two links of frames that a constraint keeps together."""
        anchor = pose_at(texts.numbers("anchor", (0, 0, 0)))
        if texts.element.tag == "connect":
            at = a.shift @ anchor
            return at, np.linalg.inv(b.home) @ a.home @ at
        numbers = texts.numbers("relpose", (0, 1, 0, 0, 0, 0, 0))
        at = b.shift @ anchor
        if not any(numbers[3:]):  # as the text shows the bodies
            return np.linalg.inv(a.home) @ b.home @ at, at
        relative = pose_at(numbers[:3], turn_of(numbers[3:]))
        return a.shift @ relative, at  # where the anchor of b goes, MuJoCo counts it in

    def _follow(self, texts: Given) -> None:
        """Solve L − L₀ = Σ cₖ (M − M₀)ᵏ of joints, or tendons along joints, for L's last joint."""
        element = texts.element
        sides = []
        for name in filter(None, (texts.get(f"{element.tag}1", "?"), texts.get(f"{element.tag}2"))):
            side = self._tendons.get(name) if element.tag == "tendon" else None
            if element.tag == "joint" and name in self._references:
                side = _Tendon(element, name, {name: 1.0})
            if side is None or not side.factors:
                kind = "hinge or slide" if element.tag == "joint" else "tendon along joints"
                raise self.refuse(element, f"{name!r} is no {kind}")
            sides.append(side)
        factors = texts.numbers("polycoef", (0, 1, 0, 0, 0), least=1).tolist()
        moved = {joint: coordinate(joint) - self._references[joint] for joint in self._references}
        law: Scalar = factors[0]
        for second in sides[1:]:
            x = second.along(moved)
            law = law + sum(c * x**k for k, c in enumerate(factors) if k and c)
        along = sides[0].factors
        free = [joint for joint in along if joint not in self.laws]
        if not free and len(sides) > 1 and factors[1] and not any(factors[2:]):
            # a linear law has an inverse: the second side follows the first
            law = (sides[0].along(moved) - factors[0]) / factors[1]
            along, sides = sides[1].factors, sides[::-1]
            free = [joint for joint in along if joint not in self.laws]
        if not free:
            names = " and ".join(map(repr, along))
            raise self.refuse(element, f"joint {names} is tied by several constraints")
        joint = free[-1]
        law = (law - sides[0].along(moved | {joint: 0.0})) / along[joint]
        self.follow(element, joint, law + self._references[joint])

    def _mechanism(self, root: Element) -> Mechanism:
        s, most = self._options, self._set_in(root).number("settotalmass", -1.0)
        total = sum(link.mass.mass for link in self._links)
        scale = most / total if most > 0 and total > 0 else 1.0
        loops, follows = self._close(root), self.compose_laws()
        if s.passive and (s.density or s.viscosity):
            self._immerse(root.child("option") or root, follows)
        bodies = []
        for link in self._links:
            whole = link.mass = replace(
                link.mass, mass=scale * link.mass.mass, inertia=scale * link.mass.inertia, axes=None
            )
            # a rotor of a ball resists turning alike about all axes, as a sphere does
            whole = replace(
                whole, inertia=whole.inertia + self._rotors.get(link.name, 0.0) * np.eye(3)
            )
            if load := self._carried_along.get(link.name, 0.0):
                # that of a free joint resists the origin's acceleration as a mass there does
                whole = sum_masses([whole, Mass(load, np.zeros(3), np.zeros((3, 3)))])
            bodies.append(whole.body(link.name, link.visuals))
        bodies += map(Body, self._lengths.values())
        self._time_springs(bodies)
        self.forces = [_in_free_joints(force, follows) for force in self.forces]
        for link in self._links:
            weight = s.passive * link.lift * link.mass.mass
            self.lift(link.name, "gravcomp", link.mass.center, weight)
            if load := self._carried_along.get(link.name, 0.0):  # a mass without weight
                weightless = load * np.dot(self.gravity, position())
                self.forces.append(
                    PotentialField(f"{link.name}_armature", link.name, (0.0,) * 3, weightless)
                )
        if self._drives_lift and any(link.lift for link in self._links):
            self.omitted["bounds of actuators on the compensation of gravity"] += 1
        name = root.attributes.get("model", self.file.stem if self.file else "MuJoCo model")
        return self.assemble(name, bodies, loops, follows)


def _overlay(defaults: Mapping[str, str], given: Mapping[str, str]) -> dict[str, str]:
    """Return attributes over their defaults; one orientation takes the place of another."""
    turned = given.keys() & set(_ORIENTATIONS)
    merged = {k: text for k, text in defaults.items() if not (turned and k in _ORIENTATIONS)}
    for name, text in given.items():
        words = text.split()
        rest = merged.get(name, "").split()[len(words) :] if name in _IN_PARTS else []
        merged[name] = " ".join([*words, *rest]) if rest else text
    return merged


def _in_free_joints(force: AnyForce, follows: Mapping[str, Scalar]) -> AnyForce:
    """Return the force along a tendon in coordinates that follow no others."""
    if not isinstance(force, JointForce) or not follows:
        return force
    law = force.force
    for name in sorted(symbols_in(law)):
        joint = name.removesuffix("'")
        if joint in follows:
            told = follows[joint] if name == joint else _rate_of(follows[joint])
            law = law.subs({coordinate(name): told})
    return replace(force, force=law)


def _rate_of(law: Scalar) -> Scalar:
    """The rate of a law of coordinates."""
    law = plain(law)
    return sum((law.diff(coordinate(k)) * velocity(k) for k in sorted(symbols_in(law))), 0.0)


def _motion_of(joint: Joint, follows: Mapping[str, Scalar]) -> tuple[Array, Array, Array]:
    """The pose that a joint gives, and linear velocity and spin in its axes, in letters."""
    import sympy

    pose, linear, spin = np.eye(4, dtype=object), np.zeros(3), np.zeros(3)
    rates = np.array([coordinate(name) for name in joint.velocities])
    match joint:
        case Revolute() | Prismatic():
            axis = np.array(joint.axis, dtype=float)
            q = follows.get(joint.name, coordinate(joint.name))
            if joint.turns:
                pose[:3, :3], spin = turn_about(axis, q, sympy), _rate_of(q) * axis
            else:
                pose[:3, 3], linear = q * axis, _rate_of(q) * axis
        case Spherical() | Floating():
            x, y, z, w = (coordinate(name) for name in joint.quaternion)
            pose[:3, :3], spin = turn_of_unit(w, x, y, z), rates[-3:]
            if isinstance(joint, Floating):
                pose[:3, 3] = [coordinate(name) for name in joint.linear_coordinates]
                linear = rates[:3]
    return pose, linear, spin


def _refers(element: Element) -> set[str]:
    """The names of others in an element and those inside."""
    texts = (pair for part in element.walk() for pair in part.attributes.items())
    return {text for key, text in texts if key in _REFERENCES}


def _rename(element: Element, prefix: str, suffix: str) -> Element:
    """Return an element with all names inside, and references to others, between these."""
    children = tuple(_rename(child, prefix, suffix) for child in element.children)
    attributes = dict(element.attributes)
    for key in ("name", *_REFERENCES):
        if attributes.get(key, GROUND) != GROUND:
            attributes[key] = f"{prefix}{attributes[key]}{suffix}"
    return replace(element, attributes=attributes, children=children)


_KINDS = {"continuous": "hinge", "revolute": "hinge", "prismatic": "slide", "ball": "ball"}


def write_mjcf(mechanism: Mechanism) -> str:
    """Return a mechanism as MJCF text, without what `mecanique.formats.scope` lists as lost.

    Frames are those of the mechanism; angles are in radians, rpy turns about fixed axes. What has
    symbols is written with their values.
    """
    return write_xml(Tag("mujoco", *_Writer(mechanism).sections(), model=mechanism.name))


@final
class _Writer:
    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        self._steps = chains(mechanism)
        self._bodies = {body.name: body for body in mechanism.bodies}
        self._carried: dict[str, list[Joint]] = {}
        self._lengths = list_lengths(mechanism)
        for joint in mechanism.joints:
            if joint.name in self._lengths:
                continue
            self._carried.setdefault(joint.parent, []).append(joint)
        self._sites: dict[str, list[Tag]] = {}
        shares = ((force, lifted_share(mechanism, force)) for force in mechanism.forces)
        self._lifts = {f.bodies[0]: share for f, share in shares if share is not None}

    def sections(self) -> Iterator[Node]:
        mechanism = self._mechanism
        yield Tag(
            "compiler",
            angle="radian",
            eulerseq="XYZ",
            inertiafromgeom="false",
            autolimits="true",
        )
        gravity = numbers(mechanism.evaluate_all(mechanism.gravity), "gravity")
        yield Tag("option", gravity=gravity)
        tendons = [*self._tendons()]
        equalities = [*self._equalities()]
        yield Tag("worldbody", *self._contents(mechanism.ground))
        if tendons:
            yield Tag("tendon", *tendons)
        if equalities:
            yield Tag("equality", *equalities)

    def _contents(self, body: str) -> Iterator[Node]:
        """Yield the sites of a body, what shows it, and the bodies it carries."""
        yield from self._sites.get(body, ())
        for visual in self._bodies[body].visuals:
            yield from self._geom(visual)
        for joint in self._carried.get(body, ()):
            yield self._body(joint)

    def _body(self, joint: Joint) -> Tag:
        """Return the body of a joint, with those behind it that only empty bodies separate."""
        chain = [joint]
        while (behind := passes_on(self._mechanism, chain[-1])) is not None:
            chain.append(behind)
        joint = chain[-1]
        where = f"joint {joint.name!r}"
        place, joints = chain[0].origin, [*self._joints(joint)]
        if len(chain) > 1:
            # the frame of each joint in that of the body, and of the body in its parent
            pose = np.eye(4)
            for before, after in pairwise(reversed(chain)):
                pose = np.linalg.inv(self._mechanism.matrix(before.origin) @ np.linalg.inv(pose))
                joints = [*self._joints(after, pose), *joints]
            place = placement_at(self._mechanism.matrix(chain[0].origin) @ np.linalg.inv(pose))
        attributes = {"name": joint.child, **self._pose(place, where)}
        if joint.child in self._lifts:
            attributes["gravcomp"] = number(self._lifts[joint.child], where)
        contents = self._contents(joint.child)
        return Tag("body", *self._inertial(joint), *joints, *contents, **attributes)

    def _pose(self, place: Placement, where: str) -> dict[str, str]:
        xyz = self._mechanism.evaluate_all(place.xyz)
        rpy = self._mechanism.evaluate_all(place.rpy)
        pose = {"pos": numbers(xyz, where)}
        if any(rpy):
            pose["euler"] = numbers(rpy, where)
        return pose

    def _inertial(self, joint: Joint) -> Iterator[Tag]:
        """Yield mass and inertia of the body that a joint moves."""
        body = self._bodies[joint.child]
        where = f"body {body.name!r}"
        mass = self._mechanism.evaluate(body.mass)
        entries = self._mechanism.evaluate_all(body.inertia)
        light = is_light(self._mechanism, joint, "MJCF")
        mass = THICKENED if light else mass
        if light or is_thin(self._mechanism, joint):
            entries = [*(moment + THICKENED for moment in entries[:3]), *entries[3:]]
        if mass or any(entries):
            center = numbers(self._mechanism.evaluate_all(body.center), where)
            # a fixed body may have no inertia, but MuJoCo takes zeros on a diagonal alone
            form, count = ("fullinertia", 6) if any(entries[3:]) else ("diaginertia", 3)
            inertia = {form: numbers(entries[:count], where)}
            yield Tag("inertial", pos=center, mass=number(mass, where), **inertia)

    def _geom(self, visual: Visual) -> Iterator[Tag]:
        """Yield a geom that touches nothing and has no mass."""
        form, given = measure(visual.geometry)
        if form == "mesh":
            return
        sizes = self._mechanism.evaluate_all(given)
        if form != "sphere":  # half the edges, and half the length behind the radius
            at = 0 if form == "box" else 1
            sizes[at:] = [size / 2 for size in sizes[at:]]
        if not min(sizes) > 0:
            return
        looks = {} if visual.rgba is None else {"rgba": numbers(visual.rgba, "a color")}
        looks |= self._pose(visual.placement, "a visual")
        free = {"contype": "0", "conaffinity": "0", "group": "2", "mass": "0"}
        yield Tag("geom", type=form, size=numbers(sizes, "a visual"), **free, **looks)

    def _joints(self, joint: Joint, pose: Array | None = None) -> Iterator[Tag]:
        """Yield a joint, whose frame has a pose in that of its body."""
        for step in self._steps[joint.name]:
            if step.kind == "floating":
                yield Tag("freejoint", name=step.name)
            elif step.kind != "fixed":
                yield Tag("joint", **self._moves(joint, step, pose))

    def _moves(self, joint: Joint, step: SimpleJoint, pose: Array | None) -> dict[str, str]:
        where = f"joint {step.name!r}"
        attributes = {"name": step.name, "type": _KINDS[step.kind]}
        if pose is not None:
            attributes["pos"] = numbers(pose[:3, 3].tolist(), where)
        if step.axis is not None:
            axis = step.axis if pose is None else (pose[:3, :3] @ step.axis).tolist()
            attributes["axis"] = numbers(axis, where)
        if step.limits is not None and step.limits.bounded:
            reach = max(step.limits.lower, -1e9), min(step.limits.upper, 1e9)
            attributes["range"] = numbers(reach, where)
        if step.limits is not None and 0 < step.limits.effort < UNBOUNDED:
            effort = step.limits.effort
            attributes["actuatorfrcrange"] = numbers((-effort, effort), where)
        if isinstance(joint, Single) and step.name == joint.name:
            attributes |= self._resistance(joint)
        return attributes

    def _resistance(self, joint: Single, rest: str = "springref") -> dict[str, str]:
        """Return rotor, spring and damper of a joint or tendon."""
        where, attributes = f"joint {joint.name!r}", {}
        armature = self._mechanism.evaluate(joint.armature)
        if armature:
            attributes["armature"] = number(armature, where)
        stiffness, reference = joint_spring(self._mechanism, joint.name)
        if stiffness:
            attributes["stiffness"] = number(stiffness, where)
            attributes[rest] = number(reference, where)
        damping = joint_damping(self._mechanism, joint.name)
        if damping:
            attributes["damping"] = number(damping, where)
        return attributes

    def _site(self, name: str, body: str, pose: Mapping[str, str]) -> None:
        self._sites.setdefault(body, []).append(Tag("site", name=name, **pose))

    def _tendons(self) -> Iterator[Tag]:
        evaluate = self._mechanism.evaluate
        for name, joint in self._lengths.items():
            factors = tendon_factors(self._mechanism, name) or {}
            ways = [Tag("joint", joint=k, coef=number(c, name)) for k, c in factors.items()]
            given = self._resistance(joint, "springlength")
            yield Tag("fixed", *ways, name=name.removesuffix(LENGTH), **given)
        for force in self._mechanism.forces:
            if isinstance(force, Spring | Damper):
                ends = [f"{force.name}_{letter}" for letter in "ab"]
                for site, end in zip(ends, force.ends, strict=True):
                    point = numbers(self._mechanism.evaluate_all(end.point), site)
                    self._site(site, end.body, {"pos": point})
                if isinstance(force, Spring):
                    given = {
                        "stiffness": number(evaluate(force.stiffness), force.name),
                        "springlength": number(evaluate(force.free_length), force.name),
                    }
                else:
                    given = {"damping": number(evaluate(force.damping), force.name)}
                sites = [Tag("site", site=site) for site in ends]
                yield Tag("spatial", *sites, name=force.name, **given)

    def _equalities(self) -> Iterator[Tag]:
        mechanism, scope = self._mechanism, SCOPES["MJCF"]
        for loop in mechanism.loops:
            if scope.loops is not None and loop.kind in scope.loops:
                yield self._closure(loop)
        steps = axial_steps(mechanism)
        for name in (k for k in mechanism.coordinates.driven if k not in self._lengths):
            law = law_of_follower(mechanism, steps, name, scope.degree)
            if law is None:
                continue
            leader, factors = law
            tied = {"joint1": steps[name], "polycoef": numbers(factors, name)}
            yield Tag("joint", **tied, **({"joint2": leader} if leader else {}))

    def _closure(self, loop: Loop) -> Tag:
        sites = {}
        for k, (body, frame) in enumerate(
            ((loop.body_a, loop.frame_a), (loop.body_b, loop.frame_b)), 1
        ):
            sites[f"site{k}"] = f"{loop.name}_{k}"
            self._site(f"{loop.name}_{k}", body, self._pose(frame, f"loop {loop.name!r}"))
        tag = "connect" if loop.kind == "ball" else "weld"
        return Tag(tag, name=loop.name, **sites)
