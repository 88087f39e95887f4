"""The evidence of another source about a mechanism, as forces at many states.

A mass matrix is asked through M a at random accelerations a, at rest and without gravity; a bias at
constant velocities; gravity at rest. So everything is one kind of experiment: state and
acceleration in, forces out.
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.model.expression import symbols_in
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States


@final
@dataclass(frozen=True, eq=False)
class Inputs:
    """What goes into experiments."""

    q: Array  # shape (n, nq)
    v: Array  # shape (n, nv)
    a: Array  # shape (n, nv)
    t: Array  # shape (n,) [s]
    heavy: npt.NDArray[np.bool_]  # whether gravity acts, shape (n,)
    inertia: npt.NDArray[np.bool_]  # whether inertia forces and gravity count, shape (n,)
    loads: npt.NDArray[np.bool_]  # whether springs, dampers, drives and loads count, shape (n,)

    def __len__(self) -> int:
        return len(self.t)

    def at(self, rows: npt.NDArray[np.intp]) -> Inputs:
        """Return some of the experiments, or the same ones several times."""
        return Inputs(*(getattr(self, name)[rows] for name in self.__dataclass_fields__))


class _Experiment(NamedTuple):
    """One quantity asked for at all states; its flags are those of `Inputs`."""

    kind: str
    v: Array
    a: Array
    tau: Array
    heavy: bool = True
    inertia: bool = True
    loads: bool = False


@final
class Evidence:
    """Experiments with what another source answered; tau (n, nv), kind (n,)."""

    def __init__(
        self, mechanism: Mechanism, inputs: Inputs, tau: Array, kind: npt.NDArray[np.str_]
    ) -> None:
        self.mechanism = mechanism
        self.inputs = inputs
        self.tau = tau
        self.kind = kind
        self.chosen: Array | None = None
        self.recursion = Recursion(mechanism)
        self.base: Array = self.answers(self.recursion, inputs)

    @classmethod
    def of(
        cls, mechanism: Mechanism, states: States, theirs: Mapping[str, Array], seed: int = 0
    ) -> Evidence | None:
        """Return what values by quantity say; None if nothing can be asked."""
        q, v, t = states.q, states.v, states.t
        n, zero = len(states), np.zeros_like(states.v)
        # of order one in every direction, so that no part of M is hidden
        a = np.abs(v).mean(axis=0) * np.random.default_rng(seed).normal(size=v.shape) if n else zero
        moved = _is_rheonomic(mechanism)
        given = {name: values for name, values in theirs.items() if np.isfinite(values).all()}
        parts: list[_Experiment] = []
        if "mass matrix" in given:
            Ma = np.einsum("nij,nj->ni", given["mass matrix"], a)
            if not moved:
                parts.append(_Experiment("mass matrix", zero, a, Ma, heavy=False))
            elif "bias" in given:
                parts.append(_Experiment("mass matrix", v, a, Ma + given["bias"]))
        if "bias" in given:
            parts.append(_Experiment("bias", v, zero, given["bias"]))
        if "gravity" in given and not moved:
            parts.append(_Experiment("gravity", zero, zero, given["gravity"]))
        if "forces" in given:
            parts.append(
                _Experiment("forces", v, zero, -given["forces"], inertia=False, loads=True)
            )
        if "inverse dynamics" in given and not {"mass matrix", "bias"} & given.keys():
            tau = given["inverse dynamics"]
            parts.append(_Experiment("inverse dynamics", v, states.a, tau, loads=True))
        if not parts or not n:
            return None
        inputs = Inputs(
            q=np.concatenate([q] * len(parts)),
            v=np.concatenate([part.v for part in parts]),
            a=np.concatenate([part.a for part in parts]),
            t=np.concatenate([t] * len(parts)),
            heavy=np.repeat([part.heavy for part in parts], n),
            inertia=np.repeat([part.inertia for part in parts], n),
            loads=np.repeat([part.loads for part in parts], n),
        )
        kind = np.repeat([part.kind for part in parts], n)
        return cls(mechanism, inputs, np.concatenate([part.tau for part in parts]), kind)

    def after(
        self,
        effect: Array,
        *,
        origins: Mapping[int, Array],
        moments: Mapping[int, Array],
        turns: Mapping[int, Array],
        slopes: Array | None,
    ) -> Evidence:
        """Return the evidence that is left to explain once a change is made.

        Shapes: effect (n, nv), slopes (k, n, nv).
        """
        evidence = copy(self)
        for name in ("regressor", "before"):
            evidence.__dict__.pop(name, None)
        evidence.__dict__["weights"] = self.weights
        evidence.chosen = None
        if origins or moments or turns:
            evidence.recursion = self.recursion.vary(origins, moments, turns=turns)
            evidence.base = evidence.answers(evidence.recursion, self.inputs)
        else:
            evidence.tau = self.tau - effect
        if slopes is not None and len(slopes):
            directions, sizes, _ = np.linalg.svd(evidence.weigh(slopes).T, full_matrices=False)
            evidence.chosen = directions[:, sizes > 1e-9 * sizes[0]]
        return evidence

    def weigh(self, differences: Array) -> Array:
        """Return differences as weighted rows, shape (…, N), without what is chosen already.

        Shapes: differences (…, n, nv).
        """
        rows: Array = (differences * self.weights).reshape(*differences.shape[:-2], -1)
        return rows if self.chosen is None else rows - (rows @ self.chosen) @ self.chosen.T

    def answers(
        self,
        recursion: Recursion,
        inputs: Inputs,
        gravity: Array | None = None,
        mechanism: Mechanism | None = None,
    ) -> Array:
        """Return the forces that a recursion predicts, shape (n, nv); gravity (3,)."""
        mechanism = self.mechanism if mechanism is None else mechanism
        states = States(mechanism, inputs.q, inputs.v, inputs.t, inputs.a)
        pull = (self.gravity if gravity is None else gravity) * inputs.heavy[:, None]
        tau = (
            recursion.vary(gravity=pull).inverse_dynamics(states, inputs.a)
            * inputs.inertia[:, None]
        )
        if inputs.loads.any() and mechanism.forces:
            tau = tau - recursion.forces(states) * inputs.loads[:, None]
        return tau

    @property
    def is_measured(self) -> bool:
        """Whether it consists of samples of inverse dynamics, which may be noisy."""
        return bool((self.kind == "inverse dynamics").all())

    @cached_property
    def gravity(self) -> Array:
        """Acceleration of free fall, shape (3,) [m/s²]."""
        return np.array(self.mechanism.evaluate_all(self.mechanism.gravity))

    @cached_property
    def regressor(self) -> Array:
        """What the mass moments of each link add, shape (n, nv, links, 4, 4)."""
        inputs = self.inputs
        states = States(self.mechanism, inputs.q, inputs.v, inputs.t, inputs.a)
        pulled = self.recursion.vary(gravity=self.gravity * inputs.heavy[:, None])
        Y: Array = pulled.regressor(states, inputs.a)
        return Y * inputs.inertia[:, None, None, None, None]

    @cached_property
    def weights(self) -> Array:
        """What makes all entries alike in unit and size, shape (n, nv)."""
        inputs = self.inputs
        if self.is_measured:
            # noise is mostly a part of what each joint bears
            rms = np.sqrt(np.mean(self.tau**2, axis=0))
            by_joint = 1 / np.where(
                rms > 1e-9 * rms.max(initial=0.0), rms, rms.max(initial=0.0) or 1.0
            )
            whole: Array = np.broadcast_to(by_joint / np.sqrt(self.tau.size), self.tau.shape)
            return whole
        rest = np.zeros_like(inputs.v[:8])
        states = States(self.mechanism, inputs.q[:8], rest, inputs.t[:8], rest)
        diagonal = np.diagonal(self.recursion.mass_matrix(states), axis1=1, axis2=2).mean(axis=0)
        d = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
        weights = np.empty_like(self.tau)
        for kind in np.unique(self.kind):
            rows = self.kind == kind
            sizes = [float(np.linalg.norm(tau[rows] / d)) for tau in (self.tau, self.base)]
            weights[rows] = 1 / (d * (max(sizes) or 1.0))
        return weights

    @cached_property
    def few(self) -> npt.NDArray[np.intp]:
        """Two experiments of each kind, enough to choose the changes worth evaluating in full."""
        return np.concatenate(
            [np.flatnonzero(self.kind == kind)[:2] for kind in dict.fromkeys(self.kind)]
        )

    def misfit(self, predicted: Array) -> float:
        """Return the weighted difference of all answers, of what is chosen already as well.

        Shapes: predicted (n, nv).
        """
        return float(self._size_of_all(predicted, slice(None)))

    def _size_of_all(self, predicted: Array, rows: npt.NDArray[np.intp] | slice) -> Array:
        off = (predicted - self.tau[rows]) * self.weights[rows]
        size: Array = np.sqrt(np.sum(off * off, axis=(-2, -1)))
        return size

    def residual(self, predicted: Array, rows: npt.NDArray[np.intp] | None = None) -> Any:
        """Return how far predictions are from what the other source answered, relative, shape (…).

        Shapes: predicted (…, n, nv).
        """
        with np.errstate(all="ignore"):
            if rows is None:
                size = np.linalg.norm(self.weigh(predicted - self.tau), axis=-1)
            else:
                size = self._size_of_all(predicted, rows)
        return np.where(np.isfinite(size), size, np.inf)

    @cached_property
    def before(self) -> float:
        """How far the unchanged mechanism is from what the other source answered, relative."""
        return float(self.residual(self.base))


def _is_rheonomic(mechanism: Mechanism) -> bool:
    """Whether a coordinate map depends on time, so that inertia forces act even at rest."""
    moving = {"t", *(signal.symbol for signal in mechanism.inputs)}
    return any(moving & set(symbols_in(scalar)) for scalar in mechanism.coordinates.driven.values())
