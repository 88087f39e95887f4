"""Loops in any tilt, at any distance from the origin and of any size move alike.

The rank of their constraints must not depend on where they are: rows of mere rounding grow with the
terms that make them, which are as long as the way from the world's origin.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import mecanique as mq
from mecanique.model import Body, Fixed, Loop, Mechanism, Placement, Revolute, rod
from mecanique.model.constraints.loops import CLOSED
from mecanique.reference.loops.assembly import close_velocity, held_columns

Y = (0, -1, 0)
AROUND_Y = (math.pi / 2, 0, 0)
ANGLES = {"phi": 1.0, "theta": -0.8, "psi": 1.6, "chi": -1.4}


def linkage(kind: str, size: float, base: Placement, *, idle: bool) -> Mechanism:
    """Four bars in one plane, closed by a loop of some kind; idle ones repeat what joints hold."""
    a, b, c, d = 0.5 * size, 1.4 * size, 1.2 * size, 1.3 * size
    bodies = [Body("base"), Body("crank", rod(1.0, a, (1, 0, 0)))]
    bodies += [Body("rocker", rod(1.5, c, (1, 0, 0)))]
    joints: list[Any] = [
        Fixed("mount", "ground", "base", origin=base),
        Revolute("A", "base", "crank", axis=Y, coordinate="phi"),
        Revolute("D", "base", "rocker", axis=Y, origin=Placement((d, 0, 0)), coordinate="psi"),
    ]
    tip = Placement((b, 0, 0), AROUND_Y)
    ends = "rocker", Placement((c, 0, 0), AROUND_Y)
    if kind != "distance":
        bodies += [Body("coupler", rod(2.0, b, (1, 0, 0)))]
        end = Placement((a, 0, 0))
        joints += [Revolute("B", "crank", "coupler", axis=Y, origin=end, coordinate="theta")]
    if kind in ("weld", "plate"):
        bodies += [Body("half", rod(1.0, b / 2, (-1, 0, 0)))]
        end, tip = Placement((c, 0, 0)), Placement((b / 2, 0, 0), AROUND_Y)
        joints += [Revolute("E", "rocker", "half", axis=Y, origin=end, coordinate="chi")]
        ends = "half", Placement((-b / 2, 0, 0), AROUND_Y)
    loops = [Loop("C", kind, "coupler", tip, *ends)]  # type: ignore[arg-type]  # parametrized
    if kind == "distance":
        loops = [Loop.distance("C", "crank", (a, 0, 0), "rocker", (c, 0, 0), b)]
    if idle:
        loops += [
            Loop.distance("bar", "base", (0, 0, 0), "crank", (a, 0, 0), a),
            Loop.ball("pivot", "base", (d, 0, 0), "rocker", (0, 0, 0)),
        ]
    return Mechanism(
        "linkage",
        (Body("ground"), *bodies),
        tuple(joints),
        loops=tuple(loops),
        gravity=(0, 0, 0),
    )


def answers(mechanism: Mechanism, size: float) -> tuple[tuple[int, ...], np.ndarray, np.ndarray]:
    """Return ranks; positions and rates; reactions in the base's axes, for lengths of one."""
    guess = {name: ANGLES[name] for name in mechanism.coordinates}
    q = mq.assemble(mechanism, guess, keep=("phi",))
    freedom, reference = mq.degrees_of_freedom(mechanism, q), mq.Reference(mechanism)
    closed = reference.closed
    assert closed is not None
    v = np.array([2.0 * (name == "phi'") for name in mechanism.velocities])
    v = close_velocity(closed, q, v, 0.0, held_columns(mechanism, ("phi",)))
    ranks = (
        freedom.N,
        freedom.rank,
        freedom.rank_here,
        len(freedom.redundant),
        closed.solve(q, v, 0.0).rank,
        len(reference.independent_mass_matrix(q)[0]),
    )
    wrenches = [
        wrench.in_axes("base") for wrench in reference.reactions(q, v).values() if wrench.child
    ]
    pairs = [(wrench.force / size, wrench.moment / size**2) for wrench in wrenches]
    motion = np.concatenate([q, v, reference.acceleration(q, v)])
    return ranks, motion, np.concatenate([part for pair in pairs for part in pair])


@pytest.mark.parametrize(("seed", "count"), [(17, 4), pytest.param(1, 40, marks=pytest.mark.slow)])
@pytest.mark.parametrize("idle", [False, True])
@pytest.mark.parametrize("kind", CLOSED)
def test_tilts_offsets_and_sizes_change_nothing(
    kind: str, idle: bool, seed: int, count: int
) -> None:
    """From 1 mm to 1 km, up to 1 km away, in any direction."""
    random = np.random.default_rng(seed)
    ranks, motion, forces = answers(linkage(kind, 1.0, Placement(), idle=idle), 1.0)
    assert ranks[0] == 1
    assert ranks[4] == ranks[1]
    drawn = 10 ** random.uniform(-3, 3, (count, 2))
    for size, away in [(1e-3, 1e3), (1e-3, 30.0), (1e3, 1e-3), *drawn.tolist()]:
        offset, rpy = away * random.uniform(-1, 1, 3), random.uniform(-3, 3, 3)
        base = Placement(tuple(offset.tolist()), tuple(rpy.tolist()))
        found = answers(linkage(kind, size, base, idle=idle), size)
        # the position of a point is known to ε of its distance from the origin
        allowed = 1e-14 * (20 + float(np.linalg.norm(offset)) / size)
        assert found[0] == ranks
        np.testing.assert_allclose(found[1], motion, rtol=0, atol=allowed * abs(motion).max())
        np.testing.assert_allclose(found[2], forces, rtol=0, atol=allowed * abs(forces).max())
