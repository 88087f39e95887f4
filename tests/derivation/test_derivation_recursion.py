"""The recursion against Lagrange's operator on jets and the identities of mechanics."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from derivation_samples import SAMPLES, sample, states
from systems import FREE

from mecanique import textbook
from mecanique.derivation.mechanics import vectors
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.recursion import recursion_on_tape
from mecanique.derivation.numeric import newton_euler
from mecanique.derivation.numeric.lagrange import LagrangeOnJets
from mecanique.derivation.numeric.newton_euler import Balances
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.errors import DerivationError
from mecanique.model import (
    Body,
    Coordinates,
    Input,
    JointSpring,
    Mechanism,
    Prismatic,
    Revolute,
    Spring,
    box,
    coordinate,
)
from mecanique.model.joints import Floating, Spherical
from mecanique.model.placement import Placement
from mecanique.model.placement import rpy_rotation as rotation_by_angles
from mecanique.model.states import States


def difference(a: np.ndarray, b: np.ndarray) -> float:
    """Return the largest difference, relative to the largest number."""
    return float(np.abs(a - b).max() / max(1e-300, np.abs(b).max()))


@pytest.mark.parametrize("name", SAMPLES)
@pytest.mark.parametrize("quantity", ["mass_matrix", "bias", "forces", "acceleration"])
def test_recursion_is_the_definition(name: str, quantity: str) -> None:
    mechanism = sample(name)
    some = states(mechanism, 5)
    fast: Callable[[States], np.ndarray] = getattr(Recursion(mechanism), quantity)
    exact: Callable[[States], np.ndarray] = getattr(LagrangeOnJets(mechanism), quantity)
    assert difference(fast(some), exact(some)) < 1e-12


@pytest.mark.parametrize("name", SAMPLES)
def test_energies_agree(name: str) -> None:
    mechanism = sample(name)
    some = states(mechanism, 5)
    for fast, exact in zip(
        Recursion(mechanism).energy(some), LagrangeOnJets(mechanism).energy(some), strict=True
    ):
        assert difference(fast, exact) < 1e-12


@pytest.mark.parametrize("name", FREE)
def test_textbook_systems_agree(name: str) -> None:
    mechanism = textbook.load(name)
    some = near_start(mechanism, name, 3)
    fast, exact = Recursion(mechanism), LagrangeOnJets(mechanism)
    scale = max(1.0, float(np.abs(exact.mass_matrix(some)).max()))
    for quantity in ("mass_matrix", "bias", "forces"):
        a, b = getattr(fast, quantity)(some), getattr(exact, quantity)(some)
        assert np.abs(a - b).max() <= 1e-12 * max(scale, np.abs(b).max()), quantity


def near_start(mechanism: Mechanism, name: str, n: int) -> States:
    """Return random states around the start of the system's motion, where coordinates are valid."""
    rng = np.random.default_rng(3)
    start = mechanism.position(textbook.entry(name).start)
    q = start + 0.05 * rng.normal(size=(n, mechanism.nq))
    return States.of(mechanism, q, rng.normal(size=(n, mechanism.nv)), rng.normal(size=n))


@pytest.mark.parametrize("name", SAMPLES)
def test_mass_matrix_is_symmetric_and_positive(name: str) -> None:
    mechanism = sample(name)
    M = Recursion(mechanism).mass_matrix(states(mechanism, 20))
    assert difference(np.swapaxes(M, -1, -2), M) < 1e-15
    assert np.linalg.eigvalsh(M).min() > 0


def moved(some: States, h: float) -> States:
    """Return the states a time h later if they keep their velocities, for central differences."""
    q = some.q.copy()
    m = some.mechanism
    for joint in m.joints:
        names = [name for name in joint.coordinates if name in m.coordinates]
        at = [m.coordinates.index(name) for name in names]
        if isinstance(joint, (Spherical, Floating)):
            v = some.v[:, [m.velocities.index(name) for name in joint.velocities]]
            x, y, z, w = q[:, at[-4:]].T
            wx, wy, wz = v[:, -3:].T
            # the exact turn by ω h: q ⊗ (sin(|ω| h / 2) ω / |ω|, cos(|ω| h / 2))
            size = np.linalg.norm(v[:, -3:], axis=1)
            s, c = h / 2 * np.sinc(size * h / (2 * np.pi)), np.cos(size * h / 2)
            px, py, pz, pw = s * wx, s * wy, s * wz, c
            turned = (
                w * px + x * pw + y * pz - z * py,
                w * py + y * pw + z * px - x * pz,
                w * pz + z * pw + x * py - y * px,
                w * pw - x * px - y * py - z * pz,
            )
            if isinstance(joint, Floating):
                R = rotation(x, y, z, w)
                q[:, at[:3]] += h * np.einsum("nij,nj->ni", R, v[:, :3])
            q[:, at[-4:]] = np.stack(turned, axis=1)
    inside = {n for j in m.joints if isinstance(j, (Spherical, Floating)) for n in j.coordinates}
    for k, name in enumerate(m.coordinates):
        if name not in inside:
            q[:, k] += h * some.v[:, m.velocities.index(f"{name}'")]
    return States.of(m, q, some.v, some.t)


