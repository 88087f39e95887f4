"""Coulomb friction, stops, impacts: the rows of what switches, and what holds in a mode.

In a mode M a = load + Σ w λ with J a = wanted in the rows it holds: w is Jᵀ of the row, and of the
normal of a contact that slips J_nᵀ − μ Σ d J_tᵀ, d being the direction of slip. Of accelerations
wanted is −γ; of an impact a is the change of velocities, λ are impulses, and wanted is −(1 + e)
times the rate of a gap. Scalars are numbers, values on a tape, or arrays over states, whose axis
comes first: `terms.gaps.T[row]` is the gap of a row in any of them.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeAlias, final

import numpy as np
import numpy.typing as npt

from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.tolerances import ALIGNED, CLOSED_GAP, FRICTIONLESS, REDUNDANT, STILL
from mecanique.errors import InputError
from mecanique.model.constraint_base import GuidingElement, JointRow, PressingContact
from mecanique.model.constraints.friction import Contact, Switching
from mecanique.model.expression import Scalar, coordinate, symbols_in
from mecanique.model.joint_base import Single
from mecanique.model.mechanism import Mechanism

Scalars: TypeAlias = npt.NDArray[Any]
"""Numbers, or values on a tape as an array of objects."""

OPEN, CLOSED, STICKS = "open", "closed", "sticks"
FORWARD, BACKWARD, SLIPS = "slips +", "slips -", "slips"


@final
@dataclass(frozen=True)
class ElementState:
    """The state of one element."""

    name: str  # one of those above
    # of slip along its tangents, of unit length; of what sticks, against which its static friction
    # is all used, as it is where what else is held leaves it no slip
    direction: tuple[Any, ...] = ()
    beginning: bool = False  # slow slip in space, along the direction in which it grows


Mode: TypeAlias = "tuple[ElementState, ...]"


class Terms(NamedTuple):
    """M a = load + Jᵀ λ with J a + γ = 0 in one state, and what the elements have there."""

    mass: Scalars  # shape (…, nv, nv)
    load: Scalars  # shape (…, nv), forces − bias
    jacobian: Scalars  # shape (…, m, nv)
    gamma: Scalars  # shape (…, m)
    gaps: Scalars  # shape (…, m), zero in rows of velocities alone
    rates: Scalars  # shape (…, m), J v + drift
    drift: Scalars  # shape (…, m)
    kinetic: Scalars  # shape (…, elements), μ, or the kinetic force where the load is stated
    static: Scalars  # shape (…, elements), the same of static friction
    inside: Scalars = np.empty(0)  # shape (…, elements), as `find_inside`; none of modes' programs


@final
@dataclass(frozen=True)
class ElementRows:
    """Which rows an element has, and what its laws are."""

    element: Switching | PressingContact | GuidingElement
    normal: int | None  # its row of the gap; None if it only rubs
    tangents: tuple[int, ...]  # its rows along which it rubs
    pressing: int | None = None  # the row whose force its friction goes by
    restitution: Any = 0.0
    stiffness: Any = None  # of an elastic stop
    holds: Any = 0.0  # the pull that a latch keeps
    length: Any = None  # of a side with ends
    edges: tuple[int, ...] = ()  # rows of the sides that it meets in an edge

    @property
    def name(self) -> str:
        """Name of the element."""
        return self.element.name

    @property
    def rows(self) -> tuple[int, ...]:
        """Its rows, the one that presses first."""
        return self.tangents if self.normal is None else (self.normal, *self.tangents)

    @property
    def struck(self) -> bool:
        """Whether it has impacts."""
        return self.normal is not None and self.stiffness is None

    @property
    def by_impulse(self) -> bool:
        """Whether its impacts have Poisson's law of restitution."""
        return getattr(self.element, "law", "newton") == "poisson"

    @property
    def in_turn(self) -> bool:
        """Whether those that approach with it impact one after the other."""
        return bool(getattr(self.element, "in_turn", False))

    @property
    def impacts(self) -> tuple[str, ...]:
        """What an impact by itself may be: in a plane it is known, of no named state.

        In space its friction is asked for.
        """
        return self.states[1:] if len(self.tangents) > 1 else ("",)

    @property
    def states(self) -> tuple[str, ...]:
        """The states it may be in."""
        first = () if self.normal is None else (OPEN,)
        if not self.tangents:
            return (*first, CLOSED)
        return (*first, STICKS, *((FORWARD, BACKWARD) if len(self.tangents) == 1 else (SLIPS,)))


