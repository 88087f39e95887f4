"""Write C99: functions that allocate nothing, a header with the units, and steps that integrate."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError
from mecanique.generation.dop853 import (
    STEPS,
    tableau,
    write_constants,
)
from mecanique.generation.program import Answer, LoopProjection, Program
from mecanique.generation.targets.target import (
    Cases,
    call_functions,
    describe,
    list_answer,
    run_command,
)
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import velocity_scales
from mecanique.program.listing import list_program
from mecanique.program.tape import Tape, Value

NOTATION = call_functions("", "const double {} = {};", Abs="fabs", sign="signum")
"""The notation of C."""

SIGN = "#define signum(x) ((double)(((x) > 0) - ((x) < 0)))"
"""The sign function, which C lacks."""

_PLAIN = str.maketrans({"·": "*", "²": "^2", "³": "^3", "θ": "theta", "–": "-", "−": "-"})

WARNINGS = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-Wno-overlength-strings")
"""Options under which the written C compiles without warnings."""

LONG = 10_000
"""Sources with more lines take minutes to optimize."""


def compiler() -> str:
    """Return the path of a C compiler: $CC, or cc, gcc or clang."""
    for name in (os.environ.get("CC", ""), "cc", "gcc", "clang"):
        path = shutil.which(name) if name else None
        if path:
            return path
    raise InputError(
        "expected a C compiler, found none: install gcc or clang, or name one in the environment "
        "variable CC"
    )


def limit_optimization(sources: Iterable[Path]) -> list[str]:
    """Return the option that switches off optimization of very long code; it must come last."""
    lines = max((text.count(b"\n") for text in map(Path.read_bytes, sources)), default=0)
    return ["-O0"] if lines > LONG else []


@final
class C:
    """C99."""

    title = "C99"

    def files(self, program: Program, head: Sequence[str]) -> dict[str, str]:
        """Return the header and the source."""
        return {
            f"{program.name}.h": _write_header(program, head),
            f"{program.name}.c": _write_source(program, head),
        }

    def test_files(self, program: Program, cases: Cases) -> dict[str, str]:
        """Return the test program with its table."""
        return {f"test_{program.name}.c": _write_test(program, cases)}

    def commands(self, program: Program, directory: Path) -> list[list[str]]:
        """Return the commands that compile and run the test."""
        name, runnable = program.name, str(directory / f"test_{program.name}.exe")
        sources = [directory / f"{name}.c", directory / f"test_{name}.c"]
        options = [*WARNINGS, "-O1", *limit_optimization(sources), "-o", runnable]
        return [
            [compiler(), *options, *map(str, sources), "-lm"],
            [runnable],
        ]

    def version(self) -> str:
        """Return the first line in which the compiler names itself."""
        said = run_command([compiler(), "--version"])
        return (said.stdout.splitlines() or [Path(compiler()).name])[0]


def signature(program: Program, answer: Answer) -> str:
    """Return the declaration of an answer's function, without the semicolon."""
    quantity = answer.quantity
    arguments = [
        "double t" if kind == "t" else f"const double *{kind}" for kind in (*quantity.takes, "p")
    ]
    return f"void {program.name}_{quantity.name}({', '.join(arguments)}, double *out)"


def _write_header(program: Program, head: Sequence[str]) -> str:
    name, lines = program.name, _write_comment(head)
    letters, guard = program.letters, f"{program.name.upper()}_H"
    lines += [f"#ifndef {guard}", f"#define {guard}", "", "#ifdef __cplusplus", 'extern "C" {']
    lines += ["#endif", ""]
    for kind, title in (
        ("q", "generalized coordinates"),
        ("v", "generalized velocities"),
        ("tau", "torques and forces added to those of the mechanism; NULL for none"),
        ("p", f"parameters; NULL for {name}_parameters"),
    ):
        lines += _write_comment(
            [f"{kind}: {title}", *(f"  {row}" for row in describe(letters[kind]))]
        )
    sizes = {kind: len(letters[kind]) for kind in ("q", "v", "p")}
    lines.append(f"enum {{ {', '.join(f'{name}_n{k} = {n}' for k, n in sizes.items())} }};")
    lines += ["", f"extern const double {name}_parameters[{max(sizes['p'], 1)}];", ""]
    for answer in program.answers:
        quantity, size = answer.quantity, len(answer.values)
        lines += _write_comment([f"{quantity.meaning}: out[{size}]"])
        lines += [*_wrap(f"{signature(program, answer)};"), ""]
    lines += ["#ifdef __cplusplus", "}", "#endif", "", "#endif", ""]
    return "\n".join(lines)


def _write_source(program: Program, head: Sequence[str]) -> str:
    name = program.name
    values = ", ".join(repr(letter.value) for letter in program.parameters) or "0.0"
    lines = [*_write_comment(head), "#include <math.h>", "#include <stddef.h>", ""]
    lines += [f'#include "{name}.h"', ""]
    constants = f"const double {name}_parameters[{max(len(program.parameters), 1)}]"
    lines += [*_wrap(f"{constants} = {{{values}}};"), ""]
    if any(kind == "sign" for kind, _, _ in program.tape.operations):
        lines += [SIGN, ""]
    for answer in program.answers:
        lines += [*_write_function(program, answer), ""]
    return "\n".join(lines)


