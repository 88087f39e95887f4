"""Compute the equations of motion of many states at once, by the recursion along the tree.

The sweeps are those of `mecanique.derivation.mechanics.recursion`, in vectors that are arrays
over all states.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any, final

import numpy as np

from mecanique.derivation.mechanics.chart import CoordinateMap, JointMotion
from mecanique.derivation.mechanics.forces import Forces
from mecanique.derivation.mechanics.letters import DrivenPath
from mecanique.derivation.mechanics.recursion import Numbers, Skeleton, TreeRecursion, skeleton_of
from mecanique.derivation.mechanics.vectors import (
    STILL,
    Triple,
    apply_to_columns,
    as_rows,
    cross,
    product,
)
from mecanique.derivation.numeric.dynamics import BatchDynamics, Latest
from mecanique.derivation.tree.links import links, place_of
from mecanique.derivation.tree.poses import Arithmetic, moments, placement_matrix
from mecanique.errors import InputError
from mecanique.model.expression import Scalar, symbols_in
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States

_FLOATS = Arithmetic()


@final
class ArrayLetters:
    """The values of a mechanism's letters in n states; those of constants are kept."""

    arithmetic = _FLOATS

    def __init__(self, states: States, constants: dict[Scalar, float | None]) -> None:
        self.mechanism, self.values = states.mechanism, states.values
        self._states, self._constants = states, constants

    def number(self, scalar: Scalar, values: Mapping[str, Any]) -> Any:
        """Evaluate a scalar; one that depends on parameters alone is evaluated only once."""
        if scalar not in self._constants:
            is_constant = symbols_in(scalar) <= self.mechanism.values.keys()
            self._constants[scalar] = self.mechanism.evaluate(scalar) if is_constant else None
        constant = self._constants[scalar]
        return _FLOATS(scalar, values) if constant is None else constant

    def call(self, function: str, *arguments: Any) -> Any:
        """Return a function's value, e.g. "sqrt" of one argument."""
        apply: Callable[..., Any] = getattr(np, function)
        return apply(*arguments)

    def vector(self, components: Sequence[Any]) -> np.ndarray:
        """Return scalars, or vectors, as the rows of an array."""
        return as_rows(components)

    def driven_paths(self) -> dict[str, DrivenPath]:
        """Return the path of each coordinate that the coordinate map drives, by name."""
        from mecanique.derivation.numeric.paths import driven_paths

        with np.errstate(invalid="ignore", divide="ignore"):
            jets = driven_paths(self._states)
        for name, c in jets.items():
            bad = ~np.isfinite(c).all(axis=(0, 1))
            if bad.any():
                position = zip(self.mechanism.coordinates, self._states.q[bad][0], strict=True)
                at = ", ".join(f"{q} = {x:g}" for q, x in position)
                raise InputError(
                    f"the coordinate map of mechanism {self.mechanism.name!r} gives no smooth "
                    f"{name!r} at {at}; expected coordinates inside its range"
                )
        # the second derivative is twice the coefficient of ε²
        return {
            name: DrivenPath(c[0, 0], c[1, 0], 2 * c[2, 0], c[0, 1:]) for name, c in jets.items()
        }


