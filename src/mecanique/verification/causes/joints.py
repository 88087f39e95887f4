"""Mistakes in joints: what coordinates mean, where joints stand, what acts in them; gravity."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations, permutations
from typing import final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.errors import MecaniqueError
from mecanique.model import slips
from mecanique.model.coordinates import Coordinates
from mecanique.model.expression import symbols_in
from mecanique.model.force_base import loads_in
from mecanique.model.joint_base import Single
from mecanique.model.mechanism import Mechanism
from mecanique.model.placement import rpy_rotation
from mecanique.model.slips import Slip, say_factor
from mecanique.verification.causes.evidence import (
    Amount,
    Evidence,
    Hypothesis,
    Tree,
    descend,
    deviations,
    fit,
    give,
    give_all,
    promising,
    say_turn,
    turn_about,
)


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
            for (at_q, at_v), name in zip(self._places.values(), order, strict=True):
                q[at_q], v[at_v] = self._places[name]
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
    """Ways to place a joint that differ in a few numbers."""

    name: str  # of the way, alike for all joints
    numbers: int  # how many
    make: Callable[[Array], Frames]  # the frames of some numbers, with their text
    amount: Callable[[Array], Amount]  # how plain they are


def placement_changes(evidence: Evidence) -> Iterator[Hypothesis]:
    """Joints moved, turned and with tilted axes by amounts that fit."""
    rows = np.arange(len(evidence.inputs))
    weighted = evidence.weigh(evidence.base - evidence.tau)

    def residuals(trials: list[Frames]) -> Array:
        parts = [
            answers_of(evidence, trials[k : k + _PART], rows) for k in range(0, len(trials), _PART)
        ]
        flat = evidence.weigh(np.concatenate(parts) - evidence.tau)
        return np.nan_to_num(flat, nan=1e9, posinf=1e9, neginf=-1e9)

    families = [
        family for k in range(len(evidence.recursion.tree)) for family in _families(evidence, k)
    ]
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
    fitted = [family.make(x) for family, x in zip(kept, unknowns, strict=True)]
    good = [k for k in range(len(kept)) if costs[k] < evidence.before]
    for k in good:
        family, x, frames = kept[k], unknowns[k], fitted[k]
        near = [family.make(x + _SMALL * unit) for unit in np.eye(family.numbers)]
        answers, *others = answers_of(evidence, [frames, *near], rows)
        yield Hypothesis(
            kind=frames.kind,
            where=frames.where,
            text=frames.text,
            answers=answers,
            free=family.numbers,
            amount=family.amount(x),
            tree=frames.tree,
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
    """Derivatives of the residuals by small changes, shape (changes, N)."""
    # a change of one frame is the sum of its shifts and turns, which are evaluated once
    origins = evidence.recursion.origins
    trials: list[Frames] = []
    places: dict[int, int] = {}
    for unit in units:
        if not unit.tree.turns:
            (k,) = unit.tree.origins
            if k not in places:
                places[k] = len(trials)
                trials += [
                    _both(k, origins[k], "", _SMALL * both[:3], _SMALL * both[3:])
                    for both in np.eye(6)
                ]
    tilts = [unit for unit in units if unit.tree.turns]
    slopes = (residuals(trials + tilts) - off) / _SMALL
    of_tilts = iter(slopes[len(trials) :])
    rows = []
    for unit in units:
        if unit.tree.turns:
            rows.append(next(of_tilts))
            continue
        ((k, changed),) = unit.tree.origins.items()
        shift = (changed - origins[k])[:3, 3]
        spin = origins[k][:3, :3].T @ changed[:3, :3]
        turn = np.array([spin[2, 1], spin[0, 2], spin[1, 0]])
        at = places[k]
        rows.append(np.concatenate([shift, turn]) @ slopes[at : at + 6] / _SMALL)
    return np.array(rows)


def _families(evidence: Evidence, k: int) -> Iterator[_Family]:
    if evidence.recursion.tree[k].kind != "free":
        joint = _Joint(evidence, k)
        yield from joint.move()
        yield from joint.turn()
        yield from joint.tilt()
        yield joint.place_anew()


@final
class _Joint:
    """A joint where it stands, and the ways to place it otherwise."""

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
        right_axis = np.array(self._link.axis)
        aside = np.linalg.svd(right_axis[None])[2][1:]

        def make(x: Array) -> Frames:
            axis = turn_about(x @ aside) @ right_axis
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
            R = np.array(rpy_rotation((roll, pitch, yaw)), dtype=float)
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
        moved = self._X.copy()
        moved[:3, 3] = p
        return Frames("joint origin", self._where, text, Tree({self._k: moved}))

    def _face(self, R: Array, text: str) -> Frames:
        frame = self._X.copy()
        frame[:3, :3] = R
        return Frames("joint turn", self._where, text, Tree({self._k: frame}))


def _both(k: int, X: Array, where: str, shift: Array, turn: Array) -> Frames:
    moved = X.copy()
    moved[:3, 3] += shift
    moved[:3, :3] = X[:3, :3] @ turn_about(turn)
    text = f"origin of {where} moved by ({give_all(shift)}) m and turned by {say_turn(turn)}"
    return Frames("joint origin", where, text, Tree({k: moved}))


def _size(evidence: Evidence) -> float:
    """A length of the mechanism's order [m]."""
    lengths = [float(np.linalg.norm(X[:3, 3])) for X in evidence.recursion.origins]
    return max(lengths, default=1.0) or 1.0


