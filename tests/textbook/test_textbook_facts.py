"""Every closed-form fact of every system holds to 1e-10."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mecanique.textbook import entry, names
from mecanique.textbook.facts import (
    Acceleration,
    Conserved,
    Eigenvalues,
    Frequencies,
    KineticEnergy,
    MassMatrix,
    Steady,
)
from mecanique.verification.facts import FactRow, check_facts


def failures(rows: tuple[FactRow, ...]) -> list[str]:
    return [f"{row.statement}: {row.residual:.1e}" for row in rows if not row.holds]


@pytest.mark.parametrize("name", names())
def test_facts_hold_for_other_values(name: str) -> None:
    random = np.random.default_rng(len(name))
    alike = random.uniform(0.9, 1.1)  # of moments of inertia, which no body has in any proportion
    values = {
        p.symbol: p.value * (alike if p.unit == "kg·m²" else random.uniform(0.9, 1.1))
        for p in entry(name).parameters
    }
    rows = check_facts(name, values, seed=1, samples=5)
    assert len(rows) == len(entry(name).facts) >= 2
    assert not failures(rows)


@pytest.mark.parametrize("name", [name for name in names() if entry(name).options])
@pytest.mark.parametrize("n", [1, 2, pytest.param(7, marks=pytest.mark.slow)])
def test_facts_hold_for_any_number_of_links(name: str, n: int) -> None:
    assert not failures(check_facts(name, {"n": n}, samples=5))


@pytest.mark.slow
def test_rounding_of_a_long_chain_is_no_failure() -> None:
    assert not failures(check_facts("n_link_pendulum", {"n": 200}, samples=2))


AT_A_STATE = (Acceleration, MassMatrix, KineticEnergy, Conserved, Frequencies, Eigenvalues, Steady)
"""Kinds of facts that take no integration."""


@pytest.mark.parametrize("name", names())
def test_facts_hold_for_the_equations_derived_in_house(name: str) -> None:
    facts = tuple(fact for fact in entry(name).facts if isinstance(fact, AT_A_STATE))
    assert facts
    assert not failures(check_facts(replace(entry(name), facts=facts), source="derive", samples=3))


def test_the_example_of_the_contributors_guide_is_sound() -> None:
    guide = (Path(__file__).parents[2] / "CONTRIBUTING.md").read_text(encoding="utf-8")
    (example,) = (
        text for text in re.findall(r"```python\n(.*?)```", guide, re.DOTALL) if "SYSTEM" in text
    )
    assert len(example.splitlines()) <= 32
    assert "mecanique gallery examples/pictures --pictures --only block_and_spring" in guide
    names: dict[str, Any] = {}
    exec(compile(example, "CONTRIBUTING.md", "exec"), names)
    rows = check_facts(names["SYSTEM"])
    assert len(rows) == 2
    assert not failures(rows)
