"""Where joints stand and along what they move, with a few numbers fitted."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import final

import numpy as np

from mecanique.arrays import Array
from mecanique.model.placement import rotation
from mecanique.verification.causes.change import Change
from mecanique.verification.causes.descent import descend
from mecanique.verification.causes.evidence import Evidence
from mecanique.verification.causes.fitted import Amount, give_all, say_turn, turn_about
from mecanique.verification.causes.frames import Frames, answers_of, with_axis

_CLOSER = 3
"""Joints that get a closer look, of each way to change one."""

_MOST = 12
"""Ways to change a joint that are followed to the end."""

_SMALL = 1e-5
_PART = 64
"""Joints evaluated at once."""


@final
@dataclass(frozen=True, eq=False)
class _Family:
    """Ways to place a joint that differ in a few numbers.

    Args:
        name: of the way, alike for all joints.
        numbers: how many.
        make: the frames of some numbers, with their text.
        amount: how plain they are.
    """

    name: str
    numbers: int
    make: Callable[[Array], Frames]
    amount: Callable[[Array], Amount]


def placement_changes(evidence: Evidence) -> Iterator[Change]:
    """Joints moved, turned and with tilted axes by amounts that fit."""
    rows = np.arange(len(evidence.inputs))
    weighted = evidence.weigh(evidence.base - evidence.tau)

    def residuals(trials: list[Frames]) -> Array:
        parts = [
            answers_of(evidence, trials[k : k + _PART], rows) for k in range(0, len(trials), _PART)
        ]
        flat = evidence.weigh(np.concatenate(parts) - evidence.tau)
        return np.nan_to_num(flat, nan=1e9, posinf=1e9, neginf=-1e9)

    families = [one for k in range(len(evidence.recursion.tree)) for one in _families(evidence, k)]
    if not families:
        return
    kept = _choose(evidence, families, residuals, weighted)
    if not kept:  # no placement changes anything, e.g. because nothing but noise is left
        return
    unknowns, costs = descend(
        lambda trials: residuals([kept[k].make(x) for k, x in trials]),
        [np.zeros(family.numbers) for family in kept],
        _MOST,
    )
    found = [family.make(x) for family, x in zip(kept, unknowns, strict=True)]
    good = [k for k in range(len(kept)) if costs[k] < evidence.before]
    for k in good:
        family, x, frames = kept[k], unknowns[k], found[k]
        near = [family.make(x + _SMALL * unit) for unit in np.eye(family.numbers)]
        answers, *others = answers_of(evidence, [frames, *near], rows)
        yield Change(
            kind=frames.kind,
            where=frames.where,
            text=frames.text,
            answers=answers,
            free=family.numbers,
            amount=family.amount(x),
            origins=frames.origins,
            turns=frames.turns,
            slopes=(np.array(others) - answers) / _SMALL,
        )


def _choose(
    evidence: Evidence,
    families: list[_Family],
    residuals: Callable[[list[Frames]], Array],
    off: Array,
) -> list[_Family]:
    """The joints, of each way, whose small changes explain most."""
    units = [family.make(_SMALL * unit) for family in families for unit in np.eye(family.numbers)]
    slopes = iter(_slopes(evidence, units, residuals, off))
    gains = []
    for family in families:
        columns = np.array([next(slopes) for _ in range(family.numbers)])
        used = columns[np.linalg.norm(columns, axis=1) > 1e-9]
        left = off
        if len(used):
            left = off - used.T @ np.linalg.lstsq(used.T, off, rcond=1e-9)[0]
        gains.append(float(np.linalg.norm(left)) if len(used) else np.inf)
    kept = []
    for name in dict.fromkeys(family.name for family in families):
        places = [k for k, family in enumerate(families) if family.name == name]
        places = [k for k in places if gains[k] < np.inf]
        kept += sorted(places, key=lambda k: gains[k])[:_CLOSER]
    return [families[k] for k in sorted(kept)]


def _slopes(
    evidence: Evidence, units: list[Frames], residuals: Callable[[list[Frames]], Array], off: Array
) -> Array:
    """Derivatives of the residuals by small changes, shape (changes, N).

    A change of one frame is the sum of its shifts and turns, which are evaluated once.
    """
    origins = evidence.recursion.origins
    trials: list[Frames] = []
    places: dict[int, int] = {}
    for unit in units:
        if not unit.turns:
            (k,) = unit.origins
            if k not in places:
                places[k] = len(trials)
                trials += [
                    _both(k, origins[k], "", _SMALL * both[:3], _SMALL * both[3:])
                    for both in np.eye(6)
                ]
    tilts = [unit for unit in units if unit.turns]
    slopes = (residuals(trials + tilts) - off) / _SMALL
    of_tilts = iter(slopes[len(trials) :])
    found = []
    for unit in units:
        if unit.turns:
            found.append(next(of_tilts))
            continue
        ((k, other),) = unit.origins.items()
        shift = (other - origins[k])[:3, 3]
        spin = origins[k][:3, :3].T @ other[:3, :3]
        turn = np.array([spin[2, 1], spin[0, 2], spin[1, 0]])
        at = places[k]
        found.append(np.concatenate([shift, turn]) @ slopes[at : at + 6] / _SMALL)
    return np.array(found)


def _families(evidence: Evidence, k: int) -> Iterator[_Family]:
    if evidence.recursion.tree[k].kind != "free":
        joint = _Joint(evidence, k)
        yield from joint.move()
        yield from joint.turn()
        yield from joint.tilt()
        yield joint.place_anew()


@final
class _Joint:
    """A joint where it stands, and the ways to place it otherwise.

    Args:
        evidence: what is to be explained.
        k: its number in the tree.
    """

    def __init__(self, evidence: Evidence, k: int) -> None:
        self._evidence, self._k = evidence, k
        self._link = evidence.recursion.tree[k]
        self._where = f"joint {self._link.joint!r}"
        self._size = _size(evidence)
        self._X = evidence.recursion.origins[k]
        self._p, self._R = self._X[:3, 3], self._X[:3, :3]
        self._far = float(np.linalg.norm(self._p))
        self._rpy = np.array(evidence.mechanism.evaluate_all(self._link.origin.rpy))

    def move(self) -> Iterator[_Family]:
        """Yield the ways to move its origin."""
        p, size = self._p, self._size
        for axis, name in zip(np.eye(3), "xyz", strict=True):
            yield self._shift_along(axis, name)
        if np.count_nonzero(p) > 1:
            yield _Family(
                "longer",
                1,
                lambda x: self._place_at(
                    p * (1 + x[0]), f"position of {self._where} times {1 + x[0]:.6g}"
                ),
                lambda x: Amount.of(1 + x[0], 1.0, ways=3),
            )
        yield _Family(
            "shift",
            3,
            lambda x: self._place_at(
                p + size * x, f"origin of {self._where} moved by ({give_all(size * x)}) m"
            ),
            lambda x: Amount.of_all(size * x, self._far),
        )

    def turn(self) -> Iterator[_Family]:
        """Yield the ways to turn it."""
        for at, name in enumerate(("roll", "pitch", "yaw")):
            yield self._change_angle(at, name)
        yield from map(self._spin_about, range(3))
        yield _Family(
            "turn",
            3,
            lambda x: self._face(self._R @ turn_about(x), f"{self._where} turned by {say_turn(x)}"),
            lambda x: Amount.of_all(np.degrees(x), 180.0),
        )

    def tilt(self) -> Iterator[_Family]:
        """Yield the way to tilt its axis, if it has one."""
        if self._link.kind not in ("turn", "slide"):
            return
        own = np.array(self._link.axis)
        aside = np.linalg.svd(own[None])[2][1:]

        def make(x: Array) -> Frames:
            axis = turn_about(x @ aside) @ own
            text = f"axis of {self._where} along ({give_all(axis)})"
            return with_axis(self._evidence, self._k, axis, text)

        yield _Family("tilt", 2, make, lambda x: Amount.of_all(np.degrees(x), 180.0))

    def place_anew(self) -> _Family:
        """Return the way to move and turn it at once."""
        size = self._size
        return _Family(
            "place",
            6,
            lambda x: _both(self._k, self._X, self._where, size * x[:3], x[3:]),
            lambda x: Amount.of_all(size * x[:3], self._far),
        )

    def _shift_along(self, axis: Array, name: str) -> _Family:
        size, before = self._size, float(self._p @ axis)
        return _Family(
            f"shift {name}",
            1,
            lambda x: self._place_at(
                self._p + size * x[0] * axis,
                f"origin of {self._where} moved by {size * x[0]:.6g} m along {name}",
            ),
            lambda x: Amount.of(before + size * x[0], before, self._far, ways=3),
        )

    def _change_angle(self, at: int, name: str) -> _Family:
        before = self._rpy[at]

        def make(x: Array) -> Frames:
            roll, pitch, yaw = angles = self._rpy + x[0] * np.eye(3)[at]
            said = f"{angles[at]:.6g} rad instead of {before:.6g} rad"
            R = np.array(rotation((roll, pitch, yaw)), dtype=float)
            return self._face(R, f"{name} of {self._where}: {said}")

        def amount(x: Array) -> Amount:
            radians, degrees = (
                Amount.of(unit * (before + x[0]), unit * before, unit * np.pi, ways=3)
                for unit in (1.0, np.degrees(1.0))
            )
            return min(radians, degrees)

        return _Family(name, 1, make, amount)

    def _spin_about(self, at: int) -> _Family:
        name = "xyz"[at]
        return _Family(
            f"turn {name}",
            1,
            lambda x: self._face(
                self._R @ turn_about(x[0] * np.eye(3)[at]),
                f"{self._where} turned by {np.degrees(x[0]):.6g}° about its {name}",
            ),
            lambda x: Amount.of(np.degrees(x[0]), beside=180.0, ways=3),
        )

    def _place_at(self, p: Array, text: str) -> Frames:
        other = self._X.copy()
        other[:3, 3] = p
        return Frames("joint origin", self._where, text, {self._k: other})

    def _face(self, R: Array, text: str) -> Frames:
        other = self._X.copy()
        other[:3, :3] = R
        return Frames("joint turn", self._where, text, {self._k: other})


def _both(k: int, X: Array, where: str, shift: Array, turn: Array) -> Frames:
    other = X.copy()
    other[:3, 3] += shift
    other[:3, :3] = X[:3, :3] @ turn_about(turn)
    text = f"origin of {where} moved by ({give_all(shift)}) m and turned by {say_turn(turn)}"
    return Frames("joint origin", where, text, {k: other})


def _size(evidence: Evidence) -> float:
    """A length of the mechanism's order [m]."""
    lengths = [float(np.linalg.norm(X[:3, 3])) for X in evidence.recursion.origins]
    return max(lengths, default=1.0) or 1.0
