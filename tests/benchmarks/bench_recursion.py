"""What the batched recursion costs for N hinges, beside the jets and Pinocchio. By hand.

    python tests/benchmarks/bench_recursion.py

Chains of N rods, each on a hinge about another axis, fixed to the ground. Times are per state, the
least of several turns: the bias and the mass matrix of the recursion for 100 states at once (fewer
where they would fill the memory), of Pinocchio (rnea and crba, one state after the other) up to the
size it is given, and the bias by the jets up to 40 hinges. Exponents are slopes between the last
two sizes, and over all of them."""

from __future__ import annotations

import platform
from collections.abc import Callable
from functools import partial
from time import perf_counter

import numpy as np
import pinocchio as pin

import mecanique as mq
from mecanique.derivation.numeric.lagrange import LagrangeOnJets
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.model.states import States
from mecanique.reference.engine.load import load
from mecanique.urdf.limits import MOST_VELOCITIES

SIZES = (10, 20, 40, 80, 150, 200, 300, 600, 1000)
JETS = 40
STATES = 100
MASS_ENTRIES = 3_000_000
AXES = ((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.6, 0.8))


def chain(n: int) -> mq.Mechanism:
    """A chain of n rods of 0.1 m and 0.1 kg."""
    names = ["ground", *(f"rod{k}" for k in range(1, n + 1))]
    hinges = tuple(
        mq.Revolute(
            f"hinge{k}",
            names[k - 1],
            names[k],
            axis=AXES[k % 3],
            coordinate=f"q{k}",
            origin=mq.Placement((0.0, 0.0, -0.1 if k > 1 else 0.0)),
        )
        for k in range(1, n + 1)
    )
    bodies = (mq.Body("ground"), *(mq.Body(name, mq.rod(0.1, 0.1)) for name in names[1:]))
    return mq.Mechanism("chain", bodies, hinges, gravity=(0.0, 0.0, -9.81))


def least(work: Callable[[], object], turns: int = 3) -> float:
    """The least time of several turns [s]."""
    times = []
    for _ in range(turns):
        start = perf_counter()
        work()
        times.append(perf_counter() - start)
    return min(times)


def states_of(mechanism: mq.Mechanism, count: int) -> States:
    """Random states."""
    q, v = np.random.default_rng(0).uniform(-1, 1, (2, count, mechanism.nv))
    return States.of(mechanism, q, v)


def engine(mechanism: mq.Mechanism) -> tuple[Callable[[], object], Callable[[], object]]:
    """Pinocchio's bias and mass matrix at the random states."""
    model = load(mechanism).model
    data, rest = model.createData(), np.zeros(model.nv)
    q = np.array(
        [
            pin.randomConfiguration(model, -np.ones(model.nq), np.ones(model.nq))
            for _ in range(STATES)
        ]
    )
    v = np.random.default_rng(0).uniform(-1, 1, (STATES, model.nv))
    return (
        lambda: [pin.rnea(model, data, one, rate, rest) for one, rate in zip(q, v, strict=True)],
        lambda: [pin.crba(model, data, one) for one in q],
    )


def slope(times: dict[int, float]) -> str:
    """Growth exponents: between the last two sizes, and over all of them."""
    if len(times) < 2:
        return "-"
    n, t = (np.log(list(x)) for x in (times.keys(), times.values()))
    return (
        f"{(t[-1] - t[-2]) / (n[-1] - n[-2]):.2f} at the end, {np.polyfit(n, t, 1)[0]:.2f} over all"
    )


def main() -> None:
    """Measure and print the table."""
    columns = ("bias", "mass matrix", "bias, jets", "bias, Pinocchio", "mass matrix, Pinocchio")
    found: dict[str, dict[int, float]] = {name: {} for name in columns}
    print(
        f"Python {platform.python_version()}, numpy {np.__version__}, Pinocchio "
        f"{pin.__version__}; µs per state"
    )
    print(f"{'N':>5} " + " ".join(f"{name:>22}" for name in columns), flush=True)
    for n in SIZES:
        mechanism = chain(n)
        recursion, many = Recursion(mechanism), states_of(mechanism, STATES)
        found["bias"][n] = least(partial(recursion.bias, many)) / STATES
        count = max(1, min(STATES, MASS_ENTRIES // n**2))
        some = states_of(mechanism, count)
        found["mass matrix"][n] = least(partial(recursion.mass_matrix, some)) / count
        if n <= JETS:
            few, jets = states_of(mechanism, 10), LagrangeOnJets(mechanism)
            found["bias, jets"][n] = least(partial(jets.bias, few)) / 10
        if n <= MOST_VELOCITIES:
            bias, mass = engine(mechanism)
            found["bias, Pinocchio"][n], found["mass matrix, Pinocchio"][n] = (
                least(bias) / STATES,
                least(mass) / STATES,
            )
        cells = (
            f"{1e6 * found[name][n]:>22.1f}" if n in found[name] else f"{'-':>22}"
            for name in columns
        )
        print(f"{n:>5} {' '.join(cells)}", flush=True)
    for name, times in found.items():
        print(f"{name}: N to the power {slope(times)}")


if __name__ == "__main__":
    main()
