"""Small motions about a state: M, C, K, natural frequencies, damping, modes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, final

import numpy as np

from mecanique.errors import InputError
from mecanique.model.expression import finite
from mecanique.model.mechanism import Mechanism
from mecanique.motion.dense import State
from mecanique.motion.rates import Rates
from mecanique.motion.settings import Values

__all__ = ["Linearization", "frequency_response", "linearize"]

STEPS = (0.02, 0.004, 0.0008, 0.00016)
"""Steps of the differences, in the unit of each coordinate: the next is tried where one is not accurate."""

ACCURATE = 1e-11
"""Relative error that is good enough."""

WEIGHTS = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])
"""Central differences of eighth order: weights of f(x + k h) − f(x − k h), k = 1…4 (Fornberg, 1988)."""

UNDAMPED = 1e-10
"""C and the skew part of K below this fraction of their scale count as zero."""


@final
@dataclass(frozen=True, eq=False)
class Linearization:
    """M δ̈ + C δ̇ + K δ = 0 for small deviations δ from a state; where v is not q̇, δ is a displacement along v.

    Args:
        mechanism: what moves.
        q: shape (nq,), positions.
        v: shape (nv,), velocities.
        t: time [s].
        M: shape (nv, nv), mass matrix.
        C: shape (nv, nv), ∂/∂v of M a + bias − forces.
        K: shape (nv, nv), ∂/∂q of M a + bias − forces.
        error: estimate of the error of C and K, relative to the largest entry of each.
        acceleration: shape (nv,), of the state itself; zero at an equilibrium.
    """

    mechanism: Mechanism
    q: np.ndarray
    v: np.ndarray
    t: float
    M: np.ndarray
    C: np.ndarray
    K: np.ndarray
    error: float
    acceleration: np.ndarray

    @property
    def at_equilibrium(self) -> bool:
        """Whether the mechanism can rest there."""
        return bool(not self.v.any() and np.abs(self.acceleration).max(initial=0.0) < 1e-8)

    @cached_property
    def undamped(self) -> bool:
        """Whether C is zero and K symmetric: then modes are real and the frequencies those of (K, M)."""
        stiffness = np.abs(self.K).max(initial=0.0)
        scale = np.sqrt(np.abs(self.M).max(initial=0.0) * stiffness) + 1e-300
        skew = np.abs(self.K - self.K.T).max(initial=0.0)
        return bool(np.abs(self.C).max(initial=0.0) <= UNDAMPED * scale and skew <= UNDAMPED * (stiffness + 1e-300))

    @cached_property
    def _squares(self) -> tuple[np.ndarray, np.ndarray]:
        from scipy.linalg import eigh

        values, modes = eigh((self.K + self.K.T) / 2, self.M)
        return values, modes

    @cached_property
    def state_matrix(self) -> np.ndarray:
        """A of ẋ = A x for x = (δ, δ̇), shape (2 nv, 2 nv)."""
        n = len(self.M)
        lower = -np.linalg.solve(self.M, np.hstack([self.K, self.C]))
        return np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), lower])

    @cached_property
    def eigenvalues(self) -> np.ndarray:
        """All 2 nv exponents λ of small motions e^(λ t), by size of their imaginary part [1/s]."""
        if self.undamped:
            roots = np.sqrt(-self._squares[0].astype(complex))
            values = np.concatenate([roots, -roots])
        else:
            values = np.linalg.eigvals(self.state_matrix)
        result: np.ndarray = values[np.lexsort((values.real, values.imag, np.abs(values.imag)))]
        return result

    @cached_property
    def _modal(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Frequencies, damping ratios and modes, the slowest first."""
        if self.undamped:
            squares, modes = self._squares
            frequencies = np.sqrt(squares.clip(0))
            damping = np.where(squares > 0, 0.0, np.nan)
            return frequencies, damping, _scaled(modes)
        n = len(self.M)
        values, vectors = np.linalg.eig(self.state_matrix)
        shapes = vectors[:n].copy()
        fast = np.abs(values.imag) > 1e-9 * np.abs(values).max(initial=0.0)
        pairs = np.flatnonzero(fast & (values.imag > 0))
        pairs = pairs[np.argsort(np.abs(values[pairs]))]
        # two real exponents stand for one motion that does not oscillate; the slower one shows its shape
        real = np.flatnonzero(~fast)
        real = real[np.argsort(-values[real].real)][: n - len(pairs)]
        chosen = np.concatenate([real, pairs])
        still = np.arange(n) < len(real)
        frequencies = np.where(still, 0.0, np.abs(values[chosen]))
        damping = np.where(still, np.nan, -values[chosen].real / np.where(still, 1.0, frequencies))
        return frequencies, damping, _scaled(shapes[:, chosen])

    @property
    def frequencies(self) -> np.ndarray:
        """Natural frequencies |λ|, shape (nv,), ascending; 0 for motions that do not oscillate [rad/s]."""
        return self._modal[0]

    @property
    def damping(self) -> np.ndarray:
        """Damping ratios −Re λ / |λ|, shape (nv,), as the frequencies; not a number where nothing oscillates."""
        return self._modal[1]

    @property
    def modes(self) -> np.ndarray:
        """Mode shapes as columns, shape (nv, nv), as the frequencies; the largest component is 1."""
        return self._modal[2]

    @property
    def stable(self) -> bool:
        """Whether no small deviation grows exponentially."""
        size = np.abs(self.eigenvalues).max(initial=0.0)
        return bool((self.eigenvalues.real <= 1e-7 * size).all())

    def __str__(self) -> str:
        m = self.mechanism
        at = ", ".join(f"{name} = {value:.6g}" for name, value in zip(m.coordinates, self.q, strict=True))
        kind = "equilibrium" if self.at_equilibrium else "state (no equilibrium)"
        lines = [f"{m.name} about the {'stable' if self.stable else 'unstable'} {kind} {at}"]
        for omega, zeta, mode in zip(self.frequencies, self.damping, self.modes.T, strict=True):
            shape = ", ".join(f"{x.real:+.4f}" if abs(x.imag) < 1e-12 else f"{x:+.4f}" for x in mode)
            motion = f"{omega:.9g} rad/s" if omega > 0 else "no oscillation"
            lines.append(f"  {motion}" + (f", damping {zeta:.3g}" if zeta > 1e-14 else "") + f": ({shape})")
        return "\n".join(lines)


