"""FMUs: validated, run and compared with Pinocchio, and simulated as `simulate` does."""

from __future__ import annotations

import re
import subprocess
import zipfile
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from sides import (
    CORNER,
    make_braked,
    make_buffer,
    make_corner,
    make_pair,
    make_rod,
    make_sled,
    make_slope,
    make_tow,
)

import mecanique as mq
from mecanique.generation import dop853
from mecanique.generation.build import build_program
from mecanique.generation.targets import fmu as target
from mecanique.generation.targets.c import WARNINGS, compiler
from mecanique.generation.targets.target import run_command
from mecanique.reference.engine.package import has_pinocchio

fmpy = pytest.importorskip("fmpy")
from fmpy.fmi1 import FMICallException  # noqa: E402
from fmpy.fmi3 import FMU3Model  # noqa: E402
from fmpy.validation import validate_fmu  # noqa: E402


@pytest.fixture(scope="module")
def write(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    @cache
    def made(name: str) -> Path:
        entry = mq.textbook.entry(name)
        q = dict(entry.start)
        v = {rate.removesuffix("'"): value for rate, value in entry.start_velocity.items()}
        code = mq.generate(mq.derive(entry.mechanism()), "fmu", "energy", q=q, v=v, samples=4)
        assert code.verdict is not None
        assert code.verdict.worst["rhs"] < 1e-13
        assert code.verdict.worst["co-simulation"] < 1e-8
        return code.write(tmp_path_factory.mktemp(name))[0]

    return made


def model(path: Path, folder: Path, log: list[str]) -> FMU3Model:
    """An instance for model exchange, with its messages."""
    description = fmpy.read_model_description(str(path))
    found = FMU3Model(
        guid=description.guid,
        unzipDirectory=fmpy.extract(str(path), str(folder)),
        modelIdentifier=description.modelExchange.modelIdentifier,
        instanceName="test",
    )
    found.instantiate(logMessage=lambda *said: log.append(said[-1].decode()))
    return found


@pytest.mark.parametrize("name", ["cart_pole", "free_rigid_body", "four_bar_linkage"])
def test_both_kinds_of_simulation_move_as_simulate_does(
    name: str, write: Callable[[str], Path], tmp_path: Path
) -> None:
    path, entry = write(name), mq.textbook.entry(name)
    assert validate_fmu(str(path)) == []
    mechanism = entry.mechanism()
    q = mq.assemble(mechanism, dict(entry.start))
    v = dict(entry.start_velocity)
    motion = mq.simulate(mechanism, q=q, v=v, duration=2.0, rtol=1e-12)
    for kind, most in (("ModelExchange", 2e-5), ("CoSimulation", 1e-6)):
        found = fmpy.simulate_fmu(
            str(path),
            fmi_type=kind,
            stop_time=2.0,
            output_interval=0.25,
            relative_tolerance=1e-9,
        )
        exact = motion(found["time"])
        states = np.array([found[name] for name in mechanism.coordinates]).T
        assert np.abs(states - exact.q).max() < most
        energy = mq.Reference(mechanism).energy(exact.q, exact.v)
        np.testing.assert_allclose(found["kinetic_energy"], energy.kinetic, rtol=0, atol=200 * most)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["squeezer", "kapitza_pendulum"])
def test_what_moves_fast_is_compared_over_short_steps(
    name: str, write: Callable[[str], Path]
) -> None:
    assert validate_fmu(str(write(name))) == []


def test_the_model_describes_its_variables(write: Callable[[str], Path], tmp_path: Path) -> None:
    path = write("four_bar_linkage")
    described = fmpy.read_model_description(str(path))
    variables = {variable.name: variable for variable in described.modelVariables}
    assert described.fmiVersion == "3.0"
    assert described.modelExchange.needsCompletedIntegratorStep
    rate = variables["der(theta)"]
    assert rate.derivative is variables["theta"]
    assert rate.unit == "rad/s"
    assert variables["der(theta')"].derivative is variables["theta'"]
    units = {unit.name: unit.baseUnit for unit in described.unitDefinitions}
    assert (units["rad/s"].rad, units["rad/s"].s, units["J"].kg, units["J"].s) == (1, -1, 1, -2)
    kinds = {name: v.variability for name, v in variables.items() if v.causality == "parameter"}
    assert kinds["g"] == "tunable"
    assert "fixed" in kinds.values()
    assert variables["tau_theta'"].causality == "input"


