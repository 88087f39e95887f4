"""Small motions about a state: M, C, K, natural frequencies, damping, modes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.errors import DerivationError
from mecanique.model.mechanism import Mechanism
from mecanique.model.units import add_unit, units
from mecanique.motion.simulation.arguments import Values
from mecanique.wording import write_table

if TYPE_CHECKING:
    from mecanique.derivation.printing.writers import Equation
    from mecanique.derivation.small_motions import Linearized
    from mecanique.motion.linear.comparison import Comparison
    from mecanique.motion.linear.response import Response
    from mecanique.motion.record.motion import Motion


UNDAMPED = 1e-10
"""C and the skew part of K below this fraction of their scale count as zero."""

_NO_SQUARE = 1e-14
"""ω² below this fraction of the largest is rounding: along it nothing pulls back."""


@final
@dataclass(frozen=True, eq=False)
class Linearization:
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
        return bool(not self.v.any() and np.abs(self.acceleration).max(initial=0.0) < 1e-8 * stiff)

    @cached_property
    def undamped(self) -> bool:
        """Whether C is zero and K symmetric, so that the modes are the real ones of (K, M)."""
        stiffness = np.abs(self.K).max(initial=0.0)
        scale = np.sqrt(np.abs(self.M).max(initial=0.0) * stiffness) + 1e-300
        skew = np.abs(self.K - self.K.T).max(initial=0.0)
        return bool(
            np.abs(self.C).max(initial=0.0) <= UNDAMPED * scale
            and skew <= UNDAMPED * (stiffness + 1e-300)
        )

    @cached_property
    def _squares(self) -> tuple[np.ndarray, np.ndarray]:
        from scipy.linalg import eigh

        values, modes = eigh((self.K + self.K.T) / 2, self.M)
        rounding = np.abs(values) <= _NO_SQUARE * np.abs(values).max(initial=0.0)
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
        fast = np.abs(values.imag) > 1e-9 * np.abs(values).max(initial=0.0)
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
        return bool((self.eigenvalues.real <= 1e-7 * size).all())

    @cached_property
    def symbolic(self) -> Linearized:
        """The same in letters: matrices, equations and, of one degree of freedom, the frequency.

        Raises:
            DerivationError: if there is no symbolic form, or the state is no equilibrium.
        """
        from mecanique.derivation import derive
        from mecanique.derivation.small_motions import linearize_equations

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
        from mecanique.motion.linear.response import response

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
        from mecanique.motion.linear.modes import mode_motion

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
        from mecanique.motion.linear.comparison import compare

        return compare(self, amplitude, mode=mode, tolerance=tolerance)

    def _repr_html_(self) -> str:
        head = ["ω [rad/s]", "damping", *map(add_unit, self.deviations, self.units)]
        rows = []
        for omega, zeta, mode in zip(self.frequencies, self.damping, self.modes.T, strict=True):
            shape = [f"{x.real:+.4f}" if abs(x.imag) < 1e-12 else f"{x:+.4f}" for x in mode]
            rows.append([f"{omega:.6g}", f"{zeta:.3g}", *shape])
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
            shape = ", ".join(
                f"{x.real:+.4f}" if abs(x.imag) < 1e-12 else f"{x:+.4f}" for x in mode
            )
            motion = f"{omega:.9g} rad/s" if omega > 0 else "no oscillation"
            lines.append(
                f"  {motion}" + (f", damping {zeta:.3g}" if zeta > 1e-14 else "") + f": ({shape})"
            )
        return "\n".join(lines)


def _scale(modes: np.ndarray) -> np.ndarray:
    """Scale each column so that its largest component, the first of equal ones, is 1."""
    if not modes.size:
        return modes
    sizes = np.abs(modes)
    largest = (sizes >= sizes.max(axis=0, initial=0.0) * (1 - 1e-9)).argmax(axis=0)
    scaled: np.ndarray = modes / modes[largest, np.arange(modes.shape[1])]
    return scaled
