"""SDF, Gazebo's format, read and written.

Versions 1.3 to 1.12 are read as libsdformat and Drake mean them (sdformat.org, "Specification" and
"Pose frame semantics"); tests compare mass matrix and bias with Drake's. Every link that nothing
joins to the world floats in it. What the dynamics do without (contacts, sensors, plugins, friction)
is listed in `Mechanism.about`; what would change them and is not read is refused by name.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeAlias, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError
from mecanique.formats.scope import (
    SCOPES,
    THICKENED,
    is_closed,
    is_empty,
    joint_damping,
    joint_spring,
    lifted_share,
)
from mecanique.formats.sources import (
    GROUND,
    Given,
    Source,
    draw,
    placement_at,
    refuse_overflow,
    resist_rates,
    turn_of,
    unit_vector,
)
from mecanique.model.bodies import Body
from mecanique.model.bodies.tensor import tensor_of
from mecanique.model.bodies.visuals import Mesh, Visual
from mecanique.model.constraints.loops import Loop
from mecanique.model.expression import coordinate, symbols_in
from mecanique.model.joint_base import Limits, Single
from mecanique.model.joints import (
    Fixed,
    Floating,
    Helical,
    Joint,
    Prismatic,
    Revolute,
    Spherical,
    Universal,
)
from mecanique.model.mechanism import Mechanism
from mecanique.model.placement import Placement, pose_at, pose_of
from mecanique.urdf.dialect import DRAKE_NAMESPACE, UNBOUNDED, WORLD
from mecanique.urdf.markup import Element, Node, Tag, number, numbers, write_xml
from mecanique.urdf.names import Names
from mecanique.urdf.reading.packages import MeshSearch, PackagePath
from mecanique.urdf.solids import Mass, no_mass, solid_of, sum_masses
from mecanique.urdf.write import SimpleJoint, axial_steps, chains, law_of_follower, measure_in_words

_UNBOUNDED = 1e16
"""SDF's word for no limit, and all above it."""

_SLANT = 1e-6
"""How far a quaternion's length may be from one: libsdformat does not correct it."""

_FRAMES = (1, 7)
"""The version since which axes name the frame that they are in, instead of a choice of two."""

_MOST_FRAMES = 500
"""Longest chain of frames stated by one another; all are followed for each link."""

_MOST_DEPTH = 20
"""Deepest nesting of models, so that one which includes itself ends."""

_OMITTED = {
    "actor": "actors",
    "audio": "sounds",
    "audio_sink": "sounds",
    "audio_source": "sounds",
    "battery": "batteries",
    "collision": "collisions",
    "drake:collision_filter_group": "filters of collisions",
    "gripper": "grippers",
    "light": "lights",
    "particle_emitter": "emitters",
    "plugin": "plugins",
    "projector": "projectors",
    "sensor": "sensors",
    "velocity_decay": "decays of velocity",
}
"""Elements that the dynamics do without, in words."""

_KNOWN = {
    "model": "pose link joint frame model include static enable_wind self_collide "
    "allow_auto_disable",
    "link": "pose inertial visual gravity kinematic enable_wind self_collide must_be_base_link",
    "joint": "pose parent child axis axis2 physics thread_pitch screw_thread_pitch gearbox_ratio "
    "gearbox_reference_body drake:rotor_inertia drake:gear_ratio drake:controller_gains "
    "drake:mimic",
    "world": "model include joint gravity frame physics scene magnetic_field atmosphere wind gui "
    "road spherical_coordinates population state",
    "axis": "xyz dynamics limit mimic initial_position use_parent_model_frame",
    "dynamics": "damping friction spring_stiffness spring_reference",
    "include": "uri name pose placement_frame static",
    "inertial": "pose mass inertia density",
}
"""Elements that may stand in others."""

Link: TypeAlias = "_Link"


@final
@dataclass
class _Frame:
    """A frame, by what it is stated in; links, models and joints have one, too."""

    element: Element
    pose: Array
    within: _Scope
    relative_to: str  # name in its scope
    link: Link | None = None
    attached_to: str = ""  # name in its scope, for frames


@final
@dataclass
class _Scope:
    """A model or the world: names in it."""

    name: str  # before the names of its links, with "::"
    parent: _Scope | None
    frames: dict[str, _Frame] = field(default_factory=dict)
    inner: dict[str, _Scope] = field(default_factory=dict)
    canonical: str = ""


@final
@dataclass(eq=False)
class _Link:
    """A link, in the frame of the joint that carries it."""

    name: str
    mass: Mass
    visuals: list[Visual]
    frame: _Frame
    static: bool
    weightless: bool
    shift: Array = field(default_factory=lambda: np.eye(4))  # of the link in its body


@final
@dataclass
class _Joint:
    element: Element
    scope: _Scope
    name: str
    parent: _Link
    child: _Link
    pose: Array  # in the world
    version: tuple[int, int]  # of SDF in its file
    sense: float = 1.0  # −1 where the child carries the parent


def read_sdf(
    path_or_text: str | os.PathLike[str], package_path: PackagePath | None = None
) -> Mechanism:
    """Return the mechanism that an SDF file or text describes."""
    file = None if isinstance(path_or_text, str) and "<" in path_or_text else Path(path_or_text)
    with refuse_overflow(file):
        return _Reader(file, package_path).read(path_or_text)


