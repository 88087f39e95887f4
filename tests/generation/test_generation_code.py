"""Code in C, JavaScript and Python: that of every system, run and compared with Pinocchio."""

from __future__ import annotations

import json
import runpy
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sympy
from systems import CLOSED, FREE, derive_system

import mecanique as mq
from mecanique.generation import compiled
from mecanique.generation.identifiers import identifiers, mangle, unmangle
from mecanique.generation.targets.c import LONG, WARNINGS, compiler, limit_optimization
from mecanique.generation.targets.javascript import JavaScript
from mecanique.generation.targets.python import Python

pytestmark = pytest.mark.usefixtures("in_process")

QUICK = {"crane", "double_pendulum", "foucault_pendulum", "free_rigid_body", "two_blocks"}
"""Compiled in every run; the others where slow tests run."""
OF_TREES = (
    "rhs",
    "acceleration",
    "energy",
    "mass_matrix",
    "bias",
    "gravity",
    "forces",
    "inverse_dynamics",
    "poses",
    "jacobians",
)


def test_very_long_c_is_not_optimized(tmp_path: Path) -> None:
    short, long = tmp_path / "short.c", tmp_path / "long.c"
    short.write_text("int x;\n" * 100, encoding="utf-8")
    long.write_text("int x;\n" * (LONG + 1), encoding="utf-8")
    assert limit_optimization([short]) == []
    assert limit_optimization([short, long]) == ["-O0"]


def test_a_compiler_that_does_not_end_is_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "SECONDS", 1e-3)
    with pytest.raises(mq.InputError, match="the C compiler did not end within 0 s"):
        compiled.build_library({"one.c": "int one(void) { return 1; }\n"})


def assert_code_agrees(name: str, target: str) -> None:
    samples = 100 if name in QUICK else 20
    verdict = mq.generate(derive_system(name), target, OF_TREES, samples=samples).verdict
    assert verdict is not None
    assert verdict.samples == samples
    assert verdict.worst.keys() == set(OF_TREES)
    for quantity, worst in verdict.worst.items():
        assert worst <= max(1e-13, verdict.rounded[quantity])


@pytest.mark.parametrize("name", FREE)
def test_the_python_code_of_every_tree_gives_what_pinocchio_gives(name: str) -> None:
    assert_code_agrees(name, "python")


COMPILED = [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in FREE]


@pytest.mark.parametrize("target", ["c", "javascript"])
@pytest.mark.parametrize("name", COMPILED)
def test_the_compiled_code_of_every_tree_gives_what_pinocchio_gives(name: str, target: str) -> None:
    assert_code_agrees(name, target)


def test_a_spring_in_a_screw_pulls_at_its_angle() -> None:
    bodies = (mq.Body("ground"), mq.Body("nut", mq.cylinder(1.5, 0.1, 0.2)))
    screw = mq.Helical("screw", "ground", "nut", pitch=0.02)
    spring = mq.JointSpring("thread", "screw", 3.0, 0.4)
    press = mq.Mechanism("press", bodies, (screw,), forces=(spring,))
    sprung = mq.derive(press)
    verdict = mq.generate(sprung, "python", ("rhs", "forces", "energy")).verdict
    assert verdict is not None
    assert max(verdict.worst.values()) <= 1e-12
    assert sprung.forces([0.5]) == pytest.approx([-3.0 * (0.5 - 0.4)], abs=1e-12)


@pytest.mark.parametrize("name", ["pi", "E", "GoldenRatio", "Catalan"])
def test_constants_are_numbers_in_programs(name: str) -> None:
    constant: sympy.NumberSymbol = getattr(sympy, name)
    point = mq.Body("point", mq.particle(2.0))
    slide = mq.Prismatic("slide", "ground", "point", axis=(1, 0, 0), coordinate="x")
    pull = mq.JointForce("pull", "slide", -constant * mq.coordinate("x"))
    mechanism = mq.Mechanism("spring", (mq.Body("ground"), point), (slide,), forces=(pull,))
    program = mq.generate(mq.derive(mechanism), "c", ("rhs", "forces")).compile()
    assert program.forces(0.0, [0.5], [0.0]) == pytest.approx([-0.5 * float(constant)], rel=1e-15)


