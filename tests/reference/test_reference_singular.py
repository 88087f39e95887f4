"""Next to singular positions: how far they are, how it moves on, and how slopes are blended."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from mecanique import simulate, textbook
from mecanique.errors import EngineError
from mecanique.model import Body, Floating, Mechanism, ball
from mecanique.reference import Reference, assemble, assembly_branches
from mecanique.reference.engine.load import load
from mecanique.reference.loops.assembly import NewtonResult, Tangent, newton
from mecanique.reference.loops.closed import Closed
from mecanique.reference.loops.freedom import refuse_locked
from mecanique.reference.loops.singular import (
    _FAR,
    _NEAR,
    _SIDE,
    _WEIGHTS,
    ClosedRhs,
    _distance,
    _find_way,
    _fits,
    _land_around,
    _Neighborhood,
    _pass,
    _Slope,
    _smooth_step,
    _State,
    _turns_ahead,
    _velocity_on,
)
from mecanique.reference.tolerances import WEAK

TURN = np.array([1.0, 1.0, 1.0, -1.0, -1.0])
"""How the chain of two parallelograms moves, as one pendulum."""


@pytest.fixture(scope="module")
def chain() -> Closed:
    mechanism = textbook.load("chained_four_bars", n=2)
    names = ("theta0", "theta1", "theta2")
    aside = {**dict.fromkeys(names, 1.0), "phi1": -1.0, "phi2": -1.0}
    closed = Reference(mechanism).with_rank_at(aside).closed
    assert closed is not None
    return closed


def state(closed: Closed, angle: float) -> _State:
    return _State(closed.mechanism.position({}) + angle * TURN, -3.5 * TURN, 0.0)


def test_a_smooth_step_rises_from_0_to_1_and_is_flat_at_both_ends() -> None:
    assert [_smooth_step(x) for x in (-1.0, 0.0, 0.5, 1.0)] == [0.0, 0.0, 0.5, 1.0]
    for x in (0.1, 0.25, 0.4):
        assert _smooth_step(x) + _smooth_step(1 - x) == pytest.approx(1.0, abs=1e-15)
        # its derivative is 30 x² (1 − x)²
        slope = (_smooth_step(x + 1e-5) - _smooth_step(x - 1e-5)) / 2e-5
        assert slope == pytest.approx(30 * x**2 * (1 - x) ** 2, rel=1e-8)


@pytest.mark.parametrize("angle", [0.0, 1e-6, 0.02, 0.2])
def test_what_the_motion_takes_is_not_closed(chain: Closed, angle: float) -> None:
    way = _find_way(chain, state(chain, angle))
    assert way.right.shape == (5, 4)
    np.testing.assert_allclose(way.right.T @ way.right, np.eye(4), rtol=0, atol=1e-13)
    np.testing.assert_allclose(way.right.T @ way.along, 0.0, rtol=0, atol=1e-13)
    moved = way.metric.columns @ way.along
    np.testing.assert_allclose(moved / np.abs(moved).max(), -TURN, rtol=0, atol=1e-12)


def test_the_distance_to_a_singular_position_is_the_angle_to_it(chain: Closed) -> None:
    for angle in (0.002, 0.01, 0.1):
        here = state(chain, angle)
        found = _distance(chain, _find_way(chain, here), here)
        assert found == pytest.approx(np.tan(angle), rel=0.02)
    still = _State(here.q, np.zeros(5), 0.0)
    assert _distance(chain, _find_way(chain, still), still) == np.inf


def test_what_is_hardly_closed_counts_as_singular(chain: Closed) -> None:
    """The least singular value grows in proportion to the angle."""
    probe = 0.01
    slope = _find_way(chain, state(chain, probe)).singular[-1] / probe
    for part, singular in ((0.5, True), (2.0, False)):
        here = state(chain, part * WEAK / slope)
        distance = _distance(chain, _find_way(chain, here), here)
        assert (distance == 0.0) == singular


@pytest.mark.parametrize("speed", [-3.5, 1e-3, 1e3])
def test_exactly_in_a_singular_position_the_acceleration_is_that_of_the_branch(
    speed: float,
) -> None:
    """Two parallelograms move as one pendulum of bars, whose angles count from the horizontal."""
    mechanism = textbook.load("chained_four_bars", n=2)
    reference = Reference(mechanism)
    at_rest = TURN * 0.1
    # the pendulum's acceleration is proportional to cos(angle), whatever its speed
    pendulum = reference.acceleration(at_rest)[0] / np.cos(0.1)
    found = reference.acceleration(np.zeros(5), speed * TURN)
    np.testing.assert_allclose(found, pendulum * TURN, rtol=1e-6, atol=0)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e4])
def test_a_motion_fits_its_branch_to_a_part_of_its_curvature(size: float) -> None:
    gamma = size * np.array([0.5, -1.0])
    assert _fits(-gamma + 0.9e-5 * max(size, 1.0), gamma)
    assert not _fits(-gamma + 1.1e-5 * max(size, 1.0), gamma)


def test_next_to_a_singular_position_only_what_is_closest_there_counts(chain: Closed) -> None:
    here = state(chain, 1e-3)
    way = _find_way(chain, here)
    slopes = [_Slope(x * here.v, x * here.v) for x in (1.0, 7.0)]
    near, other = (_pass(chain, here, slope, way, _NEAR) for slope in slopes)
    np.testing.assert_array_equal(near.acceleration, other.acceleration)
    np.testing.assert_allclose(near.rates, here.v, rtol=1e-5, atol=0)
    # between the two distances both count
    part = 0.3
    between = _pass(chain, here, slopes[1], way, (1 - part) * _NEAR + part * _FAR)
    for mixed, first, last in zip(between, near, slopes[1], strict=True):
        rise = _smooth_step(part)
        np.testing.assert_allclose(mixed, rise * last + (1 - rise) * first, rtol=1e-12, atol=1e-12)
    far = _pass(chain, here, slopes[1], way, _FAR)
    np.testing.assert_array_equal(far.acceleration, slopes[1].acceleration)


def test_in_a_singular_position_at_rest_nothing_decides_how_it_goes_on() -> None:
    reference = Reference(textbook.load("chained_four_bars", n=2))
    with pytest.raises(EngineError, match="nothing decides which branch it takes"):
        reference.acceleration(np.zeros(5))
    with pytest.raises(EngineError, match="no branch continues with"):
        reference.acceleration(np.zeros(5), [1.0, 0.0, 0.0, -1.0, 0.0])


@pytest.mark.parametrize(("name", "begins"), [("chained_four_bars", True), ("squeezer", False)])
def test_a_mechanism_may_begin_in_a_singular_position(name: str, begins: bool) -> None:
    closed = Reference(textbook.load(name)).closed
    assert closed is not None
    assert refuse_locked(closed, 0.0) is begins


def test_motions_refuse_to_begin_where_nothing_decides_how_they_go_on() -> None:
    chain = textbook.load("chained_four_bars", n=2)
    with pytest.raises(EngineError, match="nothing decides which branch it takes"):
        Reference(chain).rhs()(0.0, np.zeros(10))
    with pytest.raises(EngineError, match="nothing decides which branch it takes"):
        simulate(chain, q=np.zeros(5), duration=0.1)


def test_a_right_hand_side_taken_bare_counts_the_constraints() -> None:
    """Without their number it would free a second branch, and miss what this one demands."""
    reference = Reference(textbook.load("chained_four_bars", n=2))
    rates = reference.rhs()(0.0, np.concatenate([np.zeros(5), 2.0 * TURN]))
    np.testing.assert_allclose(
        rates[5:], reference.acceleration(np.zeros(5), 2.0 * TURN), rtol=1e-6, atol=0
    )


@pytest.mark.parametrize("name", ["phi", "theta", "psi"])
def test_branches_of_a_linkage_share_the_coordinate_that_was_named(name: str) -> None:
    linkage = textbook.load("four_bar_linkage")
    start = {"phi": 1.1, "theta": -0.76, "psi": 1.25}
    found = assembly_branches(linkage, {name: start[name]})
    at = linkage.coordinates.index(name)
    assert len(found) == 2
    assert {q[at] for q in found} == {start[name]}
    # one too many: what stays is chosen
    assert len(assembly_branches(linkage, start)) == 2


def test_a_joint_counts_by_its_velocities(monkeypatch: pytest.MonkeyPatch) -> None:
    flying = Mechanism(
        "stone",
        (Body("ground"), Body("stone", ball(1.0, 0.1))),
        (Floating("free", "ground", "stone"),),
    )
    most = "mecanique.reference.engine.load.MOST_VELOCITIES"
    monkeypatch.setattr(most, 6)
    load(flying)
    monkeypatch.setattr(most, 5)
    with pytest.raises(EngineError, match="has 6 joint velocities; Pinocchio is given at most 5"):
        load(flying)


@pytest.mark.parametrize("angle", [0.75, 1.3])
def test_no_distance_is_measured_again_within_half_the_way_to_where_slopes_are_blended(
    chain: Closed, angle: float
) -> None:
    here, slope = state(chain, angle), ClosedRhs(chain)
    slope(0.0, np.concatenate([here.q, here.v]))
    # a way of FAR at most, however far the singular position is
    reach = min(_distance(chain, _find_way(chain, here), here) - _FAR, _FAR) / 2
    assert slope._regular.holds(here.q + 0.99 * reach * TURN)
    assert slope._regular.holds(here.q - 0.99 * reach * TURN)
    assert not slope._regular.holds(here.q + 1.01 * reach * TURN)


def test_a_neighborhood_is_around_its_position() -> None:
    around = _Neighborhood(np.array([1.0, -2.0]), 0.1, np.array([1.0, 1.0]))
    assert around.holds(np.array([1.05, -2.05]))
    assert not around.holds(np.array([1.05, -2.2]))
    assert not around.holds(np.array([-1.0, 2.0]))


def test_a_neighborhood_counts_lengths_by_their_unit() -> None:
    around = _Neighborhood(np.zeros(2), 0.1, np.array([1.0, 0.02]))  # an angle, and a small length
    assert around.holds(np.array([0.09, 0.0019]))
    assert not around.holds(np.array([0.09, 0.0021]))


@pytest.mark.parametrize("r", [0.03, 0.3, 3.0])
def test_a_turn_is_judged_a_few_times_whatever_the_size(
    r: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A crank and a rod that hardly differ: time scales by the root of the lengths."""
    judged: list[float] = []

    def judge(*given: Any) -> bool | None:
        judged.append(given[-1])
        return _turns_ahead(*given)

    monkeypatch.setattr("mecanique.reference.loops.singular._turns_ahead", judge)
    crank = textbook.load("slider_crank", r=r, l=1.001 * r)
    motion = simulate(
        crank, q={"theta": 1.0}, v={"theta'": 3.0 / r**0.5}, duration=2.0 * r**0.5, samples=3
    )
    assert motion.q[-1, 0] == pytest.approx(12.40264296, abs=1e-6)
    assert 0 < len(judged) < 20