def _write_function(program: Program, answer: Answer) -> list[str]:
    listing, reads = list_answer(program, answer, NOTATION)
    lines = [*_wrap(signature(program, answer)), "{"]
    idle = {*answer.quantity.takes, "p"}
    for read in reads:
        if read.array == "p" and "p" in idle:
            lines.append(f"    if (p == NULL) p = {program.name}_parameters;")
        idle.discard(read.array)
        if read.array != "t":
            entry = f"{read.array}[{read.place}]"
            value = f"tau != NULL ? {entry} : 0.0" if read.array == "tau" else entry
            lines.append(f"    const double {read.symbol} = {value};")
    lines += [f"    {line}" for line in listing.lines]
    lines += [f"    out[{k}] = {text};" for k, text in enumerate(listing.outputs)]
    lines += [f"    (void){name};" for name in (*answer.quantity.takes, "p") if name in idle]
    if not answer.values:
        lines.append("    (void)out;")
    return [*lines, "}"]


def _write_test(program: Program, cases: Cases) -> str:
    """Write a program that compares all states and prints the worst difference of each answer."""
    name, states = program.name, len(cases)
    lines = [
        f"/* Compares {name}.c with reference values; build with",
        f"   cc -std=c99 -o test_{name} {name}.c test_{name}.c -lm */",
        "#include <math.h>",
        "#include <stdio.h>",
        "",
        f'#include "{name}.h"',
        "",
        f"enum {{ STATES = {states} }};",
        "",
    ]
    inputs = {**cases.inputs, "y": np.hstack([cases.inputs["q"], cases.inputs["v"]])}
    for kind in ("t", "y", "q", "v", "a", "tau", "p"):
        if kind == "p" or any(kind in answer.quantity.takes for answer in program.answers):
            lines += _write_table(kind, inputs[kind])
    for named in (answer.quantity.name for answer in program.answers):
        lines += _write_table(f"{named}_expected", cases.expected[named])
        lines += _write_table(f"{named}_weight", cases.weights[named])
        lines += _write_table(f"{named}_allowed", cases.allowed[named][:, None])
    lines += [
        "static int compare(const char *name, int size, const double *out, const double *expected,",
        "                   const double *weight, double allowed, int state, double *worst,",
        "                   int *where)",
        "{",
        "    double square = 0.0;",
        "    for (int k = 0; k < size; k++) {",
        "        const double d = weight[k] * (out[k] - expected[k]);",
        "        square += d * d;",
        "    }",
        "    const double difference = sqrt(square);",
        "    if (!(difference <= *worst)) { *worst = difference; *where = state; }",
        "    if (difference <= allowed) return 0;",
        '    fprintf(stderr, "%s differs by %.3g in state %d\\n", name, difference, state);',
        "    return 1;",
        "}",
        "",
        "int main(void)",
        "{",
        "    int failed = 0;",
    ]
    for answer in program.answers:
        quantity, size = answer.quantity, len(answer.values)
        given = ["t[k][0]" if kind == "t" else f"{kind}[k]" for kind in (*quantity.takes, "p")]
        tables = f"{quantity.name}_expected[k], {quantity.name}_weight[k]"
        lines += [
            "    {",
            f"        double out[{max(size, 1)}], worst = 0.0;",
            "        int where = 0;",
            "        for (int k = 0; k < STATES; k++) {",
            f"            {name}_{quantity.name}({', '.join(given)}, out);",
            f'            failed |= compare("{quantity.name}", {size}, out, {tables},',
            f"                              {quantity.name}_allowed[k][0], k, &worst, &where);",
            "        }",
            f'        printf("{quantity.name} %.17g %d\\n", worst, where);',
            "    }",
        ]
    return "\n".join([*lines, "    return failed;", "}", ""])


def _write_table(name: str, rows: np.ndarray) -> list[str]:
    width = max(rows.shape[1], 1)
    lines = [f"static const double {name}[STATES][{width}] = {{"]
    for row in rows:
        lines += _wrap(f"    {{{', '.join(map(repr, row.tolist())) or '0.0'}}},")
    return [*lines, "};", ""]


def _write_comment(lines: Sequence[str]) -> list[str]:
    text = "\n".join(lines).translate(_PLAIN).encode("ascii", "backslashreplace").decode()
    first, *rest = text.replace("*/", "* /").split("\n")
    return ["/*", f" * {first}".rstrip(), *(f" * {line}".rstrip() for line in rest), " */"]


def _wrap(line: str, width: int = 100) -> list[str]:
    """Break a long list of numbers."""
    lines = []
    while len(line) > width:
        at = line.rfind(", ", 0, width)
        if at < 0:
            break
        lines.append(line[: at + 1])
        line = f"     {line[at + 1 :]}"
    return [*lines, line]


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
