"""Elements that switch in URDF: tags of our own, which other programs ignore.

    <mecanique:friction name="dry" joint="slide" mu="0.2" mu_static="0.25" load="9.81" speed="0"/>
    <mecanique:stop name="wall" joint="slide" at="1" side="1" restitution="0.5"/>
    <mecanique:stop name="buffer" joint="slide" at="-1" side="-1" stiffness="500"/>
    <mecanique:capstan name="drum" joint="up" other="down" length="2" wrap="3.14159" mu="0.3"/>
    <mecanique:contact name="floor" link="ball" on="ground" radius="0.1" mu="0.3" restitution="0.8"
        center="0 0 0" plane_xyz="0 0 0" plane_rpy="0 0 0" law="newton" in_turn="false"/>

They say what `mecanique.model.constraints.friction` says, by attributes of the same names.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from mecanique.errors import InputError, UrdfError
from mecanique.model.constraints.friction import Capstan, Contact, Friction, Stop, Switching
from mecanique.model.expression import symbols_in
from mecanique.model.mechanism import Mechanism
from mecanique.model.placement import Placement, vector
from mecanique.urdf.dialect import CAPSTAN, CONTACT, FRICTION, STOP
from mecanique.urdf.findings import Report
from mecanique.urdf.markup import Element, Tag
from mecanique.urdf.markup import number as write_number
from mecanique.urdf.markup import numbers as write_numbers
from mecanique.urdf.names import Names
from mecanique.urdf.reading.fields import name_of, number, numbers

_TYPES: Mapping[str, type[Switching]] = {
    FRICTION: Friction,
    STOP: Stop,
    CAPSTAN: Capstan,
    CONTACT: Contact,
}
_TAGS = {kind: tag for tag, kind in _TYPES.items()}

_NUMBERS = {
    FRICTION: ("mu", "mu_static", "load", "speed"),
    STOP: ("at", "restitution", "stiffness", "holds"),
    CAPSTAN: ("length", "wrap", "mu", "mu_static", "speed", "restitution"),
    CONTACT: ("radius", "bowl", "mu", "mu_static", "restitution"),
}
"""Attributes that are numbers; one that is left out has its default."""

_VECTORS = {FRICTION: (), STOP: (), CAPSTAN: (), CONTACT: ("center", "axis")}

_IN_TURN = {"false": False, "true": True}

_WORDS: Mapping[str, Mapping[str, Mapping[str, Any]]] = {
    FRICTION: {},
    CAPSTAN: {},
    STOP: {"side": {"1": 1, "-1": -1}, "in_turn": _IN_TURN},
    CONTACT: {
        "law": {"newton": "newton", "poisson": "poisson"},
        "in_turn": _IN_TURN,
    },
}
"""Attributes that are words, and what each means."""

_PLANE = ("plane_xyz", "plane_rpy")

_ENDS = {
    FRICTION: ("joint",),
    STOP: ("joint",),
    CAPSTAN: ("joint", "other"),
    CONTACT: ("link", "on"),
}
"""Attributes that name joints or links."""


def words_of(tag: str) -> set[str]:
    """Return the attributes of a tag."""
    ends = {*_ENDS[tag], *(_PLANE if tag == CONTACT else ())}
    return {"name", *ends, *_NUMBERS[tag], *_VECTORS[tag], *_WORDS[tag]}


def switching_tag(mechanism: Mechanism, element: Switching, anchors: Mapping[str, str]) -> Tag:
    """Return the tag of an element that switches."""
    tag = _TAGS[type(element)]
    where = f"{tag.partition(':')[2]} {element.name!r}"
    if isinstance(element, Contact):
        body, on = (anchors.get(end, end) for end in element.bodies)
        attributes = {"name": element.name, "link": body, "on": on}
        for attribute, triple in zip(_PLANE, (element.plane.xyz, element.plane.rpy), strict=True):
            attributes[attribute] = write_numbers(mechanism.evaluate_all(triple), where)
    else:
        attributes = {"name": element.name}
        attributes |= {attribute: getattr(element, attribute) for attribute in _ENDS[tag]}
    for attribute in _NUMBERS[tag]:
        scalar = getattr(element, attribute)
        if scalar is None:
            continue
        if isinstance(scalar, str):
            attributes[attribute] = scalar
            continue
        varying = sorted(symbols_in(scalar) - mechanism.values.keys())
        if varying:
            raise UrdfError(
                f"{where}: its {attribute} depends on {', '.join(varying)}, and URDF holds numbers"
            )
        attributes[attribute] = write_number(mechanism.evaluate(scalar), where)
    for attribute in _VECTORS[tag]:
        triple = getattr(element, attribute)
        if triple is not None:
            attributes[attribute] = write_numbers(mechanism.evaluate_all(triple), where)
    for attribute, meanings in _WORDS[tag].items():
        value = getattr(element, attribute)
        attributes[attribute] = next(word for word, what in meanings.items() if what == value)
    return Tag(tag, **attributes)


def read_switching(
    element: Element,
    links: Collection[str],
    joints: Collection[str],
    names: Names,
    report: Report,
) -> Switching | None:
    """Return the element that switches which a tag describes; None if faults were reported."""
    tag, name = element.tag, name_of(element, report)
    where = f"{tag.partition(':')[2]} {name!r}"
    ends = dict.fromkeys(_ENDS[tag], links if tag == CONTACT else joints)
    fields: dict[str, Any] = {}
    sound = name is not None
    for attribute, known in ends.items():
        end = name_of(element, report, attribute, where)
        if end is not None and end not in known:
            kind = "link" if tag == CONTACT else "joint"
            report.add("M603", element, where, f"{end!r} is no {kind}")
            end = None
        sound &= end is not None
        fields["body" if attribute == "link" else attribute] = end
    for attribute, meanings in _WORDS[tag].items():
        word = element.attributes.get(attribute, next(iter(meanings)))
        if word not in meanings:
            expected = f"expected {attribute} {' or '.join(meanings)}, got {word[:60]!r}"
            report.add("M602", element, where, expected)
            return None
        fields[attribute] = meanings[word]
    counts = {**dict.fromkeys(_NUMBERS[tag], 1), **dict.fromkeys(_VECTORS[tag], 3)}
    if tag == CONTACT:
        counts |= dict.fromkeys(_PLANE, 3)
    for attribute in counts.keys() & element.attributes.keys():
        text = element.attributes[attribute].strip()
        if attribute == "load" and text[:1].isalpha():  # what presses, by its name
            fields[attribute] = text
        elif counts[attribute] == 1:
            fields[attribute] = number(element, attribute, report, where)
        else:
            fields[attribute] = numbers(element, attribute, 3, report, where)
        sound &= fields[attribute] is not None
    if name is None or not sound:
        return None
    if tag == CONTACT:
        xyz, rpy = (fields.pop(attribute, (0.0, 0.0, 0.0)) for attribute in _PLANE)
        fields["plane"] = Placement(vector(xyz, _PLANE[0]), vector(rpy, _PLANE[1]))
    try:
        return _TYPES[tag](names.free(name), **fields)
    except InputError as error:
        report.add("M602", element, where, str(error))
        return None
