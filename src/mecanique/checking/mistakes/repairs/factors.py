"""Repair a letter, a number, a sine, a power or a sum within a term."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from mecanique.checking.mistakes.repairs.repair import ALIKE, SIMPLE, Part, Repair


def repair_number(part: Part) -> Iterator[Repair]:
    """Yield repairs of a number."""
    ratio = part.want
    spread = float(np.ptp(ratio))
    parent = part.tape.nodes[part.tape.parents[part.place]]
    if parent.kind == "power" or spread > ALIKE * float(np.abs(ratio).max()):
        return
    found = Fraction(float(ratio.mean())).limit_denominator(SIMPLE)
    if found and abs(float(found) / float(ratio.mean()) - 1) < ALIKE and not part.is_term:
        yield Repair("factor", f"the number '{part.quoted}' should be {found}", part.quoted, 1.6)


def repair_letter(part: Part) -> Iterator[Repair]:
    """Yield repairs of a letter: another one, its sine, a power."""
    name = part.node.name
    context = part.context
    for other, value in context.alternatives(name):
        if part.is_alike(value[part.usable]):
            angular = name in context.units
            kind = "letter" if angular else "angle"
            text = f"{part.here} {part.where}should be {other}"
            # a sum in place of a letter is a missing term
            yield Repair(kind, text, part.quoted, 2.05 if "+" in other else 1.3)
    if name in context.angles:
        for function, shape in (("sin", np.sin), ("tan", np.tan)):
            if part.is_alike(shape(part.have)):
                text = (
                    f"{part.here} {part.where}should be {function}({name}): the angle is "
                    "assumed to be small"
                )
                yield Repair("small angle", text, part.quoted, 1.0)
    if name in context.units or name in context.velocities or name in context.coordinates:
        for shown, value in (
            (f"{name}^2", part.have**2),
            (f"{name}^3", part.have**3),
            ("1", np.ones_like(part.have)),
        ):
            if part.is_alike(value):
                text = f"{part.here} {part.where}should be {shown}"
                yield Repair("power", text, part.quoted, 1.7)


def repair_circular(part: Part) -> Iterator[Repair]:
    """Yield repairs of a sine or cosine: the other one, another angle, none."""
    name, argument = part.node.name, part.node.parts[0]
    inner = part.values.parts[part.tape.parts[part.place][0]][part.usable]
    own, other = (np.sin, np.cos) if name == "sin" else (np.cos, np.sin)
    turned = "cos" if name == "sin" else "sin"
    for sign, words in ((1, ""), (-1, "−")):
        if part.is_alike(sign * other(inner)):
            text = f"'{part.quoted}' {part.where}should be {words}{turned}"
            yield Repair("sin for cos", text, part.quoted, 1.0 + 0.3 * (sign < 0))
    for formula, value in part.context.arguments.items():
        angle = value[part.usable]
        alike = bool((np.abs(angle - inner) <= ALIKE).all())
        if not alike and part.is_alike(own(angle)):
            text = (
                f"'{part.quoted}' {part.where}should be {name}({formula}): relative and "
                "absolute angles are mixed up"
            )
            yield Repair("angle", text, part.quoted, 1.2)
        elif not alike and part.is_alike(other(angle)):
            text = f"'{part.quoted}' {part.where}should be {turned}({formula})"
            yield Repair("angle", text, part.quoted, 2.2)
    if part.is_alike(np.ones_like(inner)) and argument.letters:
        text = f"the factor '{part.quoted}' does not belong {part.where or 'there'}"
        yield Repair("factor surplus", text, part.quoted, 2.0)


def repair_power(part: Part) -> Iterator[Repair]:
    """Yield repairs of a power: another exponent, a product of rates."""
    base = part.values.parts[part.tape.parts[part.place][0]][part.usable]
    for exponent in (1, 2, 3, 4, 0, -1):
        with np.errstate(all="ignore"):
            value = np.abs(base) ** exponent if exponent in (2, 4) else base**exponent
        if part.is_alike(np.asarray(value, dtype=float)):
            letter = part.node.parts[0]
            shown = " ".join(part.text[letter.start : letter.end].split())
            right = {0: "1", 1: shown}.get(exponent, f"{shown}^{exponent}")
            text = f"'{part.quoted}' {part.where}should be {right}"
            yield Repair("power", text, part.quoted, 1.5)
    exponent_node = part.node.parts[1]
    velocity = part.node.parts[0].name
    if velocity in part.context.velocities and exponent_node.value == 2:
        for other in part.context.velocities:
            product = part.context.values[other][part.usable] * base
            if other != velocity and part.is_alike(product):
                text = f"'{part.quoted}' {part.where}should be {velocity} {other}"
                yield Repair("angle", text, part.quoted, 1.4)


def repair_sum(part: Part) -> Iterator[Repair]:
    """Yield repairs of a sum: its sine, a letter that it lacks."""
    angular = part.node.letters and part.node.letters <= set(part.context.angles)
    if angular and part.is_alike(np.sin(part.have)):
        text = f"'{part.quoted}' should be its sine: the angle is assumed to be small"
        yield Repair("small angle", text, part.quoted, 1.0)
    short = part.want - part.have
    group = [name for name in part.node.letters if name in part.context.units]
    units = {part.context.units[name] for name in group}
    if len(units) == 1 and group and part.tape.parents[part.place] >= 0:
        for name, unit in part.context.units.items():
            value = part.context.values[name][part.usable]
            alike = (np.abs(short - value) <= ALIKE * np.abs(value)).all()
            if unit in units and alike:
                text = f"{name} is missing from the sum '{part.quoted}'"
                yield Repair("letter", text, part.quoted, 1.4)
