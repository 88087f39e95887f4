"""Elements that guide, in URDF: tags of our own beside the joints, which other programs ignore.

    <mecanique:cord name="cord" normal="0 -1 0">
      <mecanique:end link="weight1" xyz="0 0 0"/>
      <mecanique:pulley link="pulley" xyz="0 0 0" radius="0.2" sense="-1" grips="true"/>
      <mecanique:end link="weight2" xyz="0 0 0"/>
    </mecanique:cord>

    <mecanique:belt name="drive" normal="0 -1 0" preload="200">
      <mecanique:pulley link="motor" xyz="0 0 0" radius="0.05"/>
      <mecanique:pulley link="drum" xyz="0 0 0" radius="0.15"/>
    </mecanique:belt>

    <mecanique:gear name="mesh" wheel="sun" other="planet" radius="0.2" other_radius="0.1"
                    internal="false" pressure_angle="0.349"/>
    <mecanique:rack name="mesh" wheel="pinion" other="slide" radius="0.1" point="0 0 0.1"
                    pressure_angle="0.349"/>

The joints that a cord, a belt or teeth tie mimic one another; the tag says what ties them. A pin
that mimic joints close already is a `mecanique:loop` with `redundant="true"`
(`mecanique.urdf.reading.loops`).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from math import radians
from typing import TypeAlias

from mecanique.errors import InputError
from mecanique.model.constraints.cords import Belt, Cord, Pulley
from mecanique.model.constraints.gears import Gear, Rack
from mecanique.model.constraints.loops import Loop
from mecanique.model.expression import Scalar
from mecanique.model.mechanism import Mechanism
from mecanique.urdf.dialect import BELT, CORD, CORD_STOPS, GEAR, RACK
from mecanique.urdf.findings import Report
from mecanique.urdf.markup import Comment, Element, Node, Tag
from mecanique.urdf.markup import number as written
from mecanique.urdf.markup import numbers as all_written
from mecanique.urdf.names import Names
from mecanique.urdf.reading.fields import name_of, number, numbers
from mecanique.urdf.reading.loops import loop_nodes

_END, _PULLEY = CORD_STOPS
_SENSES = {"1": 1, "-1": -1}
_GRIPS = {"true": True, "false": False}

Triple: TypeAlias = "tuple[float, float, float]"
"""Three components."""


def element_nodes(
    mechanism: Mechanism, anchors: Mapping[str, str], *, mimicked: bool
) -> Iterator[Node]:
    """Give the tags of a mechanism's elements, each after a comment with its name."""
    for element in mechanism.elements:
        if isinstance(element, Loop):
            yield from loop_nodes(mechanism, element, anchors, redundant=mimicked)
            continue
        if isinstance(element, (Gear, Rack)):
            yield from _teeth_nodes(mechanism, element)
            continue
        belt = isinstance(element, Belt)
        what = "belt" if belt else "cord"
        where = f"{what} {element.name!r}"
        yield Comment(f"{what} {element.name}, which mecanique reads; others see its mimic joints")
        stops = []
        every = element.stops[:-1] if belt else element.stops
        for k, stop in enumerate(every):
            link = anchors.get(stop.body, stop.body)
            xyz = all_written([mechanism.evaluate(c) for c in stop.center], where)
            if belt or 0 < k <= len(element.over):
                radius = written(mechanism.evaluate(stop.radius), where)
                grips = str(element.over[k if belt else k - 1].grips).lower()
                about = {"radius": radius, "sense": str(stop.sense), "grips": grips}
                stops.append(Tag(_PULLEY, link=link, xyz=xyz, **about))
            else:
                stops.append(Tag(_END, link=link, xyz=xyz))
        turned = {} if element.axes == "world" else {"axes": element.axes}
        if isinstance(element, Belt) and element.preload is not None:
            turned["preload"] = written(mechanism.evaluate(element.preload), where)
        normal = all_written(element.normal, where)
        tag = BELT if belt else CORD
        yield Tag(tag, *stops, name=element.name, normal=normal, **turned)


def _teeth_nodes(mechanism: Mechanism, element: Gear | Rack) -> Iterator[Node]:
    """The tag of wheels in mesh, or of a pinion and its rack."""
    what = type(element).__name__.lower()
    where = f"{what} {element.name!r}"

    def value(scalar: Scalar) -> str:
        return written(mechanism.evaluate(scalar), where)

    more = {"wheel": element.wheel, "other": element.other, "radius": value(element.radius)}
    if isinstance(element, Gear):
        more["other_radius"] = value(element.other_radius)
        more["internal"] = str(element.internal).lower()
    else:
        more["point"] = all_written([mechanism.evaluate(c) for c in element.point], where)
    more["pressure_angle"] = value(element.pressure_angle)
    yield Comment(f"{what} {element.name}, which mecanique reads; others see its mimic joints")
    yield Tag(GEAR if isinstance(element, Gear) else RACK, name=element.name, **more)


