"""Other engines, each at a ladder of tolerances or steps, from loose to tight."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from time import process_time
from typing import Any, NamedTuple

import numpy as np
from motion_systems import Case
from scipy.integrate import ode, odeint

import mecanique as mq

__all__ = ["PEERS", "SCIPY", "TOLERANCES", "Level"]

TOLERANCES = tuple(10.0**-k for k in np.arange(9.0, 13.6, 0.5))

STEPS = tuple(2e-3 * 0.75**k for k in range(15))
"""Of MuJoCo's method of order 4 [s]."""


class Level(NamedTuple):
    """An engine at one tolerance or step."""

    engine: str
    level: str
    build: float
    run: Callable[[], np.ndarray]


def pinocchio(case: Case) -> Iterator[Level]:
    """Pinocchio's aba in SciPy's compiled integrators: the bare combination."""
    import pinocchio as pin

    begin = process_time()
    # a hinge without limits has two coordinates in Pinocchio, one with limits has its angle
    limits = '<limit lower="-1e9" upper="1e9" effort="1e9" velocity="1e9"/></joint>'
    text = re.sub(
        r'type="continuous"(.*?)</joint>',
        rf'type="revolute"\1{limits}',
        mq.write_urdf(case.mechanism),
        flags=re.DOTALL,
    )
    model = pin.buildModelFromXML(text)
    model.gravity.linear = np.array([case.mechanism.evaluate(g) for g in case.mechanism.gravity])
    if model.nq != case.mechanism.nq:
        return  # joints that follow others are independent in Pinocchio's own reader
    data, tau, nv, aba = model.createData(), np.zeros(model.nv), model.nv, pin.aba
    build = process_time() - begin

    def rhs(t: float, y: np.ndarray) -> np.ndarray:
        out: np.ndarray = np.empty(2 * nv)
        out[:nv] = y[nv:]
        out[nv:] = aba(model, data, y[:nv], y[nv:], tau)
        return out

    yield from _scipy("pin.aba", rhs, case, build)


def sympy(case: Case) -> Iterator[Level]:
    """SymPy's Lagrange's method as `math` code in SciPy's integrators; five rods take it hours."""
    if case.mechanism.nv > 2:
        return
    import sympy as sp
    from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

    begin = process_time()
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
    build = process_time() - begin

    def rhs(t: float, y: np.ndarray) -> list[float]:
        values = y.tolist()
        return [*values[n:], *code(*values)]

    yield from _scipy("sympy math", rhs, case, build)


def _scipy(
    name: str, rhs: Callable[[float, np.ndarray], Any], case: Case, build: float
) -> Iterator[Level]:
    for rtol in TOLERANCES:

        def explicit(rtol: float = rtol) -> np.ndarray:
            solver = ode(rhs).set_integrator("dop853", rtol=rtol, atol=rtol, nsteps=10**6)
            result: np.ndarray = solver.set_initial_value(case.start, 0.0).integrate(case.span)
            return result

        yield Level(f"{name} + dop853", f"{rtol:.0e}", build, explicit)
    for rtol in TOLERANCES:

        def multistep(rtol: float = rtol) -> np.ndarray:
            found = odeint(
                rhs, case.start, [0.0, case.span], rtol=rtol, atol=rtol, mxstep=10**6, tfirst=True
            )
            return np.asarray(found[-1])

        yield Level(f"{name} + odeint", f"{rtol:.0e}", build, multistep)