def close_contacts(mechanism: Mechanism) -> Mechanism:
    """Return the mechanism without its elements, in which every contact is closed and sticks."""
    closed = tuple(e.closed for e in mechanism.switching if isinstance(e, Contact))
    return replace(mechanism, switching=(), contacts=(*mechanism.contacts, *closed))


def list_elements(
    mechanism: Mechanism,
    names: Sequence[str],
    evaluate: Callable[[Scalar], Any],
    idle: Collection[int] = (),
) -> tuple[ElementRows, ...]:
    """Return the elements with their rows: those of contacts by name, then those in joints.

    Rows that no motion changes are idle: there is no slip along them.
    """
    elements: list[ElementRows] = []
    first = len(names)
    for element in mechanism.switching:
        if isinstance(element, Contact):
            normal: int | None = names.index(f"{element.name}: normal")
            tangents = [names.index(f"{element.name}: {row}") for row in ("x", "y")]
            tangents = [k for k in tangents if element.rubs and k not in idle]
        else:
            rows = list(enumerate(element.joint_rows, first))
            first += len(rows)
            normal = next((k for k, row in rows if row.offset is not None), None)
            tangents = [k for k, row in rows if row.offset is None]
        stated = {
            name: evaluate(value)
            for name in ("restitution", "stiffness", "holds")
            if (value := getattr(element, name, None)) is not None
        }
        if isinstance(element, Contact) and element.ends:
            stated["length"] = evaluate(element.length)
        elements.append(ElementRows(element, normal, tuple(tangents), **stated))
    normals = {rows.name: rows.normal for rows in elements}
    related: list[ElementRows] = []
    for known in elements:
        by = known.element.pressed_by
        edges = [normals[name] for name in _list_edges(mechanism, known.element)]
        related.append(
            replace(
                known,
                pressing=None if by is None else normals[by],
                edges=tuple(row for row in edges if row is not None),
            )
        )
    return tuple(related)


def _list_edges(mechanism: Mechanism, element: Any) -> Iterator[str]:
    """Yield the sides that a side meets in an edge: of one body, touched by the same point.

    Where they meet is judged at the mechanism's own parameters.
    """
    if not isinstance(element, Contact) or not element.ends:
        return

    def place(side: Contact) -> tuple[Scalars, Scalars]:
        """Return the ends of a side, shape (2, 3), and its normal."""
        turn = np.array([mechanism.evaluate_all(row) for row in side.plane.rotation])
        half = 0.5 * mechanism.evaluate(side.length) * turn[:, 0]
        middle = np.array(mechanism.evaluate_all(side.plane.xyz))
        return np.array([middle - half, middle + half]), turn[:, 2]

    ends, normal = place(element)
    for rival in mechanism.switching:
        if not isinstance(rival, Contact) or not rival.ends:
            continue
        same = (rival.bodies, rival.center, rival.radius)
        if rival is element or same != (element.bodies, element.center, element.radius):
            continue
        theirs, _ = place(rival)
        apart = np.linalg.norm(ends[:, None] - theirs, axis=2)
        near, size = np.unravel_index(apart.argmin(), (2, 2)), apart.max()
        behind = (theirs[1 - near[1]] - ends[near[0]]) @ normal < -ALIGNED * size
        if apart[near] <= CLOSED_GAP * size and behind:
            yield rival.name


def list_holding(mechanism: Mechanism, names: Sequence[str]) -> Iterator[ElementRows]:
    """Yield what holds in every mode, by the names of forces: what rolls, and cords that pull."""
    for contact in mechanism.contacts:
        if isinstance(contact, PressingContact):
            normal, *tangents = (names.index(f"{contact.name}: {row}") for row in contact.rows)
            yield ElementRows(contact, normal, tuple(tangents), pressing=normal)
    for element in mechanism.elements:
        for name in element.tensions:
            yield ElementRows(element, names.index(name), ())


def list_holding_margins(
    mechanism: Mechanism,
    forces: Mapping[str, Any],
    evaluate: Callable[[Scalar], Any],
    length: Callable[..., Any],
) -> list[Any]:
    """Return what rolling contacts and cords have left, in the order of `break_names`.

    They are elements of one state: what rolls sticks, and a cord is closed.
    """
    elements = tuple(list_holding(mechanism, list(forces)))
    mode = tuple(ElementState(rows.states[1]) for rows in elements)
    asked = [getattr(rows.element, "friction", None) for rows in elements]
    static = [0.0 if mu is None else evaluate(mu) for mu in asked]
    limits, apart = (static, [rows.holds for rows in elements]), np.zeros(len(forces))
    pairs = list_margins(elements, mode, (apart, apart), list(forces.values()), limits, length)
    listed = zip(asked, pairs, strict=True)
    return [margin for mu, pair in listed for margin in (pair[:1] if mu is None else pair)]


