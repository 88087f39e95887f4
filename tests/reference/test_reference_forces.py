"""Every kind of force on one body, by hand."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from force_samples import SAMPLES, Sample

import mecanique as mq
from mecanique.reference import Reference

R = mq.distance()


@pytest.mark.parametrize("sample", SAMPLES, ids=lambda sample: sample.mechanism.name)
def test_a_body_accelerates_and_stores_energy_as_by_hand(sample: Sample) -> None:
    reference = Reference(sample.mechanism)
    found = reference.acceleration(sample.q, sample.v, sample.t)
    np.testing.assert_allclose(found, sample.acceleration, rtol=1e-12, atol=1e-13)
    energy = reference.energy(sample.q, sample.v, sample.t)
    assert energy.potential == pytest.approx(sample.potential, rel=1e-13)
    assert energy.total == pytest.approx(energy.kinetic + sample.potential, rel=1e-13)


@pytest.mark.parametrize(
    ("potential", "slope"),
    [
        (2.5 * R**2 + R**4, lambda r: 5 * r + 4 * r**3),
        (4.0 * R - R**2, lambda r: 4 - 2 * r),
        (R**3, lambda r: 3 * r**2),
    ],
)
def test_a_force_by_distance_has_no_direction_where_points_meet_unless_it_is_even(
    potential: Any, slope: Callable[[float], float]
) -> None:
    """m x'' = −V'(x) along a rail; V(r) = V(−r) alone leaves nothing to decide at r = 0."""
    slide = mq.Prismatic("slide", "ground", "block", axis=(0.6, 0.0, 0.8), coordinate="x")
    pull = mq.CentralForce("pull", "ground", (0, 0, 0), "block", (0, 0, 0), potential)
    bodies = mq.Body("ground"), mq.Body("block", mq.particle(2.0))
    reference = mq.Reference(mq.Mechanism("rail", bodies, (slide,), (pull,), gravity=(0, 0, 0)))
    for x in (0.7, -0.7):
        expected = -np.sign(x) * slope(0.7) / 2.0
        assert reference.acceleration([x]) == pytest.approx([expected], rel=1e-13)
    if slope(-0.3) == -slope(0.3):
        assert reference.acceleration([0.0]).tolist() == [0.0]
    else:
        with pytest.raises(mq.EngineError, match=r"^central force 'pull' has no direction"):
            reference.acceleration([0.0])