def pydy(case: Case) -> Iterator[Level]:
    """PyDy's lambdified right-hand side in SciPy's odeint, as its System does."""
    if case.mechanism.nv > 5:
        return
    import sympy as sp
    from pydy.codegen.ode_function_generators import LambdifyODEFunctionGenerator
    from sympy.physics.mechanics import (
        KanesMethod,
        Particle,
        Point,
        ReferenceFrame,
        RigidBody,
        dynamicsymbols,
        inertia,
    )

    begin = process_time()
    n = case.mechanism.nv
    q, u = dynamicsymbols(f"q:{n}"), dynamicsymbols(f"u:{n}")
    t, g = dynamicsymbols._t, sp.Symbol("g")
    N, pin = ReferenceFrame("N"), Point("O")
    pin.set_vel(N, 0)
    frame, joint, bodies, loads = N, pin, [], []
    first = n - case.rods
    if first:
        joint = pin.locatenew("P", q[0] * N.x)
        joint.set_vel(N, u[0] * N.x)
        bodies.append(Particle("cart", joint, 2.0))
    for k in range(first, n):
        turned = frame.orientnew(f"F{k}", "Axis", (q[k], -N.y))
        turned.set_ang_vel(frame, -u[k] * N.y)
        center = joint.locatenew(f"C{k}", -turned.z / 2)
        center.v2pt_theory(joint, N, turned)
        tip = joint.locatenew(f"P{k}", -turned.z)
        tip.v2pt_theory(joint, N, turned)
        bodies.append(
            RigidBody(
                f"B{k}", center, turned, 1.0, (inertia(turned, 0, sp.Rational(1, 12), 0), center)
            )
        )
        loads.append((center, -g * N.z))
        frame, joint = turned, tip
    kane = KanesMethod(
        N, q_ind=q, u_ind=u, kd_eqs=[x.diff(t) - y for x, y in zip(q, u, strict=True)]
    )
    kane.kanes_equations(bodies, loads)
    generator = LambdifyODEFunctionGenerator(
        kane.forcing_full, q, u, [g], mass_matrix=kane.mass_matrix_full, linear_sys_solver="numpy"
    )
    rhs = generator.generate()
    build = process_time() - begin
    for rtol in TOLERANCES:

        def run(rtol: float = rtol) -> np.ndarray:
            found = odeint(
                rhs,
                case.start,
                [0.0, case.span],
                rtol=rtol,
                atol=rtol,
                mxstep=10**6,
                args=({g: 9.81},),
            )
            return np.asarray(found[-1])

        yield Level("PyDy lambdify + odeint", f"{rtol:.0e}", build, run)


def mujoco(case: Case) -> Iterator[Level]:
    """MuJoCo's fixed-step RK4."""
    import mujoco as mj

    begin = process_time()
    spec = bare_urdf(case) if case.name == "panda" else _mjcf(case)
    build0 = process_time() - begin
    for step in STEPS:
        begin = process_time()
        model = mj.MjModel.from_xml_string(spec)
        data = mj.MjData(model)
        model.opt.integrator = mj.mjtIntegrator.mjINT_RK4
        model.opt.disableflags |= mj.mjtDisableBit.mjDSBL_CONTACT | mj.mjtDisableBit.mjDSBL_LIMIT
        build = build0 + process_time() - begin
        count = round(case.span / step)
        model.opt.timestep = case.span / count

        def run(model: Any = model, data: Any = data, count: int = count) -> np.ndarray:
            mj.mj_resetData(model, data)
            data.qpos[:] = case.q
            mj.mj_step(model, data, count)
            return np.concatenate([data.qpos, data.qvel])

        yield Level("MuJoCo RK4", f"{step:.2e} s", build, run)


def bare_urdf(case: Case) -> str:
    """The mechanism's URDF without shapes to be seen or touched."""
    return re.sub(
        r"<(visual|collision)\b.*?</\1>", "", mq.write_urdf(case.mechanism), flags=re.DOTALL
    )


def _mjcf(case: Case) -> str:
    """The planar chains in MuJoCo's own format."""
    inertia = f'<inertial pos="0 0 -.5" mass="1" diaginertia="{1 / 12:.17g} {1 / 12:.17g} 1e-9"/>'
    text = ""
    for k in range(case.rods, 0, -1):
        place = "0 0 0" if k == 1 else "0 0 -1"
        text = f'<body pos="{place}"><joint type="hinge" axis="0 -1 0"/>{inertia}{text}</body>'
    if case.name == "cart_pole":
        cart = (
            '<inertial pos="0 0 0" mass="2" diaginertia="1 1 1"/><joint type="slide" axis="1 0 0"/>'
        )
        text = f"<body>{cart}{text}</body>"
    return f'<mujoco><option gravity="0 0 -9.81"/><worldbody>{text}</worldbody></mujoco>'


