"""Links of a URDF."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

from mecanique.model.bodies import Body
from mecanique.model.bodies.shape import Inertia, Shape
from mecanique.model.bodies.visuals import Visual
from mecanique.model.mechanism.validation import inertia_fault
from mecanique.model.placement import Placement
from mecanique.urdf.dialect import WORLD
from mecanique.urdf.element import Element
from mecanique.urdf.findings import Report
from mecanique.urdf.reading.fields import name_of, number, placement, single
from mecanique.urdf.reading.joints import JointText
from mecanique.urdf.reading.pictures import Pictures

ENTRIES = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
"""Attributes of <inertia>, in the order of the model."""


@final
@dataclass(frozen=True)
class Link:
    """A link as written.

    Args:
        name: its name.
        element: where it is written.
        mass: [kg].
        frame: where the inertia's center and axes are in the link.
        inertia: ixx, iyy, izz, ixy, ixz, iyz about the center, in the axes of `frame` [kg·m²].
        visuals: what is drawn.
        collisions: what would collide.
        real: whether a real body can have this inertia.
    """

    name: str
    element: Element
    mass: float
    frame: Placement
    inertia: Inertia
    visuals: tuple[Visual, ...]
    collisions: tuple[Visual, ...]
    real: bool = True

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


def read_links(robot: Element, report: Report, pictures: Pictures) -> list[Link]:
    """Return the links of a robot; what cannot be read is reported."""
    links: dict[str, Link] = {}
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
        links[name] = Link(
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


def implied_world(links: list[Link], joints: list[JointText], report: Report) -> list[Link]:
    """Return the link `world` if joints refer to it but no link declares it, as Drake does."""
    if any(link.name == WORLD for link in links):
        return []
    for joint in joints:
        if joint.parent == WORLD:
            message = f"its parent {WORLD!r} is no link; it is read as the inertial frame"
            remedy = f'Add <link name="{WORLD}"/>; Pinocchio refuses the file without it.'
            report.aside.add("M107", joint.element, joint.where, message, remedy)
            nothing = 0.0, Placement(), (0.0,) * 6
            return [Link(WORLD, joint.element, *nothing, (), ())]
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