def read_teeth(
    element: Element, joints: Collection[str], names: Names, report: Report
) -> Gear | Rack | None:
    """Return the gear or rack that our own element describes; None if faults were reported."""
    name = name_of(element, report)
    where = f"{element.tag.partition(':')[2]} {name!r}"
    carried: list[str] = []
    for role in ("wheel", "other"):
        joint = name_of(element, report, role, where)
        if joint is not None and joint not in joints:
            report.add("M603", element, where, f"{joint!r} is no joint")
        elif joint is not None:
            carried.append(joint)
    wanted = ("radius", "other_radius") if element.tag == GEAR else ("radius",)
    sizes = [number(element, size, report, where) for size in wanted]
    angle = number(element, "pressure_angle", report, where, default=radians(20))
    point = numbers(element, "point", 3, report, where, default=(0.0, 0.0, 0.0))
    internal = element.attributes.get("internal", "false")
    if internal not in _GRIPS:
        expected = f"expected internal true or false, got {internal!r}"
        report.add("M602", element, where, expected)
        return None
    if name is None or len(carried) < 2 or None in sizes or angle is None or point is None:
        return None
    wheel, mate = carried
    try:
        if element.tag == RACK:
            free = names.free(name)
            return Rack(free, wheel, mate, sizes[0], point=point, pressure_angle=angle)
        return Gear(
            names.free(name),
            wheel,
            mate,
            sizes[0],
            other_radius=sizes[1],
            internal=_GRIPS[internal],
            pressure_angle=angle,
        )
    except InputError as error:
        report.add("M602", element, where, str(error))
        return None


def read_cord(
    element: Element, links: Collection[str], names: Names, report: Report
) -> Cord | None:
    """Return the cord that an element of our own describes; None if faults were reported."""
    name = name_of(element, report)
    where = f"cord {name!r}"
    first, *over, last = element.children or [element]
    if (
        len(element.children) < 2
        or {first.tag, last.tag} != {_END}
        or any(child.tag != _PULLEY for child in over)
    ):
        expected = f"expected <{_END}>, any number of <{_PULLEY}>, <{_END}>"
        report.add("M602", element, where, expected)
        return None
    stops = _read_stops(element, links, report, where)
    plane = _read_plane(element, links, report, where)
    if name is None or plane is None or stops is None:
        return None
    start, *pulleys, end = stops
    try:
        ends = (start.body, start.center), (end.body, end.center)
        return Cord(names.free(name), ends[0], tuple(pulleys), ends[1], *plane)
    except InputError as error:
        report.add("M602", element, where, str(error))
        return None


def read_belt(
    element: Element, links: Collection[str], names: Names, report: Report
) -> Belt | None:
    """Return the belt that an element of our own describes; None if faults were reported."""
    name = name_of(element, report)
    where = f"belt {name!r}"
    if any(child.tag != _PULLEY for child in element.children):
        report.add("M602", element, where, f"expected <{_PULLEY}> only")
        return None
    pulleys = _read_stops(element, links, report, where)
    plane = _read_plane(element, links, report, where)
    given = "preload" in element.attributes
    preload = number(element, "preload", report, where) if given else None
    if name is None or plane is None or pulleys is None or (given and preload is None):
        return None
    try:
        return Belt(names.free(name), tuple(pulleys), preload, *plane)
    except InputError as error:
        report.add("M602", element, where, str(error))
        return None


def _read_stops(
    element: Element, links: Collection[str], report: Report, where: str
) -> list[Pulley] | None:
    """The pulleys and ends of a cord or belt, an end as a pulley without a radius."""
    stops: list[Pulley] = []
    for child in element.children:
        link = name_of(child, report, "link", where)
        xyz = numbers(child, "xyz", 3, report, where, default=(0.0, 0.0, 0.0))
        wheel = _wheel(child, report, where) if child.tag == _PULLEY else (0.0, 1, True)
        if link is not None and link not in links:
            report.add("M603", child, where, f"{link!r} is no link")
        elif link is not None and xyz is not None and wheel is not None:
            radius, sense, grips = wheel
            center = (xyz[0], xyz[1], xyz[2])
            stops.append(Pulley(link, radius, sense, center=center, grips=grips))
    return stops if len(stops) == len(element.children) else None


def _read_plane(
    element: Element, links: Collection[str], report: Report, where: str
) -> tuple[Triple, str] | None:
    """The normal of a cord or belt, and the body in whose axes it is."""
    normal = numbers(element, "normal", 3, report, where, default=(0.0, -1.0, 0.0))
    axes = element.attributes.get("axes", "world")
    if "axes" in element.attributes and axes not in links:
        report.add("M603", element, where, f"{axes!r} is no link")
        return None
    return None if normal is None else ((normal[0], normal[1], normal[2]), axes)


def _wheel(element: Element, report: Report, where: str) -> tuple[float, int, bool] | None:
    """Radius, sense and grip of a pulley."""
    radius = number(element, "radius", report, where, default=0.0)
    sense = element.attributes.get("sense", "1")
    grips = element.attributes.get("grips", "true")
    for what, given, known in (("sense", sense, _SENSES), ("grips", grips, _GRIPS)):
        if given not in known:
            expected = f"expected {what} {' or '.join(known)}, got {given!r}"
            report.add("M602", element, where, expected)
    if radius is None or sense not in _SENSES or grips not in _GRIPS:
        return None
    return radius, _SENSES[sense], _GRIPS[grips]
