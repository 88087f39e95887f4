"""Small motions about a state: M, C, K, natural frequencies, damping, modes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from time import perf_counter
from typing import TYPE_CHECKING, Any, final

import numpy as np

from mecanique.errors import DerivationError, InputError, IntegrationError, UnknownNameError
from mecanique.model.expression import finite
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import add_unit, units
from mecanique.motion.linear.equilibrium import drop_disturbances
from mecanique.motion.motion import Motion, simulate
from mecanique.motion.output.plot import new_figure
from mecanique.motion.record.curve import Curve
from mecanique.motion.record.events import Event
from mecanique.motion.record.rates import Rates
from mecanique.motion.record.trajectory import Statistics
from mecanique.motion.simulation.problem import Values, sample_times
from mecanique.motion.tolerances import (
    ACCELERATES,
    ALIKE,
    AMPLITUDE_RTOL,
    KINKED,
    NO_COMPONENT,
    NO_DAMPING,
    NO_SQUARE,
    OSCILLATES,
    SAME_AMPLITUDE,
    SAME_MOTION,
    STABLE,
    TINY,
    UNDAMPED,
)
from mecanique.wording import Legible, write_table

if TYPE_CHECKING:
    from mecanique.derivation.linear import Linearized
    from mecanique.derivation.printing.writers import Equation
    from mecanique.reference import Reference


@final
@dataclass(frozen=True, eq=False, repr=False)
class Linearization(Legible):
    """M δ̈ + C δ̇ + K δ = 0 for small deviations δ from a state.

    Where v is not q̇, δ is a displacement along v. In a mechanism with loops M, C and K are those
    of n independent deviations; the others follow by `tangent`.

    Args:
        mechanism: what moves.
        q: shape (nq,), positions.
        v: shape (nv,), velocities.
        t: time [s].
        M: shape (n, n), mass matrix; n = nv without loops.
        C: shape (n, n), ∂/∂v of M a + bias − forces.
        K: shape (n, n), ∂/∂q of M a + bias − forces.
        error: estimate of the error of C and K, relative to the largest entry of each.
        acceleration: shape (nv,), of the state itself; zero at an equilibrium.
        tangent: shape (nv, n), deviations along all velocities by the independent ones; unity
            without loops.
        chosen: which equilibrium it is and how it was found; about a state that was given, what
            it left out, or "".

    Example:
        >>> small = mq.linearize(mq.textbook.load("two_blocks"))
        >>> small.frequencies.round(3)
        array([3.162, 6.325])
        >>> small.modes.round(3)
        array([[ 0.5,  1. ],
               [ 1. , -1. ]])
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
    tangent: np.ndarray
    chosen: str = ""

    @property
    def deviations(self) -> tuple[str, ...]:
        """Names of all deviations, one per velocity: the coordinate's, or δ and the velocity's."""
        return tuple(v[:-1] if v.endswith("'") else f"δ{v}" for v in self.mechanism.velocities)

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each deviation; "" where it is not known."""
        known = units(self.mechanism)
        return tuple(
            known[v[:-1]] if v.endswith("'") else known[v].removesuffix("/s")
            for v in self.mechanism.velocities
        )

    @property
    def at_equilibrium(self) -> bool:
        """Whether the mechanism can rest there."""
        # a position that is off by 1e-11 accelerates by this times the stiffness
        stiff = max(1.0, 1e-3 * float((np.abs(self.eigenvalues) ** 2).max(initial=0.0)))
        return bool(
            not self.v.any() and np.abs(self.acceleration).max(initial=0.0) < ACCELERATES * stiff
        )

    @cached_property
    def undamped(self) -> bool:
        """Whether C is zero and K symmetric, so that the modes are the real ones of (K, M)."""
        stiffness = np.abs(self.K).max(initial=0.0)
        scale = np.sqrt(np.abs(self.M).max(initial=0.0) * stiffness) + TINY
        skew = np.abs(self.K - self.K.T).max(initial=0.0)
        return bool(
            np.abs(self.C).max(initial=0.0) <= UNDAMPED * scale
            and skew <= UNDAMPED * (stiffness + TINY)
        )

    @cached_property
    def _squares(self) -> tuple[np.ndarray, np.ndarray]:
        from scipy.linalg import eigh

        values, modes = eigh((self.K + self.K.T) / 2, self.M)
        rounding = np.abs(values) <= NO_SQUARE * np.abs(values).max(initial=0.0)
        return np.where(rounding, 0.0, values), modes

    @cached_property
    def state_matrix(self) -> np.ndarray:
        """A of ẋ = A x for x = (δ, δ̇), shape (2 n, 2 n)."""
        n = len(self.M)
        lower = -np.linalg.solve(self.M, np.hstack([self.K, self.C]))
        return np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), lower])

    @cached_property
    def eigenvalues(self) -> np.ndarray:
        """All 2 n exponents λ of small motions e^(λ t), by size of their imaginary part [1/s]."""
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
            return frequencies, damping, _scale(self.tangent @ modes)
        n = len(self.M)
        values, vectors = np.linalg.eig(self.state_matrix)
        shapes = vectors[:n].copy()
        fast = np.abs(values.imag) > OSCILLATES * np.abs(values).max(initial=0.0)
        pairs = np.flatnonzero(fast & (values.imag > 0))
        pairs = pairs[np.argsort(np.abs(values[pairs]))]
        # two real exponents stand for one motion that does not oscillate; the slower one shows its
        # shape
        real = np.flatnonzero(~fast)
        real = real[np.argsort(-values[real].real)][: n - len(pairs)]
        chosen = np.concatenate([real, pairs])
        still = np.arange(n) < len(real)
        frequencies = np.where(still, 0.0, np.abs(values[chosen]))
        damping = np.where(still, np.nan, -values[chosen].real / np.where(still, 1.0, frequencies))
        return frequencies, damping, _scale(self.tangent @ shapes[:, chosen])

    @property
    def frequencies(self) -> np.ndarray:
        """Natural frequencies `|λ|`, shape (n,), ascending; 0 where nothing oscillates [rad/s]."""
        return self._modal[0]

    @property
    def damping(self) -> np.ndarray:
        """Damping ratios `−Re λ / |λ|`, shape (n,), NaN where nothing oscillates."""
        return self._modal[1]

    @property
    def modes(self) -> np.ndarray:
        """Mode shapes as columns, shape (nv, n), each with a largest component of 1."""
        return self._modal[2]

    @property
    def stable(self) -> bool:
        """Whether no small deviation grows exponentially."""
        size = np.abs(self.eigenvalues).max(initial=0.0)
        return bool((self.eigenvalues.real <= STABLE * size).all())

    @cached_property
    def symbolic(self) -> Linearized:
        """The same in letters: matrices, equations and, of one degree of freedom, the frequency.

        Raises:
            DerivationError: if there is no symbolic form, or the state is no equilibrium.
        """
        from mecanique.derivation import derive
        from mecanique.derivation.linear import linearize_equations

        if self.mechanism.constrained:
            raise DerivationError(
                f"mechanism {self.mechanism.name!r} has loops, and M, "
                "C and K with loops have no closed form here"
            )
        if self.v.any():
            raise DerivationError(
                "the symbolic linear equations are about an equilibrium, "
                "not about a state in motion"
            )
        place = dict(zip(self.mechanism.coordinates, self.q.tolist(), strict=True))
        return linearize_equations(derive(self.mechanism).derivation, place)

    @property
    def equations(self) -> tuple[Equation, ...]:
        """The linear equations as a textbook prints them, e.g. q'' + 3 g q/(2 l) = 0.

        Raises:
            DerivationError: if there is no symbolic form, or the state is no equilibrium.
        """
        return self.symbolic.equations

    def text(self) -> str:
        """Return the linear equations M q'' + C q' + K q = f in letters, as text.

        Raises:
            DerivationError: if there is no symbolic form, or the state is no equilibrium.
        """
        return self.symbolic.text()

    def latex(self) -> str:
        """Return the linear equations in letters, in LaTeX.

        Raises:
            DerivationError: if there is no symbolic form, or the state is no equilibrium.
        """
        return self.symbolic.latex()

    def mathml(self) -> str:
        """Return the linear equations in letters, in MathML.

        Raises:
            DerivationError: if there is no symbolic form, or the state is no equilibrium.
        """
        return self.symbolic.mathml()

    def response(self, force: Values, frequencies: np.ndarray | None = None) -> Response:
        """Return the steady response to a harmonic force over its frequency.

        Args:
            force: amplitudes F of the generalized forces: shape (nv,), or by coordinate or velocity
                name.
            frequencies: ω, shape (n,) [rad/s]; by default 400 up to twice the highest natural
                frequency.

        Raises:
            InputError: if a value is not what is expected, or ω is an undamped natural frequency.
        """
        return response(self, force, frequencies)

    def motion(
        self,
        mode: int | None = None,
        amplitude: float | None = None,
        *,
        periods: float = 3.0,
        fps: float = 60.0,
    ) -> Motion:
        """Return a mode as a `Motion`: the linear solution, not one of the exact equations.

        Args:
            mode: which one, 0 for the slowest; by default the slowest that oscillates.
            amplitude: of the mode's largest component [rad or m]; by default 0.2 rad or a fifth of
                the mechanism's typical length.
            periods: how many periods.
            fps: samples per second.

        Raises:
            InputError: if there is no such mode, or it does not oscillate.
        """
        return mode_motion(self, mode, amplitude, periods=periods, fps=fps)

    def compare(
        self, amplitude: float | None = None, *, mode: int | None = None, tolerance: float = 0.01
    ) -> Comparison:
        """Compare a mode by the linear and by the exact equations.

        Args:
            amplitude: of the mode's largest component [rad or m]; by default the one at which they
                differ by the tolerance.
            mode: which one, 0 for the slowest; by default the slowest that oscillates.
            tolerance: the relative difference for which the amplitude is sought.

        Raises:
            InputError: if there is no such mode, it does not oscillate, or the state is no
                equilibrium.
        """
        return compare(self, amplitude, mode=mode, tolerance=tolerance)

    def _repr_html_(self) -> str:
        head = ["ω [rad/s]", "damping", *map(add_unit, self.deviations, self.units)]
        rows = []
        for omega, zeta, mode in zip(self.frequencies, self.damping, self.modes.T, strict=True):
            rows.append([f"{omega:.6g}", write_ratio(zeta, 3), *map(write_entry, mode)])
        caption, *_ = str(self).splitlines()
        return write_table(caption, [head, *rows])

    def __str__(self) -> str:
        m = self.mechanism
        # an equilibrium is found to rounding: no −8e-17
        at = ", ".join(
            f"{name} = {round(x, 12) + 0.0:.6g}"
            for name, x in zip(m.coordinates, self.q, strict=True)
        )
        kind = "equilibrium" if self.at_equilibrium else "state (no equilibrium)"
        stable = "stable" if self.stable else "unstable"
        lines = [f"{m.name} about the {stable} {kind} {at}".rstrip()]
        if self.chosen:
            lines.append(f"  {self.chosen}")
        if not len(self.M):
            lines.append("  nothing can move there, so there is no mode")
        for omega, zeta, mode in zip(self.frequencies, self.damping, self.modes.T, strict=True):
            shape = ", ".join(map(write_entry, mode))
            motion = f"{omega:.9g} rad/s" if omega > 0 else "no oscillation"
            lines.append(
                f"  {motion}"
                + (f", damping {zeta:.3g}" if zeta > NO_DAMPING else "")
                + f": ({shape})"
            )
        return "\n".join(lines)


def write_entry(x: complex) -> str:
    """Return a component of a mode's shape as text, to four digits."""
    # adding zero turns the -0 that rounding leaves into 0
    real, imaginary = round(x.real, 4) + 0.0, round(x.imag, 4) + 0.0
    return f"{real:+.4f}" if abs(x.imag) < ALIKE else f"{complex(real, imaginary):+.4f}"


