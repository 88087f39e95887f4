"""Kinematics alone, of robots without mass: poses, Jacobians and loops against the engine."""

from __future__ import annotations

import numpy as np

from mecanique.arrays import Array
from mecanique.derivation.numeric.constraints.rows import Held
from mecanique.derivation.numeric.lagrange import LagrangeOnJets
from mecanique.derivation.scalars.jets import Jet
from mecanique.derivation.tree.links import links, place_of
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import characteristic_length
from mecanique.model.states import States
from mecanique.reference import Reference
from mecanique.reference.engine.package import engine_name
from mecanique.verification.states import random_states
from mecanique.verification.verdict import TOLERANCE, Row, Verdict, conclude
from mecanique.wording import OF_SHAPES

WAY_OUT = f"give its bodies mass and inertia: {OF_SHAPES}"
"""What to do about a robot without mass."""

_NOTE = (
    f"kinematics alone: nothing that moves has mass, so it has no equations of motion; {WAY_OUT}"
)


def has_mass(mechanism: Mechanism) -> bool:
    """Whether anything that moves has mass, inertia or a rotor."""
    moving = (body for body in mechanism.bodies if body.name != mechanism.ground)
    if any(any(mechanism.evaluate_all((body.mass, *body.inertia))) for body in moving):
        return True
    rotors = (getattr(joint, "armature", 0.0) for joint in mechanism.joints)
    return any(map(mechanism.evaluate, rotors))


def compare_kinematics(
    mechanism: Mechanism, samples: int, seed: int, tolerance: float = TOLERANCE
) -> Verdict:
    """Compare poses and Jacobians of all bodies, and gaps and Jacobians of loops, with the engine.

    The in-house Jacobian is the derivative of the poses themselves, on jets.
    """
    states = random_states(mechanism, samples, seed)
    engine, length = Reference.of(mechanism), characteristic_length(mechanism)
    _, poses = LagrangeOnJets(mechanism).motion(states, np.zeros_like(states.v))
    place = place_of(links(mechanism), mechanism)
    bodies = [body.name for body in mechanism.bodies if body.name != mechanism.ground]
    ours = {name: poses[place[name]] for name in bodies}
    theirs = np.asarray(engine.poses(states.q, states.t))
    index = {body.name: k for k, body in enumerate(mechanism.bodies)}
    pairs = {
        "poses": [
            (_by_length(ours[name].value, length), _by_length(theirs[:, index[name]], length))
            for name in bodies
        ],
        "Jacobians": [
            (_scale(_jacobian(ours[name]), length), _scale(given, length))
            for name in bodies
            for given in [np.asarray(engine.jacobian(name, states.q, states.t))]
        ],
    }
    if mechanism.loops and not mechanism.contacts:
        held = Held(mechanism)
        here, units = held.at(states), held.row_units.units
        residual = np.asarray(engine.constraint_residual(states.q, states.t))
        J = np.asarray(engine.constraint_jacobian(states.q, states.t))
        pairs["gaps of loops"] = [(here.residual / units, residual / units)]
        pairs["Jacobians of loops"] = [(here.jacobian / units[:, None], J / units[:, None])]
    rows = [
        _row(quantity, both, states, tolerance, bodies) for quantity, both in pairs.items() if both
    ]
    return conclude(mechanism, rows, len(states), seed, tolerance, notes=(_NOTE,))


def _row(
    quantity: str,
    pairs: list[tuple[Array, Array]],
    states: States,
    tolerance: float,
    bodies: list[str],
) -> Row:
    """Compare arrays whose first index is the state; relative to 1 or the largest entry there."""
    n = len(states)
    off = np.array(
        [
            np.abs(a - b).reshape(n, -1).max(axis=1, initial=0.0)
            / np.maximum(1.0, np.abs(b).reshape(n, -1).max(axis=1, initial=0.0))
            for a, b in pairs
        ]
    )
    body, state = np.unravel_index(int(np.argmax(off)), off.shape)
    entry = (bodies[int(body)],) if len(pairs) == len(bodies) and "loops" not in quantity else ()
    return Row(
        quantity,
        ("jets", engine_name()),
        float(off[body, state]),
        tuple(states.q[state].tolist()),
        tuple(states.v[state].tolist()),
        float(states.t[state]),
        entry=entry,
        tolerance=tolerance,
    )


def _by_length(poses: Array, length: float) -> Array:
    scaled: Array = poses.copy()
    scaled[..., :3, 3] /= length
    return scaled


def _scale(jacobian: Array, length: float) -> Array:
    """Give the rows of velocities the characteristic length as their unit."""
    scaled: Array = jacobian.copy()
    scaled[:, :3] /= length
    return scaled


def _jacobian(pose: Jet) -> Array:
    """The Jacobian of a pose, shape (n, 6, nv): velocity of its origin, then δR Rᵀ as a vector."""
    value, varied = pose.c[0, 0], pose.c[0, 1:]
    spin = varied[..., :3, :3] @ np.swapaxes(value[..., :3, :3], -1, -2)
    turns = [spin[..., 2, 1], spin[..., 0, 2], spin[..., 1, 0]]
    columns = np.stack([*np.moveaxis(varied[..., :3, 3], -1, 0), *turns])
    return np.moveaxis(columns, 2, 0)
