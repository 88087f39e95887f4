"""Compute the rows of rolling, blades and velocity constraints by Pinocchio's kinematics.

A contact prevents relative motion along a direction n of the two bodies' points at the same place
P: n·(v_A − v_B) = 0. With twists (l, ω) at the world's origin v = l + ω × P, and along the motion

    d/dt (v_A − v_B) = (l_A − l_B)' + (ω_A − ω_B)' × P + (ω_A − ω_B) × P',

where P' is the velocity of the place of contact, not of a material point: with the hub C and ρ =
P − C it is v_C + ρ', and ρ' follows from the rotation of the axis e, e' = ω_A × e (Basu-Mandal,
Chatterjee & Papadopoulos, Proc. R. Soc. A 463 (2007) 1983, sect. 4; Neimark & Fufaev, Dynamics of
Nonholonomic Systems, 1972, ch. I, sect. 4).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple, final

import numpy as np

from mecanique.arrays import Array
from mecanique.model.constraints.contacts import Blade, Contact, Rolling, row_names
from mecanique.model.expression import Scalar, compile_scalars, symbols_in
from mecanique.model.mechanism import Mechanism
from mecanique.reference.engine.load import EngineModel
from mecanique.reference.vectors import cross, hat


class ContactConstraints(NamedTuple):
    """Constraint rows in one state, with the rate J v + b and its derivative J a + γ."""

    residual: Array  # Φ, zero where there is none, shape (m,)
    jacobian: Array  # J, shape (m, n)
    drift: Array  # b, shape (m,)
    gamma: Array  # γ, shape (m,)


class _Body(NamedTuple):
    """A body in motion: its axes, and its twist at the world's origin with the twist's rate."""

    turn: Array
    origin: Array
    linear: Array
    spin: Array
    linear_rate: Array
    spin_rate: Array

    def at(self, point: Array) -> Array:
        """Return the velocity of the body's point at a place in the world."""
        return self.linear + cross(self.spin, point)


class _Touch(NamedTuple):
    """The place of a contact, its velocity, and the directions in which it prevents motion."""

    place: Array  # shape (3,), P
    rate: Array  # shape (3,), P'
    directions: Array  # shape (k, 3)
    turning: Array  # shape (k, 3), their rates
    seat: Array  # shape (3,), the point of the body at which its force is reported
    gap: float  # Φ of the first direction
    margin: float = 1.0  # from 0, where no place is determined, as of a wheel that lies flat, to 1


