"""Moments of inertia are derived from the table, and loads that have a potential are recognized."""

import re
from dataclasses import replace

import numpy as np
import pytest
from derivation_reading import value_of_text
from scipy.spatial.transform import Rotation
from systems import derive_system

import mecanique as mq
from mecanique.derivation.numeric.lagrange import LagrangeOnJets
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.derivation.numeric.virtual_work import NumericVirtualWork
from mecanique.derivation.symbolic.forces import stored_in_loads
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.model.bodies.shapes import HOMOGENEOUS
from mecanique.model.force_base import Point
from mecanique.model.states import States


def step(equations: mq.Equations, title: str) -> tuple[str, list[str]]:
    """Explanation and lines of the step of a derivation with a title."""
    (found,) = [stage for stage in equations.steps if stage.title == title]
    text = equations.text(steps=True).partition(f". {title}\n")[2].partition("\n\n")[0]
    lines = [line.strip() for line in text.splitlines() if line.startswith("     ")]
    return found.explanation, lines


@pytest.mark.parametrize("method", ["lagrange", "newton_euler", "virtual_work"])
def test_a_derivation_begins_with_moments_of_inertia(method: str) -> None:
    said, lines = step(derive_system("heavy_top", method), "Moments of inertia")
    assert "top is a solid cone: 3 m (4 r² + h²)/80 across the axis" in said
    assert lines == [
        "c_top_z = 3 h/4",
        "I_top_xx = 3 m (4 r^2 + h^2)/80",
        "I_top_yy = 3 m (4 r^2 + h^2)/80",
        "I_top_zz = 3 m r^2/10",
    ]


def test_parts_add_up_by_steiners_theorem() -> None:
    said, lines = step(derive_system("dumbbell"), "Moments of inertia")
    assert "rod is made of 2 particles: its moments are the sums over these parts" in said
    assert "I_rod_xx = m1 m2 l^2/(m1 + m2)" in lines
    said, _ = step(derive_system("rolling_coin"), "Moments of inertia")
    assert "coin is a thin disk: m r²/4 about a diameter" in said


def test_what_only_renames_is_not_listed() -> None:
    for name in ("kepler_orbit", "bars_and_springs"):  # particles, of masses m and 2 m
        assert "Moments of inertia" not in derive_system(name).text(steps=True)
    _, lines = step(derive_system("gyroscope"), "Moments of inertia")
    assert [line for line in lines if line.startswith("m_")] == ["m_inner = m2 + w"]


def test_the_angular_momentum_stands_before_its_rate() -> None:
    said, lines = step(derive_system("double_pendulum", "newton_euler"), "Free body rod1: moments")
    assert "by the mass times the square of the distance of the two (Steiner)" in said
    assert lines[0] == "H_rod1 = m1 l1^2 q1'/3"  # in the sense of q1, about -y
    assert lines[1].startswith("m1 l1^2 q1''/3 = ")


def test_a_free_slide_guides_nothing() -> None:
    """A block on a ramp is free: its slide only transmits nothing along the ramp."""
    bodies = (mq.Body("ground"), mq.Body("block", mq.box(1.0, (0.1, 0.1, 0.1))))
    ramp = mq.Prismatic("ramp", "ground", "block", axis=(0.6, 0.0, -0.8), coordinate="s")
    equations = mq.derive(mq.Mechanism("oblique", bodies, (ramp,)), method="virtual_work")
    said, lines = step(equations, "Virtual work of the reactions")
    assert "guide dependent coordinates" not in said
    assert said.endswith("That it transmits nothing there is stated by the last lines.")
    assert lines[-1] == "0.6 R_ramp_x - 0.8 R_ramp_z = 0"
    guided = replace(mq.textbook.load("bars_and_springs_small"), elements=())
    equations = mq.derive(guided, method="virtual_work")
    said, _ = step(equations, "Virtual work of the reactions")
    assert "The forces that guide dependent coordinates count as reactions" in said


