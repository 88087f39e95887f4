"""One motion by mecanique and by its peers, side by side in one run, at equal final error. Run by hand.

    python tests/benchmarks/bench_motion.py [system …]

Every engine integrates 10 s (Panda: 1 s) from the same start, at a ladder of tolerances or steps. Of each, the first
level counts whose final error (the largest of all coordinates and velocities, against Taylor series in long doubles,
or dop853 at the least tolerance) is at most 1e-10. These levels then run in turns. Times are medians, without building,
which is listed beside them; ratios are to the first row. Peers that are not installed are left out and named:
pip install mujoco exudyn pydy drake heyoka.
"""

from __future__ import annotations

import platform
import re
import sys
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import ode

import mecanique as mq

ERROR = 1e-10
TURNS = 7
TOLERANCES = (1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 3e-14)


class Case(NamedTuple):
    """A mechanism whose joint angles are its coordinates, and its start from rest."""

    name: str
    mechanism: mq.Mechanism
    q: np.ndarray
    span: float = 10.0


class Level(NamedTuple):
    """An engine at one tolerance or step."""

    engine: str
    level: str
    build: float
    run: Callable[[], np.ndarray]


def chain(n: int) -> mq.Mechanism:
    """Uniform rods m = 1, l = 1, one hanging from the other, by relative angles."""
    m, length, g = mq.Parameter("m", 1.0, "kg"), mq.Parameter("l", 1.0, "m"), mq.Parameter("g", 9.81, "m/s²")
    links = range(1, n + 1)
    return mq.Mechanism(
        name=f"chain{n}",
        bodies=(mq.Body("ground"), *(mq.Body(f"rod{i}", mq.rod(m, length)) for i in links)),
        joints=tuple(
            mq.Revolute(
                f"pin{i}",
                "ground" if i == 1 else f"rod{i - 1}",
                f"rod{i}",
                axis=(0, -1, 0),
                origin=mq.Placement((0, 0, 0 if i == 1 else -length)),
                coordinate=f"q{i}",
            )
            for i in links
        ),
        parameters=(m, length, g),
        gravity=(0, 0, -g),
    )


def cart() -> mq.Mechanism:
    """A cart M = 2 on a rail along x with a hanging rod."""
    M, m, length, g = (mq.Parameter(*p) for p in (("M", 2.0), ("m", 1.0), ("l", 1.0), ("g", 9.81)))
    return mq.Mechanism(
        name="cart_pole",
        bodies=(mq.Body("ground"), mq.Body("cart", mq.particle(M)), mq.Body("rod", mq.rod(m, length))),
        joints=(
            mq.Prismatic("rail", "ground", "cart", axis=(1, 0, 0), coordinate="x"),
            mq.Revolute("pin", "cart", "rod", axis=(0, -1, 0), coordinate="q"),
        ),
        parameters=(M, m, length, g),
        gravity=(0, 0, -g),
    )


def cases() -> Iterator[Case]:
    """The systems of the comparison."""
    yield Case("pendulum", chain(1), np.array([2.0]))
    yield Case("double", chain(2), np.array([0.9, 0.5]))
    yield Case("cart_pole", cart(), np.array([0.0, 2.0]))
    yield Case("five", chain(5), np.array([0.5, 0.1, 0.1, 0.1, 0.1]))
    yield Case("twenty", chain(20), np.full(20, 0.02))
    panda = mq.read_urdf(mq.robot("panda"))
    yield Case("panda", panda, panda.neutral() + 0.1, 1.0)  # it falls in chaos soon after


def mecanique(case: Case) -> Iterator[Level]:
    """The package itself: what method "auto" does when it is called again, and with heyoka."""
    methods = ["dop853"]
    if case.mechanism.nv <= 5:
        methods += ["closed_form", "taylor"] if find_spec("heyoka") else ["closed_form"]
    for method in methods:
        for rtol in TOLERANCES:
            begin = perf_counter()
            mechanism = case.mechanism.replace()
            reference = mq.Reference(mechanism)

            def run(
                mechanism: mq.Mechanism = mechanism,
                reference: Any = reference,
                rtol: float = rtol,
                method: str = method,
            ) -> np.ndarray:
                motion = mq.simulate(
                    mechanism, q=case.q, duration=case.span, rtol=rtol, method=method, samples=2, reference=reference
                )
                return np.concatenate([motion.q[-1], motion.v[-1]])

            mq.simulate(mechanism, q=case.q, duration=1e-3, rtol=rtol, method=method, samples=2, reference=reference)
            build = perf_counter() - begin
            yield Level(f"mecanique {method}", f"{rtol:.0e}", build, run)