@final
class _Reader(Source):
    """One file with the models it includes."""

    def __init__(self, file: Path | None, package_path: PackagePath | None) -> None:
        super().__init__(file, "SDF")
        self._search = MeshSearch(file, package_path)
        self._version = (1, 0)
        self._links: list[_Link] = []
        self._framed: list[_Frame] = []  # of <frame>, which may carry nothing
        self._carried: list[_Joint] = []
        self._loops: list[Loop] = []

    def read(self, source: str | os.PathLike[str]) -> Mechanism:
        root = self.parse(self.file if self.file is not None else str(source))
        whole = self._open(root)
        world = _Scope("", None)
        ground = _Frame(root, np.eye(4), world, "")
        world.frames[GROUND] = ground
        self._ground = _Link(GROUND, no_mass(), [], ground, True, True)
        ground.link = self._ground
        parts: Sequence[Element] = (whole,)
        if whole.tag == "world":
            self._check(whole, "world")
            self.gravity = self._numbers_in(whole, "gravity", self.gravity)
            parts = whole.children
        several = sum(part.tag in ("model", "include") for part in parts) > 1
        for part in parts:
            if part.tag in ("model", "include"):
                self._model(part, world, several, 0, static=False)
            elif part.tag == "frame":
                self._frame(part, world)
            elif part.tag == "joint":
                self._note_joint(part, world)
        self._join_all(world)
        return self._mechanism(whole.attributes.get("name", "model"))

    def _open(self, root: Element) -> Element:
        """Return the one model or world below <sdf>."""
        if root.tag != "sdf":
            raise self.refuse(root, f"expected <sdf> as the outermost element, not <{root.tag}>")
        text = root.attributes.get("version", "")
        major, _, minor = text.partition(".")
        if major != "1" or not minor.isdigit() or not 3 <= int(minor) <= 12:
            raise self.refuse(root, f"expected version 1.3 to 1.12, got {text[:20]!r}")
        self._version = (1, int(minor))
        inside = [child for child in root.children if child.tag in ("model", "world")]
        for child in root.children:
            if child.tag not in ("model", "world", "light", "actor"):
                raise self.refuse(child, f"<{child.tag}> in <sdf> is not read")
        if len(inside) != 1:
            raise self.refuse(root, f"expected one <model> or <world>, got {len(inside)}")
        return inside[0]

    def _check(self, element: Element, kind: str) -> None:
        """Refuse what is not read in an element, and note what is left out."""
        self.count(element)
        known = _KNOWN[kind].split()
        for child in element.children:
            if child.tag in _OMITTED:
                self.omitted[_OMITTED[child.tag]] += 1
            elif child.tag not in known:
                prefix, colon, _ = child.tag.partition(":")
                if colon and prefix not in ("drake", "experimental"):
                    self.omitted[f"elements of {prefix}"] += 1
                    continue
                raise self.refuse(child, f"<{child.tag}> in <{element.tag}> is not read")

    # texts

    def _numbers_in(self, element: Element | None, tag: str, default: Iterable[float]) -> Array:
        """The numbers in the text of a child; the default without one."""
        child = element.child(tag) if element is not None else None
        values = [*default]
        if child is None:
            return np.array(values)
        plural = "number" if len(values) == 1 else "numbers"
        wanted = f"expected {len(values)} finite {plural} in <{tag}>"
        if '"' in child.text:  # libsdformat reads over it
            self.omitted["stray quotation marks"] += 1
        numbers = self.split(child, child.text.replace('"', " "), wanted)
        if len(numbers) != len(values):
            raise self.refuse(child, f"{wanted}, got {child.text[:60]!r}")
        return np.array(numbers)

    def _number_in(self, element: Element | None, tag: str, default: float) -> float:
        return float(self._numbers_in(element, tag, (default,))[0])

    def _limit_in(self, limits: Element | None, tag: str, default: float) -> float:
        """Return a bound, or the default where it stands for none."""
        child = limits.child(tag) if limits is not None else None
        with suppress(ValueError):
            if child is not None and abs(float(child.text)) >= _UNBOUNDED:
                return default
        value = self._number_in(limits, tag, default) if child is not None else default
        return default if value < 0 and tag in ("effort", "velocity") else value

    def _is_true(self, element: Element, tag: str, default: bool) -> bool:
        child = element.child(tag)
        return default if child is None else child.text.strip().lower() in ("true", "1")

    def _text_in(self, element: Element, tag: str) -> str:
        child = element.child(tag)
        if child is None or not child.text.strip():
            raise self.refuse(element, f"<{element.tag}> has no <{tag}>")
        return child.text.strip()

    def _pose_in(self, element: Element) -> tuple[Array, str]:
        """The pose stated in an element, and the name of the frame it is relative to."""
        child = element.child("pose")
        if child is None:
            return np.eye(4), ""
        form = child.attributes.get("rotation_format", "euler_rpy")
        count = {"euler_rpy": 6, "quat_xyzw": 7}.get(form)
        if count is None:
            raise self.refuse(child, f"rotation_format={form!r} is not read")
        wanted = f"expected {count} finite numbers in <pose>"
        nothing = "0 0 0 0 0 0" if count == 6 else "0 0 0 0 0 0 1"
        numbers = self.split(child, child.text or nothing, wanted)
        if len(numbers) != count:
            raise self.refuse(child, f"{wanted}, got {child.text[:60]!r}")
        if count == 7:
            x, y, z, w = numbers[3:]
            if abs(math.hypot(x, y, z, w) - 1) > _SLANT:
                raise self.refuse(
                    child, f"expected a unit quaternion in <pose>, got {child.text!r}"
                )
            turn = turn_of(np.array([w, x, y, z]))
        else:
            degrees = child.attributes.get("degrees", "false") in ("true", "1")
            roll, pitch, yaw = np.radians(numbers[3:]) if degrees else numbers[3:]
            turn = pose_of(Placement(rpy=(float(roll), float(pitch), float(yaw))))[:3, :3]
        relative_to = child.attributes.get("relative_to", child.attributes.get("frame", ""))
        return pose_at(numbers[:3], turn), relative_to

    def _name(self, element: Element) -> str:
        name = element.attributes.get("name", "")
        if not name:
            raise self.refuse(element, f"<{element.tag}> has no name")
        if element.tag != "world" and (name == GROUND or name[:2] == name[-2:] == "__"):
            raise self.refuse(element, f"the name {name!r} is reserved; give it another")
        return name

    # frames

    def _add_frame(self, element: Element, scope: _Scope, name: str, frame: _Frame) -> None:
        if name in scope.frames:
            raise self.refuse(element, f"the name {name!r} is there already; give it another")
        scope.frames[name] = frame

    def _frame(self, element: Element, scope: _Scope) -> None:
        pose, relative = self._pose_in(element)
        attached = element.attributes.get("attached_to", "")
        attached = attached or (GROUND if scope.parent is None else "__model__")
        frame = _Frame(element, pose, scope, relative or attached, attached_to=attached)
        self._add_frame(element, scope, self._name(element), frame)
        self._framed.append(frame)

    def _find(self, scope: _Scope, name: str, at: Element) -> _Frame:
        """Return a frame by its name in a scope, of models inside with "::"."""
        head, colons, rest = name.partition("::")
        if colons and head in scope.inner:
            return self._find(scope.inner[head], rest, at)
        if name in scope.frames:
            return scope.frames[name]
        if name == GROUND:
            return self._ground.frame
        raise self.refuse(at, f"there is no link, frame or joint {name!r} here; mend the name")

    def _follow(self, frame: _Frame, how: str) -> list[_Frame]:
        """Return a frame with those it is "stated relative" or "attached" to, to the last."""
        chain, met = [frame], set[int]()
        while chain[-1].link is None if how == "attached" else chain[-1].relative_to:
            last = chain[-1]
            met.add(id(last))
            name = last.attached_to if how == "attached" else last.relative_to
            chain.append(self._find(last.within, name, last.element))
            if id(chain[-1]) in met:
                raise self.refuse(last.element, f"frames are {how} to one another in a circle")
            if len(chain) > _MOST_FRAMES:
                message = f"frames are {how} to one another through more than {_MOST_FRAMES} others"
                raise self.refuse(frame.element, message)
        return chain

    def _place(self, frame: _Frame) -> Array:
        """Return the pose of a frame in the world."""
        *inner, pose = (part.pose for part in self._follow(frame, "stated relative"))
        for part in reversed(inner):
            pose = pose @ part
        return np.asarray(pose)

    def _carrier(self, frame: _Frame) -> _Link:
        """Return the link that a frame is attached to."""
        link = self._follow(frame, "attached")[-1].link
        assert link is not None
        return link

    # models

    def _model(
        self, element: Element, outer: _Scope, prefixed: bool, depth: int, *, static: bool
    ) -> None:
        if depth > _MOST_DEPTH:
            raise self.refuse(element, f"models are nested deeper than {_MOST_DEPTH}")
        around, version = element, self._version
        placed = element.attributes.get("placement_frame", "")
        pose, relative = self._pose_in(element)
        if element.tag == "include":
            element = self._include(element)
            placed = element.attributes.get("placement_frame", "")
            if around.child("pose") is None:
                pose, relative = self._pose_in(element)
            if around.child("placement_frame") is not None:
                placed = self._text_in(around, "placement_frame")
            static = static or self._is_true(around, "static", False)
        self._check(element, "model")
        given = around.child("name") if around.tag == "include" else None
        name = given.text.strip() if given is not None else self._name(element)
        merges = around.tag == "include" and around.attributes.get("merge") in ("true", "1")
        name = f"_merged__{name}__model__" if merges else name
        if name in outer.inner or name in outer.frames:
            raise self.refuse(around, f"the name {name!r} is there already; give it another")
        scope = _Scope(f"{outer.name}{name}::" if prefixed else "", outer)
        if merges:
            scope.name = outer.name
        else:
            outer.inner[name] = scope
        base = "__model__" if outer.parent is not None else GROUND
        model_frame = _Frame(around, pose, outer, relative or base)
        scope.frames["__model__"] = model_frame
        outer.frames[name] = model_frame
        static = static or self._is_true(element, "static", False)
        for child in element.children:
            match child.tag:
                case "link":
                    self._link(child, scope, static)
                case "frame":
                    self._frame(child, scope)
                case "joint":
                    self._note_joint(child, scope)
                case "model" | "include":
                    self._model(child, scope, True, depth + 1, static=static)
        self._version = version
        model_frame.attached_to = name
        model_frame.link = self._canonical(element, scope)
        if merges:
            # what was read stands in the outer model, too, but keeps its own names of frames
            frames = {key: frame for key, frame in scope.frames.items() if frame is not model_frame}
            if taken := outer.frames.keys() & frames.keys():
                raise self.refuse(
                    around, f"the name {min(taken)!r} is there already; give it another"
                )
            outer.frames.update(frames)
            outer.inner.update(scope.inner)
        if placed:
            # the model stands so that this frame of it has the pose that is stated
            target = self._find(scope, placed, around)
            base, pose = model_frame.relative_to, model_frame.pose
            model_frame.relative_to, model_frame.pose = "", np.eye(4)
            inside = self._place(target)
            model_frame.relative_to, model_frame.pose = base, pose @ np.linalg.inv(inside)

    def _canonical(self, element: Element, scope: _Scope) -> _Link:
        name = element.attributes.get("canonical_link", "")
        if name:
            return self._carrier(self._find(scope, name, element))
        links = (frame.link for frame in scope.frames.values() if frame.element.tag == "link")
        inside = (model.frames["__model__"].link for model in scope.inner.values())
        return next(filter(None, (*links, *inside)), self._ground)

    def _include(self, element: Element) -> Element:
        self._check(element, "include")
        uri = self._text_in(element, "uri")
        path = self._find_model(element, uri)
        inside = self._open(self.parse_inclusion(element, path))
        if inside.tag != "model":
            raise self.refuse(element, f"expected a model in {path}, got a world")
        return inside

    def _find_model(self, element: Element, uri: str) -> Path:
        scheme, separator, rest = uri.partition("://")
        if separator and scheme not in ("model", "package", "file"):
            message = f"models of {scheme}:// are not fetched: {uri[:60]!r}"
            raise self.refuse(element, f"{message}; fetch it, and name its folder by model://…")
        rest = rest if separator else uri
        candidates: list[Path] = []
        missing: Path | None = None
        named = separator and scheme != "file"
        if not named and self.file is not None and not Path(rest).is_absolute():
            near = Path(element.file).parent if element.file else self.file.parent
            candidates.append(near / rest)
        if scheme != "file":  # Gazebo seeks bare names among its models, too
            package, _, inside = rest.strip("/").partition("/")
            folder = self._search.package(package)
            missing = None if folder is None else folder / inside
            candidates += [] if missing is None else [missing]
        if any(part == ".." for part in Path(rest).parts):
            raise self.refuse(element, f"expected a model below this file, got {uri[:60]!r}")
        for candidate in candidates:
            if candidate.is_file():
                return candidate
            if candidate.is_dir():
                files = [*self._stated_in(element, candidate / "model.config")]
                files += [candidate / "model.sdf", *sorted(candidate.glob("*.sdf"))]
                existing = [file for file in files if file.is_file()]
                if existing:
                    return existing[0]
                missing = files[0]
        if missing is not None:
            message = f"the model {uri[:60]!r} would be {missing}: there is no such file"
            raise self.refuse(element, f"{message}; put it there, or mend the name")
        message = f"the model {uri[:60]!r} is not found in {self._search.searched}"
        raise self.refuse(element, f"{message}; name the folder that holds it (--package-path DIR)")

    def _stated_in(self, element: Element, config: Path) -> Iterator[Path]:
        """Yield the files that Gazebo's list of a model names, that of the newest version first."""
        named = self.parse_inclusion(element, config).all("sdf") if config.is_file() else ()
        texts = (re.findall(r"\d+", part.attributes.get("version", "")) for part in named)
        versions = zip((list(map(int, text)) for text in texts), named, strict=True)
        for _, part in sorted(versions, key=lambda pair: pair[0], reverse=True):
            yield config.parent / Path(part.text).name

    # links

    def _link(self, element: Element, scope: _Scope, static: bool) -> None:
        self._check(element, "link")
        name = self._name(element)
        pose, relative = self._pose_in(element)
        frame = _Frame(element, pose, scope, relative or "__model__")
        if self._is_true(element, "kinematic", False):
            raise self.refuse(element, "a kinematic link is not read")
        weightless = not self._is_true(element, "gravity", True)
        mass = self._inertial(element)
        link = _Link(f"{scope.name}{name}", mass, [], frame, static, weightless)
        link.visuals += self._visuals(element)
        frame.link = link
        self._add_frame(element, scope, name, frame)
        self._links.append(link)

    def _inertial(self, element: Element) -> Mass:
        """Mass 1 kg and moments 1 kg m² are SDF's where none are stated."""
        inertial = element.child("inertial")
        if inertial is None:
            return Mass(1.0, np.zeros(3), np.eye(3))
        self._check(inertial, "inertial")
        if inertial.attributes.get("auto", "false") in ("true", "1"):
            return self._inertia_of(element, inertial)
        pose, relative = self._pose_in(inertial)
        if relative:
            raise self.refuse(inertial, "the pose of <inertial> is always relative to its link")
        mass = self._number_in(inertial, "mass", 1.0)
        if not mass > 0:
            message = f"expected a positive <mass>, got {mass:g}: engines take 1 kg instead"
            raise self.refuse(inertial, message)
        stated = inertial.child("inertia")
        names = {"ixx": 1.0, "iyy": 1.0, "izz": 1.0, "ixy": 0.0, "ixz": 0.0, "iyz": 0.0}
        entries = [self._number_in(stated, name, default) for name, default in names.items()]
        return Mass(mass, np.zeros(3), tensor_of(entries)).move(pose)

    def _inertia_of(self, link: Element, inertial: Element) -> Mass:
        """The mass that a link's collisions have by their volumes and densities, or as stated."""
        density = self._number_in(inertial, "density", 1000.0)
        parts: list[Mass] = []
        for collision in link.all("collision"):
            pose, relative = self._pose_in(collision)
            geometry = collision.child("geometry")
            shape = next(iter(geometry.children), None) if geometry is not None else None
            size = None if shape is None or relative else self._half_size(shape)
            if shape is None or size is None:
                what = "this" if shape is None or relative else f"a <{shape.tag}> as"
                raise self.refuse(collision, f"the inertia of {what} <collision> is not computed")
            volume, squares = solid_of(shape.tag, size)
            mass = self._number_in(collision, "density", density) * volume
            parts.append(Mass(mass, np.zeros(3), np.diag(mass * squares)).move(pose))
        whole = sum_masses(parts)
        if not whole.mass > 0:
            raise self.refuse(inertial, "the collisions have no mass")
        mass = self._number_in(inertial, "mass", whole.mass)
        return Mass(mass, whole.center, mass / whole.mass * whole.inertia)

    def _half_size(self, shape: Element) -> Array | None:
        """Half the sizes along three axes, as far as a simple solid has them."""
        radius = self._number_in(shape, "radius", 0.5 if shape.tag == "capsule" else 1.0)
        match shape.tag:
            case "box":
                return self._numbers_in(shape, "size", (1, 1, 1)) / 2
            case "sphere":
                return np.array([radius, 0.0, 0.0])
            case "cylinder" | "capsule":
                return np.array([radius, self._number_in(shape, "length", 1.0) / 2, 0.0])
            case "ellipsoid":
                return self._numbers_in(shape, "radii", (1, 1, 1))
        return None

    def _visuals(self, element: Element) -> Iterator[Visual]:
        for visual in element.all("visual"):
            geometry = visual.child("geometry")
            shape = next(iter(geometry.children), None) if geometry is not None else None
            pose, _ = self._pose_in(visual)
            if shape is None:
                continue
            if (size := self._half_size(shape)) is not None:
                yield from draw(shape.tag, size, pose)
            uri = shape.child("uri")
            if shape.tag == "mesh" and uri is not None and uri.text.strip():
                x, y, z = self._numbers_in(shape, "scale", (1, 1, 1)).tolist()
                yield Visual(Mesh(uri.text.strip(), None, (x, y, z)), placement_at(pose))

    # joints

    def _note_joint(self, element: Element, scope: _Scope) -> None:
        self._check(element, "joint")
        name = self._name(element)
        pose, relative = self._pose_in(element)
        child = self._text_in(element, "child")
        frame = _Frame(element, pose, scope, relative or child, attached_to=child)
        self._add_frame(element, scope, name, frame)
        where = f"{scope.name}{name}", self._ground, self._ground  # until links are joined
        self._carried.append(_Joint(element, scope, *where, np.eye(4), self._version))
        for axis in element.all("axis") if self._version >= _FRAMES else ():
            if self._is_true(axis, "use_parent_model_frame", False):
                self.omitted["choices of the model's axes, which SDF 1.7 has no more"] += 1

    def _join_all(self, world: _Scope) -> None:
        """Join the links to a tree from the world; joints that are left close loops."""
        carrier: dict[str, _Joint] = {}
        closing: list[_Joint] = []
        for joint in self._carried:
            element, scope = joint.element, joint.scope
            ends = [self._text_in(element, tag) for tag in ("parent", "child")]
            if ends[1] == GROUND:
                raise self.refuse(element, "a joint whose child is the world is not read")
            joint.parent, joint.child = (
                self._carrier(self._find(scope, end, element)) for end in ends
            )
            joint.pose = self._place(scope.frames[self._name(element)])
            if joint.parent is joint.child:
                raise self.refuse(
                    element,
                    f"it joins link {joint.child.name!r} to itself; mend <parent> or <child>",
                )
            if joint.child.static:
                self.omitted["joints of static models"] += 1
            elif joint.child.name in carrier:
                closing.append(joint)
            else:
                carrier[joint.child.name] = joint
        closing = [joint for joint in closing if not self._turn(joint, carrier)]
        for frame in (*(link.frame for link in self._links), *self._framed):
            self._place(frame)
            self._carrier(frame)
        names = Names(joint.name for joint in self._carried)
        waiting = [link for link in self._links if link.name not in carrier]
        for link in waiting:
            if link.static:
                place = placement_at(self._place(link.frame))
                self.joints.append(
                    Fixed(names.free(f"{link.name}_weld"), GROUND, link.name, origin=place)
                )
            else:
                base = "root_joint" if len(waiting) == 1 else f"{link.name}_root_joint"
                self.joints.append(Floating(names.free(base), GROUND, link.name))
        reached = {GROUND, *(link.name for link in waiting)}
        left = [*carrier.values()]
        while left:
            ready = [joint for joint in left if joint.parent.name in reached]
            if not ready:
                message = f"link {left[0].child.name!r} hangs on itself"
                raise self.refuse(left[0].element, message)
            for joint in ready:
                self._joint(joint)
                reached.add(joint.child.name)
            left = [joint for joint in left if joint.child.name not in reached]
        for joint in closing:
            self._close(joint)

    def _turn(self, joint: _Joint, carrier: dict[str, _Joint]) -> bool:
        """Let children carry their parents up to a loose root, so that a joint closes no loop.

        Drake turns joints so, too.
        """
        ends = [_climb(link, carrier) for link in (joint.child, joint.parent)]
        if ends[0][-1] is ends[1][-1]:
            return False
        for way, turned in zip(ends, ([], [joint]), strict=True):
            turned += [carrier[link.name] for link in way[:-1]]
            kinds = {part.element.attributes.get("type") for part in turned}
            if way[-1] is self._ground or way[-1].static or kinds & {"ball", "universal"}:
                continue
            for part in turned:
                part.parent, part.child, part.sense = part.child, part.parent, -part.sense
            carrier |= {part.child.name: part for part in (joint, *turned)}
            return True
        return False

    def _direction(self, joint: _Joint, axis: Element | None) -> Array:
        """An axis in the joint's frame."""
        xyz = self._numbers_in(axis, "xyz", (0, 0, 1))
        stated = axis.child("xyz") if axis is not None else None
        old = joint.version < (1, 5)  # there axes are those of the model
        chosen = joint.version < _FRAMES and axis is not None
        turn = np.eye(3)
        if stated is not None and (name := stated.attributes.get("expressed_in", "")):
            frame = self._find(joint.scope, name, stated)
            turn = joint.pose[:3, :3].T @ self._place(frame)[:3, :3]
        elif axis is not None and chosen and self._is_true(axis, "use_parent_model_frame", old):
            model_frame = joint.scope.frames["__model__"]
            turn = joint.pose[:3, :3].T @ self._place(model_frame)[:3, :3]
        try:
            return joint.sense * unit_vector(turn @ xyz)
        except InputError as error:
            raise self.refuse(joint.element, str(error)) from None

    def _joint(self, joint: _Joint) -> None:
        element, parent, child = joint.element, joint.parent, joint.child
        axes = (*element.all("axis"), *element.all("axis2"))
        for stated in axes:
            self._check(stated, "axis")
        kind = element.attributes.get("type", "")
        pose = joint.pose
        axis = element.child("axis")
        if kind == "universal":
            both = (element.child(tag) for tag in ("axis", "axis2"))
            first, second = (self._direction(joint, along) for along in both)
            if abs(first @ second) > 1e-9:
                raise self.refuse(element, "the axes of a universal joint are not orthogonal")
            turn = np.column_stack([first, second, np.cross(first, second)])
            pose = pose @ pose_at(turn=turn)
        in_parent = np.linalg.inv(self._place(parent.frame) @ np.linalg.inv(parent.shift)) @ pose
        child.shift = np.linalg.inv(pose) @ self._place(child.frame)
        place = placement_at(in_parent)
        name, ends = joint.name, (parent.name, child.name)
        match kind:
            case "fixed":
                self.joints.append(Fixed(name, *ends, origin=place))
                return
            case "ball":
                self.joints.append(Spherical(name, *ends, origin=place))
            case "universal":
                self.joints.append(Universal(name, *ends, origin=place))
            case "revolute" | "continuous" | "prismatic" | "screw":
                self._single(joint, kind, axis, place)
                return
            case _:
                raise self.refuse(element, f"a joint of type {kind!r} is not read")
        for stated in axes:
            if self._number_in(stated.child("dynamics"), "spring_stiffness", 0.0):
                raise self.refuse(stated, f"spring_stiffness of a {kind} joint is not read")
        # Drake takes the damping of the first axis for all
        damping = self._number_in(axis.child("dynamics") if axis else None, "damping", 0.0)
        self.forces += resist_rates(self.joints[-1], [damping])

    def _single(self, joint: _Joint, kind: str, axis: Element | None, place: Placement) -> None:
        """Add a joint with one coordinate, its spring, its damper and what it follows."""
        element, name = joint.element, joint.name
        if axis is None:
            raise self.refuse(element, f"a joint of type {kind!r} has no <axis>; state one")
        x, y, z = self._direction(joint, axis).tolist()
        bounds = axis.child("limit")
        names = {"lower": -math.inf, "upper": math.inf, "effort": math.inf, "velocity": math.inf}
        values = {limit: self._limit_in(bounds, limit, names[limit]) for limit in names}
        rotor = self._number_in(element, "drake:rotor_inertia", 0.0)
        gear = self._number_in(element, "drake:gear_ratio", 1.0)
        armature = gear**2 * rotor if values["effort"] else 0.0
        stated = {
            "origin": place,
            "axis": (x, y, z),
            "limits": Limits(**values) if bounds is not None else None,
            "armature": armature,
        }
        ends = joint.parent.name, joint.child.name
        if kind == "screw":
            stated["pitch"] = self._pitch(element)
            self.joints.append(Helical(name, *ends, **stated))  # type: ignore[arg-type]
        else:
            made = Prismatic if kind == "prismatic" else Revolute
            self.joints.append(made(name, *ends, **stated))  # type: ignore[arg-type]
        dynamics = axis.child("dynamics")
        if dynamics is not None:
            self._check(dynamics, "dynamics")
        stiffness, damping, rest = (
            self._number_in(dynamics, tag, 0.0)
            for tag in ("spring_stiffness", "damping", "spring_reference")
        )
        if kind == "screw" and stiffness:
            self.omitted["springs in screws, which Drake leaves out"] += 1
            stiffness = 0.0
        linear = np.array([1.0, 0.0, 0.0])
        self.resist(name, name, stiffness * linear, np.full(2, rest), damping * linear)
        if self._number_in(dynamics, "friction", 0.0):
            self.rubbing.append(name)
        for tied in (element.child("drake:mimic"), axis.child("mimic")):
            if tied is None:
                continue
            inside = {child.tag: child.text for child in tied.children}
            texts = Given(self, tied, inside | dict(tied.attributes))
            if texts.get("axis", "axis") != "axis":
                raise texts.refuse("a mimic of a second axis is not read")
            leader = coordinate(f"{joint.scope.name}{texts.get('joint', '')}")
            law = leader - texts.number("reference", 0.0)
            law = texts.number("multiplier", 1.0) * law + texts.number("offset", 0.0)
            self.follow(tied, name, law)

    def _pitch(self, element: Element) -> float:
        """Advance per radian; `thread_pitch` is the old form, in rad/m and left-handed."""
        tags = {child.tag for child in element.children}
        if "screw_thread_pitch" in tags or "thread_pitch" not in tags:
            return self._number_in(element, "screw_thread_pitch", 1.0) / (2 * math.pi)
        old = self._number_in(element, "thread_pitch", 1.0)
        if not old:
            raise self.refuse(element, "expected a thread_pitch other than zero")
        return -1 / old

    def _close(self, joint: _Joint) -> None:
        """Close a loop by a joint whose child another joint carries already."""
        element = joint.element
        ends = []
        for link in (joint.parent, joint.child):
            body = self._place(link.frame) @ np.linalg.inv(link.shift)
            ends.append(np.linalg.inv(body) @ joint.pose)
        a, b = ends
        at_a, at_b = (tuple(end[:3, 3].tolist()) for end in ends)
        names = joint.parent.name, joint.child.name
        kind, axis = element.attributes.get("type", ""), element.child("axis")
        dynamics = None if axis is None else axis.child("dynamics")
        loads = (self._number_in(dynamics, tag, 0.0) for tag in ("damping", "spring_stiffness"))
        if kind != "fixed" and (any(loads) or kind in ("prismatic", "screw", "universal")):
            # the joint moves a body without mass, welded to the child, so that it has coordinates
            end = replace(joint.child, name=f"{joint.name}_end", mass=no_mass(), visuals=[])
            self._joint(replace(joint, child=end))
            self._links.append(end)
            loop = Loop.weld(f"{joint.name}_weld", end.name, Placement(), names[1], placement_at(b))
            self._loops.append(loop)
            return
        match kind:
            case "fixed":
                frames = placement_at(a), placement_at(b)
                self._loops.append(Loop.weld(joint.name, names[0], frames[0], names[1], frames[1]))
            case "ball":
                self._loops.append(Loop.ball(joint.name, names[0], at_a, names[1], at_b))
            case "revolute" | "continuous":
                along = self._direction(joint, axis)
                axes = [(end[:3, :3] @ along).tolist() for end in ends]
                loop = Loop.hinge(joint.name, names[0], at_a, names[1], at_b, axes[0], axes[1])
                self._loops.append(loop)
            case _:
                raise self.refuse(element, f"a loop closed by a joint of type {kind!r} is not read")

    def _mechanism(self, name: str) -> Mechanism:
        bodies = [Body(GROUND)]
        for link in self._links:
            mass = link.mass.move(link.shift)
            visuals = []
            for visual in link.visuals:
                place = placement_at(link.shift @ pose_of(visual.placement))
                visuals.append(replace(visual, placement=place))
            bodies.append(mass.body(link.name, visuals))
            if link.weightless:
                self.lift(link.name, "weightless", mass.center, mass.mass)
        singles = {joint.name for joint in self.joints}
        for follower, (element, law) in self.laws.items():
            missing = symbols_in(law) - singles
            if missing:
                message = f"joint {follower!r} mimics {min(missing)!r}, which is not there"
                raise self.refuse(element, message)
        light = [link.name for link in self._links if link.weightless and not link.static]
        about = list[str]()
        if light:
            about.append(f"<gravity> of {', '.join(light)} is off, which Drake ignores.")
        return self.assemble(name, bodies, self._loops, self.compose_laws(), *about)


