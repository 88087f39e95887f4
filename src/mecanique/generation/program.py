"""A program in the form that languages need: inputs by kind, and quantities by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

from mecanique.derivation.mechanics.switching import ElementRows
from mecanique.errors import InputError, UnknownNameError
from mecanique.model.constraints.friction import Switching
from mecanique.model.mechanism import Mechanism
from mecanique.program.tape import Counts, Tape, Value, count


@final
@dataclass(frozen=True)
class Output:
    """A quantity that a program can compute."""

    name: str  # name of its function
    symbol: str  # letter of its value
    takes: tuple[str, ...]  # its arguments among t, y, q, v, a and tau; y is q followed by v
    meaning: str  # its meaning, in a few words
    constrained: bool = False  # whether only mechanisms with loops or other constraints have it
    by: str = ""  # for a derivative, the variable: y, q, v, a, tau or p
    base: str = ""  # for a derivative, the name of the differentiated quantity
    mode: tuple[tuple[str, str], ...] = ()  # the state of each element that switches, by name
    struck: bool = False  # whether it is an impact in that state


QUANTITIES = {
    quantity.name: quantity
    for quantity in (
        Output("rhs", "dy", ("t", "y", "tau"), "rates of q, then of v"),
        Output("acceleration", "a", ("t", "q", "v", "tau"), "generalized accelerations"),
        Output("mass_matrix", "M", ("t", "q"), "mass matrix, row by row"),
        Output("bias", "h", ("t", "q", "v"), "Coriolis and centrifugal terms, and gravity"),
        Output("gravity", "g", ("t", "q"), "gravity's part of the bias"),
        Output(
            "forces", "Q", ("t", "q", "v"), "generalized forces of springs, dampers, drives, loads"
        ),
        Output(
            "inverse_dynamics",
            "tau",
            ("t", "q", "v", "a"),
            "tau for accelerations a: M a + bias - forces, so beyond what springs, dampers, drives "
            "and loads exert",
        ),
        Output("energy", "E", ("t", "q", "v"), "kinetic energy, potential energy [J]"),
        Output("poses", "H", ("t", "q"), "rows of rotation and position of each body, 3 by 4"),
        Output(
            "jacobians",
            "J",
            ("t", "q"),
            "Jacobian of each body: velocity of its origin, angular velocity, world axes, 6 by nv",
        ),
        Output(
            "reactions",
            "R",
            ("t", "q", "v", "tau"),
            "force and moment on the child of each joint at its origin, then of loops; "
            "tau acts in the joints and is not part of them",
        ),
        Output(
            "multipliers",
            "lambda",
            ("t", "q", "v", "tau"),
            "multipliers of the constraints",
            constrained=True,
        ),
        Output(
            "closure",
            "Phi",
            ("t", "q", "v"),
            "gaps Phi of the constraints, then their rates",
            constrained=True,
        ),
    )
}
"""The quantities by name."""


BY = {
    "q": "coordinates, along the motion of each velocity",
    "v": "velocities",
    "y": "coordinates, along the motion of each velocity, and velocities",
    "a": "accelerations",
    "tau": "torques",
    "p": "parameters",
}
"""The variables by which quantities can be differentiated."""


def derivative(name: str) -> Output | None:
    """Return the derivative with a name like "acceleration_by_q", None for other names."""
    base, separator, by = name.rpartition("_by_")
    quantity = QUANTITIES.get(base)
    if not separator or quantity is None or by not in BY:
        return None
    state = {"y", *quantity.takes} if {"q", "v"} <= set(quantity.takes) else set(quantity.takes)
    state |= {"q", "v"} if "y" in quantity.takes else set()
    if by != "p" and by not in state:
        return None
    meaning = f"derivatives of {base} by {BY[by]}, row by row"
    return Output(
        name, f"d{quantity.symbol}", quantity.takes, meaning, quantity.constrained, by, base
    )


def choose(what: str | Sequence[str], mechanism: Mechanism) -> tuple[Output, ...]:
    """Return quantities by name."""
    names = [name.strip() for name in what.split(",")] if isinstance(what, str) else list(what)
    constrained = mechanism.constrained
    known = [
        name for name, quantity in QUANTITIES.items() if constrained or not quantity.constrained
    ]
    chosen = []
    for name in names:
        quantity = QUANTITIES.get(name) or derivative(name)
        if quantity is None:
            raise UnknownNameError("quantity", name, known)
        if constrained and quantity.by not in ("", "a", "tau"):
            raise InputError(
                f"expected no {_list_constraints(mechanism)} for {name!r}: the states next to one "
                "that keeps them do not"
            )
        if quantity.constrained and not constrained:
            raise InputError(
                f"expected a mechanism with loops, contacts or velocity constraints for {name!r}; "
                "this one has none"
            )
        chosen.append(quantity)
    if not names or len(set(names)) < len(names):
        raise InputError(f"expected names of quantities, each once, got {what!r}")
    return tuple(chosen)


def _list_constraints(mechanism: Mechanism) -> str:
    """Return the kinds of constraints that a mechanism has, e.g. "loops or contacts"."""
    kinds = {
        "loops": mechanism.loops,
        "contacts": mechanism.contacts,
        "velocity constraints": mechanism.velocity_constraints,
    }
    return " or ".join(kind for kind, constraints in kinds.items() if constraints)


@final
@dataclass(frozen=True)
class ProgramInput:
    """An input of a program."""

    name: str
    place: str  # its name on the tape
    unit: str = ""  # its SI unit; "" if it is unknown
    meaning: str = ""  # its meaning, in a few words
    value: float = 0.0


@final
@dataclass(frozen=True)
class Answer:
    """A named output of a program."""

    quantity: Output
    values: tuple[Value, ...]  # its entries, row by row
    shape: tuple[int, ...]  # its shape


@final
@dataclass(frozen=True)
class LoopProjection:
    """The correction that projects a nearby state on the loops."""

    changes: tuple[Value, ...]  # changes of q, then of v, to first order, shape (nq + nv,)
    firmness: Value  # measure of regularity, zero in singular positions
    gaps: tuple[Value, ...]  # gap of each equation of the loops


@final
@dataclass(frozen=True)
class SwitchingTerms:
    """What decides which mode follows in a state."""

    elements: tuple[ElementRows, ...]
    positional: tuple[bool, ...]  # whether each row is the rate of a gap
    length: float  # a characteristic length [m]
    values: tuple[Value, ...]  # as `SwitchingEquations.list_terms` gives them
    impacts: Mapping[int, tuple[Value, ...]]  # of elements struck: `SwitchingEquations.bounce`


@final
@dataclass(frozen=True)
class Program:
    """A straight-line program."""

    mechanism: Mechanism  # the mechanism whose equations it computes
    name: str  # stem of its functions' names
    origin: str  # how the equations were obtained
    tape: Tape  # the operations, each different one once
    letters: dict[str, tuple[ProgramInput, ...]]  # the inputs by kind: t, q, v, a, tau and p
    answers: tuple[Answer, ...]  # the outputs
    # for programs to be integrated, the default initial state, shape (nq + nv,)
    start: tuple[float, ...] = ()
    # for closed mechanisms to be integrated, the correction that keeps loops closed
    landing: LoopProjection | None = None
    switching: tuple[Switching, ...] = ()  # the elements whose modes it computes
    # for programs to be integrated, what decides which mode of these follows
    corners: SwitchingTerms | None = None

    @property
    def parameters(self) -> tuple[ProgramInput, ...]:
        """The parameters and signals that are inputs."""
        return self.letters["p"]

    def count(self, quantity: str | None = None) -> Counts:
        """Return the number of operations of one output, or of all together."""
        chosen = [a for a in self.answers if quantity in (None, a.quantity.name)]
        return count(self.tape, [value for answer in chosen for value in answer.values])
