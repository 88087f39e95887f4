"""Why two sources differ: single changes of the mechanism, ranked by what they explain."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from mecanique.arrays import Array
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States
from mecanique.verification.causes.cause import REMOVED, Cause
from mecanique.verification.causes.change import Change
from mecanique.verification.causes.coordinates import map_changes, state_changes
from mecanique.verification.causes.evidence import Evidence
from mecanique.verification.causes.frames import frame_changes
from mecanique.verification.causes.joints import gravity_changes, joint_changes
from mecanique.verification.causes.links import link_changes

__all__ = ["causes_of"]

_SAME = 1.2
"""Changes whose differences are within this factor of the least one explain equally well."""

_WORTH = 0.5
"""Changes that leave more than this part of the difference are not reported."""

_MOST = 5
_MOST_VALUES = 30_000
"""About how many forces are predicted for each change."""


def causes_of(
    mechanism: Mechanism, states: States, theirs: Mapping[str, Array]
) -> tuple[Cause, ...]:
    """Return the likely causes of a difference, the likeliest first.

    Args:
        mechanism: our side.
        states: where the other side was evaluated.
        theirs: what it gave, by quantity.
    """
    most = int(np.clip(_MOST_VALUES // (4 * max(mechanism.nv, 1) ** 2), 4, 12))
    if "inverse dynamics" in theirs and len(theirs) == 1:
        most = 40
    at = np.arange(min(most, len(states)))
    evidence = Evidence.of(
        mechanism, states.at(at), {name: values[at] for name, values in theirs.items()}
    )
    if evidence is None or not REMOVED / 10 < evidence.before < np.inf:
        return ()
    return _rank(evidence, _changes(evidence))


def _changes(evidence: Evidence) -> list[Change]:
    makers = (
        gravity_changes,
        state_changes,
        map_changes,
        joint_changes,
        link_changes,
        frame_changes,
    )
    with np.errstate(all="ignore"):
        return [change for maker in makers for change in maker(evidence)]


def _rank(evidence: Evidence, changes: list[Change]) -> tuple[Cause, ...]:
    before = evidence.before
    after = np.array([float(evidence.residual(change.answers)) for change in changes])
    worth = np.flatnonzero(after <= _WORTH * before)
    if not len(worth):
        return ()
    bound = max(REMOVED, _SAME * float(after[worth].min()))
    # what explains equally well is ordered by how few numbers had to be chosen, then as listed
    equal = sorted((k for k in worth if after[k] <= bound), key=lambda k: (changes[k].free, k))
    rest = sorted((k for k in worth if after[k] > bound), key=lambda k: float(after[k]))
    found = {
        changes[k].text: Cause(
            changes[k].kind, changes[k].where, changes[k].text, before, float(after[k])
        )
        for k in reversed([*equal, *rest])
    }
    causes = list(reversed(found.values()))
    if causes[0].removes:
        # beside a change that removes the difference, only others that do so are worth reporting
        others = (cause for cause in causes[1:] if cause.removes and cause.kind != "other inertia")
        causes = [causes[0], *others]
    twins = [
        cause for cause in causes[1:] if cause.after <= bound and cause.kind != "other inertia"
    ]
    return (replace(causes[0], alike=tuple(twins)), *causes[1:_MOST])
