"""What generated C costs beside Pinocchio: operations, time a state, time to write. By hand.

    python tests/benchmarks/bench_code.py

Both sides compute the same mechanism at the same 256 states; shown are medians of several turns, in
time of the processor. C is compiled by the system's compiler with the
options stated (its loop over states
is in C too). Pinocchio's rnea and aba run in its own loop in C++ on one thread (rneaInParallel,
abaInParallel), as its wheel is built; CasADi evaluates the same program, written for it, in its
virtual machine, over all states in one call; crba has no such loop, so it is called from Python,
and what the same call costs on a model without joints is subtracted. Right-hand sides of closed
mechanisms are compared with `Reference.rhs`, null-space code over Pinocchio in Python. "writing" is
the derivation and the text of one function, "compiling" that text."""

from __future__ import annotations

import platform
from collections.abc import Callable
from dataclasses import replace
from statistics import median
from time import perf_counter, thread_time
from typing import Any

import numpy as np
import pinocchio as pin

import mecanique as mq
from mecanique.generation.build import build_program
from mecanique.generation.compiled import OPTIONS, Compiled, compile_program
from mecanique.generation.program import Program
from mecanique.generation.targets.c import C
from mecanique.generation.targets.python import CasADi
from mecanique.verification.states import random_states

STATES = 256
TURNS, REPEATS = 15, 10


def panda() -> mq.Mechanism:
    """Panda with its fingers locked."""
    robot = mq.read_urdf(mq.robot("panda"), damping=False)
    joints = tuple(
        mq.Fixed(joint.name, joint.parent, joint.child, origin=joint.origin)
        if "finger" in joint.name
        else joint
        for joint in robot.joints
    )
    return replace(robot, joints=joints, coordinates=mq.Coordinates(()))


def robot(name: str) -> mq.Mechanism:
    """A robot of example-robot-data without friction in its joints."""
    return mq.read_urdf(mq.robot(name), damping=False)


def measure(work: Callable[[], object]) -> float:
    """The median time of several turns [s]."""
    times = []
    for _ in range(TURNS):
        start = thread_time()
        for _ in range(REPEATS):
            work()
        times.append((thread_time() - start) / REPEATS)
    return median(times)


def compare(mechanism: mq.Mechanism) -> None:
    """Print a row for each algorithm."""
    text = mq.write_urdf(mechanism)
    model = pin.buildModelFromXML(text)
    data, n = model.createData(), model.nv
    rng = np.random.default_rng(0)
    q, v, a = rng.uniform(-1, 1, (3, STATES, n))
    pool = pin.ModelPool(model, 1)
    columns = [np.asfortranarray(x.T) for x in (q, v, a)]
    out = np.empty((n, STATES), order="F")
    empty = pin.Model()
    nothing, none = empty.createData(), np.zeros(0)

    def call_crba(model: pin.Model, data: pin.Data, q: np.ndarray) -> Callable[[], None]:
        def work() -> None:
            for row in q:
                pin.crba(model, data, row)

        return work

    def crba() -> float:
        idle = call_crba(empty, nothing, np.broadcast_to(none, (STATES, 0)))
        return (measure(call_crba(model, data, q)) - measure(idle)) / STATES

    def rnea() -> float:
        return measure(lambda: pin.rneaInParallel(1, pool, *columns, out)) / STATES

    def aba() -> float:
        return measure(lambda: pin.abaInParallel(1, pool, *columns, out)) / STATES

    order = [list(model.names)[1:].index(j) for j in names_of(mechanism)]
    engines: dict[str, tuple[str, Callable[[], float], Callable[[int], Any]]] = {
        "inverse_dynamics": ("rnea", rnea, lambda k: pin.rnea(model, data, q[k], v[k], a[k])),
        "acceleration": ("aba", aba, lambda k: pin.aba(model, data, q[k], v[k], a[k])),
        "mass_matrix": ("crba", crba, lambda k: pin.crba(model, data, q[k])),
    }
    for what, (name, engine, answer) in engines.items():
        start = perf_counter()
        program = build_program(mq.derive(mechanism), what)
        files = C().files(program, ["measured"])
        written = perf_counter()
        compiled = compile_program(program, files, OPTIONS)
        done = perf_counter()
        given = {"q": q[:, order], "v": v[:, order], "a": a[:, order], "tau": a[:, order]}
        takes = ["t" if kind == "t" else kind for kind in program.answers[0].quantity.takes]
        given = {kind: np.ascontiguousarray(given[kind]) for kind in takes if kind != "t"}
        function = getattr(compiled, what)
        found = function(0.0, **given)
        worst = 0.0
        for k in range(50):
            expected = np.asarray(answer(k))[order]
            if expected.ndim == 2:
                expected = expected[:, order]
            off = np.abs(found[k] - expected).max() / np.abs(expected).max()
            worst = max(worst, float(off))
        ours = measure(bind(compiled, what, given, found)) / STATES
        theirs = engine()
        print(
            f"{mechanism.name:16s} {n:3d} {name:5s} {program.count(what).total:6d} operations  "
            f"C {ours * 1e9:5.0f} ns  Pinocchio {theirs * 1e9:5.0f} ns  "
            f"CasADi {in_casadi(program, what, given) * 1e9:5.0f} ns  "
            f"{theirs / ours:4.1f} times  worst difference {worst:.0e}  "
            f"writing {written - start:.2f} s  compiling {done - written:.2f} s",
            flush=True,
        )