def as_scalars(scalars: Iterable[Any]) -> Scalars:
    """Return scalars on a tape as an array of objects."""
    return np.array(list(scalars), dtype=object)


def place_of(mechanism: Mechanism, row: JointRow) -> Scalar:
    """Return the gap of a row of joints, or the way that it rubs, in the coordinates."""
    whole: Any = row.offset or 0.0
    for name, weight in row.weights:
        joint = mechanism.joint(name)
        assert isinstance(joint, Single), "validated"
        way = coordinate(joint.coordinate)
        place: Any = mechanism.coordinates.driven.get(joint.coordinate, way)
        for symbol in symbols_in(place):
            if symbol in mechanism.coordinates and f"{symbol}'" not in mechanism.velocities:
                raise InputError(
                    f"joint {name!r} follows {symbol!r}, part of a quaternion, which elements "
                    "that switch do not treat; put them into another joint"
                )
        whole = whole + weight * place
    return whole


def joint_terms(mechanism: Mechanism, letters: Letters) -> Terms:
    """Return the terms of the elements in joints on a tape, without mass and load."""
    rows = [row for element in mechanism.switching for row in element.joint_rows]
    places = [letters.number(place_of(mechanism, row), letters.values) for row in rows]
    speeds = [letters.number(row.speed, letters.values) for row in rows]
    ways = letters.along(places)
    rates = [way - speed for way, speed in zip(ways, speeds, strict=True)]
    by_time = [letters.differentiate(place, letters.t) for place in places]
    coefficients = as_scalars(
        letters.number(scalar, letters.values)
        for element in mechanism.switching
        for scalar in element.coefficients
    )
    kinetic, static = coefficients.reshape(-1, 2).T
    return Terms(
        mass=as_scalars([]),
        load=as_scalars([]),
        jacobian=as_scalars(map(letters.slopes, places, ways)).reshape(-1, mechanism.nv),
        gamma=as_scalars(letters.along(rates)),
        gaps=as_scalars(
            0.0 if row.offset is None else place for row, place in zip(rows, places, strict=True)
        ),
        rates=as_scalars(rates),
        drift=as_scalars(by_t - speed for by_t, speed in zip(by_time, speeds, strict=True)),
        kinetic=kinetic,
        static=static,
    )


def name_mode(
    elements: Sequence[ElementRows], states: Mapping[str, str], along: tuple[Any, ...] = ()
) -> Mode:
    """Return a mode by the name of each element's state, open if it has none.

    What slips in space does so along a direction, in parts along its tangents.
    """
    directions = {FORWARD: (1.0,), BACKWARD: (-1.0,), SLIPS: along}
    named = [states.get(rows.name, OPEN) for rows in elements]
    return tuple(ElementState(name, directions.get(name, ())) for name in named)


def point_slip(
    elements: Sequence[ElementRows], mode: Mode, rates: Scalars, length: Callable[..., Any]
) -> Mode:
    """Return a mode in which what slips in space does so along its slip in the state."""
    pointed = []
    for rows, state in zip(elements, mode, strict=True):
        if state.name == SLIPS and not state.direction:
            slip = [rates.T[row] for row in rows.tangents]
            state = replace(state, direction=tuple(part / length(*slip) for part in slip))
        pointed.append(state)
    return tuple(pointed)


class ModeProblem(NamedTuple):
    """What a mode is solved for: accelerations under loads, or changes of velocities."""

    load: Scalars  # shape (…, nv); zero of an impact
    wanted: Scalars  # shape (…, m), what J a is in a row that is held
    given: Mapping[int, Any]  # normal forces that are known, by row
    sticking: Scalars  # shape (…, elements), the friction that sticks at most, as in `Terms`
    holds: Sequence[Any]  # what each element pulls at most


