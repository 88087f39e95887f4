from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipk

import mecanique as mq
from mecanique.motion import Event

G = 9.81
DROP = np.sqrt(2 / G)


@pytest.fixture(scope="module")
def ball() -> mq.Mechanism:
    return mq.Mechanism(
        "ball",
        (mq.Body("ground"), mq.Body("ball", mq.particle(2.0))),
        (mq.Prismatic("fall", "ground", "ball", axis=(0, 0, 1), coordinate="z"),),
    )


def test_the_period_is_the_elliptic_integral() -> None:
    events = [Event("down", "q", 1), Event("turn", "q'")]
    motion = mq.simulate(
        mq.textbook.load("rigid_bar_pendulum"), q=[2.0], duration=10.0, events=events
    )
    period = 4 * np.sqrt(2 / (3 * G)) * ellipk(np.sin(1.0) ** 2)
    assert len(motion.times("down")) == 4
    np.testing.assert_allclose(np.diff(motion.times("down")), period, rtol=0, atol=2e-10)
    np.testing.assert_allclose(np.diff(motion.times("turn")), period / 2, rtol=0, atol=2e-10)
    assert [e.t for e in motion.events] == sorted(e.t for e in motion.events)


def test_a_stop_ends_the_motion_there(ball: mq.Mechanism) -> None:
    motion = mq.simulate(ball, q=[1.0], duration=5.0, events=[Event("floor", "z", stop=True)])
    assert motion.t[-1] == pytest.approx(DROP, abs=1e-14)
    assert motion["z"][-1] == pytest.approx(0.0, abs=1e-14)
    assert motion.events[0].name == "floor"
    assert not motion.events[0].impact


def test_a_function_and_an_expression_can_be_watched(ball: mq.Mechanism) -> None:
    events = [
        Event("half way", mq.coordinate("z") - 0.5),
        Event("one second", lambda t, q, v: t - 1.0),
        Event("fast", mq.velocity("z") + 1.0, direction=-1),
        Event("never", mq.coordinate("z") - 0.5, direction=1),
    ]
    motion = mq.simulate(ball, q=[1.0], duration=2.0, events=events)
    assert motion.times("half way") == pytest.approx([np.sqrt(1 / G)], abs=1e-13)
    assert motion.times("one second") == pytest.approx([1.0], abs=1e-13)
    assert motion.times("fast") == pytest.approx([1 / G], abs=1e-13)
    assert not len(motion.times("never"))


def test_a_ball_bounces_with_its_restitution(ball: mq.Mechanism) -> None:
    e = 0.8
    motion = mq.simulate(
        ball, q=[1.0], duration=3.0, events=[Event("floor", "z", -1, restitution=e)]
    )
    flights = DROP * np.concatenate([[1.0], 2 * e ** np.arange(1, 6)])
    np.testing.assert_allclose(motion.times("floor"), np.cumsum(flights), rtol=0, atol=1e-13)
    for occurrence in motion.events:
        np.testing.assert_allclose(occurrence.after, -e * occurrence.v, rtol=1e-13, atol=0)
    assert (motion["z"] > -1e-12).all()
    energy = motion.energy()
    # each impact keeps e² of the kinetic energy 2·g·1 before it
    assert energy.total[-1] == pytest.approx(2 * G * e ** (2 * len(motion.events)), rel=1e-12)
    assert motion.audit().ok
    # at an impact the state after it
    assert motion(float(motion.times("floor")[0])).v[0] > 0


def test_contact_that_lasts_is_refused(ball: mq.Mechanism) -> None:
    with pytest.raises(
        mq.IntegrationError, match=r"'floor' comes to rest at t = 4\.06.* lasting contact"
    ) as caught:
        mq.simulate(ball, q=[1.0], duration=6.0, events=[Event("floor", "z", -1, restitution=0.8)])
    assert caught.value.motion.t[-1] == pytest.approx(DROP + 2 * DROP * 0.8 / 0.2, abs=1e-6)
    with pytest.raises(mq.IntegrationError, match="lasting contact"):
        mq.simulate(ball, q=[1.0], duration=6.0, events=[Event("floor", "z", -1, restitution=0.0)])