def write_ratio(zeta: float, digits: int) -> str:
    """Return a damping ratio as text; "none" where nothing oscillates."""
    return "none" if np.isnan(zeta) else f"{round(zeta, 12) + 0.0:.{digits}g}"


def _scale(modes: np.ndarray) -> np.ndarray:
    """Scale each column so that its largest component, the first of equal ones, is 1."""
    if not modes.size:
        return modes
    sizes = np.abs(modes)
    largest = (sizes >= sizes.max(axis=0, initial=0.0) * (1 - ALIKE)).argmax(axis=0)
    scaled: np.ndarray = modes / modes[largest, np.arange(modes.shape[1])]
    return scaled


NODES = 32
"""Points per period between which the linear motion is interpolated."""

TICK = 1e-4
"""Step, in periods, of the differences that give the rates of a mode with loops."""

ANGLE = 0.2
"""Amplitude that is easily seen [rad]."""


def mode_motion(
    linearization: Linearization,
    mode: int | None,
    amplitude: float | None,
    *,
    periods: float,
    fps: float,
) -> Motion:
    """Return a mode, the slowest that oscillates by default, as a motion."""
    begin = perf_counter()
    mode = slowest(linearization) if mode is None else mode
    root, _ = chosen_mode(linearization, mode)
    size = (
        usual_amplitude(linearization, mode)
        if amplitude is None
        else finite(amplitude, "the amplitude")
    )
    period = 2 * np.pi / abs(root.imag)
    duration = finite(periods, "the number of periods") * period
    if not duration > 0:
        raise InputError(f"expected a positive number of periods, got {periods!r}")
    times = sample_times(0.0, duration, fps, None)  # refuses too many
    nodes = np.linspace(0.0, duration, max(5, int(np.ceil(duration / period * NODES)) + 1))
    mechanism, rates = linearization.mechanism, Rates.of(linearization.mechanism)
    q, v, a = _closed_solution(linearization, mode, size, nodes)
    curve = Curve(t=nodes, q=q, v=v, a=a, breaks=np.array([0]), rates=rates)
    q, v, _ = _closed_solution(linearization, mode, size, times)
    frequency = abs(root.imag) / (2 * np.pi)
    text = f"mode {mode + 1} of the linear equations, {frequency:.6g} Hz, amplitude {size:.4g}"
    statistics = Statistics(0, 0, perf_counter() - begin, 0.0, 0.0)
    return Motion(
        mechanism=mechanism, t=times, q=q, v=v, path=curve, method=text, statistics=statistics
    )


