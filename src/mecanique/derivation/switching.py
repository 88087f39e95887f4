"""Equations of a mechanism with elements that switch: those of each mode, and when it holds.

The elements' forces enter Lagrange's equations as loads of unknown size, M a + h = Q + Jᵀ R: their
coefficients are the rows J that a mode may hold. In a mode each element gives one equation for each
of its forces: J a + γ = 0 where it sticks or is closed, R = −μ N where it slips, R = 0 where it is
open.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from html import escape
from itertools import product
from math import prod
from typing import Any, final

import numpy as np

from mecanique.derivation.methods import derive
from mecanique.derivation.printing.expressions import from_sympy
from mecanique.derivation.printing.formulas import MOVING, SUMS, open_sum
from mecanique.derivation.printing.prose import to_html
from mecanique.derivation.printing.writers import MathML, Text, Writer, to_lines, write
from mecanique.errors import DerivationError
from mecanique.model.constraints.friction import Contact, Friction, Stop, Switching
from mecanique.model.expression import Scalar, coordinate, plain
from mecanique.model.forces import Force, JointForce, Torque
from mecanique.model.joint_base import Single
from mecanique.model.joints import Fixed
from mecanique.model.mechanism import Mechanism
from mecanique.model.parameters import Input
from mecanique.wording import Legible, say_count

MOST_MODES = 81
"""So many modes at most are written out."""

READABLE = 16
"""So many modes at most are written out where no one has asked for them."""

LONGEST_FRACTION = 1_000_000
"""Largest denominator of a fraction; those of binary numbers are longer."""

MOST_SIMPLIFIED = 30
"""Operations of a formula up to which sympy's `simplify` is tried, whose time grows without end."""

_UNDETERMINED = "its forces are not determined by rigid bodies"


@final
@dataclass(frozen=True)
class ModeEquations:
    """The equations of one mode.

    Args:
        states: the state of each element, by name.
        accelerations: each solved for, a sympy expression by name, e.g. "x''"; empty if the mode
            does not determine them.
        forces: those of the elements, likewise: friction, and normal forces.
        conditions: when it holds, in words and formulas.
        places: the sort key of each letter in a product.
    """

    states: dict[str, str]
    accelerations: dict[str, Any]
    forces: dict[str, Any]
    conditions: tuple[str, ...]
    places: Mapping[str, tuple[float, float]] = field(repr=False, compare=False)

    @property
    def title(self) -> str:
        """The state of each element in words, e.g. "belt slips +"."""
        return ", ".join(f"{name} {state}" for name, state in self.states.items())

    def __str__(self) -> str:
        lines = [f"{self.title}:", *(f"  {line}" for line in self.write(Text()))]
        if not self.accelerations:
            lines.append(f"  {_UNDETERMINED}")
        lines += [f"  {condition}" for condition in self.conditions]
        return "\n".join(lines)

    def write(self, writer: Writer) -> list[str]:
        """Write its accelerations and forces in the format of a writer."""
        return [
            writer.equation(writer.letter(name, False, ""), _write(value, self.places, writer))
            for name, value in (self.accelerations | self.forces).items()
        ]


@final
@dataclass(frozen=True, repr=False)
class Modes(Legible):
    """The modes of a mechanism with elements that switch; its text lists them.

    Args:
        mechanism: whose they are.
        modes: each with its equations.
    """

    mechanism: Mechanism
    modes: tuple[ModeEquations, ...]

    def __getitem__(self, states: str | tuple[str, ...]) -> ModeEquations:
        asked = (states,) if isinstance(states, str) else states
        for mode in self.modes:
            if tuple(mode.states.values()) == asked:
                return mode
        known = "; ".join(", ".join(mode.states.values()) for mode in self.modes)
        raise DerivationError(f"expected the states of a mode, {known}; got {', '.join(asked)}")

    def __str__(self) -> str:
        return "\n".join(map(str, self.modes))

    def _repr_html_(self) -> str:
        shown = []
        for mode in self.modes:
            names = {*mode.places, *mode.forces}
            shown.append(f"<h4>{escape(mode.title)}</h4>")
            shown += map(to_lines, mode.write(MathML()), mode.write(Text()))
            if not mode.accelerations:
                shown.append(f"<p>{escape(_UNDETERMINED)}</p>")
            shown += [f"<p>{to_html(condition, names)}</p>" for condition in mode.conditions]
        return "\n".join(shown)

    @property
    def _caption(self) -> str:
        return f"{self.mechanism.name}: {say_count(len(self.modes), 'mode')}"