@final
@dataclass(frozen=True, eq=False)
class Frames:
    """A mechanism with another tree."""

    kind: str
    where: str
    text: str
    tree: Tree


def frame_changes(evidence: Evidence) -> Iterator[Hypothesis]:
    """Joint frames misread, of one joint and of all."""
    yield from promising(evidence, _variants(evidence), partial(answers_of, evidence))


def _variants(evidence: Evidence) -> Iterator[Frames]:
    recursion, mechanism = evidence.recursion, evidence.mechanism
    together: dict[tuple[str, str], dict[int, Array]] = {}
    for k, link in enumerate(recursion.tree):
        X, where = recursion.origins[k], f"joint {link.joint!r}"
        rpy = np.array(mechanism.evaluate_all(link.origin.rpy))
        for what, slip in _origins(X, rpy):
            yield Frames(slip.kind, where, f"{what} of {where}: {slip.text}", Tree({k: slip.value}))
            text = f"{what} of every joint: {slip.text}"
            together.setdefault((slip.kind, text), {})[k] = slip.value
        yield from _axes(evidence, k)
    for (kind, text), origins in together.items():
        if len(origins) > 1:
            yield Frames(kind, "", text, Tree(origins))
    for factor, kind, text in slips.MILLIMETERS:
        said = f"{text} ({say_factor(factor)})"
        origins = {k: _move(X, factor * X[:3, 3]) for k, X in enumerate(recursion.origins)}
        scale = np.diag([factor, factor, factor, 1.0])
        moments = {k: scale @ J @ scale for k, J in enumerate(recursion.moments)}
        where = "every length, of joints, centers and inertias"
        yield Frames(kind, "", f"{where}: {said}", Tree(origins, moments))
        moments = {k: _shift(J, factor) for k, J in enumerate(recursion.moments)}
        where = "every length, of joints and centers"
        yield Frames(kind, "", f"{where}: {said}", Tree(origins, moments))


def _origins(X: Array, rpy: Array) -> Iterator[tuple[str, Slip]]:
    """Yield a joint's frame with a slip in its position or in its orientation, and in which."""
    p = X[:3, 3]
    if p.any():
        for factor, kind, text in slips.MILLIMETERS:
            yield "position", Slip(kind, f"{text} ({say_factor(factor)})", _move(X, factor * p))
        for slip in slips.mistake_vector("joint origin", p):
            yield "position", slip._replace(value=_move(X, slip.value))
        yield "position", Slip("joint origin", slips.LEFT_OUT, _move(X, 0 * p))
    if rpy.any():
        for slip in slips.mistake_turn(rpy):
            yield "orientation", slip._replace(value=_face(X, slip.value))


