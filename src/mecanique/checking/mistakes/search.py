"""Search for what is wrong in equations of motion, the likeliest first."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from typing import final

import numpy as np

from mecanique.checking.grammar.letters import Letters
from mecanique.checking.judgement.motion import Residual
from mecanique.checking.judgement.truth import Truth
from mecanique.checking.mistakes.hypotheses import Hypotheses
from mecanique.checking.mistakes.repairs import Context, Repair, repairs
from mecanique.checking.mistakes.units import UnitMisfitError, Units
from mecanique.checking.verdict import Cause

__all__ = ["Search"]

_HOLDS = 1e-7
"""An equation holds at other accelerations up to this part of its terms."""

_MOST = 12
"""Causes that are kept for an equation."""


@final
class Search:
    """Looks for mistakes in equations on one mechanism.

    Args:
        truth: the right equations.
        letters: of formulas.
    """

    def __init__(self, truth: Truth, letters: Letters) -> None:
        self._truth = truth
        self._letters = letters

    @cached_property
    def _hypotheses(self) -> Hypotheses:
        return Hypotheses(self._truth, self._truth.sample)

    @cached_property
    def context(self) -> Context:
        """What may have been meant."""
        sample = self._truth.sample
        return Context(
            self._truth.mechanism, self._letters, self.units, sample.letters, sample.count
        )

    @cached_property
    def units(self) -> Units:
        """The units of the letters."""
        return Units(self._truth.mechanism)

    def causes(self, found: Sequence[Residual], text: str) -> tuple[tuple[Cause, ...], ...]:
        """Return the causes of each equation's being wrong; none where it is right.

        Args:
            found: the equations.
            text: what they were read from.
        """
        common = self._explain_all(found)
        several = len(found) > 1
        causes = []
        for number, one in enumerate(found, 1):
            place = number if several else 0
            causes.append(() if one.holds else self._of_equation(one, place, common, text))
        return tuple(causes)

    def mend(self, one: Residual, number: int, text: str) -> tuple[Cause, ...]:
        """Return the single changes that would make a formula of any quantity right.

        Args:
            one: the formula minus its true value.
            number: of the formula among several, 0 for a single one.
            text: what it was read from.
        """
        zero = np.zeros(one.sample.count)
        found = repairs(one.tape, one.values, zero, self.context, text)
        weighed = [
            (repair.weight, Cause(repair.kind, repair.text, repair.part, number))
            for repair in _list_once(found)
            if repair.part
        ]
        return _rank(self._misfits(one, number, text), weighed)

    def has_unit_fault(self, one: Residual, text: str) -> bool:
        """Return whether units do not fit in an equation."""
        return bool(self._misfits(one, 0, text))

    def _misfits(self, one: Residual, number: int, text: str) -> list[Cause]:
        try:
            self.units.check(one.root, text)
        except UnitMisfitError as fault:
            part = " ".join(text[fault.part.start : fault.part.end].split())
            return [Cause("units", fault.text, part, number)]
        return []

    def _of_equation(
        self, one: Residual, number: int, common: Sequence[tuple[float, Cause]], text: str
    ) -> tuple[Cause, ...]:
        misfit = self._misfits(one, number, text)
        weighed = list(common)
        sample = one.sample
        zero = np.zeros(sample.count)
        context = self.context if sample is self._truth.sample else None
        if context is not None:
            mended = repairs(one.tape, one.values, zero, context, text)
            weighed += [
                (repair.weight, Cause(repair.kind, repair.text, repair.part, number))
                for repair in _list_once(mended)
            ]
            weighed += [
                (weight, Cause(kind, sentence, "", number))
                for weight, kind, sentence in self._explaining([one])
            ]
        return _rank(misfit, weighed)

    def _explain_all(self, found: Sequence[Residual]) -> list[tuple[float, Cause]]:
        """Return what explains all equations at once, if several are wrong."""
        wrong = [one for one in found if not one.holds]
        if len(wrong) < 2 or found[0].sample is not self._truth.sample:
            return []
        return [
            (weight - 0.6, Cause(kind, sentence))
            for weight, kind, sentence in self._explaining(found)
        ]

    def _explaining(self, found: Sequence[Residual]) -> Iterator[tuple[float, str, str]]:
        """Yield the hypotheses at whose accelerations equations hold."""
        listed = self._hypotheses.listed
        if not listed:
            return
        explains = np.ones(len(listed), dtype=bool)
        step = self._hypotheses.accelerations - self._truth.sample.a
        for one in found:
            slopes = one.by_acceleration
            with np.errstate(all="ignore"):
                moved = np.einsum("nv,hnv->hn", slopes, step)
                size = one.values.size + np.einsum("nv,hnv->hn", np.abs(slopes), np.abs(step))
                left = np.abs(one.values.whole + moved) / size
            left[:, ~one.finite] = 0.0
            explains &= (left <= _HOLDS).all(axis=1)
        for k in np.flatnonzero(explains):
            hypothesis = listed[k]
            yield hypothesis.weight, hypothesis.kind, hypothesis.sentence


def _list_once(found: Iterable[Repair]) -> list[Repair]:
    return list(dict.fromkeys(found))


def _rank(first: list[Cause], weighed: list[tuple[float, Cause]]) -> tuple[Cause, ...]:
    """Return causes in order of weight, each once; units that do not fit come first."""
    order = sorted(weighed, key=lambda pair: pair[0])
    causes = [cause for _, cause in order]
    return tuple(dict.fromkeys([*first, *causes]))[:_MOST]
