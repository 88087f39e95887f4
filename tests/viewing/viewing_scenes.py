"""Scenes made by hand, whose every number is known."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.special import ellipj, ellipk

from mecanique.viewing.page.page import page
from mecanique.viewing.scene.scene import (
    Arrow,
    DerivationStep,
    DrawnLine,
    JointMark,
    Knob,
    LedgerRow,
    Plot,
    Scene,
    SceneBody,
    SceneFrame,
    SceneShape,
    SceneText,
    ShownDerivation,
    Trace,
    VerdictTable,
    WorkLedger,
)

Floats = NDArray[np.float64]
GRAVITY = 9.81
LENGTH = 1.0
MASS = 2.0

EQUATION = (
    "<math><mrow><mover><mi>θ</mi><mo>¨</mo></mover><mo>+</mo><mfrac><mrow><mn>3</mn><mi>g</mi></mrow>"
    "<mrow><mn>2</mn><mi>l</mi></mrow></mfrac><mi>sin</mi><mo>⁡</mo><mi>θ</mi><mo>=</mo><mn>0</mn></mrow></math>"
)
ENERGY = (
    "<math><mrow><mi>L</mi><mo>=</mo><mfrac><mn>1</mn><mn>6</mn></mfrac><mi>m</mi><msup><mi>l</mi><mn>2</mn></msup>"
    "<msup><mover><mi>θ</mi><mo>˙</mo></mover><mn>2</mn></msup><mo>+</mo><mfrac><mn>1</mn><mn>2</mn></mfrac>"
    "<mi>m</mi><mi>g</mi><mi>l</mi><mi>cos</mi><mo>⁡</mo><mi>θ</mi></mrow></math>"
)


def swing(t: Floats, start: float) -> tuple[Floats, Floats, Floats]:
    """θ, its rate and acceleration for a rod let go at `start`: sin(θ/2) = k sn(K + ω t, k)."""
    omega, k = np.sqrt(1.5 * GRAVITY / LENGTH), np.sin(start / 2)
    sn, cn, dn, _ = ellipj(ellipk(k * k) + omega * t, k * k)
    theta = 2 * np.arcsin(k * sn)
    rate = 2 * k * omega * cn
    assert np.all(dn > 0)
    return theta, rate, -(omega**2) * np.sin(theta)


def about_y(theta: Floats) -> Floats:
    """Quaternions of turns by θ about −y."""
    zero = np.zeros_like(theta)
    return np.stack([zero, -np.sin(theta / 2), zero, np.cos(theta / 2)], axis=-1)


def raised(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Floats:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def reach(forces: Iterable[Floats]) -> float:
    """The force drawn 0.28 of the scene long: the largest, or 1.25 times the 90th percentile."""
    sizes = [np.sort(np.linalg.norm(force, axis=1)) for force in forces]
    return float(max(min(each[-1], 1.25 * each[int(0.9 * (len(each) - 1))]) for each in sizes))


def pendulum(
    duration: float = 4.0, fps: float = 60.0, title: str = "Rigid bar pendulum", body: str = "bar"
) -> Scene:
    """A uniform rod on a pin, let go at 2 rad."""
    t = np.linspace(0, duration, round(duration * fps) + 1)
    theta, rate, acceleration = swing(t, 2.0)
    out = np.stack([np.sin(theta), 0 * t, -np.cos(theta)], axis=1)
    along = np.stack([np.cos(theta), 0 * t, np.sin(theta)], axis=1)
    center = LENGTH / 2 * out
    a = LENGTH / 2 * (acceleration[:, None] * along - rate[:, None] ** 2 * out)
    weight = np.tile([0, 0, -MASS * GRAVITY], (len(t), 1))
    spin = MASS * LENGTH**2 / 12 * acceleration
    half = LENGTH / 2
    positions = np.zeros((len(t), 2, 3))
    quaternions = np.stack([about_y(0 * t), about_y(theta)], axis=1)
    ledger = WorkLedger(
        ("<mi>θ</mi>",),
        ("N·m",),
        (
            LedgerRow(
                "weight",
                "weight",
                "<mi>δ</mi><msub><mi>z</mi><mi>c</mi></msub>",
                np.sum(weight * along, 1)[:, None] * half,
            ),
            LedgerRow(
                "inertia",
                "inertia",
                "<mi>δ</mi><mi>θ</mi>",
                (-MASS * np.sum(a * along, 1) * half - spin)[:, None],
            ),
        ),
    )
    document = SceneText(
        subtitle="A uniform rod of mass m and length l, pinned at one end",
        derivations=(
            ShownDerivation(
                "Lagrange",
                (
                    DerivationStep("Lagrangian", ENERGY),
                    DerivationStep("Equation of motion", EQUATION, final=True),
                ),
            ),
            ShownDerivation(
                "Newton–Euler",
                (
                    DerivationStep(
                        "Moments about the pin", EQUATION, "The reaction has no arm.", True
                    ),
                ),
            ),
        ),
        verdict=VerdictTable(
            True,
            "The derivation agrees with the reference at 100 random states.",
            ("Quantity", "Worst relative difference"),
            (("mass matrix", "1.1e-16"), ("bias", "2.2e-16"), ("acceleration", "2.4e-16")),
            ("Seed 0; pinocchio 4.1.0",),
        ),
        parameters=(
            Knob("m", "<mi>m</mi>", MASS, "kg", "mass of the rod", 0.5, 8.0),
            Knob("l", "<mi>l</mi>", LENGTH, "m", "length of the rod", 0.2, 3.0),
        ),
        initial=(Knob("theta", "<mi>θ</mi>", 2.0, "rad", "angle from the vertical", -3.0, 3.0),),
        freedom=("1 coordinate, no constraint: 1 degree of freedom.",),
        ledger=ledger,
        urdf='<robot name="rigid_bar_pendulum">\n  <link name="bar"/>\n</robot>\n',
        file_name="rigid_bar_pendulum",
    )
    return Scene(
        title=title,
        t=t,
        bodies=(
            SceneBody(
                "ground",
                (SceneShape("box", (0.3, 0.2, 0.05), raised(z=0.045), (0.35, 0.38, 0.42, 1.0)),),
            ),
            SceneBody(
                body,
                (
                    SceneShape(
                        "box", (0.05, 0.03, LENGTH), raised(z=-half), (0.34, 0.63, 0.83, 1.0)
                    ),
                ),
            ),
        ),
        positions=positions,
        quaternions=quaternions,
        arrows=(
            Arrow("weight", "weight", body, center, weight),
            Arrow("pin", "reaction", body, np.zeros_like(center), MASS * a - weight),
            Arrow("inertia", "inertia", body, center, -MASS * a),
            Arrow(
                "inertia, moment",
                "inertia",
                body,
                center,
                np.stack([0 * t, spin, 0 * t], axis=1),
                "N·m",
            ),
        ),
        traces=(Trace("tip", LENGTH * out),),
        joints=(JointMark("pin", "revolute", body, (0, 0, 0), (0, -1, 0)),),
        series=(
            Plot("theta", "<mi>θ</mi>", "rad", theta, "Coordinates", shown=True),
            Plot(
                "theta rate",
                "<mover><mi>θ</mi><mo>˙</mo></mover>",
                "rad/s",
                rate,
                "Velocities",
                shown=True,
            ),
        ),
        document=document,
        planar=True,
    )


def blocks(duration: float = 6.0) -> Scene:
    """Two sliding blocks with springs and a damper: x1 and x2 are sums of cosines."""
    t = np.linspace(0, duration, round(duration * 60) + 1)
    x1 = 0.9 + 0.16 * np.cos(2.2 * t) + 0.07 * np.cos(5.1 * t)
    x2 = 2.0 + 0.26 * np.cos(2.2 * t) - 0.05 * np.cos(5.1 * t)
    zero = np.zeros_like(t)

    def at(x: Floats, z: float = 0.2) -> Floats:
        return np.stack([x, zero, zero + z], axis=1)

    positions = np.stack([at(zero, 0.0), at(x1), at(x2)], axis=1)
    quaternions = np.zeros((len(t), 3, 4))
    quaternions[..., 3] = 1
    wall, left, right = at(zero), at(x1 - 0.2), at(x1 + 0.2)
    force = np.stack([-40 * (x1 - 0.9), zero, zero], axis=1)
    pull = np.stack([30 * (x2 - x1 - 1.1), zero, zero], axis=1)
    blue, orange = (0.34, 0.63, 0.83, 1.0), (0.93, 0.68, 0.25, 1.0)
    grey = (0.45, 0.48, 0.52, 1.0)
    return Scene(
        title="Two blocks",
        t=t,
        bodies=(
            SceneBody("wall", (SceneShape("box", (0.08, 0.5, 0.6), raised(-0.04, 0, 0.3), grey),)),
            SceneBody("block 1", (SceneShape("box", (0.4, 0.4, 0.4), rgba=blue),)),
            SceneBody("block 2", (SceneShape("box", (0.4, 0.4, 0.4), rgba=orange),)),
        ),
        positions=positions,
        quaternions=quaternions,
        arrows=(
            Arrow("k1", "spring", "block 1", left, force),
            Arrow("k2 on 1", "spring", "block 1", right, pull),
            Arrow("k2 on 2", "spring", "block 2", at(x2 - 0.2), -pull),
            Arrow(
                "F",
                "load",
                "block 2",
                at(x2 + 0.2),
                np.stack([8 * np.cos(3 * t), zero, zero], axis=1),
            ),
            Arrow(
                "M", "load", "block 1", at(x1), np.stack([zero, 3 * np.cos(t), zero], axis=1), "N·m"
            ),
        ),
        lines=(
            DrawnLine("k1", "spring", np.stack([wall, left], axis=1)),
            DrawnLine("c1", "damper", np.stack([wall, left], axis=1)),
            DrawnLine("k2", "spring", np.stack([right, at(x2 - 0.2)], axis=1)),
        ),
        series=(
            Plot("x1", "x1", "m", x1, "Coordinates", True),
            Plot("x2", "x2", "m", x2, "Coordinates", True),
        ),
        planar=True,
        ground=0.0,
    )


def write_page(scene: Scene, path: Path) -> Path:
    path.write_text(page(scene), encoding="utf-8")
    return path


def instants(scene: Scene) -> Iterator[SceneFrame]:
    """Yield what a scene shows, instant by instant."""
    return (scene.frame(k) for k in range(len(scene.t)))


def swarm(bodies: int = 10, duration: float = 60.0, fps: float = 60.0) -> Scene:
    """Many bodies that swing and turn at their own rates, each with weight and reaction."""
    t = np.linspace(0, duration, round(duration * fps) + 1)
    rng = np.random.default_rng(0)
    rates = rng.uniform(2.0, 9.0, (bodies, 3))
    positions = np.stack(
        [0.6 * np.sin(rates[b] * t[:, None] + b) + [0.4 * b, 0, 0.5] for b in range(bodies)], axis=1
    )
    half = 0.9 * np.sin(rates[:, 0] * t[:, None]) + 0.5 * np.sin(rates[:, 1] * t[:, None])
    axis = rng.normal(size=(bodies, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    quaternions = np.concatenate([np.sin(half)[..., None] * axis, np.cos(half)[..., None]], axis=2)
    reaction = 20 * np.sin(rates[None] * t[:, None, None]) + 4 * np.cos(11.3 * t)[:, None, None]
    names = [f"body {b}" for b in range(bodies)]
    weight = np.tile([0, 0, -9.81], (len(t), 1))
    return Scene(
        title="Swarm",
        t=t,
        bodies=tuple(SceneBody(name, (SceneShape("cylinder", (0.05, 0.3)),)) for name in names),
        positions=positions,
        quaternions=quaternions,
        arrows=tuple(
            arrow
            for b, name in enumerate(names)
            for arrow in (
                Arrow(f"weight {b}", "weight", name, positions[:, b], weight),
                Arrow(f"reaction {b}", "reaction", name, positions[:, b], reaction[:, b]),
            )
        ),
        traces=(Trace("first", positions[:, 0]),),
        series=tuple(
            Plot(f"{what}{b}", f"{what}{b}", unit, values[:, b], group)
            for what, unit, group, values in (
                ("q", "rad", "Coordinates", half),
                ("v", "rad/s", "Velocities", np.gradient(half, t, axis=0)),
            )
            for b in range(bodies)
        ),
    )
