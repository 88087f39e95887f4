"""Systems with friction, stops and contacts: each is verified, written as URDF, and moves."""

from __future__ import annotations

import math

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.integrate import quad

import mecanique as mq
from mecanique.cli import app
from mecanique.motion.motion import Motion
from mecanique.textbook.facts import Lasting, ModeAcceleration, Occurs
from mecanique.verification.facts import check_facts

NAMES = mq.textbook.names(corners=True)


def move(name: str) -> Motion:
    """Return the default motion of a system."""
    system = mq.textbook.entry(name)
    start, velocity = dict(system.start), dict(system.start_velocity)
    return mq.simulate(mq.textbook.load(name), q=start, v=velocity, duration=system.duration)


def when(motion: Motion, name: str) -> float:
    """Return when something happened last [s]."""
    return next(event.t for event in reversed(motion.events) if event.name == name)


@pytest.mark.parametrize("name", NAMES)
def test_each_system_is_verified_moves_and_is_read_back(name: str) -> None:
    mechanism = mq.textbook.load(name)
    assert mechanism.switching
    assert mq.verify(mechanism, samples=10).agrees
    read = mq.read_urdf(mq.write_urdf(mechanism))
    assert [element.states for element in read.switching] == [
        element.states for element in mechanism.switching
    ]
    motion = move(name)
    assert motion.events
    assert motion.audit().ok


@pytest.mark.parametrize("name", NAMES)
def test_each_fact_holds(name: str) -> None:
    rows = check_facts(name, simulate=mq.simulate)
    assert len(rows) == len(mq.textbook.entry(name).facts)
    assert [str(row) for row in rows if not row.holds] == []


G = 9.81

# of a system: an event, which of its kind, a quantity there, its closed form
FIGURES = {
    "the ball strikes again after sqrt(2 h/g) (1 + 2 e)": (
        ("bouncing_ball", "floor: impact", 1, "t"),
        math.sqrt(2 / G) * 2.6,
    ),
    "and leaves at e^2 sqrt(2 g h)": (
        ("bouncing_ball", "floor: impact", 1, "after z'"),
        0.64 * math.sqrt(2 * G),
    ),
    "the oscillator turns again after 2 pi sqrt(m/k)": (
        ("dry_oscillator", "dry: slips -", 0, "t"),
        math.pi / 5,
    ),
    "nearer by 4 mu m g/k": (("dry_oscillator", "dry: slips -", 0, "x"), 0.1 - 4 * 0.1 * G / 100),
    "the clutch slips by w^2/(2 T (1/J_1 + 1/J_2))": (
        ("clutch", "plates: sticks", 0, "s"),
        -(40**2) / (2 * 3 * 7),
    ),
    "the block climbs v^2/(2 g (sin(alpha) + mu cos(alpha)))": (
        ("block_on_incline", "dry: slips +", 0, "x"),
        -1 / (2 * G * (math.sin(0.4) + 0.2 * math.cos(0.4))),
    ),
    "the balls of the cradle meet when the gap is gone": (
        ("newtons_cradle", "touch1, touch2: impact", 0, "t"),
        0.3,
    ),
}
# of a system: what its losses are in the end
LOSSES = {
    "a billiard ball turns two sevenths of its energy into heat": (
        ("billiard_ball", "cloth: friction"),
        0.17 / 7,
    ),
    "the clutch loses J_1 J_2 w^2/(2 (J_1 + J_2))": (
        ("clutch", "plates: friction"),
        0.5 * 0.2 * 40**2 / (2 * 0.7),
    ),
    "the cradle loses nothing": (("newtons_cradle", "touch1, touch2: impact"), 0.0),
}


@pytest.mark.parametrize("words", FIGURES)
def test_each_figure_of_a_corner_is_the_closed_form(words: str) -> None:
    (name, event, which, quantity), expected = FIGURES[words]
    motion = move(name)
    at = [occurrence for occurrence in motion.events if occurrence.name == event][which]
    coordinates, speeds = motion.mechanism.coordinates, motion.mechanism.velocities
    known = {"t": at.t, **dict(zip(coordinates, at.q, strict=True))}
    known |= {f"after {name}": v for name, v in zip(speeds, at.after, strict=True)}
    assert known[quantity] == pytest.approx(expected, rel=1e-11, abs=0.0)