@pytest.mark.parametrize("name", CLOSED)
def test_the_code_of_every_closed_mechanism_gives_what_pinocchio_gives(name: str) -> None:
    what = ["rhs", "acceleration_by_tau", "energy", "closure"]
    if name != "bricard_linkage":  # where they are not determined
        what.append("multipliers")
    verdict = mq.generate(derive_system(name), "python", what, samples=10).verdict
    assert verdict is not None
    for quantity in ("rhs", "closure"):
        assert verdict.worst[quantity] <= max(1e-13, verdict.rounded[quantity])


@pytest.mark.parametrize(
    "name", ["cart_pole", "double_pendulum", "crane", "spherical_pendulum", "four_bar_linkage"]
)
def test_reactions_are_those_that_pinocchio_gives(name: str) -> None:
    code = mq.generate(derive_system(name), "python", "reactions,jacobians", samples=20)
    assert code.verdict is not None
    assert code.verdict.worst["reactions"] <= 1e-12
    mechanism = mq.textbook.load(name)
    shape = code.program.answers[0].shape
    assert shape == (len(mechanism.joints) + len(mechanism.loops), 6)


def test_a_pendulum_hangs_on_its_weight_and_its_swing() -> None:
    mechanism = mq.textbook.load("simple_pendulum")
    what = "reactions,jacobians,reactions_by_v"
    compiled = mq.generate(mq.derive(mechanism), "c", what, samples=5).compile()
    m, l, g = (mechanism.values[name] for name in ("m", "l", "g"))
    ((force, moment),) = compiled.reactions(0.0, [0.0], [0.7]).reshape(1, 2, 3)
    np.testing.assert_allclose(force, [0.0, 0.0, m * (g + l * 0.7**2)], rtol=0, atol=1e-14)
    np.testing.assert_allclose(moment, 0.0, rtol=0, atol=1e-14)
    by_speed = compiled.reactions_by_v(0.0, [0.0], [0.7])
    assert by_speed[2] == pytest.approx(2 * m * l * 0.7, rel=1e-12)
    turn = compiled.jacobians(0.0, [0.3])[0, 3:, 0]
    np.testing.assert_allclose(turn, [0.0, -1.0, 0.0], rtol=0, atol=1e-15)


@pytest.mark.parametrize("target", ["python", "c", "javascript", "jax", "casadi", "fmu"])
def test_reactions_feel_the_torques_that_drive(target: str) -> None:
    if target in ("jax", "casadi", "fmu"):
        pytest.importorskip(target.replace("fmu", "fmpy"))
    mechanism = mq.textbook.load("cart_pole")
    code = mq.generate(derive_system("cart_pole"), target, "reactions,reactions_by_tau", samples=8)
    assert code.verdict is not None
    assert code.verdict.worst["reactions"] <= 1e-12
    assert code.verdict.worst["reactions_by_tau"] <= 1e-6
    if target == "c":
        q, tau = [0.0, 0.1], [5.0, 0.0]
        wrenches = code.compile().reactions(0.0, q, [0.0, 0.0], tau)
        expected = mq.Reference(mechanism).reactions(q, tau=tau)
        for row, wrench in zip(wrenches, expected.values(), strict=True):
            np.testing.assert_allclose(row, [*wrench.force, *wrench.moment], rtol=0, atol=1e-12)


