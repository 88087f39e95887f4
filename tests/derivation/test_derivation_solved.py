"""Solved equations end as a book's do, and give the accelerations and forces of the reference."""

from __future__ import annotations

import re

import numpy as np
import pytest
from derivation_reading import residual, value_of_text
from systems import derive_system

import mecanique as mq
from mecanique.derivation.printing.writers import Text
from mecanique.derivation.scalars.cancel import divide_by_wave
from mecanique.derivation.scalars.elementary import cos, sin
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.series import Ring
from mecanique.derivation.symbolic import solution
from mecanique.derivation.symbolic.derivation import Result, lefts_of
from mecanique.derivation.symbolic.lagrange import Lagrange, energy_integral
from mecanique.derivation.symbolic.multipliers import Quotient, name_of
from mecanique.derivation.symbolic.reduced import reduce_to_one
from mecanique.derivation.symbolic.result import INTEGRALS, result_of
from mecanique.errors import DerivationError, UnknownNameError
from mecanique.model import time
from mecanique.verification.states import random_states

m, r, g = mq.Parameter("m", 1.3, "kg"), mq.Parameter("r", 0.5, "m"), mq.Parameter("g", 9.81, "m/s²")
W, F = mq.Parameter("W", 0.9, "rad/s"), mq.Parameter("F", 2.0, "N")
SLIDES = (("x", (1.0, 0.0, 0.0)), ("y", (0.0, 1.0, 0.0)), ("z", (0.0, 0.0, 1.0)))
TURNS = (("yaw", (0.0, 0.0, 1.0)), ("pitch", (0.0, 1.0, 0.0)), ("roll", (1.0, 0.0, 0.0)))


def lines(equations: mq.Equations, *keep: str) -> list[str]:
    return equations.solved(keep).text().splitlines()


def turntable() -> mq.Mechanism:
    """A homogeneous ball, located by three slides and three hinges, on a table that turns at W."""
    chain = ("ground", *"abcde", "ball")
    slides = tuple(
        mq.Prismatic(f"along_{q}", chain[k], chain[k + 1], axis=axis, coordinate=q)
        for k, (q, axis) in enumerate(SLIDES)
    )
    hinges = tuple(
        mq.Revolute(f"by_{q}", chain[k], chain[k + 1], axis=axis, coordinate=q)
        for k, (q, axis) in enumerate(TURNS, 3)
    )
    axle = mq.Revolute("axle", "ground", "table", axis=(0, 0, 1), coordinate="turn")
    names = tuple(q for q, _ in (*SLIDES, *TURNS))
    return mq.Mechanism(
        "turntable",
        (
            *(mq.Body("ground"), mq.Body("table", mq.disk(5.0, 2.0))),
            *(*map(mq.Body, chain[1:-1]), mq.Body("ball", mq.ball(m, r))),
        ),
        (axle, *slides, *hinges),
        coordinates=mq.Coordinates(names, {"turn": W * time()}),
        parameters=(m, r, g, W),
        gravity=(0, 0, -g),
        contacts=(mq.Rolling("contact", "ball", r, axis=None, on="table"),),
    )


def spool(*, under: bool) -> mq.Mechanism:
    """A spool on level ground, pulled by a thread that leaves its core below or above."""
    core, k = mq.Parameter("c", 0.2, "m"), mq.Parameter("I", 0.1, "kg·m²")
    lever = F * core * (-1 if under else 1)
    return mq.Mechanism(
        "spool",
        (
            *(mq.Body("ground"), mq.Body("along"), mq.Body("center")),
            mq.Body("spool", mq.Shape(m, (0, 0, 0), (0.05, k, 0.05, 0, 0, 0))),
        ),
        (
            mq.Prismatic("slide", "ground", "along", axis=(1, 0, 0), coordinate="x"),
            mq.Prismatic("lift", "along", "center", axis=(0, 0, 1), coordinate="z"),
            mq.Revolute("roll", "center", "spool", axis=(0, 1, 0), coordinate="turn"),
        ),
        forces=(
            mq.Force("pull", "center", (0, 0, 0), (F, 0, 0)),
            mq.JointForce("lever", "roll", lever),
        ),
        parameters=(m, r, g, F, core, k),
        gravity=(0, 0, -g),
        contacts=(mq.Rolling("floor", "spool", r),),
    )


def yo_yo() -> mq.Mechanism:
    """A disk that unwinds from a thread at its rim: the map keeps it from slipping."""
    return mq.Mechanism(
        "yo_yo",
        (mq.Body("ground"), mq.Body("center"), mq.Body("disk", mq.disk(m, r))),
        (
            mq.Prismatic("fall", "ground", "center", axis=(0, 0, -1), coordinate="y"),
            mq.Revolute("spin", "center", "disk", axis=(0, 0, 1), coordinate="phi"),
        ),
        coordinates=mq.Coordinates(("y",), {"phi": mq.coordinate("y") / r}),
        parameters=(m, r, g),
        gravity=(0, 0, -g),
    )


def test_the_rolling_disk_ends_as_in_the_book() -> None:
    """Goldstein, Classical Mechanics, sect. 2.4, with a disk for the hoop."""
    for method in ("lagrange", "newton_euler", "virtual_work"):
        for keep in ((), ("x",), ("turn",), ("x'",)):
            assert lines(derive_system("rolling_disk", method), *keep) == [
                "x'' = 2 g sin(alpha)/3",
                "z'' = 0",
                "turn'' = 2 g sin(alpha)/(3 R)",
                "lambda_contact_normal = m g cos(alpha)",
                "lambda_contact_x = -m g sin(alpha)/3",
            ]


