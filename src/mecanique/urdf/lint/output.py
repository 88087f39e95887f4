"""Findings as text for people and JSON for programs."""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any
from urllib.parse import quote

from mecanique.model.mechanism.origin import Finding
from mecanique.urdf.rules import RULES, Rule


def as_text(findings: Sequence[Finding]) -> str:
    """Return findings as text: why each matters and how to fix it, then their number."""
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
    """Return findings as JSON: an object with the list "findings"."""
    rows = [asdict(finding) for finding in findings]
    return json.dumps({"findings": rows}, indent=2, ensure_ascii=False)


_LEVELS = {"error": "error", "warning": "warning", "info": "note"}


def as_sarif(findings: Sequence[Finding]) -> str:
    """Return findings as a SARIF 2.1.0 log."""
    codes = sorted({finding.code for finding in findings})
    driver = {"name": "mecanique", "rules": [_rule(RULES[code]) for code in codes]}
    results = [_result(finding, codes.index(finding.code)) for finding in findings]
    log = {
        "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
        "version": "2.1.0",
        "runs": [
            {"tool": {"driver": driver}, "columnKind": "unicodeCodePoints", "results": results}
        ],
    }
    return json.dumps(log, indent=2, ensure_ascii=False)


def _rule(rule: Rule) -> dict[str, Any]:
    return {
        "id": rule.code,
        "name": rule.name,
        "shortDescription": {"text": rule.name.replace("-", " ")},
        "fullDescription": {"text": rule.why},
        "help": {"text": rule.remedy},
        "defaultConfiguration": {"level": _LEVELS[rule.severity]},
    }


def _result(finding: Finding, index: int) -> dict[str, Any]:
    file = finding.file
    uri = Path(file).as_uri() if os.path.isabs(file) else quote(file.replace(os.sep, "/"))
    place: dict[str, Any] = {
        "physicalLocation": {
            "artifactLocation": {"uri": uri},
            "region": {"startLine": max(finding.line, 1)},
        }
    }
    if finding.where:
        place["logicalLocations"] = [{"name": finding.where, "kind": "element"}]
    text = f"{finding.where}: {finding.message}" if finding.where else finding.message
    return {
        "ruleId": finding.code,
        "ruleIndex": index,
        "level": _LEVELS[finding.severity],
        "message": {"text": f"{text}. {finding.why} {finding.remedy}"},
        "locations": [place],
    }
