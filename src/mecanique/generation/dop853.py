"""The method of order 8(5,3) of Dormand and Prince, once for C, JavaScript and numpy.

Its tableau is that of SciPy. The control of steps is that of DOP853 (E. Hairer, S. P. Nørsett,
G. Wanner, Solving Ordinary Differential Equations I, 1993, sect. II.4, II.5 and II.10), damped as
there with β = 0.04; after each step a closed mechanism is projected on its loops.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, final

import numpy as np

from mecanique.arrays import Array

DAMPING = 0.04
"""How much of the last step's error the next step's length heeds, Hairer's β.

Without it a sixth of all steps of a swinging motion are refused (K. Gustafsson, ACM Trans. Math.
Softw. 17 (1991) 533; Hairer, Nørsett & Wanner, sect. II.4 and IV.2).
"""

EXPONENT = 1 / 8 - 0.2 * DAMPING
"""How much of a step's own error it heeds."""

SAFETY, SHRINKAGE, GROWTH = 0.9, 0.2, 6.0
"""Margin of a step's length; its least and its greatest change."""

BEFORE = 1e-4
"""Error that is remembered of a first step, and of each that has less."""

NEARLY = 1.000001
"""A step that is nearly as long as what is left is the last."""

SHORTEST = 1e-14
"""The shortest step, as a part of the time or of 1 s."""

FIRST, UNKNOWN, BRIEF = 0.01, 1e-10, 1e-6
"""The first step is this part of state over rate; where the square of one of them, in tolerances,
is below the second, it is the third [s]."""

LOOKS, SHALLOW = 4, 0.5
"""Events are looked for at so many places of a step, and between them where a parabola through
three comes down to this part of the least of the three, or farther."""

GRAZES = 1e-10
"""What comes less than this part of its size around beyond zero, and back, only touches it: less is
not known of a motion at the default tolerance."""

UNSTABLE = 6.1
"""Step length times rate of decay at which the method becomes unstable (DOP853, Hairer et al.)."""

STIFF_AFTER, STIFF_FORGET = 15, 6
"""So many steps at the limit of stability are stiff; so many in a row below it start afresh."""

SWEEPS = 8
"""Most sweeps of Newton's method that project a state on the loops."""

ASTRAY, HALVED = 0.1, 0.5
"""The greatest first change of position; each must be below this part of the one before."""

ROUNDING, CLOSED = 4e-16, 1e-12
"""Change of position, relative to its size or one, that is only rounding; of closed loops."""

PROBE = 1e-4
"""How far ahead the firmness of the loops is computed again, to see how it changes."""

FIRM = 0.01
"""Loops that hold less firmly are next to a singular position."""

NEAREST = 0.15
"""Distance from a singular position at which to stop, in characteristic lengths or radians."""

PASSED = 2.0
"""This many times `NEAREST` behind a singular position it is passed."""

MIDDLE = 7 / 15
"""The middle of the widest gap between the stages of a step, from 1/3 to 3/5 of its length."""

MAGNIFIED = 1e-10
"""Change of position, as above, that may be only rounding next to a singular position.

A gap of 1e-14 m, the rounding of a chain of 40 links, is closed by 100 times as much where loops
hold with a firmness of 0.01.
"""

LEAP, LEAST_LEAP = 0.09, 0.02
"""Distances before a singular position, as above, from which to leap across it; a refused leap is
tried again from half the distance.

No stage is nearer than 0.29 of it. The nearer, the more rounding is magnified in the accelerations:
of 40 parallelograms in series, at a tolerance of 1e-12, a leap errs by 0.5 tolerances from 0.09, by
1.8 from 0.06, by 9 from 0.04 and by 500 from 0.02.
"""

LEAP_ERROR = 10.0
"""A leap may err by this many times the tolerance of a step.

Steps of closed mechanisms use a tenth of the tolerance that is asked for, since their errors add
up; a leap is one among fifty.
"""

_CONTROL = (
    *("DAMPING", "EXPONENT", "SAFETY", "SHRINKAGE", "GROWTH"),
    *("BEFORE", "NEARLY", "SHORTEST", "FIRST", "UNKNOWN", "BRIEF"),
)