@dataclass(frozen=True)
class _ElementForces:
    """The unknown forces of an element, by symbol: normal first if it has one."""

    element: Switching
    normal: Any
    tangent: Any
    gap: Scalar = 0.0  # of a row of joints that presses
    drift: Scalar = 0.0  # of that row when nothing moves but what time moves
    speed: Scalar = 0.0  # what the rate of slip lacks, likewise
    sideways: Any = None  # a force across the tangent, which must not matter in a plane


def force_symbol(letter: str, element: str) -> str:
    """Return the symbol of a force of an element, N, T or R with its name."""
    return f"{letter}_{re.sub(r'[^0-9a-zA-Z]', '_', element)}"


def list_letters(element: Switching) -> tuple[str, ...]:
    """Return the letters of an element's forces, N first if it presses."""
    if isinstance(element, Contact):
        return ("N", "T") if element.rubs else ("N",)
    return tuple(row.letter for row in element.joint_rows)


def derive_modes(mechanism: Mechanism, most: int = MOST_MODES) -> Modes:
    """Derive the equations of every mode of a mechanism with elements that switch.

    Args:
        mechanism: a tree with `Friction`, `Stop` or `Contact` among its `switching` elements;
            contacts with planes of the ground, those with friction in plane motion.
        most: so many modes are written out at most; each may take seconds.

    Returns:
        The modes, each with its accelerations, the forces of the elements and its conditions.

    Raises:
        DerivationError: if an element is not treated, or there are too many modes.

    Example:
        >>> from dataclasses import replace
        >>> mu, N = mq.Parameter("mu", 0.2), mq.Parameter("N", 5.0, "N")
        >>> block = mq.textbook.load("two_blocks")
        >>> dry = mq.Friction("dry", block.joints[0].name, mu, N)
        >>> parameters = (*block.parameters, mu, N)
        >>> dry_block = replace(block, parameters=parameters, switching=(dry,))
        >>> print(mq.derive_modes(dry_block)["slips +"].conditions[0])
        while q1' > 0
    """
    from sympy import Matrix, Symbol, diff, simplify, sympify

    loaded, unknown = _load(mechanism)
    equations = derive(loaded)
    M, h, Q = equations.M, equations.h, equations.Q
    symbols = [s for forces in unknown for s in (forces.normal, forces.tangent) if s is not None]
    slopes = {symbol: Q.diff(symbol) for symbol in symbols}
    sideways = [f.sideways for f in unknown if f.sideways is not None]
    rest = Q.subs(dict.fromkeys([*symbols, *sideways], 0))
    for forces in unknown:
        if (
            forces.sideways is not None
            and not Q.diff(forces.sideways).applyfunc(simplify).is_zero_matrix
        ):
            raise DerivationError(
                f"contact {forces.element.name!r} slips along two directions; the equations of its "
                "modes are written out for motion in a plane alone"
            )
    velocities = [Symbol(name) for name in mechanism.velocities]
    accelerations = [Symbol(f"{name}'") for name in mechanism.velocities]
    balance = M * Matrix(accelerations) + h - rest
    for symbol in symbols:
        balance -= slopes[symbol] * symbol

    def rate(symbol: Any, speed: Scalar) -> Any:
        return (slopes[symbol].T * Matrix(velocities))[0] - speed

    def hold(symbol: Any, speed: Scalar) -> Any:
        """J a + γ of the row of a force."""
        moving = rate(symbol, speed)
        held = (slopes[symbol].T * Matrix(accelerations))[0] + diff(moving, Symbol("t"))
        for name in mechanism.coordinates:
            held += diff(moving, Symbol(name)) * Symbol(f"{name}'")
        return held

    choices = [_list_states(forces) for forces in unknown]
    count = prod(len(states) for states in choices)
    if count > most:
        raise DerivationError(
            f"mechanism {mechanism.name!r} has {count} modes, more than {most}; expected "
            "fewer elements that switch"
        )
    modes: list[ModeEquations] = []
    places = _place_letters(mechanism)
    for states in product(*choices):
        laws = list(balance)
        for forces, state in zip(unknown, states, strict=True):
            laws += _constrain(forces, state, hold)
        solution = _solve(laws, [*accelerations, *symbols])
        conditions: list[str] = []
        for forces, state in zip(unknown, states, strict=True):
            conditions += _say_conditions(forces, state, solution, rate, places)
        pairs = zip(mechanism.velocities, accelerations, strict=True)
        named = {f"{name}'": solution.get(s) for name, s in pairs}
        modes.append(
            ModeEquations(
                {forces.element.name: state for forces, state in zip(unknown, states, strict=True)},
                {name: value for name, value in named.items() if value is not None},
                {str(s): solution[s] for s in symbols if sympify(solution.get(s, 0)) != 0},
                tuple(conditions),
                places,
            )
        )
    return Modes(mechanism, tuple(modes))


