"""Wheels, balls and blades in URDF: elements of our own, which other programs ignore.

    <mecanique:rolling name="rim" link="disk" on="ground" radius="0.3" crown="0"
        center="0 0 0" axis="0 1 0" plane_xyz="0 0 0" plane_rpy="0 0 0"/>
    <mecanique:rolling name="below" link="stone" on="ground" radius="0.2" stretch="1 0.15 0.1"/>
    <mecanique:rolling name="inside" link="ball" on="ground" radius="0.05" bowl="0.6"/>
    <mecanique:blade name="edge" link="sleigh" on="ground"
        point="0 0 0" along="1 0 0" normal="0 0 1"/>

They say what `mecanique.model.constraints.contacts` says; a ball has no axis and no crown.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Any

from mecanique.errors import InputError
from mecanique.model.constraints.contacts import Blade, Contact, Rolling
from mecanique.model.expression import Scalar
from mecanique.model.mechanism import Mechanism
from mecanique.model.placement import Placement, vector
from mecanique.urdf.dialect import BLADE, ROLLING
from mecanique.urdf.findings import Report
from mecanique.urdf.markup import Element, Tag
from mecanique.urdf.markup import number as write_number
from mecanique.urdf.markup import numbers as write_numbers
from mecanique.urdf.names import Names
from mecanique.urdf.reading.fields import name_of, number, numbers

_NONE = (0.0, 0.0, 0.0)
_ONES = (1.0, 1.0, 1.0)


def contact_tag(mechanism: Mechanism, contact: Contact, anchors: Mapping[str, str]) -> Tag:
    """Return the element of a contact."""
    where = f"contact {contact.name!r}"

    def text(components: Iterable[Scalar]) -> str:
        return write_numbers([mechanism.evaluate(c) for c in components], where)

    ends = {
        "name": contact.name,
        "link": anchors.get(contact.body, contact.body),
        "on": anchors.get(contact.on, contact.on),
    }
    if isinstance(contact, Blade):
        shape = {
            "point": text(contact.point),
            "along": text(contact.along),
            "normal": text(contact.normal),
        }
        return Tag(BLADE, **ends, **shape)
    shape = {"radius": write_number(mechanism.evaluate(contact.radius), where)}
    if contact.axis is not None:
        shape["crown"] = write_number(mechanism.evaluate(contact.crown), where)
        shape["axis"] = text(contact.axis)
    shape["center"] = text(contact.center)
    shape["plane_xyz"], shape["plane_rpy"] = text(contact.plane.xyz), text(contact.plane.rpy)
    if contact.stretched:
        shape["stretch"] = text(contact.stretch)
    if contact.curved:
        shape["bowl"] = write_number(mechanism.evaluate(contact.bowl), where)
    if contact.friction is not None:
        shape["friction"] = write_number(mechanism.evaluate(contact.friction), where)
    return Tag(ROLLING, **ends, **shape)


def read_contact(
    element: Element, links: Collection[str], names: Names, report: Report
) -> Contact | None:
    """Return the contact that an element describes; None if faults were reported."""
    name = name_of(element, report)
    where = f"contact {name!r}"
    ends = [name_of(element, report, attribute, where) for attribute in ("link", "on")]
    for end in ends:
        if end is not None and end not in links:
            report.add("M603", element, where, f"{end!r} is no link")
            return None
    body, on = ends
    shape = (
        _read_blade(element, report, where)
        if element.tag == BLADE
        else _read_rolling(element, report, where)
    )
    if name is None or body is None or on is None or shape is None:
        return None
    if body == on:
        report.add("M603", element, where, f"both of its ends are on link {body!r}")
        return None
    try:
        if element.tag == BLADE:
            return Blade(names.free(name), body, on=on, **shape)
        return Rolling(names.free(name), body, on=on, **shape)
    except InputError as error:
        report.add("M602", element, where, str(error))
        return None


def _read_blade(element: Element, report: Report, where: str) -> dict[str, Any] | None:
    point = numbers(element, "point", 3, report, where, default=_NONE)
    along = numbers(element, "along", 3, report, where)
    normal = numbers(element, "normal", 3, report, where)
    if point is None or along is None or normal is None:
        return None
    return {"point": point, "along": along, "normal": normal}


def _read_rolling(element: Element, report: Report, where: str) -> dict[str, Any] | None:
    radius = number(element, "radius", report, where)
    center, xyz, rpy = (
        numbers(element, attribute, 3, report, where, default=_NONE)
        for attribute in ("center", "plane_xyz", "plane_rpy")
    )
    if radius is None or center is None or xyz is None or rpy is None:
        return None
    plane = Placement(vector(xyz, "plane_xyz"), vector(rpy, "plane_rpy"))
    fields: dict[str, Any] = {"radius": radius, "center": center, "plane": plane}
    if "friction" in element.attributes:
        fields["friction"] = number(element, "friction", report, where)
        if fields["friction"] is None:
            return None
    if "axis" not in element.attributes:
        stretch = numbers(element, "stretch", 3, report, where, default=_ONES)
        bowl = number(element, "bowl", report, where, default=0.0)
        if stretch is None or bowl is None:
            return None
        return {**fields, "axis": None, "stretch": stretch, "bowl": bowl}
    axis = numbers(element, "axis", 3, report, where)
    crown = number(element, "crown", report, where, default=0.0)
    return None if axis is None or crown is None else {**fields, "axis": axis, "crown": crown}