def pinocchio(case: Case) -> Iterator[Level]:
    """Pinocchio's aba in SciPy's compiled dop853: the bare combination."""
    import pinocchio as pin

    begin = perf_counter()
    # a hinge without limits has two coordinates in Pinocchio, one with limits has its angle
    limits = '<limit lower="-1e9" upper="1e9" effort="1e9" velocity="1e9"/></joint>'
    text = re.sub(
        r'type="continuous"(.*?)</joint>', rf'type="revolute"\1{limits}', mq.write_urdf(case.mechanism), flags=re.DOTALL
    )
    model = pin.buildModelFromXML(text)
    model.gravity.linear = np.array([case.mechanism.evaluate(g) for g in case.mechanism.gravity])
    if model.nq != case.mechanism.nq:
        return  # joints that follow others are independent in Pinocchio's own reader
    data, tau, nv, aba = model.createData(), np.zeros(model.nv), model.nv, pin.aba
    build = perf_counter() - begin

    def rhs(t: float, y: np.ndarray) -> np.ndarray:
        out: np.ndarray = np.empty(2 * nv)
        out[:nv] = y[nv:]
        out[nv:] = aba(model, data, y[:nv], y[nv:], tau)
        return out

    yield from _dop853("pin.aba + dop853", rhs, case, build)


def sympy(case: Case) -> Iterator[Level]:
    """SymPy's Lagrange's method, its equations as `math` code in SciPy's dop853."""
    if case.mechanism.nv > 2:
        return
    import sympy as sp
    from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

    begin = perf_counter()
    n, t = case.mechanism.nv, dynamicsymbols._t
    q = dynamicsymbols(f"q:{n}")
    qd = [x.diff(t) for x in q]
    L, x, z, angle = sp.Integer(0), sp.Integer(0), sp.Integer(0), sp.Integer(0)
    rods = q
    if case.name == "cart_pole":
        x, rods = q[0], q[1:]
        L = qd[0] ** 2
    g = sp.Float(9.81)
    for k in rods:
        angle = angle + k
        cx, cz = x + sp.sin(angle) / 2, z - sp.cos(angle) / 2
        L += (cx.diff(t) ** 2 + cz.diff(t) ** 2) / 2 + angle.diff(t) ** 2 / 24 - g * cz
        x, z = x + sp.sin(angle), z - sp.cos(angle)
    method = LagrangesMethod(sp.trigsimp(sp.expand(L)), q)
    method.form_lagranges_equations()
    M, f = sp.simplify(method.mass_matrix), sp.simplify(method.forcing)
    names = sp.symbols(f"a:{2 * n}")
    both = {**dict(zip(qd, names[n:], strict=True)), **dict(zip(q, names[:n], strict=True))}
    a = sp.simplify(M.LUsolve(f)).subs(both)
    code = sp.lambdify(names, list(a), modules="math", cse=True)
    build = perf_counter() - begin

    def rhs(t: float, y: np.ndarray) -> list[float]:
        values = y.tolist()
        return [*values[n:], *code(*values)]

    yield from _dop853("sympy math + dop853", rhs, case, build)


def _dop853(name: str, rhs: Callable[[float, np.ndarray], Any], case: Case, build: float) -> Iterator[Level]:
    start = np.concatenate([case.q, np.zeros(len(case.q))])
    for rtol in TOLERANCES:

        def run(rtol: float = rtol) -> np.ndarray:
            solver = ode(rhs).set_integrator("dop853", rtol=rtol, atol=rtol, nsteps=10**6)
            result: np.ndarray = solver.set_initial_value(start, 0.0).integrate(case.span)
            return result

        yield Level(name, f"{rtol:.0e}", build, run)


