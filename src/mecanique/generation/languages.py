"""Write equations of motion as code, run it, and compare it with Pinocchio."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import final

from mecanique.derivation.equations import Equations
from mecanique.derivation.switching import Modes
from mecanique.errors import InputError, UnknownNameError
from mecanique.files import as_bytes, write_whole
from mecanique.generation.build import build_modes, build_program, refuse_time
from mecanique.generation.compiled import OPTIONS, Compiled, compile_program
from mecanique.generation.program import Program
from mecanique.generation.targets.c import C
from mecanique.generation.targets.fmu import FMU
from mecanique.generation.targets.javascript import JavaScript
from mecanique.generation.targets.jax import JAX
from mecanique.generation.targets.python import CasADi, Python
from mecanique.generation.targets.target import Target
from mecanique.generation.verdict import CodeVerdict, cases_of, judge, start_of
from mecanique.model.values import Given, whole
from mecanique.plugins import list_plugins, load_plugin
from mecanique.program.tape import Counts
from mecanique.verification.verdict import versions


@final
@dataclass(frozen=True, repr=False)
class Code:
    """The equations of a mechanism as code.

    Args:
        target: the language, e.g. "c".
        program: the program it was written from.
        files: content of each file by name, including the test that compares it with Pinocchio.
        verdict: result of the comparison with Pinocchio; None if the code could not be run here.

    Example:
        >>> code = mq.generate(mq.derive(mq.textbook.load("simple_pendulum")), "python")
        >>> code.count("acceleration").multiplications
        4
        >>> [path.name for path in code.write("pendulum")]
        ['simple_pendulum.py', 'test_simple_pendulum.py']
    """

    target: str
    program: Program
    files: Mapping[str, str | bytes]
    verdict: CodeVerdict | None

    @property
    def name(self) -> str:
        """The stem of the names of functions and files."""
        return self.program.name

    @property
    def parameters(self) -> tuple[str, ...]:
        """The parameters that the functions take, in order."""
        return tuple(letter.name for letter in self.program.parameters)

    def count(self, quantity: str | None = None) -> Counts:
        """Return the number of operations of one quantity, or of all together.

        Args:
            quantity: its name.
        """
        return self.program.count(quantity)

    def write(self, directory: str | Path) -> tuple[Path, ...]:
        """Write the files, all of them or none, and return their paths.

        Args:
            directory: the directory, which is created if it does not exist.

        Raises:
            InputError: if the directory cannot be created or written to.
        """
        place = Path(directory)
        try:
            place.mkdir(parents=True, exist_ok=True)
            with ExitStack() as stack:
                for name, content in self.files.items():
                    file = stack.enter_context(write_whole(place / name))
                    file.write(as_bytes(content))
        except OSError as error:
            raise InputError(
                f"expected a directory to write to, got {directory}: {error}"
            ) from None
        return tuple(place / name for name in self.files)

    def compile(self, options: Sequence[str] = OPTIONS) -> Compiled:
        """Compile the C code and return its functions, to call with arrays.

        Args:
            options: options of the compiler.

        Raises:
            InputError: if the code is not C, no C compiler is installed, or it refuses the code.
        """
        if self.target != "c":
            raise InputError(f'expected code with target="c" to compile, got {self.target!r}')
        return compile_program(self.program, self._texts, options)

    @property
    def _texts(self) -> dict[str, str]:
        return {name: text for name, text in self.files.items() if isinstance(text, str)}

    def __str__(self) -> str:
        return "\n".join(self._texts.values())

    def __repr__(self) -> str:
        what = ", ".join(answer.quantity.name for answer in self.program.answers)
        name = self.program.mechanism.name
        return f"<Code of {name!r}: {what} in {self.target}, {self.count().total} operations>"


TARGETS: dict[str, Target] = {
    "c": C(),
    "javascript": JavaScript(),
    "python": Python(),
    "jax": JAX,
    "casadi": CasADi(),
    "fmu": FMU(),
}
"""The languages by name."""


def target_of(name: str) -> Target:
    """Return a language by its name, including those added by other packages."""
    if name in TARGETS:
        return TARGETS[name]
    if name in list_plugins("targets"):
        return load_plugin("targets", name, Target)  # type: ignore[type-abstract]
    raise UnknownNameError("target", name, [*TARGETS, *list_plugins("targets")])


_NUMBERS = 40_000
"""Largest number of entries in the tables of a test."""


def generate(
    equations: Equations | Modes,
    target: str = "c",
    what: str | Sequence[str] = ("acceleration", "energy"),
    *,
    parameters: Sequence[str] | None = None,
    name: str | None = None,
    q: Given = None,
    v: Given = None,
    samples: int = 100,
    seed: int = 0,
) -> Code:
    """Write equations of motion as code in another language.

    The code is run and compared with Pinocchio, and its file states the result; if the language
    cannot be run here, the file says so.

    Args:
        equations: the equations of motion; or, of what switches, the modes of `derive_modes`: a
            function for each mode, with its accelerations and the elements' forces, one for each
            impact of an element, with the velocities after it and its impulses, and one with gaps
            and rates. An FMU moves through all modes by itself, and has these gaps and rates, and
            the state of each element, as outputs. `what` is then left aside.
        target: "c" (C99 that allocates nothing), "javascript", "python" (numpy, for many states at
            once), "jax", "casadi" or "fmu" (FMI 3.0, model exchange and co-simulation, for
            simulation tools; the quantities are its outputs).
        what: quantities, each a function: "rhs", "acceleration", "mass_matrix", "bias", "gravity",
            "forces", "inverse_dynamics", "energy", "poses" and "jacobians" of all bodies, the
            "reactions" of joints and loops, and for loops "multipliers" and "closure";
            "acceleration_by_q" and so on are derivatives by q (along the motion of each velocity),
            v, y, a, tau or p; "rhs_by_y" and "rhs_by_tau" linearize.
        parameters: symbols of the parameters and constant inputs that remain arguments of the
            functions; all by default. The others become numbers.
        name: stem of the names of functions and files; the mechanism's name by default.
        q: default initial coordinates of an FMU, in order or by name; a closed mechanism is
            assembled near these.
        v: its default initial velocities.
        samples: number of random states at which the code is compared.
        seed: of the random states.

    Returns:
        The code with its test, and the result of the comparison.

    Raises:
        UnknownNameError: if a target, quantity or parameter is not known.
        InputError: if another argument is invalid.
        DerivationError: if the equations have no program, or the code and Pinocchio disagree.

    Example:
        >>> code = mq.generate(mq.derive(mq.textbook.load("simple_pendulum")), "python")
        >>> list(code.files)
        ['simple_pendulum.py', 'test_simple_pendulum.py']
        >>> code.verdict.worst["acceleration"] < 1e-9
        True
    """
    samples, seed = whole(samples, "samples", 1), whole(seed, "seed", 0)
    language = target_of(target)
    moves = isinstance(language, FMU)
    if isinstance(equations, Modes):
        refuse_time(equations.mechanism)
        program = build_modes(equations, parameters, name, moves=moves)
    else:
        program = build_program(equations, what, parameters, name, moves=moves)
    if moves:
        program = replace(program, start=start_of(equations.mechanism, q, v))
    cases = cases_of(program, samples, seed)
    verdict: CodeVerdict | None = None
    try:
        verdict = judge(program, language, cases, seed)
        said = verdict.lines()
    except InputError as error:
        said = [f"Not run where it was written: {error}."]
    width = sum(rows.shape[1] for rows in cases.inputs.values()) + 2 * sum(
        rows.shape[1] for rows in cases.expected.values()
    )
    shipped = cases.first(max(1, min(samples, _NUMBERS // max(width, 1))))
    files = language.files(program, [*_head(program, language), *said])
    return Code(target, program, {**files, **language.test_files(program, shipped)}, verdict)


def _head(program: Program, language: Target) -> list[str]:
    counts = [
        f"  {answer.quantity.name}: {program.count(answer.quantity.name)}"
        for answer in program.answers
    ]
    return [
        f"Equations of motion of the mechanism {program.mechanism.name!r} in {language.title}.",
        "",
        f"Written by mecanique {versions()['mecanique']} from the {program.origin}.",
        *counts,
    ]
