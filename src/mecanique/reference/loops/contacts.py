"""Find where bodies roll or slide, in which directions, and how these turn; velocity constraints.

A contact prevents relative motion of the two bodies' points at the same place P along directions n.
P moves, not as a material point: with the hub C and ρ = P − C its velocity is v_C + ρ', and ρ'
follows from the rotation of the axis e, e' = ω_A × e (Basu-Mandal, Chatterjee & Papadopoulos,
Proc. R. Soc. A 463 (2007) 1983, sect. 4; Neimark & Fufaev, Dynamics of Nonholonomic Systems, 1972,
ch. I, sect. 4).
"""

from __future__ import annotations

from typing import NamedTuple, final

import numpy as np

from mecanique.arrays import Array, cross
from mecanique.model.constraints.contacts import Blade, Contact, Rolling, row_names
from mecanique.model.expression import Scalar, compile_scalars, symbols_in
from mecanique.model.mechanism import Mechanism
from mecanique.reference.engine.load import EngineModel, Holder
from mecanique.reference.vectors import hat

_REST = np.zeros(6)


class LoopClosure(NamedTuple):
    """Constraints in one state."""

    residual: Array  # Φ, shape (m,) [m or rad]; zero where there is none
    jacobian: Array  # J, shape (m, n)
    drift: Array  # b, the part of Φ' without v, shape (m,)
    gamma: Array  # γ, the part of Φ'' without a, shape (m,)


class _Body(NamedTuple):
    """A body in motion, world axes."""

    turn: Array  # shape (3, 3)
    origin: Array  # shape (3,)
    linear: Array  # shape (3,), the velocity of its point at the world's origin
    spin: Array  # shape (3,)

    def at(self, point: Array) -> Array:
        """Return the velocity of the body's point at a place in the world."""
        return self.linear + cross(self.spin, point)


class Meeting(NamedTuple):
    """Where k loops or contacts hold two bodies together, and m directions in which they do."""

    places: Array  # shape (k, 3), P
    rates: Array  # shape (k, 3), P'
    directions: Array  # shape (m, 3)
    turning: Array  # shape (m, 3), their rates
    seats: Array  # shape (k, 3), the points of the bodies at which forces are reported
    gaps: Array  # shape (m,), Φ; zero where there is none


class _Touch(NamedTuple):
    """The place of a contact, its velocity, and the directions in which it prevents motion."""

    place: Array  # shape (3,), P
    rate: Array  # shape (3,), P'
    directions: Array  # shape (k, 3)
    turning: Array  # shape (k, 3), their rates
    seat: Array  # shape (3,), the point of the body at which its force is reported
    gap: float  # Φ of the first direction
    margin: float = 1.0  # from 0, where no place is determined, as of a wheel that lies flat, to 1
    foot: float = 0.0  # the place along x of the plane [m]