STEPS = (
    *_CONTROL,
    *("UNSTABLE", "STIFF_AFTER", "STIFF_FORGET"),
    *("SWEEPS", "ASTRAY", "HALVED", "ROUNDING", "CLOSED", "PROBE", "FIRM"),
    *("PASSED", "MIDDLE", "LEAST_LEAP", "LEAP_ERROR", "MAGNIFIED"),
)
"""Names of the constants that the steps in C use."""

_TABLES = (
    (
        "NODES",
        "Where in a step the stages lie; the last three serve the dense output alone.",
    ),
    (
        "STAGES",
        "Weights of earlier stages in the state at which each stage is taken; the twelfth is the "
        "step.",
    ),
    ("ERRORS", "Weights of the stages in the errors of order 5 and 3."),
    ("DENSE", "Weights of the stages in the last four coefficients of the dense output."),
)

SCRIPT = Path(__file__).parents[1] / "viewing" / "page" / "assets" / "engine" / "tableau.js"
"""The file of the page's scripts that `write_script` writes."""


@final
@dataclass(frozen=True)
class Tableau:
    """Coefficients of the method."""

    A: Array  # weights of earlier stages in each of the 12 stages, shape (12, 12)
    B: Array  # weights of the stages in the step, shape (12,)
    C: Array  # nodes of the stages, shape (12,)
    errors: Array  # weights of the stages and the end in the errors of order 5 and 3, shape (2, 13)
    later: Array  # weights in the three stages of the dense output, shape (3, 16)
    nodes: Array  # nodes of these, shape (3,)
    dense: Array  # weights in the coefficients of the dense output, shape (4, 16)


def write_constants(names: Sequence[str]) -> list[str]:
    """Return the declarations of constants of this module in C."""
    lines = []
    for name in names:
        value = globals()[name]
        if isinstance(value, int):
            lines.append(f"enum {{ {name} = {value} }};")
        else:
            lines.append(f"static const double {name} = {value!r};")
    return lines


@cache
def tableau() -> Tableau:
    """Return the coefficients."""
    from scipy.integrate import DOP853

    method: Any = DOP853
    return Tableau(
        A=method.A,
        B=method.B,
        C=method.C,
        errors=np.stack([method.E5, method.E3]),
        later=method.A_EXTRA,
        nodes=method.C_EXTRA,
        dense=method.D,
    )


def write_script() -> str:
    """Return the page's script with all of these numbers, as it is kept at `SCRIPT`."""
    table = tableau()
    rows: dict[str, Sequence[Array]] = {
        "STAGES": [*table.A, table.B, *table.later],
        "ERRORS": [*table.errors],
        "DENSE": [*table.dense],
    }
    constants = *_CONTROL, "LOOKS", "SHALLOW", "GRAZES"
    lines = [
        "// Written by generation/dop853.py: the method of Dormand & Prince of order 8(5, 3), and",
        "// its dense output of order 7 (E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary",
        "// Differential Equations I, 1993, II.5, II.6). Rows hold what is not zero.",
        "",
        "export const CONTROL = {",
        *(f"  {name}: {globals()[name]!r},".replace("e-0", "e-") for name in constants),
        "};",
    ]
    for name, meaning in _TABLES:
        lines += ["", f"// {meaning}", f"export const {name} = ["]
        if name == "NODES":
            lines += _fill([*table.C, 1.0, *table.nodes])
        for row in rows.get(name, ()):
            pairs = [f"    [{k}, {_say(weight)}]," for k, weight in enumerate(row) if weight]
            single = f"[{pairs[0].strip(' ,')}]" if len(pairs) == 1 else ""
            lines += [f"  {single or '[]'},"] if len(pairs) < 2 else ["  [", *pairs, "  ],"]
        lines.append("];")
    return "\n".join([*lines, ""])


def _fill(numbers: list[float]) -> list[str]:
    """Return numbers in lines."""
    text = " ".join(f"{_say(number)}," for number in numbers)
    return textwrap.wrap(text, 100, initial_indent="  ", subsequent_indent="  ")


def _say(weight: float) -> str:
    return repr(float(weight))


if __name__ == "__main__":
    SCRIPT.write_text(write_script(), encoding="utf-8")
