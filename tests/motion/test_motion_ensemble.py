from __future__ import annotations

import os
import pickle
import signal
from collections.abc import Callable
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pytest

import mecanique as mq
from mecanique.motion.compile.heyoka import is_installed
from mecanique.motion.ensemble.chunks import Part, run_part

needs_heyoka = pytest.mark.skipif(not is_installed(), reason="heyoka is not installed")
METHODS = ["batch", "single", pytest.param("taylor", marks=needs_heyoka)]


def starts(n: int) -> dict[str, np.ndarray]:
    random = np.random.default_rng(0)
    return {"q1": random.uniform(-0.8, 0.8, n), "q2": random.uniform(-0.8, 0.8, n)}


@pytest.mark.parametrize("method", METHODS)
def test_every_run_is_the_motion_of_its_own(method: str) -> None:
    mechanism, n = mq.textbook.load("double_pendulum"), 5
    sweep: dict[str, Any] = {"l1": np.linspace(0.6, 1.4, n), "m2": 2.0}
    runs = mq.simulate_many(
        mechanism,
        starts(n),
        {"q1'": 0.3},
        sweep,
        duration=2.0,
        samples=5,
        method=method,
        rtol=1e-11,
    )
    assert len(runs) == runs.done == n
    assert runs.q.shape == runs.v.shape == (n, 5, 2)
    assert not len(runs.failed)
    for k in range(n):
        own = mechanism.replace(l1=sweep["l1"][k], m2=2.0)
        start = {name: values[k] for name, values in starts(n).items()}
        motion = mq.simulate(own, q=start, v={"q1": 0.3}, duration=2.0, samples=5, rtol=1e-12)
        np.testing.assert_allclose(runs.q[k], motion.q, rtol=0, atol=1e-9)
        np.testing.assert_allclose(runs["q2'"][k], motion["q2'"], rtol=0, atol=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_small_swings_keep_the_period_of_each_length(method: str) -> None:
    lengths = np.array([0.5, 1.0, 2.0])
    mechanism = mq.textbook.load("simple_pendulum")
    (length,) = (p.symbol for p in mechanism.parameters if p.unit == "m")
    omega = np.sqrt(mechanism.values["g"] / lengths)
    runs = mq.simulate_many(
        mechanism, [1e-5], parameters={length: lengths}, duration=3.0, method=method, rtol=1e-12
    )
    np.testing.assert_allclose(runs.q[:, -1, 0], 1e-5 * np.cos(3 * omega), rtol=0, atol=1e-11)


def test_quaternions_stay_of_unit_length() -> None:
    mechanism = mq.textbook.load("free_rigid_body")
    spin = {name: np.array([0.3, 2.0]) for name in mechanism.velocities[-3:]}
    runs = mq.simulate_many(
        mechanism, None, spin, duration=2.0, method="batch", rtol=1e-10, samples=3
    )
    np.testing.assert_allclose(np.linalg.norm(runs.q[:, :, -4:], axis=2), 1.0, rtol=0, atol=1e-14)
    for k in range(2):
        motion = mq.simulate(
            mechanism, v=runs.start[k, mechanism.nq :], duration=2.0, samples=3, rtol=1e-12
        )
        np.testing.assert_allclose(runs.q[k], motion.q, rtol=0, atol=1e-8)


def pushed(signal: Any) -> mq.Mechanism:
    m, force = mq.Parameter("m", 2.0, "kg"), mq.Input("F", signal, "N")
    return mq.Mechanism(
        name="pushed",
        bodies=(mq.Body("ground"), mq.Body("block", mq.particle(m))),
        joints=(mq.Prismatic("rail", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        forces=(mq.JointForce("push", "rail", force),),
        parameters=(m,),
        inputs=(force,),
    )


def wave(t: float) -> float:
    return float(np.sin(3 * t))


@pytest.mark.parametrize(
    "signal", [mq.Record(np.array([0.0, 0.5, 2.0]), np.array([0.0, 1.0, -3.0])), wave]
)
def test_records_and_functions_drive_the_runs(signal: Any) -> None:
    motion = mq.simulate(pushed(signal), duration=2.0, samples=4, rtol=1e-12)
    start = {"x": [0.0, 1.0]}
    runs = mq.simulate_many(
        pushed(signal), start, duration=2.0, samples=4, method="batch", rtol=1e-11
    )
    np.testing.assert_allclose(
        runs["x"], motion["x"] + np.array([[0.0], [1.0]]), rtol=0, atol=1e-11
    )


def test_what_cannot_travel_is_refused() -> None:
    with pytest.raises(mq.InputError, match="cannot be sent to other processes"):
        mq.simulate_many(pushed(lambda t: t))


def test_mechanisms_without_a_closed_form_run_one_by_one() -> None:
    mechanism = mq.textbook.load("n_link_pendulum", n=9)
    runs = mq.simulate_many(mechanism, {"q1": [0.1, 0.2]}, duration=0.2)
    assert runs.method.startswith("single")
    assert "expected at most 8 velocities" in runs.method
    assert runs.motion(1, samples=2).q[-1] == pytest.approx(runs.q[1, -1], abs=1e-7)


def closed_starts(count: int) -> np.ndarray:
    entry = mq.textbook.entry("four_bar_linkage")
    q = mq.assemble(entry.mechanism(), dict(entry.start))
    return q + np.random.default_rng(0).uniform(-0.1, 0.1, (count, len(q)))


def test_closed_mechanisms_run_in_c() -> None:
    mechanism, starts = mq.textbook.load("four_bar_linkage"), closed_starts(3)
    runs = mq.simulate_many(mechanism, starts, duration=1.0, samples=[0.5, 1.0], rtol=1e-10)
    assert runs.method.startswith("compiled (explicit Runge-Kutta of order 8(5,3) in C); chosen")
    assert not len(runs.failed)
    for k in range(3):
        alone = runs.motion(k, samples=[0.5, 1.0])
        np.testing.assert_allclose(runs.q[k, 1:], alone.q, rtol=0, atol=1e-9)
    many = mq.simulate_many(mechanism, starts, duration=1.0, rtol=1e-10, max_steps=5)
    assert many.failed.tolist() == [0, 1, 2]


def test_closed_mechanisms_take_parameters_of_their_own() -> None:
    mechanism = mq.textbook.load("four_bar_linkage")
    runs = mq.simulate_many(
        mechanism, closed_starts(1)[0], parameters={"m3": [1.0, 9.0]}, duration=0.5
    )
    for k, mass in enumerate((1.0, 9.0)):
        alone = mq.simulate(mechanism.replace(m3=mass), q=closed_starts(1)[0], duration=0.5)
        np.testing.assert_allclose(runs.q[k, -1], alone.q[-1], rtol=0, atol=1e-8)
    assert not np.allclose(runs.q[0, -1], runs.q[1, -1], rtol=0, atol=1e-3)


def test_runs_next_to_a_singular_position_are_left_to_simulate() -> None:
    mechanism = mq.textbook.load("chained_four_bars", n=1)
    q = np.array([[0.2, 0.2, -0.2], [1.0, 1.0, -1.0]])
    v = np.array([[-4.0, -4.0, 4.0], [0.0, 0.0, 0.0]])
    runs = mq.simulate_many(mechanism, q, v, duration=0.08, rtol=1e-6)
    assert runs.method.startswith("compiled")
    assert runs["theta0"][0, -1] < -0.05
    np.testing.assert_allclose(runs["theta0"], runs["theta1"], rtol=0, atol=1e-12)
    assert not len(runs.failed)


@pytest.mark.slow
def test_loops_that_cannot_be_closed_fail_alone() -> None:
    mechanism = mq.textbook.load("four_bar_linkage")
    runs = mq.simulate_many(
        mechanism, closed_starts(1)[0], parameters={"b": [2.2, 9.0]}, duration=0.1
    )
    assert runs.failed.tolist() == [1]


def test_closed_mechanisms_without_a_compiler_run_one_by_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    mechanism = mq.textbook.load("four_bar_linkage")
    monkeypatch.setattr("mecanique.motion.ensemble.simulate_many.can_compile", lambda: False)
    runs = mq.simulate_many(mechanism, closed_starts(2), duration=0.1)
    assert runs.method.startswith("single")
    assert "chosen because no C compiler works here" in runs.method
    assert not len(runs.failed)
    with pytest.raises(mq.DerivationError, match="which method 'batch' does not keep"):
        mq.simulate_many(mechanism, closed_starts(2), method="batch")


def test_a_run_that_fails_leaves_the_others_alone() -> None:
    mechanism = mq.textbook.load("kepler_orbit", mu=1.0)
    runs = mq.simulate_many(
        mechanism,
        {"r": [1.0, 1.0, 2.0]},
        {"phi": [1.0, 0.0, 8**-0.5]},
        duration=1.2,
        method="batch",
        max_steps=3000,
    )  # two circles; the second planet falls into the center
    assert runs.failed.tolist() == [1]
    assert np.isnan(runs.q[1, -1]).all()
    assert np.isfinite(runs.q[1, 0]).all()
    np.testing.assert_allclose(runs["r"][[0, 2], -1], [1.0, 2.0], rtol=0, atol=1e-11)
    np.testing.assert_allclose(runs["phi"][[0, 2], -1], [1.2, 1.2 * 8**-0.5], rtol=0, atol=1e-11)


def sweep_of_pendulums(**options: Any) -> mq.Runs:
    mechanism = mq.textbook.load("rigid_bar_pendulum")
    q = {"q": np.linspace(0.1, 2.0, 40)}
    return mq.simulate_many(mechanism, q, duration=1.0, method="batch", chunk=5, **options)


def test_an_executor_gives_what_this_process_gives(tmp_path: Path) -> None:
    alone = sweep_of_pendulums()
    with ThreadPoolExecutor(2) as executor:
        shared = sweep_of_pendulums(executor=executor, directory=tmp_path / "runs")
    assert np.array_equal(alone.q, shared.q)
    assert len(list((tmp_path / "runs").glob("runs_*.npz"))) == 8
    pieces = list(shared.chunks())
    assert np.array_equal(np.concatenate([at for at, _, _ in pieces]), np.arange(40))
    assert np.array_equal(np.concatenate([v for _, _, v in pieces]), alone.v)


def test_what_is_done_before_an_interruption_is_kept_and_continued(tmp_path: Path) -> None:
    def stop(fraction: float) -> None:
        if fraction >= 0.5:
            raise KeyboardInterrupt

    with pytest.raises(
        mq.IntegrationError, match=r"interrupted: 20 of 40 runs done.*the same call continues"
    ) as info:
        sweep_of_pendulums(directory=tmp_path, progress=stop)
    partial = info.value.motion
    assert partial.done == 20
    assert np.isnan(partial.q[20:]).all()
    files = {path: path.stat().st_mtime_ns for path in tmp_path.glob("runs_*.npz")}
    fractions: list[float] = []
    runs = sweep_of_pendulums(directory=tmp_path, progress=fractions.append)
    assert fractions == [0.5, 0.625, 0.75, 0.875, 1.0]
    assert all(path.stat().st_mtime_ns == written for path, written in files.items())
    assert np.array_equal(runs.q, sweep_of_pendulums().q)


def fatal(part: Part) -> Any:
    """Ends its own process on the sixth part, the first time."""
    mark = Path(os.environ["MECANIQUE_TEST_MARK"])
    if part.first == 25 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return run_part(part)


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="no signals")
def test_a_killed_worker_loses_nothing_that_is_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MECANIQUE_TEST_MARK", str(tmp_path / "mark"))
    monkeypatch.setattr("mecanique.motion.ensemble.simulate_many.run_part", fatal)
    with (
        ProcessPoolExecutor(1, mp_context=get_context("spawn")) as executor,
        pytest.raises(mq.IntegrationError, match="the executor broke") as info,
    ):
        sweep_of_pendulums(executor=executor, directory=tmp_path / "runs")
    assert info.value.motion.done == 25
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as executor:
        runs = sweep_of_pendulums(executor=executor, directory=tmp_path / "runs")
    assert runs.done == 40
    assert np.array_equal(runs.q, sweep_of_pendulums().q)


T = TypeVar("T")


class Counting(Executor):
    """Runs at once, in this process, and notes how many futures were waiting."""

    def __init__(self) -> None:
        self.parts: list[int] = []

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        future: Future[T] = Future()
        self.parts.append(args[0].first)
        try:
            future.set_result(fn(*args, **kwargs))
        except ValueError as error:
            future.set_exception(error)
        return future


def test_every_part_is_submitted_once() -> None:
    executor = Counting()
    sweep_of_pendulums(executor=executor)
    assert executor.parts == list(range(0, 40, 5))


def test_threads_share_the_runs_of_a_chunk() -> None:
    mechanism = mq.textbook.load("rigid_bar_pendulum")
    q, lengths = np.linspace(0.1, 1.0, 1200), np.linspace(0.5, 1.5, 1200)
    start = np.column_stack([q, np.zeros(1200)])
    given = (
        0,
        pickle.dumps(mechanism),
        start[:, :1],
        start[:, 1:],
        {"l": lengths},
        np.array([0.0, 0.5]),
        "batch",
    )
    one, two = (run_part(Part(*given, 1e-10, 1e-10, 1000, threads)) for threads in (1, 2))
    assert two.q.shape == (1200, 2, 1)
    np.testing.assert_allclose(one.q, two.q, rtol=0, atol=1e-10)
    np.testing.assert_allclose(one.v, two.v, rtol=0, atol=1e-10)


def test_a_directory_of_other_runs_is_refused(tmp_path: Path) -> None:
    sweep_of_pendulums(directory=tmp_path)
    with pytest.raises(
        mq.InputError, match=r"holds other runs \(other settings\); choose another directory"
    ):
        sweep_of_pendulums(directory=tmp_path, rtol=1e-5)
    (tmp_path / "runs_000000000.npz").write_bytes(b"PK")
    with pytest.raises(mq.InputError, match=r"cannot be read .*; delete it and run again"):
        _ = sweep_of_pendulums(directory=tmp_path).q


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"q": {"q1": [0.1, 0.2]}, "v": {"q2": [1, 2, 3]}},
            r"expected one number of runs in q, v and parameters, got \[2, 3\]",
        ),
        (
            {"q": {"q1": [0.1, 0.2], "q2": [1, 2, 3]}},
            r"expected one number of coordinate values each, got \[2, 3\]",
        ),
        (
            {"q": np.zeros((2, 3))},
            r"expected shape \(2,\) or \(n, 2\) for the coordinate values \(q1, q2\), got \(2, 3\)",
        ),
        (
            {"q": {"q1": np.zeros((2, 2))}},
            r"expected a number or shape \(n,\) for coordinate q1, got shape \(2, 2\)",
        ),
        ({"q": {"q1": [np.nan]}}, "expected finite numbers for coordinate q1"),
        ({"q": {"q1": []}}, "expected at least one number for coordinate q1, got none"),
        ({"q": {"q1": "much"}}, "expected a finite number for coordinate q1, got 'much'"),
        ({"parameters": {"x": 1.0}}, "unknown parameter 'x'"),
        ({"parameters": [1.0]}, "expected parameters by symbol"),
        ({"v": {"theta": 1.0}}, "unknown velocity 'theta'"),
        ({"method": "euler"}, "unknown method 'euler'"),
        ({"chunk": 0}, "expected a whole number of at least 1 for chunk, got 0"),
        ({"parameters": {"m1": [1.0, -1.0]}}, "its mass is negative"),
    ],
)
def test_refusals(options: dict[str, Any], message: str) -> None:
    with pytest.raises(mq.MecaniqueError, match=message):
        mq.simulate_many(mq.textbook.load("double_pendulum"), **options)