def accelerate(terms: Terms, elements: Sequence[ElementRows]) -> ModeProblem:
    """Return what the accelerations of a state follow from; elastic stops press by their gaps."""
    elastic = {
        rows.normal: -1.0 * rows.stiffness * terms.gaps.T[rows.normal]
        for rows in elements
        if rows.normal is not None and rows.stiffness is not None
    }
    holds = [rows.holds for rows in elements]
    return ModeProblem(terms.load, -1.0 * terms.gamma, elastic, terms.static, holds)


def bounce(
    terms: Terms,
    elements: Sequence[ElementRows],
    named: tuple[str, str],
    solve: Callable[[Terms, str, ModeProblem], tuple[Scalars, Scalars]],
    functions: tuple[Callable[[Any], Any], Callable[[Any], Any]] = (np.abs, np.sign),
) -> tuple[Scalars, Scalars]:
    """Return the changes of velocities and the impulses of an element's impact by itself."""
    name, friction = named
    (element,) = (rows for rows in elements if rows.name == name)
    normal = element.normal
    assert normal is not None, "it is struck"
    if not friction:
        unit = strike(terms, {}, elements, {normal: 1.0})
        pushes = [
            solve(terms, state, unit)
            for state in ((FORWARD, BACKWARD) if element.tangents else (CLOSED, CLOSED))
        ]
        return _follow_routh(terms, element, pushes, *functions)
    if not element.by_impulse:
        rate = -1.0 * element.restitution * terms.rates.T[normal]
        return solve(terms, friction, strike(terms, {normal: rate}, elements))
    pressed, impulses = solve(terms, friction, strike(terms, {}, elements))
    terms = terms._replace(rates=terms.rates + _along(terms, pressed))
    given = {normal: element.restitution * impulses.T[normal]}
    parted, more = solve(terms, friction, strike(terms, {}, elements, given))
    return pressed + parted, impulses + more


def _along(terms: Terms, a: Scalars) -> Scalars:
    """Return J a."""
    rows: Scalars = (terms.jacobian @ a[..., None])[..., 0]
    return rows


def _follow_routh(
    terms: Terms,
    element: ElementRows,
    pushes: Sequence[tuple[Scalars, Scalars]],
    absolute: Callable[[Any], Any],
    sign: Callable[[Any], Any],
) -> tuple[Scalars, Scalars]:
    """Return changes of velocities and impulses by Routh's diagram, without a branch.

    The normal impulse grows; friction is on its cone against slip until that stops, then on the ray
    of sticking or, if this is outside the cone, on the side of the cone next to it. Compression
    ends as the approach does. Then the approach returns e times (Newton), or the normal impulse
    does (Poisson): E. J. Routh, Dynamics of a System of Rigid Bodies, Elementary Part, ch. IV.
    Where friction jams what Newton's law asks to part, it stays.
    """

    def positive(scalar: Any) -> Any:
        return 0.5 * (scalar + absolute(scalar))

    (ahead, back) = (np.concatenate(push, axis=-1) for push in pushes)
    # by the normal impulse, and by friction of the size of its limit in the positive direction
    mean, half = 0.5 * (ahead + back), 0.5 * (back - ahead)
    nv, normal = terms.load.shape[-1], element.normal
    by_normal, by_friction = (_along(terms, push[..., :nv]).T for push in (mean, half))
    yields, turned = by_normal[normal], by_friction[normal]
    across, rubbed, slip = 0.0, 0.0, 0.0
    for row in element.tangents:
        across, rubbed, slip = by_normal[row], by_friction[row], terms.rates.T[row]
    way, speed = sign(slip), absolute(slip)
    slows, parts = rubbed - way * across, yields - way * turned
    outside = positive(absolute(across) - rubbed)
    ray = -1.0 * across / (rubbed + outside + FRICTIONLESS * yields)
    approach = positive(-1.0 * terms.rates.T[normal])
    gain = approach * (1.0 if element.by_impulse else 1.0 + element.restitution)
    lacks = gain * slows - parts * speed
    rounding = STILL * (absolute(gain * slows) + absolute(parts * speed))
    stops = sign(positive(lacks - rounding)) * sign(approach)
    goes = 1.0 - stops
    # a tape evaluates all cases: the divisor of one that is not taken, which may be zero, is made
    # that of a normal impulse, which never is
    until = stops * speed / (stops * slows + goes * yields)
    later = yields + ray * turned
    frees = sign(positive(later - REDUNDANT * yields))
    press = goes * gain / (goes * parts + stops * yields) + until
    rest = stops * frees * (gain - parts * until)
    press = press + rest / (frees * later + (1.0 - frees) * yields)
    if element.by_impulse:
        press = (1.0 + element.restitution) * press
    excess = positive(press * slows - speed)
    excess = excess / (slows * sign(excess) + yields * (1.0 - sign(excess)))
    rubs = ray * excess - way * (press - excess)
    shares = (np.asarray(share, mean.dtype) for share in (press, rubs))
    whole = sum((part.T * share).T for part, share in zip((mean, half), shares, strict=True))
    return whole[..., :nv], whole[..., nv:]


