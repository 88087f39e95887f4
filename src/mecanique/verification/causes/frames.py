"""Mistakes in where the joints stand: lengths in other units, angles in degrees."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.model.placement import rotation
from mecanique.verification.causes.change import Change, promising
from mecanique.verification.causes.evidence import Evidence

__all__ = ["frame_changes"]

_DEGREE = np.pi / 180


@final
@dataclass(frozen=True, eq=False)
class _Variant:
    """Other frames, and other mass moments, by place in the tree."""

    kind: str
    where: str
    text: str
    origins: dict[int, Array]
    moments: dict[int, Array] = field(default_factory=dict)


def frame_changes(evidence: Evidence) -> Iterator[Change]:
    """Joint frames misread, of one joint and of all."""
    yield from promising(evidence, _variants(evidence), partial(_answers, evidence))


def _variants(evidence: Evidence) -> Iterator[_Variant]:
    recursion, mechanism = evidence.recursion, evidence.mechanism
    together: dict[tuple[str, str], dict[int, Array]] = {}
    for k, link in enumerate(recursion.tree):
        X, where = recursion.origins[k], f"joint {link.joint!r}"
        rpy = mechanism.evaluate_all(link.origin.rpy)
        for kind, text, other in _origins(X, rpy):
            yield _Variant(kind, where, f"{text} of {where}", {k: other})
            together.setdefault((kind, text), {})[k] = other
    for (kind, text), origins in together.items():
        if len(origins) > 1:
            yield _Variant(kind, "", f"{text} of every joint", origins)
    for factor, said in ((1e3, "times 1000"), (1e-3, "divided by 1000")):
        origins = {k: _scale(X, factor) for k, X in enumerate(recursion.origins)}
        scale = np.diag([factor, factor, factor, 1.0])
        moments = {k: scale @ J @ scale for k, J in enumerate(recursion.moments)}
        yield _Variant(
            "length unit",
            "",
            f"every length {said}, of joints, centers and inertias",
            origins,
            moments,
        )
        moments = {k: _shift(J, factor) for k, J in enumerate(recursion.moments)}
        yield _Variant(
            "length unit", "", f"every length {said}, of joints and centers", origins, moments
        )


def _origins(X: Array, rpy: list[float]) -> Iterator[tuple[str, str, Array]]:
    if X[:3, 3].any():
        yield "length unit", "position times 1000 (millimeters for meters)", _scale(X, 1e3)
        yield "length unit", "position divided by 1000 (meters for millimeters)", _scale(X, 1e-3)
    if any(rpy):
        small, large = np.multiply(rpy, _DEGREE), np.multiply(rpy, 1 / _DEGREE)
        yield "degree", "roll, pitch and yaw taken for degrees", _turn(X, small.tolist())
        yield "degree", "roll, pitch and yaw in degrees taken for radians", _turn(X, large.tolist())
        yield "frame", "roll, pitch and yaw left out", _turn(X, [0.0, 0.0, 0.0])


def _scale(X: Array, factor: float) -> Array:
    other: Array = X.copy()
    other[:3, 3] *= factor
    return other


def _turn(X: Array, rpy: list[float]) -> Array:
    other: Array = X.copy()
    other[:3, :3] = np.array(rotation(tuple(rpy)), dtype=float)
    return other


def _shift(J: Array, factor: float) -> Array:
    """Moments with the center of mass moved, and the inertia about it kept."""
    other: Array = J.copy()
    other[:3, 3] *= factor
    other[3, :3] *= factor
    if J[3, 3]:
        other[:3, :3] += (factor**2 - 1) * np.outer(J[:3, 3], J[:3, 3]) / J[3, 3]
    return other


def _answers(evidence: Evidence, variants: list[_Variant], rows: npt.NDArray[np.intp]) -> Array:
    """What each variant answers in some experiments, shape (variants, n, nv)."""
    n, recursion = len(rows), evidence.recursion
    inputs = evidence.inputs.at(np.tile(rows, len(variants)))
    changed: list[dict[int, Array]] = []
    for name, own in (("origins", recursion.origins), ("moments", recursion.moments)):
        changes = [getattr(variant, name) for variant in variants]
        repeated = {}
        for k in set().union(*changes):
            repeated[k] = np.repeat([change.get(k, own[k]) for change in changes], n, axis=0)
        changed.append(repeated)
    answers = evidence.answers(recursion.vary(changed[0], changed[1]), inputs)
    return answers.reshape(len(variants), n, -1)
