"""Rules that other packages add."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TypeAlias, final

from mecanique.plugins import list_plugins, load_plugin
from mecanique.urdf.element import Element
from mecanique.urdf.findings import Report
from mecanique.urdf.reading.document import Document
from mecanique.urdf.rules import Rule

Fault: TypeAlias = tuple[Element, str, str]
"""The element at fault, where it is (e.g. "link 'arm'"), and what is wrong."""


@final
@dataclass(frozen=True)
class AddedRule:
    """A rule of another package, an entry point of the group `mecanique.lint_rules`.

    Args:
        rule: its code, name, severity, reason and remedy.
        check: yields the faults in a document, from its outermost element.
    """

    rule: Rule
    check: Callable[[Element], Iterable[Fault]]


def check(document: Document, report: Report) -> None:
    """Note what the rules of other packages find.

    Raises:
        InputError: if one cannot be loaded.
    """
    for name in list_plugins("lint_rules"):
        each = load_plugin("lint_rules", name, AddedRule)
        for element, where, message in each.check(document.element):
            report.add(each.rule, element, where, message)