def _axes(evidence: Evidence, k: int) -> Iterator[Frames]:
    """Another axis of a joint: one of x, y and z, or its own with the coordinates exchanged."""
    link = evidence.recursion.tree[k]
    if link.kind not in ("turn", "slide"):
        return
    right_axis = np.array(link.axis)
    others = [sign * axis for axis in np.eye(3) for sign in (1, -1)]
    others += [right_axis[list(order)] for order in permutations(range(3))]
    others += [right_axis * (1 - 2 * axis) for axis in np.eye(3)]
    seen = [right_axis]
    yield with_axis(evidence, k, -right_axis, f"axis of joint {link.joint!r}: reversed")
    for axis in (axis for axis in others if not np.allclose(axis, -right_axis, rtol=0, atol=1e-9)):
        if not any(np.allclose(axis, known, rtol=0, atol=1e-9) for known in seen):
            seen.append(axis)
            where = f"joint {link.joint!r}"
            said = f"axis of {where} along ({', '.join(f'{x:.6g}' for x in axis)})"
            yield with_axis(evidence, k, axis, said)


def with_axis(evidence: Evidence, k: int, axis: Array, text: str) -> Frames:
    """Return a joint that moves along another axis of its frame; all frames stay at zero."""
    recursion = evidence.recursion
    Q = np.eye(4)
    Q[:3, :3] = _from_to(np.array(recursion.tree[k].axis), axis)
    where = f"joint {recursion.tree[k].joint!r}"
    opposite = np.allclose(axis, -np.array(recursion.tree[k].axis), rtol=0, atol=1e-8)
    kind = "axis sign" if opposite else "joint axis"
    return Frames(kind, where, text, Tree(turns={k: Q}))


def _from_to(a: Array, b: Array) -> Array:
    """A turn that carries one unit vector to another."""
    across, along = np.cross(a, b), float(a @ b)
    size = float(np.linalg.norm(across))
    if size > 1e-12:
        return turn_about(across / size * np.arctan2(size, along))
    if along > 0:
        return np.eye(3)
    aside = np.cross(a, np.eye(3)[np.argmin(np.abs(a))])
    return turn_about(np.pi * aside / np.linalg.norm(aside))


def _face(X: Array, R: Array) -> Array:
    frame: Array = X.copy()
    frame[:3, :3] = R
    return frame


def _move(X: Array, p: Array) -> Array:
    frame: Array = X.copy()
    frame[:3, 3] = p
    return frame


def _shift(J: Array, factor: float) -> Array:
    """Moments with the center of mass moved, and the inertia about it kept."""
    shifted: Array = J.copy()
    shifted[:3, 3] *= factor
    shifted[3, :3] *= factor
    if J[3, 3]:
        shifted[:3, :3] += (factor**2 - 1) * np.outer(J[:3, 3], J[:3, 3]) / J[3, 3]
    return shifted


def answers_of(evidence: Evidence, variants: list[Frames], rows: npt.NDArray[np.intp]) -> Array:
    """Return what each variant answers in some experiments, shape (variants, n, nv)."""
    n, recursion = len(rows), evidence.recursion
    inputs = evidence.inputs.at(np.tile(rows, len(variants)))
    changed: dict[str, dict[int, Array]] = {}
    for name in ("origins", "moments", "turns"):
        originals, repeated = getattr(recursion, name), changed.setdefault(name, {})
        changes = [getattr(variant.tree, name) for variant in variants]
        for k in set().union(*changes):
            repeated[k] = np.repeat([change.get(k, originals[k]) for change in changes], n, axis=0)
    varied = recursion.vary(changed["origins"], changed["moments"], turns=changed["turns"])
    answers = evidence.answers(varied, inputs)
    return answers.reshape(len(variants), n, -1)


_UNITS = {
    ("armature", True): "kg·m²",
    ("armature", False): "kg",
    ("damping", True): "N·m·s",
    ("damping", False): "N·s/m",
    ("friction", True): "N·m",
    ("friction", False): "N",
}


