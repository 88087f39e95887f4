"""Limits, stops and impacts: a page ends its motion, or sends it back, where `simulate` does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
import sympy
from viewing_browser import Visit
from viewing_engines import engine_of, needs_node, run

import mecanique as mq
from mecanique.motion.motion import Motion
from mecanique.textbook import entry, load
from mecanique.viewing.live.view import Computed
from mecanique.viewing.show import scene

Q, SPEED = sympy.Symbol("q"), sympy.Symbol("q'")


def move(name: str, **options: Any) -> Motion:
    """Simulate, until a limit if there is one."""
    try:
        return mq.simulate(load(name), rtol=1e-12, samples=30, **options)
    except mq.IntegrationError as error:
        return cast("Motion", error.motion)


def limited_cart() -> mq.Mechanism:
    """A cart whose rail is short."""
    cart = load("cart_pole")
    joints = tuple(
        replace(joint, limits=mq.Limits(-0.3, 0.3)) if isinstance(joint, mq.Prismatic) else joint
        for joint in cart.joints
    )
    return replace(cart, joints=joints)


def wall(quantity: Any, **options: Any) -> tuple[mq.Event, ...]:
    return (mq.Event("wall", quantity, **options),)


@needs_node
def test_motions_end_and_turn_where_simulate_says(tmp_path: Path) -> None:
    start: dict[str, Any] = {
        "q": {"x": 0.0, "q": 1.0},
        "v": {"x": 0.5},
        "duration": 3.0,
        "samples": 30,
    }
    cart = limited_cart()
    swing: dict[str, Any] = {"q": [1.0], "duration": 3.0}
    motions = {
        "where x comes to its limit h: beyond": move("atwood_machine", duration=3.0),
        "where r comes to its limit 0: beyond": move("swinging_atwood_machine", q={"r": 0.5}),
        "at the upper limit of": mq.simulate(cart, rtol=1e-12, limits="stop", **start),
        "": mq.simulate(cart, rtol=1e-12, limits=0.7, **start),
        "at its event 'wall'": move("simple_pendulum", events=wall("q", stop=True), **swing),
        "at its event": move("simple_pendulum", events=wall(SPEED + 1, stop=True), **swing),
        # below it for a moment within one step
        "at its event 'w": move("simple_pendulum", events=wall(Q + 0.99999, stop=True), **swing),
    }
    again = move("simple_pendulum", events=wall(Q + 0.2, restitution=0.9), **swing)
    every = [*motions.items(), ("", again)]
    tasks = [
        {"engine": asdict(engine_of(motion)), "rtol": 1e-12, "times": [float(motion.t[-1])]}
        for _, motion in every
    ]
    for (stopped, motion), found in zip(every, run(tasks, tmp_path), strict=True):
        assert found["stopped"].startswith(stopped)
        assert bool(found["stopped"]) == bool(stopped)
        assert found["last"] == pytest.approx(motion.t[-1], rel=1e-10)
        end = [*motion.q[-1], *motion.v[-1], motion.energy().work[-1]]
        assert found["states"][0] == pytest.approx(end, abs=1e-8)
        if not stopped:
            assert sum(event.impact for event in motion.events) > 1
        if motion.mechanism is not cart:
            names: dict[str, Any] = {}
            exec(found["python"], names)
            assert names["motion"].t[-1] == pytest.approx(motion.t[-1], abs=1e-8)
            assert names["motion"].q[-1] == pytest.approx(motion.q[-1], abs=1e-6)


def pushed_weight() -> mq.Mechanism:
    """An Atwood machine, one weight of which is lifted more and more."""
    rising = mq.Force("push", "weight2", (0, 0, 0), (0, 0, 50.0 * mq.time()))
    return replace(load("atwood_machine"), forces=(rising,))


def slippery_coin() -> mq.Mechanism:
    """A coin that rolls where there is little friction."""
    coin = load("rolling_coin")
    (contact,) = coin.contacts
    return replace(coin, contacts=(replace(cast("mq.Rolling", contact), friction=0.138),))


@needs_node
def test_what_ceases_to_hold_does_so_when_simulate_says(tmp_path: Path) -> None:
    system = entry("rolling_coin")
    v = {name.removesuffix("'"): rate for name, rate in system.start_velocity.items()}
    motions = (
        mq.simulate(pushed_weight(), q={"x": -0.5}, duration=0.5, rtol=1e-9),
        mq.simulate(slippery_coin(), q=dict(system.start), v=v, duration=1.0, rtol=1e-9),
        mq.simulate(load("atwood_machine"), duration=0.5, rtol=1e-9),
    )
    tasks = [{"engine": asdict(engine_of(each)), "rtol": 1e-9, "times": []} for each in motions]
    for motion, found in zip(motions, run(tasks, tmp_path), strict=True):
        told = {each["name"]: each["t"] for each in found["breaks"]}
        assert told == pytest.approx(
            {each.name: each.t for each in reversed(motion.events)}, abs=1e-6
        )
    assert motions[0].events[0].name == "cord_2 would push"
    assert motions[1].events[0].name == "rim would slip"
    assert not motions[2].events


def test_a_page_says_that_its_motion_ends(show: Callable[..., Visit]) -> None:
    seen = show(scene(move("atwood_machine", duration=3.0), equations=(), verdict=None))
    ends = "where x comes to its limit h: beyond, the description of 'atwood_machine'"
    assert f"The motion ends at t = 1.563 s, {ends}" in seen.page.inner_text("#ended")
    assert seen.js("mecanique.clock.last") == pytest.approx(1.562559, abs=1e-6)
    seen.page.click("#tab-parameters")
    start = "input[type=number][data-name='x']"
    seen.page.fill(start, "0.5")
    assert "t = 1.104 s" in seen.page.inner_text("#ended")
    seen.page.fill("#beside-by", "0.1")
    seen.page.click("#beside-on")
    assert seen.js("mecanique.clock.table.other.path.last < mecanique.clock.last")
    seen.page.fill(start, "1.5")
    assert seen.page.inner_text("#setup-status").startswith("x must stay within (-h, h): beyond")
    assert seen.page.get_attribute(start, "aria-invalid") == "true"
    seen.page.fill("input[data-kind=duration]", "0.5")
    assert seen.page.is_hidden("#ended")
    seen.clean()


def test_a_hand_keeps_to_the_limits_and_no_cord_pushes_unseen(show: Callable[..., Visit]) -> None:
    motion = mq.simulate(pushed_weight(), q={"x": -0.5}, duration=0.5, rtol=1e-9)
    seen = show(scene(motion, equations=(), verdict=None))
    x, y = seen.js(
        """(() => {
        const { stage } = mecanique;
        const box = stage.pane.getBoundingClientRect();
        const [x, y] = stage.project(stage.nodes[2].position.toArray());
        return [x + box.left, y + box.top]; })()"""
    )
    told = seen.page.inner_text("#ended")
    begins = f"From t = {motion.events[0].t:.4g} s on no real mechanism moves like this: "
    assert told == f"{begins}cord_2 would push."
    seen.page.mouse.move(x, y)
    seen.page.mouse.down()
    seen.page.mouse.move(x, y - 1000, steps=4)
    seen.page.mouse.up()
    assert 0.2 < abs(seen.js("mecanique.setup.bench.setting.start[0]")) < 1
    assert seen.page.inner_text("#ended") == told
    seen.js("mecanique.setup.change([['duration', '', 0.45]])")
    assert seen.js("document.getElementById('setup-status').textContent").endswith(told)
    seen.clean()


def test_a_live_view_leaves_the_end_to_its_page() -> None:
    engine = Computed(load("atwood_machine"), None, None, np.inf, 1e-10, 1.0).scene.engine
    assert engine is not None
    assert engine.endless
    assert [bound.direction for bound in engine.bounds] == [-1, -1]


def test_what_ends_by_a_function_is_recorded() -> None:
    event = mq.Event("far", lambda t, q, v: q[0] - 0.5, -1, stop=True)
    motion = mq.simulate(load("simple_pendulum"), q=[1.0], duration=1.0, events=(event,))
    document = scene(motion, equations=(), verdict=None).document
    assert "event 'far' is a function of Python" in document.recorded
