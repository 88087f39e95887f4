"""Motion: integrate a mechanism's equations, look at what comes of them, and audit it."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mecanique.motion.audit import Audit, AuditRow
    from mecanique.motion.dense import State
    from mecanique.motion.energies import Energies
    from mecanique.motion.ensemble import simulate_many
    from mecanique.motion.equilibrium import Equilibrium, equilibria
    from mecanique.motion.events import Event, Occurrence
    from mecanique.motion.inertial import InertialCheck, inertial_check
    from mecanique.motion.integrate import simulate
    from mecanique.motion.linearization import Linearization
    from mecanique.motion.linearizing import linearize
    from mecanique.motion.motion import Motion, Statistics
    from mecanique.motion.response import Response, frequency_response
    from mecanique.motion.runs import Runs
    from mecanique.motion.trust import Trust

__all__ = [
    "Audit",
    "AuditRow",
    "Energies",
    "Equilibrium",
    "Event",
    "InertialCheck",
    "Linearization",
    "Motion",
    "Occurrence",
    "Response",
    "Runs",
    "State",
    "Statistics",
    "Trust",
    "equilibria",
    "frequency_response",
    "inertial_check",
    "linearize",
    "simulate",
    "simulate_many",
]

_HOMES = {
    "Audit": "audit",
    "AuditRow": "audit",
    "Energies": "energies",
    "Equilibrium": "equilibrium",
    "Event": "events",
    "InertialCheck": "inertial",
    "Linearization": "linearization",
    "Motion": "motion",
    "Occurrence": "events",
    "Response": "response",
    "Runs": "runs",
    "State": "dense",
    "Statistics": "motion",
    "Trust": "trust",
    "equilibria": "equilibrium",
    "frequency_response": "response",
    "inertial_check": "inertial",
    "linearize": "linearizing",
    "simulate": "integrate",
    "simulate_many": "ensemble",
}
"""The module of each name; they are imported when somebody asks for them."""


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value
