"""The forces on every body are in equilibrium once d'Alembert's are among them."""

from __future__ import annotations

import numpy as np
import pytest

import mecanique as mq
from mecanique.motion.analysis.forces import Actions
from mecanique.verification.states import random_states

SYSTEMS = mq.textbook.names()


def states(mechanism: mq.Mechanism) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    found = random_states(mechanism, 5, seed=4, lot=8)
    return found.t, found.q, found.v


@pytest.mark.parametrize("name", SYSTEMS)
def test_forces_and_moments_on_each_body_sum_to_zero(name: str) -> None:
    mechanism = mq.textbook.load(name)
    reference = mq.Reference(mechanism)
    t, q, v = states(mechanism)
    a = reference.acceleration(q, v, t)
    acting = Actions(mechanism, reference)
    every = [*acting.applied(t, q, v), *acting.reactions(t, q, v), *acting.inertia(t, q, v, a)]
    # a free body turns without any force: its energy is then the size that moments are compared
    # with
    sizes = [
        float(np.abs(part).max()) for action in every for part in (action.force, action.moment)
    ]
    scale = max(*sizes, float(np.max(reference.energy(q, v, t).kinetic)))
    for body in mechanism.bodies:
        if body.name == mechanism.ground:
            continue
        on_body = [action for action in every if action.body == body.name]
        force = sum(action.force for action in on_body)
        moment = sum(action.moment + np.cross(action.origin, action.force) for action in on_body)
        np.testing.assert_allclose(force, np.zeros((5, 3)), rtol=0, atol=1e-12 * scale)
        np.testing.assert_allclose(moment, np.zeros((5, 3)), rtol=0, atol=1e-12 * scale)


@pytest.mark.parametrize(
    "name", ["two_blocks", "double_pendulum", "bars_and_springs", "shear_building"]
)
def test_what_one_body_does_to_another_is_done_back(name: str) -> None:
    mechanism = mq.textbook.load(name)
    acting = Actions(mechanism, mq.Reference(mechanism))
    t, q, v = states(mechanism)
    every = [*acting.applied(t, q, v), *acting.reactions(t, q, v)]
    between = [action for action in every if action.other is not None]
    assert between
    total = sum(action.force for action in between)
    np.testing.assert_allclose(total, np.zeros((5, 3)), rtol=0, atol=1e-12)
