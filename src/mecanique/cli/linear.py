"""Print small motions and checks of the ground: in letters, in numbers, as JSON, as CSV."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from mecanique.cli.printing import to_json
from mecanique.errors import DerivationError

if TYPE_CHECKING:
    from mecanique.motion.inertial import InertialCheck
    from mecanique.motion.linear.linearization import Linearization, Response
    from mecanique.motion.linear.speeds import SpeedMatrices, SpeedRange
    from mecanique.motion.linear.steady import SteadyLinearization


def small_motions(linearization: Linearization) -> str:
    """Return a linearization as text: equations in letters, matrices and modes in numbers."""
    if not len(linearization.M):
        return str(linearization)
    lines = [_letters(linearization), ""]
    names = _independent(linearization)
    lines.append(
        f"In numbers (SI), about the {'stable' if linearization.stable else 'unstable'} equilibrium"
    )
    lines.append(f"({linearization.chosen})")
    lines.append(f"  {linearization.say_place()}")
    for letter, matrix in (("M", linearization.M), ("C", linearization.C), ("K", linearization.K)):
        lines.append(f"{letter}, rows and columns {', '.join(names)}")
        lines += [_matrix_row(row) for row in _clean(matrix)]
    lines.append(
        f"{'mode':>4}  {'rad/s':>12}  {'Hz':>12}  {'damping':>9}  shape "
        f"({', '.join(linearization.deviations)})"
    )
    lines += _modes(linearization)
    return "\n".join(lines)


def figures(linearization: Linearization) -> str:
    """Return a linearization as JSON."""
    m = linearization.mechanism
    try:
        symbolic: dict[str, Any] = {
            "equations": [equation.text() for equation in linearization.equations],
            "latex": linearization.latex(),
        }
    except DerivationError as error:
        symbolic = {"equations": None, "latex": None, "why_not": str(error)}
    parts = np.stack([linearization.modes.real, linearization.modes.imag], axis=-1)
    data = {
        "mechanism": m.name,
        "equilibrium": dict(zip(m.coordinates, linearization.q.tolist(), strict=True)),
        "chosen": linearization.chosen,
        "stable": linearization.stable,
        **symbolic,
        "deviations": list(_independent(linearization)),
        **_matrices(linearization),
        "frequencies_rad_per_s": linearization.frequencies.tolist(),
        "frequencies_hz": (linearization.frequencies / (2 * np.pi)).tolist(),
        "damping_ratios": [None if np.isnan(z) else z for z in linearization.damping.tolist()],
        "eigenvalues": [[x.real, x.imag] for x in linearization.eigenvalues.tolist()],
        "modes": dict(zip(linearization.deviations, parts.tolist(), strict=True)),
    }
    return to_json(data)


def inertial_figures(check: InertialCheck) -> str:
    """Return a check of the ground as JSON."""
    data = {
        "mechanism": check.still.mechanism.name,
        "latitude_deg": float(np.degrees(check.latitude)),
        "facing": check.facing,
        "inertial": check.inertial,
        "tolerance": check.tolerance,
        "rows": [
            {**asdict(row), "relative": row.relative if np.isfinite(row.relative) else None}
            for row in check.rows
        ],
    }
    return to_json(data)


def response_table(response: Response) -> str:
    """Return a frequency response as CSV: ω, then amplitude and phase lag of each coordinate."""
    head = ["omega [rad/s]"]
    for name in response.names:
        head += [f"amplitude {name}", f"phase {name}"]
    pairs = np.stack([response.amplitude, response.phase], axis=-1)
    table = np.column_stack([response.frequencies, pairs.reshape(len(pairs), -1)])
    lines = [",".join(head)]
    for row in table.tolist():
        lines.append(",".join(f"{x:.10g}" for x in row))
    return "\n".join(lines)


def _letters(linearization: Linearization) -> str:
    try:
        return linearization.text()
    except DerivationError as error:
        return f"The linear equations are computed, not written out: {error}."


def _independent(linearization: Linearization) -> tuple[str, ...]:
    """Return the names of the independent deviations, whose rows of the tangent are unit rows."""
    if len(linearization.tangent) == len(linearization.M):
        return linearization.deviations
    unit = np.eye(len(linearization.M))
    rows = [int(np.abs(linearization.tangent - row).max(axis=1).argmin()) for row in unit]
    return tuple(linearization.deviations[k] for k in rows)


def _matrix_row(row: np.ndarray) -> str:
    return "  " + "  ".join(f"{x:12.6g}" for x in row)


def _clean(matrix: np.ndarray) -> np.ndarray:
    """A matrix for print, without rounding errors."""
    cleaned: np.ndarray = np.where(
        np.abs(matrix) <= 1e-12 * np.abs(matrix).max(initial=0.0), 0.0, matrix
    )
    return cleaned


def _modes(linearization: Linearization) -> Iterator[str]:
    from mecanique.motion.linear.linearization import write_entry, write_ratio

    values = zip(
        linearization.frequencies, linearization.damping, linearization.modes.T, strict=True
    )
    for number, (omega, zeta, mode) in enumerate(values, 1):
        shape = ", ".join(map(write_entry, mode))
        ratio = write_ratio(zeta, 6)
        figures = (
            f"{omega:12.9g}  {omega / (2 * np.pi):12.9g}"
            if omega > 0
            else f"{'no oscillation':>26}"
        )
        yield f"{number:>4}  {figures}  {ratio:>9}  ({shape})"


def exponents(steady: SteadyLinearization, *, as_json: bool) -> str:
    """Return the exponents of deviations from a steady motion, and their matrices."""
    from mecanique.motion.linear.steady import drop_noise, write_exponent

    if as_json:
        figures = {
            "positions": steady.positions,
            "velocities": steady.velocities,
            "cyclic": steady.cyclic,
            "A": steady.A.tolist(),
            **_matrices(steady),
            "exponents": _pairs(steady.exponents),
            "stable": steady.stable,
        }
        return to_json(figures)
    lines = [f"{steady.mechanism.name}: {'stable' if steady.stable else 'unstable'} steady motion"]
    lines.append(f"independent positions   {', '.join(steady.positions)}")
    lines.append(f"independent velocities  {', '.join(steady.velocities)}")
    lines.append(f"cyclic                  {', '.join(steady.cyclic) or 'none'}")
    lines += [
        "",
        "exponents [1/s]",
        *(f"  {write_exponent(x)}" for x in drop_noise(steady.exponents)),
    ]
    for name, matrix in (("M", steady.M), ("C", steady.C), ("K", steady.K)):
        lines += ["", f"{name}"]
        lines += [_matrix_row(row) for row in _clean(matrix)]
    return "\n".join(lines)


def speed_figures(table: SpeedRange) -> str:
    """Return exponents over speeds as JSON."""
    figures = {
        "speeds": table.speeds.tolist(),
        "exponents": [_pairs(row) for row in table.eigenvalues],
        "limits": table.limits,
    }
    return to_json(figures)


def matrix_figures(matrices: SpeedMatrices) -> str:
    """Return matrices as functions of the speed as JSON: of C and K by its power."""
    return to_json({"coordinates": matrices.names, **_matrices(matrices)})


def _matrices(source: Linearization | SteadyLinearization | SpeedMatrices) -> dict[str, Any]:
    return {"M": source.M.tolist(), "C": source.C.tolist(), "K": source.K.tolist()}


def _pairs(values: np.ndarray) -> list[list[float]]:
    return [[float(x.real), float(x.imag)] for x in values]