def _climb(link: _Link, carrier: Mapping[str, _Joint]) -> list[_Link]:
    """Return a link, and those that carry it up to a root."""
    way = [link]
    while way[-1].name in carrier and carrier[way[-1].name].parent not in way:
        way.append(carrier[way[-1].name].parent)
    return way


_VERSION = "1.11"
"""The first that states mimics."""


def write_sdf(mechanism: Mechanism) -> str:
    """Return a mechanism as SDF text, without what `mecanique.formats.scope` lists as lost.

    Frames are those of the mechanism; a body without mass that is fixed to another is a frame of
    it. Loops are plain joints, rotors tags of Drake's. What has symbols is written with their
    values.
    """
    model = Tag("model", *_Writer(mechanism).parts(), name=mechanism.name)
    gravity = numbers(mechanism.evaluate_all(mechanism.gravity), "gravity")
    world = Tag("world", Tag("gravity", content=gravity), model, name=mechanism.name)
    whole = Tag("sdf", world, version=_VERSION, **{"xmlns:drake": DRAKE_NAMESPACE})
    return name_in_sdf(write_xml(whole))


def name_in_sdf(name: str) -> str:
    """Return a name, or a text of names, without what SDF keeps for names in other models."""
    return name.replace("::", "__")


@final
class _Writer:
    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        self._steps = chains(mechanism)
        self._axial = axial_steps(mechanism)
        self._bodies = {body.name: body for body in mechanism.bodies}
        # links and joints share their names' room in SDF; joints keep theirs
        steps = [step for chain in self._steps.values() for step in chain]
        names = Names(step.name for step in steps if step.kind != "floating")
        for loop in mechanism.loops:
            names.free(loop.name)
        carried = (step.child for step in steps)
        self._names = {body: names.free(body) for body in dict.fromkeys((*self._bodies, *carried))}
        ground = self._bodies[mechanism.ground]
        self._stands = ground.name != WORLD and not is_empty(mechanism, ground)
        self._lifted = {
            force.bodies[0] for force in mechanism.forces if lifted_share(mechanism, force) == 1
        }

    def parts(self) -> Iterator[Node]:
        """Yield links, frames and joints of the model."""
        mechanism = self._mechanism
        if self._stands:
            ground = mechanism.ground
            yield self._link(self._bodies[ground], {})
            ends = WORLD, self._name(ground)
            yield _joint(f"{ground}_weld", "fixed", ends, _pose((0, 0, 0), (0, 0, 0)))
        for joint in mechanism.joints:
            yield from self._carry(joint)
        poses = mechanism.home_poses
        kinds = {"weld": "fixed", "ball": "ball", "hinge": "revolute"}
        for loop in mechanism.loops:
            if loop.kind in kinds and is_closed(mechanism, loop, poses):
                axis = [_axis((0.0, 0.0, 1.0))] if loop.kind == "hinge" else []
                ends = self._name(loop.body_a), self._name(loop.body_b)
                place = self._pose(loop.frame_a)
                yield _joint(loop.name, kinds[loop.kind], ends, place, axis)

    def _name(self, body: str) -> str:
        grounded = body == self._mechanism.ground and not self._stands
        return WORLD if grounded else self._names[body]

    def _pose(self, place: Placement) -> str:
        return _pose(*map(self._mechanism.evaluate_all, (place.xyz, place.rpy)))

    def _carry(self, joint: Joint) -> Iterator[Node]:
        """Yield a joint, and the link it carries, whose frame is the joint's."""
        mechanism, body = self._mechanism, self._bodies[joint.child]
        parent, place = self._name(joint.parent), self._pose(joint.origin)
        if isinstance(joint, Floating):
            yield self._link(body, {}, place)
            return
        if isinstance(joint, Fixed) and is_empty(mechanism, body) and parent != WORLD:
            name = self._name(body.name)
            yield Tag("frame", Tag("pose", content=place), name=name, attached_to=parent)
            return
        name, ends = joint.name, (parent, self._name(joint.child))
        if isinstance(joint, Universal):
            axes = [_axis((1.0, 0.0, 0.0)), _axis((0.0, 1.0, 0.0), tag="axis2")]
            yield _joint(name, "universal", ends, place, axes)
        elif isinstance(joint, Helical):
            travel = number(2 * math.pi * mechanism.evaluate(joint.pitch), name)
            inside = [Tag("screw_thread_pitch", content=travel)]
            inside += self._moves(joint, self._steps[name][-1])
            yield _joint(name, "screw", ends, place, inside)
        else:
            for step in self._steps[name]:
                ends = self._name(step.parent), self._name(step.child)
                inside = [*self._moves(joint, step)]
                yield _joint(step.name, step.kind, ends, _pose(step.xyz, step.rpy), inside)
                if step.child != joint.child:
                    yield self._link(Body(step.child), {"relative_to": step.name})
        yield self._link(body, {"relative_to": name})

    def _link(self, body: Body, stated: dict[str, str], place: str = "") -> Tag:
        inside: list[Node] = []
        if place or stated:
            inside.append(Tag("pose", content=place or _pose((0, 0, 0), (0, 0, 0)), **stated))
        if body.name in self._lifted:
            inside.append(Tag("gravity", content="0"))
        evaluate = self._mechanism.evaluate_all
        where, names = f"body {body.name!r}", ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
        mass, entries = self._mechanism.evaluate(body.mass), evaluate(body.inertia)
        if not mass > 0:  # SDF would take 1 kg
            mass, entries = THICKENED, [*(e + THICKENED for e in entries[:3]), *entries[3:]]
        pairs = zip(names, entries, strict=True)
        moments = (Tag(name, content=number(entry, where)) for name, entry in pairs)
        center = _pose(evaluate(body.center), (0, 0, 0))
        parts = (Tag("pose", content=center), Tag("mass", content=number(mass, where)))
        inside.append(Tag("inertial", *parts, Tag("inertia", *moments)))
        inside += [self._visual(visual, k) for k, visual in enumerate(body.visuals)]
        return Tag("link", *inside, name=self._names[body.name])

    def _visual(self, visual: Visual, index: int) -> Tag:
        kind, measures = measure_in_words(self._mechanism, visual.geometry, "a visual")
        inside = [Tag(name, content=words) for name, words in measures.items()]
        if isinstance(visual.geometry, Mesh):
            inside.insert(0, Tag("uri", content=visual.geometry.uri))
        shape = Tag(kind, *inside)
        parts = [Tag("pose", content=self._pose(visual.placement)), Tag("geometry", shape)]
        if visual.rgba is not None:
            color = Tag("diffuse", content=numbers(visual.rgba, "a color"))
            parts.append(Tag("material", color))
        return Tag("visual", *parts, name=f"visual_{index}")

    def _moves(self, joint: Joint, step: SimpleJoint) -> Iterator[Tag]:
        """Yield the axis of a joint with its limits, spring, damper, law and rotor."""
        if step.axis is None:
            return
        mechanism, where = self._mechanism, f"joint {step.name!r}"
        inside: list[Node] = [*_limits(step.limits, where)]
        single = isinstance(joint, Single) and step.name == joint.name
        if single:
            stiffness, reference = joint_spring(mechanism, joint.name)
            named = {
                "damping": joint_damping(mechanism, joint.name),
                "spring_stiffness": stiffness,
                "spring_reference": reference,
            }
            given = {name: value for name, value in named.items() if value}
            states = [Tag(name, content=number(value, where)) for name, value in given.items()]
            inside += [Tag("dynamics", *states)] if states else []
        if step.coordinate in mechanism.coordinates.driven:
            law = law_of_follower(mechanism, self._axial, step.coordinate, SCOPES["SDF"].degree)
            if law is not None and law[0]:
                leader, (offset, factor) = law
                given = {"multiplier": factor, "offset": offset, "reference": 0.0}
                states = [Tag(name, content=number(value, where)) for name, value in given.items()]
                inside.append(Tag("mimic", *states, joint=leader))
        yield _axis(step.axis, inside)
        if isinstance(joint, Single) and single and (rotor := mechanism.evaluate(joint.armature)):
            yield Tag("drake:rotor_inertia", content=number(rotor, where))
            yield Tag("drake:gear_ratio", content="1")


def _pose(xyz: Sequence[float], rpy: Sequence[float]) -> str:
    return f"{numbers(xyz, 'a pose')} {numbers(rpy, 'a pose')}"


def _joint(
    name: str, kind: str, ends: tuple[str, str], place: str, inside: Sequence[Node] = ()
) -> Tag:
    base = "__model__" if ends[0] == WORLD else ends[0]
    pose = Tag("pose", content=place, relative_to=base)
    parent, child = Tag("parent", content=ends[0]), Tag("child", content=ends[1])
    return Tag("joint", pose, parent, child, *inside, name=name, type=kind)


def _axis(axis: Sequence[float], inside: Sequence[Node] = (), tag: str = "axis") -> Tag:
    return Tag(tag, Tag("xyz", content=numbers(axis, "an axis")), *inside)


def _limits(limits: Limits | None, where: str) -> Iterator[Tag]:
    if limits is None:
        return
    bounds = {
        name: value
        for name in ("lower", "upper", "effort", "velocity")
        if abs(value := getattr(limits, name)) < UNBOUNDED
    }
    if bounds:
        stated = (Tag(name, content=number(value, where)) for name, value in bounds.items())
        yield Tag("limit", *stated)
