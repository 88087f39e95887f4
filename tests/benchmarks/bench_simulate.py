"""What `simulate` costs beside bare Pinocchio's aba in SciPy's dop853. Run by hand.

    python tests/benchmarks/bench_simulate.py

All integrate 10 s at rtol = atol = 1e-10 in one run, in turns, by the processor's time: Pinocchio
bare; the same loop on the right-hand side of `Reference`, which maps coordinates and adds forces
(the double pendulum's angles are absolute, the cart has a damper); `simulate`, which adds 601
samples, dense output and checks; and `simulate` with the reference's construction. Ratios are
medians over the turns, to the bare loop.

Then what a call costs that does not name a reference, which is loaded at the first call, beside one
that does: two rods by Taylor series, from the second call on."""

from __future__ import annotations

import platform
from collections.abc import Callable
from functools import partial
from time import process_time

import numpy as np
import pinocchio as pin
import scipy
from scipy.integrate import ode

import mecanique as mq
from mecanique.model.joints import Prismatic, Revolute

TURNS = 15
RTOL = 1e-10
CASES: tuple[tuple[str, dict[str, float], dict[str, float]], ...] = (
    ("rigid_bar_pendulum", {}, {"q": 2.0}),
    ("double_pendulum", {}, {"q1": 0.9, "q2": 1.4}),
    ("cart_pole", {"c": 0.0}, {"q": 2.0}),
)


def bare(mechanism: mq.Mechanism, start: np.ndarray) -> Callable[[], np.ndarray]:
    """Integrate with the least: joint coordinates, no checks, no samples, no forces."""
    model = pin.Model()
    model.gravity.linear = np.array([mechanism.evaluate(g) for g in mechanism.gravity])
    at = {mechanism.ground: 0}
    for joint in mechanism.tree:
        kinds = {
            Revolute: pin.JointModelRevoluteUnaligned,
            Prismatic: pin.JointModelPrismaticUnaligned,
        }
        assert isinstance(joint, (Revolute, Prismatic))
        origin = np.array([mechanism.evaluate(x) for x in joint.origin.xyz])
        axis = np.array(joint.axis)
        at[joint.child] = model.addJoint(
            at[joint.parent], kinds[type(joint)](axis), pin.SE3(np.eye(3), origin), joint.name
        )
        body = mechanism.body(joint.child)
        ixx, iyy, izz, ixy, ixz, iyz = (mechanism.evaluate(x) for x in body.inertia)
        inertia = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
        center = np.array([mechanism.evaluate(x) for x in body.center])
        model.appendBodyToJoint(
            at[joint.child],
            pin.Inertia(mechanism.evaluate(body.mass), center, inertia),
            pin.SE3.Identity(),
        )
    data, tau, nv, aba = model.createData(), np.zeros(model.nv), model.nv, pin.aba

    def rhs(t: float, y: np.ndarray) -> np.ndarray:
        out: np.ndarray = np.empty(2 * nv)
        out[:nv] = y[nv:]
        out[nv:] = aba(model, data, y[:nv], y[nv:], tau)
        return out

    return loop(rhs, np.concatenate([start, np.zeros(nv)]))


def loop(
    rhs: Callable[[float, np.ndarray], np.ndarray], start: np.ndarray
) -> Callable[[], np.ndarray]:
    """SciPy's compiled integrator on a right-hand side, and nothing else."""

    def run() -> np.ndarray:
        solver = ode(rhs).set_integrator("dop853", rtol=RTOL, atol=RTOL, nsteps=10**6)
        result: np.ndarray = solver.set_initial_value(start, 0.0).integrate(10.0)
        return result

    return run


def seconds(run: Callable[[], object]) -> float:
    """Time of one call."""
    begin = process_time()
    run()
    return process_time() - begin


def simulate_afresh(mechanism: mq.Mechanism, q: np.ndarray) -> mq.Motion:
    """Simulate with a reference that is made for this motion alone."""
    reference = mq.Reference(mechanism)
    return mq.simulate(mechanism, q=q, reference=reference, rtol=RTOL, method="dop853")


def compare_plain() -> None:
    """Print what a call costs that does not name a reference."""
    mechanism = mq.textbook.load("double_pendulum")
    reference = mq.Reference(mechanism)
    call = partial(mq.simulate, mechanism, q={"q1": 2.0}, method="taylor")
    load = min(seconds(partial(mq.Reference, mechanism)) for _ in range(TURNS)) * 1e3
    runs = (partial(call, reference=reference), call)
    for run in runs:
        run()
    # in turns, because a machine's speed changes
    times = np.array([[seconds(run) for run in runs] for _ in range(20 * TURNS)])
    given, plain = times.min(axis=0) * 1e3
    print(f"taylor: {given:.3f} ms with reference=, {plain:.3f} ms without", end=", ")
    print(f"ratio {plain / given:.2f}; a reference takes {load:.2f} ms to load")


def main() -> None:
    """Print the table."""
    versions = f"Python {platform.python_version()}, SciPy {scipy.__version__}"
    versions += f", Pinocchio {pin.__version__}"
    print(f"{platform.machine()}, {versions}")
    titles = ("bare", "reference", "simulate", "with set-up")
    print(
        f"{'system':<20}"
        + "".join(f"{title + ' [ms]':>17}{'ratio':>7}" for title in titles)
        + "  difference"
    )
    for name, parameters, start in CASES:
        mechanism = mq.textbook.load(name, **parameters)
        reference = mq.Reference(mechanism)
        q = mechanism.position(start)
        relative = np.array([q[0], q[1] - q[0]]) if name == "double_pendulum" else q
        runs: tuple[Callable[[], object], ...] = (
            bare(mechanism, relative),
            loop(reference.rhs(), np.concatenate([q, np.zeros(mechanism.nv)])),
            partial(mq.simulate, mechanism, q=q, reference=reference, rtol=RTOL, method="dop853"),
            partial(simulate_afresh, mechanism, q),
        )
        end = runs[1]()
        motion = mq.simulate(mechanism, q=q, reference=reference, rtol=RTOL, method="dop853")
        assert isinstance(end, np.ndarray)
        times = np.array([[seconds(run) for run in runs] for _ in range(TURNS)])
        middle = np.median(times, axis=0) * 1e3
        ratios = np.median(times / times[:, :1], axis=0)
        cells = "".join(
            f"{ms:>17.2f}{ratio:>7.2f}" for ms, ratio in zip(middle, ratios, strict=True)
        )
        print(f"{name:<20}{cells}  {np.abs(motion.q[-1] - end[: mechanism.nq]).max():.1e}")


if __name__ == "__main__":
    main()
    compare_plain()
