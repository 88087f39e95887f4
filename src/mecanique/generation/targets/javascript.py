"""Write JavaScript: functions of typed arrays that allocate nothing, for a module or a page."""

from __future__ import annotations

import json
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import final

import numpy as np

from mecanique.errors import InputError
from mecanique.generation.program import Answer, Program
from mecanique.generation.targets.target import (
    Cases,
    call_functions,
    describe,
    list_answer,
    run_command,
)

_NOTATION = call_functions("Math.", "const {} = {};", Abs="abs")


@final
class JavaScript:
    """A JavaScript module."""

    title = "JavaScript"

    def files(self, program: Program, head: Sequence[str]) -> dict[str, str]:
        """Return the module."""
        lines = ["/*", *(f" * {line}".rstrip().replace("*/", "* /") for line in head), " *"]
        lines += [" * y contains the coordinates, then the velocities:"]
        state = [*program.letters["q"], *program.letters["v"]]
        lines += [f" *   {row}" for row in describe(state)]
        lines += [" * p contains the parameters:"]
        lines += [f" *   {row}" for row in describe(program.parameters)]
        lines += [
            " * tau, torques and forces added to those of the mechanism, is optional.",
            " */",
        ]
        for kind, name in (("q", "coordinates"), ("v", "velocities"), ("p", "parameters")):
            table = [
                {"name": letter.name, "unit": letter.unit}
                | ({"value": letter.value, "meaning": letter.meaning} if kind == "p" else {})
                for letter in program.letters[kind]
            ]
            rows = [f"  {json.dumps(row, ensure_ascii=False)}," for row in table]
            lines += [f"export const {name} = [", *rows, "];"]
        lines += ["", *(f"export {text}\n" for text in functions(program))]
        return {f"{program.name}.mjs": "\n".join(lines)}

    def test_files(self, program: Program, cases: Cases) -> dict[str, str]:
        """Return the test with its table."""
        return {f"test_{program.name}.mjs": _write_test(program, cases)}

    def commands(self, program: Program, directory: Path) -> list[list[str]]:
        """Return the command that runs the test."""
        return [[_find_node(), str(directory / f"test_{program.name}.mjs")]]

    def version(self) -> str:
        """Return the version of node."""
        return f"node {run_command([_find_node(), '--version']).stdout.strip()}"


def functions(program: Program) -> list[str]:
    """Return the text of each function of a program, name(t, y, p, out, tau).

    Functions take only the arguments that they need, in this order; accelerations come before p.
    """
    return [_write_function(program, answer) for answer in program.answers]


def _find_node() -> str:
    path = shutil.which("node")
    if path is None:
        raise InputError("expected node to run JavaScript, found none: install Node.js")
    return path


def _list_arguments(answer: Answer) -> list[str]:
    takes = answer.quantity.takes
    given = [name for name in ("a",) if name in takes]
    return ["t", "y", *given, "p", "out", *(name for name in ("tau",) if name in takes)]


def _write_function(program: Program, answer: Answer) -> str:
    listing, reads = list_answer(program, answer, _NOTATION, stacked=True)
    lines = [f"function {answer.quantity.name}({', '.join(_list_arguments(answer))}) {{"]
    for read in reads:
        if read.array != "t":
            entry = f"{read.array}[{read.place}]"
            value = f"tau ? {entry} : 0" if read.array == "tau" else entry
            lines.append(f"  const {read.symbol} = {value};")
    lines += [f"  {line}" for line in listing.lines]
    lines += [f"  out[{k}] = {text};" for k, text in enumerate(listing.outputs)]
    return "\n".join([*lines, "  return out;", "}"])


def _write_test(program: Program, cases: Cases) -> str:
    inputs = {**cases.inputs, "y": np.hstack([cases.inputs["q"], cases.inputs["v"]])}
    inputs["t"] = inputs["t"][:, 0]
    lines = [
        f"// Compares {program.name}.mjs with reference values; run with node.",
        f'import * as code from "./{program.name}.mjs";',
        "",
        "const inputs = {",
        *(
            f"  {kind}: {json.dumps(inputs[kind].tolist())},"
            for kind in ("t", "y", "a", "tau", "p")
        ),
        "};",
        "const answers = {",
    ]
    for answer in program.answers:
        name = answer.quantity.name
        tables = {
            "takes": _list_arguments(answer),
            "expected": cases.expected[name].tolist(),
            "weight": cases.weights[name].tolist(),
            "allowed": cases.allowed[name].tolist(),
        }
        lines += [f"  {name}: {{"]
        lines += [f"    {key}: {json.dumps(table)}," for key, table in tables.items()]
        lines += ["  },"]
    return "\n".join([*lines, "};", _COMPARE])


_COMPARE = """
let failed = 0;
for (const [name, answer] of Object.entries(answers)) {
  let worst = 0;
  let where = 0;
  for (let k = 0; k < inputs.t.length; k++) {
    const out = new Float64Array(answer.expected[k].length);
    code[name](...answer.takes.map((kind) => (kind === "out" ? out : inputs[kind][k])));
    let square = 0;
    for (let i = 0; i < out.length; i++) {
      square += (answer.weight[k][i] * (out[i] - answer.expected[k][i])) ** 2;
    }
    const difference = Math.sqrt(square);
    if (!(difference <= worst)) {
      worst = difference;
      where = k;
    }
    if (!(difference <= answer.allowed[k])) {
      console.error(`${name} differs by ${difference} in state ${k}`);
      failed = 1;
    }
  }
  console.log(`${name} ${worst} ${where}`);
}
process.exitCode = failed;
"""
