"""Compute the motion of a mechanism with loops, in one state at a time and without checks.

M a + h = Jᵀ λ with J a + γ = 0 is solved in the null space of J
(`mecanique.reference.loops.nullspace`), which allows massless links and redundant constraints.
λ gives the wrenches of the loops; inverse dynamics with these as external forces gives the joint
reactions. Each mechanism is loaded into Pinocchio only once per thread, as long as it is alive.
"""

from __future__ import annotations

import threading
import weakref
from copy import copy
from typing import NamedTuple, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import EngineError
from mecanique.model.constraints.contacts import SPEAKING
from mecanique.model.mechanism import Mechanism
from mecanique.reference.engine.forces.sites import SiteAction
from mecanique.reference.engine.load import EngineModel
from mecanique.reference.engine.package import engine_package
from mecanique.reference.engine.tree import EngineTree
from mecanique.reference.loops.closures import Closures, velocities_that_carry
from mecanique.reference.loops.nullspace import (
    ConstrainedAccelerations,
    Metric,
    measure,
    solve,
    split,
)
from mecanique.reference.tolerances import LEAST, LOOSE, OPEN, TINY
from mecanique.reference.vectors import hat


@final
class MassRoot:
    """The root of the mass matrix of a mechanism's tree."""

    def __init__(self, engine: EngineModel) -> None:
        model = engine.model
        self._data = engine.data
        # bodies without mass as well: a flywheel may be given by its moment of inertia alone
        self._joints = range(1, model.njoints)
        inertias = [model.inertias[i] for i in self._joints]
        masses = np.array([inertia.mass for inertia in inertias])
        # reshaped so that empty arrays have three axes, too
        self._mass = np.sqrt(np.maximum(masses, 0.0)).reshape(-1, 1, 1)
        self._levers = np.array([inertia.lever for inertia in inertias]).reshape(-1, 3, 1)
        self._inertia = np.array([_root(x.inertia) for x in inertias]).reshape(-1, 3, 3)
        self._carried = velocities_that_carry(engine)[1:, None]
        rotors = np.sqrt(np.asarray(model.armature))
        self._rotors = np.diag(rotors)[rotors > 0]

    def now(self) -> Array:
        """Return A, shape (k, nv), in the state of the joint Jacobians computed last."""
        columns = self._data.J.reshape(6, -1)
        poses = [self._data.oMi[i] for i in self._joints]
        turns = np.array([pose.rotation for pose in poses]).reshape(-1, 3, 3)
        places = np.array([pose.translation for pose in poses]).reshape(-1, 3)
        centers = places + (turns @ self._levers)[:, :, 0]
        linear = self._mass * (columns[:3] - hat(centers) @ columns[3:]) * self._carried
        angular = self._inertia @ turns.transpose(0, 2, 1) @ columns[3:] * self._carried
        nv = columns.shape[1]
        rows = [linear.reshape(-1, nv), angular.reshape(-1, nv), self._rotors]
        root: Array = np.concatenate(rows)
        return root


def _root(inertia: Array) -> Array:
    """Return R with Rᵀ R = I."""
    principal, axes = np.linalg.eigh(inertia)
    root: Array = np.sqrt(np.maximum(principal, 0.0))[:, None] * axes.T
    return root


class TransmittedWrenches(NamedTuple):
    """The wrenches of joints and loops."""

    wrenches: Array  # force and moment of each joint, then of each loop, shape (n, 2, 3)
    # shape (n, 6), whether redundant constraints leave a component undetermined
    undetermined: Array


