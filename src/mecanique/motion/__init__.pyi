"""The names of this room and where they live; `mecanique.lazy` reads this."""

from mecanique.motion.analysis.audit import Audit as Audit, AuditRow as AuditRow
from mecanique.motion.analysis.energies import Energies as Energies
from mecanique.motion.analysis.trust import Trust as Trust
from mecanique.motion.ensemble.simulate_many import Runs as Runs
from mecanique.motion.ensemble.simulate_many import simulate_many as simulate_many
from mecanique.motion.inertial import (
    InertialCheck as InertialCheck,
    inertial_check as inertial_check,
)
from mecanique.motion.linear.equilibria import (
    Equilibrium as Equilibrium,
    equilibria as equilibria,
)
from mecanique.motion.linear.linearization import (
    Linearization as Linearization,
    Response as Response,
    frequency_response as frequency_response,
)
from mecanique.motion.linear.linearize import linearize as linearize
from mecanique.motion.linear.speeds import (
    SpeedMatrices as SpeedMatrices,
    SpeedRange as SpeedRange,
    expand_in_speed as expand_in_speed,
    sweep_speeds as sweep_speeds,
)
from mecanique.motion.linear.steady import (
    SteadyLinearization as SteadyLinearization,
    linearize_steady as linearize_steady,
)
from mecanique.motion.motion import Motion as Motion, simulate as simulate
from mecanique.motion.record.curve import State as State
from mecanique.motion.record.events import Event as Event, Occurrence as Occurrence
from mecanique.motion.trajectory import Statistics as Statistics
from mecanique.motion.switching.holding import contact_events as contact_events
