"""The steady response of small motions to a harmonic force, over its frequency."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, final

import numpy as np

from mecanique.errors import InputError, UnknownNameError
from mecanique.model.units import add_unit
from mecanique.motion.linear.linearization import Linearization
from mecanique.motion.simulation.arguments import Values

SAMPLES = 400
"""Number of frequencies where none are given."""


@final
@dataclass(frozen=True, eq=False)
class Response:
    """Steady motion δ = Re X e^(iωt) under generalized forces F cos ωt, ready to be plotted.

    Args:
        names: of the coordinates that respond.
        units: their units.
        frequencies: shape (n,), ω [rad/s].
        X: shape (n, nv), complex amplitudes.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    frequencies: np.ndarray
    X: np.ndarray

    @property
    def amplitude(self) -> np.ndarray:
        """|X|, shape (n, nv)."""
        size: np.ndarray = np.abs(self.X)
        return size

    @property
    def phase(self) -> np.ndarray:
        """By how much the motion lags behind the force, in 0…2π, shape (n, nv) [rad]."""
        lag: np.ndarray = np.mod(-np.angle(self.X), 2 * np.pi)
        return lag

    def __getitem__(self, name: str) -> np.ndarray:
        """Return the complex amplitude of one coordinate, shape (n,)."""
        if name not in self.names:
            raise UnknownNameError("coordinate", name, self.names)
        column: np.ndarray = self.X[:, self.names.index(name)]
        return column

    def plot(self) -> Any:
        """Plot amplitude and phase over the frequency; return the matplotlib Figure.

        Raises:
            InputError: if matplotlib is not installed.
        """
        try:
            from matplotlib.figure import Figure
        except ImportError:
            raise InputError(
                "plots need matplotlib; install it, e.g. pip install matplotlib"
            ) from None
        figure = Figure(layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True)
        for k, (name, unit) in enumerate(zip(self.names, self.units, strict=True)):
            above.semilogy(self.frequencies, self.amplitude[:, k], label=add_unit(name, unit))
            below.plot(self.frequencies, self.phase[:, k])
        above.set_ylabel("amplitude")
        above.legend()
        below.set_ylabel("phase lag [rad]")
        below.set_xlabel("ω [rad/s]")
        return figure


def response(
    linearization: Linearization, force: Values, frequencies: np.ndarray | None = None
) -> Response:
    """Return the steady response to a harmonic force over its frequency.

    Args:
        linearization: about which state.
        force: amplitudes F of the generalized forces: shape (nv,), or by coordinate or velocity
            name.
        frequencies: ω, shape (n,) [rad/s]; by default 400 up to twice the highest natural
            frequency.

    Raises:
        InputError: if a value is not what is expected, or ω is an undamped natural frequency.
    """
    if frequencies is None:
        highest = float(linearization.frequencies.max(initial=0.0)) or 1.0
        # none of them is a rational multiple of the highest natural frequency with a small
        # denominator
        frequencies = np.linspace(0.0, 2 * highest, SAMPLES + 1)[1:] * (1 - 1e-4 / np.pi)
    omega = np.atleast_1d(np.asarray(frequencies, dtype=float))
    X = frequency_response(linearization, force, omega)
    return Response(linearization.deviations, linearization.units, omega, X)


def frequency_response(
    linearization: Linearization, force: Values, frequencies: float | np.ndarray
) -> np.ndarray:
    """Return the complex amplitude of the steady response, shape (nv,) or (n, nv).

    (K − ω² M + i ω C) X = F; the response to F cos ωt is Re X e^(iωt) (Clough & Penzien, Dynamics
    of Structures, 1993, ch. 3).

    Args:
        linearization: about which state.
        force: amplitudes F of the generalized forces: shape (nv,), or by coordinate or velocity
            name.
        frequencies: ω, a number or shape (n,) [rad/s].

    Returns:
        The amplitudes of displacement, along the velocities, by frequency.

    Raises:
        InputError: if a value is not what is expected, or ω is an undamped natural frequency.

    Example:
        >>> blocks = mq.linearize(mq.textbook.load("two_blocks"))
        >>> abs(mq.frequency_response(blocks, {"q2": 1.0}, [0.0, 3.0])).round(4)
        array([[0.025 , 0.075 ],
               [0.3226, 0.6774]])
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
        raise InputError(
            f"the response grows without bound at {at:.9g} rad/s, "
            "a natural frequency without damping"
        )
    along = linearization.tangent.T @ amplitude
    moved = np.linalg.solve(
        stiffness, np.broadcast_to(along.astype(complex)[:, None], (len(omega), len(along), 1))
    )
    found: np.ndarray = moved[..., 0] @ linearization.tangent.T
    return found if np.ndim(frequencies) else found[0]
