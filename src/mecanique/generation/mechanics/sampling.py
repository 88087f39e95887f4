"""Evaluate a program in some states, to find entries that are always zero or dependent."""

from __future__ import annotations

from typing import Any

import numpy as np

from mecanique.generation.mechanics.letters import Letters
from mecanique.model.states import States
from mecanique.program.evaluation import evaluate
from mecanique.program.traced import value_of


def sample(letters: Letters, tables: list[Any], states: States) -> list[np.ndarray]:
    """Return tables of scalars at a few states, each shape (states, rows, columns).

    Args:
        letters: the inputs.
        tables: rows of scalars.
        states: the states.
    """
    inputs = inputs_at(letters, states)
    found = []
    for table in tables:
        values = [value_of(entry) for row in table for entry in row]
        numbers = evaluate(letters.tape, values, inputs, len(states))
        found.append(numbers.reshape(len(states), len(table), -1))
    return found


def inputs_at(letters: Letters, states: States) -> dict[str, Any]:
    """Return the value of every input of a program in some states, by name.

    Args:
        letters: the inputs.
        states: coordinates, velocities and times.
    """
    values = states.values
    return {
        "t": states.t,
        **{name: values[name] for name in letters.mechanism.coordinates},
        **{name: values[name] for name in letters.mechanism.velocities},
        **{symbol: values[symbol] for symbol in letters.open},
        **{f"tau {name}": 0.0 for name in letters.mechanism.velocities},
        **{
            f"a {name}": a for name, a in zip(letters.mechanism.velocities, states.a.T, strict=True)
        },
    }
