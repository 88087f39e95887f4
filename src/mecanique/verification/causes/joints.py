"""Mistakes in joints: what coordinates mean, where joints stand, what acts in them; gravity."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations, permutations
from types import MappingProxyType
from typing import NamedTuple, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.errors import MecaniqueError
from mecanique.model import Coordinates, slips
from mecanique.model.expression import symbols_in
from mecanique.model.force_base import loads_in
from mecanique.model.joint_base import Single
from mecanique.model.slips import Slip, say_factor
from mecanique.verification.causes.evidence import (
    SMALL,
    Amount,
    Evidence,
    Family,
    Hypothesis,
    Inputs,
    TreeChange,
    deviations,
    fit,
    fit_families,
    give,
    give_all,
    promising,
    say_turn,
    turn_about,
)


class _Scale(NamedTuple):
    """What coordinates, velocities and accelerations, and forces are multiplied by."""

    q: float = 1.0
    v: float = 1.0
    tau: float = 1.0


class _Reading(NamedTuple):
    """Another reading of the coordinates that have a velocity of their own, by name."""

    kind: str
    where: str  # coordinate or joint, or empty
    text: str  # what the other source does
    scale: Mapping[str, _Scale] = MappingProxyType({})
    taken: Mapping[str, str] = MappingProxyType({})  # which of our coordinates each one is given


def state_changes(evidence: Evidence) -> Iterator[Hypothesis]:
    """Axes of the other sign, degrees for radians, joints in another order."""
    velocities = {name: k for k, name in enumerate(evidence.mechanism.velocities)}
    places = {
        name: (k, velocities[f"{name}'"])
        for k, name in enumerate(evidence.mechanism.coordinates)
        if f"{name}'" in velocities
    }
    readings = _readings(evidence, list(places))
    yield from promising(evidence, readings, partial(_answers, evidence, places))


def map_changes(evidence: Evidence) -> Iterator[Hypothesis]:
    """Followers (mimic joints, driven coordinates) that follow wrongly."""
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


def _reverse(name: str) -> str:
    return f"axis of joint {name!r}: reversed"


def _readings(evidence: Evidence, names: list[str]) -> Iterator[_Reading]:
    singles = {j.coordinate: j for j in evidence.mechanism.joints if isinstance(j, Single)}
    joints = {name: singles[name] for name in names if name in singles}
    driven = evidence.mechanism.coordinates.driven
    mapped = set(driven).union(*map(symbols_in, driven.values()))  # on either side
    reversed_axis = _Scale(-1, -1, -1)
    for name, joint in joints.items():
        # an axis in the coordinate map is another mistake
        if name not in mapped:
            where = f"joint {joint.name!r}"
            text = _reverse(joint.name)
            yield _Reading("axis sign", where, text, {name: reversed_axis})
    if len(joints) > 1:
        text = "axis of every joint: reversed"
        yield _Reading("axis sign", "", text, dict.fromkeys(joints, reversed_axis))
    angles = [name for name, joint in joints.items() if joint.turns]
    groups = [([name], f"coordinate {name!r}") for name in angles]
    groups += [(angles, "")] if len(angles) > 1 else []
    for group, where in groups:
        for q, kind, said in slips.ANGLE:
            text = f"{where or 'every angle'}: {said}"
            yield _Reading(kind, where, text, dict.fromkeys(group, _Scale(q)))
            text += ", its rates as well"
            yield _Reading(kind, where, text, dict.fromkeys(group, _Scale(q, q)))
    for text, order in _orders(names):
        pairs = zip(names, order, strict=True)
        yield _Reading("joint order", "", text, taken={a: b for a, b in pairs if a != b})


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


def _answers(
    evidence: Evidence,
    places: Mapping[str, tuple[int, int]],
    readings: list[_Reading],
    rows: npt.NDArray[np.intp],
) -> Array:
    """What each reading answers in some experiments, shape (readings, n, nv)."""
    inputs = evidence.inputs.at(rows)
    nv = evidence.mechanism.nv
    moved, factors = list[Inputs](), list[Array]()
    order = np.tile(np.arange(nv), (len(readings), 1))
    for reading, forces in zip(readings, order, strict=True):
        q, v, a = (part.copy() for part in (inputs.q, inputs.v, inputs.a))
        factor = np.ones(nv)
        for name in {*reading.taken, *reading.scale}:
            at_q, at_v = places[name]
            from_q, from_v = places[reading.taken.get(name, name)]
            scale = reading.scale.get(name, _Scale())
            q[:, at_q] = scale.q * inputs.q[:, from_q]
            v[:, at_v] = scale.v * inputs.v[:, from_v]
            a[:, at_v] = scale.v * inputs.a[:, from_v]
            forces[at_v], factor[at_v] = from_v, scale.tau
        moved.append(replace(inputs, q=q, v=v, a=a))
        factors.append(factor)
    answers = evidence.answers(evidence.recursion, Inputs.join(moved))
    back = np.argsort(order, axis=1)[:, None]
    whole = np.take_along_axis(answers.reshape(len(readings), len(inputs), nv), back, axis=2)
    return whole * np.array(factors)[:, None]


_CLOSER = 3
"""Joints that get a closer look, of each way to change one."""

_MOST = 12
"""Ways to change a joint that are followed to the end."""


def placement_changes(evidence: Evidence) -> Iterator[Hypothesis]:
    """Joints moved, turned and with tilted axes by amounts that fit."""

    def residuals(trees: list[TreeChange]) -> Array:
        flat = evidence.weigh(evidence.change(trees) - evidence.tau)
        return np.nan_to_num(flat, nan=1e9, posinf=1e9, neginf=-1e9)

    joints = [k for k, link in enumerate(evidence.recursion.tree) if link.kind != "free"]
    families = [family for k in joints for family in _families(evidence, k)]
    if families:
        kept = _choose(families, residuals, evidence.weigh(evidence.base - evidence.tau))
        # no placement changes anything where nothing but noise is left, say
        if kept:
            yield from fit_families(evidence, kept, residuals, evidence.change, _MOST)


def _choose(
    families: list[Family], residuals: Callable[[list[TreeChange]], Array], off: Array
) -> list[Family]:
    """The joints, of each way, whose small changes explain most."""
    trees = [family.change(step) for family in families for step in family.units]
    slopes = iter((residuals(trees) - off) / SMALL)
    gains: dict[Family, float] = {}
    for family in families:
        columns = np.array([next(slopes) for _ in family.units])
        used = columns[np.linalg.norm(columns, axis=1) > 1e-9]
        if len(used):
            left = off - used.T @ np.linalg.lstsq(used.T, off, rcond=1e-9)[0]
            gains[family] = float(np.linalg.norm(left))
    kept = set[Family]()
    for way in {family.way for family in families}:
        alike = [family for family in gains if family.way == way]
        kept.update(sorted(alike, key=lambda family: gains[family])[:_CLOSER])
    return [family for family in families if family in kept]


def _families(evidence: Evidence, k: int) -> Iterator[Family]:
    """Yield the ways to place a joint otherwise."""
    link, X = evidence.recursion.tree[k], evidence.recursion.origins[k]
    where = f"joint {link.joint!r}"
    size = _size(evidence)
    p = X[:3, 3]
    far = float(np.linalg.norm(p))
    still = np.zeros((3, 3))

    def move(
        way: str,
        steps: Array,
        turns: Array,
        say: Callable[[Array], str],
        amount: Callable[[Array], Amount],
        kind: str = "joint origin",
    ) -> Family:
        """Return the way to move by x · steps and to turn by x · turns, shape (numbers, 3)."""

        def change(x: Array) -> TreeChange:
            frame = _move(X, p + x @ steps)
            return TreeChange({k: _face(frame, X[:3, :3] @ turn_about(x @ turns))})

        start = np.zeros(len(steps))
        return Family(kind, where, change, lambda x, _: say(x), amount, (start,), way)

    def shift(axis: Array, name: str) -> Family:
        """Return the way to move along an axis."""
        before = float(p @ axis)
        return move(
            f"shift {name}",
            size * axis[None],
            still[:1],
            lambda x: f"origin of {where} moved by {size * x[0]:.6g} m along {name}",
            lambda x: Amount.of(before + size * x[0], before, far, ways=3),
        )

    def spin(axis: Array, name: str) -> Family:
        """Return the way to turn about an axis."""
        return move(
            f"turn {name}",
            still[:1],
            axis[None],
            lambda x: f"{where} turned by {np.degrees(x[0]):.6g}° about its {name}",
            lambda x: Amount.of(np.degrees(x[0]), beside=180.0, ways=3),
            "joint turn",
        )

    yield from map(shift, np.eye(3), "xyz")
    if np.count_nonzero(p) > 1:
        yield move(
            "longer",
            p[None],
            still[:1],
            lambda x: f"position of {where} times {1 + x[0]:.6g}",
            lambda x: Amount.of(1 + x[0], 1.0, ways=3),
        )
    yield move(
        "shift",
        size * np.eye(3),
        still,
        lambda x: f"origin of {where} moved by ({give_all(size * x)}) m",
        lambda x: Amount.of_all(size * x, far),
    )
    rpy = np.array(evidence.mechanism.evaluate_all(link.origin.rpy))
    for at in range(3):
        yield _change_angle(k, X, where, rpy, at)
    yield from map(spin, np.eye(3), "xyz")
    yield move(
        "turn",
        still,
        np.eye(3),
        lambda x: f"{where} turned by {say_turn(x)}",
        lambda x: Amount.of_all(np.degrees(x), 180.0),
        "joint turn",
    )
    if link.kind in ("turn", "slide"):
        yield _tilt(k, where, np.array(link.axis))
    steps, turns = np.split(np.diag([size] * 3 + [1.0] * 3), 2, axis=1)
    yield move(
        "place",
        steps,
        turns,
        lambda x: (
            f"origin of {where} moved by ({give_all(size * x[:3])}) m and turned by "
            f"{say_turn(x[3:])}"
        ),
        lambda x: Amount.of_all(size * x[:3], far),
    )


def _change_angle(k: int, X: Array, where: str, rpy: Array, at: int) -> Family:
    """Return the way to change roll, pitch or yaw."""
    name, before = ("roll", "pitch", "yaw")[at], rpy[at]

    def change(x: Array) -> TreeChange:
        return TreeChange({k: _face(X, slips.turn_of(rpy + x[0] * np.eye(3)[at]))})

    def say(x: Array, _: Array) -> str:
        return f"{name} of {where}: {before + x[0]:.6g} rad instead of {before:.6g} rad"

    def amount(x: Array) -> Amount:
        radians, degrees = (
            Amount.of(unit * (before + x[0]), unit * before, unit * np.pi, ways=3)
            for unit in (1.0, np.degrees(1.0))
        )
        return min(radians, degrees)

    return Family("joint turn", where, change, say, amount, (np.zeros(1),), name)


def _tilt(k: int, where: str, right_axis: Array) -> Family:
    """Return the way to tilt a joint's axis."""
    aside = np.linalg.svd(right_axis[None])[2][1:]

    def tilt(x: Array) -> Array:
        axis: Array = turn_about(x @ aside) @ right_axis
        return axis

    return Family(
        "joint axis",
        where,
        lambda x: _lead(k, right_axis, tilt(x)),
        lambda x, _: f"axis of {where} along ({give_all(tilt(x))})",
        lambda x: Amount.of_all(np.degrees(x), 180.0),
        (np.zeros(2),),
        "tilt",
    )


