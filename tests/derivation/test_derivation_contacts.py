"""Rows of contacts on a tape: their rates are derivatives of the gap and of the slip."""

from __future__ import annotations

import numpy as np
import pytest
from rolling_samples import ALL

from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.loops import loops_of
from mecanique.derivation.mechanics.recursion import recursion_on_tape
from mecanique.model import Mechanism
from mecanique.program.evaluation import evaluate
from mecanique.program.traced import values_of

STATES = 4


@pytest.mark.parametrize("mechanism", ALL.values(), ids=ALL)
def test_rates_of_gaps_and_slips_are_their_derivatives_off_the_contact(
    mechanism: Mechanism,
) -> None:
    """Φ' = ψ = A v − b and ψ' = A a + γ, wherever the bodies are and however they slip."""
    letters = Letters(mechanism)
    rows = loops_of(letters, recursion_on_tape(letters)).velocity_rows
    gaps = [row for row in rows if row.name.endswith(": normal")]
    drifts = values_of(row.slip for row in rows)
    pairs = [
        ([row.slip for row in gaps], letters.along([row.gap for row in gaps])),
        ([row.rate for row in rows], letters.along([row.slip for row in rows])),
    ]
    random = np.random.default_rng(3)
    q = mechanism.normalize(random.uniform(-0.7, 0.7, (STATES, mechanism.nq)))
    v = random.normal(size=(STATES, mechanism.nv))
    names = (*mechanism.coordinates, *mechanism.velocities)
    given = {
        "t": random.uniform(0, 1, STATES),
        **dict(zip(names, np.hstack([q, v]).T, strict=True)),
    }
    for found, expected in pairs:
        answers = evaluate(letters.tape, values_of([*found, *expected]), given, STATES)
        ours, exact = np.split(answers, 2, axis=1)
        np.testing.assert_allclose(ours, exact, rtol=1e-11, atol=1e-12)
    # ψ is linear in v, with the slopes A
    slips = evaluate(letters.tape, drifts, given, STATES)
    still = {**given, **dict.fromkeys(mechanism.velocities, np.zeros(STATES))}
    slopes = [value for row in rows for value in values_of(row.slopes)]
    A = evaluate(letters.tape, slopes, given, STATES).reshape(STATES, len(rows), -1)
    rest = evaluate(letters.tape, drifts, still, STATES)
    np.testing.assert_allclose(slips - rest, (A @ v[..., None])[..., 0], rtol=1e-11, atol=1e-12)