@final
class ContactRows:
    """The rows of a mechanism's contacts, in the engine's velocities."""

    def __init__(self, mechanism: Mechanism, engine: EngineModel, carried: Array) -> None:
        self._engine = engine
        self._carried = carried
        self.names = row_names(mechanism.contacts)
        """Name of each row, "contact: motion it prevents"."""
        self.owner = np.array(
            [k for k, contact in enumerate(mechanism.contacts) for _ in contact.rows], dtype=int
        )
        """The index of the contact of each row, shape (m,)."""
        self.positional = np.array([name.endswith(": normal") for name in self.names], dtype=bool)
        """Whether each row is the rate of a Φ, shape (m,)."""
        moved = {name: self._carried[holder.joint] for name, holder in engine.holders.items()}
        self.meets = np.array(
            [moved[c.body] + moved[c.on] for c in mechanism.contacts], dtype=bool
        ).reshape(len(mechanism.contacts), engine.model.nv)[self.owner]
        """Whether each row may depend on each velocity, shape (m, n)."""
        self._shapes = [_numbers(mechanism, contact) for contact in mechanism.contacts]
        self._contacts = mechanism.contacts
        self.met: Array = np.zeros((len(mechanism.contacts), 3))
        """Where each contact was in the last call of `now`, shape (contacts, 3)."""
        self.margins: Array = np.ones(len(mechanism.contacts))
        """How well each place was determined there, from 0 to 1, shape (contacts,)."""

    def now(self, u: Array) -> ContactConstraints:
        """Return the rows in the engine's present state."""
        columns = self._engine.data.J.reshape(6, -1)
        residual, jacobian, gamma = [], [], []
        for k, (contact, shape) in enumerate(zip(self._contacts, self._shapes, strict=True)):
            a, b = (self._body(name, u) for name in (contact.body, contact.on))
            touch = shape.touch(a, b)
            self.met[k], self.margins[k] = touch.place, touch.margin
            between = self._carries(contact.body) - self._carries(contact.on)
            # column by column, J_l + J_ω × P
            J = (columns[:3] - hat(touch.place) @ columns[3:]) * between
            parting = a.at(touch.place) - b.at(touch.place)
            change = (
                a.linear_rate
                - b.linear_rate
                + cross(a.spin_rate - b.spin_rate, touch.place)
                + cross(a.spin - b.spin, touch.rate)
            )
            jacobian.append(touch.directions @ J)
            gamma.append(touch.directions @ change + touch.turning @ parting)
            residual.append([touch.gap, *[0.0] * (len(touch.directions) - 1)])
        n = len(self.names)
        rows = np.concatenate(jacobian) if jacobian else np.zeros((0, columns.shape[1]))
        return ContactConstraints(
            np.array([gap for row in residual for gap in row]),
            rows,
            np.zeros(n),
            np.concatenate(gamma) if gamma else np.zeros(0),
        )

    def residual(self) -> Array:
        """Return Φ of all rows in the engine's present position, shape (m,)."""
        gaps = []
        for contact, touch in zip(self._contacts, self._touches(), strict=True):
            gaps += [touch.gap, *[0.0] * (len(contact.rows) - 1)]
        return np.array(gaps)

    def places(self) -> Array:
        """Return the points of contact in the engine's present position, shape (k, 3)."""
        return np.array([touch.place for touch in self._touches()]).reshape(-1, 3)

    def wrenches(self, multipliers: Array) -> tuple[Array, Array, Array]:
        """Return force, moment and point of each contact's action, world axes."""
        wrenches = np.zeros((3, len(self._contacts), 3))
        for k, touch in enumerate(self._touches()):
            force = multipliers[self.owner == k] @ touch.directions
            wrenches[:, k] = force, cross(touch.place - touch.seat, force), touch.seat
        return wrenches[0], wrenches[1], wrenches[2]

    def _touches(self) -> Iterator[_Touch]:
        """Yield each contact in the engine's present position, at rest."""
        still = np.zeros(self._engine.model.nv)
        for contact, shape in zip(self._contacts, self._shapes, strict=True):
            a, b = (self._body(name, still, moving=False) for name in (contact.body, contact.on))
            yield shape.touch(a, b)

    def _carries(self, body: str) -> Array:
        carries: Array = self._carried[self._engine.holders[body].joint]
        return carries

    def _body(self, name: str, u: Array, *, moving: bool = True) -> _Body:
        holder, data = self._engine.holders[name], self._engine.data
        pose = data.oMi[holder.joint] * holder.placement
        twist = rate = np.zeros(6)
        if moving:
            carried = u * self._carried[holder.joint]
            twist, rate = data.J.reshape(6, -1) @ carried, data.dJ.reshape(6, -1) @ carried
        return _Body(
            turn=pose.rotation,
            origin=pose.translation,
            linear=twist[:3],
            spin=twist[3:],
            linear_rate=rate[:3],
            spin_rate=rate[3:],
        )


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
        n = d / length
        n_rate = (d_rate - (n @ d_rate) * n) / length
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

    def now(self, q: Array, v: Array, t: float) -> ContactConstraints:
        """Return the rows in a state."""
        if not self.names:
            return ContactConstraints(
                np.zeros(0), np.zeros((0, self._size)), np.zeros(0), np.zeros(0)
            )
        entries = np.array(self._entries(*q.tolist(), *v.tolist(), *self._values, t), dtype=float)
        now, change = entries.reshape(2, len(self.names), self._size + 1)
        return ContactConstraints(
            np.zeros(len(self.names)),
            now[:, :-1],
            -now[:, -1],
            change[:, :-1] @ v - change[:, -1],
        )
