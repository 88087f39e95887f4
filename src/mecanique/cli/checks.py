"""Checking files and whole collections: what `mecanique lint` and `mecanique verify --all` and `--robots` do."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import typer

import mecanique as mq
from mecanique.cli.printing import progress, say

if TYPE_CHECKING:
    from mecanique.urdf.findings import Finding
    from mecanique.verification.survey import Survey

__all__ = ["linted", "surveyed"]

_PROCESSES = 2


def linted(file: str, form: str, *, fix: bool, output: Path | None) -> int:
    """Print what is wrong in a URDF file, or mend it; return the exit code.

    Args:
        file: its path, or a robot's name.
        form: "text", "json" or "sarif".
        fix: whether to mend what has one safe mend.
        output: where the mended text goes; it is printed without.
    """
    from mecanique.urdf.lint import as_json, as_sarif, as_text, lint, mend

    if output is not None and not fix:
        raise mq.InputError("expected --fix with --output: only a mended copy is written to a file")
    path = Path(file) if Path(file).exists() or not _is_word(file) else mq.robot(file)
    findings = lint(path)
    if fix and not any(_unreadable(finding.code) for finding in findings):
        text = mend(path.read_text(encoding="utf-8-sig"), name=path.stem)
        if output is None:
            typer.echo(text, nl=False)
            return _code(lint(text))
        output.write_text(text, encoding="utf-8")
        findings = lint(output)
    say({"text": as_text, "json": as_json, "sarif": as_sarif}[form](findings))
    return _code(findings)


def surveyed(samples: int, seed: int, *, robots: bool) -> Survey:
    """Verify every textbook system, or every robot, showing progress.

    Args:
        samples: number of random states of each.
        seed: of the random states.
        robots: whether the robots.
    """
    from mecanique.verification.survey import survey_robots, survey_systems

    survey, what = (survey_robots, "robot") if robots else (survey_systems, "textbook system")
    with progress(f"Verifying every {what}") as advance:
        processes = min(_PROCESSES, os.cpu_count() or 1)
        return survey(samples, seed, processes=processes, progress=advance)


def _code(findings: tuple[Finding, ...]) -> int:
    if any(_unreadable(finding.code) for finding in findings):
        return 2
    return 1 if any(finding.severity == "error" for finding in findings) else 0


def _unreadable(code: str) -> bool:
    return code.startswith("M0")


def _is_word(text: str) -> bool:
    return not text.endswith((".urdf", ".xml")) and text in mq.robots()