def linearize(
    mechanism: Mechanism,
    at: Values | State | None = None,
    *,
    v: Values | None = None,
    t: float = 0.0,
    reference: Any = None,
) -> Linearization:
    """Linearize the equations of motion about a state.

    M a + bias − forces is differentiated by central differences of eighth order; `error` says how well that worked.
    About a state in motion the accelerations are held at the state's own.

    Args:
        mechanism: what moves.
        at: positions, shape (nq,) or by name, or a `State` with time and velocities; by default the equilibrium found
            from the neutral position.
        v: velocities, shape (nv,) or by name; zero by default.
        t: time [s].
        reference: the mechanism's `Reference`, if it is there already.

    Raises:
        InputError: if the state is not what is expected, or no equilibrium is found.
        UnknownNameError: if a coordinate or velocity does not exist.
    """
    t = finite(t, "the time t")
    if reference is None:
        from mecanique.reference import Reference

        reference = Reference(mechanism)
    if isinstance(at, State):
        t, v, at = float(at.t), at.v, at.q
    if at is None:
        from mecanique.motion.equilibrium import equilibrium_near

        at = equilibrium_near(mechanism, mechanism.neutral(), t, reference)
        if at is None:
            raise InputError(
                f"no equilibrium of {mechanism.name!r} was found from the neutral position; give one: "
                "linearize(mechanism, at={...}), or look for all with equilibria(mechanism)"
            )
    position, velocity = mechanism.position(at), mechanism.velocity(v)
    rates = Rates.of(mechanism)
    acceleration = reference.acceleration(position, velocity, t)

    def by_position(step: np.ndarray) -> np.ndarray:
        q = rates.moved(np.repeat(position[None], len(step), axis=0), step)
        many = np.repeat(velocity[None], len(step), axis=0)
        residual: np.ndarray = reference.inverse_dynamics(q, many, np.repeat(acceleration[None], len(step), axis=0), t)
        return residual

    def by_velocity(step: np.ndarray) -> np.ndarray:
        many = np.repeat(position[None], len(step), axis=0)
        a = np.repeat(acceleration[None], len(step), axis=0)
        residual: np.ndarray = reference.inverse_dynamics(many, velocity + step, a, t)
        return residual

    K, error_k = _slopes(by_position, mechanism.nv)
    C, error_c = _slopes(by_velocity, mechanism.nv)
    M = reference.mass_matrix(position, t)
    # what differs from symmetry by no more than the differences' error is symmetric
    if np.abs(K - K.T).max(initial=0.0) <= 1e-11 * np.abs(K).max(initial=0.0):
        K = (K + K.T) / 2
    return Linearization(mechanism, position, velocity, t, M, C, K, max(error_k, error_c), acceleration)


