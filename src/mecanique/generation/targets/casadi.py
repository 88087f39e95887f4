"""CasADi: symbolic functions, to differentiate and to optimize with."""

from __future__ import annotations

import platform
import sys
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import final

from mecanique.generation.program.listing import Notation, list_program
from mecanique.generation.program.program import Answer, Program
from mecanique.generation.targets.python import quote, require, tables
from mecanique.generation.targets.target import Cases, describe, symbols_of, takes_state

__all__ = ["CasADi"]

_FUNCTIONS = {
    **{name: f"ca.{name}({{}})" for name in ("sin", "cos", "tan", "sqrt", "exp", "log", "tanh")},
    **{name: f"ca.{name}({{}})" for name in ("asin", "acos", "atan", "atan2", "sign")},
    "pow": "ca.power({})",
    "Abs": "ca.fabs({})",
}
_NOTATION = Notation(_FUNCTIONS, "{} = {}")


@final
class CasADi:
    """A module of Python that builds functions of CasADi."""

    title = "Python with CasADi"

    def files(self, program: Program, head: Sequence[str]) -> dict[str, str]:
        """Return the module."""
        lines = [*head, "", "Each function is a casadi.Function of all its arguments.", ""]
        for kind, title in (
            ("q", "q: generalized coordinates"),
            ("v", "v: generalized velocities"),
            ("tau", "tau: torques and forces added to those of the mechanism"),
            ("p", "p: parameters, in the mechanism PARAMETERS"),
        ):
            lines += [title, *(f"    {row}" for row in describe(program.letters[kind])), ""]
        lines = [quote(line) for line in lines]
        lines[0] = f'"""{lines[0]}'
        values = [letter.value for letter in program.parameters]
        lines += ['"""', "", "import casadi as ca", "", f"PARAMETERS = {values!r}"]
        for answer in program.answers:
            lines += ["", "", *_function(program, answer)]
        return {f"{program.name}.py": "\n".join([*lines, ""])}

    def test_files(self, program: Program, cases: Cases) -> dict[str, str]:
        """Return the test with its table."""
        lines = [
            f'"""Compares {program.name}.py with values of Pinocchio."""',
            "",
            "import importlib.util",
            "import pathlib",
            "import sys",
            "",
            "import numpy as np",
            "",
            f'HERE = pathlib.Path(__file__).with_name("{program.name}.py")',
            *tables(program, cases),
        ]
        return {f"test_{program.name}.py": "\n".join([*lines, _COMPARE])}

    def commands(self, program: Program, directory: Path) -> list[list[str]]:
        """Return the command that runs the test."""
        require("casadi")
        return [[sys.executable, str(directory / f"test_{program.name}.py")]]

    def version(self) -> str:
        """Return the versions of Python and CasADi."""
        return f"Python {platform.python_version()} and casadi {version('casadi')}"


def _function(program: Program, answer: Answer) -> list[str]:
    quantity, symbols, letters = answer.quantity, symbols_of(program), program.letters
    kinds = (*takes_state(answer), "p")
    spelled = {
        letter.place: symbol
        for kind in kinds
        for letter, symbol in zip(letters[kind], symbols[kind], strict=True)
    }
    listing = list_program(program.tape, answer.values, spelled, _NOTATION)
    used = set(listing.inputs)
    takes = (*quantity.takes, "p")
    sizes = {kind: len(some) for kind, some in letters.items()}
    sizes["y"] = sizes["q"] + sizes["v"]
    lines = [
        f"def _{quantity.name}():",
        *(f'    {kind} = ca.SX.sym("{kind}", {sizes[kind]})' for kind in takes),
    ]
    for kind in kinds:
        offset = sizes["q"] if kind == "v" and "y" in takes else 0
        array = "y" if kind in ("q", "v") and "y" in takes else kind
        for k, (letter, symbol) in enumerate(zip(letters[kind], symbols[kind], strict=True)):
            if letter.place in used and kind != "t":
                lines.append(f"    {symbol} = {array}[{k + offset}]")
    lines += [f"    {line}" for line in listing.lines]
    lines += ["    out = ca.vertcat(", *(f"        {text}," for text in listing.outputs), "    )"]
    if len(answer.shape) == 2:  # CasADi counts by columns
        rows, columns = answer.shape
        lines.append(f"    out = ca.reshape(out, {columns}, {rows}).T")
    names = ", ".join(f'"{kind}"' for kind in takes)
    arguments = f'[{", ".join(takes)}], [out], [{names}], ["out"]'
    lines.append(f'    return ca.Function("{quantity.name}", {arguments})')
    return [*lines, "", "", f"{quantity.name} = _{quantity.name}()"]


_COMPARE = """

def main():
    spec = importlib.util.spec_from_file_location("code", HERE)
    code = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(code)
    inputs = {kind: np.array(rows, dtype=float) for kind, rows in INPUTS.items()}
    inputs["y"] = np.hstack([inputs["q"], inputs["v"]])
    failed = 0
    for name, takes in TAKES.items():
        worst, where = 0.0, 0
        for k in range(len(inputs["t"])):
            out = np.asarray(getattr(code, name)(*(inputs[kind][k] for kind in takes)))
            off = np.array(WEIGHTS[name][k]) * (out.ravel() - EXPECTED[name][k])
            difference = float(np.linalg.norm(off))
            if not difference <= worst:
                worst, where = difference, k
            if not difference <= ALLOWED[name][k]:
                print(f"{name} differs by {difference:.3g} in state {k}", file=sys.stderr)
                failed = 1
        print(name, worst, where)
    return failed


if __name__ == "__main__":
    sys.exit(main())
"""
