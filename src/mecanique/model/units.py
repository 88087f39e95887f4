"""SI units of coordinates and velocities, for headers and axes."""

from __future__ import annotations

from mecanique.model.expression import Scalar, symbols_in
from mecanique.model.joints import UNITS
from mecanique.model.mechanism import Mechanism

__all__ = ["labelled", "per_second", "units"]


def units(mechanism: Mechanism) -> dict[str, str]:
    """Return the unit of each coordinate and velocity, by name; "" where it is unknown.

    A generalized coordinate that is no joint's own has the unit of a joint coordinate that follows
    it by a pure number, or rad where it stands in an angle's place.
    """
    own: dict[str, str] = {}
    quasi: dict[str, str] = {}
    for joint in mechanism.joints:
        own |= zip(joint.coordinates, (UNITS[kind] for kind in joint.kinds), strict=True)
        if joint.quaternion:
            quasi |= dict.fromkeys(joint.linear_velocities, "m/s")
            quasi |= dict.fromkeys(joint.angular_velocities, "rad/s")
    for name in mechanism.coordinates:
        if name not in own:
            own[name] = _followed(mechanism, name, own)
    found = {name: own[name] for name in mechanism.coordinates}
    for name in mechanism.velocities:
        found[name] = quasi[name] if name in quasi else per_second(own[name[:-1]])
    return found


def per_second(unit: str) -> str:
    """Return the unit of a rate."""
    if not unit:
        return ""
    if unit == "1":
        return "1/s"
    return f"{unit[:-2]}/s²" if unit.endswith("/s") else f"{unit}/s"


def labelled(name: str, unit: str) -> str:
    """Return a name with its unit in brackets, if there is one."""
    return f"{name} [{unit}]" if unit else name


def _followed(mechanism: Mechanism, name: str, own: dict[str, str]) -> str:
    from sympy import Symbol

    symbol = Symbol(name)
    for follower, expression in mechanism.coordinates.driven.items():
        if name not in symbols_in(expression):
            continue
        if not symbols_in(slope := expression.diff(symbol)) and slope.is_number:
            return own[follower]
        if any(_turns(part, symbol) for part in expression.atoms(*_angles())):
            return "rad"
    return ""


def _angles() -> tuple[type, ...]:
    from sympy import cos, sin, tan

    return (sin, cos, tan)


def _turns(part: Scalar, symbol: Scalar) -> bool:
    """Whether a symbol stands in an angle's place by a pure number."""
    slope = part.args[0].diff(symbol)
    return bool(slope.is_number and slope != 0)
