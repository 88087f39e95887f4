"""Lint: the reader's findings and those of every rule."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TypeAlias, final

from mecanique.errors import InputError
from mecanique.model.mechanism.origin import Finding
from mecanique.plugins import list_plugins, load_plugin
from mecanique.urdf.findings import Spot
from mecanique.urdf.lint import blanks, engines, homogeneous, masses, sides, spelling, units
from mecanique.urdf.markup import Element
from mecanique.urdf.read import mechanism_of
from mecanique.urdf.reading.document import Source, read_document
from mecanique.urdf.reading.packages import PackagePath
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


def lint(
    path_or_text: Source,
    *,
    package_path: PackagePath | None = None,
    arguments: Mapping[str, str] | None = None,
    meshes: bool = False,
) -> tuple[Finding, ...]:
    """Return what is wrong in a URDF and what other programs read differently, line by line.

    The findings include errors if and only if `read_urdf` refuses the text
    when it is strict.

    Args:
        path_or_text: the path of a URDF file, or its text.
        package_path: folders to search for packages, before those of ROS_PACKAGE_PATH and
            AMENT_PREFIX_PATH.
        arguments: values of the arguments of a xacro file, which is expanded first.
        meshes: whether to read mesh files, too, for centers of mass outside of them and densities
            that no material has.

    Returns:
        What was found, to print or to loop over.

    Raises:
        InputError: if it is neither a path nor a text.

    Example:
        >>> len(mq.lint(mq.write_urdf(mq.textbook.load('rigid_bar_pendulum'))))
        0
    """
    if not isinstance(path_or_text, (str, os.PathLike)) or not os.fspath(path_or_text):
        raise InputError(f"expected the path of a URDF file or its text, got {path_or_text!r}")
    document, report = read_document(path_or_text, package_path, arguments)
    if document is not None:
        mechanism_of(document, report)
        for rules in (spelling, blanks, masses, sides, units, engines):
            rules.check(document, report)
        for name in list_plugins("lint_rules"):
            added = load_plugin("lint_rules", name, AddedRule)
            for element, where, message in added.check(document.element):
                report.add(added.rule, Spot(element, where), message)
        for link in document.links:
            homogeneous.check(link, report, meshes=meshes)
    return tuple(sorted(report.findings, key=lambda finding: (finding.line, finding.code)))
