"""Mistakes in where the joints stand: lengths in other units, angles in degrees."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from itertools import permutations
from typing import final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.model.placement import rotation
from mecanique.verification.causes.change import Change, promising
from mecanique.verification.causes.evidence import Evidence
from mecanique.verification.causes.fitted import turn_about

_DEGREE = np.pi / 180


@final
@dataclass(frozen=True, eq=False)
class Frames:
    """Other frames, other mass moments and turned axes, by place in the tree."""

    kind: str
    where: str
    text: str
    origins: dict[int, Array] = field(default_factory=dict)
    moments: dict[int, Array] = field(default_factory=dict)
    turns: dict[int, Array] = field(default_factory=dict)


def frame_changes(evidence: Evidence) -> Iterator[Change]:
    """Joint frames misread, of one joint and of all."""
    yield from promising(evidence, _variants(evidence), partial(answers_of, evidence))


def _variants(evidence: Evidence) -> Iterator[Frames]:
    recursion, mechanism = evidence.recursion, evidence.mechanism
    together: dict[tuple[str, str], dict[int, Array]] = {}
    for k, link in enumerate(recursion.tree):
        X, where = recursion.origins[k], f"joint {link.joint!r}"
        rpy = mechanism.evaluate_all(link.origin.rpy)
        for kind, text, other in _origins(X, rpy):
            yield Frames(kind, where, f"{text} of {where}", {k: other})
            together.setdefault((kind, text), {})[k] = other
        yield from _axes(evidence, k)
    for (kind, text), origins in together.items():
        if len(origins) > 1:
            yield Frames(kind, "", f"{text} of every joint", origins)
    for factor, said in ((1e3, "times 1000"), (1e-3, "divided by 1000")):
        origins = {k: _scale(X, factor) for k, X in enumerate(recursion.origins)}
        scale = np.diag([factor, factor, factor, 1.0])
        moments = {k: scale @ J @ scale for k, J in enumerate(recursion.moments)}
        yield Frames(
            "length unit",
            "",
            f"every length {said}, of joints, centers and inertias",
            origins,
            moments,
        )
        moments = {k: _shift(J, factor) for k, J in enumerate(recursion.moments)}
        yield Frames(
            "length unit", "", f"every length {said}, of joints and centers", origins, moments
        )


def _origins(X: Array, rpy: list[float]) -> Iterator[tuple[str, str, Array]]:
    yield from _positions(X)
    yield from _angles(X, rpy)


def _positions(X: Array) -> Iterator[tuple[str, str, Array]]:
    """A position in other units, mirrored, with its coordinates exchanged, or left out."""
    p = X[:3, 3]
    if not p.any():
        return
    yield "length unit", "position times 1000 (millimeters for meters)", _scale(X, 1e3)
    yield "length unit", "position divided by 1000 (meters for millimeters)", _scale(X, 1e-3)
    seen = [p]
    others = [
        (f"{'xyz'[k]} of the position of the other sign", p * (1 - 2 * np.eye(3)[k]))
        for k in range(3)
    ]
    others += [("position of the other sign", -p), ("position left out", 0 * p)]
    others += [
        (f"position with x, y, z taken from {_say_order(order)}", p[list(order)])
        for order in permutations(range(3))
    ]
    for text, other in others:
        if not any(np.allclose(other, one, rtol=1e-9, atol=0) for one in seen):
            seen.append(other)
            yield "joint origin", text, _move(X, other)


def _angles(X: Array, rpy: list[float]) -> Iterator[tuple[str, str, Array]]:
    """Roll, pitch and yaw in other units, of other signs, in another order, or left out."""
    if not any(rpy):
        return
    small, large = np.multiply(rpy, _DEGREE), np.multiply(rpy, 1 / _DEGREE)
    yield "degree", "roll, pitch and yaw taken for degrees", _turn(X, small.tolist())
    yield "degree", "roll, pitch and yaw in degrees taken for radians", _turn(X, large.tolist())
    yield "frame", "roll, pitch and yaw left out", _turn(X, [0.0, 0.0, 0.0])
    about = [turn_about(angle * axis) for angle, axis in zip(rpy, np.eye(3), strict=True)]
    seen = [X]
    found = []
    for order in permutations(range(3)):
        first, second, third = order
        said = f"roll, pitch and yaw applied in the order {_say_order(order)} about moved axes"
        found.append((said, _face(X, about[first] @ about[second] @ about[third])))
    for order in permutations(range(3)):
        said = f"roll, pitch and yaw taken from those about {_say_order(order)}"
        found.append((said, _turn(X, [rpy[k] for k in order])))
    for k, name in enumerate(("roll", "pitch", "yaw")):
        signs = 1 - 2 * np.eye(3)[k]
        found.append((f"{name} of the other sign", _turn(X, (signs * rpy).tolist())))
        said = f"roll, pitch and yaw mirrored across {'xyz'[k]}"
        found.append((said, _turn(X, (-signs * rpy).tolist())))
    found.append(("roll, pitch and yaw turned back", _face(X, X[:3, :3].T)))
    for text, other in found:
        if not any(np.allclose(other, one, rtol=0, atol=1e-9) for one in seen):
            seen.append(other)
            yield "joint turn", text, other


def _say_order(order: tuple[int, ...]) -> str:
    return ", ".join("xyz"[k] for k in order)


def _axes(evidence: Evidence, k: int) -> Iterator[Frames]:
    """Another axis of a joint: one of x, y and z, or its own with the coordinates exchanged."""
    link = evidence.recursion.tree[k]
    if link.kind not in ("turn", "slide"):
        return
    own = np.array(link.axis)
    others = [sign * axis for axis in np.eye(3) for sign in (1, -1)]
    others += [own[list(order)] for order in permutations(range(3))]
    others += [own * (1 - 2 * axis) for axis in np.eye(3)]
    seen = [own]
    yield with_axis(evidence, k, -own, f"axis of joint {link.joint!r} of the other sign")
    for axis in (axis for axis in others if not np.allclose(axis, -own, rtol=0, atol=1e-9)):
        if not any(np.allclose(axis, one, rtol=0, atol=1e-9) for one in seen):
            seen.append(axis)
            where = f"joint {link.joint!r}"
            said = f"axis of {where} along ({', '.join(f'{x:.6g}' for x in axis)})"
            yield with_axis(evidence, k, axis, said)


def with_axis(evidence: Evidence, k: int, axis: Array, text: str) -> Frames:
    """Return a joint that moves along another axis of its frame; all frames stay at zero.

    Args:
        evidence: about what mechanism.
        k: the joint's place in the tree.
        axis: unit vector.
        text: what it means.
    """
    recursion = evidence.recursion
    Q = np.eye(4)
    Q[:3, :3] = _from_to(np.array(recursion.tree[k].axis), axis)
    where = f"joint {recursion.tree[k].joint!r}"
    opposite = np.allclose(axis, -np.array(recursion.tree[k].axis), rtol=0, atol=1e-8)
    kind = "axis sign" if opposite else "joint axis"
    return Frames(kind, where, text, turns={k: Q})


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


def _scale(X: Array, factor: float) -> Array:
    other: Array = X.copy()
    other[:3, 3] *= factor
    return other


def _turn(X: Array, rpy: list[float]) -> Array:
    return _face(X, np.array(rotation(tuple(rpy)), dtype=float))


def _face(X: Array, R: Array) -> Array:
    other: Array = X.copy()
    other[:3, :3] = R
    return other


def _move(X: Array, p: Array) -> Array:
    other: Array = X.copy()
    other[:3, 3] = p
    return other


def _shift(J: Array, factor: float) -> Array:
    """Moments with the center of mass moved, and the inertia about it kept."""
    other: Array = J.copy()
    other[:3, 3] *= factor
    other[3, :3] *= factor
    if J[3, 3]:
        other[:3, :3] += (factor**2 - 1) * np.outer(J[:3, 3], J[:3, 3]) / J[3, 3]
    return other


def answers_of(evidence: Evidence, variants: list[Frames], rows: npt.NDArray[np.intp]) -> Array:
    """Return what each variant answers in some experiments, shape (variants, n, nv)."""
    n, recursion = len(rows), evidence.recursion
    inputs = evidence.inputs.at(np.tile(rows, len(variants)))
    changed: dict[str, dict[int, Array]] = {}
    for name in ("origins", "moments", "turns"):
        own, repeated = getattr(recursion, name), changed.setdefault(name, {})
        changes = [getattr(variant, name) for variant in variants]
        for k in set().union(*changes):
            repeated[k] = np.repeat([change.get(k, own[k]) for change in changes], n, axis=0)
    varied = recursion.vary(changed["origins"], changed["moments"], turns=changed["turns"])
    answers = evidence.answers(varied, inputs)
    return answers.reshape(len(variants), n, -1)