@final
class Closed:
    """The constrained motion of a mechanism with loops."""

    def __init__(self, tree: EngineTree, most: int | None = None) -> None:
        pin = engine_package()

        self._pin = pin
        self._tree = tree
        self.mechanism: Mechanism = tree.mechanism
        self._root = MassRoot(tree.engine)
        self._upper = np.triu(np.ones((tree.engine.model.nv,) * 2, dtype=bool))
        self.closures = Closures(tree.mechanism, tree.engine, tree.chart)
        self.most = most
        place = {name: k for k, name in enumerate(self.mechanism.coordinates.names)}
        names = [name[:-1] for name in self.mechanism.velocities]
        self._integrals = np.array([place.get(name, -1) for name in names], dtype=int)

    def with_rank(self, most: int | None) -> Closed:
        """Return a copy with another rank of the constraints, None for an unknown one."""
        ranked = copy(self)
        ranked.most = most
        return ranked

    def solve(self, q: Array, v: Array, t: float, *, weak: float = 0.0) -> ConstrainedAccelerations:
        """Solve for accelerations and multipliers."""
        engine, chart, loads = self._tree.engine, self._tree.chart, self._tree.loads
        values, u = self.closures.move(q, v, t)
        closure = self.closures.now(residual=False)
        loads.update(values, q, u, v, t)
        # inverse dynamics with external forces is bias minus their generalized forces
        h = (
            self._pin.rnea(
                engine.model, engine.data, chart.p, u, chart.gamma, loads.external.forces
            )
            - loads.in_joints
        )
        if not chart.identical:
            h = chart.G.T @ h
        return solve(
            self.measure(closure.jacobian),
            h,
            closure.jacobian,
            closure.gamma,
            names=self.mechanism.velocities,
            most=self.most,
            weak=weak,
        )

    def measure(self, jacobian: Array) -> Metric:
        """Return the metric of the state that the closures were last evaluated in."""
        engine, chart = self._tree.engine, self._tree.chart
        half = self._pin.crba(engine.model, engine.data, chart.p)
        mass = np.where(self._upper, half, half.T)
        if not chart.identical:
            mass = chart.G.T @ mass @ chart.G
        return measure(mass, jacobian, self.closures.units, self._mass_root)

    def acceleration(self, q: Array, v: Array, t: float) -> Array:
        """Return a, shape (nv,)."""
        return self._solve_closed(q, v, t).acceleration

    def refuse_open(self, q: Array, t: float) -> None:
        """Refuse a position with open loops, where the equations have no meaning."""
        residual = self.closures.residual(q, t)
        gaps = np.abs(residual) * self.closures.rows
        worst = int(gaps.argmax()) if len(gaps) else 0
        if len(gaps) and not gaps[worst] < OPEN:
            name = self.closures.names[worst]
            off = "a wheel is off its plane" if name.endswith(": normal") else "the loops are open"
            raise EngineError(
                f"mechanism {self.mechanism.name!r}: {off} at q = {q.tolist()} "
                f"({name} by {residual[worst]:.3g}); close them first, by mecanique.assemble"
            )

    def multipliers(self, q: Array, v: Array, t: float) -> Array:
        """Return λ of each row, shape (m,)."""
        return self._solve_closed(q, v, t).multipliers

    def reactions(self, q: Array, v: Array, t: float) -> TransmittedWrenches:
        """Return the wrenches of joints on children, of loops on bodies b, and of contacts."""
        if self.mechanism.velocity_constraints:
            raise EngineError(
                f"mechanism {self.mechanism.name!r}: velocity constraint "
                f"{self.mechanism.velocity_constraints[0].name!r} does not say by which force it "
                f"acts, and where, so the reactions are undetermined; use {SPEAKING}"
            )
        motion = self._solve_closed(q, v, t)
        tree, count = self._tree, len(self.mechanism.joints) + len(self.closures.ends)
        # evaluated first: the joints' totals must be the last computation in the tree
        settled = bool(motion.determined.all())
        loose = np.zeros((count, 6), dtype=bool) if settled else self.undetermined(q, t)
        loads = tree.loads
        values, u, rate = tree.move(q, v, t, motion.acceleration)
        actions = loads.update(values, q, u, v, t) + loads.across_joints()
        wrenches = self.closures.wrenches(motion.multipliers)
        transmitted = tree.transmit([*actions, *self._actions(wrenches)], u, rate)
        force, moment, _ = wrenches
        return TransmittedWrenches(
            np.concatenate([transmitted, np.stack([force, moment], axis=1)]), loose
        )

    def undetermined(self, q: Array, t: float) -> Array:
        """Return which components of joints' and loops' wrenches are undetermined, shape (n, 6)."""
        # They are those with self-stresses: multipliers that balance one another, Jᵀ λ = 0
        tree = self._tree
        count = len(self.mechanism.joints) + len(self.closures.ends)
        zero = np.zeros(self.mechanism.nv)
        here = self.closures.scale(q, zero, t)
        left = split(here.jacobian, least=LEAST, rounding=lambda: here.rounding).loose
        loose = np.zeros((count, 6), dtype=bool)
        for combination in left.T:
            tree.move(q, zero, t, zero)
            wrenches = self.closures.wrenches(self.closures.rows * combination)
            rest = np.zeros(tree.engine.model.nv)
            transmitted = tree.transmit(self._actions(wrenches), rest, rest, weightless=True)
            whole = np.concatenate([transmitted, np.stack(wrenches[:2], axis=1)]).reshape(count, 6)
            whole[:, 3:] /= self.closures.length
            loose |= np.abs(whole) > LOOSE * max(float(np.abs(whole).max(initial=0.0)), TINY)
        return loose

    def drift(self, q: Array, v: Array, t: float) -> Array:
        """Return the largest gap and the largest rate of a gap, scaled, shape (2,)."""
        here = self.closures.scale(q, v, t)
        return np.array([np.abs(part).max(initial=0.0) for part in (here.gaps, here.rates)])

    def rates(self, q: Array, v: Array) -> Array:
        """Return q', shape (nq,)."""
        out: Array = np.empty(self.mechanism.nq)
        self._tree.chart.rates(q, v, out)
        return out

    def sizes(self, q: Array) -> Array:
        """Return the absolute value of each velocity's coordinate; 0 for a quasi-velocity."""
        return np.where(self._integrals >= 0, np.abs(q[self._integrals]), 0.0)

    def poses(self, q: Array, t: float) -> Array:
        """Return the pose of every body, in their order, shape (nb, 4, 4)."""
        return self._tree.poses(q, np.zeros(self.mechanism.nv), t)

    def _mass_root(self) -> Array:
        chart, root = self._tree.chart, self._root.now()
        return root if chart.identical else root @ chart.G

    def _solve_closed(self, q: Array, v: Array, t: float) -> ConstrainedAccelerations:
        self._tree.move(q, v, t)
        self._tree.loads.check()
        self.refuse_open(q, t)
        return self.solve(q, v, t)

    def _actions(self, wrenches: tuple[Array, Array, Array]) -> list[SiteAction]:
        """Return the actions of the loops on bodies b, and their opposites on bodies a."""
        sites = self._tree.loads.sites
        return [
            SiteAction.of(sites[body], sign * force, place, sign * moment)
            for end, force, moment, place in zip(self.closures.ends, *wrenches, strict=True)
            for body, sign in ((end.acted, 1.0), (end.acting, -1.0))
        ]