@final
class ContactRows:
    """The rows of a mechanism's contacts."""

    def __init__(self, mechanism: Mechanism, engine: EngineModel, carried: Array) -> None:
        self._engine, self._carried = engine, carried
        self.names = row_names(mechanism.contacts)
        """Name of each row, "contact: motion it prevents"."""
        self.owner = np.array(
            [k for k, contact in enumerate(mechanism.contacts) for _ in contact.rows], dtype=int
        )
        """The index of the contact of each row, shape (m,)."""
        self.positional = np.array([name.endswith(": normal") for name in self.names], dtype=bool)
        """Whether each row is the rate of a Φ, shape (m,)."""
        self._contacts = [
            (_numbers(mechanism, c), engine.holders[c.body], engine.holders[c.on])
            for c in mechanism.contacts
        ]
        ends = np.array([(body.joint, on.joint) for _, body, on in self._contacts], dtype=int)
        moved = carried[ends.reshape(-1, 2)]
        self.between: Array = moved[:, 0] - moved[:, 1]
        """Which velocities move each contact's body, minus those that move its plane, (k, nu)."""
        self.meets: Array = moved.sum(axis=1)[self.owner]
        """Not zero where a row may depend on a velocity, shape (m, nu)."""
        self._first = np.unique(self.owner, return_index=True)[1]
        self.margins: Array = np.ones(len(mechanism.contacts))
        """How well each place was determined at the last meeting, from 0 to 1, (contacts,)."""
        self.feet: Array = np.zeros(len(mechanism.contacts))
        """Each place along x of its plane at the last meeting [m], shape (contacts,)."""

    def meet(self, moving: Array | None = None) -> Meeting:
        """Return the contacts by J u, column by column, without which the bodies rest."""
        touches = [
            shape.touch(self._body(body, moving), self._body(on, moving))
            for shape, body, on in self._contacts
        ]
        self.margins[:] = [touch.margin for touch in touches]
        self.feet[:] = [touch.foot for touch in touches]
        gaps = np.zeros(len(self.names))
        gaps[self._first] = [touch.gap for touch in touches]
        return Meeting(
            np.array([touch.place for touch in touches]),
            np.array([touch.rate for touch in touches]),
            np.concatenate([touch.directions for touch in touches]),
            np.concatenate([touch.turning for touch in touches]),
            np.array([touch.seat for touch in touches]),
            gaps,
        )

    def _body(self, holder: Holder, moving: Array | None) -> _Body:
        pose = self._engine.data.oMi[holder.joint] * holder.placement
        twist = _REST if moving is None else moving @ self._carried[holder.joint]
        return _Body(pose.rotation, pose.translation, twist[:3], twist[3:])


class _Wheel(NamedTuple):
    """The numbers of a rolling body and its plane."""

    center: Array
    axis: Array | None
    radius: float
    crown: float
    point: Array
    axes: Array
    stretch: Array
    bowl: float

    def touch(self, a: _Body, b: _Body) -> _Touch:
        """Return its contact."""
        if self.bowl:
            return self._touch_sphere(a, b)
        hub = a.origin + a.turn @ self.center
        frame = (b.turn @ self.axes).T
        n, n_rate = frame[2], cross(b.spin, frame[2])
        rho, rho_rate, margin = -self.crown * n, -self.crown * n_rate, 1.0
        if self.axis is None:
            rho, rho_rate = self._below(a, n, n_rate)
        else:
            e = a.turn @ self.axis
            e_rate = cross(a.spin, e)
            lean, lean_rate = n @ e, n_rate @ e + n @ e_rate
            s, s_rate = n - lean * e, n_rate - lean_rate * e - lean * e_rate
            margin = float(np.linalg.norm(s))
            up = s / margin
            up_rate = (s_rate - (up @ s_rate) * up) / margin
            ring = self.radius - self.crown
            rho, rho_rate = rho - ring * up, rho_rate - ring * up_rate
        place = hub + rho
        ground = b.origin + b.turn @ self.point
        return _Touch(
            place,
            a.at(hub) + rho_rate,
            frame[[2, 0, 1]],
            frame[[2, 0, 1]] @ hat(b.spin).T,
            hub,
            float(n @ (place - ground)),
            margin,
            float(frame[0] @ (place - ground)),
        )

    def _below(self, a: _Body, n: Array, n_rate: Array) -> tuple[Array, Array]:
        """Return ρ of an ellipsoid with semi-axes d, −R d² Rᵀ n/|d Rᵀ n|, and ρ'."""
        squares = (self.radius * self.stretch) ** 2
        if not self.radius:
            return np.zeros(3), np.zeros(3)  # a point
        u, u_rate = n @ a.turn, (n_rate - cross(a.spin, n)) @ a.turn
        h = float(np.sqrt(u @ (squares * u)))
        h_rate = u @ (squares * u_rate) / h
        rho = -a.turn @ (squares * u) / h
        return rho, cross(a.spin, rho) - a.turn @ (squares * u_rate) / h - rho * (h_rate / h)

    def _touch_sphere(self, a: _Body, b: _Body) -> _Touch:
        """Return the contact of a ball with a sphere about O: on the line from its center to O."""
        hub = a.origin + a.turn @ self.center
        x, y, z = frame = (b.turn @ self.axes).T
        O = b.origin + b.turn @ self.point + self.bowl * z
        side = np.sign(self.bowl)
        d, d_rate = side * (O - hub), side * (b.at(O) - a.at(hub))
        length = float(np.linalg.norm(d))
        apart = length or 1.0  # about the center itself no direction is determined
        n = d / apart
        n_rate = (d_rate - (n @ d_rate) * n) / apart
        x_rate, y_rate, z_rate = frame @ hat(b.spin).T
        directions, turning = [n], [n_rate]
        for e, e_rate in ((x, x_rate), (y, y_rate)):
            # rotated as z is rotated into n: e − (n·e) (z + n)/(1 + n·z); opposite to z it is e
            opposite = 1 + n @ z or 1.0
            part = (n @ e) / opposite
            part_rate = (n_rate @ e + n @ e_rate - part * (n_rate @ z + n @ z_rate)) / opposite
            directions.append(e - part * (z + n))
            turning.append(e_rate - part_rate * (z + n) - part * (z_rate + n_rate))
        return _Touch(
            hub - self.radius * n,
            a.at(hub) - self.radius * n_rate,
            np.array(directions),
            np.array(turning),
            hub,
            float(self.bowl - side * length - self.radius),
            float(1 + n @ z) / 2,
        )


