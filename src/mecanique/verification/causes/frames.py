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
from mecanique.model import slips
from mecanique.model.slips import Slip, say_factor
from mecanique.verification.causes.change import Change, promising
from mecanique.verification.causes.evidence import Evidence
from mecanique.verification.causes.fitted import turn_about


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
        rpy = np.array(mechanism.evaluate_all(link.origin.rpy))
        for what, slip in _origins(X, rpy):
            yield Frames(slip.kind, where, f"{what} of {where}: {slip.text}", {k: slip.value})
            text = f"{what} of every joint: {slip.text}"
            together.setdefault((slip.kind, text), {})[k] = slip.value
        yield from _axes(evidence, k)
    for (kind, text), origins in together.items():
        if len(origins) > 1:
            yield Frames(kind, "", text, origins)
    for factor, kind, text in slips.MILLIMETERS:
        said = f"{text} ({say_factor(factor)})"
        origins = {k: _move(X, factor * X[:3, 3]) for k, X in enumerate(recursion.origins)}
        scale = np.diag([factor, factor, factor, 1.0])
        moments = {k: scale @ J @ scale for k, J in enumerate(recursion.moments)}
        where = "every length, of joints, centers and inertias"
        yield Frames(kind, "", f"{where}: {said}", origins, moments)
        moments = {k: _shift(J, factor) for k, J in enumerate(recursion.moments)}
        where = "every length, of joints and centers"
        yield Frames(kind, "", f"{where}: {said}", origins, moments)


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
    own = np.array(link.axis)
    others = [sign * axis for axis in np.eye(3) for sign in (1, -1)]
    others += [own[list(order)] for order in permutations(range(3))]
    others += [own * (1 - 2 * axis) for axis in np.eye(3)]
    seen = [own]
    yield with_axis(evidence, k, -own, f"axis of joint {link.joint!r}: reversed")
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
