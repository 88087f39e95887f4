"""Programs as Taylor-series integrators, compiled by heyoka (extra `fast`).

Each step expands the motion in a Taylor series by automatic differentiation of the equations, to
the order that the tolerance asks for (À. Jorba, M. Zou, Experimental Mathematics 14 (2005) 99; F.
Biscani, D. Izzo, Monthly Notices of the Royal Astronomical Society 504 (2021) 2614).
"""

from __future__ import annotations

from functools import cache
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from mecanique.errors import DerivationError, InputError
from mecanique.motion.compile.program import RatesProgram

if TYPE_CHECKING:
    from mecanique.program.tape import Value


_FUNCTIONS = {"sin", "cos", "sqrt", "exp", "log", "asin", "acos", "atan", "tanh"}

_COMPACT = {True: 600, False: 200}
"""Programs with more operations, optimized or not, are compiled compactly: sooner, but slower."""

_OPTIONS: dict[bool, dict[str, Any]] = {
    True: {"opt_level": 1, "fast_math": True},
    False: {"opt_level": 0, "fast_math": True},
}
"""Optimized code or not.

Optimized code runs two to five times faster and takes ten times longer to compile; higher levels
gain little. Products and sums may be fused, which rounds less; states that are not finite are still
detected.
"""


@cache
def is_installed() -> bool:
    """Return whether heyoka is there."""
    return find_spec("heyoka") is not None


def integrator(
    program: RatesProgram, tolerance: float, runs: int = 1, *, optimized: bool = True
) -> Any:
    """Return a heyoka integrator of runs side by side; its par[i] are the open parameters."""
    heyoka = _heyoka()
    equations = system(program, heyoka)
    size = len(program.tape.find_needed(program.rates))
    options = {"tol": tolerance, "compact_mode": size > _COMPACT[optimized], **_OPTIONS[optimized]}
    if program.open:
        options["pars"] = (
            [0.0] * len(program.open) if runs == 1 else [[0.0] * runs for _ in program.open]
        )
    if runs == 1:
        return heyoka.taylor_adaptive(equations, [0.0] * len(equations), **options)
    return heyoka.taylor_adaptive_batch(equations, [[0.0] * runs for _ in equations], **options)


def lanes() -> int:
    """Return how many runs this machine advances side by side."""
    return max(2, int(_heyoka().recommended_simd_size()))


def _heyoka() -> Any:
    if not is_installed():
        raise InputError(
            "method 'taylor' needs heyoka, which is not installed: pip install 'mecanique[fast]', "
            "or use method 'auto'"
        )
    import heyoka

    return heyoka


def system(program: RatesProgram, heyoka: Any) -> list[tuple[Any, Any]]:
    """Return the equations as heyoka takes them: pairs of a letter and its rate."""
    if program.signals:
        names = ", ".join(program.signals)
        raise DerivationError(
            f"method 'taylor' needs the equations as formulas, but the input {names} is a function "
            "or a record; write it as an expression in t, or use method 'closed_form' or 'auto'"
        )
    operations = program.tape.operations
    needed = program.tape.find_needed(program.rates)
    unknown = sorted(
        {operations[place][0] for place in needed} - _FUNCTIONS - {"+", "-", "*", "/", "input"}
    )
    if unknown:
        raise DerivationError(
            f"no Taylor series of {', '.join(unknown)}; use another method than 'taylor'"
        )
    letters = heyoka.make_vars(*(f"s{k}" for k in range(len(program.states))))
    named = dict(zip(program.states, letters, strict=True))
    named |= {symbol: heyoka.par[k] for k, symbol in enumerate(program.open)} | {"t": heyoka.time}
    uses = dict.fromkeys(needed, 0)
    for value in [*(v for place in needed for v in operations[place][1]), *program.rates]:
        if isinstance(value, int):
            uses[value] += 1
    built: dict[int, Any] = {}

    def expression(value: Value) -> Any:
        return heyoka.expression(value) if isinstance(value, float) else built[value]

    def terms(value: Value, sign: float) -> list[Any]:
        """A sum's terms, where nothing else uses its parts: one long sum is cheaper than many."""
        if isinstance(value, int) and operations[value][0] in "+-" and uses[value] == 1:
            kind, (a, b), _ = operations[value]
            return terms(a, sign) + terms(b, sign if kind == "+" else -sign)
        return [expression(value) if sign > 0 else -1.0 * expression(value)]

    for place in needed:
        kind, values, name = operations[place]
        if kind == "input":
            built[place] = named[name]
        elif kind in "+-":
            a, b = values
            built[place] = heyoka.sum(terms(a, 1.0) + terms(b, 1.0 if kind == "+" else -1.0))
        elif kind in "*/":
            a, b = values
            built[place] = (
                expression(a) * expression(b) if kind == "*" else expression(a) / expression(b)
            )
        else:
            built[place] = getattr(heyoka, kind)(expression(values[0]))
    return [
        (named[name], expression(rate))
        for name, rate in zip(program.states, program.rates, strict=True)
    ]
