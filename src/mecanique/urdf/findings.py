"""Findings: what is wrong in a URDF text, or what other programs read differently."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from mecanique.errors import UrdfError
from mecanique.urdf.element import Element
from mecanique.urdf.rules import RULES, Severity

__all__ = ["Finding", "Report"]

_MOST_LISTED = 40


@final
@dataclass(frozen=True)
class Finding:
    """One finding about a URDF text.

    Args:
        code: which rule found it, e.g. "M204".
        severity: "error" is what `read_urdf` refuses, "warning" is likely a mistake or leaves
            something out, "info" is read differently by others.
        file: name of the file; "<text>" if there is none.
        line: the line, counted from 1.
        where: the link, joint or other element, e.g. "joint 'knee'".
        message: what is found.
        why: why it matters.
        remedy: how to mend it.
    """

    code: str
    severity: Severity
    file: str
    line: int
    where: str
    message: str
    why: str
    remedy: str

    @property
    def name(self) -> str:
        """The rule's name in words, e.g. "triangle-inequality"."""
        return RULES[self.code].name

    def __str__(self) -> str:
        place = f"{self.where}: " if self.where else ""
        return f"{self.file}:{self.line}: {self.severity} {self.code} {place}{self.message}"


@final
class Report:
    """Collect the findings of one text.

    Args:
        file: name of the file, if there is one.
    """

    def __init__(self, file: str | None) -> None:
        self.file = file
        self.findings: list[Finding] = []

    def add(
        self, code: str, at: Element | int, where: str, message: str, remedy: str | None = None
    ) -> None:
        """Note a finding.

        Args:
            code: the rule's code.
            at: the element or line at fault.
            where: the link, joint or other element.
            message: what is found.
            remedy: how to mend it, if better known than by the rule.
        """
        rule = RULES[code]
        line = at if isinstance(at, int) else at.line
        finding = Finding(
            code,
            rule.severity,
            self.file or "<text>",
            line,
            where,
            message,
            rule.why,
            remedy or rule.remedy,
        )
        self.findings.append(finding)

    def together(
        self,
        code: str,
        places: Sequence[tuple[Element, str]],
        message: str,
        remedy: str | None = None,
    ) -> None:
        """Note one finding for many places, at the first of them; nothing without places.

        Args:
            code: the rule's code.
            places: element and name of each place.
            message: what is found there.
            remedy: how to mend it, if better known than by the rule.
        """
        if places:
            names = list(dict.fromkeys(where for _, where in places))
            shown = ", ".join(names[:4]) + (f", … ({len(names)} in all)" if len(names) > 4 else "")
            self.add(code, places[0][0], shown, message, remedy)

    @property
    def errors(self) -> list[Finding]:
        """The findings that make the text unreadable."""
        return [finding for finding in self.findings if finding.severity == "error"]

    def refuse(self) -> None:
        """Raise one error for all errors found, if any.

        Raises:
            UrdfError: that lists every error with its file and line.
        """
        errors = sorted(self.errors, key=lambda finding: finding.line)
        if not errors:
            return
        sentences = [f"{e.where}: {e.message}" if e.where else e.message for e in errors]
        if len(errors) == 1:
            raise UrdfError(
                f"{sentences[0]}. {errors[0].remedy}", file=self.file, line=errors[0].line
            )
        place = f"{self.file}:" if self.file else "line "
        listed = [
            f"{place}{e.line}: {sentence}" for e, sentence in zip(errors, sentences, strict=True)
        ]
        if len(listed) > _MOST_LISTED:
            listed[_MOST_LISTED:] = [f"… and {len(errors) - _MOST_LISTED} more"]
        raise UrdfError("\n  ".join([f"{len(errors)} errors:", *listed]), file=self.file)
