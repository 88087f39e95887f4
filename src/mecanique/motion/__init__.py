"""Integrate, inspect and audit motions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mecanique.lazy import import_name

if TYPE_CHECKING:
    from mecanique.motion.analysis.audit import Audit, AuditRow
    from mecanique.motion.analysis.energies import Energies
    from mecanique.motion.analysis.trust import Trust
    from mecanique.motion.ensemble.runs import Runs
    from mecanique.motion.ensemble.simulate_many import simulate_many
    from mecanique.motion.inertial import InertialCheck, inertial_check
    from mecanique.motion.linear.equilibria import Equilibrium, equilibria
    from mecanique.motion.linear.linearization import Linearization, Response, frequency_response
    from mecanique.motion.linear.linearize import linearize
    from mecanique.motion.linear.speeds import (
        SpeedMatrices,
        SpeedRange,
        expand_in_speed,
        sweep_speeds,
    )
    from mecanique.motion.linear.steady import SteadyLinearization, linearize_steady
    from mecanique.motion.motion import Motion, simulate
    from mecanique.motion.record.curve import State
    from mecanique.motion.record.events import Event, Occurrence
    from mecanique.motion.record.trajectory import Statistics
    from mecanique.motion.simulation.watching.validity import contact_events

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
    "SpeedMatrices",
    "SpeedRange",
    "State",
    "Statistics",
    "SteadyLinearization",
    "Trust",
    "contact_events",
    "equilibria",
    "expand_in_speed",
    "frequency_response",
    "inertial_check",
    "linearize",
    "linearize_steady",
    "simulate",
    "simulate_many",
    "sweep_speeds",
]

_HOMES = {
    "Audit": ".analysis.audit",
    "AuditRow": ".analysis.audit",
    "Energies": ".analysis.energies",
    "Equilibrium": ".linear.equilibria",
    "Event": ".record.events",
    "InertialCheck": ".inertial",
    "Linearization": ".linear.linearization",
    "Motion": ".motion",
    "Occurrence": ".record.events",
    "Response": ".linear.linearization",
    "Runs": ".ensemble.runs",
    "SpeedMatrices": ".linear.speeds",
    "SpeedRange": ".linear.speeds",
    "State": ".record.curve",
    "Statistics": ".record.trajectory",
    "SteadyLinearization": ".linear.steady",
    "Trust": ".analysis.trust",
    "contact_events": ".simulation.watching.validity",
    "equilibria": ".linear.equilibria",
    "expand_in_speed": ".linear.speeds",
    "frequency_response": ".linear.linearization",
    "inertial_check": ".inertial",
    "linearize": ".linear.linearize",
    "linearize_steady": ".linear.steady",
    "simulate": ".motion",
    "simulate_many": ".ensemble.simulate_many",
    "sweep_speeds": ".linear.speeds",
}
"""The module of each name; each is imported when it is first used."""


def __getattr__(name: str) -> Any:
    return import_name(__name__, name, _HOMES)