@pytest.mark.slow
def test_a_dask_cluster_with_a_killed_worker_completes_the_runs(tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    import dask

    # a loaded machine takes its time to start a cluster; a dead worker is not to be waited for
    patience = {
        "distributed.comm.timeouts.connect": "300s",
        "distributed.comm.timeouts.tcp": "300s",
    }
    with dask.config.set(patience):
        cluster = distributed.LocalCluster(
            n_workers=2,
            threads_per_worker=1,
            processes=True,
            dashboard_address=None,
            local_directory=str(tmp_path),
        )
        client = distributed.Client(cluster)
    with cluster, client:
        victims = [worker.process.pid for worker in cluster.workers.values()]

        def kill(fraction: float) -> None:
            if fraction >= 0.25 and len(victims) == 2:
                os.kill(victims.pop(), signal.SIGKILL)

        runs = sweep_of_pendulums(executor=client.get_executor(), progress=kill)
    assert len(victims) == 1
    assert runs.done == 40
    assert np.array_equal(runs.q, sweep_of_pendulums().q)


def test_what_rolls_keeps_rolling_in_many_runs() -> None:
    mechanism = mq.textbook.load("chaplygin_sleigh")
    spin = mechanism.velocities[-1]
    runs = mq.simulate_many(mechanism, v={spin: [1.0, 2.0]}, duration=1.0, rtol=1e-9)
    assert not runs.method.startswith(("batch", "taylor"))
    for k in range(2):
        alone = runs.motion(k, samples=2)
        np.testing.assert_allclose(runs.v[k, -1], alone.v[-1], rtol=0, atol=1e-10)


def test_chunks_of_other_shapes_are_refused(tmp_path: Path) -> None:
    """Three runs in place of ten had been read as seven that failed, without a word."""
    runs = sweep_of_pendulums(directory=tmp_path)
    path = next(tmp_path.glob("*.npz"))
    with np.load(path) as arrays:
        cut = {name: arrays[name][:1] for name in arrays.files}
    np.savez(path, **cut)
    with pytest.raises(mq.InputError, match=r"expected numbers of shape .*; delete it and run"):
        _ = sweep_of_pendulums(directory=tmp_path).q
    assert len(runs) > 1


def test_an_executors_own_error_keeps_the_runs_that_are_done() -> None:
    class Failing(ThreadPoolExecutor):
        """Takes one part, and then no more."""

        taken = 0

        def submit(self, *args: Any, **options: Any) -> Any:
            self.taken += 1
            if self.taken > 1:
                raise RuntimeError("no more workers")
            future = super().submit(*args, **options)
            future.result()
            return future

    with Failing(1) as executor, pytest.raises(mq.IntegrationError) as caught:
        sweep_of_pendulums(executor=executor)
    assert "the executor broke (RuntimeError: no more workers): 5 of 40 runs done" in str(
        caught.value
    )
    assert caught.value.motion is not None