MOST = 32
"""Number of mechanisms that stay loaded in a thread, those used last."""


class Loaded(NamedTuple):
    """A mechanism inside Pinocchio."""

    tree: EngineTree  # its tree; all who load the mechanism in one thread share its data
    closed: Closed | None  # its loops, with constraints of unknown rank; None for a tree


class _Kept(NamedTuple):
    mechanism: weakref.ref[Mechanism]
    loaded: Loaded


@final
class _Shelf(threading.local):
    """The mechanisms that a thread keeps; threads must not share Pinocchio's data."""

    def __init__(self) -> None:
        self.kept: dict[int, _Kept] = {}


_shelf = _Shelf()


def load_once(mechanism: Mechanism) -> Loaded:
    """Load a mechanism into Pinocchio, at the first call only."""
    # Results do not depend on earlier calls
    kept, key = _shelf.kept, id(mechanism)
    entry = kept.pop(key, None)
    if entry is None or entry.mechanism() is not mechanism:
        # a copy is loaded, so that the cache does not keep the mechanism alive
        tree = EngineTree(copy(mechanism))
        loaded = Loaded(tree, Closed(tree) if mechanism.constrained else None)
        entry = _Kept(weakref.ref(mechanism, lambda _: kept.pop(key, None)), loaded)
    kept[key] = entry
    if len(kept) > MOST:
        del kept[next(iter(kept))]
    return entry.loaded


def load_loops(mechanism: Mechanism) -> Closed:
    """Load a mechanism with loops as `load_once` does, and return its loops."""
    closed = load_once(mechanism).closed
    assert closed is not None, "the mechanism has loops"
    return closed
