"""Write Python: functions of arrays of numpy or a similar module, or symbolic ones of CasADi."""

from __future__ import annotations

import platform
import pprint
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import final

from mecanique.errors import InputError
from mecanique.generation.program import Answer, Program
from mecanique.generation.targets.target import (
    Cases,
    Read,
    call_functions,
    describe,
    list_answer,
)

NOTATION = call_functions(
    "np.",
    "{} = {}",
    asin="arcsin",
    acos="arccos",
    atan="arctan",
    atan2="arctan2",
    pow="power",
    Abs="abs",
)
"""The notation of numpy."""


def require(package: str) -> None:
    """Check that a package is installed."""
    if find_spec(package) is None:
        raise InputError(
            f"expected {package}, which is not installed: pip install 'mecanique[{package}]'"
        )


def open_module(
    program: Program, head: Sequence[str], titles: Mapping[str, str], said: Sequence[str]
) -> list[str]:
    """Return the docstring of a module: its head, its inputs, and what else is said of it."""
    lines = [*head, ""]
    known = {"q": "generalized coordinates", "v": "generalized velocities", **titles}
    for kind, title in known.items():
        rows = describe(program.letters[kind])
        lines += [f"{kind}: {title}", *(f"    {row}" for row in rows), ""]
    lines = [line.replace("\\", "\\\\").replace('"' * 3, "'" * 3) for line in (*lines, *said)]
    return [f'"""{lines[0]}', *lines[1:], '"""', ""]


def say_versions(package: str) -> str:
    """Return the versions of Python and of a package."""
    return f"Python {platform.python_version()} and {package} {version(package)}"


def write_function(program: Program, answer: Answer) -> list[str]:
    """Return the lines of a function that computes an answer."""
    listing, reads = list_answer(program, answer, NOTATION)
    lines = [*open_function(answer, reads), *(f"    {line}" for line in listing.lines)]
    lines += ["    out = [", *(f"        {text}," for text in listing.outputs), "    ]"]
    return [*lines, f"    return _stack(out, {answer.shape}, {list_arguments(answer)})"]


def open_function(answer: Answer, reads: Sequence[Read]) -> list[str]:
    """Return the first lines of a function: its name and what it reads from its arguments."""
    quantity = answer.quantity
    arguments = [f"{kind}=None" if kind == "tau" else kind for kind in quantity.takes]
    lines = [
        f"def {quantity.name}({', '.join(arguments)}, p=None):",
        f'    """{quantity.meaning[0].upper()}{quantity.meaning[1:]}, shape {answer.shape}."""',
        "    p = _list_parameters(p)",
    ]
    for read in reads:
        if read.array == "t":
            continue
        entry = f"_read({read.array}, {read.place})"
        if read.array in ("tau", "p"):
            default = repr(read.letter.value) if read.array == "p" else "0.0"
            entry = f"{default} if {read.array} is None else {entry}"
        lines.append(f"    {read.symbol} = {entry}")
    return lines


def list_arguments(answer: Answer) -> str:
    """Return the arguments whose leading shapes the answer has."""
    takes = answer.quantity.takes
    return ", ".join(["np.asarray(t)[..., None]" if k == "t" else k for k in takes] + ["p"])


@final
@dataclass(frozen=True)
class Python:
    """A Python module that computes with numpy, or with a similar module."""

    title: str = "Python with numpy"  # name of the language
    package: str = "numpy"  # the package that must be installed
    module: str = "numpy"  # the module that is imported as np
    # writes the lines of one function
    write: Callable[[Program, Answer], list[str]] = field(default=write_function)
    helpers: str = ""  # text of what these lines call beside `_read` and `_stack`

    def files(self, program: Program, head: Sequence[str]) -> dict[str, str]:
        """Return the module."""
        titles = {
            "tau": "torques and forces added to those of the mechanism; none by default",
            "p": "parameters, an array or values by name; PARAMETERS by default",
        }
        said = ["Arrays have the shape (..., size); answers have the same leading shape."]
        if self.package == "jax":
            said += ['For double precision call jax.config.update("jax_enable_x64", True).']
        lines = open_module(program, head, titles, said)
        lines += [f"import {self.package}"] if self.package != self.module else []
        lines += [f"import {self.module} as np", ""]
        for kind, name in (("q", "COORDINATES"), ("v", "VELOCITIES")):
            lines.append(f"{name} = {tuple(letter.name for letter in program.letters[kind])!r}")
        values = {letter.name: letter.value for letter in program.parameters}
        lines += [f"PARAMETERS = {pprint.pformat(values, sort_dicts=False)}", "", ""]
        functions = [self.write(program, answer) for answer in program.answers]
        needed = any("_take(" in line for text in functions for line in text)
        lines += [_HELPERS + self.helpers if needed else _HELPERS]
        for text in functions:
            lines += ["", "", *text]
        return {f"{program.name}.py": "\n".join([*lines, ""])}

    def test_files(self, program: Program, cases: Cases) -> dict[str, str]:
        """Return the test with its table."""
        return {
            f"test_{program.name}.py": write_test(
                program, cases, _DOUBLE if self.package == "jax" else (), COMPARE
            )
        }

    def commands(self, program: Program, directory: Path) -> list[list[str]]:
        """Return the command that runs the test."""
        require(self.package)
        return [[sys.executable, str(directory / f"test_{program.name}.py")]]

    def version(self) -> str:
        """Return the versions of Python and the package."""
        return say_versions(self.package)