def _size(evidence: Evidence) -> float:
    """A length of the mechanism's order [m]."""
    lengths = [float(np.linalg.norm(X[:3, 3])) for X in evidence.recursion.origins]
    return max(lengths, default=1.0) or 1.0


@final
@dataclass(frozen=True, eq=False)
class Frames:
    """A guess: a mechanism with another tree."""

    kind: str
    where: str
    text: str
    tree: TreeChange


def frame_changes(evidence: Evidence) -> Iterator[Hypothesis]:
    """Joint frames misread, of one joint and of all."""
    yield from promising(
        evidence,
        _variants(evidence),
        lambda some, rows: evidence.change([variant.tree for variant in some], rows),
    )


def _variants(evidence: Evidence) -> Iterator[Frames]:
    recursion, mechanism = evidence.recursion, evidence.mechanism
    together: dict[tuple[str, str], dict[int, Array]] = {}
    for k, link in enumerate(recursion.tree):
        X, where = recursion.origins[k], f"joint {link.joint!r}"
        rpy = np.array(mechanism.evaluate_all(link.origin.rpy))
        for what, slip in _origins(X, rpy):
            yield Frames(
                slip.kind, where, f"{what} of {where}: {slip.text}", TreeChange({k: slip.value})
            )
            text = f"{what} of every joint: {slip.text}"
            together.setdefault((slip.kind, text), {})[k] = slip.value
        yield from _axes(evidence, k)
    for (kind, text), origins in together.items():
        if len(origins) > 1:
            yield Frames(kind, "", text, TreeChange(origins))
    for factor, kind, text in slips.MILLIMETERS:
        said = f"{text} ({say_factor(factor)})"
        origins = {k: _move(X, factor * X[:3, 3]) for k, X in enumerate(recursion.origins)}
        scale = np.diag([factor, factor, factor, 1.0])
        moments = {k: scale @ J @ scale for k, J in enumerate(recursion.moments)}
        where = "every length, of joints, centers and inertias"
        yield Frames(kind, "", f"{where}: {said}", TreeChange(origins, moments))
        moments = {k: _shift(J, factor) for k, J in enumerate(recursion.moments)}
        where = "every length, of joints and centers"
        yield Frames(kind, "", f"{where}: {said}", TreeChange(origins, moments))


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
    where = f"joint {link.joint!r}"
    others = [sign * axis for axis in np.eye(3) for sign in (1, -1)]
    others += [right_axis[list(order)] for order in permutations(range(3))]
    others += [right_axis * (1 - 2 * axis) for axis in np.eye(3)]
    yield Frames("axis sign", where, _reverse(link.joint), _lead(k, right_axis, -right_axis))
    seen = [right_axis, -right_axis]
    for axis in others:
        if not any(np.allclose(axis, known, rtol=0, atol=1e-9) for known in seen):
            seen.append(axis)
            said = f"axis of {where} along ({give_all(axis)})"
            yield Frames("joint axis", where, said, _lead(k, right_axis, axis))


