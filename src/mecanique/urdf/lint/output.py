"""Findings as text for people and JSON for programs."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict

from mecanique.model.mechanism.origin import Finding


def as_text(findings: Sequence[Finding]) -> str:
    """Return findings as text: why each matters and how to fix it, then their number.

    Args:
        findings: from `lint`.
    """
    lines = [
        line
        for finding in findings
        for line in (str(finding), f"    {finding.why} {finding.remedy}")
    ]
    counts: Counter[str] = Counter(finding.severity for finding in findings)
    totals = [
        f"{counts[severity]} {word if counts[severity] == 1 else word + 's'}"
        for severity, word in (("error", "error"), ("warning", "warning"), ("info", "note"))
        if counts[severity]
    ]
    return "\n".join([*lines, ", ".join(totals) or "nothing found"])


def as_json(findings: Sequence[Finding]) -> str:
    """Return findings as JSON: an object with the list "findings".

    Args:
        findings: from `lint`.
    """
    rows = [asdict(finding) for finding in findings]
    return json.dumps({"findings": rows}, indent=2, ensure_ascii=False)
