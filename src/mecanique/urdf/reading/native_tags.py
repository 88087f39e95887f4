"""Elements of mecanique's namespace: one table of tags for writer, reader and linter.

    <mecanique:loop name="C" type="pin">
      <mecanique:frame_a link="coupler" xyz="2.2 0 0" rpy="0 0 0"/>
      <mecanique:frame_b link="rocker" xyz="1.7 0 0" rpy="0 0 0"/>
    </mecanique:loop>

    <mecanique:rolling name="rim" link="disk" on="ground" radius="0.3" crown="0"
        axis="0 1 0" center="0 0 0" plane_xyz="0 0 0" plane_rpy="0 0 0"/>
    <mecanique:rolling name="below" link="stone" on="ground" radius="0.2" stretch="1 0.15 0.1"/>
    <mecanique:rolling name="inside" link="ball" on="ground" radius="0.05" bowl="0.6"/>
    <mecanique:blade name="edge" link="sleigh" on="ground"
        point="0 0 0" along="1 0 0" normal="0 0 1"/>

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

    <mecanique:velocity_constraint name="edge" rate="0">
      <mecanique:term joint="slide_x" coefficient="sin(turn)"/>
      <mecanique:term joint="slide_y" coefficient="-cos(turn)"/>
    </mecanique:velocity_constraint>

    <mecanique:friction name="dry" joint="slide" mu="0.2" mu_static="0.25" load="9.81" speed="0"/>
    <mecanique:stop name="wall" joint="slide" at="1" side="1" restitution="0.5"/>
    <mecanique:stop name="buffer" joint="slide" at="-1" side="-1" stiffness="500"/>
    <mecanique:capstan name="drum" joint="up" other="down" length="2" wrap="3.14159" mu="0.3"/>
    <mecanique:contact name="floor" link="ball" on="ground" radius="0.1" mu="0.3" restitution="0.8"
        center="0 0 0" plane_xyz="0 0 0" plane_rpy="0 0 0" law="newton" in_turn="false"/>
    <mecanique:contact name="top" link="ball" on="ground" radius="0.1" length="2"/>

    <mecanique:potential name="well" joint="slide" potential="-q**2 + 2*q**4"/>
    <mecanique:central_force name="sun" link_a="ground" point_a="0 0 0" link_b="planet"
        point_b="0 0 0" potential="-10/distance"/>
    <mecanique:potential_field name="trap" link="ball" point="0 0 0" potential="3*position_x**2"/>

Each states what its class in `mecanique.model` does, by attributes called after the fields. Other
programs ignore them: they see open trees, wheels that slip, and joints that mimic one another.

A velocity constraint is Σ coefficient × velocity = rate over joints with one coordinate;
coefficients and rate are expressions in the joints' positions, by the joints' names, and in time t.
In the potential of a joint, q is the joint's coordinate; in that of a central force, distance is
the distance of the two points; in a potential field, position_x, position_y and position_z are the
point's coordinates in the world. A loop that mimic joints close already has `redundant="true"`.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields, replace
from functools import cached_property
from operator import attrgetter
from typing import Any, Literal, TypeAlias, final

from mecanique.errors import InputError, UrdfError
from mecanique.model.constraints.contacts import Blade, Rolling
from mecanique.model.constraints.cords import Belt, Cord, Pulley
from mecanique.model.constraints.friction import Capstan, Contact, Friction, Stop
from mecanique.model.constraints.gears import Gear, Rack
from mecanique.model.constraints.loops import CLOSED, Loop
from mecanique.model.constraints.velocity_constraints import VelocityConstraint
from mecanique.model.expression import DISTANCE, FUNCTIONS, POSITION, Scalar, symbols_in
from mecanique.model.forces import CentralForce, Potential, PotentialField
from mecanique.model.joint_base import Single
from mecanique.model.joints import Joint
from mecanique.model.mechanism import Mechanism
from mecanique.model.placement import Placement
from mecanique.urdf.dialect import IN_DRAKE
from mecanique.urdf.findings import Report
from mecanique.urdf.markup import Comment, Element, Node, Tag
from mecanique.urdf.markup import number as write_number
from mecanique.urdf.markup import numbers as write_numbers
from mecanique.urdf.names import Names
from mecanique.urdf.reading.expressions import read_expression, rename, write_expression
from mecanique.urdf.reading.fields import Passage

Holds: TypeAlias = Literal["number", "load", "vector", "word", "joint", "link", "expression"]
"""What an attribute holds; a load is a number or the name of what presses."""

Triple: TypeAlias = tuple[Scalar, Scalar, Scalar]

_JOINT_LETTER = "q"
"""What a potential calls the coordinate of its joint; of several, q1, q2 and so on."""

_LETTERS: Mapping[type[Any], str] = {
    Potential: f"the letters {_JOINT_LETTER} and t",
    CentralForce: f"the letters {DISTANCE} and t",
    PotentialField: f"the letters {', '.join(POSITION)} and t",
}
"""What an expression may be in, by the class that has it."""

_FALSE: Mapping[str, Any] = {"false": False, "true": True}
_TRUE: Mapping[str, Any] = {"true": True, "false": False}
_SIDES: Mapping[str, Any] = {"1": 1, "-1": -1}
_ORIGIN = (0.0, 0.0, 0.0)


@final
@dataclass(frozen=True)
class Attribute:
    """What an attribute holds, wherever it stands, and the field of the class that it states."""

    holds: Holds = "number"
    path: str = ""  # "plane.xyz" for a part of a placement; by default the attribute's name
    words: Mapping[str, Any] | None = None  # what each word means; None for any words


_VOCABULARY: Mapping[str, Attribute] = {
    **dict.fromkeys(("joint", "other", "wheel"), Attribute("joint")),
    **dict.fromkeys(("on", "axes"), Attribute("link")),
    "link": Attribute("link", "body"),
    "link_a": Attribute("link", "body_a"),
    "link_b": Attribute("link", "body_b"),
    **dict.fromkeys(("along", "axis", "center", "normal", "rpy"), Attribute("vector")),
    **dict.fromkeys(("point", "point_a", "point_b", "stretch"), Attribute("vector")),
    "xyz": Attribute("vector", "center"),
    "plane_xyz": Attribute("vector", "plane.xyz"),
    "plane_rpy": Attribute("vector", "plane.rpy"),
    **dict.fromkeys(("side", "sense"), Attribute("word", words=_SIDES)),
    **dict.fromkeys(("grips", "internal"), Attribute("word", words=_TRUE)),
    **dict.fromkeys(("in_turn", "redundant"), Attribute("word", words=_FALSE)),
    "law": Attribute("word", words={"newton": "newton", "poisson": "poisson"}),
    "type": Attribute("word", "kind"),
    "load": Attribute("load"),
    **dict.fromkeys(("coefficient", "potential", "rate"), Attribute("expression")),
}
"""What attributes hold that are no plain numbers."""


@final
@dataclass(frozen=True)
class NativeTag:
    """An element of mecanique's namespace: its attributes in the order they are written."""

    tag: str
    type: type[Any]
    home: str  # the field of a mechanism that holds it
    words: str  # its attributes beside the name
    children: tuple[str, ...] = ()
    called: str = ""  # in messages; by default the word of its tag
    needed: tuple[str, ...] = ()  # attributes, although their fields have defaults
    tacit: tuple[str, ...] = ()  # attributes that are not written where they are the default

    @property
    def attributes(self) -> dict[str, Attribute]:
        """Its attributes by name."""
        return {name: _VOCABULARY.get(name, Attribute()) for name in self.words.split()}

    @cached_property
    def defaults(self) -> dict[str, Any]:
        """What each field of the class is by default, MISSING where it must be stated."""
        return {part.name: part.default for part in fields(self.type)}

    def needs(self, name: str, attribute: Attribute) -> bool:
        """Return whether an attribute must be there."""
        ends = attribute.holds in ("joint", "link") and name not in self.tacit
        field = (attribute.path or name).partition(".")[0]
        return ends or name in self.needed or self.defaults.get(field) is MISSING

    def where(self, name: object) -> str:
        """Return how messages name one."""
        return f"{self.called or self.tag.partition(':')[2]} {name!r}"


