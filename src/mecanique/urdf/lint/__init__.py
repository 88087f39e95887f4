"""What is wrong in a URDF text, and what different programs read differently."""

from mecanique.model.mechanism.origin import Finding
from mecanique.urdf.lint.check import lint
from mecanique.urdf.lint.homogeneous import compare_inertias
from mecanique.urdf.lint.output import as_json, as_sarif, as_text
from mecanique.urdf.lint.repair import find_balances, mend

__all__ = [
    "Finding",
    "as_json",
    "as_sarif",
    "as_text",
    "compare_inertias",
    "find_balances",
    "lint",
    "mend",
]
