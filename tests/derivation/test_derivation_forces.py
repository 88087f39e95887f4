"""Every kind of force on one body, by hand."""

from __future__ import annotations

import numpy as np
import pytest
from force_samples import SAMPLES, Sample

from mecanique.derivation import derive
from mecanique.derivation.numeric.lagrange import LagrangeOnJets
from mecanique.derivation.numeric.newton_euler import Balances
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.derivation.numeric.virtual_work import NumericVirtualWork
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.model.states import States

METHODS = ("lagrange", "newton_euler", "virtual_work")


@pytest.mark.parametrize("sample", SAMPLES, ids=lambda sample: sample.mechanism.name)
def test_a_body_accelerates_and_stores_energy_as_by_hand(sample: Sample) -> None:
    states = States.of(sample.mechanism, sample.q[None], sample.v[None], sample.t)
    for method in (LagrangeOnJets, Recursion, Balances, NumericVirtualWork):
        dynamics = method(sample.mechanism)
        found = dynamics.acceleration(states)[0]
        np.testing.assert_allclose(found, sample.acceleration, rtol=1e-11, atol=1e-12)
        assert dynamics.energy(states)[1][0] == pytest.approx(sample.potential, rel=1e-13)
    # of the closed forms one is looked at for each force
    name = METHODS[SAMPLES.index(sample) % len(METHODS)]
    derivation = derive(sample.mechanism, name).derivation
    letters = dict(zip(derivation.algebra.accelerations, sample.acceleration, strict=True))
    value = Evaluation(derivation.algebra.ring, {**states.values, **letters})
    for row in derivation.rows:
        assert value(row) == pytest.approx(0.0, abs=1e-12 * (1 + abs(sample.potential)))