def test_the_coin_has_three_equations_and_its_contact_force_beside_them() -> None:
    """Neimark & Fufaev, Dynamics of Nonholonomic Systems, ch. II: 5/4, 6/4 and 3/2 m r²."""
    solved = derive_system("rolling_coin").solved()
    assert solved.independent == ("yaw", "lean", "spin")
    assert [str(equation) for equation in solved.equations] == [
        "(1 + 5 sin(lean)^2) yaw'' + 6 sin(lean) spin'' + 10 sin(lean) cos(lean) yaw' lean'"
        " + 2 cos(lean) lean' spin' = 0",
        "5 r lean'' - 5 r sin(lean) cos(lean) yaw'^2 - 6 r cos(lean) yaw' spin'"
        " - 4 g sin(lean) = 0",
        "3 sin(lean) yaw'' + 3 spin'' + 5 cos(lean) yaw' lean' = 0",
    ]
    assert str(solved.accelerations["yaw''"]) == "yaw'' = -2 lean' spin'/cos(lean)"
    assert [*solved.forces] == ["lambda_rim_normal", "lambda_rim_x", "lambda_rim_y"]


def test_the_ball_on_a_turntable_circles_at_two_sevenths() -> None:
    """Routh, Advanced Rigid Dynamics: z' x W, 2/7 of the table's rate."""
    solved = mq.derive(turntable()).solved()
    assert str(solved.accelerations["x''"]) == "x'' = -2 W y'/7"
    assert str(solved.accelerations["y''"]) == "y'' = 2 W x'/7"
    assert str(solved.forces["lambda_contact_normal"]) == "lambda_contact_normal = m g"


@pytest.mark.parametrize(("under", "lever"), [(True, "r - c"), (False, "r + c")])
def test_a_spool_goes_where_its_thread_pulls(under: bool, lever: str) -> None:
    """With the lever arm r ∓ c of the thread about the contact, (I + m r²) x'' = F r (r ∓ c)."""
    solved = mq.derive(spool(under=under)).solved("x")
    x = str(solved.accelerations["x''"])
    assert x in (f"x'' = F r ({lever})/(m r^2 + I)", f"x'' = r ({lever}) F/(m r^2 + I)")


def test_trees_end_as_in_the_book() -> None:
    assert lines(derive_system("atwood_machine")) == ["x'' = 2 (m1 - m2) g/(2 m1 + 2 m2 + M)"]
    assert lines(mq.derive(yo_yo())) == ["y'' = 2 g/3"]
    assert lines(derive_system("cart_pole")) == [
        "x'' = (F + m (l q'^2 + g cos(q)) sin(q) - c x')/(M + m sin(q)^2)",
        "q'' = -((M + m) g sin(q) + (F + m l sin(q) q'^2 - c x') cos(q))/(l (M + m sin(q)^2))",
    ]
    assert lines(derive_system("kepler_orbit")) == [
        "phi'' = -2 phi' r'/r",
        "r'' = r phi'^2 - mu/r^2",
    ]


def test_the_sleigh_needs_no_divisor_that_vanishes() -> None:
    """Its edge leaves neither x nor y free everywhere: all accelerations are explicit yet."""
    solved = derive_system("chaplygin_sleigh").solved()
    assert solved.independent == ()
    assert solved.equations == ()
    assert str(solved.forces["lambda_edge_side"]) == (
        "lambda_edge_side = m I (sin(theta) y' + cos(theta) x') theta'/(m a^2 + I)"
    )
    assert repr(solved) == "<Solved equations of 'chaplygin_sleigh', no velocity independent>"


SOLVED = (
    *("acrobot", "atwood_machine", "bead_on_hoop", "cart_pole"),
    *("chaplygin_sleigh", "double_atwood_machine", "double_pendulum", "elastic_pendulum"),
    *("foucault_pendulum", "furuta_pendulum", "gyroscope", "heavy_top", "kepler_orbit"),
    *("planetary_gear", "rolling_coin", "rolling_disk", "spherical_pendulum", "two_link_arm"),
    *("ball_on_a_turntable", "swinging_atwood_machine", "two_blocks", "two_wheeled_cart"),
    *("snakeboard", "slider_crank", "governor"),
)


