"""From a motion to its scene: bodies, springs, joints, traces and force arrows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from mecanique.figure.solids import FRONT, cord_stretches, moves_parallel
from mecanique.model import Contact, Mechanism
from mecanique.model.constraint_base import PressingContact, Striking
from mecanique.model.force_base import End
from mecanique.model.mechanism_units import per_second, units
from mecanique.model.placement import is_zero, pose_at
from mecanique.model.quaternions import from_matrices
from mecanique.motion.analysis.forces import Action, Actions
from mecanique.motion.motion import Motion
from mecanique.motion.record.events import Occurrence, break_names
from mecanique.viewing.scene.drawn import (
    bodies_of,
    marks_of,
    name_arrows,
    spans_of,
    tips_of,
    title_of,
)
from mecanique.viewing.scene.scene import (
    Arrow,
    Break,
    DrawnLine,
    Floats,
    ModeStrip,
    Plot,
    Scene,
    SceneBody,
    SceneShape,
    SceneText,
    Trace,
)
from mecanique.viewing.scene.texts import letter

PLANE_MARGIN, PLANE_THICKNESS = 0.15, 0.2
"""How far a plane is drawn beyond what touches it, as a part of the motion's extent, and how thick,
as a part of that margin."""

FEW_COORDINATES = 4
"""Up to this many are plotted when the page opens; of more, the energies are."""

MOST_JOINTS = 30
"""The reactions in further joints have no curves."""

ENERGIES = {"kinetic": "T", "potential": "V", "total": "T + V", "work": "work of forces"}
"""How each energy is written."""

LOST = "energy lost, "
"""What the name of a curve of energy lost by friction or impacts begins with."""


def curves_of(motion: Motion) -> tuple[Plot, ...]:
    """Return the curves of a motion."""
    few = len(motion.mechanism.coordinates) <= FEW_COORDINATES
    return (
        *_states(motion, shown=few),
        *_energies(motion, shown=not few),
        *(
            Plot(name, name, "N", force, "Reactions")
            for name, force in motion.guide_forces().items()
            if np.isfinite(force).all()
        ),
        *_reactions(motion),
    )


def _states(motion: Motion, *, shown: bool) -> Iterator[Plot]:
    mechanism = motion.mechanism
    unit = units(mechanism)
    for name in mechanism.coordinates:
        symbol = letter(name, mechanism)
        yield Plot(name, symbol, unit[name], motion[name], "Coordinates", shown=shown)
    for name in mechanism.velocities:
        yield Plot(name, letter(name, mechanism), unit[name], motion[name], "Velocities")
    for k, name in enumerate(mechanism.velocities):
        rate, size = f"{name}'", per_second(unit[name])
        yield Plot(rate, letter(rate, mechanism), size, motion.a[:, k], "Accelerations")


def _energies(motion: Motion, *, shown: bool) -> Iterator[Plot]:
    energy = motion.energy()
    for name, label in ENERGIES.items():
        values = getattr(energy, name)
        plotted = shown and name != "work"
        yield Plot(f"energy {name}", label, "J", values, "Energies", shown=plotted)
    if motion.corners is not None:
        for name, lost in losses_of(motion).items():
            yield Plot(f"{LOST}{name}", explain_loss(name), "J", lost, "Energies", shown=shown)


def losses_of(motion: Motion) -> dict[str, Floats]:
    """Return what friction and impacts took, also of elements that may be struck but were not."""
    losses = motion.losses()
    struck = {name for loss in losses for name in loss.removesuffix(": impact").split(", ")}
    for element in motion.described.switching:
        elastic = getattr(element, "stiffness", None) is not None
        if isinstance(element, Striking) and not elastic and element.name not in struck:
            losses[f"{element.name}: impact"] = np.zeros(len(motion.t))
    return losses


def explain_loss(name: str) -> str:
    """Return what took an energy, in words, from its name in `Motion.losses`."""
    element, _, what = name.rpartition(": ")
    words = "heat of friction" if what == "friction" else f"lost by {what}"
    return f"{words}, {element}"


def _reactions(motion: Motion) -> Iterator[Plot]:
    if motion.mechanism.velocity_constraints:
        return
    for joint in motion.mechanism.joints[:MOST_JOINTS]:
        if joint.name in motion.reference.guided:
            continue
        wrench = motion.reactions(joint.name)
        for k, axis in enumerate("xyz"):
            for vector, sign, unit in ((wrench.force, "R", "N"), (wrench.moment, "M", "N·m")):
                name = f"{joint.name} {sign}{axis}"
                yield Plot(name, name, unit, vector[:, k], "Reactions")


MOST_ARROWS = 120
"""More forces than this are not drawn: the page would be neither legible nor light."""


def scene_of(
    motion: Motion,
    document: SceneText | None = None,
    actions: Sequence[Action] | None = None,
) -> Scene:
    """Return the scene of a motion, with forces and reactions that are always zero, too."""
    mechanism: Mechanism = motion.mechanism
    poses: Floats = motion.poses()
    at = {body.name: k for k, body in enumerate(mechanism.bodies)}
    shown = actions_of(motion) if actions is None else actions
    return Scene(
        title=title_of(mechanism),
        t=motion.t,
        bodies=tuple(_furnish(motion.described, poses, at)),
        positions=poses[:, :, :3, 3],
        quaternions=from_matrices(poses[:, :, :3, :3]),
        arrows=tuple(_arrows(shown)),
        lines=(*_lines(motion.described, poses, at), *_cords(motion)),
        traces=tuple(
            Trace(f"path of {tip.body}", _follow(mechanism, poses, at, tip))
            for tip in tips_of(mechanism)
        ),
        joints=marks_of(mechanism, poses.mean(axis=0)),
        series=curves_of(motion),
        document=SceneText() if document is None else document,
        planar=_planar(poses) and moves_parallel(mechanism, poses[0], FRONT[2]),
        breaks=tuple(_breaks(motion)),
        modes=tuple(_strips(motion)),
    )


def _furnish(mechanism: Mechanism, poses: Floats, at: dict[str, int]) -> Iterator[SceneBody]:
    """Yield the bodies as they are drawn, those without a shape with the planes that they bear."""
    places = {body.name: poses[:, k] for body, k in zip(mechanism.bodies, at.values(), strict=True)}
    margin = PLANE_MARGIN * float(np.ptp(poses[:, :, :3, 3], axis=(0, 1)).max())
    for body in bodies_of(mechanism):
        spans: dict[tuple[float, ...], list[Floats]] = {}
        for contact in (*mechanism.contacts, *mechanism.switching) if not body.shapes else ():
            if not isinstance(contact, Contact | PressingContact) or contact.on != body.name:
                continue
            if not is_zero(contact.bowl):
                continue
            frame = mechanism.matrix(contact.plane)
            center = np.append(mechanism.evaluate_all(contact.center), 1.0)
            paths = np.linalg.inv(places[body.name] @ frame) @ places[contact.body] @ center
            beyond = margin + 2.0 * mechanism.evaluate(contact.radius)
            reach = np.stack([paths[:, :2].min(axis=0) - beyond, paths[:, :2].max(axis=0) + beyond])
            if isinstance(contact, Contact) and contact.ends:
                half = mechanism.evaluate(contact.length) / 2
                reach[:, 0] = reach[:, 0].clip(-half, half)
            spans.setdefault(tuple(frame.ravel().tolist()), []).append(reach)
        shapes = list(body.shapes)
        for numbers, reaches in spans.items():
            low, high = np.min(reaches, axis=(0, 1)), np.max(reaches, axis=(0, 1))
            thick = PLANE_THICKNESS * margin
            pose = np.reshape(numbers, (4, 4)) @ pose_at([*(low + high) / 2, -thick / 2])
            shapes.append(SceneShape("box", (*(high - low), thick), pose))
        yield replace(body, shapes=tuple(shapes))


def _breaks(motion: Motion) -> Iterator[Break]:
    """Where contacts and cords ceased to hold."""
    names = break_names(motion.mechanism)
    for event in motion.events:
        if event.name in names:
            yield Break(event.name, float(event.t))


def _strips(motion: Motion) -> Iterator[ModeStrip]:
    """The states of each element that switches."""
    for element in motion.described.switching if motion.modes else ():
        spans: list[tuple[float, float, str]] = []
        for mode in motion.modes:
            state = mode.states[element.name]
            begin = mode.begin
            if spans and spans[-1][2] == state:
                begin = spans.pop()[0]
            spans.append((begin, mode.end, state))
        struck = [event.t for event in motion.events if _strikes(event, element.name)]
        yield ModeStrip(element.name, tuple(spans), tuple(struck))


def _strikes(event: Occurrence, name: str) -> bool:
    """Return whether an event is an impact in which an element takes part."""
    together, _, what = event.name.rpartition(": ")
    return what == "impact" and name in together.split(", ")


def actions_of(motion: Motion) -> tuple[Action, ...]:
    """Return the forces on the moving bodies along a motion; none if they are too many to draw."""
    mechanism: Mechanism = motion.mechanism
    if 2 * len(mechanism.joints) + len(mechanism.forces) + 2 * len(mechanism.bodies) > MOST_ARROWS:
        return ()
    every = Actions(mechanism, motion.reference).all(motion.t, motion.q, motion.v, motion.a)
    return tuple(action for action in every if action.body != mechanism.ground)


def _planar(poses: Floats) -> bool:
    """Whether everything moves parallel to the x-z plane."""
    scale = float(np.ptp(poses[:, :, :3, 3], axis=(0, 1)).max()) or 1.0
    sideways = float(np.ptp(poses[:, :, 1, 3], axis=0).max(initial=0.0))
    turned = float(np.ptp(poses[:, :, :3, 1], axis=0).max(initial=0.0))
    return sideways < 1e-9 * scale and turned < 1e-9


def _arrows(actions: Sequence[Action]) -> Iterator[Arrow]:
    for name, action, unit in name_arrows(actions):
        vector = action.force if unit == "N" else action.moment
        yield Arrow(
            name=name,
            kind=action.kind,
            body=action.body,
            origin=action.origin,
            vector=vector,
            unit=unit,
        )


def _lines(mechanism: Mechanism, poses: Floats, at: dict[str, int]) -> Iterator[DrawnLine]:
    for span in spans_of(mechanism):
        points = [_follow(mechanism, poses, at, end) for end in span.ends]
        yield DrawnLine(span.name, span.kind, np.stack(points, axis=1))


def _follow(mechanism: Mechanism, poses: Floats, at: dict[str, int], end: End) -> Floats:
    """A point of a body along the motion."""
    pose = poses[:, at[end.body]]
    turned = pose[:, :3, :3] @ np.array(mechanism.evaluate_all(end.point))
    return np.asarray(pose[:, :3, 3] + turned)


def _cords(motion: Motion) -> Iterator[DrawnLine]:
    """The stretches of cords, from one touch to the next."""
    state = motion.q, motion.v, motion.t
    for k, ends in enumerate(cord_stretches(motion.mechanism, motion.reference, *state)):
        yield DrawnLine(f"stretch {k + 1}", "rod", np.stack(ends, axis=1))


FAINT = 1e-6
"""A force below this fraction of the largest of its kind does not enter a scene being shown."""


def names_of(scene: Scene) -> frozenset[str]:
    """Return the arrows and reactions of a scene that are not always zero."""
    sizes: dict[str, tuple[str, float]] = {
        f"arrow {a.name}": (a.unit, float(np.abs(a.vector).max(initial=0.0))) for a in scene.arrows
    }
    sizes |= {
        f"series {s.name}": (s.unit, float(np.abs(s.values).max(initial=0.0)))
        for s in scene.series
        if s.group == "Reactions"
    }
    largest: dict[str, float] = {}
    for unit, size in sizes.values():
        largest[unit] = max(largest.get(unit, 0.0), size)
    return frozenset(
        name for name, (unit, size) in sizes.items() if size > max(1e-9, FAINT * largest[unit])
    )


def fit(scene: Scene, names: frozenset[str]) -> Scene:
    """Return a complete scene with only these arrows and reactions."""
    return replace(
        scene,
        arrows=tuple(a for a in scene.arrows if f"arrow {a.name}" in names),
        series=tuple(
            s for s in scene.series if s.group != "Reactions" or f"series {s.name}" in names
        ),
    )
