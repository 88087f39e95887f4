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
from mecanique.model.mechanism_units import add_unit, characteristic_length, units
from mecanique.motion.linear.free_motions import drop_disturbances
from mecanique.motion.motion import Motion, simulate
from mecanique.motion.output.plot import new_figure
from mecanique.motion.record.curve import Curve
from mecanique.motion.record.events import Event
from mecanique.motion.record.rates import Rates
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
from mecanique.motion.trajectory import Statistics
from mecanique.wording import Legible, write_table

if TYPE_CHECKING:
    from mecanique.derivation.linear import Linearized
    from mecanique.derivation.printing.writers import Equation


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
        if frequencies is None:
            highest = float(self.frequencies.max(initial=0.0)) or 1.0
            # none of them is a rational multiple of the highest natural frequency with a small
            # denominator
            frequencies = np.linspace(0.0, 2 * highest, SAMPLES + 1)[1:] * (1 - 1e-4 / np.pi)
        omega = np.atleast_1d(np.asarray(frequencies, dtype=float))
        X = frequency_response(self, force, omega)
        return Response(self.deviations, self.units, omega, X)

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
        begin = perf_counter()
        chosen = _Mode.of(self, mode)
        size = chosen.usual if amplitude is None else finite(amplitude, "the amplitude")
        duration = finite(periods, "the number of periods") * chosen.period
        if not duration > 0:
            raise InputError(f"expected a positive number of periods, got {periods!r}")
        times = sample_times(0.0, duration, fps, None)  # refuses too many
        count = max(5, int(np.ceil(duration / chosen.period * NODES)) + 1)
        nodes = np.linspace(0.0, duration, count)
        q, v, a = chosen.move_on_loops(size, nodes)
        rates = Rates.of(self.mechanism)
        curve = Curve(t=nodes, q=q, v=v, a=a, breaks=np.array([0]), rates=rates)
        q, v, _ = chosen.move_on_loops(size, times)
        return Motion(
            mechanism=self.mechanism,
            t=times,
            q=q,
            v=v,
            path=curve,
            method=f"mode {chosen.index + 1} of the linear equations, "
            f"{1 / chosen.period:.6g} Hz, amplitude {size:.4g}",
            statistics=Statistics(0, 0, perf_counter() - begin, 0.0, 0.0),
        )

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
        tolerance = finite(tolerance, "the tolerance")
        if not 0 < tolerance < 1:
            raise InputError(f"expected a tolerance in 0…1, got {tolerance:g}")
        if not self.at_equilibrium:
            raise InputError(
                "expected a linearization about an equilibrium; "
                "look for one with equilibria(mechanism)"
            )
        if self.mechanism.constrained:
            raise InputError(
                "expected a mechanism without loops to compare its linear and exact motion"
            )
        undisturbed = replace(self, mechanism=drop_disturbances(self.mechanism))
        chosen = _Mode.of(undisturbed, mode)
        limit = _limit(chosen.differ, chosen.usual, tolerance)
        if amplitude is None:
            amplitude = limit if np.isfinite(limit) else chosen.usual
        amplitude = finite(amplitude, "the amplitude")
        if not amplitude > 0:
            raise InputError(f"expected a positive amplitude, got {amplitude:g}")
        motion = chosen.move_exactly(amplitude, 2 * chosen.period, samples=241)
        linear, _, _ = chosen.move(amplitude, motion.t - self.t)
        return Comparison(
            linearization=undisturbed,
            mode=chosen.index,
            amplitude=amplitude,
            tolerance=tolerance,
            limit=limit,
            motion=motion,
            linear=linear,
        )

    def say_place(self) -> str:
        """Return the coordinates as text."""
        # an equilibrium is found to rounding: no −8e-17
        places = zip(self.mechanism.coordinates, self.q, strict=True)
        return ", ".join(f"{name} = {round(x, 12) + 0.0:.6g}" for name, x in places)

    def _repr_html_(self) -> str:
        head = ["ω [rad/s]", "damping", *map(add_unit, self.deviations, self.units)]
        rows = []
        for omega, zeta, mode in zip(self.frequencies, self.damping, self.modes.T, strict=True):
            rows.append([f"{omega:.6g}", write_ratio(zeta, 3), *map(write_entry, mode)])
        caption, *_ = str(self).splitlines()
        return write_table(caption, [head, *rows])

    def __str__(self) -> str:
        m = self.mechanism
        kind = "equilibrium" if self.at_equilibrium else "state (no equilibrium)"
        stable = "stable" if self.stable else "unstable"
        lines = [f"{m.name} about the {stable} {kind} {self.say_place()}".rstrip()]
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