def test_inertia_forces_name_a_distance_only_where_it_is_listed() -> None:
    equations = derive_system("double_pendulum", "virtual_work")
    said, lines = step(equations, "Inertia forces of rod1")
    assert "which acts at the distance s_rod1, where it has their moment." in said
    assert any(line.startswith("s_rod1") for line in lines)
    said, lines = step(equations, "Inertia forces of rod2")
    assert "Reduced to the center of mass they are one force F, minus the mass times" in said
    assert not any(line.startswith("s_rod2") for line in lines)


def test_the_table_is_that_of_the_conventions(pytestconfig: pytest.Config) -> None:
    text = (pytestconfig.rootpath / "docs" / "conventions.md").read_text(encoding="utf-8")
    said = re.sub(r"\{math\}`([^`]*)`", in_a_line, text)
    for number, (form, moments) in enumerate(HOMOGENEOUS.items(), 1):
        assert f"| H{number} | {form} | {moments} |" in said


def in_a_line(formula: re.Match[str]) -> str:
    r"""Return a formula as it stands in a sentence: \frac{1}{12}\,m l^2 as m l²/12."""
    text = formula[1].replace("^2", "²").replace("\\,", " ")
    fraction = re.fullmatch(r"\\frac\{(\d+)\}\{(\d+)\} (.+)", text)
    if fraction is None:
        return text
    above, below, rest = fraction.groups()
    return f"{rest}/{below}" if above == "1" else f"{above} {rest}/{below}"


def test_attraction_has_a_potential() -> None:
    equations = derive_system("kepler_orbit")
    said, lines = step(equations, "Potential energy")
    assert "The potential V of the attraction is given." in said
    assert lines == ["V = -m mu/r"]
    assert step(equations, "Energy integral")[1] == ["E = m (r'^2 + r^2 phi'^2)/2 - m mu/r"]


def on_slides(force: Point) -> mq.Equations:
    """A particle on two slides with a force on it."""
    m = mq.Parameter("m", 1.0, "kg")
    bodies = (mq.Body("ground"), mq.Body("along"), mq.Body("mass", mq.particle(m)))
    joints = (
        mq.Prismatic("x", "ground", "along", axis=(1, 0, 0)),
        mq.Prismatic("y", "along", "mass", axis=(0, 1, 0)),
    )
    load = mq.Force("load", "mass", (0, 0, 0), force)
    field = mq.Mechanism(
        "field", bodies, joints, forces=(load,), parameters=(m, K, L, T), gravity=(0, 0, 0)
    )
    return mq.derive(field)


X, Y, K = mq.coordinate("x"), mq.coordinate("y"), mq.Parameter("k", 2.0, "N/m³")
L, T = mq.Parameter("l", 1.0, "m"), mq.Parameter("tau", 1.0, "s")


@pytest.mark.parametrize(
    ("force", "potential"),
    [
        ((-K * X**3, 0, 0), "V = k x^4/4"),
        ((-K * X * Y**2, -K * X**2 * Y, 0), "V = k x^2 y^2/2"),
        ((-K * L**3 * mq.sin(X / L), 0, 0), "V = -k l^4 cos(x/l)"),
    ],
)
def test_a_load_without_a_curl_has_a_potential(force: Point, potential: str) -> None:
    assert step(on_slides(force), "Potential energy")[1] == [potential]


@pytest.mark.parametrize(
    "force", [(-K * Y**3, K * X**3, 0), (-K * T * X**2 * mq.velocity("x"), 0, 0)]
)
def test_a_load_with_a_curl_has_none(force: Point) -> None:
    equations = on_slides(force)
    assert step(equations, "Potential energy")[1] == ["V = 0"]
    assert not [stage for stage in equations.steps if stage.title == "Energy integral"]


