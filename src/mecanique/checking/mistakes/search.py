"""Search for mistakes in equations of motion, the likeliest first."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from types import MappingProxyType
from typing import final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.checking.budget import SECONDS, OutOfTimeError, spend, stop_clock
from mecanique.checking.grammar.letters import Letters
from mecanique.checking.grammar.reader import Statement
from mecanique.checking.grammar.tree import Node, rate
from mecanique.checking.grammar.tree import number as zero_node
from mecanique.checking.judgement.motion import Residual, residuals
from mecanique.checking.judgement.quantities import Quantity
from mecanique.checking.judgement.truth import Truth
from mecanique.checking.mistakes.hypotheses import Hypotheses, list_parts
from mecanique.checking.mistakes.of_quantities import QuantityMistakes
from mecanique.checking.mistakes.repairs import ALIKE, Context, Repair, repairs
from mecanique.checking.mistakes.units import UnitMisfitError, Units
from mecanique.checking.verdict import Cause
from mecanique.derivation.printing.equations import expression
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.series import Series
from mecanique.errors import FormulaError
from mecanique.model.units import Dimension

_WORDS = (
    (1.0, "missing", "{} is missing"),
    (2.0, "sign", "the sign of {} is wrong"),
    (-1.0, "factor", "{} is counted twice"),
    (0.5, "factor", "{} is halved"),
)
"""The truth minus the answer as a multiple of a part of the truth, with kind and words."""


def find_lacking(residual: Residual, series: Mapping[str, Series]) -> Iterator[Repair]:
    """Yield parts of the true quantity whose absence or factor explains a formula."""
    named = [name for name in series if name in residual.root.letters]
    if len(named) != 1:
        return
    slope = residual.tape.along(residual.slopes, named[0])
    with np.errstate(all="ignore"):
        lacks = residual.values.whole / slope
    usable = residual.finite & np.isfinite(lacks)
    if not usable.any():
        return
    truth = series[named[0]]
    evaluated = Evaluation(truth.ring, residual.sample.values)
    for part in [*list_parts(truth, residual.truth.velocities), truth]:
        spend()
        own = np.broadcast_to(evaluated(part), lacks.shape)
        for factor, kind, words in _WORDS:
            scale = np.abs(factor * own) + np.abs(lacks)
            if (np.abs(lacks - factor * own) <= ALIKE * scale)[usable].all():
                text = words.format(f"the term {expression(part).text()}")
                yield Repair(kind, text, "", 1.1 if factor == 1.0 else 1.6)


NOTHING: Mapping[str, Node] = MappingProxyType({})
"""No definitions of further letters."""

_HOLDS = 1e-7
"""An equation holds for wrong accelerations if it is off by less than this part of its terms."""

_SEVERAL = -0.6
"""Added to the weight of a hypothesis that explains several equations at once."""

_DENIED = 1.0
"""Added to the weight of a hypothesis that contradicts an equation that is right."""

_MOST = 12
"""Largest number of causes that are kept for an equation."""


@final
class Search:
    """Searches for mistakes in equations about one mechanism."""

    def __init__(self, truth: Truth, letters: Letters) -> None:
        self._truth = truth
        self._letters = letters

    @cached_property
    def _hypotheses(self) -> Hypotheses:
        return Hypotheses(self._truth)

    @cached_property
    def context(self) -> Context:
        """The likely intentions."""
        sample = self._truth.sample
        return Context(
            self._truth.mechanism, self._letters, self.units, sample.letters, sample.count
        )

    @cached_property
    def units(self) -> Units:
        """The units of the letters."""
        return Units(self._truth.mechanism)

    def causes(
        self, residuals: Sequence[Residual], text: str, defined: Mapping[str, Node] = NOTHING
    ) -> tuple[tuple[Cause, ...], ...]:
        """Return the likely causes for each wrong equation; none for a right one."""
        several = len(residuals) > 1
        holds = self._hold(residuals)
        common = self._explain_all(residuals, holds)
        right = np.array([residual.holds for residual in residuals])
        # a hypothesis that contradicts a right equation explains only part of the answer
        denied = _DENIED * ~np.asarray(holds[:, right].all(axis=1))
        causes: list[tuple[Cause, ...]] = []
        for k, residual in enumerate(residuals):
            if residual.holds:
                causes.append(())
                continue
            number = k + 1 if several else 0
            own = [*common, *self._list_likeliest(holds[:, k], denied, number)]
            own += self._mend(residual, number, text)
            causes.append(_rank(_misfits(self.units, residual, number, text, defined), own))
        return tuple(causes)

    def mend(
        self,
        residual: Residual,
        number: int,
        text: str,
        asked: Mapping[str, Dimension],
        series: Mapping[str, Series],
        quantity: Quantity | None = None,
    ) -> tuple[Cause, ...]:
        """Return the single changes that would make a formula of any quantity right."""
        units = Units(self._truth.mechanism, asked)
        zero = np.zeros(residual.sample.count)
        found = repairs(residual.tape, residual.values, zero, self.context, text)
        weighed = [
            (repair.weight, Cause(repair.kind, repair.text, repair.part, number))
            for repair in _list_in_time(found)
            if repair.part or repair is _ENDED
        ]
        weighed += [
            (repair.weight, Cause(repair.kind, repair.text, "", number))
            for repair in _list_in_time(find_lacking(residual, series))
        ]
        if quantity is not None:
            for mistake in self.of_quantities.explain(residual, quantity):
                cause = Cause(mistake.kind, mistake.text, mistake.part, number)
                weighed.append((mistake.weight, cause))
        return _rank(_misfits(units, residual, number, text), weighed)

    @cached_property
    def of_quantities(self) -> QuantityMistakes:
        """The mistakes in quantities other than equations of motion."""
        return QuantityMistakes(self._truth)

    def explain_constant(self, root: Node, number: int, text: str) -> tuple[Cause, ...]:
        """Return the likely causes why a formula is not conserved."""
        listed = [
            (mistake.weight, Cause(mistake.kind, mistake.text, mistake.part, number))
            for mistake in self.of_quantities.explain_constant(root, text)
        ]
        truth = self._truth
        try:
            slope = rate(root, self._letters.rate_nodes)
            line = Statement((slope, zero_node(0)), text, root.start)
            found = residuals([line], truth, truth.sample, text)
            holds = self._hold(found)
            listed += self._list_likeliest(holds[:, 0], np.full(len(holds), 0.4), number)
        except FormulaError:
            pass
        return _rank([], listed)

    def has_unit_fault(self, one: Residual, text: str) -> bool:
        """Return whether the units in an equation do not match."""
        return bool(_misfits(self.units, one, 0, text))

    def _mend(self, residual: Residual, number: int, text: str) -> list[tuple[float, Cause]]:
        """Return the single changes that would make an equation right, with their weights."""
        if residual.sample is not self._truth.sample:
            return []
        zero = np.zeros(residual.sample.count)
        mended = _list_in_time(repairs(residual.tape, residual.values, zero, self.context, text))
        return [
            (found.weight, Cause(found.kind, found.text, found.part, number)) for found in mended
        ]

    def _explain_all(
        self, found: Sequence[Residual], holds: npt.NDArray[np.bool_]
    ) -> list[tuple[float, Cause]]:
        """Return hypotheses that explain all equations at once, if several are wrong."""
        if sum(not one.holds for one in found) < 2:
            return []
        return self._list_likeliest(np.asarray(holds.all(axis=1)), np.full(len(holds), _SEVERAL), 0)

    def _hold(self, residuals: Sequence[Residual]) -> npt.NDArray[np.bool_]:
        """Return whether each equation holds for the accelerations of each hypothesis."""
        known = all(residual.sample is self._truth.sample for residual in residuals)
        if not known or all(residual.holds for residual in residuals):
            return np.zeros((0, len(residuals)), dtype=bool)
        with stop_clock():
            listed = self._hypotheses.listed
        if not listed:
            return np.zeros((0, len(residuals)), dtype=bool)
        step = self._hypotheses.motions - self._truth.sample.motion
        columns = []
        for residual in residuals:
            slopes = residual.by_unknown
            with np.errstate(all="ignore"):
                moved = np.einsum("nv,hnv->hn", slopes, step)
                size = residual.values.size + np.einsum("nv,hnv->hn", np.abs(slopes), np.abs(step))
                left = np.abs(residual.values.whole + moved) / size
            left[:, ~residual.finite] = 0.0
            columns.append((left <= _HOLDS).all(axis=1))
        return np.stack(columns, axis=-1)

    def _list_likeliest(
        self, chosen: npt.NDArray[np.bool_], more: Array, number: int
    ) -> list[tuple[float, Cause]]:
        """Return the likeliest of the hypotheses that are chosen, with their weights."""
        weighed = [
            (self._hypotheses.listed[h].weight + float(more[h]), self._hypotheses.listed[h])
            for h in np.flatnonzero(chosen)
        ]
        weighed.sort(key=lambda pair: pair[0])
        return [
            (weight, Cause(one.kind, one.sentence, "", number)) for weight, one in weighed[:_MOST]
        ]


def _misfits(
    units: Units, residual: Residual, number: int, text: str, defined: Mapping[str, Node] = NOTHING
) -> list[Cause]:
    try:
        units.find(residual.root, text)
    except UnitMisfitError as fault:
        part = " ".join(text[fault.part.start : fault.part.end].split())
        if odd := units.list_odd(defined):
            what = f"the units do not match: the terms that define {', '.join(odd)} differ in units"
            return [Cause("units", what, "", number)]
        own = [units.describe(name, node) for name, node in defined.items() if name in fault.text]
        return [Cause("units", "; ".join([fault.text, *own]), part, number)]
    return []


_ENDED = Repair("time", f"the search for causes ended after {SECONDS:g} s", "", math.inf)


def _list_in_time(found: Iterable[Repair]) -> list[Repair]:
    """Return repairs, each once; those found until the time was over, and that it was."""
    listed: dict[Repair, None] = {}
    try:
        for repair in found:
            listed[repair] = None
    except OutOfTimeError:
        listed[_ENDED] = None
    return list(listed)


def _rank(first: list[Cause], weighed: list[tuple[float, Cause]]) -> tuple[Cause, ...]:
    """Return causes in order of weight, each once; those about units come first."""
    order = sorted(weighed, key=lambda pair: pair[0])
    causes = [cause for _, cause in order]
    return tuple(dict.fromkeys([*first, *causes]))[:_MOST]