def _load(mechanism: Mechanism) -> tuple[Mechanism, list[_ElementForces]]:
    """Return the smooth mechanism with the elements' forces as inputs, and these."""
    from sympy import Rational, Symbol, diff, sympify

    if mechanism.loops or mechanism.contacts or mechanism.velocity_constraints:
        raise DerivationError(
            f"mechanism {mechanism.name!r} has constraints that hold in every mode; the equations "
            "of its modes are written out for trees alone"
        )
    driven = mechanism.coordinates.driven
    guided = any(Symbol("t") in sympify(place).free_symbols for place in driven.values())

    inputs, forces = list(mechanism.inputs), list(mechanism.forces)
    unknown: list[_ElementForces] = []

    def add(letter: str, element: Switching, unit: str) -> Any:
        symbol = force_symbol(letter, element.name)
        inputs.append(Input(symbol, 0.0, unit, f"force of {element.name}"))
        return Symbol(symbol)

    for element in mechanism.switching:
        if isinstance(element, Contact):
            if (
                element.closed.curved
                or element.axis is not None
                or not _is_fixed(mechanism, element.on)
            ):
                raise DerivationError(
                    f"contact {element.name!r} is not with a plane of the ground; the equations of "
                    "its modes are not written out yet"
                )
            if guided:
                raise DerivationError(
                    f"contact {element.name!r}: the coordinate map depends on time, so its body "
                    "may move by itself; the equations of such modes are not written out yet"
                )
            x, y, n = zip(*element.plane.rotation, strict=True)
            normal = add("N", element, "N")
            tangent = add("T", element, "N") if element.rubs else None
            sideways = add("Y", element, "N") if element.rubs else None
            cx, cy, cz = element.center
            pull = [entry * normal for entry in n]
            for direction, force in ((x, tangent), (y, sideways)):
                if force is not None:
                    pull = [a + b * force for a, b in zip(pull, direction, strict=True)]
            lever = [-element.radius * component for component in n]
            turn = (
                lever[1] * pull[2] - lever[2] * pull[1],
                lever[2] * pull[0] - lever[0] * pull[2],
                lever[0] * pull[1] - lever[1] * pull[0],
            )
            name = element.name
            axes = "world" if element.on == mechanism.ground else element.on
            forces.append(Force(f"{name}, force", element.body, (cx, cy, cz), tuple(pull), axes))
            if element.radius != 0:
                forces.append(Torque(f"{name}, moment", element.body, turn, axes))
            unknown.append(_ElementForces(element, normal, tangent, sideways=sideways))
            continue
        in_joints = _ElementForces(element, None, None)
        pulls: dict[str, Any] = {}
        for row in element.joint_rows:
            place: Any = row.offset or 0
            joints = [mechanism.joint(name) for name, _ in row.weights]
            turns = any(isinstance(joint, Single) and joint.turns for joint in joints)
            force = add(row.letter, element, "N·m" if turns else "N")
            for name, weight in row.weights:
                factor = Rational(weight)  # of letters that are exact, no decimals come
                joint = mechanism.joint(name)
                assert isinstance(joint, Single), "validated"
                place += factor * driven.get(joint.coordinate, coordinate(joint.coordinate))
                pulls[name] = pulls.get(name, 0) + factor * force
            drift = diff(place, Symbol("t"))
            if row.offset is None:
                in_joints = replace(in_joints, tangent=force, speed=row.speed - drift)
            else:
                in_joints = replace(in_joints, normal=force, gap=place, drift=-drift)
        for name, pull in pulls.items():
            label = element.name if len(pulls) == 1 else f"{element.name} on {name}"
            forces.append(JointForce(label, name, pull))
        unknown.append(in_joints)
    loaded = replace(mechanism, switching=(), inputs=tuple(inputs), forces=tuple(forces))
    return loaded, unknown