def in_casadi(program: Program, what: str, given: dict[str, np.ndarray]) -> float:
    """The time of a state in CasADi's virtual machine, without that of a call [s]."""
    space: dict[str, Any] = {}
    exec(next(iter(CasADi().files(program, ["measured"]).values())), space)
    function = space[what].map(STATES)
    rows = {**given, "t": np.zeros((STATES, 1)), "p": np.zeros((STATES, len(program.parameters)))}
    buffer, call = function.buffer()
    kept = [np.ascontiguousarray(rows[kind], dtype=float) for kind in function.name_in()]
    out = np.empty(function.nnz_out(0))
    for k, values in enumerate(kept):
        buffer.set_arg(k, values.data)
    buffer.set_res(0, out.data)
    return measure(call) / STATES


def compare_closed(name: str) -> None:
    """Print a row for the right-hand side of a closed mechanism."""
    mechanism = mq.textbook.load(name)
    start = perf_counter()
    program = build_program(mq.derive(mechanism), "rhs", ())
    compiled = compile_program(program, C().files(program, ["measured"]))
    done = perf_counter()
    states = random_states(mechanism, STATES, 0)
    y = np.hstack([states.q, states.v])
    reference = mq.Reference(mechanism).rhs()
    found = compiled.rhs(0.0, y)
    expected = np.array([reference(0.0, row) for row in y])
    off = np.linalg.norm(found - expected, axis=1) / np.linalg.norm(expected, axis=1)
    ours = measure(bind(compiled, "rhs", {"y": y, "tau": np.zeros((STATES, mechanism.nv))}, found))
    theirs = measure(lambda: [reference(0.0, row) for row in y[:32]]) / 32
    print(
        f"{name:24s} rhs {program.count().total:6d} operations  C {ours / STATES * 1e9:5.0f} ns  "
        f"Reference.rhs {theirs * 1e6:5.0f} µs  median difference {np.median(off):.0e}  "
        f"writing and compiling {done - start:.2f} s",
        flush=True,
    )


def bind(
    compiled: Compiled, what: str, given: dict[str, np.ndarray], out: np.ndarray
) -> Callable[[], None]:
    """Return a call of a function's loop in C with all its arguments ready."""
    function = getattr(compiled, what)._many
    time = np.zeros(1)
    takes = [*compiled._answers[what].quantity.takes, "p"]
    rows = {**given, "t": time, "p": np.zeros(1)}
    addresses = [rows[kind].ctypes.data for kind in takes]
    steps = [rows[kind].shape[1] if kind in given else 0 for kind in takes]
    place = out.ctypes.data
    return lambda: function(STATES, *addresses, *steps, place)


def names_of(mechanism: mq.Mechanism) -> list[str]:
    """Joints that move, in the order of the velocities."""
    moved = {velocity: joint.name for joint in mechanism.joints for velocity in joint.velocities}
    return [moved[velocity] for velocity in mechanism.velocities]


if __name__ == "__main__":
    print(
        f"{platform.processor() or platform.machine()}, Python {platform.python_version()}, "
        f"Pinocchio {pin.__version__}, {C().version()}, {' '.join(OPTIONS)}"
    )
    for mechanism in (panda(), robot("ur5_robot"), robot("talos_reduced"), robot("icub_reduced")):
        compare(mechanism)
    for name in ("four_bar_linkage", "slider_crank", "bars_and_springs_loop", "squeezer"):
        compare_closed(name)