def pydy(case: Case) -> Iterator[Level]:
    """PyDy's lambdified right-hand side in SciPy's odeint, as its System does."""
    if case.mechanism.nv > 5 or case.name == "cart_pole":
        return
    import sympy as sp
    from pydy.codegen.ode_function_generators import LambdifyODEFunctionGenerator
    from scipy.integrate import odeint
    from sympy.physics.mechanics import KanesMethod, Point, ReferenceFrame, RigidBody, dynamicsymbols, inertia

    begin = perf_counter()
    n = case.mechanism.nv
    q, u = dynamicsymbols(f"q:{n}"), dynamicsymbols(f"u:{n}")
    t, g = dynamicsymbols._t, sp.Symbol("g")
    N, pin = ReferenceFrame("N"), Point("O")
    pin.set_vel(N, 0)
    frame, joint, bodies, loads = N, pin, [], []
    for k in range(n):
        turned = frame.orientnew(f"F{k}", "Axis", (q[k], -N.y))
        turned.set_ang_vel(frame, -u[k] * N.y)
        center = joint.locatenew(f"C{k}", -turned.z / 2)
        center.v2pt_theory(joint, N, turned)
        tip = joint.locatenew(f"P{k}", -turned.z)
        tip.v2pt_theory(joint, N, turned)
        bodies.append(RigidBody(f"B{k}", center, turned, 1.0, (inertia(turned, 0, sp.Rational(1, 12), 0), center)))
        loads.append((center, -g * N.z))
        frame, joint = turned, tip
    kane = KanesMethod(N, q_ind=q, u_ind=u, kd_eqs=[x.diff(t) - y for x, y in zip(q, u, strict=True)])
    kane.kanes_equations(bodies, loads)
    generator = LambdifyODEFunctionGenerator(
        kane.forcing_full, q, u, [g], mass_matrix=kane.mass_matrix_full, linear_sys_solver="numpy"
    )
    rhs = generator.generate()
    build = perf_counter() - begin
    start = np.concatenate([case.q, np.zeros(n)])
    for rtol in TOLERANCES:

        def run(rtol: float = rtol) -> np.ndarray:
            found: np.ndarray = odeint(
                rhs, start, [0.0, case.span], rtol=rtol, atol=rtol, mxstep=10**6, args=({g: 9.81},)
            )
            end: np.ndarray = found[-1]
            return end

        yield Level("PyDy lambdify + odeint", f"{rtol:.0e}", build, run)


def mujoco(case: Case) -> Iterator[Level]:
    """MuJoCo's fixed-step RK4."""
    import mujoco as mj

    if case.name == "panda":
        return
    begin = perf_counter()
    spec = _mjcf(case)
    build0 = perf_counter() - begin
    for step in (1e-3, 5e-4, 2.5e-4, 1.25e-4):
        begin = perf_counter()
        model = mj.MjModel.from_xml_string(spec.format(step=step))
        data = mj.MjData(model)
        build = build0 + perf_counter() - begin
        count = round(case.span / step)

        def run(model: Any = model, data: Any = data, count: int = count) -> np.ndarray:
            mj.mj_resetData(model, data)
            data.qpos[:] = case.q
            mj.mj_step(model, data, count)
            return np.concatenate([data.qpos, data.qvel])

        yield Level("MuJoCo RK4", f"{step:.2e} s", build, run)


def _mjcf(case: Case) -> str:
    """The planar chains in MuJoCo's own format."""
    rods = case.mechanism.nv - (case.name == "cart_pole")
    inertia = f'<inertial pos="0 0 -.5" mass="1" diaginertia="{1 / 12:.17g} {1 / 12:.17g} 1e-9"/>'
    text = ""
    for k in range(rods, 0, -1):
        place = "0 0 0" if k == 1 else "0 0 -1"
        text = f'<body pos="{place}"><joint type="hinge" axis="0 -1 0"/>{inertia}{text}</body>'
    if case.name == "cart_pole":
        cart = '<inertial pos="0 0 0" mass="2" diaginertia="1 1 1"/><joint type="slide" axis="1 0 0"/>'
        text = f"<body>{cart}{text}</body>"
    return (
        '<mujoco><option timestep="{step}" integrator="RK4" gravity="0 0 -9.81"><flag contact="disable"/></option>'
        f"<worldbody>{text}</worldbody></mujoco>"
    )