def slowest(linearization: Linearization) -> int:
    """Return the slowest mode that oscillates."""
    moving = np.flatnonzero((linearization.frequencies > 0) & (np.abs(linearization.damping) < 1))
    if not len(moving):
        raise InputError(f"no mode of {linearization.mechanism.name!r} oscillates there")
    return int(moving[0])


def chosen_mode(linearization: Linearization, mode: int) -> tuple[complex, np.ndarray]:
    """Return exponent λ and shape of a mode that oscillates; 0 is the slowest."""
    count = len(linearization.M)
    if isinstance(mode, bool) or not isinstance(mode, (int, np.integer)) or not 0 <= mode < count:
        raise InputError(f"expected a mode in 0…{count - 1}, 0 for the slowest, got {mode!r}")
    omega, zeta = float(linearization.frequencies[mode]), float(linearization.damping[mode])
    if not omega > 0 or not abs(zeta) < 1:
        raise InputError(f"mode {mode} of {linearization.mechanism.name!r} does not oscillate")
    return complex(-zeta * omega, omega * np.sqrt(1 - zeta**2)), linearization.modes[:, mode]


def linear_solution(
    linearization: Linearization, mode: int, amplitude: float, t: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return q, v and v̇ of the linear motion in one mode, δ = A Re(shape e^(λt)), at t [s]."""
    root, shape = chosen_mode(linearization, mode)
    waves = amplitude * np.exp(root * t)[:, None] * shape
    rates = Rates.of(linearization.mechanism)
    at = np.repeat(linearization.q[None], len(t), axis=0)
    q = rates.normalize(rates.displace(at, waves.real))
    return q, (root * waves).real, (root**2 * waves).real


def _closed_solution(
    linearization: Linearization, mode: int, amplitude: float, t: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the linear motion with its loops closed; wide straight deviations open them."""
    from mecanique.reference import Reference
    from mecanique.reference.loops.assembly import close_position

    loops, rates = Reference.of(linearization.mechanism).closed, Rates.of(linearization.mechanism)
    if loops is None:
        return linear_solution(linearization, mode, amplitude, t)
    h = TICK * 2 * np.pi / abs(chosen_mode(linearization, mode)[0].imag)

    def place(shift: float) -> np.ndarray:
        straight, _, _ = linear_solution(linearization, mode, amplitude, t + shift)
        return np.array([close_position(loops, q, linearization.t) for q in straight])

    before, q, after = place(-h), place(0.0), place(h)
    v = rates.velocities(q, (after - before) / (2 * h))
    a = rates.velocities(q, (after - 2 * q + before) / h**2)
    return q, v, a


def usual_amplitude(linearization: Linearization, mode: int) -> float:
    """Return an amplitude that is easily seen: 0.2 rad, or 0.2 characteristic lengths."""
    _, shape = chosen_mode(linearization, mode)
    length = _length(linearization)
    reach = np.array([length if unit == "m" else 1.0 for unit in linearization.units])
    return ANGLE * float((reach / np.abs(shape).clip(NO_COMPONENT)).min())


def _length(linearization: Linearization) -> float:
    from mecanique.model.mechanism_units import characteristic_length

    return float(characteristic_length(linearization.mechanism))


SAMPLES = 400
"""Number of frequencies where none are given."""


@final
@dataclass(frozen=True, eq=False, repr=False)
class Response(Legible):
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
        figure = new_figure()
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
    """Return the steady response to a harmonic force, shape (nv,), over its frequency [rad/s]."""
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
    amplitudes: np.ndarray = moved[..., 0] @ linearization.tangent.T
    return amplitudes if np.ndim(frequencies) else amplitudes[0]


LONGEST = 20.0
"""A motion that has not returned after this many linear periods is no longer an oscillation."""

ROUNDS = 40
"""Largest number of amplitudes to try."""


@final
@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Legible):
    """A mode by the linear and by the exact equations, started alike.

    For one degree of freedom without damping the difference is that of the periods, relative to the
    linear one; in general it is the largest distance between the two motions within a linear
    period, relative to the amplitude.

    Args:
        linearization: about which state.
        mode: which mode.
        amplitude: of its largest component [rad or m].
        tolerance: the relative difference that `limit` is for.
        limit: the amplitude at which linear and exact motion differ by that; infinite if they never
            do.
        motion: the exact motion, over two linear periods.
        linear: shape (n, nq), the linear motion at the same times.
    """

    linearization: Linearization
    mode: int
    amplitude: float
    tolerance: float
    limit: float
    motion: Motion
    linear: np.ndarray

    @property
    def t(self) -> np.ndarray:
        """Times of both motions, shape (n,) [s]."""
        return self.motion.t

    @property
    def exact(self) -> np.ndarray:
        """The motion by the exact equations, shape (n, nq)."""
        return self.motion.q

    @property
    def linear_period(self) -> float:
        """Period of the linear motion [s]."""
        return _period(self.linearization, self.mode)

    @cached_property
    def exact_period(self) -> float | None:
        """Period of the exact motion; None if it has none, or does not return [s]."""
        if not _periodic(self.linearization):
            return None
        period = _exact_period(self.linearization, self.mode, self.amplitude, self.motion.reference)
        return period if np.isfinite(period) else None

    @cached_property
    def difference(self) -> float:
        """The relative difference; infinite if the exact motion does not return."""
        return _difference(self.linearization, self.mode, self.motion.reference)(self.amplitude)

    @property
    def measure(self) -> str:
        """What the difference is of: "period" or "motion"."""
        return "period" if _periodic(self.linearization) else "motion"

    def __str__(self) -> str:
        largest = int(np.abs(self.linearization.modes[:, self.mode]).argmax())
        name, unit = self.linearization.deviations[largest], self.linearization.units[largest]
        start = f"{name} = {self.amplitude:.6g} {unit}".rstrip()
        lines = [
            f"{self.linearization.mechanism.name}, mode {self.mode + 1}, "
            f"started {start} from the equilibrium"
        ]
        lines.append(f"  linear period {self.linear_period:.9g} s")
        if self.measure == "period":
            period = self.exact_period
            lines.append(
                "  exact period  "
                + ("none: it does not return" if period is None else f"{period:.9g} s")
            )
        lines.append(f"  {self.measure} differs by {self.difference:.3%}")
        if np.isfinite(self.limit):
            wide = f"{self.limit:.6g} {unit}".rstrip()
            lines.append(f"  it differs by {self.tolerance:.3g} from the amplitude {wide} on")
        else:
            lines.append("  linear and exact motion are the same at any amplitude tried")
        return "\n".join(lines)


