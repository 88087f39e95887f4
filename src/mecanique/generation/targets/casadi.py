"""Write symbolic functions for CasADi, for differentiation and optimization."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import final

from mecanique.generation.program import Answer, Program
from mecanique.generation.targets.python import (
    COMPARE,
    open_module,
    require,
    say_versions,
    write_test,
)
from mecanique.generation.targets.target import Cases, call_functions, list_answer

_NOTATION = call_functions("ca.", "{} = {}", pow="power", Abs="fabs")

_COMPARE = COMPARE.replace(
    "return function(*given)",
    "return [np.asarray(function(*row)).ravel() for row in zip(*given, strict=True)]",
)
"""Functions of CasADi take one state at a time."""


@final
class CasADi:
    """A Python module that builds functions of CasADi."""

    title = "Python with CasADi"

    def files(self, program: Program, head: Sequence[str]) -> dict[str, str]:
        """Return the module."""
        titles = {
            "tau": "torques and forces added to those of the mechanism",
            "p": "parameters, in the mechanism PARAMETERS",
        }
        told = [*head, "", "Each function is a casadi.Function of all its arguments."]
        lines = open_module(program, told, titles, ())
        values = [letter.value for letter in program.parameters]
        lines += ["import casadi as ca", "", f"PARAMETERS = {values!r}"]
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
        return say_versions("casadi")


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