@final
class Recursion(BatchDynamics):
    """Mass matrix, bias, forces, accelerations and energies, for many states at once."""

    # Any of the numbers of the tree may be varied from state to state: matrices then have the shape
    # (n, 4, 4) instead of (4, 4), gravity (n, 3) instead of (3,)

    def __init__(
        self,
        mechanism: Mechanism,
        origins: Sequence[np.ndarray] = (),
        moments: Sequence[np.ndarray] = (),
        gravity: np.ndarray | None = None,
        turns: Mapping[int, np.ndarray] | None = None,
    ) -> None:
        self._mechanism = mechanism
        self.tree = links(mechanism)
        """The elementary links, in the order in which `vary` and `regressor` count them."""
        self._chart = CoordinateMap(mechanism, self.tree)
        self.origins = tuple(origins) or tuple(
            placement_matrix(link.origin, mechanism.values) for link in self.tree
        )
        """The pose of each link's frame in its parent's, each shape (4, 4)."""
        self.moments = tuple(moments) or self._weigh()
        """Mass moments of each link, ∫ (p, 1)(p, 1)ᵀ dm, each shape (4, 4)."""
        stated = np.array(mechanism.evaluate_all(mechanism.gravity))
        self._gravity = stated if gravity is None else gravity
        self._turned = turns or {}
        self._constants: dict[Scalar, float | None] = {}
        self._latest = Latest(self.place)

    def _weigh(self) -> tuple[np.ndarray, ...]:
        mechanism, places = self._mechanism, place_of(self.tree, self._mechanism)
        weighed = [np.zeros((4, 4)) for _ in self.tree]
        for body in mechanism.bodies:
            if places[body.name] >= 0:
                weighed[places[body.name]] += np.array(moments(body, mechanism.values, _FLOATS))
        return tuple(weighed)

    @cached_property
    def _skeleton(self) -> Skeleton:
        numbers = Numbers(
            origins=[_last(X)[:3] for X in self.origins],
            moments={k: _last(J) for k, J in enumerate(self.moments) if J.any()},
            armatures=[self._mechanism.evaluate(link.armature) for link in self.tree],
            gravity=np.atleast_2d(self._gravity).T if self._gravity.any() else STILL,
            identity=np.eye(3, 4)[..., None],
            axis=lambda axis: np.array(axis)[:, None],
            turns={k: _last(Q)[:3, :3] for k, Q in self._turned.items()},
        )
        return skeleton_of(self._mechanism, self.tree, numbers)

    def mass_matrix(self, states: States) -> np.ndarray:
        """Return M, shape (n, nv, nv)."""
        M = np.zeros((len(states), self._mechanism.nv, self._mechanism.nv))
        M[:] = np.moveaxis(self.at(states).mass_matrix(), -1, 0)
        return M

    def bias(self, states: States) -> np.ndarray:
        """Return Coriolis, centrifugal and rheonomic inertia terms and gravity, shape (n, nv)."""
        return _columns(self.at(states).bias(), len(states))

    def forces(self, states: States) -> np.ndarray:
        """Return the generalized forces of springs, dampers, drives and loads, shape (n, nv)."""
        tree = self.at(states)
        tau = Forces(tree.letters, tree).in_joints()
        efforts = self.efforts_in_joints(states, tree.chart)
        if efforts is not None:
            tau = [push + effort for push, effort in zip(tau, efforts, strict=True)]
        return _columns(tree.chart.project(tau), len(states))

    def efforts_in_joints(self, states: States, chart: JointMotion) -> np.ndarray | None:
        """Return the torques given with the states as forces in the joints; None without any."""
        # Shape (nu, n); generalized forces become the least torques that do the same virtual work
        efforts = states.efforts
        if efforts is None:
            return None
        tau = np.zeros((len(chart.u), len(states)))
        for name, column in efforts.in_joints.items():
            tau[self.velocity_places[name]] = column
        if efforts.generalized is not None and chart.order is None:
            inverse = np.linalg.pinv(np.moveaxis(chart.G, -1, 0).swapaxes(1, 2))
            tau += (inverse @ efforts.generalized[..., None])[..., 0].T
        return tau

    def inverse_dynamics(self, states: States, a: np.ndarray) -> np.ndarray:
        """Return M a + bias, shape (n, nv)."""
        return _columns(self.at(states).inverse_dynamics(a.T), len(states))

    def gravity(self, states: States) -> np.ndarray:
        """Return gravity's part of the bias, shape (n, nv)."""
        return _columns(self.at(states).gravity_forces(), len(states))

    def momentum(self, states: States) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the momenta, linear, angular about the origin and about the center of mass."""
        parts = self.at(states).momentum()
        linear, angular, central = (_columns(part, len(states)) for part in parts)
        return linear, angular, central

    def energy(self, states: States) -> tuple[np.ndarray, np.ndarray]:
        """Return the kinetic energy T and the potential energy V, each shape (n,) [J]."""
        tree = self.at(states)
        T, V = tree.energy()
        n = len(states)
        return np.full(n, T), np.full(n, V + Forces(tree.letters, tree).energy())

    def poses(self, states: States) -> list[np.ndarray]:
        """Return the pose of every link, in the order of the tree, each shape (n, 4, 4)."""
        tree = self.at(states)
        poses = []
        for seat in self._skeleton.seats:
            pose = np.zeros((len(states), 4, 4))
            pose[:, :3] = np.moveaxis(tree.pose_of(seat), -1, 0)
            pose[:, 3, 3] = 1.0
            poses.append(pose)
        return poses

    def at(self, states: States) -> TreeRecursion:
        """Return the tree at n states, its vectors with the states along the last axis."""
        return self._latest.at(states)

    def place(self, states: States) -> TreeRecursion:
        """Return the same, without keeping it for the next question about these states."""
        letters = ArrayLetters(states, self._constants)
        return TreeRecursion(letters, self._skeleton, self._chart.at(letters))

    @property
    def velocity_places(self) -> dict[str, int]:
        """The index of each joint velocity, by name."""
        names = [name for link in self.tree for name in link.velocities]
        return {name: k for k, name in enumerate(names)}

    @property
    def turns(self) -> tuple[np.ndarray, ...]:
        """The rotation of each joint's axis in the joint's frame, each shape (4, 4)."""
        return tuple(self._turned.get(k, np.eye(4)) for k in range(len(self.tree)))

    def vary(
        self,
        origins: Mapping[int, np.ndarray] | None = None,
        moments: Mapping[int, np.ndarray] | None = None,
        gravity: np.ndarray | None = None,
        turns: Mapping[int, np.ndarray] | None = None,
    ) -> Recursion:
        """Return a copy with other numbers of some links, or another gravity."""
        return Recursion(
            self._mechanism,
            [(origins or {}).get(k, X) for k, X in enumerate(self.origins)],
            [(moments or {}).get(k, J) for k, J in enumerate(self.moments)],
            self._gravity if gravity is None else gravity,
            {**self._turned, **(turns or {})},
        )

    def regressor(self, states: States, a: np.ndarray) -> np.ndarray:
        """Return the regressor Y with M a + bias = Σ Y J, J the mass moments of each link."""
        # The equations of motion are linear in J (C. G. Atkeson, C. H. An & J. M. Hollerbach, Int.
        # J. Robotics Research 5 (1986) 101). The rotors' inertia is left out.
        # Shape (n, nv, links, 4, 4). Shapes: a (n, nv).
        tree, n = self.at(states), len(states)
        chart = tree.chart
        fields = tree.fields(chart.u, chart.spread(a.T))
        Y = np.zeros((n, len(chart.u), len(self.tree), 4, 4))
        for k, seat in enumerate(self._skeleton.seats):
            if seat.place < 0:
                continue
            # the field of accelerations at the points of link k, and the pose of k, in one frame
            _, U, _, acceleration = fields[seat.place]
            X, at = seat.pose, seat.place
            field = np.zeros((3, 4, n))
            if isinstance(U, np.ndarray):
                field += apply_to_columns(U, X)
            field[:, 3] += np.broadcast_to(np.transpose(acceleration), (n, 3)).T
            while at >= 0:
                link = tree.links[at]
                for j, axis in link.linear.items():
                    Y[:, j, k, 3] = np.einsum("i...,ib...->...b", axis, field)
                for j, axis in link.angular.items():
                    for column in range(4):
                        shift = cross(axis, X[:, column])
                        Y[:, j, k, column] = np.einsum("i...,ib...->...b", shift, field)
                field = apply_to_columns(link.pose[:, :3], field)
                X = product(link.pose, X)
                at = link.parent
        if chart.places is not None:
            return Y[:, chart.places]
        return np.asarray(np.einsum("nukab,uvn->nvkab", Y, chart.G))


def _last(matrices: np.ndarray) -> np.ndarray:
    """Return matrices with the states along the last axis, which has length 1 without states."""
    return matrices[..., None] if matrices.ndim == 2 else np.moveaxis(matrices, 0, -1)


def _columns(scalars: Triple | Sequence[Any], n: int) -> np.ndarray:
    """Return scalars of n states, or of all states, as columns, shape (n, scalars)."""
    columns = np.zeros((n, len(scalars)))
    for column, scalar in zip(columns.T, scalars, strict=True):
        column[:] = scalar
    return columns
