"""Inverse dynamics of mechanisms with loops, against virtual work."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import cos, sin, sqrt

import numpy as np
import pytest

from mecanique.errors import ClosureError, EngineError, InputError, MecaniqueError
from mecanique.model import JointForce, Mechanism
from mecanique.reference import Reference, assemble
from mecanique.textbook import load
from mecanique.textbook.catalogue import entry

R, L = 0.5, 1.2


def crank(theta: float, force: float = 0.0) -> tuple[Reference, np.ndarray]:
    """A slider-crank whose slider a force pushes outwards, and its position."""
    plain = load("slider_crank", r=R, l=L)
    mechanism: Mechanism = replace(plain, forces=(JointForce("gas", "guide", force),))
    reach = sqrt(L**2 - (R * sin(theta)) ** 2)
    beta = -theta - np.arcsin(R * sin(theta) / L)
    return Reference(mechanism), np.array([theta, beta, R * cos(theta) + reach])


@pytest.mark.parametrize("theta", [0.3, 0.9, 2.0, 4.0])
def test_the_torque_that_holds_a_crank_against_the_piston(theta: float) -> None:
    """T = F r sin θ (1 + r cos θ / √(l² − r² sin² θ)) for a push inwards, plus the weight."""
    reference, q = crank(theta, -300.0)
    ratio = 1 + R * cos(theta) / sqrt(L**2 - (R * sin(theta)) ** 2)
    weight = 2.0 * 9.81 * R * cos(theta) / 2
    held = reference.driving_forces(("O",), q)["O"]
    assert held == pytest.approx(weight - 300.0 * R * sin(theta) * ratio, rel=1e-10)
    assert reference.acceleration(q, tau={"O": float(held)}) == pytest.approx([0, 0, 0], abs=1e-9)
    assert reference.driving_forces("theta", q) == {"theta": held}
    push = reference.driving_forces(["guide"], q)["guide"]
    assert push == pytest.approx(-held / (R * sin(theta) * ratio), rel=1e-9)


@pytest.mark.parametrize("heavy", [1e-9, 1.0, 1e9])
def test_what_drives_can_balance_does_not_depend_on_how_heavy_a_machine_is(heavy: float) -> None:
    plain = load("slider_crank", r=R, l=L, m1=2.0 * heavy, m2=3.0 * heavy)
    reference, (_, q) = Reference(plain), crank(0.9)
    held = reference.driving_forces(("O",), q)["O"]
    assert held == pytest.approx(heavy * 2.0 * 9.81 * R * cos(0.9) / 2, rel=1e-10)
    with pytest.raises(ClosureError, match="cannot produce"):
        reference.driving_forces((), q)


@pytest.mark.parametrize("name", ["slider_crank", "four_bar_linkage", "squeezer"])
def test_driving_forces_make_the_accelerations_that_torques_make(name: str) -> None:
    mechanism = load(name)
    q = assemble(mechanism, entry(name).start)
    reference = Reference(mechanism)
    drive = mechanism.joints[0].name
    allowed = np.linalg.svd(reference.constraint_jacobian(q))[2][-1]
    for torque, speed in ((-2.0, 0.0), (5.0, 0.0), (5.0, 3.0)):
        v = speed * allowed
        a = reference.acceleration(q, v, tau={drive: torque})
        found = reference.driving_forces((drive,), q, v, a)[drive]
        assert found == pytest.approx(torque, rel=1e-7)


def test_the_constraints_hold_their_accelerations() -> None:
    reference, q = crank(0.8)
    names, M = reference.independent_mass_matrix(q)
    J = reference.constraint_jacobian(q)
    assert len(names) == 1
    assert J.shape == (len(reference.constraint_names), 3)
    assert reference.constraint_residual(q) == pytest.approx(np.zeros(len(J)), abs=1e-14)
    v = np.linalg.svd(J)[2][-1]
    a = reference.acceleration(q, v)
    assert J @ a + reference.constraint_bias(q, v) == pytest.approx(np.zeros(len(J)), abs=1e-11)
    at = reference.mechanism.velocities.index(names[0])
    kinetic = reference.energy(q, v).kinetic
    assert M[0, 0] * v[at] ** 2 / 2 == pytest.approx(kinetic, rel=1e-11)
    both = reference.constraint_jacobian(np.array([q, q]))
    assert both.shape == (2, *J.shape)


def test_a_tree_has_no_constraints_and_all_velocities() -> None:
    arm = load("two_link_arm")
    reference = Reference(arm)
    q, v, a = [0.3, 0.4], [0.1, 0.2], [1.0, -2.0]
    both = reference.driving_forces(("shoulder", "elbow"), q, v, a)
    expected = reference.inverse_dynamics(q, v, a)
    assert [both["shoulder"], both["elbow"]] == pytest.approx(expected, rel=1e-12)
    assert reference.constraint_jacobian(q).shape == (0, 2)
    assert reference.independent_mass_matrix(q)[0] == arm.velocities


@pytest.mark.parametrize(
    ("drives", "change", "a", "error", "message"),
    [
        (("O",), 0.1, None, EngineError, "open"),
        (("O",), 0.0, {"theta": 1.0}, ClosureError, "do not allow these accelerations"),
        (("motor",), 0.0, None, InputError, "unknown joint 'motor'"),
        ((), 0.0, None, ClosureError, "cannot produce"),
    ],
)
def test_what_cannot_be_driven_is_refused(
    drives: Sequence[str],
    change: float,
    a: dict[str, float] | None,
    error: type[MecaniqueError],
    message: str,
) -> None:
    reference, q = crank(0.8)
    with pytest.raises(error, match=message):
        reference.driving_forces(drives, q + np.array([0, 0, change]), None, a)
