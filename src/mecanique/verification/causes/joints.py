"""Mistakes in what acts in the joints, and in gravity."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from mecanique.arrays import Array
from mecanique.model.force_base import loads_in
from mecanique.model.joint_base import Single
from mecanique.verification.causes.change import Amount, Hypothesis, deviations, fit, give
from mecanique.verification.causes.evidence import Evidence

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
    if size:
        yield Hypothesis("gravity sign", "", "gravity pulls the other way", answers(-pull))
        yield Hypothesis("gravity direction", "", "gravity is left out", answers(np.zeros(3)))
    for axis, name in zip(np.eye(3), "xyz", strict=True):
        for sign, mark in ((1, "+"), (-1, "−")):
            g = sign * size * axis
            if size and not np.allclose(np.abs(g), np.abs(pull), rtol=0, atol=1e-9 * size):
                yield Hypothesis(
                    "gravity direction", "", f"gravity pulls along {mark}{name}", answers(g)
                )
    amounts, predicted = fit(evidence, pulls)
    fitted = np.where(
        np.abs(pull + amounts) > 1e-9 * np.linalg.norm(pull + amounts), pull + amounts, 0.0
    )
    plain = [np.zeros(3), -pull, *(sign * size * axis for axis in np.eye(3) for sign in (1, -1))]
    if size and any(np.allclose(fitted, known, rtol=0, atol=1e-9 * size) for known in plain):
        # it is one of those above
        return
    listed = ", ".join(f"{g:.6g}" for g in fitted)
    yield Hypothesis("gravity direction", "", f"gravity is ({listed}) m/s²", predicted, 3)


def _text(kind: str, where: str, amount: float, present: float, unit: str, sigma: float) -> str:
    if present and abs(amount + present) <= 1e-6 * abs(present):
        return f"the {kind} of {where} ({present:.6g} {unit}) is left out"
    return f"{kind} of {where}: {give(present + amount, sigma)} {unit} instead of {present:.6g}"