_END, _PULLEY, _TERM = "mecanique:end", "mecanique:pulley", "mecanique:term"
_FRAMES = ("mecanique:frame_a", "mecanique:frame_b")


@final
@dataclass(frozen=True)
class _Term:
    """A term of a velocity constraint."""

    joint: str
    coefficient: Scalar


@final
@dataclass(frozen=True)
class _Frame:
    """A frame of a loop."""

    body: str
    center: Triple = _ORIGIN
    rpy: Triple = _ORIGIN


_CHILDREN = (
    NativeTag(_END, Pulley, "", "link xyz"),
    NativeTag(_PULLEY, Pulley, "", "link xyz radius sense grips"),
    NativeTag(_TERM, _Term, "", "joint coefficient"),
    NativeTag(_FRAMES[0], _Frame, "", "link xyz rpy"),
    NativeTag(_FRAMES[1], _Frame, "", "link xyz rpy"),
)

CHILDREN: Mapping[str, NativeTag] = {child.tag: child for child in _CHILDREN}
"""The elements inside those of `NATIVE_TAGS`, by tag."""

_TABLE = (
    NativeTag("mecanique:loop", Loop, "loops", "type redundant length", _FRAMES),
    NativeTag(
        "mecanique:rolling",
        Rolling,
        "contacts",
        "link on radius crown axis center plane_xyz plane_rpy stretch bowl friction",
        called="contact",
        tacit=("stretch", "bowl"),
    ),
    NativeTag(
        "mecanique:blade",
        Blade,
        "contacts",
        "link on point along normal",
        called="contact",
        needed=("along", "normal"),
    ),
    NativeTag("mecanique:cord", Cord, "elements", "normal axes", (_END, _PULLEY), tacit=("axes",)),
    NativeTag(
        "mecanique:belt", Belt, "elements", "normal axes preload", (_PULLEY,), tacit=("axes",)
    ),
    NativeTag(
        "mecanique:gear",
        Gear,
        "elements",
        "wheel other radius other_radius internal pressure_angle",
    ),
    NativeTag("mecanique:rack", Rack, "elements", "wheel other radius point pressure_angle"),
    NativeTag(
        "mecanique:velocity_constraint",
        VelocityConstraint,
        "velocity_constraints",
        "rate",
        (_TERM,),
        called="velocity constraint",
    ),
    NativeTag("mecanique:friction", Friction, "switching", "joint mu mu_static load speed"),
    NativeTag(
        "mecanique:stop", Stop, "switching", "joint at restitution stiffness holds side in_turn"
    ),
    NativeTag(
        "mecanique:capstan",
        Capstan,
        "switching",
        "joint other length wrap mu mu_static speed restitution",
    ),
    NativeTag(
        "mecanique:contact",
        Contact,
        "switching",
        "link on plane_xyz plane_rpy radius bowl length mu mu_static restitution center axis law "
        "in_turn",
        tacit=("length",),
    ),
    NativeTag("mecanique:potential", Potential, "forces", "joint potential", called="force"),
    NativeTag(
        "mecanique:central_force",
        CentralForce,
        "forces",
        "link_a point_a link_b point_b potential",
        called="force",
    ),
    NativeTag(
        "mecanique:potential_field",
        PotentialField,
        "forces",
        "link point potential",
        called="force",
    ),
)

