"""Compute the right-hand side of the equations of motion for integrators, fast and unchecked."""

from __future__ import annotations

from collections.abc import Callable
from math import atan2
from typing import TypeAlias

import numpy as np

from mecanique.arrays import Array
from mecanique.model.mechanism import Mechanism
from mecanique.reference.engine.chart import Chart
from mecanique.reference.engine.forces.loads import Loads
from mecanique.reference.engine.load import EngineModel
from mecanique.reference.engine.package import engine_package

Rhs: TypeAlias = Callable[[float, Array], Array]
"""f(t, y) = y', shape (nq + nv,) both."""

_Accelerations: TypeAlias = Callable[[Array, Array, float], Array]


def fast_rhs(
    mechanism: Mechanism,  # the mechanism
    engine: EngineModel,  # the mechanism inside Pinocchio
    chart: Chart,  # its coordinates
    loads: Loads,  # its forces
    *,
    recursive: bool,
    overwriting: bool,
) -> Rhs:
    """Choose the fastest right-hand side that is correct for a mechanism."""
    # The recursion is the articulated-body one (Featherstone, Rigid Body Dynamics Algorithms,
    # 2008, ch. 7). Most integrators keep arrays they receive: without `overwriting` each is new.
    single = chart.single and chart.velocities_are_rates
    bare = recursive and single and not loads.act_on_bodies and not loads.act_in_joints
    if bare:
        if chart.identical:
            rhs = _chain(engine, loads, mechanism.nv)
        else:
            rhs = _linear(engine, chart, loads, mechanism.nv)
        return rhs if overwriting else lambda t, y: rhs(t, y).copy()
    accelerations = (
        _recursive(engine, chart, loads) if recursive else _solve(mechanism, engine, chart, loads)
    )
    nq, size, empty = mechanism.nq, mechanism.nq + mechanism.nv, np.empty
    if chart.velocities_are_rates:

        def simple(t: float, y: Array) -> Array:
            out = empty(size)
            v = y[nq:]
            out[:nq] = v
            out[nq:] = accelerations(y[:nq], v, t)
            return out

        return simple

    def general(t: float, y: Array) -> Array:
        out = empty(size)
        q, v = y[:nq], y[nq:]
        chart.rates(q, v, out[:nq])
        out[nq:] = accelerations(q, v, t)
        return out

    return general


def _chain(engine: EngineModel, loads: Loads, nv: int) -> Rhs:
    """Treat hinges and slides without springs or loads: chains and falling robots."""
    pin = engine_package()

    model, data = engine.by_angles
    aba, none, out = pin.aba, loads.in_joints, np.empty(2 * nv)

    def chain(t: float, y: Array) -> Array:
        v = y[nv:]
        out[:nv] = v
        out[nv:] = aba(model, data, y[:nv], v, none)
        return out

    return chain


def _linear(engine: EngineModel, chart: Chart, loads: Loads, nv: int) -> Rhs:
    """Treat these with joint coordinates r = G q + r0, such as relative to absolute angles."""
    pin = engine_package()

    model, data = engine.by_angles
    aba, none, out = pin.aba, loads.in_joints, np.empty(2 * nv)
    chart.place(np.zeros(nv), 0.0)
    p, rest = chart.p, np.zeros((2, nv))
    for joint in list(engine.model.joints)[1:]:
        at = joint.idx_q
        rest[0, joint.idx_v] = atan2(p[at + 1], p[at]) if joint.nq == 2 else p[at]
    forth, back = chart.G.T.copy(), np.linalg.inv(chart.G).dot

    def linear(t: float, y: Array) -> Array:
        out[:nv] = y[nv:]
        both = y.reshape(2, nv).dot(forth)
        both += rest
        out[nv:] = back(aba(model, data, both[0], both[1], none))
        return out

    return linear


def _recursive(engine: EngineModel, chart: Chart, loads: Loads) -> _Accelerations:
    pin = engine_package()

    aba, move, model, data = pin.aba, pin.forwardKinematics, engine.model, engine.data
    place, p, in_joints, external, update = (
        chart.place,
        chart.p,
        loads.in_joints,
        loads.external.forces,
        loads.update,
    )
    on_bodies, forced = loads.act_on_bodies, loads.act_on_bodies or loads.act_in_joints
    identical = chart.identical
    forth, back = chart.G.dot, np.linalg.inv(chart.G).dot

    def accelerate(q: Array, v: Array, t: float) -> Array:
        values = place(q, t)
        u = v if identical else forth(v)
        if on_bodies:
            move(model, data, p, u)
        if forced:
            update(values, q, u, v, t)
        result: Array = (
            aba(model, data, p, u, in_joints, external)
            if on_bodies
            else aba(model, data, p, u, in_joints)
        )
        return result if identical else back(result)

    return accelerate


def _solve(mechanism: Mechanism, engine: EngineModel, chart: Chart, loads: Loads) -> _Accelerations:
    pin = engine_package()
    from scipy.linalg.lapack import dposv

    crba, rnea, move, model, data = (
        pin.crba,
        pin.rnea,
        pin.forwardKinematics,
        engine.model,
        engine.data,
    )
    place, at, p, in_joints, external = (
        chart.place,
        chart.at,
        chart.p,
        loads.in_joints,
        loads.external.forces,
    )
    on_bodies, forced = loads.act_on_bodies, loads.act_on_bodies or loads.act_in_joints
    # both are overwritten by each call of `at`
    G, gamma = chart.G, chart.gamma
    back = G.T.dot
    unknown: Array = np.full(mechanism.nv, np.nan)
    if not mechanism.nv:
        return lambda q, v, t: unknown

    def solve(q: Array, v: Array, t: float) -> Array:
        values = place(q, t)
        u = at(q, v, t)
        if on_bodies:
            move(model, data, p, u)
        if forced:
            update(values, q, u, v, t)
        # inverse dynamics with external forces is bias minus their generalized forces
        right = back(
            in_joints
            - (
                rnea(model, data, p, u, gamma, external)
                if on_bodies
                else rnea(model, data, p, u, gamma)
            )
        )
        _, result, fault = dposv(back(crba(model, data, p)).dot(G), right)
        return unknown if fault else result

    update = loads.update
    return solve
