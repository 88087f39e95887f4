"""Every kind of force on one body, by hand."""

from __future__ import annotations

import numpy as np
import pytest
from force_samples import SAMPLES, Sample

from mecanique.reference import Reference


@pytest.mark.parametrize("sample", SAMPLES, ids=lambda sample: sample.mechanism.name)
def test_a_body_accelerates_and_stores_energy_as_by_hand(sample: Sample) -> None:
    reference = Reference(sample.mechanism)
    found = reference.acceleration(sample.q, sample.v, sample.t)
    np.testing.assert_allclose(found, sample.acceleration, rtol=1e-12, atol=1e-13)
    energy = reference.energy(sample.q, sample.v, sample.t).potential
    assert energy == pytest.approx(sample.potential, rel=1e-13)