NATIVE_TAGS: Mapping[str, NativeTag] = {kind.tag: kind for kind in _TABLE}
"""Every element of mecanique's namespace below robot, by its tag."""

_KINDS = {kind.type: kind for kind in _TABLE}


def write_native(
    mechanism: Mechanism, thing: Any, anchors: Mapping[str, str], *, redundant: bool = False
) -> Iterator[Node]:
    """Yield the element of a thing that neither URDF nor Drake has a tag for, with its remarks."""
    # `anchors`: links at which it ends instead of others; `redundant`: whether mimic joints close a
    # loop already
    kind = _KINDS[type(thing)]
    writer = _Writer(mechanism, anchors, kind.where(thing.name))
    match thing:
        case VelocityConstraint():
            yield writer.constraint(kind, thing)
            return
        case Loop():
            yield Comment(
                f"{thing.kind} loop {thing.name}, which mecanique reads; "
                "no tag of Drake is the same"
            )
            yield writer.loop(kind, thing, redundant=redundant)
            return
        case Cord() | Belt() | Gear() | Rack():
            what = f"{type(thing).__name__.lower()} {thing.name}"
            yield Comment(f"{what}, which mecanique reads; others see its mimic joints")
    inside = []
    if isinstance(thing, Cord | Belt):
        stops = [(_PULLEY, pulley) for pulley in thing.over]
        if isinstance(thing, Cord):
            first, *last = [thing.start, *([thing.end] if thing.end else [])]
            ends = [(_END, Pulley(body, center=at)) for body, at in (first, *last)]
            stops = [ends[0], *stops, *ends[1:]]
        inside = [Tag(tag, **writer.states(CHILDREN[tag], stop)) for tag, stop in stops]
    yield Tag(kind.tag, *inside, name=thing.name, **writer.states(kind, thing))