def run_reactions(target: str, folder: Path) -> np.ndarray:
    """Return what written code gives for the cart-pole at q = 0.1, tau_x' = 5, rows of 6."""
    code = mq.generate(derive_system("cart_pole"), target, "acceleration,reactions", samples=2)
    code.write(folder)
    state, tau = ([0.0, 0.1], [0.0, 0.0]), [5.0, 0.0]
    match target:
        case "javascript":
            script = (
                'import * as c from "./cart_pole.mjs"; const out = new Float64Array(12); '
                "const p = c.parameters.map((parameter) => parameter.value); "
                "c.reactions(0, [0, 0.1, 0, 0], p, out, [5, 0]); "
                "console.log(JSON.stringify([...out]))"
            )
            (folder / "ask.mjs").write_text(script, encoding="utf-8")
            asked = subprocess.run(
                ["node", "ask.mjs"], cwd=folder, capture_output=True, check=True, encoding="utf-8"
            )
            return np.array(json.loads(asked.stdout)).reshape(2, 6)
        case "fmu":
            import fmpy

            path = str(folder / "cart_pole.fmu")
            names = [v.name for v in fmpy.read_model_description(path).modelVariables]
            outputs = [name for name in names if name.startswith("reaction[")]
            start = {"q": 0.1, "tau_x'": 5.0}
            found = fmpy.simulate_fmu(path, start_values=start, stop_time=1e-3, output=outputs)
            return np.array([found[name][0] for name in outputs]).reshape(2, 6)
    module = runpy.run_path(str(folder / "cart_pole.py"))
    if target != "jax":
        return np.asarray(module["reactions"](0.0, *state, tau), dtype=float)
    import jax

    jax.config.update("jax_enable_x64", True)
    given = [np.array(values) for values in (*state, tau)]
    return np.asarray(module["reactions"](0.0, *given, p=module["PARAMETERS"]))


@pytest.mark.parametrize("target", ["python", "javascript", "jax", "fmu"])
def test_reactions_under_torques_are_those_of_the_reference(target: str, tmp_path: Path) -> None:
    if target in ("jax", "fmu"):
        pytest.importorskip(target.replace("fmu", "fmpy"))
    expected = mq.Reference(mq.textbook.load("cart_pole")).reactions([0.0, 0.1], tau=[5.0, 0.0])
    rows = [[*wrench.force, *wrench.moment] for wrench in expected.values()]
    np.testing.assert_allclose(run_reactions(target, tmp_path), rows, rtol=0, atol=1e-11)


def test_headers_tell_the_axes_of_free_bodies_and_where_damping_counts() -> None:
    code = mq.generate(derive_system("free_rigid_body"), "c", "inverse_dynamics", samples=4)
    header = str(code.files["free_rigid_body.h"])
    for line in (
        "free_vx [m/s]: velocity of the origin of 'cylinder', along the x axis of the body itself",
        "tau_free_wz [N*m]: moment about the origin of 'cylinder', along the z axis of the body",
        "qw [1]: w of the unit quaternion of 'cylinder' in the joint's frame",
        "M a + bias - forces, so beyond what springs, dampers, drives and loads exert",
    ):
        assert line in header