@pytest.mark.parametrize(
    "mechanism",
    [*(mq.textbook.load(name) for name in SOLVED), turntable(), spool(under=True), yo_yo()],
    ids=lambda mechanism: mechanism.name,
)
def test_what_is_solved_is_what_the_reference_says(mechanism: mq.Mechanism) -> None:
    equations = mq.derive(mechanism)
    found = equations.solved().found
    states = random_states(mechanism, 6, 5, equations.derivation.assumptions, lot=8)
    reference = mq.Reference(mechanism)
    a = reference.acceleration(states.q, states.v, states.t)
    names = equations.derivation.algebra.accelerations
    values = {**states.values, **dict(zip(names, a.T, strict=True))}
    value = Evaluation(equations.derivation.algebra.ring, values)

    def compute(quotient: Quotient) -> np.ndarray:
        return np.asarray(value(quotient.above) / value(quotient.below) + 0 * states.t)

    size = 1 + float(np.abs(a).max())
    for name, quotient in found.accelerations.items():
        np.testing.assert_allclose(compute(quotient), values[name], rtol=0, atol=1e-11 * size)
    for row in found.rows:
        terms = [np.abs(value(part)).max() for part in row.coefficients(names).values()]
        limit = 1e-10 * (1 + size * max(terms, default=0.0))
        np.testing.assert_allclose(value(row) + 0 * states.t, 0, rtol=0, atol=limit)
    if mechanism.loops:  # whose forces the reference has in other axes: they balance M a + h - Q
        derivation = equations.derivation
        ring, ties = derivation.algebra.ring, derivation.ties
        pulls = [[value(slope) for slope in tie.slopes(ring)] for tie in ties]
        pushes = [compute(found.forces[name_of(tie.multiplier)]) for tie in ties]
        for k, (M, h, Q) in enumerate(zip(derivation.M, derivation.h, derivation.Q, strict=True)):
            inertia = sum(value(entry) * x for entry, x in zip(M, a.T, strict=True))
            held = sum(pull[k] * push for pull, push in zip(pulls, pushes, strict=True))
            most = 1 + np.abs(inertia).max() + np.abs(held).max()
            rest = inertia + value(h - Q) - held
            np.testing.assert_allclose(rest, 0 * states.t, rtol=0, atol=1e-10 * most)
    elif found.forces:
        given = reference.multipliers(states.q, states.v, states.t)
        forces = {f"lambda_{name.replace(': ', '_')}": force for name, force in given.items()}
        most = 1 + max(float(np.abs(force).max()) for force in forces.values())
        for name, quotient in found.forces.items():
            np.testing.assert_allclose(
                compute(quotient), forces[name], rtol=0, atol=1e-10 * most * size
            )


def test_the_snakeboard_leaves_its_heading_where_its_axles_are_turned() -> None:
    """J. Ostrowski et al., Proc. IEEE ICRA 1994: m l²/tan² φ joins the inertia of the heading."""
    solved = derive_system("snakeboard").solved()
    assert solved.independent == ("theta",)
    assert [str(equation) for equation in solved.equations] == [
        "(J + Ja + 2 Jw + m l^2 cos(phi)^2/sin(phi)^2) theta'' + m B l^2 W sin(W t) cos(phi) theta'"
        "/sin(phi)^3 = Ja A W^2 sin(W t)"
    ]
    assert str(solved.accelerations["theta''"]) == (
        "theta'' = W (Ja A W sin(phi)^3 - m B l^2 cos(phi) theta') sin(W t)"
        "/((m l^2 + (J + Ja + 2 Jw - m l^2) sin(phi)^2) sin(phi))"
    )
    text = derive_system("snakeboard").text(steps=True)
    assert "accelerations are explicit wherever no denominator is zero." in " ".join(text.split())


def test_a_slider_crank_ends_with_the_force_that_drives_its_slider() -> None:
    """The force along the slide is m2 x'', and the crank's acceleration has both inertias."""
    solved = derive_system("slider_crank").solved()
    assert solved.independent == ("theta",)
    force, x = str(solved.forces["lambda_B_x"]), str(solved.accelerations["x''"])
    assert force.partition(" = ")[2] == x.partition(" = ")[2].replace("-m1 (", "-m1 m2 (")
    assert str(solved.accelerations["theta''"]) == (
        "theta'' = 3 (2 m2 (l (theta' + beta')^2 + r cos(beta) theta'^2) sin(beta)"
        " - m1 g cos(theta) cos(theta + beta)^2)"
        "/(2 r (m1 cos(theta + beta)^2 + 3 m2 sin(beta)^2))"
    )
    text = " ".join(derive_system("slider_crank").text(symbols=True).split())
    assert "The constraints leave theta free. The accelerations are explicit wherever" in text


@pytest.mark.parametrize("name", ["atwood_machine", "cart_pole", "gyroscope", "furuta_pendulum"])
def test_denominators_that_vanish_nowhere_are_not_warned_of(name: str) -> None:
    text = " ".join(derive_system(name).text(steps=True).split())
    single = name == "atwood_machine"
    assert f"The acceleration{' is' if single else 's are'} explicit. " in text


@pytest.mark.parametrize(
    "name", ["heavy_top", "kepler_orbit", "particle_on_circle_x", "coupled_pendulums"]
)
def test_denominators_that_may_vanish_are_warned_of(name: str) -> None:
    """Sines, coordinates, roots of coordinates, lengths of springs whose ends may meet."""
    text = " ".join(derive_system(name).text(steps=True).split())
    single = name == "particle_on_circle_x"
    said = f"The acceleration{' is' if single else 's are'} explicit"
    assert f"{said} wherever no denominator is zero. " in text


def test_tops_are_solved_in_letters_where_these_are_explained() -> None:
    """As the result of the derivation; alone, the lines are in the parameters."""
    solved = derive_system("heavy_top").solved()
    assert "J_theta" not in solved.text()
    said = solved.text(symbols=True)
    assert "  J_theta  inertia referred to theta [kg·m²]\n" in said
    assert "  r        radius of the base [m]\n" in said
    result = derive_system("heavy_top").text(steps=True).partition("Result\n")[2]
    lines = said.partition("\n\nJ_psi = ")[2].splitlines()
    assert len(lines) == 5
    assert all(f"{line}\n" in result for line in lines)
    assert "Each line is divided" not in solved.latex(symbols=True)


