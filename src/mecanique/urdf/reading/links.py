"""Links of a URDF."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import final

from mecanique.model.bodies import Body
from mecanique.model.bodies.body import Inertia, Shape
from mecanique.model.bodies.visuals import Box, Cylinder, Geometry, Mesh, Rgba, Sphere, Visual
from mecanique.model.mechanism.validation import inertia_fault
from mecanique.model.placement import Placement
from mecanique.urdf.dialect import WORLD
from mecanique.urdf.findings import Report
from mecanique.urdf.markup import Element
from mecanique.urdf.reading.fields import name_of, number, numbers, placement, single
from mecanique.urdf.reading.joints import JointText
from mecanique.urdf.reading.packages import MeshSearch, OutsideError

_SHAPES = ("box", "cylinder", "sphere", "mesh")


@final
@dataclass
class Pictures:
    """Read the appearance of links."""

    report: Report
    search: MeshSearch
    materials: dict[str, Rgba | None] = field(default_factory=dict)
    lost: list[tuple[Element, str]] = field(default_factory=list)

    def declare(self, robot: Element) -> None:
        """Read the robot's materials, then those inside links, to which other links may refer."""
        for element in robot.all("material"):
            self._material(element, "")
        for link in robot.all("link"):
            for visual in link.all("visual"):
                for element in visual.all("material"):
                    if element.child("color") is not None:
                        name = element.attributes.get("name", "")
                        if name and name not in self.materials:
                            self._material(element, "")

    def visuals(self, link: Element, tag: str, where: str) -> tuple[Visual, ...]:
        """Return the visuals or collisions of a link, without those that cannot be drawn."""
        visuals = (self._visual(element, where) for element in link.all(tag))
        return tuple(visual for visual in visuals if visual is not None)

    def _visual(self, element: Element, where: str) -> Visual | None:
        place = placement(element, self.report, where)
        geometry = self._geometry(element, where)
        color = self._color(element, where) if element.tag == "visual" else None
        name = element.attributes.get("name", "")
        return None if geometry is None else Visual(geometry, place, color, name)

    def _geometry(self, element: Element, where: str) -> Geometry | None:
        holder = single(element, "geometry", self.report, where)
        shapes = (
            [] if holder is None else [child for child in holder.children if child.tag in _SHAPES]
        )
        if len(shapes) > 1:
            self.report.add("M112", shapes[1], where, f"<geometry> holds {len(shapes)} shapes")
        if not shapes:
            others = "" if holder is None else ", ".join(child.tag for child in holder.children[:3])
            fault = f"of a kind that is not known ({others})" if others else "missing"
            self.report.add(
                "M503", holder or element, where, f"the shape of a <{element.tag}> is {fault}"
            )
            return None
        shape = shapes[0]
        if shape.tag == "mesh":
            return self._mesh(shape, where)
        sizes = self._sizes(shape, where)
        if sizes is None:
            return None
        if min(sizes) <= 0:
            self.report.add(
                "M504", shape, where, f"expected positive sizes of a <{shape.tag}>, got {sizes}"
            )
            return None
        if shape.tag == "box":
            return Box((sizes[0], sizes[1], sizes[2]))
        return Sphere(sizes[0]) if shape.tag == "sphere" else Cylinder(sizes[0], sizes[1])

    def _sizes(self, shape: Element, where: str) -> tuple[float, ...] | None:
        if shape.tag == "box":
            return numbers(shape, "size", 3, self.report, where)
        names = ("radius",) if shape.tag == "sphere" else ("radius", "length")
        sizes = [number(shape, name, self.report, where) for name in names]
        known = tuple(size for size in sizes if size is not None)
        return known if len(known) == len(names) else None

    def _mesh(self, shape: Element, where: str) -> Mesh | None:
        uri = shape.attributes.get("filename")
        scale = numbers(shape, "scale", 3, self.report, where, default=(1.0, 1.0, 1.0))
        if not uri:
            self.report.add("M103", shape, where, "<mesh> has no filename=…")
            return None
        path = None
        try:
            path = self.search.find(uri)
            if path is None:
                self.lost.append((shape, where))
        except OutsideError:
            self.report.add("M502", shape, where, f"the mesh {uri!r} lies outside its package")
        return None if scale is None else Mesh(uri, path, (scale[0], scale[1], scale[2]))

    def _color(self, element: Element, where: str) -> Rgba | None:
        material = single(element, "material", self.report, where)
        if material is None:
            return None
        if material.child("color") is not None:
            return self._rgba(material, where)
        name = material.attributes.get("name", "")
        if name not in self.materials and material.child("texture") is None:
            self.report.add("M505", material, where, f"the material {name!r} is not described")
        return self.materials.get(name)

    def _material(self, element: Element, where: str) -> None:
        name = element.attributes.get("name", "")
        if not name:
            self.report.add("M103", element, where, "<material> has no name=…")
        elif name in self.materials:
            self.report.add("M106", element, where, f"the material {name!r} is described twice")
        else:
            self.materials[name] = self._rgba(element, where)

    def _rgba(self, material: Element, where: str) -> Rgba | None:
        color = single(material, "color", self.report, where)
        if color is None:
            return None
        values = numbers(color, "rgba", 4, self.report, where)
        if values is None:
            return None
        if not all(0 <= value <= 1 for value in values):
            self.report.add("M506", color, where, f"expected colors from 0 to 1, got {values}")
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
    mass: float  # kg
    frame: Placement  # where the inertia's center and axes are in the link
    inertia: Inertia  # about the center, in the axes of `frame` [kg·m²]
    visuals: tuple[Visual, ...]
    collisions: tuple[Visual, ...]
    real: bool = True  # whether a real body can have this inertia

    @property
    def where(self) -> str:
        """Its name in reports."""
        return f"link {self.name!r}"

    @property
    def massless(self) -> bool:
        """Whether it has neither mass nor inertia."""
        return not self.mass and not any(self.inertia)

    def body(self) -> Body:
        """Return the body it describes."""
        if self.massless:
            return (
                Body(self.name, Shape(0.0, visuals=self.visuals))
                if self.visuals
                else Body(self.name)
            )
        shape = Shape(self.mass, inertia=self.inertia).at(self.frame.xyz, self.frame.rpy)
        whole = replace(shape, visuals=self.visuals)
        return Body(self.name, whole, as_given=not self.real)


