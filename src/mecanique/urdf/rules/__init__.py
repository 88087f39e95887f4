"""The rules of the linter: what each code means, why it matters and how to mend it.

An "error" is what `read_urdf(strict=True)` refuses; without strict, those errors are read past
that no equation of motion needs. A "warning" is likely a mistake, or says that something
which moves the mechanism is left out. An "info" says that other programs read the same text
differently, or what is not used.
"""

from mecanique.urdf.rules import (
    engines,
    extensions,
    files,
    joints,
    masses,
    mimic,
    pictures,
    structure,
)
from mecanique.urdf.rules.rule import Rule

__all__ = ["RULES", "Rule"]

_TABLES = (
    files.RULES,
    structure.RULES,
    masses.RULES,
    joints.RULES,
    mimic.RULES,
    pictures.RULES,
    extensions.RULES,
    engines.RULES,
)

RULES: dict[str, Rule] = {rule.code: rule for table in _TABLES for rule in table}
"""Every rule by its code."""