def test_places_around_a_state_are_sought_where_the_path_leads(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Bends grow with the square of the way k: those before give k² but for 2."""
    linkage = textbook.load("four_bar_linkage")
    reference = Reference(linkage)
    closed, q = reference.closed, assemble(linkage, {"phi": 1.0}, keep=("phi",))
    assert closed is not None
    J = reference.constraint_jacobian(q)
    here = _State(q, np.linalg.svd(J)[2][-1], 0.0)
    found: list[tuple[np.ndarray, np.ndarray]] = []

    def land(*given: Any, tangent: Tangent, **options: Any) -> NewtonResult:
        landing = newton(*given, tangent=tangent, **options)
        found.append((tangent.bend, landing.bend))
        return landing

    monkeypatch.setattr("mecanique.reference.loops.singular.newton", land)
    landings = _land_around(closed, _find_way(closed, here), here, 0.0, 0.01)
    assert landings is not None
    assert len(landings) == len(found) == 2 * _SIDE
    way = _find_way(closed, here)
    for landing in landings:
        # on each of the places the velocity is one that the loop allows
        v = _velocity_on(here, way, landing)
        J = reference.constraint_jacobian(landing.q)
        assert np.abs(J @ v).max() < 1e-9
        assert v @ here.v > 0.9
    for side in (found[:_SIDE], found[_SIDE:]):
        for k, (sought, bend) in enumerate(side[1:], 2):
            size = np.linalg.norm(bend)
            assert size > 1e-5
            assert np.linalg.norm(sought - bend) < 1.2 * 2 / k**2 * size


@pytest.mark.parametrize(
    ("gaps", "rounding", "turns"),
    [
        ([], 1e-14, None),
        ([0.9e-6], 1e-14, None),  # it may be an error of the interpolation
        ([1.1e-6], 1e-14, True),
        ([1e-3, 1e-3, 1e-3], 1e-14, True),
        ([1e-6, 1e-6 / 2**16], 1e-14, False),
        ([1e-6, 1e-6 / 2**16, 1e-14], 1e-15, False),
        ([1e-8, 2e-9, 2e-9], 1e-14, True),
        ([1e-11, 1e-11, 1e-11], 2e-11, False),
        ([1e-11, 1e-11, 1e-11], 1e-14, EngineError),
        ([9e-11, 2e-11, 1e-11], 1e-14, EngineError),  # the nearest states count
    ],
)
def test_branches_turn_where_the_gap_between_them_stays_as_states_come_nearer(
    gaps: list[float], rounding: float, turns: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What falls to less than a tenth is an error of the interpolation, which falls by 2^16."""
    left = list(gaps)
    landing = SimpleNamespace(rounding=rounding, bend=np.zeros(1))
    measured = SimpleNamespace(at=lambda *_: SimpleNamespace(residual=np.array([left.pop(0)])))
    closed: Any = SimpleNamespace(closures=measured, mechanism=SimpleNamespace(name="chain"))
    metric = SimpleNamespace(columns=np.eye(1), units=SimpleNamespace(rows=np.ones(1)))
    way: Any = SimpleNamespace(along=np.ones(1), right=np.eye(1), metric=metric)
    given: Any = SimpleNamespace(q=np.zeros(1), v=np.zeros(1), t=0.0)
    around = [landing] * (2 * len(_WEIGHTS))
    asked = list[float]()

    def land_around(*given: Any) -> Any:
        asked.append(given[-1])
        return around if left else None

    monkeypatch.setattr("mecanique.reference.loops.singular._land_around", land_around)
    monkeypatch.setattr(
        "mecanique.reference.loops.singular.displace", lambda closed, q, step: q + step
    )
    if turns is EngineError:
        with pytest.raises(EngineError, match="come within 1e-11 of crossing"):
            _turns_ahead(closed, way, given, 0.1)
    else:
        assert _turns_ahead(closed, way, given, 0.1) is turns
    # twice as near each time
    np.testing.assert_allclose(asked, asked[0] / 2 ** np.arange(len(asked)), rtol=1e-15, atol=0)