def read_links(robot: Element, report: Report, pictures: Pictures) -> list[UrdfLink]:
    """Return the links of a robot; what cannot be read is reported."""
    links: dict[str, UrdfLink] = {}
    for element in robot.all("link"):
        name = name_of(element, report)
        where = f"link {name!r}" if name else "a link"
        mass, frame, inertia, real = _inertial(element, report, where)
        visuals = pictures.visuals(element, "visual", where)
        collisions = pictures.visuals(element, "collision", where)
        if name is None:
            continue
        if name in links:
            report.add(
                "M106", element, where, f"it is there already at line {links[name].element.line}"
            )
            continue
        links[name] = UrdfLink(
            name=name,
            element=element,
            mass=mass,
            frame=frame,
            inertia=inertia,
            visuals=visuals,
            collisions=collisions,
            real=real,
        )
    if not links and not report.stopped:
        report.add("M102", robot, "", "the robot has no link")
    return list(links.values())


def implied_world(links: list[UrdfLink], joints: list[JointText], report: Report) -> list[UrdfLink]:
    """Return the link `world` if joints refer to it but no link declares it, as Drake does."""
    if any(link.name == WORLD for link in links):
        return []
    for joint in joints:
        if joint.parent == WORLD:
            message = f"its parent {WORLD!r} is no link; it is read as the inertial frame"
            remedy = f'Add <link name="{WORLD}"/>; Pinocchio refuses the file without it.'
            report.aside.add("M107", joint.element, joint.where, message, remedy)
            nothing = 0.0, Placement(), (0.0,) * 6
            return [UrdfLink(WORLD, joint.element, *nothing, (), ())]
    return []


def _inertial(link: Element, report: Report, where: str) -> tuple[float, Placement, Inertia, bool]:
    nothing = 0.0, Placement(), (0.0,) * 6, True
    element = single(link, "inertial", report, where)
    if element is None:
        return nothing
    frame = placement(element, report, where)
    parts = {tag: single(element, tag, report, where) for tag in ("mass", "inertia")}
    for tag, part in parts.items():
        if part is None and tag == "inertia":
            message = "<inertial> has no <inertia>; it is read as a point's"
            remedy = (
                "Write <inertia> out; Pinocchio and Drake take a point, MuJoCo refuses the file."
            )
            report.aside.add("M103", element, where, message, remedy)
        elif part is None:
            report.add("M103", element, where, f"<inertial> has no <{tag}>")
    mass_element, inertia_element = parts["mass"], parts["inertia"]
    mass = None if mass_element is None else number(mass_element, "value", report, where)
    entries = (
        [0.0] * len(ENTRIES)
        if inertia_element is None
        else [number(inertia_element, name, report, where) for name in ENTRIES]
    )
    inertia = tuple(entry for entry in entries if entry is not None)
    if mass is None or mass_element is None or len(inertia) < len(ENTRIES):
        return nothing
    if mass < 0:
        report.add("M201", mass_element, where, f"its mass is {mass:g} kg")
        return nothing
    fault = inertia_fault(mass, inertia)
    if fault and inertia_element is not None:
        # Lagrange's equations hold for any numbers
        code = "M203" if "triangle" in fault else "M202"
        report.aside.add(code, inertia_element, where, fault)
    ixx, iyy, izz, ixy, ixz, iyz = inertia
    return mass, frame, (ixx, iyy, izz, ixy, ixz, iyz), not fault
