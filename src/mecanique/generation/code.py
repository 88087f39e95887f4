"""Code in some language, with its files and verdict, and a way to call it from Python."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import final

from mecanique.errors import InputError
from mecanique.files import as_bytes, write_whole
from mecanique.generation.compiled import OPTIONS, Compiled, compile_program
from mecanique.generation.program import Program
from mecanique.generation.verdict import CodeVerdict
from mecanique.program.tape import Counts


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
