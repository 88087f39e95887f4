"""Why two sources differ: single changes of the mechanism, ranked by what they explain."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from mecanique.arrays import Array, spread
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States
from mecanique.verification.causes.evidence import Evidence, Hypothesis
from mecanique.verification.causes.joints import (
    frame_changes,
    gravity_changes,
    joint_changes,
    map_changes,
    placement_changes,
    state_changes,
)
from mecanique.verification.causes.links import fit_inertias, link_changes
from mecanique.verification.verdict import REMOVED, LikelyCause

_SAME = 1.2
"""Changes whose differences are within this factor of the least one explain equally well."""

_REMOVED = 1e-4
"""A change that leaves less than this part of the difference explains it."""

_ROUNDED = 1e-12
"""A change that leaves less than this leaves nothing but rounding."""

_WORTH = 0.5
"""Changes that leave more than this part of the difference are not reported."""

_STARTS = 6
"""Places where a search for two mistakes begins."""

_FEW = 2
"""Places where it begins in mechanisms with more than `_SMALL` velocities, to save time."""

_SMALL = 12
_HINT = 0.95
"""Where every single change leaves more than this part of the difference, no pair is looked for."""

_TURNS = 8
_HALFWAY = 0.5
"""After two turns, that search goes on if at most this part of the difference is left."""

_MOST = 5
_MOST_VALUES = 30_000
"""About how many forces are predicted for each change."""


_MOST_MOMENTS = 1_000_000
"""About how many effects of links on forces are looked at together."""

_EVIDENCE = 10.0
"""Changes whose Bayesian information is this much worse than the best are no rivals."""


def causes_of(
    mechanism: Mechanism, states: States, theirs: Mapping[str, Array]
) -> tuple[LikelyCause, ...]:
    """Return the likely causes of a difference, the likeliest first."""
    most = int(np.clip(_MOST_VALUES // (4 * max(mechanism.nv, 1) ** 2), 4, 12))
    if "inverse dynamics" in theirs and len(theirs) == 1:
        # samples may be noisy: all count that can be held in memory
        places = mechanism.nv * len(mechanism.bodies)
        most = max(40, _MOST_MOMENTS // max(places, 1))
    at = spread(len(states), most)
    evidence = Evidence.of(
        mechanism, states.at(at), {name: values[at] for name, values in theirs.items()}
    )
    if evidence is None or not REMOVED / 10 < evidence.before < np.inf:
        return ()
    changes = _changes(evidence)
    causes = _rank(evidence, changes)
    limit = _limit(evidence.before, 0.0)
    if evidence.is_measured:
        return causes
    if causes and causes[0].after <= limit:
        if causes[0].after <= _ROUNDED:
            return causes
        limit = _REMOVED * causes[0].after  # a small mistake may stand beside a large one
    pair = _find_pair(evidence, changes, limit)
    # beside two mistakes that remove the difference, no single one is worth reporting
    return causes if pair is None else (pair,)


def _changes(evidence: Evidence) -> list[Hypothesis]:
    known = (
        gravity_changes,
        state_changes,
        map_changes,
        joint_changes,
        link_changes,
        frame_changes,
    )
    with np.errstate(all="ignore"):
        changes = [change for maker in known for change in maker(evidence)]
        plain = [change.answers for change in changes if not change.free]
        # beside a known mistake that explains everything, no fitted number is worth its time
        if not plain or evidence.residual(np.array(plain)).min() > _limit(evidence.before, 0.0):
            changes += [*fit_inertias(evidence), *placement_changes(evidence)]
        return changes


def _limit(before: float, least: float) -> float:
    """The difference up to which changes explain as well as the one that leaves least."""
    return max(min(REMOVED, _REMOVED * before), _SAME * least)


def _rank(evidence: Evidence, changes: list[Hypothesis]) -> tuple[LikelyCause, ...]:
    before = evidence.before
    after = np.array([float(evidence.residual(change.answers)) for change in changes])
    if evidence.is_measured:
        return _rank_samples(evidence, changes, after)
    worth = np.flatnonzero(after <= _WORTH * before).tolist()
    if not worth:
        return ()
    bound = _limit(before, float(after[worth].min()))
    # what explains equally well is ordered by how few numbers had to be chosen, by how plain these
    # are, then as listed; of one mistake in one place, only what chooses fewest
    good = (k for k in worth if after[k] <= bound)
    order = sorted(good, key=lambda k: (changes[k].free, changes[k].amount, k))
    equal = list(_first_of_a_kind(changes, order))
    rest = sorted((k for k in worth if after[k] > bound), key=lambda k: float(after[k]))
    by_text = {changes[k].text: k for k in reversed([*equal, *rest])}
    causes = [_cause(evidence, changes[k], after[k]) for k in reversed(by_text.values())]
    if causes[0].removes:
        # beside a change that removes the difference, only others that do so are worth reporting
        others = (cause for cause in causes[1:] if cause.removes and cause.kind != "other inertia")
        causes = [causes[0], *others]
    return _with_twins(causes, [cause for cause in causes[1:] if cause.after <= bound])


def _cause(evidence: Evidence, change: Hypothesis, after: float) -> LikelyCause:
    return LikelyCause(change.kind, change.where, change.text, evidence.before, float(after))


def _with_twins(causes: list[LikelyCause], twins: list[LikelyCause]) -> tuple[LikelyCause, ...]:
    """Return the likeliest causes, the first with those that explain as much."""
    alike = tuple(twin for twin in twins if twin.kind != "other inertia")
    return (replace(causes[0], alike=alike), *causes[1:_MOST])


def _find_pair(evidence: Evidence, changes: list[Hypothesis], limit: float) -> LikelyCause | None:
    """Two changes in different places that explain everything together."""
    # each is fitted in turn beside the other; together they converge, as their effects are nearly
    # independent
    known = _in_places(changes)
    after = np.array([float(evidence.residual(change.answers)) for change in known])
    order = [k for k in np.argsort(after, kind="stable") if after[k] < _HINT * evidence.before]
    starts = {known[k].where: known[k] for k in reversed(order)}
    most = _STARTS if evidence.mechanism.nv <= _SMALL else _FEW
    places = list(dict.fromkeys(known[k].where for k in order))[:most]
    for place in places:
        pair = _alternate(evidence, starts[place], limit)
        if pair:
            return pair
    return None


def _alternate(evidence: Evidence, first: Hypothesis, limit: float) -> LikelyCause | None:
    """Fit a second change beside the first, then the first beside the second, and so on."""
    this, cause, worst = first, None, _HALFWAY * evidence.before
    for turn in range(_TURNS):
        left = evidence.after(this.answers - evidence.base, this.tree, this.slopes)
        changes = [
            change
            for change in _in_places(_changes(left))
            if change.where != this.where and change.kind != "other inertia"
        ]
        causes = _rank(left, changes)
        if not causes:
            return None
        second = next(c for c in changes if c.text == causes[0].text)
        size = left.misfit(second.answers)
        if size <= limit and cause is not None:
            return _join(evidence, cause, causes[0], size)
        if turn and size > worst:
            return None
        worst, cause = size if turn else worst, causes[0]
        this = replace(second, answers=evidence.base + second.answers - left.base)
    return None


def _in_places(changes: list[Hypothesis]) -> list[Hypothesis]:
    """Changes in one place; of the same in two forms, the one that changes the tree: it lasts."""
    built = {change.text for change in changes if any(change.tree)}
    return [
        change
        for change in changes
        if change.where and (any(change.tree) or change.text not in built)
    ]


def _join(evidence: Evidence, first: LikelyCause, second: LikelyCause, left: float) -> LikelyCause:
    """Two causes as one."""
    parts = tuple(sorted((first, second), key=lambda cause: cause.where))
    text = ", and ".join(_with_alike(part) for part in parts)
    return LikelyCause("two mistakes", "", text, evidence.before, left, parts=parts)


def _with_alike(part: LikelyCause) -> str:
    """A cause with what it cannot be told apart from."""
    places = list(dict.fromkeys(twin.where for twin in part.alike if twin.where != part.where))
    return f"{part.text} (or the like of {', '.join(places)})" if places else part.text


def _first_of_a_kind(changes: list[Hypothesis], order: list[int]) -> Iterator[int]:
    """The first change of each kind and place, in some order."""
    seen = set()
    for k in order:
        key = changes[k].kind, changes[k].where
        if key not in seen:
            seen.add(key)
            yield k


def _rank_samples(
    evidence: Evidence, changes: list[Hypothesis], after: Array
) -> tuple[LikelyCause, ...]:
    """Causes by Bayesian information (G. Schwarz, Annals of Statistics 6 (1978) 461)."""
    # samples have noise, so that no change removes the difference
    before, count = evidence.before, evidence.tau.size
    floor = _limit(before, 0.0)
    sizes = np.array([change.free for change in changes])
    # of several ways to make a slip, each is as much less likely beforehand
    ways = np.array([change.amount.ways for change in changes])
    score = count * np.log(after**2 + floor**2) + sizes * np.log(count) + 2 * np.log(ways)
    without = 2 * count * np.log(before)
    worth: list[int] = np.flatnonzero(score < without - _EVIDENCE).tolist()
    order = sorted(worth, key=lambda k: (score[k], sizes[k], k))
    order = list(_first_of_a_kind(changes, order))
    if not order:
        return ()
    causes = [_cause(evidence, changes[k], after[k]) for k in order]
    limit = score[order[0]] + _EVIDENCE
    ranked = zip(order[1:], causes[1:], strict=True)
    return _with_twins(causes, [cause for k, cause in ranked if score[k] <= limit])