def compare(
    linearization: Linearization,
    amplitude: float | None = None,
    *,
    mode: int | None = None,
    tolerance: float = 0.01,
) -> Comparison:
    """Return a mode by the linear and by the exact equations side by side."""
    tolerance = finite(tolerance, "the tolerance")
    if not 0 < tolerance < 1:
        raise InputError(f"expected a tolerance in 0…1, got {tolerance:g}")
    if not linearization.at_equilibrium:
        raise InputError(
            "expected a linearization about an equilibrium; look for one with equilibria(mechanism)"
        )
    if linearization.mechanism.constrained:
        raise InputError(
            "expected a mechanism without loops to compare its linear and exact motion"
        )
    from mecanique.reference import Reference

    mode = slowest(linearization) if mode is None else mode
    linearization = replace(linearization, mechanism=drop_disturbances(linearization.mechanism))
    reference = Reference.of(linearization.mechanism)
    usual = usual_amplitude(linearization, mode)
    limit = _limit(_difference(linearization, mode, reference), usual, tolerance)
    if amplitude is None:
        amplitude = limit if np.isfinite(limit) else usual
    amplitude = finite(amplitude, "the amplitude")
    if not amplitude > 0:
        raise InputError(f"expected a positive amplitude, got {amplitude:g}")
    span = 2 * _period(linearization, mode)
    motion = _exact(linearization, mode, amplitude, reference, span, samples=241)
    linear, _, _ = linear_solution(linearization, mode, amplitude, motion.t - linearization.t)
    return Comparison(
        linearization=linearization,
        mode=mode,
        amplitude=amplitude,
        tolerance=tolerance,
        limit=limit,
        motion=motion,
        linear=linear,
    )