def exudyn(case: Case) -> Iterator[Level]:
    """Exudyn's kinematic tree with its explicit Runge-Kutta of order 7, at fixed steps."""
    if case.name == "panda":
        return
    import exudyn as exu
    from exudyn import itemInterface

    n = case.mechanism.nv
    for rtol in TOLERANCES:
        begin = perf_counter()
        system = exu.SystemContainer()
        mbs = system.AddSystem()
        rods = n - (case.name == "cart_pole")
        node = mbs.AddNode(
            itemInterface.NodeGenericODE2(
                referenceCoordinates=[0.0] * n,
                initialCoordinates=case.q.tolist(),
                initialCoordinates_t=[0.0] * n,
                numberOfODE2Coordinates=n,
            )
        )
        hinge = exu.JointType.RevoluteY
        types, masses, coms, inertias, places = [], [], exu.Vector3DList(), exu.Matrix3DList(), exu.Vector3DList()
        turns = exu.Matrix3DList()
        if case.name == "cart_pole":
            types.append(exu.JointType.PrismaticX)
            masses.append(2.0)
            coms.Append([0, 0, 0])
            inertias.Append(np.eye(3))
            places.Append([0, 0, 0])
            turns.Append(np.eye(3))
        flip = np.diag([-1.0, -1.0, 1.0])  # turns about −y
        for k in range(rods):
            types.append(hinge)
            masses.append(1.0)
            coms.Append([0, 0, -0.5])
            J = np.diag([1 / 12 + 0.25, 1 / 12 + 0.25, 0.0])
            inertias.Append(J)
            places.Append([0, 0, 0] if k == 0 else [0, 0, -1])
            turns.Append(flip if k == 0 else np.eye(3))
        mbs.AddObject(
            itemInterface.ObjectKinematicTree(
                nodeNumber=node,
                jointTypes=types,
                linkParents=list(range(-1, n - 1)),
                jointTransformations=turns,
                jointOffsets=places,
                linkInertiasCOM=_about_center(inertias, masses, coms),
                linkCOMs=coms,
                linkMasses=masses,
                baseOffset=[0, 0, 0],
                gravity=[0, 0, -9.81],
            )
        )
        mbs.Assemble()
        settings = exu.SimulationSettings()
        settings.timeIntegration.endTime = case.span
        settings.timeIntegration.numberOfSteps = _exudyn_steps(rtol)
        settings.solution.file.write = False
        settings.timeIntegration.verboseMode = 0
        settings.show.statistics = False
        build = perf_counter() - begin
        initial = np.concatenate([case.q, np.zeros(n)])

        def run(mbs: Any = mbs, settings: Any = settings, initial: np.ndarray = initial) -> np.ndarray:
            mbs.systemData.SetODE2Coordinates(initial[:n], exu.ConfigurationType.Initial)
            mbs.systemData.SetODE2Coordinates_t(initial[n:], exu.ConfigurationType.Initial)
            mbs.SolveDynamic(settings, solverType=exu.DynamicSolverType.RK67)
            data = mbs.systemData
            return np.concatenate([data.GetODE2Coordinates(), data.GetODE2Coordinates_t()])

        yield Level("Exudyn RK67", f"{_exudyn_steps(rtol)} steps", build, run)


def _exudyn_steps(rtol: float) -> int:
    """RK67 of Exudyn has fixed steps: a ladder of them."""
    return int(400 * 1.7 ** TOLERANCES.index(rtol))


def _about_center(inertias: Any, masses: list[float], coms: Any) -> Any:
    """Inertias about the centers of mass."""
    import exudyn as exu

    found = exu.Matrix3DList()
    for k, m in enumerate(masses):
        J, c = np.array(inertias[k]), np.array(coms[k])
        found.Append(J - m * (c @ c * np.eye(3) - np.outer(c, c)))
    return found


def drake(case: Case) -> Iterator[Level]:
    """Drake's Runge-Kutta of order 3 with error control."""
    if case.name == "panda":
        return
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.systems.analysis import Simulator

    for accuracy in (1e-8, 1e-10, 1e-12):
        begin = perf_counter()
        plant = MultibodyPlant(0.0)
        Parser(plant).AddModelsFromString(mq.write_urdf(case.mechanism), "urdf")
        plant.mutable_gravity_field().set_gravity_vector([0, 0, -9.81])
        plant.Finalize()
        simulator = Simulator(plant)
        simulator.get_mutable_integrator().set_target_accuracy(accuracy)
        simulator.get_mutable_integrator().set_maximum_step_size(0.1)
        build = perf_counter() - begin

        def run(plant: Any = plant, simulator: Any = simulator) -> np.ndarray:
            context = simulator.get_mutable_context()
            context.SetTime(0.0)
            plant.SetPositions(context, case.q)
            plant.SetVelocities(context, np.zeros(len(case.q)))
            simulator.Initialize()
            simulator.AdvanceTo(case.span)
            return np.concatenate([plant.GetPositions(context), plant.GetVelocities(context)])

        yield Level("Drake RK3", f"{accuracy:.0e}", build, run)