@final
@dataclass(frozen=True, eq=False)
class _Mode:
    """A mode that oscillates, δ = A Re(shape e^(λ t)), beside the exact motion from the same start.

    The exact one is that of the mechanism without what changes with time.
    """

    linearization: Linearization
    index: int
    root: complex  # λ [1/s]
    shape: np.ndarray  # shape (nv,)

    @classmethod
    def of(cls, linearization: Linearization, mode: int | None) -> _Mode:
        """Return a mode by its number, 0 for the slowest; by default the first that oscillates."""
        name, count = linearization.mechanism.name, len(linearization.M)
        frequencies, damping = linearization.frequencies, linearization.damping
        if mode is None:
            moving = np.flatnonzero((frequencies > 0) & (np.abs(damping) < 1))
            if not len(moving):
                raise InputError(f"no mode of {name!r} oscillates there")
            mode = int(moving[0])
        whole = isinstance(mode, (int, np.integer)) and not isinstance(mode, bool)
        if not whole or not 0 <= mode < count:
            raise InputError(f"expected a mode in 0…{count - 1}, 0 for the slowest, got {mode!r}")
        omega, zeta = float(frequencies[mode]), float(damping[mode])
        if not omega > 0 or not abs(zeta) < 1:
            raise InputError(f"mode {mode} of {name!r} does not oscillate")
        root = complex(-zeta * omega, omega * np.sqrt(1 - zeta**2))
        return cls(linearization, mode, root, linearization.modes[:, mode])

    @property
    def period(self) -> float:
        """Its period [s]."""
        return 2 * np.pi / abs(self.root.imag)

    @property
    def periodic(self) -> bool:
        """Whether the exact motion is periodic, too, so that its period can be measured."""
        return len(self.linearization.M) == 1 and self.linearization.undamped

    @property
    def usual(self) -> float:
        """An amplitude that is easily seen: 0.2 rad, or 0.2 characteristic lengths."""
        length = float(characteristic_length(self.linearization.mechanism))
        reach = np.array([length if unit == "m" else 1.0 for unit in self.linearization.units])
        return ANGLE * float((reach / np.abs(self.shape).clip(NO_COMPONENT)).min())

    def move(self, amplitude: float, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return q, v and v̇ of the linear motion at t [s]."""
        waves = amplitude * np.exp(self.root * t)[:, None] * self.shape
        rates = Rates.of(self.linearization.mechanism)
        at = np.repeat(self.linearization.q[None], len(t), axis=0)
        q = rates.normalize(rates.displace(at, waves.real))
        return q, (self.root * waves).real, (self.root**2 * waves).real

    def move_on_loops(
        self, amplitude: float, t: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the linear motion with its loops closed; wide straight deviations open them."""
        from mecanique.reference import Reference
        from mecanique.reference.loops.assembly import close_position

        mechanism, time = self.linearization.mechanism, self.linearization.t
        loops, rates = Reference.of(mechanism).closed, Rates.of(mechanism)
        if loops is None:
            return self.move(amplitude, t)
        h = TICK * self.period

        def place(shift: float) -> np.ndarray:
            straight, _, _ = self.move(amplitude, t + shift)
            return np.array([close_position(loops, q, time) for q in straight])

        before, q, after = place(-h), place(0.0), place(h)
        v = rates.velocities(q, (after - before) / (2 * h))
        a = rates.velocities(q, (after - 2 * q + before) / h**2)
        return q, v, a

    def move_exactly(self, amplitude: float, span: float, **options: Any) -> Motion:
        """Return the exact motion for a time [s]."""
        q, v, _ = self.move(amplitude, np.zeros(1))
        return simulate(
            self.linearization.mechanism,
            q=q[0],
            v=v[0],
            duration=span,
            t0=self.linearization.t,
            rtol=AMPLITUDE_RTOL,
            method="dop853",
            **options,
        )

    def measure_period(self, amplitude: float) -> float:
        """Return the exact period: until the velocity is zero again on the side it came from."""
        span = LONGEST * self.period
        back = Event("back", self.linearization.mechanism.velocities[0], -1, stop=True)
        step = span / LONGEST / 8
        motion = self.move_exactly(amplitude, span, events=[back], samples=2, max_step=step)
        times = motion.times("back")
        return float(times[0]) - self.linearization.t if len(times) else np.inf

    def differ(self, amplitude: float) -> float:
        """Return the relative difference, infinite where the exact motion fails or is none."""
        try:
            if self.periodic:
                return abs(self.measure_period(amplitude) / self.period - 1)
            motion = self.move_exactly(amplitude, self.period, samples=121)
        except IntegrationError:
            return np.inf
        linear, _, _ = self.move(amplitude, motion.t - self.linearization.t)
        return float(np.abs(motion.q - linear).max()) / amplitude


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
        return self._mode.period

    @cached_property
    def exact_period(self) -> float | None:
        """Period of the exact motion; None if it has none, or does not return [s]."""
        if not self._mode.periodic:
            return None
        period = self._mode.measure_period(self.amplitude)
        return period if np.isfinite(period) else None

    @cached_property
    def difference(self) -> float:
        """The relative difference; infinite if the exact motion does not return."""
        return self._mode.differ(self.amplitude)

    @property
    def measure(self) -> str:
        """What the difference is of: "period" or "motion"."""
        return "period" if self._mode.periodic else "motion"

    @cached_property
    def _mode(self) -> _Mode:
        return _Mode.of(self.linearization, self.mode)

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