def strike(
    terms: Terms,
    targets: Mapping[int, Any],
    elements: Sequence[ElementRows],
    given: Mapping[int, Any] | None = None,
) -> ModeProblem:
    """Return what an impact follows from: the rates of rows after it, zero where none is named."""
    wanted = -1.0 * terms.rates
    for row, target in targets.items():
        wanted.T[row] = wanted.T[row] + target
    no_load = np.zeros(terms.load.shape, terms.load.dtype)
    return ModeProblem(no_load, wanted, given or {}, terms.kinetic, [0.0] * len(elements))


class HeldRows(NamedTuple):
    """The rows that a mode holds, the directions of their forces, and the force it knows."""

    rows: list[int]
    forces: Scalars  # shape (…, nv, rows)
    friction: Scalars  # shape (…, rows, m), what a unit of each row's force is along all rows
    known: Scalars  # shape (…, m), forces along rows that are known


def hold(
    terms: Terms,
    elements: Sequence[ElementRows],
    mode: Mode,
    drive: ModeProblem,
    permanent: Sequence[int] = (),
) -> HeldRows:
    """Return what a mode holds."""
    rows, sliding = list(permanent), dict[int, list[tuple[int, Any]]]()
    known = np.zeros(terms.gaps.shape, terms.gaps.dtype)
    for k, (element, state) in enumerate(zip(elements, mode, strict=True)):
        if state.name == OPEN:
            continue
        normal = element.normal
        if normal is not None and normal in drive.given:
            known.T[normal] = drive.given[normal]
        elif normal is not None:
            rows.append(normal)
        if state.name == STICKS and not state.direction:
            rows += element.tangents
        elif state.direction:
            most = drive.sticking if state.name == STICKS else terms.kinetic
            pairs = zip(element.tangents, state.direction, strict=True)
            shares = [(row, -1.0 * most.T[k] * part) for row, part in pairs]
            if element.pressing is None:
                for row, share in shares:
                    known.T[row] = share
            else:
                sliding.setdefault(element.pressing, []).extend(shares)
    for pressing in sliding.keys() - rows:  # what presses is known, or nothing touches
        for row, share in sliding[pressing]:
            known.T[row] = share * known.T[pressing]
    friction = np.repeat(np.zeros_like(known)[..., None, :], len(rows), axis=-2)
    for i, row in enumerate(rows):
        friction[..., i, row] = 1.0
        for tangent, share in sliding.get(row, ()):
            friction[..., i, tangent] = share
    forces = (friction @ terms.jacobian).swapaxes(-1, -2)
    return HeldRows(rows, forces, friction, known)


def solve_held(
    terms: Terms,
    held: HeldRows,
    drive: ModeProblem,
    by_mass: Callable[[Scalars], Scalars],
    by_rows: Callable[[Scalars, Scalars, Scalars, Scalars], Scalars | None],
) -> tuple[Scalars, Scalars] | None:
    """Return accelerations and the force along each row in one state; None if there are none.

    Args:
        terms: of the state.
        held: what the mode holds.
        drive: what it is solved for.
        by_mass: gives M⁻¹ of columns, shape (nv, k).
        by_rows: gives the forces of the rows held by their J, by M⁻¹ of the directions of the
            forces, by J a without them and by what that should be.
    """
    J = terms.jacobian[held.rows]
    load = drive.load + terms.jacobian.T @ held.known
    response = by_mass(np.column_stack([load, held.forces]))
    free, yielding = response[:, 0], response[:, 1:]
    if not held.rows:
        return free, held.known
    wanted = drive.wanted[held.rows]
    forces = by_rows(J, yielding, J @ free, wanted)
    if forces is None:
        return None
    a = free + yielding @ forces
    for row, target in zip(J, wanted, strict=True):
        # a coordinate that sticks does not creep, not even by rounding
        entries = [k for k, slope in enumerate(row) if slope != 0]
        if len(entries) == 1:
            a[entries[0]] = target / row[entries[0]]
    return a, held.known + held.friction.T @ forces