ENGINES: dict[str, tuple[str, Callable[[Case], Iterator[Level]]]] = {
    "mecanique": ("mecanique", mecanique),
    "Pinocchio + SciPy": ("pinocchio", pinocchio),
    "SymPy + SciPy": ("sympy", sympy),
    "PyDy": ("pydy", pydy),
    "MuJoCo": ("mujoco", mujoco),
    "Exudyn": ("exudyn", exudyn),
    "Drake": ("pydrake", drake),
}


def exact(case: Case) -> np.ndarray:
    """The final state, as exactly as it can be had."""
    start = np.concatenate([case.q, np.zeros(len(case.q))])
    if find_spec("heyoka") and case.mechanism.nv <= 5:
        import heyoka

        from mecanique.motion.program import program_of
        from mecanique.motion.taylor import system

        machine = heyoka.taylor_adaptive(
            system(program_of(case.mechanism), heyoka),
            start.astype(np.longdouble),
            fp_type=np.longdouble,
            compact_mode=True,
        )
        machine.propagate_until(np.longdouble(case.span))
        return np.asarray(machine.state, dtype=float)
    solver = ode(mq.Reference(case.mechanism).rhs()).set_integrator("dop853", rtol=1e-15, atol=1e-15, nsteps=10**6)
    result: np.ndarray = solver.set_initial_value(start, 0.0).integrate(case.span)
    return result


def seconds(run: Callable[[], object], repeats: int = 1) -> float:
    """Time of one call, over some calls in a row."""
    begin = perf_counter()
    for _ in range(repeats):
        run()
    return (perf_counter() - begin) / repeats


def main(wanted: list[str]) -> None:
    """Print a table for each system."""
    missing = [title for title, (module, _) in ENGINES.items() if not find_spec(module)]
    print(f"{platform.processor() or platform.machine()}, Python {platform.python_version()}; at error ≤ {ERROR:g}")
    if missing:
        print(f"left out, not installed: {', '.join(missing)}")
    for case in cases():
        if wanted and case.name not in wanted:
            continue
        goal = exact(case)
        print(
            f"\n{case.name}\n{'engine':<26}{'level':>12}{'time [ms]':>12}{'error':>10}{'build [ms]':>12}{'ratio':>10}",
            flush=True,
        )
        best: dict[str, tuple[float, Level]] = {}
        for title, (_, engine) in ENGINES.items():
            if title in missing:
                continue
            try:
                for level in engine(case):
                    if level.engine in best and best[level.engine][0] <= ERROR:
                        continue  # the first level that is accurate enough is the fastest
                    error = float(np.abs(level.run() - goal).max())
                    if error < best.get(level.engine, (np.inf, level))[0]:
                        best[level.engine] = error, level
            except Exception as trouble:  # a peer's failure is told, and must not end the comparison
                print(f"{title:<26}failed: {type(trouble).__name__}: {str(trouble)[:150]}")
        reached = [name for name, (error, _) in best.items() if error <= ERROR]
        once = [seconds(best[name][1].run) for name in reached]
        # what takes a second is measured well enough by one run; short runs are repeated, so that all are warm
        rounds = [
            [
                seconds(best[name][1].run, 1 + int(0.02 / took)) if took < 1 else took
                for name, took in zip(reached, once, strict=True)
            ]
            for _ in range(TURNS)
        ]
        times = np.array(rounds)
        for k, name in enumerate(reached):
            error, level = best[name]
            ratio = np.median(times[:, k] / times[:, 0])
            print(
                f"{name:<26}{level.level:>12}{np.median(times[:, k]) * 1e3:>12.3f}{error:>10.1e}"
                f"{level.build * 1e3:>12.1f}{ratio:>10.3f}",
                flush=True,
            )
        for name, (error, level) in best.items():
            if name not in reached:
                print(f"{name:<26}{level.level:>12}{'not reached':>12}{error:>10.1e}{level.build * 1e3:>12.1f}")


if __name__ == "__main__":
    main(sys.argv[1:])
