"""Two weights on a cord over a rough drum.

Weights m_1 and m_2 hang from the ends of a cord of length l that is wound around a drum that stands
still, over the angle phi with the coefficient of friction mu, under gravity g. The generalized
coordinates x and y are the lengths of the two runs. The heavier weight sinks while its tension is
e^(mu phi) times that of the other.
"""

from numpy import exp, pi

from mecanique import model as mq
from mecanique.textbook import System, facts

m_1 = mq.Parameter("m_1", 3.0, "kg", "mass of the weight that sinks")
m_2 = mq.Parameter("m_2", 1.0, "kg", "mass of the other")
l = mq.Parameter("l", 3.0, "m", "length of the cord beside the drum")
phi = mq.Parameter("phi", 3.141592653589793, "rad", "angle that the cord is wound")
mu = mq.Parameter("mu", 0.2, "1", "coefficient of friction")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

DRUM = 0.1
"""Radius of the drum in pictures; nothing depends on it [m]."""

beside = mq.Placement((2 * DRUM, 0, 0))
drum = mq.Visual(mq.Cylinder(DRUM, 0.1), mq.Placement((DRUM, 0, 0), (pi / 2, 0, 0)))
mechanism = mq.Mechanism(
    name="capstan",
    bodies=(
        mq.Body("ground", mq.massless(drum)),
        mq.Body("left", mq.particle(m_1)),
        mq.Body("right", mq.particle(m_2)),
    ),
    joints=(
        mq.Prismatic("run1", "ground", "left", axis=(0, 0, -1), coordinate="x"),
        mq.Prismatic("run2", "ground", "right", axis=(0, 0, -1), origin=beside, coordinate="y"),
    ),
    parameters=(m_1, m_2, l, phi, mu, g),
    gravity=(0, 0, -g),
    switching=(mq.Capstan("drum", "run1", "run2", length=l, wrap=phi, mu=mu),),
)


def _sinks(s: facts.Values) -> float:
    """The acceleration of the first weight where it sinks."""
    grown = s.m_2 * exp(s.mu * s.phi)
    return float(s.g * (s.m_1 - grown) / (s.m_1 + grown))


def _rises(s: facts.Values) -> float:
    """Its acceleration where it rises."""
    grown = s.m_1 * exp(s.mu * s.phi)
    return float(s.g * (grown - s.m_2) / (grown + s.m_2))


SYSTEM = System(
    title="Two weights on a cord over a rough drum",
    source="Euler, Mém. Acad. Berlin 18 (1769) 265; Meriam & Kraige, Statics, sect. 6/8",
    build=mechanism,
    start={"x": 1.0, "y": 2.0},
    start_velocity={"x": -1.0, "y": 1.0},
    duration=0.8,
    tags=("planar", "friction", "corners"),
    facts=(
        facts.ModeAcceleration(
            "x'' = -y'' = g (m_1 - m_2 e^(mu phi))/(m_1 + m_2 e^(mu phi)) where it sinks",
            ("slips +",),
            lambda s: [_sinks(s), -_sinks(s)],
        ),
        facts.ModeAcceleration(
            "x'' = -y'' = g (m_1 e^(mu phi) - m_2)/(m_1 e^(mu phi) + m_2) where it rises",
            ("slips -",),
            lambda s: [_rises(s), -_rises(s)],
        ),
        facts.Occurs(
            "thrown up at v it turns after v/x'', v^2/(2 x'') higher",
            "drum: slips +",
            lambda s: {"t": 1 / _rises(s), "x": 1 - 1 / (2 * _rises(s))},
        ),
        facts.Occurs(
            "from there it sinks as g (m_1 - m_2 e^(mu phi))/(m_1 + m_2 e^(mu phi)) says",
            "end",
            lambda s: {"x'": _sinks(s) * (s.t - 1 / _rises(s))},
        ),
    ),
)