def _is_fixed(mechanism: Mechanism, body: str) -> bool:
    """Return whether a body is the ground or welded to it."""
    above = {joint.child: joint for joint in mechanism.joints}
    while body in above and isinstance(above[body], Fixed):
        body = above[body].parent
    return body == mechanism.ground


def _list_states(forces: _ElementForces) -> list[str]:
    states = [] if forces.normal is None else ["open"]
    if forces.tangent is None:
        return [*states, "closed"]
    return [*states, "sticks", "slips +", "slips -"]


def _constrain(forces: _ElementForces, state: str, hold: Any) -> Iterator[Any]:
    """Yield what an element's state says of its forces."""
    element, normal, tangent = forces.element, forces.normal, forces.tangent
    if state == "open":
        yield normal
        if tangent is not None:
            yield tangent
        return
    if normal is not None:
        if isinstance(element, Stop) and element.stiffness is not None:
            yield normal + element.stiffness * forces.gap
        else:
            yield hold(normal, forces.drift)
    if tangent is None:
        return
    if state == "sticks":
        yield hold(tangent, forces.speed)
    else:
        sign = 1 if state == "slips +" else -1
        yield tangent + sign * element.coefficients[0] * _find_load(element)


def _find_load(element: Switching) -> Any:
    """Return the force that friction goes by: the symbol of what presses, 1 if none is named."""
    from sympy import Symbol

    by = element.pressed_by
    return 1 if by is None else Symbol(force_symbol("N", by))


def _solve(laws: list[Any], unknowns: list[Any]) -> dict[Any, Any]:
    """Return the unknowns; none where they are not determined."""
    from sympy import (
        Dummy,
        Float,
        Function,
        Matrix,
        Rational,
        cos,
        expand_trig,
        linear_eq_to_matrix,
        sin,
    )
    from sympy.polys.matrices import DomainMatrix

    matrix, right = linear_eq_to_matrix(laws, unknowns)
    if _is_singular(matrix):
        return {}
    whole = Matrix.hstack(matrix, right)
    if any(call.args[0].is_Add for call in whole.atoms(sin, cos)):
        whole = whole.applyfunc(expand_trig)
    # sines and cosines as letters of their own, and decimals as fractions: sympy has quick exact
    # arithmetic for fractions of polynomials in letters alone
    calls = {call: Dummy() for call in whole.atoms(Function)}
    decimals = {number: Rational(str(number)) for number in whole.atoms(Float)}
    exact = DomainMatrix.from_Matrix(whole.xreplace(calls).xreplace(decimals)).to_field()
    values = exact[:, :-1].lu_solve(exact[:, -1:]).to_Matrix()
    back = {letter: call.xreplace(decimals) for call, letter in calls.items()}
    solved = [_shorten(value.xreplace(back)) for value in values]
    solved = [_write_decimals(value, everywhere=bool(decimals)) for value in solved]
    return dict(zip(unknowns, solved, strict=True))


def _write_decimals(value: Any, *, everywhere: bool) -> Any:
    """Return a formula with its fractions as decimals, or those alone that no one would write."""
    from sympy import Float, Rational

    fractions = [number for number in value.atoms(Rational) if not number.is_integer]
    if not everywhere:
        fractions = [number for number in fractions if number.q > LONGEST_FRACTION]
    return value.xreplace({number: Float(number) for number in fractions})