def _period(linearization: Linearization, mode: int) -> float:
    root, _ = chosen_mode(linearization, mode)
    return 2 * np.pi / abs(root.imag)


def _periodic(linearization: Linearization) -> bool:
    """Whether every motion is periodic, so that its period can be measured."""
    return len(linearization.M) == 1 and linearization.undamped


def _exact(
    linearization: Linearization,
    mode: int,
    amplitude: float,
    reference: Reference,
    span: float,
    **options: Any,
) -> Motion:
    q, v, _ = linear_solution(linearization, mode, amplitude, np.zeros(1))
    return simulate(
        linearization.mechanism,
        q=q[0],
        v=v[0],
        duration=span,
        t0=linearization.t,
        rtol=AMPLITUDE_RTOL,
        method="dop853",
        reference=reference,
        **options,
    )


def _exact_period(
    linearization: Linearization, mode: int, amplitude: float, reference: Reference
) -> float:
    """Until the velocity is zero again on the side it started from."""
    span = LONGEST * _period(linearization, mode)
    back = Event("back", linearization.mechanism.velocities[0], -1, stop=True)
    motion = _exact(
        linearization,
        mode,
        amplitude,
        reference,
        span,
        events=[back],
        samples=2,
        max_step=span / LONGEST / 8,
    )
    times = motion.times("back")
    return float(times[0]) - linearization.t if len(times) else np.inf


