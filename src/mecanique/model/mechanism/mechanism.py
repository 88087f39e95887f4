"""A mechanism: bodies, joints, forces and coordinates, frozen and sound."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, fields
from typing import Any, final

from mecanique.errors import MecaniqueError, MechanismError
from mecanique.model.coordinates import Coordinates
from mecanique.model.expression import Scalar, coordinate, plain, symbols_in
from mecanique.model.mechanism.element_laws import laws_of_elements
from mecanique.model.mechanism.state_space import StateSpace
from mecanique.model.mechanism.validation import faults
from mecanique.model.mechanism.variants import Variants
from mecanique.model.placement import vector
from mecanique.notebook import draw
from mecanique.wording import say_count


@final
@dataclass(frozen=True)
class Mechanism(StateSpace, Variants):
    """A mechanism described once; what can be built is sound.

    Args:
        name: its name, as robot name in URDF.
        bodies: all bodies, the ground included.
        joints: a tree from the ground to every other body.
        forces: springs, dampers and loads.
        loops: closures between bodies of the tree.
        parameters: every parameter the expressions use.
        inputs: every named signal the expressions use.
        coordinates: generalized coordinates and their map; the joints' own by default.
        gravity: shape (3,), acceleration of free fall in world axes [m/s²].
        ground: name of the body that is fixed in the inertial frame; its frame is the world's.
        velocity_constraints: linear constraints on velocities in general.
        contacts: wheels, disks and balls that roll, and blades.
        elements: cords and other elements that hold bodies on the coordinate map, with their
            forces; a `Loop` among them is one that the map closes. Where the map leaves open what
            gears, racks and cords along slides tie, they add it.
        origin: the text it was read from, if it was; equality does not depend on it.
        about: what it is and where it comes from, in lines of text; stands above its equations.

    Raises:
        MechanismError: with every fault found.

    Example:
        >>> m, l = mq.Parameter("m", 2.0, "kg"), mq.Parameter("l", 1.2, "m")
        >>> g = mq.Parameter("g", 9.81, "m/s²")
        >>> bodies = mq.Body("ground"), mq.Body("rod", mq.rod(m, l))
        >>> hinge = mq.Revolute("hinge", "ground", "rod", axis=(0, -1, 0), coordinate="q")
        >>> pendulum = mq.Mechanism(
        ...     "pendulum", bodies, (hinge,), parameters=(m, l, g), gravity=(0, 0, -g)
        ... )
        >>> print(mq.derive(pendulum))
        q'' + 3 g sin(q)/(2 l) = 0
    """

    def __post_init__(self) -> None:
        for name in (
            "bodies",
            "joints",
            "forces",
            "loops",
            "parameters",
            "inputs",
            "velocity_constraints",
            "contacts",
            "elements",
        ):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        object.__setattr__(self, "gravity", vector(self.gravity, "gravity"))
        driven = self._collect_driven()
        free = [name for joint in self.joints for name in joint.coordinates if name not in driven]
        names = (
            *self.coordinates.names,
            *(name for name in free if name not in self.coordinates.names),
        )
        object.__setattr__(
            self, "coordinates", Coordinates(names, tuple(driven.items()), self.coordinates.limits)
        )
        found = faults(self)
        if found:
            raise MechanismError(self.name, found)

    def _collect_driven(self) -> dict[str, Scalar]:
        """The coordinate map, and what follows within joints: of what is driven there, too."""
        driven = dict(self.coordinates.driven)
        for joint in self.joints:
            for name, law in joint.followers.items():
                leaders = symbols_in(law) & driven.keys()
                law = plain(law.subs({coordinate(k): driven[k] for k in leaders}))
                if plain(driven.get(name, law)) != law:
                    raise MechanismError(
                        self.name,
                        [
                            f"the coordinate map sets {name!r}, but within joint {joint.name!r} it "
                            f"follows as {name} = {law}; leave {name!r} out of the map"
                        ],
                    )
                driven[name] = law
        # what is not sound has no laws; its faults are told
        with suppress(MecaniqueError, ArithmeticError, LookupError, TypeError):
            driven |= laws_of_elements(self, driven) if self.elements else {}
        return driven

    def __repr__(self) -> str:
        names = [*self.coordinates[:12], *(["…"] if self.nq > 12 else [])]
        return (
            f"<Mechanism {self.name!r}: {say_count(len(self.bodies), 'body', 'bodies')}, "
            f"{say_count(len(self.joints), 'joint')}, {say_count(len(self.forces), 'force')}, "
            f"q = ({', '.join(names)})>"
        )

    def _repr_html_(self) -> str | None:
        """The figure of the mechanism in a notebook, if pictures can be drawn."""
        return draw("mechanism", self)

    def __getstate__(self) -> dict[str, Any]:
        return {f.name: getattr(self, f.name) for f in fields(self)}