def test_an_impact_of_coupled_bodies_keeps_the_momentum_that_it_cannot_change() -> None:
    mechanism = mq.textbook.load("cart_pole", c=0.0)
    event = Event("stop", mq.coordinate("q") + 0.5, restitution=0.6)
    motion = mq.simulate(mechanism, q={"q": 1.0}, duration=3.0, events=[event])
    assert motion.events
    for occurrence in motion.events:
        M = motion.reference.mass_matrix(occurrence.q)
        jump = M @ (occurrence.after - occurrence.v)
        assert jump[0] == pytest.approx(0.0, abs=1e-12)  # the impulse acts on q alone
        assert occurrence.after[1] == pytest.approx(-0.6 * occurrence.v[1], rel=1e-12)
    # linear momentum along x, zero at the start, is not touched by an impact inside
    momentum = motion.reference.momentum(motion.q, motion.v, motion.t).linear[:, 0]
    np.testing.assert_allclose(momentum, 0.0, rtol=0, atol=1e-8)
    assert motion.audit().ok


def test_a_moving_stop_is_hit_with_the_relative_velocity(ball: mq.Mechanism) -> None:
    event = Event("lift", mq.coordinate("z") - mq.time(), direction=-1, restitution=1.0)
    motion = mq.simulate(ball, q=[1.0], duration=0.6, events=[event])
    hit = motion.events[0]
    assert hit.after[0] == pytest.approx(2 * 1.0 - hit.v[0], rel=1e-12)


def test_an_event_inside_one_step_is_seen() -> None:
    slide = mq.Mechanism(
        "slider",
        (mq.Body("ground"), mq.Body("block", mq.particle(1.0))),
        (mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
    )
    x = mq.coordinate("x")
    motion = mq.simulate(
        slide, v=[1.0], duration=10.0, events=[Event("gate", (x - 5.01) * (x - 5.09))], max_step=0.3
    )
    np.testing.assert_allclose(motion.times("gate"), [5.01, 5.09], rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Event("e", "z", direction=2), "expected direction -1, 0 or 1, got 2"),
        (lambda: Event("e", "z", restitution=1.5), r"expected a restitution in 0…1, got 1\.5"),
        (
            lambda: Event("e", "z", stop=True, restitution=0.5),
            "expected stop or restitution, not both",
        ),
        (
            lambda: Event("e", lambda t, q, v: t, restitution=0.5),
            "expected an expression for an impact",
        ),
        (lambda: Event("e", [1, 2]), "expected a number, a parameter or an expression"),
    ],
)
def test_bad_events_are_refused(make: object, message: str) -> None:
    assert callable(make)
    with pytest.raises(mq.InputError, match=message):
        make()


def test_events_of_another_mechanism_are_refused(ball: mq.Mechanism) -> None:
    with pytest.raises(
        mq.UnknownNameError, match="unknown coordinate or velocity 'x'; known: z, z'"
    ):
        mq.simulate(ball, events=[Event("e", "x")])
    with pytest.raises(mq.UnknownNameError, match="unknown symbol 'x'"):
        mq.simulate(ball, events=[Event("e", mq.coordinate("x"))])
    with pytest.raises(mq.InputError, match="an impact depends on positions alone, got z' in it"):
        mq.simulate(ball, events=[Event("e", mq.velocity("z"), restitution=0.5)])


@pytest.mark.parametrize("method", ["radau", "bdf", "lsoda"])
def test_implicit_methods_see_the_same_events(ball: mq.Mechanism, method: str) -> None:
    events = [Event("floor", "z", -1, restitution=0.8), Event("half", mq.coordinate("z") - 0.3)]
    motion = mq.simulate(ball, q=[1.0], duration=1.5, rtol=1e-8, method=method, events=events)
    flights = DROP * np.array([1.0, 1.6])
    np.testing.assert_allclose(motion.times("floor"), np.cumsum(flights), rtol=0, atol=1e-6)
    assert len(motion.times("half")) == 4
    early = mq.simulate(
        ball,
        q=[1.0],
        duration=1.5,
        rtol=1e-8,
        method=method,
        events=[Event("floor", "z", stop=True)],
    )
    assert early.t[-1] == pytest.approx(DROP, abs=1e-7)
    np.testing.assert_allclose(early["z"], 1 - G * early.t**2 / 2, rtol=0, atol=1e-6)
