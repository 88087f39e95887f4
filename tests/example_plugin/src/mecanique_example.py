"""What a package adds to mecanique: a system, a target of code, an engine, a lint rule."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from mecanique.errors import EngineError
from mecanique.generation.program import Program
from mecanique.generation.targets.python import Python
from mecanique.generation.targets.target import Cases
from mecanique.model import Body, Mechanism, Parameter, Prismatic, box
from mecanique.reference.originals.original import ByJoint, Original
from mecanique.textbook.system import System
from mecanique.urdf.lint.check import AddedRule
from mecanique.urdf.markup import Element
from mecanique.urdf.rules import Rule
from mecanique.verification.engines import Engine


def build(m: Parameter, g: Parameter) -> Mechanism:
    """Return a block that falls along a vertical guide."""
    return Mechanism(
        name="sliding_block",
        bodies=(Body("ground"), Body("block", box(m, (0.1, 0.1, 0.1)))),
        joints=(Prismatic("guide", "ground", "block", axis=(0, 0, 1), coordinate="z"),),
        parameters=(m, g),
        gravity=(0, 0, -g),
    )


SLIDING_BLOCK = System(
    title="Block on a vertical guide",
    source="an example of how other packages add systems",
    parameters=(Parameter("m", 2.0, "kg", "mass"), Parameter("g", 9.81, "m/s²", "gravity")),
    build=build,
    duration=1.0,
    tags=("added",),
)


class ShoutedPython:
    """Python whose head is in capitals."""

    title = "PYTHON"

    def __init__(self) -> None:
        self._python = Python()

    def files(self, program: Program, head: Sequence[str]) -> dict[str, str]:
        """Return the files of a program, by name."""
        return self._python.files(program, [line.upper() for line in head])

    def test_files(self, program: Program, cases: Cases) -> dict[str, str]:
        """Return the files of its test, by name."""
        return self._python.test_files(program, cases)

    def commands(self, program: Program, directory: Path) -> list[list[str]]:
        """Return the commands that run the test."""
        return self._python.commands(program, directory)

    def version(self) -> str:
        """Return what runs the code."""
        return self._python.version()


SHOUTED_PYTHON = ShoutedPython()


def refuse(text: bytes, gravity: Sequence[float], q: ByJoint, v: ByJoint) -> Original:
    """Refuse every file."""
    raise EngineError(f"it reads no file, not even one of {len(text)} bytes")


ECHO = Engine("Echo", "mecanique-example", refuse)


def camel_case(robot: Element) -> Iterator[tuple[Element, str, str]]:
    """Yield links whose names have capitals."""
    for link in robot.all("link"):
        name = link.attributes.get("name", "")
        if name != name.lower():
            yield link, f"link {name!r}", "its name has capitals"


NO_CAMEL_CASE = AddedRule(
    Rule("X001", "camel-case", "info", "Our team writes small letters.", "Rename the link."),
    camel_case,
)
