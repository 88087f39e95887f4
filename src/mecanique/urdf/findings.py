"""Findings: what is wrong in a URDF text, or what other programs read differently."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple, Protocol, final

from mecanique.errors import UrdfError
from mecanique.files import name_file
from mecanique.model.mechanism.origin import Finding
from mecanique.urdf.markup import Element
from mecanique.urdf.rules import RULES, Rule

_MOST_LISTED = 40

_ALWAYS = {"M006"}
"""Errors that stop the reader wherever they stand: a macro may stand for anything."""


class Located(Protocol):
    """Anything that reports name and that stands in a text."""

    @property
    def element(self) -> Element:
        """Where it stands."""

    @property
    def where(self) -> str:
        """What reports call it, e.g. "link 'arm'"."""


@final
class Spot(NamedTuple):
    """An element, by what reports call it."""

    element: Element
    where: str


@final
class Report:
    """Collect the findings of one text."""

    def __init__(
        self, file: str | None, findings: list[Finding] | None = None, *, stops: bool = True
    ) -> None:
        self.file = file
        self.findings: list[Finding] = [] if findings is None else findings
        self._stops = stops

    @cached_property
    def aside(self) -> Report:
        """The same report for what no equation of motion uses: its errors stop no reader."""
        return Report(self.file, self.findings, stops=False)

    def add(
        self, code: str | Rule, at: Located | Element | int, message: str, remedy: str | None = None
    ) -> None:
        """Note a finding at a line, at an element or at what stands there and has a name."""
        rule = RULES[code] if isinstance(code, str) else code
        where = "" if isinstance(at, Element | int) else at.where
        at = at if isinstance(at, Element | int) else at.element
        line, file = (at, "") if isinstance(at, int) else (at.line, at.file)
        finding = Finding(
            code=rule.code,
            severity=rule.severity,
            file=name_file(file or self.file or "<text>"),
            line=line,
            where=where,
            message=message,
            why=rule.why,
            remedy=remedy or rule.remedy,
            name=rule.name,
            stops=rule.severity == "error" and (self._stops or rule.code in _ALWAYS),
        )
        self.findings.append(finding)

    def together(self, code: str, places: Sequence[Located], message: str) -> None:
        """Note one finding for many places, at the first of them; nothing without places."""
        if places:
            names = list(dict.fromkeys(place.where for place in places))
            shown = ", ".join(names[:4]) + (f", … ({len(names)} in all)" if len(names) > 4 else "")
            self.add(code, Spot(places[0].element, shown), message)

    @property
    def errors(self) -> list[Finding]:
        """The findings that a strict reader refuses."""
        return [finding for finding in self.findings if finding.severity == "error"]

    @property
    def flaws(self) -> tuple[Finding, ...]:
        """The errors that the equations of motion do without, in order of the text."""
        past = [finding for finding in self.errors if not finding.stops]
        return tuple(sorted(past, key=lambda finding: finding.line))

    @property
    def stopped(self) -> bool:
        """Whether there is an error that no reader gets past."""
        return any(finding.stops for finding in self.findings)

    def refuse(self, *, strict: bool = True) -> None:
        """Raise one error for all errors found, if any of them stops the reader."""
        errors = sorted(self.errors, key=lambda finding: finding.line)
        if not (errors if strict else self.stopped):
            return
        sentences = [error.sentence for error in errors]
        if len(errors) == 1:
            (only,) = errors
            file = only.file if self.file else None
            raise UrdfError(f"{sentences[0]}. {only.remedy}", file=file, line=only.line)
        listed = []
        for error, sentence in zip(errors, sentences, strict=True):
            place = f"{error.file}:" if self.file else "line "
            listed.append(f"{place}{error.line}: {sentence}")
        if len(listed) > _MOST_LISTED:
            listed[_MOST_LISTED:] = [f"… and {len(errors) - _MOST_LISTED} more"]
        raise UrdfError(
            "\n  ".join([f"{len(errors)} errors:", *listed]),
            file=name_file(self.file or "") or None,
        )
