"""Visuals, collisions and materials of a URDF."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import final

from mecanique.model.bodies.visuals import Box, Cylinder, Geometry, Mesh, Rgba, Sphere, Visual
from mecanique.urdf.element import Element
from mecanique.urdf.findings import Report
from mecanique.urdf.reading.fields import number, numbers, placement, single
from mecanique.urdf.reading.packages import MeshSearch, OutsideError

_SHAPES = ("box", "cylinder", "sphere", "mesh")


@final
@dataclass
class Pictures:
    """Read the appearance of links.

    Args:
        report: where faults are noted.
        search: finds the mesh files.
        materials: color of each material known by name.
    """

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
        found = (self._visual(element, where) for element in link.all(tag))
        return tuple(visual for visual in found if visual is not None)

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
            found = f"of a kind that is not known ({others})" if others else "missing"
            self.report.add(
                "M503", holder or element, where, f"the shape of a <{element.tag}> is {found}"
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