def exudyn(case: Case) -> Iterator[Level]:
    """Exudyn's kinematic tree with its explicit Runge-Kutta of order 7, at fixed steps."""
    if case.name == "panda":
        return
    import exudyn as exu
    from exudyn import itemInterface

    n = case.mechanism.nv
    for steps in (int(500 * 1.25**k) for k in range(14)):
        begin = process_time()
        system = exu.SystemContainer()
        mbs = system.AddSystem()
        node = mbs.AddNode(
            itemInterface.NodeGenericODE2(
                referenceCoordinates=[0.0] * n,
                initialCoordinates=case.q.tolist(),
                initialCoordinates_t=[0.0] * n,
                numberOfODE2Coordinates=n,
            )
        )
        hinge = exu.JointType.RevoluteY
        types, masses, coms, inertias, places = (
            [],
            [],
            exu.Vector3DList(),
            exu.Matrix3DList(),
            exu.Vector3DList(),
        )
        turns = exu.Matrix3DList()
        if case.name == "cart_pole":
            types.append(exu.JointType.PrismaticX)
            masses.append(2.0)
            coms.Append([0, 0, 0])
            inertias.Append(np.eye(3))
            places.Append([0, 0, 0])
            turns.Append(np.eye(3))
        flip = np.diag([-1.0, -1.0, 1.0])  # turns about −y
        for k in range(case.rods):
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
        settings.timeIntegration.numberOfSteps = steps
        settings.solution.file.write = False
        settings.timeIntegration.verboseMode = 0
        settings.show.statistics = False
        build = process_time() - begin
        initial = np.concatenate([case.q, np.zeros(n)])

        def run(
            mbs: Any = mbs, settings: Any = settings, initial: np.ndarray = initial
        ) -> np.ndarray:
            mbs.systemData.SetODE2Coordinates(initial[:n], exu.ConfigurationType.Initial)
            mbs.systemData.SetODE2Coordinates_t(initial[n:], exu.ConfigurationType.Initial)
            mbs.SolveDynamic(settings, solverType=exu.DynamicSolverType.RK67)
            data = mbs.systemData
            return np.concatenate([data.GetODE2Coordinates(), data.GetODE2Coordinates_t()])

        yield Level("Exudyn RK67", f"{steps} steps", build, run)


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
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.systems.analysis import Simulator

    for accuracy in (1e-9, 1e-11, 1e-12):
        begin = process_time()
        plant = MultibodyPlant(0.0)
        Parser(plant).AddModelsFromString(bare_urdf(case), "urdf")
        plant.mutable_gravity_field().set_gravity_vector([0, 0, -9.81])
        plant.Finalize()
        simulator = Simulator(plant)
        simulator.get_mutable_integrator().set_target_accuracy(accuracy)
        simulator.get_mutable_integrator().set_maximum_step_size(0.1)
        build = process_time() - begin

        def run(plant: Any = plant, simulator: Any = simulator) -> np.ndarray:
            context = simulator.get_mutable_context()
            context.SetTime(0.0)
            plant.SetPositions(context, case.q)
            plant.SetVelocities(context, np.zeros(len(case.q)))
            simulator.Initialize()
            simulator.AdvanceTo(case.span)
            return np.concatenate([plant.GetPositions(context), plant.GetVelocities(context)])

        yield Level("Drake RK3", f"{accuracy:.0e}", build, run)


SCIPY: dict[str, tuple[str, Callable[[Case], Iterator[Level]]]] = {
    "Pinocchio + SciPy": ("pinocchio", pinocchio),
    "SymPy + SciPy": ("sympy", sympy),
}
"""What is always installed, put together by hand: the module that must be there, and the levels."""

PEERS: dict[str, tuple[str, Callable[[Case], Iterator[Level]]]] = {
    "PyDy": ("pydy", pydy),
    "MuJoCo": ("mujoco", mujoco),
    "Exudyn": ("exudyn", exudyn),
    "Drake": ("pydrake", drake),
}
"""Other engines."""