@final
@dataclass(frozen=True)
class _Writer:
    """Writes the attributes of one thing and of what stands inside its element."""

    mechanism: Mechanism
    anchors: Mapping[str, str]
    where: str

    def states(self, kind: NativeTag, thing: Any) -> dict[str, str]:
        """Return the attributes of a thing as text."""
        states = {}
        for name, attribute in kind.attributes.items():
            path = attribute.path or name
            value = attrgetter(path)(thing)
            tacit = name in kind.tacit and value == kind.defaults[path]
            # a ball has neither
            tacit = tacit or (name == "crown" and thing.axis is None)
            if value is not None and not tacit:
                states[name] = self._text(thing, name, attribute, value)
        return states

    def _text(self, thing: Any, name: str, attribute: Attribute, value: Any) -> str:
        match attribute.holds:
            case "joint":
                return value if isinstance(value, str) else " ".join(value)
            case "link":
                return self.anchors.get(value, value)
            case "vector":
                return write_numbers(self.mechanism.evaluate_all(value), self.where)
            case "word":
                return next(
                    word for word, meant in (attribute.words or {}).items() if meant == value
                )
            case "expression":
                letters = dict[str, str]()
                if isinstance(thing, Potential):
                    joints = map(self.mechanism.joint, thing.joints)
                    names = (joint.coordinates[-1] for joint in joints)
                    letters = dict(zip(names, _letters(thing), strict=True))
                return write_expression(rename(value, letters, self.mechanism.values))
            case "load" if isinstance(value, str):
                return value
        varying = sorted(symbols_in(value) - self.mechanism.values.keys())
        if varying:
            raise UrdfError(
                f"{self.where}: its {name} depends on {', '.join(varying)}, and URDF holds numbers"
            )
        return write_number(self.mechanism.evaluate(value), self.where)

    def loop(self, kind: NativeTag, loop: Loop, *, redundant: bool) -> Tag:
        """Return the element of a loop."""
        ends = (loop.body_a, loop.frame_a), (loop.body_b, loop.frame_b)
        frames = (_Frame(body, place.xyz, place.rpy) for body, place in ends)
        inside = [
            Tag(tag, **self.states(CHILDREN[tag], frame))
            for tag, frame in zip(_FRAMES, frames, strict=True)
        ]
        more = {"redundant": "true"} if redundant else {}
        if redundant and loop.kind == "distance":
            more["length"] = write_number(self.mechanism.evaluate(loop.length), self.where)
        return Tag(kind.tag, *inside, name=loop.name, type=loop.kind, **more)

    def constraint(self, kind: NativeTag, constraint: VelocityConstraint) -> Node:
        """Return the element of a constraint, or a comment where it is none of single joints."""
        mechanism = self.mechanism
        owners = {
            joint.coordinate: joint.name
            for joint in mechanism.joints
            if isinstance(joint, Single) and joint.coordinate not in mechanism.coordinates.driven
        }
        terms = {name.removesuffix("'"): factor for name, factor in constraint.terms.items()}
        used = {symbol for scalar in constraint.scalars for symbol in symbols_in(scalar)}
        used -= {*mechanism.values, "t"}
        spoken = [owners.get(name, "") for name in {*terms, *used}]
        if not all(name.isidentifier() and name not in (*FUNCTIONS, "t") for name in spoken):
            return Comment(
                f"velocity constraint {constraint.name}: URDF has no tag for it, as it is one of "
                "coordinates that are none of single joints"
            )

        def text(scalar: Scalar) -> str:
            return write_expression(rename(scalar, owners, mechanism.values))

        inside = [
            Tag(_TERM, joint=owners[name], coefficient=text(factor))
            for name, factor in terms.items()
        ]
        return Tag(kind.tag, *inside, name=constraint.name, rate=text(constraint.rate))


