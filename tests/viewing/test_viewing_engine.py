"""The engine of a page: its program against Pinocchio, its motions against `simulate`."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from dataclasses import asdict, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import DOP853
from scipy.special import ellipj, ellipk
from viewing_browser import Visit
from viewing_engines import engine_of, needs_node, run

import mecanique as mq
from mecanique.generation import dop853
from mecanique.model.mechanism_units import units
from mecanique.textbook import entry, load, names
from mecanique.viewing.engine import Maker
from mecanique.viewing.page.page import page
from mecanique.viewing.scene.from_motion import actions_of, scene_of
from mecanique.viewing.scene.scene import Scene
from mecanique.viewing.scene.texts import document_of
from mecanique.viewing.show import scene as scene_with_texts

QUICK = (
    "simple_pendulum",
    "slider_crank",
    "tennis_racket",
    "crane",
    "shear_building",
    "rolling_coin",
    "chaplygin_sleigh",
)

LOOSE = {
    "chained_four_bars": 1e-6,
    "double_pendulum": 1e-6,
    "furuta_pendulum": 1e-8,
    "n_link_pendulum": 1e-4,
}
"""Largest difference where neighboring motions part quickly, or loops lose rank on the way."""


def start_of(name: str) -> dict[str, Any]:
    system = entry(name)
    v = {key.removesuffix("'"): value for key, value in system.start_velocity.items()}
    return {"q": dict(system.start), "v": v}


def motion_of(name: str, **options: Any) -> mq.Motion:
    given = {"duration": entry(name).duration} | options
    return mq.simulate(load(name), **start_of(name), **given)


@cache
def maker_of(name: str) -> tuple[Maker, Scene]:
    motion = motion_of(name, samples=20, duration=1.0)
    maker, actions = Maker(motion, mq.derive(motion.mechanism)), actions_of(motion)
    document = document_of(motion, (), None, actions)
    return maker, maker.thin(scene_of(motion, document, actions))


def differences(systems: list[str], folder: Path, longest: float = math.inf) -> dict[str, float]:
    """The largest difference of the states at the end from those of `simulate`, relative."""
    tasks, ends = [], []
    for name in systems:
        length = min(longest, entry(name).duration)
        # finer than the page: compiled motions of loops at 1e-12 end 4e-9 from those at 1e-13
        motion = motion_of(name, rtol=1e-13, samples=5, duration=length)
        ends.append(np.array([*motion.q[-1], *motion.v[-1]]))
        task = {"engine": asdict(engine_of(motion)), "rtol": 1e-12, "times": [motion.t[-1]]}
        tasks.append(task)
    found = run(tasks, folder)
    for name, each in zip(systems, found, strict=True):
        assert not each["stopped"], name
    return {
        name: float(np.max(np.abs(each["states"][0][:-1] - end) / np.maximum(1, np.abs(end))))
        for name, each, end in zip(systems, found, ends, strict=True)
    }


@needs_node
def test_motions_end_where_simulate_says(tmp_path: Path) -> None:
    assert max(differences(list(QUICK), tmp_path, 1.0).values()) < 1e-9


@needs_node
@pytest.mark.slow
def test_all_motions_end_where_simulate_says(tmp_path: Path) -> None:
    for name, difference in differences(list(names()), tmp_path).items():
        assert difference < LOOSE.get(name, 1e-9), name


@needs_node
def test_the_pendulum_swings_by_the_elliptic_function(tmp_path: Path) -> None:
    """Sin(θ/2) = k sn(K − ω t, k) from rest."""
    start, times = 2.0, [0.7, 3.0, 10.0]
    motion = mq.simulate(load("simple_pendulum"), q=[start], duration=10, samples=3)
    values = motion.mechanism.values
    omega, k = np.sqrt(values["g"] / values["l"]), np.sin(start / 2)
    task = {"engine": asdict(engine_of(motion)), "rtol": 1e-12, "times": times}
    (found,) = run([task], tmp_path)
    sn = ellipj(ellipk(k * k) + omega * np.array(times), k * k)[0]
    theta = [state[0] for state in found["states"]]
    assert theta == pytest.approx(2 * np.arcsin(k * sn), abs=1e-10)


@needs_node
def test_the_work_of_a_condition_with_a_rate_of_its_own_is_computed_too(tmp_path: Path) -> None:
    a = mq.coordinate("a")
    row = {"x": -mq.sin(a), "y": mq.cos(a), "a": 0.3}
    driven = mq.Mechanism(
        "driven",
        (mq.Body("ground"), mq.Body("bob", mq.ball(1.0, 0.1))),
        (mq.Planar("free", "ground", "bob", names=("x", "y", "a")),),
        velocity_constraints=(mq.VelocityConstraint("row", row, 0.5),),
    )
    motion = mq.simulate(driven, v={"x'": 1.0}, duration=1.0, samples=3)
    work = motion.energy().work[-1]
    assert work > 0.01
    task = {"engine": asdict(engine_of(motion)), "rtol": 1e-12, "times": [1.0]}
    (answer,) = run([task], tmp_path)
    assert answer["states"][0][-1] == pytest.approx(work, rel=1e-8, abs=0)


COMPLETE = ("double_pendulum", "slider_crank", "gyroscope", "rolling_coin", "planetary_gear")
"""Trees, loops, contacts and elements that guide: all that the page shows is known to it."""


@pytest.mark.parametrize("name", COMPLETE)
def test_the_program_gives_every_number_of_the_scene(name: str) -> None:
    """Poses, every force and reaction, energies and virtual work, as Pinocchio gives them."""
    maker, scene = maker_of(name)
    kinds = {arrow.kind for arrow in scene.arrows}
    assert {"weight", "reaction", "inertia"} <= kinds
    assert maker.make(scene).unknown == ()


def test_the_program_stores_energy_in_loads_that_have_a_potential() -> None:
    """V = -m mu/r; nothing does work."""
    maker, scene = maker_of("kepler_orbit")
    series = {one.name: one.values for one in scene.series}
    values = load("kepler_orbit").values
    V = -values["m"] * values["mu"] / series["r"]
    np.testing.assert_allclose(series["energy potential"], V, rtol=1e-12, atol=0)
    assert maker.make(scene).unknown == ()


def test_what_the_program_does_not_give_is_unknown() -> None:
    maker, scene = maker_of("double_pendulum")
    wrong = replace(scene.arrows[2], vector=scene.arrows[2].vector * 1.001)
    arrows = (*scene.arrows[:2], wrong, *scene.arrows[3:])
    first = 7 * len(scene.bodies) + 12
    assert maker.make(replace(scene, arrows=arrows)).unknown == tuple(range(first, first + 6))


def test_a_program_that_moves_otherwise_is_refused() -> None:
    maker, scene = maker_of("double_pendulum")
    with pytest.raises(mq.DerivationError, match="another pose of rod2 than the motion"):
        maker.make(replace(scene, positions=scene.positions * 1.001))


def test_the_tableau_is_that_of_dormand_and_prince() -> None:
    text = dop853.SCRIPT.read_text(encoding="utf-8")
    assert text == dop853.write_script(), "write it by python -m mecanique.generation.dop853"
    tables = {}
    for part in text.split("export const ")[2:]:
        name, rows = part.split(" = ", 1)
        tables[name] = json.loads(re.sub(r",\s*\]", "]", rows.split(";")[0]))
    weights = np.zeros((12, 12))
    for k, row in enumerate(tables["STAGES"][:12]):
        for stage, weight in row:
            weights[k, stage] = weight
    tableau: Any = DOP853
    assert np.array_equal(weights, tableau.A)
    errors = np.zeros((2, 13))
    for k, row in enumerate(tables["ERRORS"]):
        for stage, weight in row:
            errors[k, stage] = weight
    assert np.array_equal(errors, [tableau.E5, tableau.E3])
    last = np.zeros(12)
    for stage, weight in tables["STAGES"][12]:
        last[stage] = weight
    assert np.array_equal(last, tableau.B)


@needs_node
@pytest.mark.parametrize(
    "name",
    [
        *("governor", "four_bar_linkage", "slider_crank", "bricard_linkage", "kepler_orbit"),
        *("ball_in_a_bowl", "crane"),
        pytest.param("rattleback", marks=pytest.mark.slow),
    ],
)
def test_a_page_finds_every_position_of_rest_that_python_does(name: str, tmp_path: Path) -> None:
    """Of the governor's, four are where loops lose rank: the sleeve on top, arms up or down.

    Bricard's last hinge would close in ten more with its axes half a turn apart; next to the sun a
    planet only seems to rest, as the inertia of its angle vanishes. A ball also rests under the top
    of its bowl, a stone on both of its ends and, upside down, to either side. A load that is let
    down swings wider and wider.
    """
    rests, turns = search_rests(name, tmp_path)
    mechanism = load(name)
    known = mq.equilibria(mechanism)
    assert len(rests) == len(known)
    for equilibrium in known:
        quaternions = {name for joint in mechanism.joints for name in joint.quaternion}
        family = {*equilibrium.family, *(quaternions if "turns" in str(equilibrium) else ())}
        free = [name in family for name in mechanism.coordinates]
        gaps = np.array([rest["q"] for rest in rests]) - equilibrium.q
        gaps[:, turns] = (gaps[:, turns] + math.pi) % (2 * math.pi) - math.pi
        gaps[:, free] = 0.0
        nearest = int(np.abs(gaps).max(axis=1).argmin())
        assert np.abs(gaps[nearest]).max() < 1e-6
        squares = sorted(max(square, 0.0) for square in rests[nearest]["squares"])
        frequencies = equilibrium.linearization.frequencies
        assert np.sqrt(squares) == pytest.approx(sorted(frequencies), rel=1e-4, abs=1e-3)
        assert rests[nearest]["stable"] == equilibrium.stable


def search_rests(name: str, tmp_path: Path) -> tuple[list[Any], list[bool]]:
    """Search the positions of rest as a page does; also return which coordinates are angles."""
    system, mechanism = entry(name), load(name)
    start, speeds = dict(system.start), dict(system.start_velocity)
    motion = mq.simulate(mechanism, q=start, v=speeds, duration=0.1)
    unit = units(mechanism)
    turns = [unit[coordinate] == "rad" for coordinate in mechanism.coordinates]
    spans = [math.pi if turn else 3.0 for turn in turns]
    task = {"engine": asdict(engine_of(motion)), "spans": spans, "turns": turns}
    return run(task, tmp_path, "find_rests"), turns


def test_a_page_that_cannot_compute_says_why() -> None:
    driven = replace(load("cart_pole"), inputs=(mq.Input("F", math.sin, "N"),))
    motion = mq.simulate(driven, duration=0.1)
    found = scene_with_texts(motion, equations=(), verdict=None)
    assert found.engine is None
    assert "input 'F' is a function of Python" in found.document.recorded
    assert "computes no other" in page(found)


@pytest.fixture(scope="module")
def crank() -> Scene:
    return scene_with_texts(motion_of("slider_crank", duration=1.0, fps=30))


def test_the_page_carries_its_proof(crank: Scene) -> None:
    verdict = crank.document.verdict
    rows = {name: float(worst) for name, worst in verdict.own}
    assert set(rows) == {"rates of the state", "energies", "poses of bodies", "closure of loops"}
    assert max(rows.values()) < 1e-9
    assert "100 random states" in verdict.own_note
    assert "The program of this page" in page(crank)


def test_the_engine_takes_little_room(crank: Scene) -> None:
    assert len(page(crank)) - len(page(replace(crank, engine=None))) < 60_000


def test_what_is_set_in_the_page_moves(crank: Scene, show: Callable[..., Visit]) -> None:
    seen = show(crank)
    seen.page.click("#tab-parameters")
    engine = crank.engine
    assert engine is not None
    symbol = engine.parameters[0]
    value = engine.values[0]
    field = f'input[type=number][data-name="{symbol}"]'
    seen.page.fill(field, str(1.1 * value))
    assert seen.js("k => mecanique.setup.bench.setting.p[k]", 0) == pytest.approx(
        1.1 * value, rel=1e-6
    )
    assert seen.js("mecanique.clock.table.path.steps") > 0
    changed = crank_state(seen)
    seen.page.click("#setup-undo")
    assert seen.js("mecanique.setup.bench.setting.p[0]") == value
    assert crank_state(seen) != changed
    seen.page.fill(field, "0")
    assert seen.page.get_attribute(field, "aria-invalid") == "true"
    seen.clean()


def crank_state(seen: Visit) -> list[float]:
    found: list[float] = seen.js("[...mecanique.clock.table.stateAt(0.7)]")
    return found


def test_an_address_sets_the_page(
    crank: Scene, visit: Callable[..., Visit], tmp_path: Path
) -> None:
    path = tmp_path / "crank.html"
    path.write_text(page(crank), encoding="utf-8")
    seen = visit(f"{path.as_uri()}#duration=0.25&rtol=1e-6", offline=True)
    assert seen.js("mecanique.clock.last") == 0.25
    assert seen.js("mecanique.setup.link()").endswith("#duration=0.25&rtol=0.000001")
    seen.clean()
