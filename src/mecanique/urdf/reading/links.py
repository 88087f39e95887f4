"""Links of a URDF."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.model.bodies import Body
from mecanique.model.bodies.body import Inertia, Shape
from mecanique.model.bodies.tensor import tensor_of
from mecanique.model.bodies.visuals import Box, Cylinder, Geometry, Mesh, Rgba, Sphere, Visual
from mecanique.model.mechanism.validation import inertia_fault
from mecanique.model.placement import Placement, pose_of
from mecanique.urdf.dialect import WORLD
from mecanique.urdf.findings import Report
from mecanique.urdf.markup import Element
from mecanique.urdf.reading.fields import Passage
from mecanique.urdf.reading.joints import JointText
from mecanique.urdf.reading.packages import MeshSearch, OutsideError
from mecanique.urdf.solids import Mass

_SHAPES = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",), "mesh": ()}
"""Attributes with the sizes of each shape."""


@final
@dataclass
class Pictures:
    """Read the appearance of links."""

    report: Report
    search: MeshSearch
    materials: dict[str, Rgba | None] = field(default_factory=dict)
    lost: list[Passage] = field(default_factory=list)  # the meshes that were not found

    def declare(self, robot: Element) -> None:
        """Read the robot's materials, then those inside links, to which other links may refer."""
        for element in robot.all("material"):
            self._material(Passage(element, self.report))
        for link in robot.all("link"):
            for visual in link.all("visual"):
                for element in visual.all("material"):
                    if element.child("color") is not None:
                        name = element.attributes.get("name", "")
                        if name and name not in self.materials:
                            self._material(Passage(element, self.report))

    def visuals(self, link: Element, tag: str, where: str) -> tuple[Visual, ...]:
        """Return the visuals or collisions of a link, without those that cannot be drawn."""
        texts = (Passage(element, self.report, where) for element in link.all(tag))
        return tuple(visual for visual in map(self._visual, texts) if visual is not None)

    def _visual(self, text: Passage) -> Visual | None:
        place = text.origin()
        geometry = self._geometry(text)
        color = self._color(text) if text.element.tag == "visual" else None
        name = text.element.attributes.get("name", "")
        return None if geometry is None else Visual(geometry, place, color, name)

    def _geometry(self, text: Passage) -> Geometry | None:
        holder = text.only("geometry")
        inside = [] if holder is None else list(holder.element.children)
        shapes = [text.at(child) for child in inside if child.tag in _SHAPES]
        if len(shapes) > 1:
            shapes[1].fault("M112", f"<geometry> holds {len(shapes)} shapes")
        if not shapes:
            others = ", ".join(child.tag for child in inside[:3])
            fault = f"of a kind that is not known ({others})" if others else "missing"
            message = f"the shape of a <{text.element.tag}> is {fault}"
            (holder or text).fault("M503", message)
            return None
        shape, tag = shapes[0], shapes[0].element.tag
        if tag == "mesh":
            return self._mesh(shape)
        count = 3 if tag == "box" else 1
        parts = [shape.numbers(name, count) for name in _SHAPES[tag]]
        if None in parts:
            return None
        sizes = tuple(size for part in parts if part is not None for size in part)
        if min(sizes) <= 0:
            shape.fault("M504", f"expected positive sizes of a <{tag}>, got {sizes}")
            return None
        if tag == "box":
            return Box((sizes[0], sizes[1], sizes[2]))
        return Sphere(sizes[0]) if tag == "sphere" else Cylinder(sizes[0], sizes[1])

    def _mesh(self, shape: Passage) -> Mesh | None:
        uri = shape.element.attributes.get("filename")
        scale = shape.numbers("scale", 3, default=(1.0, 1.0, 1.0))
        if not uri:
            shape.fault("M103", "<mesh> has no filename=…")
            return None
        path = None
        try:
            path = self.search.find(uri)
            if path is None:
                self.lost.append(shape)
        except OutsideError:
            shape.fault("M502", f"the mesh {uri!r} lies outside its package")
        return None if scale is None else Mesh(uri, path, (scale[0], scale[1], scale[2]))

    def _color(self, text: Passage) -> Rgba | None:
        material = text.only("material")
        if material is None:
            return None
        element = material.element
        if element.child("color") is not None:
            return _rgba(material)
        name = element.attributes.get("name", "")
        if name not in self.materials and element.child("texture") is None:
            material.fault("M505", f"the material {name!r} is not described")
        return self.materials.get(name)

    def _material(self, material: Passage) -> None:
        name = material.element.attributes.get("name", "")
        if not name:
            material.fault("M103", "<material> has no name=…")
        elif name in self.materials:
            material.fault("M106", f"the material {name!r} is described twice")
        else:
            self.materials[name] = _rgba(material)