def _difference(
    linearization: Linearization, mode: int, reference: Reference
) -> Callable[[float], float]:
    """The relative difference by amplitude."""
    period = _period(linearization, mode)

    def of_periods(amplitude: float) -> float:
        try:
            return abs(_exact_period(linearization, mode, amplitude, reference) / period - 1)
        except IntegrationError:
            return np.inf

    def of_motions(amplitude: float) -> float:
        try:
            motion = _exact(linearization, mode, amplitude, reference, period, samples=121)
        except IntegrationError:
            return np.inf
        linear, _, _ = linear_solution(linearization, mode, amplitude, motion.t - linearization.t)
        return float(np.abs(motion.q - linear).max()) / amplitude

    return of_periods if _periodic(linearization) else of_motions


def _limit(difference: Callable[[float], float], start: float, tolerance: float) -> float:
    """Return the amplitude of a given difference, by a bounded secant method in logarithms."""
    low, high, amplitude, power = 0.0, np.inf, start / 4, 2.0
    before: tuple[float, float] | None = None
    for _ in range(ROUNDS):
        deviation = difference(amplitude)
        if np.isfinite(deviation) and abs(deviation / tolerance - 1) < SAME_AMPLITUDE:
            return amplitude
        if deviation > tolerance:
            high = min(high, amplitude)
        else:
            low = max(low, amplitude)
        if amplitude > 1e3 * start and deviation < SAME_MOTION:
            return np.inf
        if (
            before is not None
            and np.isfinite(deviation)
            and deviation > SAME_MOTION
            and before[1] > SAME_MOTION
            and amplitude != before[0]
        ):
            slope = np.log(deviation / before[1]) / np.log(amplitude / before[0])
            power = slope if 0.2 < slope < 8 else power
        if np.isfinite(deviation):
            before = (amplitude, deviation)
            amplitude = amplitude * float(
                np.clip((tolerance / max(deviation, SAME_MOTION)) ** (1 / power), 0.125, 8)
            )
        else:
            amplitude = (low + high) / 2
        if not low < amplitude < high:
            amplitude = (low + high) / 2 if np.isfinite(high) else 2 * low
        if high < KINKED * start:
            raise InputError(
                "the linear and the exact motion differ however small they are: the forces have a "
                "kink there"
            )
        if np.isfinite(high) and high - low < ALIKE * high:
            break
    # where the difference jumps, e.g. as a spring is turned inside out, steps may just miss it
    return low * (1 - 1e-4) if np.isfinite(high) else np.inf
