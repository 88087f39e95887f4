"""Motion: integrate a mechanism's equations, look at what comes of them, and audit it."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mecanique.motion.audit import Audit, AuditRow
    from mecanique.motion.dense import State
    from mecanique.motion.energies import Energies
    from mecanique.motion.equilibrium import Equilibrium, equilibria
    from mecanique.motion.events import Event, Occurrence
    from mecanique.motion.integrate import simulate
    from mecanique.motion.linearization import Linearization, frequency_response, linearize
    from mecanique.motion.motion import Motion, Statistics
    from mecanique.motion.trust import Trust

__all__ = [
    "Audit",
    "AuditRow",
    "Energies",
    "Equilibrium",
    "Event",
    "Linearization",
    "Motion",
    "Occurrence",
    "State",
    "Statistics",
    "Trust",
    "equilibria",
    "frequency_response",
    "linearize",
    "simulate",
]

_HOMES = {
    "Audit": "audit",
    "AuditRow": "audit",
    "Energies": "energies",
    "Equilibrium": "equilibrium",
    "Event": "events",
    "Linearization": "linearization",
    "Motion": "motion",
    "Occurrence": "events",
    "State": "dense",
    "Statistics": "motion",
    "Trust": "trust",
    "equilibria": "equilibrium",
    "frequency_response": "linearization",
    "linearize": "linearization",
    "simulate": "integrate",
}
"""The module of each name; they are imported when somebody asks for them."""


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value
