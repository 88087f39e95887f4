"""What the numbers of a sound mechanism keep to, stated once for Python and for pages."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from mecanique.model.expression import Scalar, plain, symbols_in
from mecanique.model.joint_base import Single
from mecanique.model.mechanism.description import Description
from mecanique.model.statements import NumberRule

MASS = "its mass is negative ({} kg)"
MOMENT = "its inertia has a negative principal moment ({} kg·m²)"
TRIANGLE = (
    "its principal moments break the triangle inequality ({} + {} < {} kg·m²): "
    "no mass is spread like that"
)


def rules_of(m: Description) -> Iterator[NumberRule]:
    """Yield what the parameters of a mechanism keep to, but for masses and inertias.

    Springs and dampers that would feed energy in are refused: write a Force for those.
    """
    for joint in m.joints:
        where = f"joint {joint.name!r}"
        yield from _finite(f"{where}: its origin", *joint.origin.xyz, *joint.origin.rpy)
        if isinstance(joint, Single):
            yield NumberRule(where, ": its armature is negative", gap=joint.armature, endless=True)
    yield from _finite("gravity", *m.gravity)
    for name, (lower, upper) in m.coordinates.intervals.items():
        where, words = f"coordinate {name!r}", ": its lower limit {} is not below its upper {}"
        width = plain(upper) - plain(lower)
        yield NumberRule(where, words, (lower, upper), width, strict=True, endless=True)
    for part in m.parts:
        yield from part.rules()
    # it would only come back as NaN
    for name, scalar in m.coordinates.driven.items():
        yield from _finite(f"the map of {name!r}", scalar)


def _finite(where: str, *scalars: Scalar) -> Iterator[NumberRule]:
    yield from (NumberRule(where, " is not finite", (scalar,)) for scalar in scalars)


def find_broken(rules: Iterable[NumberRule], values: Mapping[str, float]) -> list[str]:
    """Return the faults of rules, each once; what varies in a motion is not judged."""
    faults: list[str] = []
    fault = None
    for rule in rules:
        varies = any(not symbols_in(scalar) <= values.keys() for scalar in rule.scalars)
        if varies or (rule.follows and fault):
            continue
        fault = rule.fault(values)
        if fault and fault not in faults:
            faults.append(fault)
    return faults