@pytest.mark.parametrize("words", LOSSES)
def test_each_loss_is_the_closed_form(words: str) -> None:
    (name, loss), expected = LOSSES[words]
    assert move(name).losses()[loss][-1] == pytest.approx(expected, rel=1e-9, abs=1e-15)


def test_forty_closed_forms_of_motions_with_corners_are_held() -> None:
    facts = [fact for name in NAMES for fact in mq.textbook.entry(name).facts]
    of_corners = [f for f in facts if isinstance(f, (Lasting, ModeAcceleration, Occurs))]
    assert len(of_corners) + len(FIGURES) + len(LOSSES) >= 40


def test_smooth_systems_and_those_with_corners_are_listed_apart() -> None:
    assert not set(NAMES) & set(mq.textbook.names())
    done = CliRunner().invoke(app, ["list", "--tag", "corners"])
    assert [line.split()[0] for line in done.output.splitlines()] == list(NAMES)


def test_an_unknown_name_offers_those_with_corners() -> None:
    with pytest.raises(mq.UnknownNameError, match="bouncing_ball"):
        mq.textbook.load("bouncing_bal")


def test_each_ends_when_its_book_says() -> None:
    g = 9.81
    expected = {
        ("block_on_incline", "dry: slips +"): 1 / (g * (math.sin(0.4) + 0.2 * math.cos(0.4))),
        ("dry_oscillator", "dry: sticks"): math.pi / 2,
        ("bouncing_ball", "floor: rest"): math.sqrt(2 / g) * 1.8 / 0.2,
        ("billiard_ball", "cloth: sticks"): 2 / (7 * 0.2 * g),
        ("clutch", "plates: sticks"): 40 / (3 * (1 / 0.5 + 1 / 0.2)),
        ("newtons_cradle", "touch1, touch2: impact"): 0.3,
    }
    for (name, event), time in expected.items():
        assert when(move(name), event) == pytest.approx(time, rel=1e-11, abs=0.0), name
    ladder = move("ladder")
    leaves = next(event for event in ladder.events if event.name == "wall: open")
    assert leaves.q[1] == pytest.approx(4 / 3 * math.cos(0.3), rel=1e-9, abs=0.0)


def test_a_bead_leaves_the_sphere_at_two_thirds_of_its_height() -> None:
    leaves = next(event for event in move("bead_leaves_sphere").events)
    assert leaves.name == "sphere: open"
    assert math.cos(leaves.q[0]) == pytest.approx(2 / 3 * math.cos(0.1), rel=1e-9, abs=0.0)


def test_a_cord_goes_slack_and_taut_as_its_parabola_says() -> None:
    motion, g = move("slack_cord"), 9.81
    slack, taut = (when(motion, f"cord: {state}") for state in ("open", "impact"))
    begins = next(event for event in motion.events if event.name == "cord: open")
    assert -math.cos(begins.q[0]) == pytest.approx(2 / 3, rel=1e-9, abs=0.0)
    # with v² = c g l at the height c l, the parabola meets the circle again after 4 v √(1 − c²)/g
    c = 2 / 3
    flight = 4 * math.sqrt(c * g * (1 - c**2)) / g
    assert taut - slack == pytest.approx(flight, rel=1e-9, abs=0.0)


def test_the_last_ball_of_a_cradle_takes_the_momentum() -> None:
    motion = move("newtons_cradle")
    way, *gaps = motion.v[-1]
    np.testing.assert_allclose(np.cumsum([way, *gaps]), [0.0, 0.0, 1.0], rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-11, 1e-12])
