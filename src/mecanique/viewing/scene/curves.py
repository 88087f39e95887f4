"""The curves that the page plots: coordinates, their rates, energies and reactions over time."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mecanique.model.units import per_second, units
from mecanique.motion.record.motion import Motion
from mecanique.viewing.scene.scene import Series
from mecanique.viewing.scene.texts import letter

FEW_COORDINATES = 4
"""Up to this many are plotted when the page opens; of more, the energies are."""

MOST_JOINTS = 30
"""The reactions in further joints have no curves."""

ENERGIES = {"kinetic": "T", "potential": "V", "total": "T + V", "work": "work of forces"}
"""How each energy is written."""


def curves_of(motion: Motion, *, complete: bool = False) -> tuple[Series, ...]:
    """Return the curves of a motion.

    Args:
        motion: the `Motion`.
        complete: whether to keep reactions that are always zero.
    """
    few = len(motion.mechanism.coordinates) <= FEW_COORDINATES
    return (
        *_states(motion, shown=few),
        *_energies(motion, shown=not few),
        *_guide_forces(motion),
        *_reactions(motion, complete),
    )


def _states(motion: Motion, *, shown: bool) -> Iterator[Series]:
    unit = units(motion.mechanism)
    for name in motion.mechanism.coordinates:
        yield Series(name, letter(name), unit[name], motion[name], "Coordinates", shown=shown)
    for name in motion.mechanism.velocities:
        yield Series(name, letter(name), unit[name], motion[name], "Velocities")
    for k, name in enumerate(motion.mechanism.velocities):
        rate, size = f"{name}'", per_second(unit[name])
        yield Series(rate, letter(rate), size, motion.a[:, k], "Accelerations")


def _energies(motion: Motion, *, shown: bool) -> Iterator[Series]:
    energy = motion.energy()
    for name, label in ENERGIES.items():
        values = getattr(energy, name)
        plotted = shown and name != "work"
        yield Series(f"energy {name}", label, "J", values, "Energies", shown=plotted)


def _guide_forces(motion: Motion) -> Iterator[Series]:
    for name, force in motion.guide_forces().items():
        if np.isfinite(force).all():
            yield Series(name, name, "N", force, "Reactions")


def _reactions(motion: Motion, complete: bool) -> Iterator[Series]:
    if motion.mechanism.velocity_constraints:
        return
    for joint in motion.mechanism.joints[:MOST_JOINTS]:
        if joint.name in motion.reference.guided:
            continue
        wrench = motion.reactions(joint.name)
        for k, axis in enumerate("xyz"):
            for vector, sign, unit in ((wrench.force, "R", "N"), (wrench.moment, "M", "N·m")):
                if complete or np.abs(vector[:, k]).max() > 1e-9:
                    name = f"{joint.name} {sign}{axis}"
                    yield Series(name, name, unit, vector[:, k], "Reactions")