def test_a_parameter_can_be_tuned_while_the_model_moves(
    write: Callable[[str], Path], tmp_path: Path
) -> None:
    path, mechanism = write("simple_pendulum"), mq.textbook.load("simple_pendulum")
    said: list[str] = []
    fmu = model(path, tmp_path, said)
    numbers = {
        variable.name: variable.valueReference
        for variable in fmpy.read_model_description(str(path)).modelVariables
    }
    fmu.setFloat64([numbers["q"]], [0.3])
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    kept = fmu.getFMUState()
    for l in (1.0, 2.5):
        fmu.setFloat64([numbers["l"]], [l])
        (found,) = fmu.getFloat64([numbers["der(q')"]])
        assert found == pytest.approx(-mechanism.values["g"] / l * np.sin(0.3), rel=1e-14)
    restored = fmu.deserializeFMUState(fmu.serializeFMUState(kept))
    fmu.setFMUState(restored)
    assert fmu.getFloat64([numbers["l"]]) == [mechanism.values["l"]]
    for name, message in (
        ("q", "a state is set by its start value"),
        ("kinetic_energy", "this variable is computed, and cannot be set"),
    ):
        with pytest.raises(FMICallException):
            fmu.setFloat64([numbers[name]], [0.5])
        assert said[-1] == message
    with pytest.raises(FMICallException):
        fmu.setFloat64([numbers["l"]], [float("nan")])
    assert said[-1] == "expected a finite value"
    fmu.freeInstance()


def test_lengths_of_loops_stay_and_a_start_off_them_is_refused(
    write: Callable[[str], Path], tmp_path: Path
) -> None:
    path = write("four_bar_linkage")
    said: list[str] = []
    fmu = model(path, tmp_path, said)
    variables = {v.name: v for v in fmpy.read_model_description(str(path)).modelVariables}
    fixed = next(v for v in variables.values() if v.variability == "fixed")
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    with pytest.raises(FMICallException):
        fmu.setFloat64([fixed.valueReference], [2.0])
    assert said[-1] == "a parameter on which closed loops depend is fixed"
    fmu.reset()
    fmu.setFloat64([variables["theta"].valueReference], [2.9])
    fmu.enterInitializationMode()
    with pytest.raises(FMICallException):
        fmu.exitInitializationMode()
    assert said[-1].startswith("the start is not on the closed loops")
    fmu.freeInstance()


def test_a_model_that_gives_something_else_is_not_handed_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    right = target.write_source
    monkeypatch.setattr(
        target,
        "write_source",
        lambda program: right(program).replace("out[1] = ", "out[1] = 1e-9 + ", 1),
    )
    with pytest.raises(mq.DerivationError, match="and the reference disagree: rhs differs by"):
        mq.generate(mq.derive(mq.textbook.load("simple_pendulum")), "fmu", samples=3)


@pytest.mark.parametrize("name", ["cart_pole", "ladder"])
def test_the_sources_travel_and_compile_without_warnings(
    name: str,
    write: Callable[[str], Path],
    write_modes: Callable[[str], Path],
    tmp_path: Path,
) -> None:
    path = write(name) if name == "cart_pole" else write_modes(name)
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
        text = archive.read(f"sources/{name}.c")
        page = archive.read("documentation/index.html").decode()
    where, ending = target.platform_of()
    assert f"binaries/{where}/{name}{ending}" in names
    engine = "Pinocchio" if has_pinocchio() else "a stand-in for Pinocchio"
    assert f"Run and compared with {engine} at 4 random states" in page
    (tmp_path / f"{name}.c").write_bytes(text)
    source = str(tmp_path / f"{name}.c")
    subprocess.run([compiler(), *WARNINGS, "-fsyntax-only", source], check=True)


def test_the_library_has_the_ending_of_its_system(monkeypatch: pytest.MonkeyPatch) -> None:
    """On Windows gcc would add .exe to what has none."""
    commands: list[list[str]] = []

    def record(command: list[str]) -> object:
        commands.append(command)
        return run_command(command)

    monkeypatch.setattr("mecanique.generation.targets.fmu.run_command", record)
    target._build("one", "int one(void) { return 1; }")
    (command,) = commands
    assert Path(command[command.index("-o") + 1]).name == f"one{target.platform_of()[1]}"


def test_what_a_model_cannot_have_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    pendulum = mq.derive(mq.textbook.load("simple_pendulum"))
    with pytest.raises(mq.DerivationError, match="accelerations, which are not inputs of an FMU"):
        mq.generate(pendulum, "fmu", "inverse_dynamics")
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CC", raising=False)
    code = mq.generate(pendulum, "fmu", samples=3)
    assert code.verdict is None
    content = code.files["simple_pendulum.fmu"]
    assert isinstance(content, bytes)
    assert b"sources/simple_pendulum.c" in content
    assert b"binaries/" not in content


