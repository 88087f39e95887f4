"""The right-hand side of the equations of motion for integrators: nothing is checked, little is allocated."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from mecanique.model.mechanism import Mechanism
from mecanique.reference.answers import Array
from mecanique.reference.chart import Chart
from mecanique.reference.engine import Engine
from mecanique.reference.loads import Loads

__all__ = ["Rhs", "fast_rhs"]

Rhs: TypeAlias = Callable[[float, Array], Array]
"""f(t, y) = y', shape (nq + nv,) both."""

_Accelerations: TypeAlias = Callable[[Array, Array, float], Array]


def fast_rhs(mechanism: Mechanism, engine: Engine, chart: Chart, loads: Loads, *, recursive: bool) -> Rhs:
    """Return the fastest right-hand side that is right for a mechanism.

    Args:
        mechanism: whose motion it is.
        engine: the mechanism inside Pinocchio.
        chart: its coordinates.
        loads: its forces.
        recursive: whether the articulated-body recursion may be used (Featherstone, Rigid Body Dynamics Algorithms,
            2008, ch. 7); otherwise M a = forces − bias is solved.
    """
    accelerations = _recursive(engine, chart, loads) if recursive else _solved(mechanism, engine, chart, loads)
    nq, size, empty = mechanism.nq, mechanism.nq + mechanism.nv, np.empty
    if chart.velocities_are_rates:

        def simple(t: float, y: Array) -> Array:
            # a new array each time: integrators keep what they are given
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


def _recursive(engine: Engine, chart: Chart, loads: Loads) -> _Accelerations:
    import pinocchio as pin

    aba, move, model, data = pin.aba, pin.forwardKinematics, engine.model, engine.data
    place, p, in_joints, external, update = chart.place, chart.p, loads.in_joints, loads.external.forces, loads.update
    if chart.identical and not loads.act_on_bodies and not loads.act_in_joints:

        def bare(q: Array, v: Array, t: float) -> Array:
            place(q, t)
            result: Array = aba(model, data, p, v, in_joints)
            return result

        return bare
    G, back = chart.G, np.linalg.inv(chart.G)
    if loads.act_on_bodies:

        def loaded(q: Array, v: Array, t: float) -> Array:
            values = place(q, t)
            u = G @ v
            move(model, data, p, u)
            update(values, q, u, v, t)
            result: Array = back @ aba(model, data, p, u, in_joints, external)
            return result

        return loaded

    def driven(q: Array, v: Array, t: float) -> Array:
        u = G @ v
        update(place(q, t), q, u, v, t)
        result: Array = back @ aba(model, data, p, u, in_joints)
        return result

    return driven


def _solved(mechanism: Mechanism, engine: Engine, chart: Chart, loads: Loads) -> _Accelerations:
    import pinocchio as pin
    from scipy.linalg.lapack import dposv

    crba, rnea, move, model, data = pin.crba, pin.rnea, pin.forwardKinematics, engine.model, engine.data
    place, at, p, in_joints, external = chart.place, chart.at, chart.p, loads.in_joints, loads.external.forces
    unknown: Array = np.full(mechanism.nv, np.nan)

    def solved(q: Array, v: Array, t: float) -> Array:
        values = place(q, t)
        u = at(q, v, t)
        G = chart.G
        if loads.act_on_bodies:
            move(model, data, p, u)
            loads.update(values, q, u, v, t)
        elif loads.act_in_joints:
            loads.update(values, q, u, v, t)
        mass = G.T @ crba(model, data, p) @ G
        # inverse dynamics with the external forces is bias less what they do
        right = G.T @ (in_joints - rnea(model, data, p, u, chart.gamma, external))
        if not len(right):
            return unknown
        _, result, fault = dposv(mass, right)
        return unknown if fault else result

    return solved