def _lead(k: int, right_axis: Array, axis: Array) -> TreeChange:
    """Return a joint that moves along another axis of its frame; all frames stay at zero."""
    Q = _face(np.eye(4), _from_to(right_axis, axis))
    return TreeChange(turns={k: Q})


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
    known = [
        ("gravity sign", "gravity pulls the other way", -pull),
        ("gravity direction", "gravity is left out", np.zeros(3)),
    ]
    for axis, name in zip(np.eye(3), "xyz", strict=True):
        if not np.allclose(size * axis, np.abs(pull), rtol=0, atol=1e-9 * size):
            known.append(("gravity direction", f"gravity pulls along +{name}", size * axis))
            known.append(("gravity direction", f"gravity pulls along −{name}", -size * axis))
    for kind, text, g in known if size else ():
        yield Hypothesis(kind, "", text, answers(g))
    amounts, predicted = fit(evidence, pulls)
    fitted = pull + amounts
    fitted = np.where(np.abs(fitted) > 1e-9 * np.linalg.norm(fitted), fitted, 0.0)
    if size and any(np.allclose(fitted, g, rtol=0, atol=1e-9 * size) for _, _, g in known):
        return
    text = f"gravity is ({give_all(fitted)}) m/s²"
    yield Hypothesis("gravity direction", "", text, predicted, 3)


def _text(kind: str, where: str, amount: float, present: float, unit: str, sigma: float) -> str:
    if present and abs(amount + present) <= 1e-6 * abs(present):
        return f"the {kind} of {where} ({present:.6g} {unit}) is left out"
    return f"{kind} of {where}: {give(present + amount, sigma)} {unit} instead of {present:.6g}"