def test_torques_on_absolute_angles_drive_in_the_joints() -> None:
    mechanism = mq.textbook.load("double_pendulum")
    drives = (mq.JointForce("first", "pin1", -0.6), mq.JointForce("second", "pin2", -1.3))
    q, v = [0.3, 0.5], [0.2, -0.4]
    code = mq.generate(derive_system("double_pendulum"), "c", "reactions", samples=5)
    # q2 = q1 + theta2: the joints' torques 0.7 − 1.3 and −1.3 do the work of 0.7 on q1, −1.3 on q2
    found = code.compile().reactions(0.0, q, v, [0.7, -1.3])
    expected = mq.Reference(replace(mechanism, forces=drives)).reactions(q, v)
    for row, wrench in zip(found, expected.values(), strict=True):
        np.testing.assert_allclose(row, [*wrench.force, *wrench.moment], rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", ["foucault_pendulum", "free_planar_body"])
def test_reactions_of_driven_joints_with_several_coordinates_do_no_work(name: str) -> None:
    mechanism = mq.textbook.load(name)
    code = mq.generate(derive_system(name), "c", "reactions,jacobians", samples=5).compile()
    q, v, tau = (
        np.array(numbers)[: mechanism.nv]
        for numbers in ((0.3, 0.5, 0.1), (0.2, -0.4, 0.6), (7.0, -13.0, 4.0))
    )
    reaction, jacobian = code.reactions(0.2, q, v, tau)[-1], code.jacobians(0.2, q)[-1]
    assert np.abs(jacobian).max() > 0.5
    np.testing.assert_allclose(reaction @ jacobian, 0.0, rtol=0, atol=1e-12)


def test_reactions_that_nothing_determines_are_refused() -> None:
    for name, message in (
        ("bricard_linkage", "are undetermined in"),
        ("rolling_disk", "have no program: its elements, contacts or velocity constraints share"),
    ):
        with pytest.raises(mq.DerivationError, match=message):
            mq.generate(derive_system(name), "python", "reactions", samples=2)


def test_multipliers_that_are_not_determined_are_refused() -> None:
    with pytest.raises(mq.DerivationError, match="redundant, which leaves their multipliers undet"):
        mq.generate(derive_system("bricard_linkage"), "python", "multipliers", samples=2)


OPERATIONS = {
    "cart_pole": (26, 20),
    "double_pendulum": (49, 36),
    "free_rigid_body": (130, 34),
    "furuta_pendulum": (46, 34),
    "heavy_top": (60, 37),
    "n_link_pendulum": (141, 65),
    "simple_pendulum": (7, 9),
}
"""Operations of right-hand sides and energies, parameters as letters: no more than these."""


@pytest.mark.parametrize("name", OPERATIONS)
def test_programs_stay_short(name: str) -> None:
    from mecanique.generation.build import build_program

    program = build_program(derive_system(name), ("rhs", "energy"))
    found = program.count("rhs").total, program.count("energy").total
    assert found == OPERATIONS[name]


def test_the_head_states_operations_states_and_versions(tmp_path: Path) -> None:
    code = mq.generate(derive_system("cart_pole"), what=("acceleration", "energy"), samples=20)
    paths = code.write(tmp_path / "new" / "place")
    assert [path.name for path in paths] == ["cart_pole.h", "cart_pole.c", "test_cart_pole.c"]
    head = paths[0].read_text(encoding="utf-8")
    assert code.verdict is not None
    assert "the mechanism 'cart_pole' in C99" in head
    assert "at 20 random states (seed 0), 10 of them with other parameters:" in head
    assert f"acceleration: worst relative difference {code.verdict.worst['acceleration']:.1e}" in (
        head
    )
    assert f"acceleration: {code.count('acceleration')}" in head
    assert "pin " in head
    assert "1  q' [rad/s]" in head
    assert "1  m [kg]" in head
    assert repr(code).startswith("<Code of 'cart_pole': acceleration, energy in c, ")


def test_the_test_that_comes_along_passes_and_fails_rightly(tmp_path: Path) -> None:
    code = mq.generate(derive_system("furuta_pendulum"), what="rhs,energy", samples=20)
    code.write(tmp_path)
    name = "furuta_pendulum"

    def run() -> subprocess.CompletedProcess[str]:
        sources = [str(tmp_path / f"{name}.c"), str(tmp_path / f"test_{name}.c")]
        built = [compiler(), *WARNINGS, "-o", str(tmp_path / "run"), *sources, "-lm"]
        subprocess.run(built, check=True)
        return subprocess.run(
            [str(tmp_path / "run")], capture_output=True, encoding="utf-8", check=False
        )

    assert run().returncode == 0
    source = tmp_path / f"{name}.c"
    source.write_text(
        source.read_text(encoding="utf-8").replace("out[3] = ", "out[3] = 1e-9 + "),
        encoding="utf-8",
    )
    wrong = run()
    assert wrong.returncode == 1
    assert "rhs differs by" in wrong.stderr
    assert "energy differs" not in wrong.stderr


def test_code_that_gives_something_else_is_not_handed_out(monkeypatch: pytest.MonkeyPatch) -> None:
    for language, target, right, wrong in (
        (Python, "python", "np.sin(", "1e-9 + np.sin("),
        (JavaScript, "javascript", "Math.sin(", "1e-9 + Math.sin("),
    ):
        files = language.files
        monkeypatch.setattr(
            language,
            "files",
            lambda *a, files=files, right=right, wrong=wrong: {
                name: text.replace(right, wrong) for name, text in files(*a).items()
            },
        )
        with pytest.raises(mq.DerivationError, match="and the reference disagree: rhs differs by"):
            mq.generate(derive_system("simple_pendulum"), target, "rhs")


def test_compiled_functions_take_one_state_or_many() -> None:
    mechanism = mq.textbook.load("cart_pole")
    code = mq.generate(mq.derive(mechanism), what=("acceleration", "energy", "mass_matrix"))
    compiled, reference = code.compile(), mq.Reference(mechanism)
    rng = np.random.default_rng(3)
    q, v, tau = rng.normal(size=(3, 7, 2))
    a = compiled.acceleration(0.0, q, v, tau)
    np.testing.assert_allclose(a, reference.acceleration(q, v, tau=tau), rtol=1e-12, atol=0)
    assert compiled.acceleration(0.0, q[2], v[2], tau[2]).tolist() == a[2].tolist()
    assert compiled.mass_matrix(0.0, q).shape == (7, 2, 2)
    heavy = mq.Reference(mechanism.replace(m=3.0))
    np.testing.assert_allclose(
        compiled.acceleration(t=0.0, q=q, v=v, p={"m": 3.0}),
        heavy.acceleration(q, v),
        rtol=1e-12,
        atol=0,
    )
    with pytest.raises(mq.InputError, match=r"expected shape \(2,\) or \(n, 2\) for q in a call"):
        compiled.acceleration(0.0, [1.0], [0.0, 0.0])
    with pytest.raises(mq.UnknownNameError, match="unknown parameter 'mass'"):
        compiled.acceleration(0.0, q, v, p={"mass": 3.0})
    with pytest.raises(mq.InputError, match="one number of states in a call of energy"):
        compiled.energy(0.0, q, v[:3])
    with pytest.raises(AttributeError, match="no function 'bias' was compiled; there is: accel"):
        _ = compiled.bias


def test_an_input_that_is_a_function_of_time_is_an_argument() -> None:
    mechanism = mq.textbook.load("cart_pole")
    (force,) = mechanism.inputs
    driven = replace(mechanism, inputs=(mq.Input(force.symbol, np.sin, "N"),))
    code = mq.generate(mq.derive(driven), "python", "rhs")
    assert code.parameters == (*mechanism.values, "F")
    assert code.verdict is not None
    assert code.verdict.worst["rhs"] < 1e-13


def test_without_a_compiler_the_code_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CC", raising=False)
    for target, missing in (("c", "a C compiler"), ("javascript", "node")):
        code = mq.generate(derive_system("simple_pendulum"), target)
        assert code.verdict is None
        assert f"Not run where it was written: expected {missing}" in str(code)
    with pytest.raises(mq.InputError, match="expected a C compiler, found none: install gcc"):
        mq.generate(derive_system("simple_pendulum")).compile()


def test_what_is_asked_wrongly_is_refused(tmp_path: Path) -> None:
    pendulum = derive_system("simple_pendulum")
    for arguments, message in (
        ({"target": "fortran"}, "unknown target 'fortran'; known: c, javascript, python, jax"),
        ({"what": "accelerations"}, "unknown quantity 'accelerations'; did you mean 'accel"),
        ({"what": ()}, "expected names of quantities, each once, got"),
        ({"what": "energy,energy"}, "expected names of quantities, each once, got"),
        ({"what": "multipliers"}, "expected a mechanism with loops, contacts or velocity"),
        ({"parameters": ("k",)}, "unknown parameter 'k'"),
        ({"name": "2nd"}, "expected a name of ASCII letters, digits and underscores"),
        ({"samples": 0}, "expected a whole number of at least 1 for samples, got 0"),
    ):
        with pytest.raises(mq.InputError, match=message):
            mq.generate(pendulum, **arguments)
    code = mq.generate(pendulum, "python")
    with pytest.raises(mq.InputError, match='expected code with target="c" to compile, got'):
        code.compile()
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(mq.InputError, match="expected a directory to write to, got"):
        code.write(tmp_path / "file")


def test_numbers_take_the_place_of_letters_where_asked() -> None:
    code = mq.generate(derive_system("double_pendulum"), parameters=("m2",))
    assert code.parameters == ("m2",)
    assert code.count("acceleration").total < 49


def test_names_are_reversible_and_never_collide() -> None:
    names = [
        "q",
        "q'",
        "θ_1",
        "θ_1'",
        "_x3b8_",
        "_xab",
        "_xabθ",
        "a_dot",
        "a'",
        "a b",
        "",
        "x_dot'",
    ]
    mangled = [mangle(name) for name in names]
    assert [unmangle(text) for text in mangled] == names
    assert len(set(mangled)) == len(names)
    assert all(text.isascii() for text in mangled)
    assert mangle("theta'") == "theta_dot"
    assert identifiers("q", ("theta", "θ")) == ("q_theta", "q__x3b8_")
    with pytest.raises(mq.DerivationError, match="two names would both be written as 'q_a'"):
        identifiers("q", ("a", "a"))


def test_names_that_are_words_of_a_language_do_no_harm() -> None:
    static, force = mq.Parameter("static", 1.0), mq.Parameter("λ", 2.0)
    mechanism = mq.Mechanism(
        "while (1) */",
        (mq.Body("ground"), mq.Body("double", mq.particle(static))),
        (mq.Prismatic("for", "ground", "double", axis=(0.0, 0.0, 1.0), coordinate="int"),),
        forces=(mq.JointSpring("if", "for", force),),
        parameters=(static, force),
    )
    for target in ("c", "javascript", "python"):
        code = mq.generate(mq.derive(mechanism), target, OF_TREES)
        assert code.verdict is not None


def test_python_text_runs_without_the_package(tmp_path: Path) -> None:
    mq.generate(derive_system("spherical_pendulum"), "python", "rhs").write(tmp_path)
    test = str(tmp_path / "test_spherical_pendulum.py")
    done = subprocess.run(
        [sys.executable, "-I", test], capture_output=True, encoding="utf-8", check=True
    )
    assert done.stdout.startswith("rhs ")


@pytest.mark.parametrize("target", [pytest.param("jax", marks=pytest.mark.slow), "casadi"])
@pytest.mark.parametrize("name", ["double_pendulum", "two_blocks", "free_rigid_body", "crane"])
def test_the_code_for_jax_and_casadi_gives_what_pinocchio_gives(target: str, name: str) -> None:
    pytest.importorskip(target)
    verdict = mq.generate(derive_system(name), target, OF_TREES).verdict
    assert verdict is not None
    assert max(verdict.worst.values()) < 2e-13


@pytest.mark.slow
def test_jax_and_casadi_differentiate_the_code(tmp_path: Path) -> None:
    casadi = pytest.importorskip("casadi")
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    made = {
        target: runpy.run_path(
            str(mq.generate(derive_system("cart_pole"), target, "rhs").write(tmp_path / target)[0])
        )
        for target in ("jax", "casadi")
    }
    y, tau = np.array([0.1, 0.4, -0.3, 0.2]), np.array([1.0, 0.0])
    p = np.array(made["casadi"]["PARAMETERS"])
    ours = mq.generate(derive_system("cart_pole"), "c", "rhs_by_y").compile().rhs_by_y(0.0, y, tau)
    by_jax = jax.jit(jax.jacfwd(made["jax"]["rhs"], argnums=1))(0.0, y, tau)
    symbols = [casadi.SX.sym(name, size) for name, size in (("y", 4), ("tau", 2))]
    slope = casadi.jacobian(made["casadi"]["rhs"](0.0, *symbols, p), symbols[0])
    by_casadi = casadi.Function("slope", symbols, [slope])(y, tau)
    np.testing.assert_allclose(np.asarray(by_jax), ours, rtol=0, atol=1e-13)
    np.testing.assert_allclose(np.asarray(by_casadi), ours, rtol=0, atol=1e-13)


def test_parameters_of_python_and_jax_are_given_by_name(tmp_path: Path) -> None:
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    for target in ("jax", "python"):
        code = mq.generate(derive_system("simple_pendulum"), target, samples=4)
        made = runpy.run_path(str(code.write(tmp_path / target)[0]))
        run = jax.jit(made["acceleration"]) if target == "jax" else made["acceleration"]
        q, v = np.array([[0.3], [0.4]]), np.array([0.0])
        default = np.asarray(run(0.0, q, v))
        np.testing.assert_array_equal(run(0.0, q, v, None, made["PARAMETERS"]), default)
        many = run(0.0, q, v, None, {"g": np.array([9.81, 2 * 9.81])})
        np.testing.assert_allclose(many, default * [[1.0], [2.0]], rtol=1e-15, atol=0)
        with pytest.raises(ValueError, match="expected parameters among m, l, g, got 'L'"):
            run(0.0, q, v, None, {"L": 2.0})


def test_derivatives_of_robots_in_jax_are_compiled_in_seconds(tmp_path: Path) -> None:
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    solo = mq.derive(mq.read_urdf(mq.robot("solo"), root="floating"))
    code = mq.generate(solo, "jax", samples=4)
    assert code.verdict is not None
    made = runpy.run_path(str(code.write(tmp_path)[0]))
    q, v = solo.mechanism.neutral(), np.linspace(-1.0, 1.0, solo.mechanism.nv)

    def accelerate(v: object) -> object:
        return made["acceleration"](0.0, q, v)

    slope = jax.jacfwd(accelerate)
    assert len(jax.make_jaxpr(slope)(v).eqns) < 400  # flat it took 3,564 and minutes
    ours = mq.generate(solo, "python", "acceleration_by_v", samples=2)
    exact = runpy.run_path(str(ours.write(tmp_path / "ours")[0]))["acceleration_by_v"](0.0, q, v)
    found = np.asarray(jax.jit(slope)(v))
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-12 * np.abs(exact).max())


def test_packages_that_are_missing_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mecanique.generation.targets.python.find_spec", lambda _: None)
    for target in ("jax", "casadi"):
        code = mq.generate(derive_system("simple_pendulum"), target)
        assert code.verdict is None
        missing = f"expected {target}, which is not installed: pip install 'mecanique[{target}]'"
        assert missing in str(code)


def test_code_of_a_locked_mechanism_is_not_called_wrong_for_the_rounding_of_its_forces() -> None:
    arms = [mq.Body(name, mq.rod(1.0, 1.0, direction=(1, 0, 0))) for name in "ab"]
    joints = [
        mq.Revolute("A", "ground", "a", axis=(0, -1, 0)),
        mq.Revolute("C", "ground", "b", axis=(0, -1, 0), origin=mq.Placement((1.5, 0, 0))),
    ]
    loop = mq.Loop.pin("L", "a", (1, 0, 0), "b", (1, 0, 0))
    triangle = mq.Mechanism("triangle", (mq.Body("ground"), *arms), tuple(joints), loops=(loop,))
    code = mq.generate(mq.derive(triangle), target="python", what="acceleration")
    assert "rounding allows" in str(code.verdict)