def test_kinetic_energies_are_in_the_books_form() -> None:
    """Goldstein, eqs. 5.50-5.54; the pendulum of Foucault by its angular velocities."""
    _, (T,) = step(derive_system("heavy_top"), "Kinetic energy")
    assert T == (
        "T = 3 m (r^2 + 4 h^2) (theta'^2 + sin(theta)^2 phi'^2)/40"
        " + 3 m r^2 (psi' + cos(theta) phi')^2/20"
    )
    _, lines = step(derive_system("heavy_top"), "Operator for psi")
    assert lines[0] == "p_psi = 3 m r^2 (psi' + cos(theta) phi')/10"
    _, lines = step(derive_system("heavy_top"), "Operator for phi")
    assert lines[0] == (
        "p_phi = 3 m (r^2 + 4 h^2) sin(theta)^2 phi'/20"
        " + 3 m r^2 (psi' + cos(theta) phi') cos(theta)/10"
    )
    _, lines = step(derive_system("gyroscope"), "Kinetic energy")
    assert lines[2] == (
        "T_rotor = m r^2 (theta'^2 + sin(theta)^2 phi'^2)/8 + m r^2 (psi' + cos(theta) phi')^2/4"
    )
    _, (T,) = step(derive_system("foucault_pendulum"), "Kinetic energy")
    assert T == (
        "T = m l^2 ((cos(beta) alpha' - W sin(beta) cos(alpha))^2 + (beta' + W sin(alpha))^2)/2"
    )


@pytest.mark.parametrize(
    ("name", "idle"),
    [
        ("heavy_top", "no force but weights does work:"),
        ("rotating_plate", "no force but springs does work:"),
        ("double_pendulum", "no force but weights does work:"),
        ("particle_on_circle", "no force does work:"),
        ("kepler_orbit", "no force but attraction does work:"),
    ],
)
def test_an_energy_integral_names_what_does_work(name: str, idle: str) -> None:
    assert idle in " ".join(derive_system(name).text(steps=True).split())


@pytest.mark.parametrize("method", [LagrangeOnJets, Recursion, NumericVirtualWork])
def test_a_free_body_has_the_equations_of_kirchhoff(method: type[Recursion]) -> None:
    """In its axes p' + ω × p and H' + ω × H + v × p, p = m (v + ω × c), H = I_A ω + m c × v.

    A slider follows it at s = n·x: s' = Rᵀn·v, s'' = Rᵀn·(v' + ω × v).
    G. Kirchhoff, Vorlesungen über Mechanik, 1876, lecture 19.
    """
    m, c, sides = 2.0, np.array([0.1, -0.2, 0.3]), np.array([0.3, 0.4, 0.5])
    light, n = 0.7, np.array([1.0, 2.0, -1.0])
    x, y, z = map(mq.coordinate, ("free_x", "free_y", "free_z"))
    free = mq.Mechanism(
        "free",
        (
            mq.Body("ground"),
            mq.Body("box", mq.box(m, tuple(sides)).at(tuple(c))),
            mq.Body("slider", mq.particle(light)),
        ),
        (
            floating := mq.Floating("free", "ground", "box"),
            mq.Prismatic("rail", "ground", "slider", axis=(1, 0, 0), coordinate="s"),
        ),
        coordinates=mq.Coordinates(floating.coordinates, {"s": x + 2 * y - z}),
        gravity=(0, 0, 0),
    )
    I_A = m / 12 * np.diag(sides @ sides - sides**2) + m * (c @ c * np.eye(3) - np.outer(c, c))
    lever = m * np.cross(np.eye(3), c).T  # m c × is its transpose
    M = np.block([[m * np.eye(3), lever], [lever.T, I_A]])
    rng = np.random.default_rng(0)
    p = rng.normal(size=(5, 4))
    p /= np.linalg.norm(p, axis=1)[:, None]
    states = States.of(free, np.hstack([rng.normal(size=(5, 3)), p]), rng.normal(size=(5, 6)))
    equations = method(free)
    found = equations.mass_matrix(states), equations.bias(states)
    for state, p_k, M_k, bias in zip(states.v, p, *found, strict=True):
        v, w = np.split(state, 2)
        push, turn = np.split(M @ state, 2)
        g = np.concatenate([Rotation.from_quat(p_k).as_matrix().T @ n, np.zeros(3)])
        np.testing.assert_allclose(M_k, M + light * np.outer(g, g), rtol=0, atol=1e-12)
        expected = np.concatenate([np.cross(w, push), np.cross(w, turn) + np.cross(v, push)])
        expected += light * g * (g[:3] @ np.cross(w, v))
        np.testing.assert_allclose(bias, expected, rtol=0, atol=1e-12)


