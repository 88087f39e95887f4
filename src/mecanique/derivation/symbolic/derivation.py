"""What a symbolic derivation yields: M a + h = Q as series, how it came about, and what it takes for granted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, final

from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.loops import Tie
from mecanique.derivation.symbolic.springs import Assumption
from mecanique.derivation.symbolic.symbols import Algebra

__all__ = ["Derivation", "Left", "Result", "Stage"]


@final
@dataclass(frozen=True)
class Left:
    """The left-hand side of a result: a quantity, or a derivative of one.

    Args:
        quantity: its letter, e.g. "T".
        by: name of what it is partially differentiated by, if anything, e.g. "q'".
        total: whether the time derivative of that is meant.
        turning: whether the terms of Euler and Kirchhoff, ω × ∂T/∂ω + v × ∂T/∂v, are meant.
        component: whether the quantity's component named by `by` is meant, e.g. Q_x.
    """

    quantity: str
    by: str = ""
    total: bool = False
    turning: bool = False
    component: bool = False


@final
@dataclass(frozen=True)
class Result:
    """One line of a derivation, left = right.

    Args:
        left: what is found; a series where an equation relates two sums.
        right: what it is.
    """

    left: Left | Series
    right: Series


@final
@dataclass(frozen=True)
class Stage:
    """One step of a derivation.

    Args:
        title: its name.
        explanation: why it is taken, in a sentence or two.
        results: what it gives.
    """

    title: str
    explanation: str
    results: tuple[Result, ...] = ()


@final
@dataclass(frozen=True)
class Derivation:
    """Symbolic equations of motion M a + h = Q, with loops M a + h = Q + Σ λ ∂Φ/∂q and Φ = 0.

    Args:
        algebra: the mechanism's symbols.
        M: rows of the mass matrix.
        h: Coriolis, centrifugal and rheonomic inertia terms and gravity.
        Q: generalized forces of springs, dampers, drives and loads.
        stages: how they came about.
        assumptions: what they take for granted.
        lengths: what each root adjoined for springs and dampers is, by its name in print.
        closing: how the equations of motion follow from the last step, in a sentence.
        unknowns: what each reaction or virtual displacement in the steps is, by its name.
        reactions: each reaction that is not identically zero, by its name; empty where the method
            shows none.
        ties: the equations of the loops, with their multipliers.
    """

    algebra: Algebra
    M: tuple[tuple[Series, ...], ...]
    h: tuple[Series, ...]
    Q: tuple[Series, ...]
    stages: tuple[Stage, ...]
    assumptions: tuple[Assumption, ...] = ()
    lengths: Mapping[str, str] = field(default_factory=dict)
    closing: str = ""
    unknowns: Mapping[str, str] = field(default_factory=dict)
    reactions: Mapping[str, Series] = field(default_factory=dict)
    ties: tuple[Tie, ...] = ()

    @property
    def rows(self) -> tuple[Series, ...]:
        """M a + h − Q − Σ λ ∂Φ/∂q, one series for each velocity."""
        algebra = self.algebra
        a: list[Any] = [algebra.ring[name] for name in algebra.accelerations]
        slopes = [(tie.multiplier, algebra.along(tie.demand)) for tie in self.ties]
        terms = [
            [m * x for m, x in zip(row, a, strict=True)]
            + [h, -q]
            + [-multiplier * by[k] for multiplier, by in slopes]
            for k, (row, h, q) in enumerate(zip(self.M, self.h, self.Q, strict=True))
        ]
        return tuple(algebra.ring.sum(parts) for parts in terms)