_HELPERS = '''
def _read(array, k):
    return np.asarray(array)[..., k]


def _list_parameters(p):
    """Return parameters as an array; those that a dictionary leaves out are in PARAMETERS."""
    if not isinstance(p, dict):
        return p
    unknown = [name for name in p if name not in PARAMETERS]
    if unknown:
        raise ValueError(f"expected parameters among {', '.join(PARAMETERS)}, got {unknown[0]!r}")
    values = [np.asarray(value) for value in {**PARAMETERS, **p}.values()]
    return np.stack(np.broadcast_arrays(*values), axis=-1) if values else None


def _lead(given):
    """Return the leading shape of what was given."""
    return np.broadcast_shapes(*(np.shape(a)[:-1] for a in given if a is not None))


def _stack(entries, shape, *given):
    """Return entries as an array, with the leading shape of what was given."""
    leading = _lead(given)
    columns = [np.broadcast_to(entry, leading) for entry in entries]
    return np.reshape(np.stack(columns, axis=-1), leading + shape)
'''.strip("\n")


def write_test(
    program: Program, cases: Cases, first: Sequence[str], compare: str, file: str | None = None
) -> str:
    """Write a Python program with states and expected values that compares the code."""
    file = file or f"{program.name}.py"
    lines = [
        f'"""Compares {file} with reference values."""',
        "",
        "import importlib.util",
        "import pathlib",
        "import sys",
        "",
        "import numpy as np",
        "",
        *first,
        f'HERE = pathlib.Path(__file__).with_name("{file}")',
        *_write_tables(program, cases),
    ]
    return "\n".join([*lines, compare])


def _write_tables(program: Program, cases: Cases) -> list[str]:
    takes = {answer.quantity.name: [*answer.quantity.takes, "p"] for answer in program.answers}
    named = {
        "INPUTS": cases.inputs,
        "EXPECTED": cases.expected,
        "WEIGHTS": cases.weights,
        "ALLOWED": cases.allowed,
    }
    lines = [f"TAKES = {takes!r}"]
    for name, table in named.items():
        rows = {key: values.tolist() for key, values in table.items()}
        lines.append(f"{name} = {rows!r}")
    return lines


_DOUBLE = ["import jax", "", 'jax.config.update("jax_enable_x64", True)', ""]

COMPARE = """

def call(function, given):
    return function(*given)


def main():
    spec = importlib.util.spec_from_file_location("code", HERE)
    code = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(code)
    inputs = {kind: np.array(rows, dtype=float) for kind, rows in INPUTS.items()}
    inputs["t"] = inputs["t"][:, 0]
    inputs["y"] = np.hstack([inputs["q"], inputs["v"]])
    failed = 0
    for name, takes in TAKES.items():
        out = np.asarray(call(getattr(code, name), [inputs[kind] for kind in takes]))
        off = np.reshape(out, np.shape(EXPECTED[name])) - EXPECTED[name]
        difference = np.linalg.norm(np.array(WEIGHTS[name]) * off, axis=1)
        where = int(np.argmax(difference))
        print(name, float(difference[where]), where)
        for k in np.flatnonzero(~(difference <= ALLOWED[name])):
            print(f"{name} differs by {difference[k]:.3g} in state {k}", file=sys.stderr)
            failed = 1
    return failed


if __name__ == "__main__":
    sys.exit(main())
"""


_CASADI = call_functions("ca.", "{} = {}", pow="power", Abs="fabs")

_COMPARE_CASADI = COMPARE.replace(
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
            lines += ["", "", *_write_casadi(program, answer)]
        return {f"{program.name}.py": "\n".join([*lines, ""])}

    def test_files(self, program: Program, cases: Cases) -> dict[str, str]:
        """Return the test with its table."""
        return {f"test_{program.name}.py": write_test(program, cases, (), _COMPARE_CASADI)}

    def commands(self, program: Program, directory: Path) -> list[list[str]]:
        """Return the command that runs the test."""
        require("casadi")
        return [[sys.executable, str(directory / f"test_{program.name}.py")]]

    def version(self) -> str:
        """Return the versions of Python and CasADi."""
        return say_versions("casadi")


def _write_casadi(program: Program, answer: Answer) -> list[str]:
    quantity = answer.quantity
    listing, reads = list_answer(program, answer, _CASADI)
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