def hammer(
    *shapes: mq.Shape,
    loads: tuple[mq.JointForce, ...] = (),
    parameters: tuple[mq.Parameter, ...] = (),
) -> mq.Mechanism:
    return mq.Mechanism(
        "hammer",
        (mq.Body("ground"), mq.Body("hammer", *shapes)),
        (mq.Revolute("pin", "ground", "hammer", axis=(0, -1, 0), coordinate="q"),),
        forces=(mq.JointDamper("oil", "pin", 0.5), mq.JointSpring("coil", "pin", 7.0), *loads),
        parameters=parameters,
    )


@pytest.mark.parametrize(
    ("shapes", "said", "moment"),
    [
        ([mq.rod(0.6, 2.0)], "hammer is a slender rod: m l²/12 about a transverse axis.", 0.2),
        (
            [mq.rod(0.6, 2.0), mq.rod(0.6, 2.0)],
            "hammer is made of 2 slender rods: its moments are the sums over these parts",
            0.4,
        ),
        (
            [mq.rod(0.6, 2.0), mq.particle(0.6, (0, 0, -1.0)), mq.massless()],
            "hammer is made of a slender rod and a particle: its moments are the sums",
            0.2,
        ),
        ([mq.Shape(1.0, inertia=(1, 2, 2, 0, 0, 0))], "The moments of the hammer are given.", 2.0),
    ],
)
def test_a_derivation_says_of_which_parts_a_moment_is_the_sum(
    shapes: list[mq.Shape], said: str, moment: float
) -> None:
    first = mq.derive(hammer(*shapes)).steps[0]
    assert said in first.explanation
    (inertia,) = (r for r in first.results if str(r).startswith("I_hammer_yy"))
    assert float(str(inertia).split(" = ")[1]) == pytest.approx(moment, rel=1e-12)


def test_the_sum_over_parts_that_is_printed_is_the_moment() -> None:
    """A rod and a ball at its end: both own moments, and what Steiner's theorem adds."""
    at = {"m": 0.6, "l": 2.0, "M": 1.7, "r": 0.3}
    m, l, M, r = letters = tuple(mq.Parameter(name, value) for name, value in at.items())
    club = hammer(mq.rod(m, l), mq.ball(M, r).at((0, 0, -l)), parameters=letters)
    _, lines = step(mq.derive(club), "Moments of inertia")
    (moment,) = (line.split(" = ")[1] for line in lines if line.startswith("I_hammer_yy"))
    assert {"m l^2/12", "2 M r^2/5"} <= {*moment.split(" + ")}
    reduced = at["m"] * at["M"] / (at["m"] + at["M"])
    exact = at["m"] * at["l"] ** 2 / 12 + 2 * at["M"] * at["r"] ** 2 / 5 + reduced * at["l"] ** 2
    # a rod hangs from its end: the centers are half a length apart
    exact -= 0.75 * reduced * at["l"] ** 2
    assert value_of_text(moment, at) == pytest.approx(exact, rel=1e-12)


def test_generalized_forces_are_of_loads_alone() -> None:
    """The work of springs is in V, that of dampers in D; what has no load has no such step."""
    title = "Virtual work of drives and loads"
    loads = (mq.JointForce("drive", "pin", 3.0), mq.JointForce("more", "pin", 0.25))
    for given, expected in (((), []), (loads[:1], ["Q_q = 3"]), (loads, ["Q_q = 3.25"])):
        steps = mq.derive(hammer(mq.rod(0.6, 2.0), loads=given)).steps
        written = [str(r) for step in steps if step.title == title for r in step.results]
        assert written == expected
        assert [str(r) for step in steps if step.title == "Dissipation" for r in step.results] == [
            "D = 0.25 q'^2"
        ]


