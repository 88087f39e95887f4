"""Mistakes in what a coordinate means: its sign, its unit, its place, its followers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from typing import final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.errors import MecaniqueError
from mecanique.model import slips
from mecanique.model.coordinates import Coordinates
from mecanique.model.expression import symbols_in
from mecanique.model.joint_base import Single
from mecanique.model.mechanism import Mechanism
from mecanique.verification.causes.change import Hypothesis, promising
from mecanique.verification.causes.evidence import Evidence


@final
@dataclass(frozen=True, eq=False)
class _Reading:
    """Another reading of the coordinates: q[i] ← factor q[from]; velocities and forces alike."""

    kind: str
    where: str  # coordinate, or empty
    text: str  # what the other source does
    q: npt.NDArray[np.intp]  # which of our coordinates each one is given, shape (nq,)
    v: npt.NDArray[np.intp]  # the same of velocities, shape (nv,)
    q_factor: Array  # what coordinates are multiplied by, shape (nq,)
    v_factor: Array  # what velocities and accelerations are multiplied by, shape (nv,)
    tau_factor: Array  # what forces are multiplied by, shape (nv,)


def state_changes(evidence: Evidence) -> Iterator[Hypothesis]:
    """Axes of the other sign, degrees for radians, joints in another order."""
    yield from promising(evidence, _readings(evidence), partial(_answers, evidence))


def map_changes(evidence: Evidence) -> Iterator[Hypothesis]:
    """Followers (mimic joints, driven coordinates) that follow wrongly, and their axes."""
    mechanism = evidence.mechanism
    driven = mechanism.coordinates.driven
    names = tuple(mechanism.coordinates)
    for name in driven:
        still = Coordinates(names, {**driven, name: 0.0})
        yield from _rebuild(
            evidence, "mimic", name, f"{name!r} does not follow (mimic ignored)", coordinates=still
        )
    if len(driven) > 1:
        still = Coordinates(names, dict.fromkeys(driven, 0.0))
        yield from _rebuild(
            evidence, "mimic", "", "no joint follows another (mimic ignored)", coordinates=still
        )
    for joint in mechanism.joints:
        if isinstance(joint, Single) and joint.coordinate in _names_in_map(evidence):
            x, y, z = joint.axis
            joints = tuple(
                replace(j, axis=(-x, -y, -z)) if j is joint else j for j in mechanism.joints
            )
            yield from _rebuild(
                evidence, "axis sign", f"joint {joint.name!r}", _reverse(joint.name), joints=joints
            )
    for name, scalar in driven.items():
        back = Coordinates(names, {**driven, name: -scalar})
        yield from _rebuild(
            evidence, "mimic", name, f"{name!r} follows the other way", coordinates=back
        )


def _rebuild(
    evidence: Evidence, kind: str, where: str, text: str, **fields: object
) -> Iterator[Hypothesis]:
    try:
        mechanism = replace(evidence.mechanism, **fields)  # type: ignore[arg-type]  # its own
        if mechanism.velocities == evidence.mechanism.velocities:
            answers = evidence.answers(Recursion(mechanism), evidence.inputs, mechanism=mechanism)
            yield Hypothesis(kind, where, text, answers)
    except MecaniqueError:
        # a change that makes no sound mechanism explains nothing
        return


def _names_in_map(evidence: Evidence) -> set[str]:
    """Coordinates on either side of the coordinate map."""
    driven = evidence.mechanism.coordinates.driven
    return set(driven).union(*map(symbols_in, driven.values()))


def _reverse(name: str) -> str:
    return f"axis of joint {name!r}: reversed"


def _readings(evidence: Evidence) -> Iterator[_Reading]:
    singles = _Singles(evidence.mechanism)
    yield from singles.change_signs(_names_in_map(evidence))
    yield from singles.change_units()
    yield from singles.change_orders()


@final
class _Singles:
    """The coordinates that have a velocity of their own, and other ways to read them."""

    def __init__(self, mechanism: Mechanism) -> None:
        velocities = {name: k for k, name in enumerate(mechanism.velocities)}
        self._places = {
            name: (k, velocities[f"{name}'"])
            for k, name in enumerate(mechanism.coordinates)
            if f"{name}'" in velocities
        }
        of_joint = {j.coordinate: j for j in mechanism.joints if isinstance(j, Single)}
        self._joints = {name: of_joint[name] for name in self._places if name in of_joint}
        nq, nv = mechanism.nq, mechanism.nv
        self._same = _Reading(
            kind="",
            where="",
            text="",
            q=np.arange(nq),
            v=np.arange(nv),
            q_factor=np.ones(nq),
            v_factor=np.ones(nv),
            tau_factor=np.ones(nv),
        )

    def change_signs(self, mapped: set[str]) -> Iterator[_Reading]:
        """Yield axes of the other sign; not of those in the coordinate map alone."""
        for name, joint in self._joints.items():
            if name not in mapped:
                where = f"joint {joint.name!r}"
                factors = self._scale([name], -1, -1, -1)
                yield replace(factors, kind="axis sign", where=where, text=_reverse(joint.name))
        if len(self._joints) > 1:
            text = "axis of every joint: reversed"
            yield replace(self._scale(list(self._joints), -1, -1, -1), kind="axis sign", text=text)

    def change_units(self) -> Iterator[_Reading]:
        """Yield degrees for radians and the reverse, of each angle and of all."""
        angles = [name for name, joint in self._joints.items() if joint.turns]
        groups = [([name], f"coordinate {name!r}") for name in angles]
        groups += [(angles, "")] if len(angles) > 1 else []
        for names, where in groups:
            for q, kind, said in slips.ANGLE:
                text = f"{where or 'every angle'}: {said}"
                alone, moving = self._scale(names, q, 1, 1), self._scale(names, q, q, 1)
                yield replace(alone, kind=kind, where=where, text=text)
                text += ", its rates as well"
                yield replace(moving, kind=kind, where=where, text=text)

    def change_orders(self) -> Iterator[_Reading]:
        """Yield other orders of the coordinates."""
        for text, order in _orders(list(self._places)):
            q, v = self._same.q.copy(), self._same.v.copy()
            for (at_q, at_v), other in zip(self._places.values(), order, strict=True):
                q[at_q], v[at_v] = self._places[other]
            yield replace(self._same, kind="joint order", text=text, q=q, v=v)

    def _scale(self, names: list[str], q: float, v: float, tau: float) -> _Reading:
        """Multiply some coordinates, their rates and their forces."""
        reading = replace(
            self._same,
            q_factor=self._same.q_factor.copy(),
            v_factor=self._same.v_factor.copy(),
            tau_factor=self._same.tau_factor.copy(),
        )
        for name in names:
            at_q, at_v = self._places[name]
            reading.q_factor[at_q], reading.v_factor[at_v], reading.tau_factor[at_v] = q, v, tau
        return reading


def _orders(names: list[str]) -> Iterator[tuple[str, list[str]]]:
    """Other orders of the coordinates."""
    seen = [names]
    orders = [
        ("coordinates in alphabetical order", sorted(names)),
        ("coordinates in reverse order", names[::-1]),
    ]
    for i, k in combinations(range(len(names)), 2):
        order = names.copy()
        order[i], order[k] = names[k], names[i]
        orders.append((f"coordinates {names[i]!r} and {names[k]!r} exchanged", order))
    for text, order in orders:
        # of an order and its inverse, either may have been meant
        back = [names[order.index(name)] for name in names]
        for candidate in (order, back):
            if candidate not in seen:
                seen.append(candidate)
                yield text, candidate


def _answers(evidence: Evidence, readings: list[_Reading], rows: npt.NDArray[np.intp]) -> Array:
    """What each reading answers in some experiments, shape (readings, n, nv)."""
    inputs = evidence.inputs.at(rows)
    many = inputs.at(np.tile(np.arange(len(inputs)), len(readings)))
    moved = replace(
        many,
        q=np.concatenate([inputs.q[:, reading.q] * reading.q_factor for reading in readings]),
        v=np.concatenate([inputs.v[:, reading.v] * reading.v_factor for reading in readings]),
        a=np.concatenate([inputs.a[:, reading.v] * reading.v_factor for reading in readings]),
    )
    answers = evidence.answers(evidence.recursion, moved).reshape(len(readings), len(inputs), -1)
    out = np.empty_like(answers)
    for k, reading in enumerate(readings):
        out[k][:, reading.v] = answers[k]
        out[k] *= reading.tau_factor
    return out
