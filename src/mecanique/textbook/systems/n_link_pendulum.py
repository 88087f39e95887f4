"""Pendulum of n links.

n equal particles m hang one below the other by massless rods of length l from a fixed pin and swing
in one vertical plane under gravity g. The generalized coordinates q1 … qn are the angles of the
rods from the downward vertical, positive towards +x; each joint turns by the difference of two of
them.
"""

import numpy as np

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

m = mq.Parameter("m", 1.0, "kg", "mass of each particle")
l = mq.Parameter("l", 0.5, "m", "length of each rod")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")


def build(n: int) -> mq.Mechanism:
    """Return the pendulum of n links."""
    links = range(1, n + 1)
    return mq.Mechanism(
        name="n_link_pendulum",
        bodies=(
            mq.Body("ground"),
            *(mq.Body(f"link{i}", mq.bar(l), mq.particle(m, (0, 0, -l))) for i in links),
        ),
        joints=(
            hinge("pin1", "ground", "link1", "q1"),
            *(
                hinge(f"pin{i}", f"link{i - 1}", f"link{i}", f"theta{i}", at=(0, 0, -l))
                for i in links[1:]
            ),
        ),
        coordinates=mq.Coordinates(
            tuple(f"q{i}" for i in links),
            {f"theta{i}": mq.coordinate(f"q{i}") - mq.coordinate(f"q{i - 1}") for i in links[1:]},
        ),
        parameters=(m, l, g),
        gravity=(0, 0, -g),
    )


def angles(s: facts.Values) -> tuple[facts.Number, facts.Number]:
    """Return q and q', shape (n,) each."""
    links = range(1, s.n + 1)
    return np.array([s[f"q{i}"] for i in links]), np.array([s[f"q{i}'"] for i in links])


def count_carried(s: facts.Values) -> facts.Number:
    """Return how many particles rods i and j both carry, n + 1 - max(i, j), shape (n, n)."""
    i = np.arange(1, s.n + 1)
    return s.n + 1 - np.maximum.outer(i, i)


def mass_matrix(s: facts.Values) -> facts.Number:
    """Return M, entry by entry m l² (n + 1 - max(i, j)) cos(qi - qj)."""
    q, _ = angles(s)
    return s.m * s.l**2 * count_carried(s) * np.cos(np.subtract.outer(q, q))


def acceleration(s: facts.Values) -> facts.Number:
    """Return the accelerations q'', from the equations of motion of all rods.

    M q'' + m l² Σ_j (n + 1 - max(i, j)) sin(qi - qj) qj'² + (n + 1 - i) m g l sin(qi) = 0.
    """
    q, v = angles(s)
    turning = s.m * s.l**2 * (count_carried(s) * np.sin(np.subtract.outer(q, q))) @ v**2
    return np.linalg.solve(
        mass_matrix(s), -turning - s.m * s.g * s.l * np.diag(count_carried(s)) * np.sin(q)
    )


def energy(s: facts.Values) -> facts.Number:
    """Return T + V, with V zero where all particles are at the height of the pin."""
    q, v = angles(s)
    return v @ mass_matrix(s) @ v / 2 - s.m * s.g * s.l * np.diag(count_carried(s)) @ np.cos(q)


def frequencies(s: facts.Values) -> facts.Number:
    """Return the roots of Laguerre's polynomial, as frequencies."""
    from scipy.special import roots_laguerre

    return np.sqrt(s.g / s.l * roots_laguerre(s.n)[0])


SYSTEM = System(
    title="Particles hanging one from another by n massless rods",
    source="D. Bernoulli, 1738; Gantmacher & Krein, Oscillation Matrices, ch. III; Goldstein, "
    "ch. 1, ex. 22 (n = 2)",
    options={"n": 4},
    build=build,
    start={"q1": 2.0},
    tags=("pendulum", "planar", "chain", "chaos"),
    facts=(
        facts.MassMatrix("M_ij = m l² (n + 1 - max(i, j)) cos(qi - qj)", mass_matrix),
        facts.Acceleration(
            "Σ_j M_ij qj'' + m l² (n + 1 - max(i, j)) sin(qi - qj) qj'² "
            "= -(n + 1 - i) m g l sin(qi)",
            acceleration,
        ),
        facts.Frequencies(
            "ω² = g x / l for the n roots x of Laguerre's polynomial L_n", frequencies
        ),
        facts.Conserved("the energy v·M v / 2 - m g l Σ (n + 1 - i) cos(qi)", energy),
    ),
    forms={
        "l q1'' + l q2'' + l q3'' + l q4'' + g q4 = 0": (
            "Gantmacher & Krein, ch. III: y4'' = -g (y4 - y3)/l of the lowest particle, y the sum "
            "of l q"
        ),
    },
)