def test_balls_of_a_cradle_that_stay_together_strike_but_once(rtol: float) -> None:
    # the gap of a corner found late by 1e-13 s was left, and closed again and again
    entry = mq.textbook.entry("newtons_cradle")
    start, velocity = dict(entry.start), dict(entry.start_velocity)
    motion = mq.simulate(entry.mechanism(), q=start, v=velocity, duration=0.6, rtol=rtol)
    assert [event.name for event in motion.events] == ["touch1, touch2: impact"]


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-12])
def test_a_slider_with_clearance_moves_on_at_any_tolerance(rtol: float) -> None:
    """Its corners bounce in turn to below rounding, and one may leave while the other arrives."""
    entry = mq.textbook.entry("clearance_slider_crank")
    start, velocity = dict(entry.start), dict(entry.start_velocity)
    motion = mq.simulate(entry.mechanism(), q=start, v=velocity, duration=0.05, rtol=rtol)
    assert motion.t[-1] == 0.05
    exact = move("clearance_slider_crank")(0.05)
    np.testing.assert_allclose(motion.q[-1], exact.q, rtol=0, atol=100 * rtol + 1e-8)


def test_a_block_rocks_as_housner_says() -> None:
    motion = move("rocking_block")
    first = [event for event in motion.events if event.t == motion.events[0].t]
    edge, lean = math.hypot(0.1, 0.4), math.atan2(0.2, 0.8)
    # J θ'' = −m g R sin(α − |θ|) about an edge, J = 4/3 m R²: time from θ₀ at rest to 0
    p2 = 9.81 / (4 / 3 * edge)

    def pace(s: float) -> float:  # θ = θ₀ (1 − s²), without the root's singularity
        tilt = lean / 2 * (1 - s**2)
        rate2 = 2 * p2 * (math.cos(lean / 2) - math.cos(lean - tilt))
        return lean * s / math.sqrt(rate2) if s > 0 else math.sqrt(lean / p2 / math.sin(lean / 2))

    quarter, _ = quad(pace, 0.0, 1.0, epsabs=0.0, epsrel=1e-12)
    assert motion.events[0].t == pytest.approx(quarter, rel=1e-9, abs=0.0)
    ratio = first[1].v[2] / first[0].v[2]
    assert ratio == pytest.approx(1 - 1.5 * math.sin(lean) ** 2, rel=1e-9, abs=0.0)


def test_run_writes_the_page_of_a_system_with_corners(tmp_path: object) -> None:
    done = CliRunner().invoke(app, ["run", "dry_oscillator", "-o", f"{tmp_path}/page.html"])
    assert done.exit_code == 0, done.output
    assert "dry_oscillator: agrees at 100 random states" in done.output
    assert "event dry: sticks: t = 1.5707" in done.output


def test_a_tippe_top_turns_over_if_it_spins_about_the_vertical() -> None:
    """About its own axis it rises and rolls: friction then takes nothing more (Jellett, 1872)."""
    top, start = mq.textbook.load("tippe_top"), dict(mq.textbook.entry("tippe_top").start)
    upright = mq.simulate(top, q=start, v={"top_wz": 155.0}, duration=0.1)
    overturned = move("tippe_top")
    for motion, low, high in ((upright, 0.995, 1.0), (overturned, -0.97, -0.92)):
        assert [event.name for event in motion.events] == ["floor: sticks"]
        last = 1 - 2 * (motion["top_qx"][-1] ** 2 + motion["top_qy"][-1] ** 2)
        assert low < last < high


def test_velocities_are_smooth_between_the_steps_that_close_in_on_a_corner() -> None:
    # the last steps before the top sticks are 1e-12 s long: a derivative between them is rounding
    motion = move("tippe_top")
    corner = int(np.searchsorted(motion.curve.t, when(motion, "floor: sticks")))
    t = motion.curve.t[:corner]
    middles = (t[-8:] + t[-9:-1]) / 2
    between = (motion.curve.v[corner - 8 : corner] + motion.curve.v[corner - 9 : corner - 1]) / 2
    short = np.diff(t[-9:]) < 1e-9
    assert short.any()
    np.testing.assert_allclose(motion(middles[short]).v, between[short], rtol=0, atol=1e-8)


def test_velocities_are_smooth_up_to_a_corner() -> None:
    """Slip in space that ends turns about, and a derivative there is rounding."""
    motion = move("tippe_top")
    corner = when(motion, "floor: sticks")
    for before in np.geomspace(1e-6, 1e-12, 7):
        first, middle, last = motion(corner - before * np.array([1.0, 0.5, 0.0])).v
        np.testing.assert_allclose(middle, (first + last) / 2, rtol=0, atol=1e-8)