def test_the_energy_of_a_body_that_slides_and_turns_is_that_of_its_center_and_of_squares() -> None:
    """T = m v²/2 + Σ I w²/2 by its principal moments (König), if its frame is in its center."""
    A, B, C = (mq.Parameter(name, value) for name, value in (("A", 1.0), ("B", 2.0), ("C", 2.5)))
    m = mq.Parameter("m", 3.0, "kg")
    for aside in (0.0, 0.2):
        stone = mq.Body("stone", mq.Shape(m, (0, aside, 0), (A, B, C, 0, 0, 0)))
        lagrange = Lagrange(
            mq.Mechanism(
                "stone",
                (mq.Body("ground"), mq.Body("lift"), stone),
                (
                    mq.Prismatic("rise", "ground", "lift", axis=(0, 0, 1), coordinate="z"),
                    mq.Universal("ball", "lift", "stone", names=("p", "q")),
                ),
                parameters=(A, B, C, m),
            )
        )
        squares, ring = lagrange.squares["stone"], lagrange.algebra.ring
        if aside:
            assert squares == ()  # of another point than the center, mixed terms are left
            continue
        assert [str(moment) for moment, _ in squares] == ["A", "B", "C"]
        halves = [moment * w * w / 2 for moment, w in squares]
        assert ring.sum([*halves, ring["m"] * ring["z'"] ** 2 / 2]) == lagrange.T


@pytest.mark.parametrize(
    ("load", "potential"),
    [
        (mq.Force("pull", "block", (0, 0, 0), (-4 * mq.coordinate("x"), 0, 5)), "2*x^2"),
        (mq.JointForce("cubic", "slide", -3 * mq.coordinate("x") ** 3), "3/4*x^4"),
        (mq.JointForce("drag", "slide", -3 * mq.velocity("x")), None),
    ],
    ids=lambda x: getattr(x, "name", ""),
)
def test_loads_store_what_their_virtual_work_takes(load: mq.AnyForce, potential: str) -> None:
    """Beside a spring, which is known to store energy, and a load that stores nothing."""
    spring = mq.JointSpring("spring", "slide", 5.0)
    motor = mq.JointForce("motor", "slide", mq.sin(mq.time()) * mq.velocity("x"))
    mechanism = mq.Mechanism(
        "block",
        (mq.Body("ground"), mq.Body("block", mq.particle(1.0))),
        (mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        forces=(spring, motor, load),
    )
    stored = stored_in_loads(mechanism)
    assert {name: str(series) for name, series in stored.items()} == (
        {load.name: potential} if potential else {}
    )
    # it is part of V, but not of what counts as stored
    lagrange = Lagrange(mechanism)
    x = lagrange.algebra.ring["x"]
    assert lagrange.stored == 5 * x**2 / 2
    assert lagrange.V - lagrange.stored == lagrange.algebra.ring.sum([*stored.values()])


def test_loads_that_store_energy_together_alone_do_not() -> None:
    """F_x = -6 (x - y) and F_y = 6 (x - y), with V = 3 (x - y)²; a third, alone, has its own."""
    x, y, z = map(mq.coordinate, "xyz")
    loads = (("first", "x", -6 * (x - y)), ("third", "z", -4 * z), ("second", "y", 6 * (x - y)))
    mechanism = mq.Mechanism(
        "blocks",
        (mq.Body("ground"), *(mq.Body(f"b{q}", mq.particle(1.3)) for q in "xyz")),
        tuple(
            mq.Prismatic(f"rail_{q}", "ground", f"b{q}", axis=(1, 0, 0), coordinate=q)
            for q in "xyz"
        ),
        forces=tuple(mq.JointForce(name, f"rail_{q}", law) for name, q, law in loads),
        gravity=(0, 0, 0),
    )
    stored = {name: str(V) for name, V in stored_in_loads(mechanism).items()}
    lagrange = Lagrange(mechanism)
    a, b, c = (lagrange.algebra.ring[q] for q in "xyz")
    assert stored == {"first": str(3 * (a - b) ** 2), "third": "2*z^2", "second": "0"}
    assert 3 * (a - b) ** 2 + 2 * c**2 == lagrange.V
    both = replace(mechanism, forces=mechanism.forces[:2])
    assert list(stored_in_loads(both)) == ["third"]