def read_native(
    element: Element,
    links: Collection[str],
    joints: Collection[str],
    names: Names,
    report: Report,
) -> Any:
    """Return what an element of mecanique's namespace describes; None if faults were reported."""
    kind, name = NATIVE_TAGS[element.tag], Passage(element, report).name()
    text = Passage(element, report, kind.where(name))
    reader = _Reader(links, joints)
    stated, inside = reader.read(text, kind), reader.read_inside(text, kind)
    if name is None or stated is None or inside is None:
        return None
    if kind.type is Cord and element.children[-1].tag == _PULLEY:
        stated["end"] = None  # it is wound on the last pulley
    try:
        return _make(kind.type, names.free(name), stated, inside)
    except InputError as error:
        text.fault("M602", str(error))
        return None


def _make(
    type_: type[Any], name: str, stated: dict[str, Any], inside: Sequence[dict[str, Any]]
) -> Any:
    """Make a thing of what its element and those inside state."""
    if type_ is Loop:
        a, b = (_Frame(**frame) for frame in inside)
        stated.pop("redundant", None)
        return Loop(
            name,
            body_a=a.body,
            frame_a=Placement(a.center, a.rpy),
            body_b=b.body,
            frame_b=Placement(b.center, b.rpy),
            **stated,
        )
    if type_ is VelocityConstraint:
        terms = [_Term(**term) for term in inside]
        return VelocityConstraint(name, tuple((x.joint, x.coefficient) for x in terms), **stated)
    stops = tuple(Pulley(**stop) for stop in inside)
    if type_ is Cord:
        first, *over = stops
        if "end" not in stated:
            last = over.pop()
            stated["end"] = (last.body, last.center)
        return Cord(name, (first.body, first.center), tuple(over), **stated)
    return Belt(name, stops, **stated) if type_ is Belt else type_(name, **stated)