def frequency_response(linearization: Linearization, force: Values, frequencies: float | np.ndarray) -> np.ndarray:
    """Return the complex amplitude of the steady response to a harmonic force, shape (nv,) or (n, nv).

    (K − ω² M + i ω C) X = F; the response to F cos ωt is Re X e^(iωt) (Clough & Penzien, Dynamics of Structures, 1993,
    ch. 3).

    Args:
        linearization: about which state.
        force: amplitudes F of the generalized forces: shape (nv,), or by coordinate or velocity name.
        frequencies: ω, a number or shape (n,) [rad/s].

    Raises:
        InputError: if a value is not what is expected, or ω is an undamped natural frequency.
    """
    amplitude = linearization.mechanism.velocity(force)
    omega = np.atleast_1d(np.asarray(frequencies, dtype=float))
    if omega.ndim != 1 or not np.isfinite(omega).all():
        raise InputError(f"expected finite frequencies [rad/s], got {frequencies!r}")
    w = omega[:, None, None]
    stiffness = linearization.K - w**2 * linearization.M + 1j * w * linearization.C
    condition = np.linalg.cond(stiffness)
    if (condition > 1e14).any():
        at = omega[int(condition.argmax())]
        raise InputError(f"the response grows without bound at {at:.9g} rad/s, a natural frequency without damping")
    response: np.ndarray = np.linalg.solve(
        stiffness, np.broadcast_to(amplitude.astype(complex)[:, None], (*w.shape[:1], len(amplitude), 1))
    )[..., 0]
    return response if np.ndim(frequencies) else response[0]


def _slopes(function: Callable[[np.ndarray], np.ndarray], count: int) -> tuple[np.ndarray, float]:
    """Return ∂f/∂x as a matrix, and its error relative to its largest entry."""
    if not count:
        return np.zeros((0, 0)), 0.0
    best, error = np.zeros((count, count)), np.inf
    for h in STEPS:
        fine, coarse = _differences(function, count, h), _differences(function, count, 2 * h)
        scale = float(np.abs(fine).max())
        found = float(np.abs(fine - coarse).max()) / scale if scale > 0 else 0.0
        if found < error:
            best, error = fine, found
        if error < ACCURATE:
            break
    return best, error


def _differences(function: Callable[[np.ndarray], np.ndarray], count: int, h: float) -> np.ndarray:
    k = np.arange(1, 5) * h
    ahead = (np.eye(count)[:, None, :] * k[None, :, None]).reshape(-1, count)
    rise = (function(ahead) - function(-ahead)).reshape(count, 4, -1)
    slopes: np.ndarray = np.einsum("k,jki->ij", WEIGHTS, rise) / h
    return slopes


def _scaled(modes: np.ndarray) -> np.ndarray:
    """Scale each column so that its largest component, the first of equal ones, is 1."""
    sizes = np.abs(modes)
    largest = (sizes >= sizes.max(axis=0, initial=0.0) * (1 - 1e-9)).argmax(axis=0)
    scaled: np.ndarray = modes / modes[largest, np.arange(modes.shape[1])]
    return scaled
