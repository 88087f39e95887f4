"""A question as plain data, with which a page judges formulas by itself."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from mecanique.arrays import Array
from mecanique.checking.check import Checker
from mecanique.checking.grammar.tape import FormulaTape
from mecanique.checking.judgement.formula import list_oscillating
from mecanique.checking.judgement.quantities import AskedQuantity, measure
from mecanique.checking.judgement.truth import Sample
from mecanique.errors import InputError
from mecanique.model.mechanism import Mechanism

ASKED = (
    "equation of motion",
    "kinetic energy",
    "potential energy",
    "Lagrangian",
    "frequency",
)
"""What a page can judge by itself."""

_MOST_SLIPS = 120
_DIGITS = 15
"""Digits of the values: a page's verdict depends on differences of 1e-8."""


def describe_question(mechanism: Mechanism, ask: str, seed: int = 0) -> dict[str, Any]:
    """Return the letters of a question, its states, and the values that an answer must have."""
    if ask not in ASKED:
        raise InputError(f"no page judges a {ask} by itself; it can: {', '.join(ASKED)}")
    if mechanism.constrained:
        raise InputError(f"no page judges formulas of {mechanism.name!r} by itself: it has loops")
    checker = Checker(mechanism, seed)
    truth, (letters, quantity) = checker.truth, checker.find_letters(ask)
    sample = truth.sample

    def table(values: Mapping[str, Array], count: int) -> dict[str, list[float]]:
        known = {name: values[name] for name in letters.kinds if name in values}
        for name, node in letters.defined.items():
            known[name] = FormulaTape(node).evaluate(values, count).whole
        return table_of({name: value for name, value in known.items() if name != "pi"})

    asked: dict[str, Any] = {
        "kind": "motion",
        "name": ask,
        "letters": dict(letters.kinds),
        "angles": sorted(letters.angles),
        "parameters": [p.symbol for p in mechanism.parameters],
        "states": table(sample.letters, sample.count),
    }
    if quantity.kind == "motion":
        given, far = truth.with_numbers(frozenset()), truth.stretch(sample)
        positions, M, steps = checker.factors.sample_paths()
        paths = {"letters": table(positions, len(M)), "M": M.tolist(), "steps": steps}
        return asked | {
            "accelerations": list(truth.accelerations),
            "velocities": list(truth.velocities),
            "inertia": np.sqrt(np.diagonal(sample.M, axis1=1, axis2=2)).mean(0).tolist(),
            "numbers": table(given.letters, given.count),
            "far": None if far is None else table(far.letters, far.count),
            "usual": [] if far is None else far.usual.tolist(),
            "paths": paths,
            "slips": list(_list_slips(checker)),
        }
    asked |= {"kind": "value", "names": list(quantity.letters), "left": sorted(quantity.of_loads)}

    def value(quantity: AskedQuantity, sample: Sample) -> dict[str, Any]:
        assert quantity.values is not None
        if quantity.kind == "several":
            known = [measure(omega, quantity.letters) for omega in quantity.values]
            measures = [table_of(_keep_finite(omegas)) for omegas in known]
            oscillating = list_oscillating(quantity)
            return {"kind": "several", "measures": measures, "oscillating": oscillating}
        answer: dict[str, Any] = {"values": _list(quantity.values)}
        if quantity.again is not None:
            values, states = quantity.again
            moved = table({**sample.letters, **states}, sample.count)
            answer["again"] = {"values": _list(values), "states": moved}
        return answer

    fixed = truth.hold(frozenset())
    numbers = value(checker.ask(ask, frozenset()), fixed.sample)
    numbers["states"] = table(fixed.sample.letters, fixed.sample.count)
    return asked | value(quantity, sample) | {"numbers": numbers}


def table_of(values: Mapping[str, Array]) -> dict[str, list[float]]:
    """Return values by letter as lists."""
    return {name: _list(value) for name, value in values.items()}


def _keep_finite(values: Mapping[str, Array]) -> dict[str, Array]:
    """Return values without those at infinity, as the period of what does not oscillate."""
    return {name: value for name, value in values.items() if np.isfinite(value).all()}


def _list_slips(checker: Checker) -> Iterator[dict[str, Any]]:
    """Yield the slips that lead to another motion, the likeliest first, with that motion."""
    for slip, motion in checker.search.list_slips()[:_MOST_SLIPS]:
        motions = list(map(_list, motion.T))
        yield {"kind": slip.kind, "text": slip.mistake().text, "motion": motions}


def _list(values: Array) -> list[float]:
    return [float(f"{x:.{_DIGITS}g}") for x in values]