def list_margins(
    elements: Sequence[ElementRows],
    mode: Mode,
    moved: tuple[Scalars, Scalars],
    forces: Scalars | Sequence[Any] | None,
    limits: tuple[Scalars | Sequence[Any], Sequence[Any]],
    length: Callable[..., Any],
) -> list[tuple[Any, Any]]:
    """Return what each element has left in its state: its gap or what presses, its friction.

    The first is the gap while it is open and the normal force while it is closed, the second the
    reserve of static friction or the speed of slip; 1 where there is none.

    Args:
        elements: those of the mechanism.
        mode: the state of each.
        moved: gap and slip of each row between corners; at a corner, both what it gains by.
        forces: along each row; None if they are not known.
        limits: what sticks at most, as in `Terms`, and what each element pulls at most.
        length: gives that of a force by its parts.
    """
    (gaps, slips), (static, holds) = moved, limits
    margins: list[tuple[Any, Any]] = []
    for k, (element, state) in enumerate(zip(elements, mode, strict=True)):
        normal = element.normal
        if normal is not None and (state.name == OPEN or element.stiffness is not None):
            gap = gaps[normal]
            margins.append((gap if state.name == OPEN else -1.0 * gap, 1.0))
            continue
        press: Any = 1.0
        if normal is not None and forces is not None:
            press = forces[normal] + holds[k]
        friction: Any = 1.0
        if state.name == STICKS and state.direction:
            pass
        elif state.name == STICKS and forces is not None:
            pulls = [forces[row] for row in element.tangents]
            friction = friction_limit(element, static[k], forces) - length(*pulls)
        elif state.direction:
            # the slip along the direction in which it began
            pairs = zip(element.tangents, state.direction, strict=True)
            friction = sum(slips[row] * part for row, part in pairs)
        margins.append((press, friction))
    return margins


def list_present_margins(
    terms: Terms,
    elements: Sequence[ElementRows],
    mode: Mode,
    forces: Scalars | None,
    length: Callable[..., Any],
) -> list[tuple[Any, Any]]:
    """Return what each element has left in its state, between corners."""
    limits = terms.static, [rows.holds for rows in elements]
    left = list_margins(elements, mode, (terms.gaps, terms.rates), forces, limits, length)
    return keep_inside(terms, elements, mode, left, length)


def find_inside(
    elements: Sequence[ElementRows],
    feet: Mapping[str, Any],
    gaps: Scalars,
    absolute: Callable[[Any], Any] = np.abs,
) -> list[Any]:
    """Return how far inside its side each contact is, by the place along it; 1 without ends.

    Near an end this is the distance from it [m]. What is in front of another side that meets this
    one in an edge is not behind this one, as the body is between them.
    """
    inside: list[Any] = []
    for element in elements:
        if element.length is None:
            inside.append(1.0)
            continue
        half, foot = 0.5 * element.length, feet[element.name]
        left = 0.5 * (half - foot * foot / half)
        for row in element.edges:
            behind = -1.0 * gaps.T[row] - CLOSED_GAP * element.length
            left = 0.5 * (left + behind - absolute(left - behind))
        inside.append(left)
    return inside


def keep_inside(
    terms: Terms,
    elements: Sequence[ElementRows],
    mode: Mode,
    left: Sequence[tuple[Any, Any]],
    length: Callable[..., Any],
) -> list[tuple[Any, Any]]:
    """Return what elements have left between corners, by the ends of their sides as well.

    What is closed opens where it leaves its side. What is open closes where it has no gap and is
    inside, whichever comes last.
    """
    bounded: list[tuple[Any, Any]] = []
    for k, (element, state, (first, second)) in enumerate(zip(elements, mode, left, strict=True)):
        if element.length is not None:
            inside = terms.inside.T[k]
            if state.name == OPEN:
                first = 0.5 * (first - inside + length(first + inside))  # the larger
            else:
                # as a force, so that the smaller is of a size with what presses
                inside = inside * (sum(map(length, terms.load)) / element.length)
                first = 0.5 * (first + inside - length(first - inside))
        bounded.append((first, second))
    return bounded


def friction_limit(element: ElementRows, coefficient: Any, forces: Scalars | Sequence[Any]) -> Any:
    """Return the most friction of an element, by its coefficient and the forces along rows."""
    return coefficient if element.pressing is None else coefficient * forces[element.pressing]
