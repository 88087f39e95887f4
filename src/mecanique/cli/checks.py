"""Check a file, a system or a whole collection, for `mecanique lint` and `mecanique verify`."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, final

import click

import mecanique as mq
from mecanique.cli.printing import inform, progress, say, write_text
from mecanique.cli.reading import Reading
from mecanique.cli.words import numbers

if TYPE_CHECKING:
    from mecanique.model.mechanism.origin import Finding
    from mecanique.verification.facts import FactRow
    from mecanique.verification.survey import Survey


_PROCESSES = 2


@final
@dataclass(frozen=True)
class Check:
    """A verdict on a system's equations, and the facts that its textbook states.

    Args:
        verdict: of the comparison.
        facts: the facts of a textbook system; none of any other.
        states: whether to print the states where what disagrees is worst.
    """

    verdict: mq.Verdict
    facts: tuple[FactRow, ...]
    states: bool = False

    @property
    def right(self) -> bool:
        """Whether the sources agree and no fact fails."""
        return self.verdict.agrees and not any(fact.fails for fact in self.facts)

    def to_json(self) -> str:
        """Return the verdict as JSON text, with the facts if there are any."""
        facts = {"facts": [fact.to_dict() for fact in self.facts]} if self.facts else {}
        whole = {**self.verdict.to_dict(), **facts}
        return json.dumps(whole, ensure_ascii=False, allow_nan=False, indent=2)

    def __str__(self) -> str:
        states = self.verdict.worst_states if self.states else ()
        return "\n".join([str(self.verdict), *states, *map(str, self.facts)])


def textbook_facts(system: str, parameters: Sequence[str], seed: int) -> tuple[FactRow, ...]:
    """Check the facts of a textbook system; there are none of any other."""
    if not mq.textbook.catalogue.is_known(system):
        return ()
    from mecanique.verification.facts import check

    return check(system, numbers(parameters, "-p"), seed=seed)


def lint_file(
    file: str,
    form: str,
    reading: Reading,
    *,
    fix: bool,
    output: Path | None,
    balance: bool = False,
    meshes: bool = False,
) -> int:
    """Report what is wrong in a URDF file, or repair it; return the exit code."""
    from mecanique.urdf.lint import as_json, as_sarif, as_text, find_balances, lint, mend

    if output is not None and not fix:
        raise mq.InputError("expected --fix with --output: only a repaired copy goes to a file")
    if fix and Path(file).suffix == ".xacro":
        raise mq.InputError("expected a URDF file with --fix: a xacro file is mended by hand")
    if balance and not fix:
        raise mq.InputError("expected --fix with --balance: it repairs a copy")
    path = Path(file) if Path(file).exists() or not _is_word(file) else mq.robot(file)
    findings = lint(
        path,
        package_path=reading.package_path or None,
        arguments=reading.arguments,
        meshes=meshes,
    )
    if fix and not any(_unreadable(finding.code) for finding in findings):
        given = path.read_text(encoding="utf-8-sig")
        text = mend(given, name=path.stem, balance=balance)
        for change in find_balances(given) if balance else ():
            inform(f"nearest inertia of a real body, {change}")
        if output is None:
            click.echo(text, nl=False)
            return _code(lint(text))
        write_text(output, text)
        findings = lint(output)
    say({"text": as_text, "json": as_json, "sarif": as_sarif}[form](findings))
    return _code(findings)


def survey(samples: int, seed: int, *, robots: bool) -> Survey:
    """Verify every textbook system, or every robot, and show progress."""
    from mecanique.verification.survey import survey_robots, survey_systems

    verify, what = (survey_robots, "robot") if robots else (survey_systems, "textbook system")
    with progress(f"Verifying every {what}") as advance:
        processes = min(_PROCESSES, os.cpu_count() or 1)
        return verify(samples, seed, processes=processes, progress=advance)


def _code(findings: tuple[Finding, ...]) -> int:
    if any(_unreadable(finding.code) for finding in findings):
        return 2
    return 1 if any(finding.severity == "error" for finding in findings) else 0


def _unreadable(code: str) -> bool:
    return code.startswith("M0")


def _is_word(text: str) -> bool:
    return not text.endswith((".urdf", ".xml", ".xacro")) and text in mq.robots()
