"""What every symbol of a derivation means."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

from mecanique.derivation.scalars.series import Kind, Series
from mecanique.derivation.symbolic.derivation import Derivation
from mecanique.model.joints import Joint, Planar, Single, Universal
from mecanique.model.mechanism import Mechanism

__all__ = ["Meaning", "meanings"]

_PARTS = ("x component", "y component", "z component", "scalar part")


@final
@dataclass(frozen=True)
class Meaning:
    """The meaning of a symbol.

    Args:
        name: the symbol.
        sentence: what it is, with its unit.
        radicand: its square, if it is a square root.
    """

    name: str
    sentence: str
    radicand: Series | None = None


def meanings(derivation: Derivation) -> tuple[Meaning, ...]:
    """Return what every symbol in the steps and the equations means, in the order of a list."""
    ring, mechanism = derivation.algebra.ring, derivation.algebra.mechanism
    used = _collect_kinds(derivation)
    found = [*_coordinates(mechanism)]
    for parameter in mechanism.parameters:
        if parameter.symbol in used:
            sentence = _sentence(parameter.meaning or "parameter", parameter.unit)
            found.append(Meaning(parameter.symbol, sentence))
    for signal in mechanism.inputs:
        if signal.symbol in used:
            found.append(Meaning(signal.symbol, _sentence(signal.meaning or "input", signal.unit)))
    for index, atom in ring.atoms.items():
        name = ring.generators[index].name
        if atom.named and used.get(name) is Kind.ATOM:
            found.append(Meaning(name, derivation.lengths.get(name, "root"), atom.argument))
    found += [Meaning(name, sentence) for name, sentence in derivation.unknowns.items()]
    if used.get("t") is Kind.TIME:
        found.append(Meaning("t", "time [s]"))
    return tuple(found)


def _collect_kinds(derivation: Derivation) -> dict[str, Kind]:
    """The kind of every symbol in print, by its name."""
    shown = list(derivation.rows)
    for stage in derivation.stages:
        for result in stage.results:
            shown.append(result.right)
            if isinstance(result.left, Series):
                shown.append(result.left)
    return {g.name: g.kind for series in shown for g in series.generators()}


def _coordinates(mechanism: Mechanism) -> Iterator[Meaning]:
    own = {name: sentence for joint in mechanism.joints for name, sentence in _of_joint(joint)}
    for name in mechanism.coordinates:
        yield Meaning(name, own.get(name, "generalized coordinate"))
    for joint in mechanism.joints:
        if not joint.quaternion:
            continue
        for velocity in joint.velocities:
            linear = velocity in joint.linear_velocities
            what, unit = ("velocity", "m/s") if linear else ("angular velocity", "rad/s")
            of = f"the {what} of {joint.child}, in its own axes [{unit}]"
            yield Meaning(velocity, f"{velocity[-1]} component of {of}")


def _of_joint(joint: Joint) -> Iterator[tuple[str, str]]:
    """Name and meaning of each free coordinate of a joint."""
    names = [name for name in joint.coordinates if name not in joint.followers]
    match joint:
        case Single() if joint.turns:
            sentences = [f"angle of the {joint.noun} {joint.name}, about {_axis(joint)} [rad]"]
        case Single():
            sentences = [f"displacement in the {joint.noun} {joint.name}, along {_axis(joint)} [m]"]
        case Planar():
            sentences = [
                f"displacement of {joint.child} along {_along(axis, joint)} [m]"
                for axis in joint.directions
            ]
            sentences.append(f"angle of {joint.child} about {_axis(joint)} [rad]")
        case Universal():
            sentences = [
                f"angle of the Cardan joint {joint.name} about {axis} [rad]"
                for axis in ("x", "the turned y")
            ]
        case _:
            linear = zip("xyz", joint.linear_coordinates, strict=False)
            sentences = [f"{axis} coordinate of {joint.child} [m]" for axis, _ in linear]
            parts = zip(_PARTS, joint.quaternion, strict=False)
            sentences += [f"{part} of the unit quaternion of {joint.child}" for part, _ in parts]
    yield from zip(names, sentences, strict=True)


def _axis(joint: Single | Planar) -> str:
    return _along(joint.axis, joint)


def _along(axis: tuple[float, float, float], joint: Joint | Single) -> str:
    """An axis in words, e.g. −y of ground, or of the joint's frame if that is turned."""
    turned = any(not isinstance(angle, float) or angle for angle in joint.origin.rpy)
    of = f"the frame of joint {joint.name}" if turned else joint.parent
    for name, component in zip("xyz", axis, strict=True):
        if abs(component) > 1 - 1e-12:
            return f"{'-' if component < 0 else ''}{name} of {of}"
    return f"({', '.join(f'{component:.6g}' for component in axis)}) of {of}"


def _sentence(meaning: str, unit: str) -> str:
    return meaning if unit in ("", "1") else f"{meaning} [{unit}]"