def test_the_law_of_corners_in_c_has_no_tolerance_of_its_own() -> None:
    text = Path(target.__file__).with_name("corners.c").read_text(encoding="utf-8")
    assert set(re.findall(r"\b[\d.]+e-\d+", text)) == {"1e-300"}


def test_constants_of_steps_stand_in_one_table(monkeypatch: pytest.MonkeyPatch) -> None:
    """What C is written with follows the table, and its text has no number of its own instead."""
    monkeypatch.setattr(dop853, "CLOSED", 3e-11)
    monkeypatch.setattr(dop853, "SWEEPS", 9)
    program = build_program(mq.derive(mq.textbook.load("four_bar_linkage")), "rhs", moves=True)
    source = target.write_source(replace(program, start=(0.0,) * 6))
    assert "static const double CLOSED = 3e-11;" in source
    assert "enum { SWEEPS = 9 };" in source
    text = Path(target.__file__).with_name("stepper.c").read_text(encoding="utf-8")
    assert not re.findall(r"\b[\d.]+e-\d+|\b0\.04\b|\b0\.9\b|\b6\.1\b", text)


SWITCHING = ("bouncing_ball", "dry_oscillator", "ladder", "newtons_cradle", "painleve_rod")


@pytest.fixture(scope="module")
def write_modes(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    @cache
    def made(name: str) -> Path:
        entry = mq.textbook.entry(name)
        q, v = dict(entry.start), dict(entry.start_velocity)
        code = mq.generate(mq.derive_modes(entry.mechanism()), "fmu", q=q, v=v, samples=4)
        assert code.verdict is not None
        assert max(code.verdict.worst.values()) < 1e-13
        return code.write(tmp_path_factory.mktemp(name))[0]

    return made


@pytest.mark.parametrize("name", SWITCHING)
def test_what_switches_moves_through_its_corners(
    name: str, write_modes: Callable[[str], Path]
) -> None:
    path, entry = write_modes(name), mq.textbook.entry(name)
    assert validate_fmu(str(path)) == []
    mechanism = entry.mechanism()
    q, v = dict(entry.start), dict(entry.start_velocity)
    motion = mq.simulate(mechanism, q=q, v=v, duration=entry.duration, rtol=1e-12)
    assert motion.events
    # an importing tool finds corners by its own tolerance
    for kind, most in (("CoSimulation", 1e-10), ("ModelExchange", 1e-6)):
        found = fmpy.simulate_fmu(
            str(path),
            fmi_type=kind,
            stop_time=entry.duration,
            output_interval=entry.duration / 50,
            relative_tolerance=1e-10,
        )
        exact = motion(np.minimum(found["time"], entry.duration))
        states = np.array([found[name] for name in mechanism.coordinates]).T
        assert np.abs(states - exact.q).max() < most
        for element, state in motion.modes[-1].states.items():
            code = {"open": 0, "closed": 1, "sticks": 1, "slips +": 2, "slips -": 3}[state]
            assert found[f"state[{element}]"][-1] == code


@pytest.mark.slow
def test_a_model_slips_in_space(write_modes: Callable[[str], Path]) -> None:
    """A tippe top slips in a direction that turns round and round, until it rolls at 1.025 s."""
    path, entry = write_modes("tippe_top"), mq.textbook.entry("tippe_top")
    assert validate_fmu(str(path)) == []
    mechanism = entry.mechanism()
    v = {rate.removesuffix("'"): value for rate, value in entry.start_velocity.items()}
    motion = mq.simulate(mechanism, q=entry.start, v=v, duration=1.2, rtol=1e-12)
    for kind, most in (("CoSimulation", 1e-9), ("ModelExchange", 1e-6)):
        found = fmpy.simulate_fmu(
            str(path),
            fmi_type=kind,
            stop_time=1.2,
            output_interval=0.02,
            relative_tolerance=1e-10,
        )
        exact = motion(np.minimum(found["time"], 1.2))
        states = np.array([found[name] for name in mechanism.coordinates]).T
        np.testing.assert_allclose(states, exact.q, rtol=0, atol=most)
        state = found["state[floor]"]
        assert {*state[found["time"] < 1.02]} == {2}
        assert {*state[found["time"] > 1.03]} == {1}


@pytest.mark.parametrize(
    ("mechanism", "q"),
    [(make_tow(), {"y": 0.05}), (make_pair(), {}), (make_tow(2), {"y1": 0.05, "y2": -0.05})],
    ids=["space", "pair", "both"],
)
def test_a_model_begins_to_slip_in_space_and_of_two_at_once(
    mechanism: mq.Mechanism, q: dict[str, float], tmp_path: Path
) -> None:
    modes, v = mq.derive_modes(mechanism), {"x": 1.0}
    path = mq.generate(modes, "fmu", q=q, v=v, samples=4).write(tmp_path)[0]
    motion = mq.simulate(mechanism, q=q, v=v, duration=0.5, rtol=1e-12)
    for kind, most in (("CoSimulation", 1e-11), ("ModelExchange", 1e-7)):
        moved = fmpy.simulate_fmu(
            str(path), fmi_type=kind, stop_time=0.5, output_interval=0.01, relative_tolerance=1e-10
        )
        exact = motion(np.minimum(moved["time"], 0.5))
        states = np.array([moved[name] for name in mechanism.coordinates]).T
        np.testing.assert_allclose(states, exact.q, rtol=0, atol=most)


def test_a_model_s_sled_falls_when_its_end_passes_the_edge(tmp_path: Path) -> None:
    q, v, duration = {"x": -0.5}, {"x": 2.0}, 0.8
    modes = mq.derive_modes(make_sled(0.4))
    path = mq.generate(modes, "fmu", q=q, v=v, samples=4).write(tmp_path)[0]
    for kind, most in (("CoSimulation", 1e-12), ("ModelExchange", 1e-7)):
        found = fmpy.simulate_fmu(
            str(path),
            fmi_type=kind,
            stop_time=duration,
            output_interval=duration / 40,
            relative_tolerance=1e-10,
        )
        falls = np.maximum(found["time"] - 0.35, 0.0)
        assert np.abs(found["z"] + 9.81 / 2 * falls**2).max() < most
        assert {*found["state[front]"]} == {*found["state[lip]"]} == {0, 1}


@pytest.mark.parametrize("mu", [0.0, 0.2])
def test_a_model_ends_bounces_while_another_contact_is_held(mu: float, tmp_path: Path) -> None:
    """Bounces between a slope and a wall end, with e = 1/2, at thrice the time of the first."""
    corner, first = make_corner(mu), np.sqrt(4 * 0.3 / np.cos(np.pi / 6) / 9.81)
    modes = mq.derive_modes(corner)
    path = mq.generate(modes, "fmu", q=CORNER, samples=4).write(tmp_path)[0]
    motion = mq.simulate(corner, q=CORNER, duration=1.5, rtol=1e-12)
    found = fmpy.simulate_fmu(
        str(path), fmi_type="CoSimulation", stop_time=1.5, output_interval=0.0005
    )
    exact = motion(np.minimum(found["time"], 1.5)).q
    np.testing.assert_allclose(np.array([found["x"], found["z"]]).T, exact, rtol=0, atol=1e-10)
    assert found["state[slope]"][-1] == found["state[wall]"][-1] == 1
    if mu == 0:
        rests = found["time"][found["state[wall]"] == 1][0]
        assert rests == pytest.approx(3 * first, rel=0, abs=0.0005)


def test_a_model_ends_bounces_with_their_friction(tmp_path: Path) -> None:
    slope, q = make_slope(0.1), {"x": 0.15, "z": 0.26}
    path = mq.generate(mq.derive_modes(slope), "fmu", q=q, samples=4).write(tmp_path)[0]
    motion = mq.simulate(slope, q=q, duration=2.0, rtol=1e-12)
    found = fmpy.simulate_fmu(
        str(path), stop_time=2.0, output_interval=0.05, relative_tolerance=1e-12
    )
    exact = motion(np.minimum(found["time"], 2.0)).q
    np.testing.assert_allclose(np.array([found["x"], found["z"]]).T, exact, rtol=0, atol=1e-12)


def test_in_a_model_a_wall_bears_what_a_spent_brake_cannot(tmp_path: Path) -> None:
    """The block stays until the spring pulls it off by 1 N, at sin(√10 t) = −1/3."""
    braked, v = make_braked(), {"y": 0.3 * np.sqrt(10)}
    path = mq.generate(mq.derive_modes(braked), "fmu", v=v, samples=4).write(tmp_path)[0]
    motion = mq.simulate(braked, v=v, duration=3.0, rtol=1e-12)
    for kind, most in (("CoSimulation", 1e-11), ("ModelExchange", 1e-7)):
        found = fmpy.simulate_fmu(
            str(path),
            fmi_type=kind,
            stop_time=3.0,
            output_interval=0.05,
            relative_tolerance=1e-10,
        )
        exact = motion(np.minimum(found["time"], 3.0)).q
        states = np.array([found["x"], found["y"]]).T
        np.testing.assert_allclose(states, exact, rtol=0, atol=most)
        off = (np.pi + np.arcsin(1 / 3)) / np.sqrt(10)
        before, at_wall = found["time"] < off - 0.01, found["state[wall]"]
        assert not found["x"][before].any()
        assert {*at_wall[before & (found["time"] > 0.11)]} == {1}
        assert {*at_wall[found["time"] > off + 0.06]} == {0}


def test_a_model_leaves_an_elastic_stop(tmp_path: Path) -> None:
    v = {"x": 2.0}
    path = mq.generate(mq.derive_modes(make_buffer()), "fmu", v=v, samples=4).write(tmp_path)[0]
    found = fmpy.simulate_fmu(
        str(path),
        fmi_type="CoSimulation",
        stop_time=1.0,
        output_interval=0.1,
        relative_tolerance=1e-10,
    )
    left = 1.0 - 0.1 - np.pi / 20
    assert found["x"][-1] == pytest.approx(0.2 - 2.0 * left, rel=0, abs=1e-9)


def test_a_model_has_poissons_impacts(tmp_path: Path) -> None:
    """The slip of a rod turns round as it is compressed, by Routh's diagram."""
    q, v = {"z": 0.9, "th": 0.2}, {"x": 0.3}
    modes = mq.derive_modes(make_rod("poisson"))
    code = mq.generate(modes, "fmu", q=q, v=v, samples=4)
    assert code.verdict is not None
    assert code.verdict.worst["impact_end"] < 1e-12
    ends = {}
    for law in ("newton", "poisson"):
        ends[law] = mq.simulate(make_rod(law), q=q, v=v, duration=0.45, rtol=1e-12)(0.45).q
    found = fmpy.simulate_fmu(str(code.write(tmp_path)[0]), fmi_type="CoSimulation", stop_time=0.45)
    last = [found[name][-1] for name in ("x", "z", "th")]
    np.testing.assert_allclose(last, ends["poisson"], rtol=0, atol=1e-9)
    assert np.abs(ends["newton"] - ends["poisson"]).max() > 1e-3


def test_a_model_says_what_comes_in_below_a_side(tmp_path: Path) -> None:
    sled, log = make_sled(0.4), list[str]()
    sled = replace(sled, switching=sled.switching[:1])
    modes, start = mq.derive_modes(sled), {"x": 0.0, "z": -0.1}
    path = mq.generate(modes, "fmu", q=start, v={"x": -1.0}, samples=4).write(tmp_path)[0]
    with pytest.raises(FMICallException):
        fmpy.simulate_fmu(
            str(path), stop_time=0.3, logger=lambda *said: log.append(said[-1].decode())
        )
    # its front corner is 0.2 m ahead and falls 0.2 g/2 m meanwhile
    assert log[0].startswith("front comes in from beyond an end of its side, below it, at t = 0.2")


def test_a_bouncing_ball_rests_in_co_simulation_when_its_sum_ends(
    write_modes: Callable[[str], Path],
) -> None:
    found = fmpy.simulate_fmu(
        str(write_modes("bouncing_ball")), stop_time=4.2, output_interval=0.001
    )
    rests = found["time"][found["state[floor]"] == 1][0]
    assert rests == pytest.approx(np.sqrt(2 / 9.81) * 1.8 / 0.2, rel=0, abs=0.001)
    assert np.abs(found["z"][found["time"] >= rests]).max() < 1e-13


def test_a_model_says_where_no_mode_follows_and_what_begins_within(
    write_modes: Callable[[str], Path], tmp_path: Path
) -> None:
    log: list[str] = []
    ball = model(write_modes("bouncing_ball"), tmp_path / "ball", log)
    ball.setFloat64([1], [-0.1])
    ball.enterInitializationMode(startTime=0.0)
    with pytest.raises(FMICallException):
        ball.exitInitializationMode()
    assert log == ["floor starts with its bodies one within the other, by 0.1"]
    log.clear()
    rod = model(write_modes("painleve_rod"), tmp_path / "rod", log)
    described = fmpy.read_model_description(str(write_modes("painleve_rod")))
    places = {v.name: v.valueReference for v in described.modelVariables}
    # beyond the first paradox, at tan θ = 2 and μ > 4/3, a rod that slides has no mode that follows
    rod.setFloat64([places["mu"]], [1.6])
    rod.enterInitializationMode(startTime=0.0)
    with pytest.raises(FMICallException):
        rod.exitInitializationMode()
    assert log == [
        "0 modes that rigid bodies determine follow at t = 0 s, where one is expected (Painleve)"
    ]
