"""What cannot be simulated is not derived: the same check, in the same words, by every method."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import mecanique as mq
from mecanique.derivation.methods import agreement
from mecanique.errors import DerivationError, EngineError, InputError
from mecanique.model import Cord, Gear, Pulley, Rack

HERE = (0.0, 0.0, 0.0)
ACROSS = (0.0, -1.0, 0.0)


def yo_yo(*ends: tuple[str, tuple[float, float, float]]) -> mq.Mechanism:
    """A drum that unwinds from a cord, which ends where it should not."""
    m, r = mq.Parameter("m", 0.2, "kg", "mass"), mq.Parameter("r", 0.02, "m", "radius")
    return mq.Mechanism(
        "yo_yo",
        (mq.Body("ground"), mq.Body("carrier"), mq.Body("drum", mq.disk(m, r))),
        (
            mq.Prismatic("fall", "ground", "carrier", axis=(0, 0, -1), coordinate="y"),
            mq.Revolute("spin", "carrier", "drum", axis=ACROSS, coordinate="phi"),
        ),
        elements=(Cord("cord", ends[0], (Pulley("drum", r),), ends[1]),),
        parameters=(m, r),
    )


def pair(other_radius: float) -> mq.Mechanism:
    """Two wheels 0.3 m apart."""
    wheels = (("a", 0.2, 0.0), ("b", 0.1, 0.3))
    return mq.Mechanism(
        "pair",
        (mq.Body("ground"), *(mq.Body(name, mq.disk(1.0, size)) for name, size, _ in wheels)),
        tuple(
            mq.Revolute(name.upper(), "ground", name, axis=ACROSS, origin=mq.Placement((far, 0, 0)))
            for name, _, far in wheels
        ),
        coordinates=mq.Coordinates((), {"B": -2 * mq.coordinate("A")}),
        elements=(Gear("mesh", "A", "B", 0.2, other_radius=other_radius),),
    )


def atwood(wheel: Pulley) -> mq.Mechanism:
    """Atwood's machine whose cord runs over a wheel that does not fit."""
    machine = mq.textbook.load("atwood_machine")
    cord = Cord("c", ("weight1", HERE), (wheel,), ("weight2", HERE))
    return replace(machine, elements=(cord,))


def rack() -> mq.Mechanism:
    """A pinion whose rack is not where its rim is."""
    machine = mq.textbook.load("rack_and_pinion")
    (mesh,) = machine.elements
    assert isinstance(mesh, Rack)
    return replace(machine, elements=(replace(mesh, radius=2 * mesh.radius),))


MISFITS = {
    "a cord that ends at the center of its drum": yo_yo(("ground", (0.02, 0, 0)), ("drum", HERE)),
    "a cord that ends on the carrier": yo_yo(("ground", (0.02, 0, 0)), ("carrier", HERE)),
    "a cord that begins too near": yo_yo(("ground", (0.01, 0, 0)), ("ground", (1.0, 0, 0))),
    "a wheel too large": atwood(Pulley("pulley", 5.0, -1)),
    "a wheel aside": atwood(Pulley("pulley", 0.2, -1, center=(0, 1, 0))),
    "a wheel too small": atwood(Pulley("pulley", 0.1, -1)),
    "a wheel run the other way": atwood(Pulley("pulley", 0.2, 1)),
    "wheels too small to touch": pair(other_radius=0.05),
    "a rack beside its pinion": rack(),
}
DOORS: dict[str, Callable[[mq.Mechanism], object]] = {
    "lagrange": lambda m: mq.derive(m, method="lagrange"),
    "newton_euler": lambda m: mq.derive(m, method="newton_euler"),
    "virtual_work": lambda m: mq.derive(m, method="virtual_work"),
    "agreement": agreement,
    "routh": mq.routh,
    "reduce_loops": mq.reduce_loops,
    "check": lambda m: mq.check(m, f"{m.velocities[0]}' = 0"),
}


@pytest.mark.parametrize("door", DOORS)
@pytest.mark.parametrize("name", MISFITS)
def test_what_cannot_be_simulated_is_not_derived(name: str, door: str) -> None:
    with pytest.raises(EngineError) as refused:
        mq.Reference(MISFITS[name])
    with pytest.raises(DerivationError) as derived:
        DOORS[door](MISFITS[name])
    assert str(derived.value) == str(refused.value)


def test_a_state_in_which_a_cord_does_not_run_is_refused_too() -> None:
    """The weight is pulled to the height of the axle: no straight run to the wheel is left."""
    machine = mq.textbook.load("atwood_machine")
    free = replace(machine, coordinates=replace(machine.coordinates, limits=()))
    equations = mq.derive(free, method="newton_euler")
    assert equations.guide_forces([0.0])["cord_1"] > 0
    with pytest.raises(EngineError, match="cord 'cord' has no straight run") as refused:
        mq.Reference(free).guide_forces([-1.0])
    with pytest.raises(DerivationError) as derived:
        equations.guide_forces(np.array([[0.0], [-1.0]]), np.zeros((2, 1)))
    assert str(derived.value) == str(refused.value)


@pytest.mark.parametrize("method", ["lagrange", "newton_euler", "virtual_work"])
@pytest.mark.parametrize("quantity", ["mass_matrix", "bias", "energy", "acceleration"])
def test_a_map_without_a_value_names_the_position_that_has_none(method: str, quantity: str) -> None:
    """z = √(1 - x²) y ends at x = 1; of three states the second is outside."""
    x, y = mq.coordinate("x"), mq.coordinate("y")
    particle = mq.Body("particle", mq.particle(1.0))
    mechanism = mq.Mechanism(
        "dome",
        (mq.Body("ground"), mq.Body("sled"), particle),
        (
            mq.Prismatic("X", "ground", "sled", axis=(1, 0, 0), coordinate="along"),
            mq.Prismatic("Z", "sled", "particle", axis=(0, 0, 1), coordinate="z"),
        ),
        coordinates=mq.Coordinates(("x", "y"), {"along": x, "z": mq.sqrt(1 - x**2) * y}),
    )
    q = np.array([[0.5, 1.0], [2.0, 3.0], [-0.5, 1.0]])
    ask = getattr(mq.derive(mechanism, method=method), quantity)
    given = (q,) if quantity == "mass_matrix" else (q, np.ones((3, 2)))
    with pytest.raises(InputError, match="gives no smooth 'z' at x = 2, y = 3; expected"):
        ask(*given)