@final
@dataclass(frozen=True)
class _Reader:
    """Reads the attributes of one element and of those inside; faults are reported."""

    links: Collection[str]
    joints: Collection[str]

    def read(self, text: Passage, kind: NativeTag) -> dict[str, Any] | None:
        """Return the fields that an element states; None if faults were reported."""
        stated: dict[str, Any] = {}
        sound, ends = True, []
        for name, attribute in kind.attributes.items():
            if name not in text.element.attributes and not kind.needs(name, attribute):
                continue
            value = stated[attribute.path or name] = self._value(text, kind, name, attribute)
            sound = sound and value is not None
            ends += [value] if attribute.holds == "link" else []
        if kind.type is Rolling:
            stated.setdefault("axis", None)  # a ball; the default of the class is a wheel
        sound = sound and not _meets_itself(text, ends)
        for part in ("plane.xyz", "plane.rpy"):
            if part in stated:
                whole, _, of = part.partition(".")
                angle_or_place = {of: stated.pop(part) or _ORIGIN}
                stated[whole] = replace(stated.get(whole, Placement()), **angle_or_place)
        return stated if sound else None

    def _value(self, text: Passage, kind: NativeTag, name: str, attribute: Attribute) -> Any:
        """Return what an attribute holds; None if it is at fault."""
        given = text.element.attributes.get(name, "").strip()
        match attribute.holds:
            case "joint" | "link":
                known = self.links if attribute.holds == "link" else self.joints
                ends: list[str | None] = [*given.split()] if kind.type is Potential else []
                ends = ends if len(ends) > 1 else [text.name(name)]
                lost = [end for end in ends if end is not None and end not in known]
                for end in lost:
                    text.fault("M603", f"{end!r} is no {attribute.holds}")
                if lost:
                    return None
                return tuple(ends) if len(ends) > 1 else ends[0]
            case "vector":
                return text.numbers(name, 3)
            case "expression":
                letters = _LETTERS.get(kind.type, "names of joints and t")
                return read_expression(text, name, letters)
            case "word":
                words = attribute.words or {given: given}
                if given not in words:
                    expected = f"expected {name} {' or '.join(words)}"
                    text.fault("M602", f"{expected}, got {given[:60]!r}")
                    return None
                return words[given]
            case "load" if given[:1].isalpha():
                return given
        return text.number(name)

    def read_inside(self, text: Passage, kind: NativeTag) -> list[dict[str, Any]] | None:
        """Return the fields that the elements inside state; None if faults were reported."""
        inside = [text.at(child) for child in text.element.children] if kind.children else []
        tags = [child.element.tag for child in inside]
        fault = ""
        if kind.type is Loop:
            frames = [text.only(tag) for tag in kind.children]
            inside = [frame for frame in frames if frame is not None]
            for tag in {*kind.children} - {frame.element.tag for frame in inside}:
                text.fault("M602", f"it has no <{tag}>")
            redundant = is_redundant(text.element)
            kinds = [name for name in CLOSED if redundant or name not in IN_DRAKE]
            if (given := text.element.attributes.get("type", "")) not in kinds:
                fault = f"expected a type among {', '.join(kinds)}, got {given!r}"
        elif kind.type is Cord:
            wheels = [_PULLEY] * (len(tags) - 2)
            if len(tags) < 2 or tags not in ([_END, *wheels, _END], [_END, *wheels, _PULLEY]):
                fault = (
                    f"expected <{_END}>, any number of <{_PULLEY}>, and <{_END}> unless the last "
                    "pulley is a drum"
                )
        elif {*tags} - {*kind.children}:
            fault = f"expected <{kind.children[0]}> only"
        if fault:
            text.fault("M602", fault)
            return None
        read = [self.read(child, CHILDREN[child.element.tag]) for child in inside]
        stated = [fields for fields in read if fields is not None]
        if kind.type is Loop and _meets_itself(text, [end["body"] for end in stated]):
            return None
        complete = len(kind.children) if kind.type is Loop else len(inside)
        return stated if len(stated) == complete else None


def _meets_itself(text: Passage, ends: Sequence[str]) -> bool:
    """Report two ends on one link."""
    same = len(ends) == 2 and ends[0] == ends[1]
    if same:
        text.fault("M603", f"both of its ends are on link {ends[0]!r}")
    return same


def is_redundant(element: Element) -> bool:
    """Return whether mimic joints close a loop already, as its element says."""
    return element.attributes.get("redundant") == "true"


def in_coordinates(thing: Any, joints: Mapping[str, Joint]) -> Any:
    """Return what was read in the names of joints, or in q, in the coordinates of the joints."""
    last = {name: joint.coordinates[-1] for name, joint in joints.items() if joint.coordinates}
    match thing:
        case VelocityConstraint():
            terms = {last.get(name, name): rename(x, last) for name, x in thing.terms.items()}
            return VelocityConstraint(thing.name, terms, rename(thing.rate, last))
        case Potential() if {*thing.joints} <= last.keys():
            names = (last[joint] for joint in thing.joints)
            letters = dict(zip(_letters(thing), names, strict=True))
            return replace(thing, potential=rename(thing.potential, letters))
    return thing


def _letters(potential: Potential) -> list[str]:
    """Return what a potential's tag calls the coordinates of its joints."""
    n = len(potential.joints)
    return [_JOINT_LETTER] if n == 1 else [f"{_JOINT_LETTER}{k + 1}" for k in range(n)]
