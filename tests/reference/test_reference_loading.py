"""A mechanism is loaded into Pinocchio once, and what ran before makes no difference."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import mecanique as mq
from mecanique.reference import Reference
from mecanique.reference.engine import tree
from mecanique.reference.engine.load import EngineModel, load
from mecanique.reference.loops import closed


@pytest.fixture
def loads(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the mechanisms that are loaded, one after the other."""
    names: list[str] = []

    def note(mechanism: mq.Mechanism) -> EngineModel:
        names.append(mechanism.name)
        return load(mechanism)

    monkeypatch.setattr(tree, "load", note)
    return names


@pytest.mark.parametrize("name", ["double_pendulum", "four_bar_linkage"])
def test_everything_asked_of_a_mechanism_loads_it_once(
    loads: list[str], name: str, tmp_path: Path
) -> None:
    mechanism = mq.textbook.load(name)
    q = mq.assemble(mechanism)
    for _ in range(2):
        motion = mq.simulate(mechanism, q=q, duration=0.05, rtol=1e-6)
        motion.energy()
        motion.reactions(mechanism.joints[0].name)
        motion.audit()
        mq.picture(mechanism, path=tmp_path / "figure.svg")
        assert mq.degrees_of_freedom(mechanism, q).N in (1, 2)
        assert mq.verify(mechanism, samples=3).agrees
        mq.equilibria(mechanism, 2)
        mq.linearize(mechanism, q)
    assert loads == [name]


def test_what_the_user_makes_is_the_users_own(loads: list[str]) -> None:
    mechanism = mq.textbook.load("simple_pendulum")
    own = Reference(mechanism)
    motion = mq.simulate(mechanism, duration=0.1, reference=own)
    assert motion.reference is own
    assert mq.simulate(mechanism, duration=0.1).reference is not own
    assert loads == ["simple_pendulum"] * 2


@pytest.mark.parametrize("method", ["dop853", "closed_form", "radau"])
def test_a_tree_moves_the_same_whatever_ran_before(method: str) -> None:
    mechanism = mq.textbook.load("elastic_pendulum")
    start = {"r": 1.0, "theta": 1.0}
    call = partial(mq.simulate, mechanism, q=start, duration=0.5, method=method)
    first = call()
    mq.simulate(mechanism, q={"r": 0.8, "theta": 2.0}, v={"theta": 3.0}, duration=0.3)
    again, afresh = call(), call(reference=Reference(mechanism))
    for other in (again, afresh):
        assert np.array_equal(first.q, other.q)
        assert np.array_equal(first.a, other.a)
        assert np.array_equal(first.energy().total, other.energy().total)


@pytest.mark.parametrize("name", ["four_bar_linkage", "bricard_linkage", "slider_crank"])
def test_loops_move_the_same_whatever_ran_before(name: str) -> None:
    """A run notes the rank of the constraints at its start, for itself alone."""
    mechanism = mq.textbook.load(name)
    reference = Reference(mechanism)
    q = mq.assemble(mechanism)
    moving = {mechanism.coordinates[0]: 0.7}
    call = partial(mq.simulate, mechanism, q=q, v=moving, duration=0.1, rtol=1e-7)
    before = reference.acceleration(q)
    first = call()
    accelerations = first.a.copy()
    mq.simulate(mechanism, q=q, duration=0.05, rtol=1e-5, reference=reference)
    mq.linearize(mechanism, q, reference=reference)
    assert reference.closed is not None
    assert reference.closed.most is None
    assert np.array_equal(reference.acceleration(q), before)
    assert np.array_equal(Reference.of(mechanism).acceleration(q), before)
    again, afresh = call(), call(reference=Reference(mechanism))
    for other in (again, afresh):
        assert np.array_equal(first.q, other.q)
        assert np.array_equal(accelerations, other.a)
        assert np.array_equal(first(0.05).q, other(0.05).q)


def test_a_loaded_mechanism_lives_no_longer_than_itself() -> None:
    mechanism = mq.textbook.load("four_bar_linkage")
    engine = weakref.ref(Reference.of(mechanism)._tree)
    mechanism_there = weakref.ref(mechanism)
    assert engine() is not None
    del mechanism
    gc.collect()
    assert mechanism_there() is None
    assert engine() is None


def test_motions_do_not_keep_what_is_loaded() -> None:
    """Of many mechanisms those asked for last stay loaded, though their motions are there."""
    base = mq.textbook.load("simple_pendulum")
    mechanisms = [base.replace(l=1.0 + k) for k in range(closed.MOST + 3)]
    motions = [mq.simulate(each, duration=0.1, method="dop853") for each in mechanisms[:2]]
    engines = [weakref.ref(Reference.of(each)._tree) for each in mechanisms]
    gc.collect()
    assert [engine() is None for engine in engines] == [True] * 3 + [False] * closed.MOST
    assert motions[0].energy().total[0] == pytest.approx(motions[0].energy().total[-1], rel=1e-12)


def test_each_thread_loads_its_own(loads: list[str]) -> None:
    mechanism = mq.textbook.load("four_bar_linkage")
    motion = mq.simulate(mechanism, q=mq.assemble(mechanism), duration=0.05, rtol=1e-6)
    mine = motion.reference
    with ThreadPoolExecutor(1) as pool:
        other = pool.submit(lambda: motion.reference).result()
        a = pool.submit(lambda: motion.a).result()
    assert other._tree is not mine._tree
    assert len(loads) == 2
    assert np.array_equal(a, mine.acceleration(motion.q, motion.v, motion.t))


def driven(torque: Callable[[float], float]) -> mq.Mechanism:
    """A hinged bar under a torque that is a function of time."""
    body = mq.Body("bar", mq.rod(2.0, 1.0))
    joint = mq.Revolute("hinge", "ground", "bar", axis=(0, -1, 0), coordinate="theta")
    u = mq.Input("u", torque, "N·m")
    drive = mq.JointForce("drive", "hinge", u)
    return mq.Mechanism("driven", (mq.Body("ground"), body), (joint,), (drive,), inputs=(u,))


def test_a_function_of_time_may_ask_a_reference_of_its_own() -> None:
    known: list[Reference] = []

    def torque(t: float) -> float:
        return sum(float(each.inverse_dynamics([0.5], [0.0], [t])[0]) for each in known)

    mechanism = driven(torque)
    own = Reference(driven(lambda t: 0.0))
    weight = own.inverse_dynamics([0.5], [0.0], [0.0]).item()
    Reference.of(mechanism)
    known.append(own)
    motion = mq.simulate(mechanism, q=[0.5], duration=0.1, method="dop853")
    assert motion.a[0].item() == pytest.approx(0.0, abs=1e-12)
    assert weight == pytest.approx(9.81 * np.sin(0.5), rel=1e-12)


def test_a_reference_that_waits_for_a_function_refuses_to_answer_it() -> None:
    known: list[Reference] = []
    mechanism = driven(lambda t: sum(float(each.mass_matrix([1.0])[0, 0]) for each in known))
    reference = Reference(mechanism)
    known.append(reference)
    with pytest.raises(
        mq.InputError, match="'driven' calls the Reference that is waiting for its value"
    ):
        reference.acceleration([0.5])
    known[:] = [Reference.of(mechanism)]
    with pytest.raises(mq.InputError, match="let it use one of its own"):
        mq.simulate(mechanism, duration=0.1, method="dop853")
    assert reference.mass_matrix([1.0]).item() == pytest.approx(2 / 3, rel=1e-12)