def _is_singular(matrix: Any) -> bool:
    """Return whether a matrix of formulas has no inverse, by its rank at a state of no meaning."""
    letters = sorted(matrix.free_symbols, key=str)
    values = np.random.default_rng(0).uniform(0.5, 1.5, len(letters)).tolist()
    numbers = matrix.subs(dict(zip(letters, values, strict=True))).evalf()
    return bool(np.linalg.matrix_rank(np.array(numbers.tolist(), dtype=float)) < numbers.rows)


def _shorten(value: Any) -> Any:
    """Return a formula in factors, short by sin² + cos² = 1."""
    from sympy import cos, factor, factor_list, fraction, rem, simplify, sin, together

    def shorten_factor(part: Any) -> Any:
        for angle in sorted({call.args[0] for call in part.atoms(sin, cos)}, key=str):
            c, s = cos(angle), sin(angle)
            s = -s if s.could_extract_minus_sign() else s  # sympy's sin(−u) is −sin(u)
            ways = [part, *(factor(rem(part, s**2 + c**2 - 1, letter)) for letter in (s, c))]
            part = min(ways, key=_length)
        return part

    parts = []
    for side in fraction(together(value)):
        number, factors = factor_list(side)
        parts.append(number * prod(shorten_factor(part) ** power for part, power in factors))
    short = factor(parts[0] / parts[1])
    if short.count_ops() > MOST_SIMPLIFIED:
        return short
    simplified = factor(simplify(short))
    return simplified if 4 * simplified.count_ops() <= 3 * short.count_ops() else short


def _length(formula: Any) -> tuple[int, int, str]:
    """Return by what formulas of one value are ordered, whatever their sign: the shortest first."""
    signed = formula, -formula
    operations = min(side.count_ops() for side in signed)
    return operations, min(str(side).count("-") for side in signed), str(formula)


def _say_conditions(
    forces: _ElementForces,
    state: str,
    solution: dict[Any, Any],
    rate: Any,
    places: Mapping[str, tuple[float, float]],
) -> Iterator[str]:
    """Yield when an element is in a state."""

    def say(value: Any) -> str:
        return _write(value, places, Text())

    normal, tangent, element = forces.normal, forces.tangent, forces.element
    if state == "open":
        yield f"while {element.name} is apart"
        return
    if normal is not None and normal in solution:
        pressed = solution[normal]
        if pressed.is_number and pressed < 0:
            yield f"never, as {normal} would be {say(pressed)}"
        else:
            least = -element.holds if isinstance(element, Stop) else 0
            yield f"while {say(pressed)} ≥ {say(plain(least))}"
    if tangent is None:
        return
    if state != "sticks":
        sign = ">" if state == "slips +" else "<"
        yield f"while {say(_shorten(rate(tangent, forces.speed)))} {sign} 0"
    elif tangent in solution:
        load, limit = _find_load(element), element.coefficients[1]
        load = solution.get(load, load)
        if isinstance(element, Friction):
            limit = element.mu_static
            load = load if element.pressed_by else element.load
        if load == 0:
            yield f"sticks if {say(solution[tangent])} = 0"
            return
        ratio = _shorten(solution[tangent] / load)
        if ratio == 0:
            yield "sticks always, as no friction is needed"
            return
        if ratio.could_extract_minus_sign():
            ratio = -ratio
        yield f"sticks if |{say(ratio)}| ≤ {say(limit)}"


def _place_letters(mechanism: Mechanism) -> dict[str, tuple[float, float]]:
    """Return the sort key of each letter in a product: parameters, coordinates, velocities."""
    kinds = (
        (0, [parameter.symbol for parameter in mechanism.parameters]),
        (SUMS + 5, mechanism.coordinates.names),
        (MOVING, mechanism.velocities),
    )
    return {name: (kind, k) for kind, names in kinds for k, name in enumerate(names)}


def _write(value: Any, places: Mapping[str, tuple[float, float]], writer: Writer) -> str:
    """Write a sympy expression in the format of a writer."""
    from sympy import Float, sympify

    value = sympify(value)
    return write(open_sum(from_sympy(value, places)), writer, decimals=bool(value.atoms(Float)))