def rotation(x: np.ndarray, y: np.ndarray, z: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Return rotation matrices of unit quaternions."""
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.asarray(np.moveaxis(np.array(rows), -1, 0))


@pytest.mark.parametrize("name", ["everything", "planar", "double_pendulum", "furuta_pendulum"])
def test_bias_does_the_work_that_energy_loses(name: str) -> None:
    """v·bias = d/dt (T + V_gravity) without acceleration: the power balance, Ṁ − 2 C skew."""
    mechanism = sample(name) if name in SAMPLES else textbook.load(name)
    mechanism = replace(mechanism, forces=())
    some, h = states(mechanism, 4), 1e-5
    recursion = Recursion(mechanism)
    later, sooner = (sum(recursion.energy(moved(some, step))) for step in (h, -h))
    power = np.sum(some.v * recursion.bias(some), axis=1)
    np.testing.assert_allclose(
        power, (later - sooner) / (2 * h), rtol=1e-7, atol=1e-7 * np.abs(power).max()
    )


@pytest.mark.parametrize("name", ["everything", "planar", "coupled_pendulums"])
def test_gravity_and_springs_are_slopes_of_the_potential_energy(name: str) -> None:
    mechanism = sample(name) if name in SAMPLES else textbook.load(name)
    springs = tuple(force for force in mechanism.forces if isinstance(force, (Spring, JointSpring)))
    mechanism = replace(mechanism, forces=springs)
    here, h = states(mechanism, 3), 1e-5
    recursion = Recursion(mechanism)
    at_rest = States.of(mechanism, here.q, np.zeros_like(here.v), here.t)
    slope = recursion.bias(at_rest) - recursion.forces(at_rest)
    for k in range(mechanism.nv):
        along = States.of(mechanism, here.q, np.tile(np.eye(mechanism.nv)[k], (3, 1)), here.t)
        later, sooner = (recursion.energy(moved(along, step))[1] for step in (h, -h))
        np.testing.assert_allclose(
            slope[:, k], (later - sooner) / (2 * h), rtol=1e-7, atol=1e-7 * np.abs(slope).max()
        )


def test_a_massless_motion_is_refused() -> None:
    nothing = Mechanism(
        "nothing", (Body("ground"), Body("arm")), (Revolute("pin", "ground", "arm"),)
    )
    with pytest.raises(
        DerivationError, match=r"'nothing': its mass matrix is singular.*give what it moves mass"
    ):
        Recursion(nothing).acceleration(states(nothing, 1))


def test_gravity_may_be_varied_as_a_whole_or_state_by_state() -> None:
    mechanism = sample("everything")
    some, g = states(mechanism, 4), np.array([0.3, -0.5, 1.6])
    expected = Recursion(replace(mechanism, gravity=tuple(g.tolist()))).bias(some)
    for gravity in (g, np.tile(g, (4, 1))):
        np.testing.assert_allclose(
            Recursion(mechanism).vary(gravity=gravity).bias(some), expected, rtol=1e-14, atol=0
        )


@pytest.mark.parametrize("name", ["driven", "everything"])
def test_torques_that_are_given_do_their_virtual_work(name: str) -> None:
    """On coordinates that are no joint's, by the least torques in the joints that do the same."""
    mechanism, free = sample(name), states(sample(name), 4)
    tau = np.random.default_rng(5).normal(size=(4, mechanism.nv))
    loaded = States.of(mechanism, free.q, free.v, free.t, tau=tau)
    for method in (Recursion(mechanism), Balances(mechanism)):
        pushed = method.forces(loaded) - method.forces(free)
        np.testing.assert_allclose(pushed, tau, rtol=0, atol=1e-11)
    recursion = Recursion(mechanism)
    chart = recursion.place(loaded).chart
    in_joints = recursion.efforts_in_joints(loaded, chart)
    assert in_joints is not None
    if name == "driven":
        G = np.moveaxis(np.broadcast_to(chart.G, (*np.shape(chart.G)[:2], 4)), -1, 0)
        for rates, push in zip(G, in_joints.T, strict=True):
            least = rates @ np.linalg.lstsq(rates, push, rcond=None)[0]
            np.testing.assert_allclose(least, push, rtol=0, atol=1e-12)


def test_an_input_without_known_rates_drives_no_coordinate_on_a_tape() -> None:
    """An expression in t does, a function of Python does not."""
    wave = Input("u", lambda t: float(np.sin(t)))
    driven = Coordinates((), {"x": coordinate("u")})
    mechanism = Mechanism(
        "shaker",
        (Body("ground"), Body("table", box(1.0, (1, 1, 1)))),
        (Prismatic("slide", "ground", "table", axis=(1, 0, 0), coordinate="x"),),
        inputs=(wave,),
        coordinates=driven,
    )
    message = "the map of coordinate 'x' depends on input 'u', whose rates are not known"
    with pytest.raises(DerivationError, match=message):
        recursion_on_tape(Letters(mechanism))


@pytest.mark.parametrize("joint", [Revolute, Prismatic])
def test_a_turned_axis_is_that_of_another_joint(joint: type[Revolute | Prismatic]) -> None:
    block = box(2.0, (0.3, 0.2, 0.5)).at((0.1, 0.2, -0.3))
    bodies = (Body("ground"), Body("a", block), Body("b", block))
    R = np.array(rotation_by_angles((0.3, -0.7, 1.1)), dtype=float)

    def arm(axis: tuple[float, float, float]) -> Mechanism:
        joints = (
            joint(
                "first", "ground", "a", axis=axis, coordinate="x", origin=Placement((0.1, 0.0, 0.4))
            ),
            Revolute(
                "second",
                "a",
                "b",
                axis=(0, 1, 0),
                coordinate="y",
                origin=Placement((0.5, 0.1, 0.0)),
            ),
        )
        return Mechanism("arm", bodies, joints, gravity=(0.0, 0.0, -9.81))

    plain, turned = arm((1, 0, 0)), Recursion(arm((R[0, 0], R[1, 0], R[2, 0])))
    some, Q = states(plain, 3), np.eye(4)
    Q[:3, :3] = R
    a = np.random.default_rng(5).normal(size=some.v.shape)
    for turn in (Q, np.tile(Q, (3, 1, 1))):
        varied = Recursion(plain).vary(turns={0: turn})
        assert difference(varied.mass_matrix(some), turned.mass_matrix(some)) < 1e-14
        assert difference(varied.bias(some), turned.bias(some)) < 1e-14
        assert difference(varied.regressor(some, a), turned.regressor(some, a)) < 1e-14
        # what is varied again keeps the turn
        again = varied.vary(moments=dict(enumerate(varied.moments)))
        assert difference(again.bias(some), turned.bias(some)) < 1e-14


def test_scalars_and_arrays_have_the_same_laws_of_turning_bodies() -> None:
    """Energy, angular momentum and axial vectors, of arrays over states and of plain numbers."""
    random = np.random.default_rng(4)
    w, alpha = random.normal(size=(2, 3))
    E = random.normal(size=(3, 3))
    E = E + E.T
    U = np.cross(np.eye(3), -alpha).T + np.outer(w, w) - w @ w * np.eye(3)
    for of_plain, of_arrays, by_hand in (
        (
            vectors.turning_energy([*w], E.tolist(), 0.7),
            vectors.turning_energy(w[:, None], E[..., None], 0.7),
            w @ (np.trace(E) * np.eye(3) - E) @ w + 1.4,
        ),
        (
            vectors.turning_momentum([*w], E.tolist()),
            vectors.turning_momentum(w[:, None], E[..., None]),
            np.trace(E) * w - E @ w,
        ),
        (
            vectors.acceleration_field([*w], [*alpha]),
            vectors.acceleration_field(w[:, None], alpha[:, None]),
            U,
        ),
        (
            vectors.axial(U.tolist(), E.tolist()),
            vectors.axial(U[..., None], E[..., None]),
            [(U @ E)[i - 1, i - 2] - (U @ E)[i - 2, i - 1] for i in range(3)],
        ),
    ):
        assert np.allclose(of_plain, by_hand, rtol=1e-13, atol=1e-13)
        assert np.allclose(np.asarray(of_arrays)[..., 0], by_hand, rtol=1e-13, atol=1e-13)


def test_a_field_of_accelerations_of_a_link_whose_spin_is_the_same_in_all_states() -> None:
    w, alpha = np.array([[1.0], [0.0], [0.0]]), np.array([[0.0, 0.0], [0.0, 0.0], [3.0, 5.0]])
    U = vectors.acceleration_field(w, alpha)
    assert np.array_equal(U[..., 0], [[0, -3, 0], [3, -1, 0], [0, 0, -1]])
    assert np.array_equal(U[..., 1], [[0, -5, 0], [5, -1, 0], [0, 0, -1]])


@pytest.mark.parametrize("name", SAMPLES)
def test_reactions_are_the_same_whether_all_is_solved_at_once_or_from_the_tips_inward(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    mechanism = sample(name)
    some = states(mechanism, 3)
    together = Balances(mechanism).reactions(some)
    monkeypatch.setattr(newton_euler, "_DENSE", 0)
    inward = Balances(mechanism)
    for joint, wrench in inward.reactions(some).items():
        size = max(1.0, *(float(np.nanmax(np.abs(part), initial=0.0)) for part in wrench))
        for ours, theirs in zip(wrench, together[joint], strict=True):
            np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-11 * size)
