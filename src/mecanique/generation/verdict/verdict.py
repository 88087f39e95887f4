"""Judge code by building and running its test."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import final

import numpy as np

from mecanique.errors import DerivationError, EngineError
from mecanique.files import as_bytes
from mecanique.generation.program import Program
from mecanique.generation.targets.target import Cases, Target
from mecanique.generation.verdict.cases import TOLERANCE, count_varied
from mecanique.verification.verdict import NOT_INSTALLED, versions


@final
@dataclass(frozen=True)
class CodeVerdict:
    """The result of comparing code with Pinocchio.

    Args:
        samples: number of states in which it was compared.
        seed: of the random states.
        tolerance: largest relative difference that counts as agreement, unless rounding allows
            more.
        worst: worst relative difference of each quantity, by name.
        rounded: largest difference that rounding excuses in some state, by name; 0 if the
            tolerance was enough everywhere.
        versions: versions of the tools involved, by name.
        varied: number of states with parameters other than the mechanism's.
    """

    samples: int
    seed: int
    tolerance: float
    worst: dict[str, float]
    rounded: dict[str, float]
    versions: dict[str, str]
    varied: int = 0

    def lines(self) -> list[str]:
        """Return the verdict in sentences, for the head of a file."""
        by = ", ".join(f"{name} {version}" for name, version in self.versions.items())
        missing = self.versions.get("pin") == NOT_INSTALLED
        engine = "a stand-in for Pinocchio" if missing else "Pinocchio"
        varied = f", {self.varied} of them with other parameters" if self.varied else ""
        lines = [
            f"Run and compared with {engine} at {self.samples} random states "
            f"(seed {self.seed}){varied}:"
        ]
        for name, worst in self.worst.items():
            excused = self.rounded.get(name, 0.0)
            beyond = (
                f"; rounding allows {excused:.1e}" if excused and worst > self.tolerance else ""
            )
            lines.append(f"  {name}: worst relative difference {worst:.1e}{beyond}")
        return [*lines, f"With {by}."]

    def __str__(self) -> str:
        return "\n".join(self.lines())


def _run(command: list[str]) -> subprocess.CompletedProcess[str]:
    """Run a command to its end, or say why none can run."""
    try:
        return subprocess.run(
            command, capture_output=True, encoding="utf-8", errors="replace", check=False
        )
    except OSError as error:  # in a browser there are no processes
        raise EngineError(
            "code is compared in a process of its own before it is handed out, and none can be "
            f"started here ({error}); generate it where Python runs by itself"
        ) from error


def judge(program: Program, target: Target, cases: Cases, seed: int) -> CodeVerdict:
    """Run the test of a program."""
    with TemporaryDirectory() as folder:
        directory = Path(folder)
        files = {**target.files(program, ["unjudged"]), **target.test_files(program, cases)}
        for name, content in files.items():
            (directory / name).write_bytes(as_bytes(content))
        done = None
        for command in target.commands(program, directory):
            done = _run(command)
            if done.returncode and not done.stdout:
                raise DerivationError(
                    f"the {target.title} of {program.mechanism.name!r} does not run: "
                    f"{done.stderr.strip()[:2000]}"
                )
    assert done is not None, "every language has a command"
    worst = {name: float(number) for name, number, _ in map(str.split, done.stdout.splitlines())}
    if done.returncode:
        raise DerivationError(
            f"the {target.title} of {program.mechanism.name!r} and the reference disagree: "
            f"{'; '.join(done.stderr.splitlines()[:3])}"
        )
    return CodeVerdict(
        samples=len(cases),
        seed=seed,
        tolerance=TOLERANCE,
        worst=worst,
        rounded={name: float(np.max(rows, initial=0.0)) for name, rows in cases.allowed.items()},
        versions={**versions(), "run by": target.version()},
        varied=count_varied(program, cases),
    )