def _rgba(material: Passage) -> Rgba | None:
    color = material.only("color")
    values = None if color is None else color.numbers("rgba", 4)
    if color is None or values is None:
        return None
    if not all(0 <= value <= 1 for value in values):
        color.fault("M506", f"expected colors from 0 to 1, got {values}")
        values = tuple(min(max(value, 0.0), 1.0) for value in values)
    return values[0], values[1], values[2], values[3]


ENTRIES = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
"""Attributes of <inertia>, in the order of the model."""


@final
@dataclass(frozen=True)
class UrdfLink:
    """A link as written."""

    name: str
    element: Element
    visuals: tuple[Visual, ...]
    collisions: tuple[Visual, ...]
    mass: float = 0.0  # kg
    frame: Placement = field(default_factory=Placement)  # of the inertia in the link
    inertia: Inertia = (0.0,) * 6  # about the origin of `frame`, in its axes [kg·m²]
    real: bool = True  # whether a real body can have this inertia

    @property
    def where(self) -> str:
        """Its name in reports."""
        return f"link {self.name!r}"

    @property
    def massless(self) -> bool:
        """Whether it has neither mass nor inertia."""
        return not self.mass and not any(self.inertia)

    def mass_at(self, pose: Array) -> Mass:
        """Return its mass in the frame in which its own has a pose."""
        mass = Mass(self.mass, np.zeros(3), tensor_of(self.inertia))
        return mass.move(pose @ pose_of(self.frame))

    def body(self) -> Body:
        """Return the body it describes."""
        if self.massless:
            shapes = (Shape(0.0, visuals=self.visuals),) if self.visuals else ()
            return Body(self.name, *shapes)
        shape = Shape(self.mass, inertia=self.inertia).at(self.frame.xyz, self.frame.rpy)
        whole = replace(shape, visuals=self.visuals)
        return Body(self.name, whole, as_given=not self.real)


def read_links(robot: Element, report: Report, pictures: Pictures) -> list[UrdfLink]:
    """Return the links of a robot; what cannot be read is reported."""
    links: dict[str, UrdfLink] = {}
    for element in robot.all("link"):
        text = Passage(element, report)
        name = text.name()
        text = replace(text, where=f"link {name!r}" if name else "a link")
        inertial = _read_inertial(text)
        visuals = pictures.visuals(element, "visual", text.where)
        collisions = pictures.visuals(element, "collision", text.where)
        if name is None:
            continue
        if name in links:
            text.fault("M106", f"it is there already at line {links[name].element.line}")
            continue
        links[name] = UrdfLink(name, element, visuals, collisions, **inertial)
    if not links and not report.stopped:
        report.add("M102", robot, "the robot has no link")
    return list(links.values())


def implied_world(links: list[UrdfLink], joints: list[JointText], report: Report) -> list[UrdfLink]:
    """Return the link `world` if joints refer to it but no link declares it, as Drake does."""
    if any(link.name == WORLD for link in links):
        return []
    for joint in joints:
        if joint.parent == WORLD:
            message = f"its parent {WORLD!r} is no link; it is read as the inertial frame"
            remedy = f'Add <link name="{WORLD}"/>; Pinocchio refuses the file without it.'
            report.aside.add("M107", joint, message, remedy)
            return [UrdfLink(WORLD, joint.element, (), ())]
    return []


def _read_inertial(link: Passage) -> dict[str, Any]:
    """Return mass, frame and inertia of a link; nothing if it has none that can be read."""
    text = link.only("inertial")
    if text is None:
        return {}
    frame = text.origin()
    mass_text, inertia_text = (text.only(tag) for tag in ("mass", "inertia"))
    if mass_text is None:
        text.fault("M103", "<inertial> has no <mass>")
    if inertia_text is None:
        remedy = "Write <inertia> out; Pinocchio and Drake take a point, MuJoCo refuses the file."
        message = "<inertial> has no <inertia>; it is read as a point's"
        text.aside.fault("M103", message, remedy)
    mass = None if mass_text is None else mass_text.number("value")
    entries = [0.0 if inertia_text is None else inertia_text.number(name) for name in ENTRIES]
    inertia = tuple(entry for entry in entries if entry is not None)
    if mass is None or mass_text is None or len(inertia) < len(ENTRIES):
        return {}
    if mass < 0:
        mass_text.fault("M201", f"its mass is {mass:g} kg")
        return {}
    fault = inertia_fault(mass, inertia)
    if fault and inertia_text is not None:
        # Lagrange's equations hold for any numbers
        inertia_text.aside.fault("M203" if "triangle" in fault else "M202", fault)
    return {"mass": mass, "frame": frame, "inertia": inertia, "real": not fault}
