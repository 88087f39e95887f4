"""The position to draw a mechanism in without a motion: every coordinate a little off zero."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from mecanique.errors import MecaniqueError
from mecanique.model.forces import Spring
from mecanique.model.mechanism import Mechanism
from mecanique.model.units import units

ANGLES = (0.55, 0.95, 0.75, 1.15)
"""Values of the first, second … angle, unless it starts at a moderate angle of its own [rad]."""

SLIGHT, GREAT = 0.25, 1.3
"""Range of moderate angles [rad]."""


MOST_TURNED = 12
"""Of a robot with more coordinates each joint is drawn as its file has it: else it is a tangle."""

_HALVINGS = 3
"""How often a start is halved in search of one that crushes no spring."""


def posture(mechanism: Mechanism, start: Mapping[str, float] | None = None) -> NDArray[np.float64]:
    """Return a position in which the figure shows what each coordinate is, shape (nq,).

    Args:
        mechanism: what is drawn.
        start: values of coordinates; lengths and moderate angles are kept, and all values if there
            are loops to close and wheels touch. By default those of the catalogue for a system of
            it with loops, which may be stretched where all are zero.
    """
    if mechanism.constrained:
        from mecanique.reference import assemble

        start = _usual_start(mechanism) if start is None else start
        given = dict(start)
        for _ in range(_HALVINGS):
            with suppress(MecaniqueError):
                q = np.asarray(assemble(mechanism, given), dtype=np.float64)
                if not _crushes(mechanism, q):
                    return q
            given = {name: value / 2 for name, value in given.items()}
        with suppress(MecaniqueError):
            return np.asarray(assemble(mechanism, dict(start)), dtype=np.float64)
    q = mechanism.position(dict(start or {}))
    if mechanism.origin is not None and len(q) > MOST_TURNED:
        return q
    inside = {name for j in mechanism.joints if j.quaternion for name in j.coordinates}
    unit_of = units(mechanism)
    count = 0
    for k, name in enumerate(mechanism.coordinates):
        if name not in inside and unit_of[name] == "rad":
            if not SLIGHT <= abs(q[k]) <= GREAT:
                q[k] = math.copysign(ANGLES[count % len(ANGLES)], q[k])
            count += 1
    return q


def _usual_start(mechanism: Mechanism) -> Mapping[str, float]:
    """Where the motion of a system of the catalogue starts; nothing for any other."""
    from mecanique.textbook.catalogue import entry, is_known

    if not is_known(mechanism.name):
        return {}
    start = entry(mechanism.name).start
    return start if start.keys() <= set(mechanism.coordinates) else {}


def _crushes(mechanism: Mechanism, q: NDArray[np.float64]) -> bool:
    """Whether a spring between two points is shorter than half its free length."""
    from mecanique.reference import Reference

    reference = Reference.of(mechanism)
    for force in mechanism.forces:
        if isinstance(force, Spring):
            a, b = (
                reference.point(end.body, mechanism.evaluate_all(end.point), q).position
                for end in force.ends
            )
            if np.linalg.norm(b - a) < mechanism.evaluate(force.free_length) / 2:
                return True
    return False
