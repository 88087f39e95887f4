"""What a rule of the linter states."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from mecanique.model.mechanism.origin import Severity


@final
@dataclass(frozen=True)
class Rule:
    """A rule of the linter.

    Args:
        code: e.g. "M204"; M0 files, M1 structure, M2 masses, M3 joints, M4 mimic, M5 pictures, M6
            drake: tags, M7 engines.
        name: the rule in words, e.g. "triangle-inequality".
        severity: of its findings.
        why: why it matters.
        remedy: how to mend what it finds.
    """

    code: str
    name: str
    severity: Severity
    why: str
    remedy: str
