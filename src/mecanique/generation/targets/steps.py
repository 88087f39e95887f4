"""Write C that integrates a program: its functions of a state, and the steps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

from mecanique.arrays import Array
from mecanique.generation.dop853 import (
    STEPS,
    tableau,
    write_constants,
)
from mecanique.generation.program import LoopProjection
from mecanique.generation.targets.c import NOTATION, SIGN
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import velocity_scales
from mecanique.program.listing import list_program
from mecanique.program.tape import Tape, Value


@final
@dataclass(frozen=True)
class SteppedProgram:
    """A program to be integrated."""

    mechanism: Mechanism
    tape: Tape
    # C's name of each input, by its name on the tape: t, or an entry of y or p such as y3
    symbols: Mapping[str, str]
    rates: Sequence[Value]  # rates of q, then of v, shape (nq + nv,); none if C finds them itself
    landing: LoopProjection | None  # for closed mechanisms, the correction that keeps loops closed


def write_steps(moving: SteppedProgram) -> str:
    """Write sizes, coefficients, the program and the steps in C."""
    coefficients = tableau()
    mechanism, landing = moving.mechanism, moving.landing
    balls = [at[0] for _, at in mechanism.quaternions]
    table = map(list_numbers, coefficients.A)
    lines = [
        "#include <math.h>",
        "#include <string.h>",
        f"enum {{ NQ = {mechanism.nq}, NV = {mechanism.nv}, N = NQ + NV }};",
        f"enum {{ LOOPS = {int(landing is not None)}, BALLS = {len(balls)}, STAGES = 12 }};",
        f"static const int ball[] = {{{', '.join(map(str, balls or [0]))}}};",
        f"static const double plain[] = {list_numbers(velocity_scales(mechanism))};",
        f"static const double A[][STAGES] = {{{', '.join(table)}}};",
    ]
    for name, row in (
        ("B", coefficients.B),
        ("C", coefficients.C),
        ("E5", coefficients.errors[0, :12]),
        ("E3", coefficients.errors[1, :12]),
    ):
        lines.append(f"static const double {name}[] = {list_numbers(row)};")
    for name, rows in (("LATER", coefficients.later), ("DENSE", coefficients.dense)):
        table = map(list_numbers, rows)
        lines.append(f"static const double {name}[][STAGES + 4] = {{{', '.join(table)}}};")
    lines.append(f"static const double NODES[] = {list_numbers(coefficients.nodes)};")
    lines += write_constants(STEPS)
    if any(kind == "sign" for kind, _, _ in moving.tape.operations):
        lines.append(SIGN)
    if moving.rates:
        lines += write_function(moving, "rates", moving.rates)
    else:
        lines.append("static void rates(double t, const double *y, const double *p, double *out);")
    lines += write_function(moving, "landing", () if landing is None else landing.changes)
    lines += write_function(moving, "firm", () if landing is None else (landing.firmness,))
    lines += [
        "static double firmness(double t, const double *y, const double *p)",
        "{",
        "    double out[1] = {0.0};",
        "    firm(t, y, p, out);",
        "    return out[0];",
        "}",
        "",
    ]
    return "\n".join(lines) + Path(__file__).with_name("stepper.c").read_text(encoding="utf-8")


def write_function(moving: SteppedProgram, name: str, outputs: Sequence[Value]) -> list[str]:
    """Write a function of time, state and parameters as lines of C."""
    listing = list_program(moving.tape, outputs, moving.symbols, NOTATION)
    lines = [
        f"static void {name}(double t, const double *y, const double *p, double *out)",
        "{",
        "    (void)t; (void)y; (void)p; (void)out;",
    ]
    for given in listing.inputs:
        symbol = moving.symbols[given]
        if symbol != "t":
            lines.append(f"    const double {symbol} = {symbol[0]}[{symbol[1:]}];")
    lines += [f"    {line}" for line in listing.lines]
    lines += [f"    out[{k}] = {text};" for k, text in enumerate(listing.outputs)]
    return [*lines, "}", ""]


def list_numbers(values: Sequence[float] | Array) -> str:
    """Write numbers as an initializer of a C array."""
    return f"{{{', '.join(repr(float(value)) for value in values)}}}"