def joint_changes(evidence: Evidence) -> Iterator[Hypothesis]:
    """Armature, damping and dry friction, of one joint and of all alike."""
    inputs, mechanism = evidence.inputs, evidence.mechanism
    # what acts in joints is looked for among the forces if the other source tells them apart from
    # the inertia forces
    acting = inputs.loads if inputs.loads.any() else inputs.inertia
    rates = {
        "armature": inputs.a * inputs.inertia[:, None],
        "damping": inputs.v * acting[:, None],
        "friction": np.sign(inputs.v) * acting[:, None],
    }
    velocities = {name: index for index, name in enumerate(mechanism.velocities)}
    singles = [joint for joint in mechanism.joints if isinstance(joint, Single)]
    free = [joint for joint in singles if joint.velocities[-1] in velocities]
    for kind, rate in rates.items():
        if not rate.any():
            continue
        columns = np.zeros((len(free), *evidence.tau.shape))
        present = np.zeros(len(free))
        for k, joint in enumerate(free):
            index = velocities[joint.velocities[-1]]
            columns[k, :, index] = rate[:, index]
            if kind == "armature":
                present[k] = mechanism.evaluate(joint.armature)
            if kind == "damping":
                dampers = loads_in(mechanism.forces, joint.name, "damper")
                present[k] = sum(mechanism.evaluate(damper.coefficient) for damper in dampers)
            amounts, answers = fit(evidence, columns[k : k + 1])
            where, unit = f"joint {joint.name!r}", _UNITS[kind, joint.turns]
            # there is no less than nothing of it
            if present[k] + amounts[0] > -1e-9 * abs(amounts[0]):
                slope = (columns[k] * evidence.weights).reshape(1, -1)
                left = float(evidence.residual(answers))
                sigma = deviations(slope, left, evidence.tau.size) if evidence.is_measured else [0]
                text = _text(kind, where, amounts[0], present[k], unit, float(sigma[0]))
                # a rotor or friction that one side does not count is likelier than any odd number
                amount = replace(Amount.of(present[k] + amounts[0], present[k]), share=0.0)
                yield Hypothesis(kind, where, text, answers, 1, amount, slopes=columns[k : k + 1])
        if len(free) > 1:
            amounts, answers = fit(evidence, columns.sum(axis=0)[None])
            if amounts[0] + present.min() > -1e-9 * abs(amounts[0]):
                yield Hypothesis(
                    kind,
                    "",
                    f"{kind} in every joint: {amounts[0]:+.6g} more in each (SI units)",
                    answers,
                    1,
                )
            if np.count_nonzero(present) > 1:
                without = evidence.base - np.einsum("k,knv->nv", present, columns)
                yield Hypothesis(kind, "", f"the {kind} of every joint is left out", without)


def gravity_changes(evidence: Evidence) -> Iterator[Hypothesis]:
    """Gravity of the other sign, in another direction, of another strength."""
    inputs, pull, recursion = evidence.inputs, evidence.gravity, evidence.recursion
    still = evidence.answers(recursion, inputs, np.zeros(3))
    pulls = np.array([evidence.answers(recursion, inputs, axis) - still for axis in np.eye(3)])
    if not pulls.any():
        return

    def answers(g: Array) -> Array:
        predicted: Array = evidence.base + np.einsum("k,knv->nv", g - pull, pulls)
        return predicted

    size = float(np.linalg.norm(pull))
    if size:
        yield Hypothesis("gravity sign", "", "gravity pulls the other way", answers(-pull))
        yield Hypothesis("gravity direction", "", "gravity is left out", answers(np.zeros(3)))
    for axis, name in zip(np.eye(3), "xyz", strict=True):
        for sign, mark in ((1, "+"), (-1, "−")):
            g = sign * size * axis
            if size and not np.allclose(np.abs(g), np.abs(pull), rtol=0, atol=1e-9 * size):
                yield Hypothesis(
                    "gravity direction", "", f"gravity pulls along {mark}{name}", answers(g)
                )
    amounts, predicted = fit(evidence, pulls)
    fitted = np.where(
        np.abs(pull + amounts) > 1e-9 * np.linalg.norm(pull + amounts), pull + amounts, 0.0
    )
    plain = [np.zeros(3), -pull, *(sign * size * axis for axis in np.eye(3) for sign in (1, -1))]
    if size and any(np.allclose(fitted, known, rtol=0, atol=1e-9 * size) for known in plain):
        # it is one of those above
        return
    listed = ", ".join(f"{g:.6g}" for g in fitted)
    yield Hypothesis("gravity direction", "", f"gravity is ({listed}) m/s²", predicted, 3)


def _text(kind: str, where: str, amount: float, present: float, unit: str, sigma: float) -> str:
    if present and abs(amount + present) <= 1e-6 * abs(present):
        return f"the {kind} of {where} ({present:.6g} {unit}) is left out"
    return f"{kind} of {where}: {give(present + amount, sigma)} {unit} instead of {present:.6g}"