def test_both_pendulums_have_the_same_positive_denominator() -> None:
    solved = derive_system("double_pendulum").solved()
    for name in ("q1''", "q2''"):
        assert "(4 (m1 + 3 m2) - 9 m2 cos(q1 - q2)^2))" in str(solved.accelerations[name])


@pytest.mark.parametrize("name", ["four_bar_linkage", "bars_and_springs_loop", "governor"])
def test_what_would_be_too_long_to_print_is_not_computed(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The accelerations of these loops have more terms than a derivation ends with."""

    def refuse(*_: object) -> None:
        raise AssertionError("the solution is computed, but not printed")

    monkeypatch.setattr(solution, "_solve_blocks", refuse)
    monkeypatch.setattr(solution, "_combine", refuse)
    text = mq.derive(mq.textbook.load(name)).text(steps=True)
    assert "constant along any motion" in " ".join(text.split())
    assert "explicit" not in text


def test_a_linkage_ends_with_its_single_equation(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("four_bar_linkage", "slider_crank"):
        reduced = mq.reduce_loops(mq.textbook.load(name))
        for method in ("lagrange", "newton_euler", "virtual_work"):
            text = derive_system(name, method).text(steps=True)
            *equations, energy = read_result(text).splitlines()
            assert f"     {reduced.equation}" in equations
            assert energy.startswith(f"     E = J {reduced.coordinate}'^2/2 + ")
            for letter, value in reduced.coefficients.items():
                assert text.count(f"     {letter} = {value}\n") == 1
    assert "reduce_loops" not in derive_system("four_bar_linkage").text(steps=True)
    monkeypatch.setattr("mecanique.derivation.symbolic.result._LONGEST_OF_LOOPS", 5)
    text = " ".join(mq.derive(mq.textbook.load("four_bar_linkage")).text(steps=True).split())
    assert "reduce the equations to one without multipliers: reduce_loops writes it." in text


def test_no_linkage_points_to_an_equation_that_there_is_not() -> None:
    """The coefficients of chained linkages follow from equations with two unknowns each."""
    with pytest.raises(DerivationError, match="no short closed form"):
        mq.reduce_loops(mq.textbook.load("chained_four_bars"))
    assert "reduce_loops" not in derive_system("chained_four_bars").text(steps=True)


def test_a_letter_of_the_single_equation_is_no_point_of_the_linkage() -> None:
    """C is the joint of coupler and rocker, so that half the derivative of J is N."""
    linkage = mq.reduce_loops(mq.textbook.load("four_bar_linkage"))
    assert [*linkage.coefficients][-2:] == ["J", "N"]
    assert [*mq.reduce_loops(mq.textbook.load("slider_crank")).coefficients][-2:] == ["J", "C"]


def read_result(text: str) -> str:
    """Return the section "Result", without the sections on special motions below it."""
    return text.partition(". Result\n")[2].partition("\n\n")[0]


@pytest.mark.parametrize("method", ["lagrange", "newton_euler", "virtual_work"])
@pytest.mark.parametrize("name", ["heavy_top", "gyroscope", "kepler_orbit"])
def test_cyclic_coordinates_end_in_an_effective_potential(name: str, method: str) -> None:
    """Goldstein, Classical Mechanics, sects. 3-3 and 5-7: E as of a motion in V_eff."""
    reduced = mq.routh(mq.textbook.load(name))
    text = derive_system(name, method).text(steps=True)
    result = read_result(text)
    if name == "kepler_orbit":  # in others letters stand for inertias
        assert result.endswith(f"\n     {reduced.equations[0]}")
    (*_, energy, _) = result.splitlines()
    assert energy.startswith("     E = ")
    assert energy.endswith(" + V_eff")
    for momentum in reduced.momenta:
        assert 1 in {part.count(f"     {momentum} = ") for part in (text, result)}


@pytest.mark.parametrize("method", ["lagrange", "newton_euler"])
@pytest.mark.parametrize(
    ("name", "inertias"),
    [
        ("heavy_top", ["J_psi = 3 m r^2/10", "J_theta = 3 m (r^2 + 4 h^2)/20"]),
        (
            "gyroscope",
            [
                "J_psi = m r^2/2",
                "J_theta = m2 r2^2/2 + w d^2 + m r^2/4",
                "J_phi = (m1 r1^2 + m2 r2^2)/2",
            ],
        ),
    ],
)
def test_inertias_of_a_top_are_called_by_letters(
    name: str, inertias: list[str], method: str
) -> None:
    """Goldstein, sect. 5-7, calls them I_1 and I_3; with them all is as without."""
    equations = derive_system(name, method)
    text = equations.text(steps=True)
    lines = [line.strip() for line in read_result(text).splitlines() if line.startswith("     ")]
    assert lines[: len(inertias)] == inertias
    random = np.random.default_rng(4)
    letters = {letter for line in lines for letter in re.findall(r"[^\W\d]\w*'*", line)}
    values = {letter: random.uniform(0.5, 1.5) for letter in sorted(letters)}
    values |= {letter: random.uniform(0.5, 1.5) for letter in ("m", "m2", "r", "r2")}
    for line in lines[: len(inertias) + 3]:  # and the accelerations
        left, _, right = line.partition(" = ")
        values[left] = value_of_text(right, values)
    for equation in equations.equations:
        assert residual(str(equation), values) == pytest.approx(0.0, abs=1e-12)
    whole = residual(str(mq.routh(mq.textbook.load(name)).equations[0]), values)
    assert residual(lines[-1], values) == pytest.approx(whole, rel=1e-12)
    assert "E = J_theta theta'^2/2 + V_eff" in lines
    assert "J_theta theta''" in lines[-1]
    # in the quadratic equation of the steady precession, too
    assert "J_theta cos(theta) phi'^2 - " in text


@pytest.mark.parametrize("second", [mq.Parameter("I3", 0.01, "kg·m²"), 0.01])
def test_a_moment_that_is_a_letter_or_a_number_needs_no_other(second: mq.Parameter | float) -> None:
    """Lagrange's top by its moments I1 and I3."""
    I1, m = mq.Parameter("I1", 0.02, "kg·m²"), mq.Parameter("m", 1.0, "kg")
    c, g = mq.Parameter("c", 0.2, "m"), mq.Parameter("g", 9.81, "m/s²")
    shape = mq.Shape(m, (0, 0, c), (I1, I1, second, 0, 0, 0))
    axes = zip("uvw", ((0, 0, 1), (1, 0, 0), (0, 0, 1)), strict=True)
    links = ("ground", "yoke", "ring", "top")
    top = mq.Mechanism(
        "top",
        (*map(mq.Body, links[:3]), mq.Body("top", shape)),
        tuple(
            mq.Revolute(name, links[k], links[k + 1], axis=axis, coordinate=name)
            for k, (name, axis) in enumerate(axes)
        ),
        parameters=(I1, m, c, g, *([second] if isinstance(second, mq.Parameter) else [])),
        gravity=(0, 0, -g),
    )
    said = read_result(mq.derive(top).text(steps=True))
    assert "J_v is the inertia referred to v. The" in " ".join(said.split())
    assert "     J_v = I1 + m c^2\n" in said
    assert "J_w" not in said
    assert "     E = J_v v'^2/2 + V_eff\n" in said


@pytest.mark.parametrize("name", ["atwood_machine", "furuta_pendulum", "spherical_pendulum"])
def test_short_inertias_and_those_that_are_not_all_are_written_out(name: str) -> None:
    """A sum of masses is no longer than its letter, nor is that of a particle."""
    assert "J_" not in derive_system(name).text(steps=True)


def test_the_effective_potential_and_the_rest_are_the_energy() -> None:
    """E of the full equations, at random states, equals that of the reduced ones."""
    reduced = mq.routh(mq.textbook.load("heavy_top"))
    values = reduced._compute_states(20, np.random.default_rng(1))
    evaluate = Evaluation(reduced.found.derivation.algebra.ring, values)
    stages = {stage.title: stage.results for stage in reduced.found.derivation.stages}
    _, potential = stages["Routh's function"]
    (energy,) = stages["Energy integral"]
    values["V_eff"] = evaluate(potential.right)
    found = Evaluation(reduced.found.derivation.algebra.ring, values)(energy.right)
    names = reduced.mechanism.coordinates.names
    q, v = (np.array([values[f"{x}{dots}"] for x in names]).T for dots in ("", "'"))
    T, V = mq.derive(reduced.mechanism).energy(q, v)
    np.testing.assert_allclose(found, T + V, rtol=1e-10, atol=1e-12)


def test_momenta_that_enter_no_equation_are_left_at_that() -> None:
    for name in ("free_particle", "particle_on_circle", "free_planar_body"):
        assert "V_eff" not in derive_system(name).text(steps=True)


def test_a_coin_shows_how_the_forces_of_the_constraints_cancel() -> None:
    text = derive_system("rolling_coin").text(steps=True)
    _, _, result = text.partition(". Elimination of the constraint forces\n")
    followers = (
        "     x' = r sin(lean) cos(yaw) yaw' + r sin(yaw) cos(lean) lean' + r cos(yaw) spin'\n"
        "     y' = r sin(yaw) sin(lean) yaw' - r cos(yaw) cos(lean) lean' + r sin(yaw) spin'\n"
        "     z' = -r sin(lean) lean'\n"
    )
    assert followers in result
    assert "in such a displacement the forces of the constraints do no work" in " ".join(
        result.split()
    )
    # virtual work has projected the equations before
    works = derive_system("rolling_coin", "virtual_work").text(steps=True)
    assert followers not in works.partition(". Result\n")[2]


def test_forces_that_redundancy_shares_are_not_listed() -> None:
    """Both wheels of a cart keep it from sliding sideways; each bears its own weight."""
    solved = derive_system("two_wheeled_cart").solved()
    assert solved.independent == ("yaw", "pitch", "left")
    assert len(solved.equations) == 3
    assert [*solved.forces] == ["lambda_left_contact_normal", "lambda_right_contact_normal"]


def test_what_redundancy_leaves_determined_of_shared_forces_is_listed() -> None:
    """Ahead each wheel is turned by friction, Jw (spin of the wheel)' = -r F; across, by the sum.

    The multipliers are the engine's, which shares friction evenly.
    """
    mechanism = mq.textbook.load("two_wheeled_cart")
    text = mq.derive(mechanism).solved().text()
    lines = [line for line in text.splitlines() if re.match(r"cos\(yaw\) lambda_\w+ ", line)]
    assert lines[0] == (
        "cos(yaw) lambda_left_contact_x + sin(yaw) lambda_left_contact_y = "
        "-Jw pitch''/r - Jw left''/r"
    )
    assert len(lines) == 3
    assert "right_contact" in lines[2].partition(" = ")[0]
    states, reference = random_states(mechanism, 3, 5, lot=8), mq.Reference(mechanism)
    a = reference.acceleration(states.q, states.v, states.t)
    values = {**mechanism.values, **states.values}
    values |= {f"{v}'": x for v, x in zip(mechanism.velocities, a.T, strict=True)}
    for name, force in reference.multipliers(states.q, states.v, states.t).items():
        values[f"lambda_{name.replace(': ', '_')}"] = force
    for line in lines:
        np.testing.assert_allclose(residual(line, values), 0, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("name", "keep", "message"),
    [
        ("rolling_disk", ("x", "turn"), "leave 1 of 3 velocities free, got x, turn to keep; turn"),
        ("rolling_coin", ("x", "y", "z"), "not all follows from x, y, z; yaw, lean and spin can"),
        ("double_pendulum", ("q1",), "without constraints it has 2 of 2 velocities free, got q1"),
        ("chained_four_bars", (), "can be solved for no velocity .*; reduce_loops keeps one"),
    ],
)
def test_what_cannot_be_solved_is_refused(name: str, keep: tuple[str, ...], message: str) -> None:
    with pytest.raises(DerivationError, match=message):
        derive_system(name).solved(keep)


def test_what_cannot_be_kept_is_named() -> None:
    with pytest.raises(UnknownNameError, match="coordinate 'w'"):
        derive_system("rolling_disk").solved("w")
    with pytest.raises(DerivationError, match="more than 5000 terms"):
        derive_system("ball_in_a_bowl").solved()


def test_the_catalogues_turntable_turns_the_velocity_by_two_sevenths() -> None:
    """Its ball turns by a quaternion on a center that moves."""
    solved = derive_system("ball_on_a_turntable").solved()
    assert lines(derive_system("ball_on_a_turntable"))[:3] == [
        "x'' = -2 W y'/7",
        "y'' = 2 W x'/7",
        "z'' = 0",
    ]
    assert str(solved.forces["lambda_contact_normal"]) == "lambda_contact_normal = m g"


def test_angles_that_swing_keep_their_names() -> None:
    """The axles of a snakeboard turn by B cos(W t), whose sine is no series."""
    text = derive_system("snakeboard").text(symbols=True)
    assert "phi = B cos(W t)" in text
    assert "phi_back = -phi" in text
    assert "sin(phi + theta) x' - cos(phi + theta) y' - l cos(phi) theta' = 0" in text


@pytest.mark.parametrize("method", ["lagrange", "newton_euler", "virtual_work"])
def test_a_derivation_ends_with_its_result(method: str) -> None:
    equations = derive_system("rolling_disk", method)
    before, _, result = equations.text(steps=True).partition(". Result\n")
    assert "The constraints leave x free." in before
    assert "     x'' = 2 g sin(alpha)/3\n" in result
    assert "     E = " not in before
    energy = "     E = 3 m x'^2/4 - m g x sin(alpha) + m g z cos(alpha)"
    assert result.endswith(energy) is (method == "lagrange")
    assert equations.latex(steps=True).count("\\subsection*{Result}") == 1
    assert "\\ddot{x} &= \\frac{2 g}{3} \\sin \\alpha" in equations.latex(steps=True)
    assert equations.document.sections()[-1].title == "Result"
    assert "<h4>Result</h4>" in equations.mathml(steps=True)
    assert "Result" not in equations.text()


@pytest.mark.parametrize("form", ["text", "latex", "mathml"])
def test_equations_with_their_symbols_do_not_stop_at_forces_of_constraints(form: str) -> None:
    said = "The constraints leave"
    disk = getattr(derive_system("rolling_disk"), form)
    assert said in disk(symbols=True)
    assert said not in disk()
    assert disk(symbols=True).index("lambda") < disk(symbols=True).index(said)
    if form == "text":
        assert "Along any motion E is constant." in " ".join(disk(symbols=True).split())
    linkage = getattr(derive_system("four_bar_linkage"), form)(symbols=True)
    assert "The loops give every other coordinate" in linkage.replace("\n", " ")
    assert "Along any motion" not in getattr(derive_system("kepler_orbit"), form)(symbols=True)


@pytest.mark.parametrize(
    ("name", "method", "whole", "last"),
    [
        (
            "rolling_disk",
            "lagrange",
            "The constraints leave x free. The accelerations are explicit. The forces of the "
            "constraints follow. Along any motion E is constant.",
            "The accelerations are explicit. The forces of the constraints follow. Nothing depends "
            "on time, no force but weights does work, and the constraints do none: the total "
            "energy E = T + V is constant along any motion.",
        ),
        (
            "rolling_disk",
            "newton_euler",
            "The constraints leave x free. The accelerations are explicit. The forces of the "
            "constraints follow.",
            "The accelerations are explicit. The forces of the constraints follow.",
        ),
        (
            "atwood_machine",
            "newton_euler",
            "The acceleration is explicit. Inserted, it gives T_cord_1, T_cord_2 and R_axle_z.",
            "The acceleration is explicit. Inserted, it gives T_cord_1, T_cord_2 and R_axle_z.",
        ),
        (
            "four_bar_linkage",
            "lagrange",
            "Along any motion E is constant. The loops give every other coordinate for each phi, "
            "with the velocity K phi' and the acceleration K phi'' + L phi'²; the equations reduce "
            "to one without multipliers wherever no denominator is zero. J is the inertia referred "
            "to phi, and N half its derivative dJ/dphi.",
            "One equation is left for phi wherever no denominator is zero: J phi'' + N phi'² = "
            "Q_phi. The loops give the other coordinates, Φ = 0. With the accelerations, the "
            "multipliers follow as listed above. Nothing depends on time, no force but weights "
            "does work, and the constraints do none: the total energy E = T + V is constant along "
            "any motion.",
        ),
    ],
)
def test_the_last_section_says_again_only_what_its_lines_are(
    name: str, method: str, whole: str, last: str
) -> None:
    ending = result_of(derive_system(name, method).derivation)
    assert ending.sentence == whole
    assert ending.sections[-1].title == "Result"
    assert ending.sections[-1].sentence == last


def test_forces_that_depend_on_the_acceleration_stand_below_it_with_that_inserted() -> None:
    """Of Atwood's machine with a pulley M; those that depend on no acceleration stand elsewhere."""
    equations = derive_system("atwood_machine", "newton_euler")
    lines = [line.text() for line in result_of(equations.derivation).lines]
    assert lines == [
        "x'' = 2 (m1 - m2) g/(2 m1 + 2 m2 + M)",
        "T_cord_1 = m1 (4 m2 + M) g/(2 m1 + 2 m2 + M)",
        "T_cord_2 = (4 m1 + M) m2 g/(2 m1 + 2 m2 + M)",
        "R_axle_z = (8 m1 m2 + 3 (m1 + m2) M + M^2) g/(2 m1 + 2 m2 + M)",
    ]
    level = [*result_of(derive_system("rigid_bar_pendulum", "newton_euler").derivation).lines]
    assert [line.text() for line in level[1:]] == ["R_pin_t = m g sin(q)/4"]


def test_integrals_stand_at_the_end() -> None:
    result = read_result(derive_system("kepler_orbit").text(steps=True))
    assert result.endswith(
        "The accelerations are explicit wherever no denominator is zero. phi is cyclic: its "
        "velocity\n   follows from the constant momentum p, and for r one equation is left, with "
        "the effective\n   potential V_eff and the constant energy E in it (Routh)."
        "\n     phi'' = -2 phi' r'/r\n     r'' = r phi'^2 - mu/r^2"
        "\n     phi' = p_phi/(m r^2)\n     V_eff = p_phi^2/(2 m r^2) - m mu/r"
        "\n     E = m r'^2/2 + V_eff\n     m r'' - p_phi^2/(m r^3) + m mu/r^2 = 0"
    )


@pytest.mark.parametrize("name", ["kepler_orbit", "heavy_top", "gyroscope"])
def test_a_result_states_each_quantity_once(name: str) -> None:
    result = read_result(derive_system(name).text(steps=True))
    lefts = re.findall(r"^     (\S+) = ", result, re.MULTILINE)
    assert "E" in lefts
    assert len(lefts) == len({*lefts})


def test_all_formats_say_the_same() -> None:
    solved = derive_system("rolling_disk").solved()
    assert str(solved) == solved.text()
    assert solved.latex().count("\\\\") == 4
    assert solved.mathml().count("<math") == 5
    assert "radius of the disk" in solved.text(symbols=True)
    assert "radius of the disk" in solved.latex(symbols=True)
    assert "radius of the disk" in solved._repr_html_()


def test_waves_divide_exactly_or_not_at_all() -> None:
    ring = Ring()
    a, b, x = ring.coordinate("a"), ring.coordinate("b"), ring.parameter("x")
    others = x + cos(b), sin(a + b) * x + 3, cos(2 * a) + sin(b - a), cos(a) * sin(a)
    for wave in (cos(a), sin(a), cos(a - b), sin(2 * a + b)):
        (key,) = wave.parts
        for other in others:
            found = divide_by_wave(other * wave, key)
            assert found is not None
            assert (found - other).vanishes()
        for other in (x, cos(b) + sin(a + b), 1 + wave):
            assert divide_by_wave(other, key) is None


def test_a_rolling_force_is_also_given_along_the_heading() -> None:
    """Ahead it is m (acceleration along the track): friction that only turns the coin."""
    lines = mq.derive(mq.textbook.load("rolling_coin")).solved().text().splitlines()
    ahead = "cos(yaw) lambda_rim_x + sin(yaw) lambda_rim_y = m r cos(lean) yaw' lean'/3"
    assert ahead in lines
    assert len([line for line in lines if line.startswith("cos(yaw) lambda_rim_y - sin(yaw)")]) == 1


def test_friction_on_a_turntable_is_also_given_in_axes_at_rest() -> None:
    """Milne: m x'' = -2 m W y'/7, though the friction is stated in the table's axes."""
    lines = mq.derive(mq.textbook.load("ball_on_a_turntable")).solved().text().splitlines()
    assert "cos(W t) lambda_contact_x - sin(W t) lambda_contact_y = -2 m W y'/7" in lines
    assert "sin(W t) lambda_contact_x + cos(W t) lambda_contact_y = 2 m W x'/7" in lines


@pytest.mark.parametrize("name", ["rolling_disk", "rolling_coin", "two_wheeled_cart"])
def test_the_energy_of_what_rolls_is_that_of_the_velocities_it_is_left_with(name: str) -> None:
    """T + V with the other velocities inserted, and what the constraints hold at zero."""
    derivation = derive_system(name).derivation
    (full,) = (stage.results[0] for stage in derivation.stages if stage.title in INTEGRALS)
    results = (x for x in result_of(derivation).sections[-1].lines if isinstance(x, Result))
    (reduced,) = (line for line in results if line.left == full.left)
    mechanism, followers = derivation.algebra.mechanism, solution.solve(derivation).followers
    names = (*mechanism.coordinates, *derivation.algebra.velocities)
    random = np.random.default_rng(3)
    values = {
        **mechanism.values,
        **dict(zip(names, random.uniform(0.2, 0.9, len(names)), strict=True)),
    }
    values |= dict.fromkeys(solution.find_still(derivation), 0.0)
    ring = derivation.algebra.ring
    values |= {v: Evaluation(ring, values)(rate) for v, rate in followers.items()}
    assert not {*followers}.intersection(g.name for g in reduced.right.generators())
    expected = Evaluation(ring, values)(full.right)
    assert Evaluation(ring, values)(reduced.right) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("name", ["slider_crank", "four_bar_linkage", "bars_and_springs_loop"])
def test_the_energy_of_a_loop_is_that_of_its_referred_inertia(name: str) -> None:
    """T + V with the velocities K phi', for the K of any position, is J phi'²/2 + V."""
    lagrange = Lagrange(mq.textbook.load(name))
    reduced, ring = reduce_to_one(lagrange), lagrange.algebra.ring
    (stage,) = energy_integral(lagrange)
    mechanism, random = lagrange.algebra.mechanism, np.random.default_rng(5)
    values = {**mechanism.values, **{q: random.uniform(0.3, 1.2) for q in mechanism.coordinates}}
    rate = values[f"{reduced.coordinate}'"] = 0.7
    for term in reduced.ratios:
        above, below = Evaluation(ring, values)(term.value.above), term.value.below
        values[term.name] = above / Evaluation(ring, values)(below)
        values[f"{term.coordinate}'"] = values[term.name] * rate
    inertia, _ = reduced.derivation.stages[-1].results
    (letter,) = lefts_of([inertia])
    values[letter.symbol] = Evaluation(ring, values)(inertia.right)
    evaluate = Evaluation(ring, values)
    (line,) = reduced.energy[0].results
    assert evaluate(line.right) == pytest.approx(evaluate(stage.results[0].right), rel=1e-12)
    assert line.write(Text()).startswith(f"E = J {reduced.coordinate}'^2/2 ")


def test_a_loop_holds_what_hangs_from_an_inclined_slide() -> None:
    """3 s/5 = sin u and 4 s/5 = 1 - cos u: with s from the first, the second holds u alone."""
    block = mq.box(1.0, (0.1, 0.1, 0.1))
    inclined = mq.Mechanism(
        "inclined",
        bodies=(mq.Body("ground"), mq.Body("block", block), mq.Body("bar", block)),
        joints=(
            mq.Prismatic("s", "ground", "block", axis=(0.6, 0, 0.8)),
            mq.Revolute("u", "block", "bar", axis=(0, 1, 0)),
        ),
        loops=(mq.Loop.pin("end", "bar", (0, 0, -1), "ground", (0, 0, -1)),),
    )
    assert [*solution.find_still(Lagrange(inclined).derivation())] == ["u", "u'"]


def test_equations_too_long_to_be_solved_stand_in_the_velocities_that_are_kept() -> None:
    """Of y' = z x' with drag c y': (m + M z²) x'' + M z z' x' + c z² x' = 0, and z'' = 0."""
    m, M, c = (mq.Parameter(name, value) for name, value in (("m", 2.0), ("M", 3.0), ("c", 0.7)))
    axes = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}
    masses = {"x": m, "y": M, "z": m}
    mechanism = mq.Mechanism(
        "three",
        (mq.Body("ground"), *(mq.Body(f"b{q}", mq.particle(masses[q])) for q in axes)),
        tuple(
            mq.Prismatic(f"along_{q}", "ground", f"b{q}", axis=axis, coordinate=q)
            for q, axis in axes.items()
        ),
        forces=(mq.JointDamper("drag", "along_y", c),),
        parameters=(m, M, c),
        velocity_constraints=(mq.VelocityConstraint("link", {"y": 1, "x": -mq.coordinate("z")}),),
        gravity=(0, 0, 0),
    )
    solved = solution.solve(Lagrange(mechanism).derivation(), longest=0)
    assert not solved.accelerations
    assert solved.kept == ("x'", "z'")
    ring = solved.rows[0].ring
    z, v, w, a, b = (ring[name] for name in ("z", "x'", "z'", "x''", "z''"))
    light, heavy, drag = (ring[name] for name in ("m", "M", "c"))
    row = (light + heavy * z**2) * a + heavy * z * w * v + drag * z**2 * v
    assert solved.rows == (row, light * b)
