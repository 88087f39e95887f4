"""Mistakes about Lagrange's operator: parts of it left out."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from mecanique.arrays import Array
from mecanique.checking.mistakes.slips.hypothesis import (
    Hypothesis,
    RightEquations,
    group_by_velocities,
)
from mecanique.derivation.scalars.series import Series


def mistake_operator(right: RightEquations) -> Iterator[Hypothesis]:
    """Yield equations without parts of Lagrange's operator: d/dt of the inertia, or ∂T/∂q."""
    derivation = right.derivation
    ring = derivation.algebra.ring
    names = derivation.algebra.velocities
    if any(not name.endswith("'") for name in names):
        return
    v = [ring[name] for name in names]
    M, rest = right.sample.M, right.rest
    rows = []
    for k, entries in enumerate(derivation.M):
        terms = [entry.ddt() * rate for entry, rate in zip(entries, v, strict=True)]
        rows.append((k, ring.sum(terms)))
    changing = np.stack([right.value(series) for _, series in rows], axis=-1)
    squares = _collect_quadratic(right, derivation.h, names)
    slopes = changing - squares
    text = "a rate is treated as constant: d/dt of the momentum lacks {}"
    for k, series in rows:
        if series:
            less = rest.copy()
            less[:, k] -= changing[:, k]
            yield Hypothesis(
                kind="rate constant", text=text, weight=1.4, M=M, rest=less, row=k, term=series
            )
            less = rest.copy()
            less[:, k] += slopes[:, k]
            what = f"the term −∂T/∂{names[k][:-1]} is missing (centripetal)"
            yield Hypothesis(kind="missing", text=what, weight=1.3, M=M, rest=less, row=k)
    what = "all terms with squares and products of velocities are missing"
    yield Hypothesis("missing", what, 1.2, M, rest - squares)
    what = "every rate is treated as constant in d/dt of the momenta"
    yield Hypothesis("rate constant", what, 1.3, M, rest - changing)
    what = "the terms −∂T/∂q are missing (centripetal)"
    yield Hypothesis("missing", what, 1.3, M, rest + slopes)


def _collect_quadratic(right: RightEquations, h: Sequence[Series], names: Sequence[str]) -> Array:
    """Return the terms of second degree in the velocities, shape (n, nv)."""
    found = []
    for series in h:
        groups = group_by_velocities(series, names)
        squares = [part for powers, part in groups.items() if sum(powers) == 2]
        found.append(right.value(series.ring.sum(squares)))
    return np.stack(found, axis=-1)
