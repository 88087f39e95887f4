"""Write symbolic functions for CasADi, for differentiation and optimization."""

from __future__ import annotations

import platform
import sys
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import final

from mecanique.generation.program import Answer, Program
from mecanique.generation.targets.python import quote, require, write_test
from mecanique.generation.targets.target import Cases, describe, list_answer
from mecanique.program.listing import Notation

_FUNCTIONS = {
    **{name: f"ca.{name}({{}})" for name in ("sin", "cos", "tan", "sqrt", "exp", "log", "tanh")},
    **{name: f"ca.{name}({{}})" for name in ("asin", "acos", "atan", "atan2", "sign")},
    "pow": "ca.power({})",
    "Abs": "ca.fabs({})",
}
_NOTATION = Notation(_FUNCTIONS, "{} = {}")


@final
class CasADi:
    """A Python module that builds functions of CasADi."""

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
            lines += ["", "", *_write_function(program, answer)]
        return {f"{program.name}.py": "\n".join([*lines, ""])}

    def test_files(self, program: Program, cases: Cases) -> dict[str, str]:
        """Return the test with its table."""
        return {f"test_{program.name}.py": write_test(program, cases, (), _COMPARE)}

    def commands(self, program: Program, directory: Path) -> list[list[str]]:
        """Return the command that runs the test."""
        require("casadi")
        return [[sys.executable, str(directory / f"test_{program.name}.py")]]

    def version(self) -> str:
        """Return the versions of Python and CasADi."""
        return f"Python {platform.python_version()} and casadi {version('casadi')}"


def _write_function(program: Program, answer: Answer) -> list[str]:
    quantity = answer.quantity
    listing, reads = list_answer(program, answer, _NOTATION)
    takes = (*quantity.takes, "p")
    sizes = {kind: len(some) for kind, some in program.letters.items()}
    sizes["y"] = sizes["q"] + sizes["v"]
    lines = [
        f"def _{quantity.name}():",
        *(f'    {kind} = ca.SX.sym("{kind}", {sizes[kind]})' for kind in takes),
    ]
    for read in reads:
        if read.array != "t":
            lines.append(f"    {read.symbol} = {read.array}[{read.place}]")
    lines += [f"    {line}" for line in listing.lines]
    lines += ["    out = ca.vertcat(", *(f"        {text}," for text in listing.outputs), "    )"]
    if len(answer.shape) == 2:  # CasADi stores matrices by columns
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