class _Edge(NamedTuple):
    """The numbers of a blade."""

    point: Array
    side: Array

    def touch(self, a: _Body, b: _Body) -> _Touch:
        """Return its contact."""
        place = a.origin + a.turn @ self.point
        side = (a.turn @ self.side)[None]
        return _Touch(place, a.at(place), side, side @ hat(a.spin).T, place, 0.0)


def _numbers(mechanism: Mechanism, contact: Contact) -> _Wheel | _Edge:
    def vector(scalars: tuple[Scalar, ...]) -> Array:
        return np.array([mechanism.evaluate(scalar) for scalar in scalars])

    match contact:
        case Rolling():
            return _Wheel(
                center=vector(tuple(contact.center)),
                axis=None if contact.axis is None else np.array(contact.axis),
                radius=mechanism.evaluate(contact.radius),
                crown=mechanism.evaluate(contact.crown),
                point=vector(contact.plane.xyz),
                axes=np.array([vector(row) for row in contact.plane.rotation]),
                stretch=vector(tuple(contact.stretch)),
                bowl=mechanism.evaluate(contact.bowl),
            )
        case Blade():
            return _Edge(vector(tuple(contact.point)), np.array(contact.side))


@final
class VelocityRows:
    """The rows A(q, t) v = b(q, t) of a mechanism's velocity constraints."""

    def __init__(self, mechanism: Mechanism) -> None:
        from sympy import Symbol, sympify

        constraints, velocities = mechanism.velocity_constraints, mechanism.velocities
        self.names = tuple(constraint.name for constraint in constraints)
        """Name of each row: the constraint's."""
        self._size = mechanism.nv
        self._values = tuple(mechanism.values.values())
        entries = [
            sympify(entry)
            for constraint in constraints
            for entry in (*constraint.along(velocities), constraint.rate)
        ]
        rates = {name: f"{name}'" for name in mechanism.coordinates if f"{name}'" in velocities}

        def change(entry: Scalar) -> Scalar:
            moved = [
                entry.diff(Symbol(name)) * Symbol(rates[name])
                for name in sorted(symbols_in(entry) & rates.keys())
            ]
            return sum(moved, entry.diff(Symbol("t")))

        names = (*mechanism.coordinates, *velocities, *mechanism.values, "t")
        self._entries = compile_scalars([*entries, *map(change, entries)], names)

    def now(self, q: Array, v: Array, t: float) -> LoopClosure:
        """Return the rows in a state."""
        entries = np.array(self._entries(*q.tolist(), *v.tolist(), *self._values, t), dtype=float)
        now, change = entries.reshape(2, len(self.names), self._size + 1)
        return LoopClosure(
            np.zeros(len(self.names)),
            now[:, :-1],
            -now[:, -1],
            change[:, :-1] @ v - change[:, -1],
        )
