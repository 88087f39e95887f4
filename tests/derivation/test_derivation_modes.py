"""Equations of modes: closed forms, and each against constraints over Pinocchio's quantities."""

from __future__ import annotations

import math
from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
import pytest
import sympy as sp
from sides import TRIPOD, make_corner, make_sled, make_standing_box

import mecanique as mq
from mecanique.derivation import switching
from mecanique.derivation.mechanics.switching import OPEN, SLIPS, STICKS, ElementState, Mode
from mecanique.derivation.switching import ModeCondition, ModeEquations, Modes
from mecanique.model.states import States
from mecanique.motion.switching.law import Laws
from mecanique.motion.switching.rows import SwitchingRows
from mecanique.verification.modes import solve_mode

m, g, mu, mu0 = (
    mq.Parameter("m", 1.3, "kg"),
    mq.Parameter("g", 9.81, "m/s²"),
    mq.Parameter("mu", 0.2),
    mq.Parameter("mu_0", 0.25),
)
alpha, r, length = (
    mq.Parameter("alpha", 0.3, "rad"),
    mq.Parameter("r", 0.1, "m"),
    mq.Parameter("l", 2.0, "m"),
)
INCLINED = (g * mq.sin(alpha), 0, -g * mq.cos(alpha))
PARAMETERS = (m, g, mu, mu0, alpha, r, length)


def block() -> mq.Mechanism:
    """Return a block on an incline."""
    bodies = mq.Body("ground"), mq.Body("block", mq.box(m, (0.1, 0.1, 0.1)))
    slide = mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x")
    dry = mq.Friction("dry", "slide", mu, m * g * mq.cos(alpha), mu_static=mu0)
    return mq.Mechanism(
        "block", bodies, (slide,), parameters=PARAMETERS, gravity=INCLINED, switching=(dry,)
    )


def flat(shape: object, contact: mq.Contact) -> mq.Mechanism:
    """Return a body in the plane x, z on an incline."""
    bodies = mq.Body("ground"), mq.Body("body", shape)  # type: ignore[arg-type]
    plane = mq.Planar("plane", "ground", "body", axis=(0, -1, 0), names=("x", "z", "th"))
    return mq.Mechanism(
        "flat", bodies, (plane,), parameters=PARAMETERS, gravity=INCLINED, switching=(contact,)
    )


BALL = flat(mq.ball(m, r), mq.Contact("floor", "body", radius=r, mu=mu))
ROD = flat(mq.rod(m, length), mq.Contact("floor", "body", mu=mu))


def test_a_rod_that_slips_turns_as_factored_by_hand() -> None:
    slips = mq.derive_modes(ROD)["slips -"]
    assert str(slips).splitlines()[3] == (
        "  th'' = -3 (2 g cos(alpha) + l cos(th) th'^2) (mu cos(th) + sin(th))"
        "/(l (1 + 3 mu sin(th) cos(th) + 3 sin(th)^2))"
    )
    opened = str(mq.derive_modes(ROD)["open"]).splitlines()
    assert opened[1] == "  x'' = (2 g sin(alpha) + l sin(th) th'^2)/2"


def test_a_ball_on_a_level_cloth_rolls_without_friction() -> None:
    rolls = mq.derive_modes(mq.textbook.load("billiard_ball"))["sticks"]
    assert rolls.conditions == ("while m g ≥ 0", "sticks always, as no friction is needed")
    assert str(rolls).splitlines()[4] == "  N_cloth = m g"


def test_numbers_given_as_decimals_stay_decimals() -> None:
    ball = flat(mq.ball(m, 0.1), mq.Contact("floor", "body", radius=0.1, mu=mu))
    slips = str(mq.derive_modes(ball)["slips +"])
    assert "  th'' = -25 g mu cos(alpha)" in slips


def test_decimals_of_friction_leave_nothing_over_that_cancels() -> None:
    """Products of decimals were rounded: a car with locked wheels sank by 2 mm/s²."""
    car = mq.Shape(1000.0, inertia=(1500.0, 1500.0, 1500.0, 0, 0, 0))
    front = mq.Contact("front", "body", center=(1.2, 0, -0.5), mu=0.8)
    rear = mq.Contact("rear", "body", center=(-1.3, 0, -0.5), mu=0.8)
    both = replace(flat(car, front), gravity=(0, 0, -9.81), switching=(front, rear))
    (slides,) = mq.derive_modes(both, only=[{"front": "slips +", "rear": "slips +"}]).modes
    assert str(slides).splitlines()[1:] == [
        "  x'' = -7.848",
        "  z'' = 0",
        "  th'' = 0",
        "  N_front = 6670.8",
        "  T_front = -5336.64",
        "  N_rear = 3139.2",
        "  T_rear = -2511.36",
        "  at th = 0",
        "  at z = 0.5",
        "  front presses always",
        "  while x' > 0",
        "  rear presses always",
    ]


def test_modes_in_numbers_alone_are_short_and_say_whether_they_hold() -> None:
    """A zero counted as a term, so that a disk in a corner was too long to be read."""
    disk = mq.disk(1.0, 0.1).at(rpy=(math.pi / 2, 0, 0))
    floor = mq.Contact("floor", "body", radius=0.1, mu=0.4)
    side = mq.Placement((1.0, 0, 0), (0, -math.pi / 2, 0))
    wall = mq.Contact("wall", "body", radius=0.1, mu=0.2, plane=side)
    corner = replace(flat(disk, floor), gravity=(0, 0, -9.81), switching=(floor, wall))
    only = [{"floor": "slips -", "wall": "sticks"}, {"floor": "slips +", "wall": "slips +"}]
    sticks, slips = mq.derive_modes(corner, only=only).modes
    assert sticks.conditions == (
        "floor presses always",
        "while x' + 0.1 th' < 0",
        "wall presses always",
        "never, as 1 > 0.2",
    )
    assert slips.conditions[2] == "never, as N_wall would be -3.633333333333"


def test_a_block_sticks_up_to_the_angle_of_repose() -> None:
    modes = mq.derive_modes(block())
    assert str(modes["sticks"]).splitlines() == [
        "dry sticks:",
        "  x'' = 0",
        "  R_dry = -m g sin(alpha)",
        "  sticks if |tan(alpha)| ≤ mu_0",
    ]
    down = modes["slips +"]
    a, G, c = sp.symbols("alpha g mu")
    assert sp.simplify(down.accelerations["x''"] - G * (sp.sin(a) - c * sp.cos(a))) == 0
    assert down.conditions == ("while x' > 0",)
    up = modes["slips -"]
    assert sp.simplify(up.accelerations["x''"] - G * (sp.sin(a) + c * sp.cos(a))) == 0


def test_a_ball_rolls_down_while_two_sevenths_of_the_slope_are_below_friction() -> None:
    modes = mq.derive_modes(BALL)
    rolling = modes["sticks"]
    a, G = sp.symbols("alpha g")
    assert sp.simplify(rolling.accelerations["x''"] - sp.Rational(5, 7) * G * sp.sin(a)) == 0
    assert rolling.conditions[1] == "sticks if |2 tan(alpha)/7| ≤ mu"
    assert modes["slips +"].conditions[1] == "while r th' + x' > 0"


def test_what_sticks_holds_by_static_friction_and_slips_by_that_of_motion() -> None:
    rough = mq.Contact("floor", "body", radius=r, mu=mu, mu_static=mu0)
    modes = mq.derive_modes(flat(mq.ball(m, r), rough))
    assert modes["sticks"].conditions[1] == "sticks if |2 tan(alpha)/7| ≤ mu_0"
    a, G, c = sp.symbols("alpha g mu")
    down = modes["slips +"].accelerations["x''"]
    assert sp.simplify(down - G * (sp.sin(a) - c * sp.cos(a))) == 0


def test_letters_of_products_stand_after_sums_but_before_their_rates() -> None:
    x, c = mq.coordinate("x"), mq.Parameter("c", 1.0, "N·s/m")
    push = mq.JointForce("push", "slide", c * x * (length + x) * mq.velocity("x") / length**2)
    pushed = replace(block(), gravity=(0, 0, 0), forces=(push,), parameters=(*PARAMETERS, c))
    assert str(mq.derive_modes(pushed)["sticks"]).splitlines()[2] == (
        "  R_dry = -c (l + x) x x'/l^2"
    )


def test_forces_of_elements_are_explained() -> None:
    meanings = dict(mq.derive_modes(BALL).symbols)
    assert meanings["N_floor"] == "force by which floor presses"
    assert meanings["T_floor"] == "friction of floor"
    assert meanings["g"].endswith("[m/s²]")
    assert dict(mq.derive_modes(block()).symbols)["R_dry"] == "friction of dry"


def test_a_stop_says_what_it_bears() -> None:
    hinge = mq.Revolute("pin", "ground", "rod", axis=(0, -1, 0), coordinate="q")
    rod = mq.Mechanism(
        "rod",
        (mq.Body("ground"), mq.Body("rod", mq.rod(m, length))),
        (hinge,),
        parameters=PARAMETERS,
        gravity=(0, 0, -g),
        switching=(mq.Stop("wall", "pin", at=0.1),),
    )
    closed = mq.derive_modes(rod)["closed"]
    q, M, G, L = sp.symbols("q m g l")
    assert closed.accelerations["q''"] == 0
    assert sp.simplify(closed.forces["N_wall"] + M * G * L * sp.sin(q) / 2) == 0


STATES = {
    "open": ElementState(OPEN),
    "closed": ElementState("closed"),
    "sticks": ElementState(STICKS),
    "slips +": ElementState("slips +", (1.0,)),
    "slips -": ElementState("slips -", (-1.0,)),
}


def ball_on_a_seesaw() -> mq.Mechanism:
    """Return a ball in the plane on a board that turns."""
    bodies = mq.Body("ground"), mq.Body("board", mq.rod(m, length)), mq.Body("ball", mq.ball(m, r))
    joints = (
        mq.Revolute("pin", "ground", "board", axis=(0, -1, 0), coordinate="q"),
        mq.Planar("plane", "ground", "ball", axis=(0, -1, 0), names=("x", "z", "th")),
    )
    touch = mq.Contact("touch", "ball", radius=r, on="board", mu=mu)
    return mq.Mechanism(
        "seesaw", bodies, joints, parameters=PARAMETERS, gravity=INCLINED, switching=(touch,)
    )


@pytest.mark.parametrize(
    "mechanism", [block(), BALL, ROD, ball_on_a_seesaw()], ids=["block", "ball", "rod", "seesaw"]
)
def test_every_mode_is_that_of_the_reference(mechanism: mq.Mechanism) -> None:
    """M a + h = Q + Jᵀ R in letters, against the engine's M, bias and rows of contacts."""
    rows = SwitchingRows(mechanism)
    laws = Laws(rows.elements, rows.permanent)
    random = np.random.default_rng(34)
    names = [*mechanism.coordinates, *mechanism.velocities]
    symbols = [sp.Symbol(name) for name in (*names, *mechanism.values)]
    for mode in mq.derive_modes(mechanism).modes:
        chosen: Mode = tuple(STATES[state] for state in mode.states.values())
        function = sp.lambdify(symbols, [*mode.accelerations.values()])
        for _ in range(5):
            q, v = random.normal(size=mechanism.nq), random.normal(size=mechanism.nv)
            solution = laws.solve(rows.at(q, v, 0.0), chosen)
            assert solution is not None
            expected = function(*q, *v, *mechanism.values.values())
            np.testing.assert_allclose(solution.a, expected, rtol=1e-10, atol=1e-10)


def count_modes(friction: float, rate: float, slip: float) -> int:
    """Return how many modes follow for a rod that stands on the floor at tan 2, and slides."""
    rod = mq.Mechanism(
        "rod",
        (mq.Body("ground"), mq.Body("body", mq.rod(1.0, 2.0))),
        (mq.Planar("plane", "ground", "body", axis=(0, -1, 0), names=("x", "z", "th")),),
        switching=(mq.Contact("floor", "body", mu=friction),),
    )
    rows = SwitchingRows(rod)
    laws = Laws(rows.elements, rows.permanent)
    # upright at π, leaning by atan 1/2 from there
    q = np.array([0.0, 0.0, math.pi + math.atan(0.5)])
    terms = rows.at(q, np.array([slip, 0.0, rate]), 0.0)
    return len(laws.follow(terms, [True], 1e-12))


@pytest.mark.parametrize(
    ("friction", "rate", "counts"),
    [(1.3, 0.0, {1}), (1.3, 6.0, {1}), (1.4, 0.0, {0, 1}), (1.4, 6.0, {1, 2})],
)
def test_painleves_rod_has_no_solution_or_two_beyond_four_thirds(
    friction: float, rate: float, counts: set[int]
) -> None:
    """In one of the two directions of slip (A. Champneys & P. Várkonyi, arXiv 1601.03545)."""
    assert {count_modes(friction, rate, slip) for slip in (1.0, -1.0)} == counts


@pytest.mark.parametrize("state", ["slips +", "slips -"])
def test_where_painleves_rod_has_no_solution_or_two_is_said(state: str) -> None:
    """Least of all angles, 5/2 − 3/2 √(1 + μ²) is zero at μ = 4/3."""
    mode = mq.derive_modes(mq.textbook.load("painleve_rod"))[state]
    (paradox,) = (part for part in mode.held if "Painlevé" in part.words)
    assert paradox.words == "no mode follows, or two with floor open (Painlevé), if"
    assert (paradox.sign, paradox.right) == ("<", 0)
    th = np.linspace(-np.pi / 2, np.pi / 2, 100_001)
    for friction in (0.5, 4 / 3, 2.0):
        opens = sp.lambdify("th", paradox.left.subs("mu", friction))(th)
        least = 2.5 - 1.5 * math.sqrt(1 + friction**2)
        assert opens.min() == pytest.approx(least, abs=1e-8)


def test_the_paradox_is_said_of_a_number_and_not_of_what_has_none() -> None:
    rod = mq.textbook.load("painleve_rod")
    floor: Any = rod.switching[0]
    numbered = mq.derive_modes(replace(rod, switching=(replace(floor, mu=2, mu_static=2),)))
    (said,) = (c for c in numbered["slips +"].conditions if "Painlevé" in c)
    assert said.endswith("if -6 sin(th) cos(th) - 3 cos(th)^2 + 4 < 0")
    ball = mq.derive_modes(mq.textbook.load("bouncing_ball"))
    assert "Painlevé" not in str(ball)


def test_what_modes_are_not_written_out_is_said() -> None:
    dome = flat(mq.ball(m, r), mq.Contact("dome", "body", radius=r, bowl=-1.0))
    with pytest.raises(mq.DerivationError, match="'dome' is not with a plane; the equations"):
        mq.derive_modes(dome)
    with pytest.raises(mq.DerivationError, match="expected the states of a mode, sticks; slips"):
        mq.derive_modes(block())["open"]
    assert SLIPS not in STATES


def test_more_modes_than_are_written_out_are_refused() -> None:
    one = block()
    brakes = tuple(mq.Friction(f"dry{k}", "slide", mu, m * g) for k in range(5))
    many = mq.Mechanism(
        "many", one.bodies, one.joints, parameters=PARAMETERS, gravity=INCLINED, switching=brakes
    )
    with pytest.raises(mq.DerivationError, match="'many' has 243 modes, more than 81; expected"):
        mq.derive_modes(many)
    # those of a motion are written out by name: five brakes are one of five times the friction
    motion = mq.simulate(many, v={"x": 1.0}, duration=0.01)
    (mode,) = mq.derive_modes(many, only=[span.states for span in motion.modes * 2]).modes
    assert set(mode.states.values()) == {"slips +"}
    G, mu_k, slope = sp.symbols("g mu alpha")
    expected = G * (sp.sin(slope) - 5 * mu_k)
    assert sp.simplify(mode.accelerations["x''"] - expected) == 0
    with pytest.raises(mq.DerivationError, match="expected a state of 'dry0', sticks, slips"):
        mq.derive_modes(many, only=[{"dry1": "sticks"}])


def test_modes_of_single_elements_are_those_in_which_the_others_keep_their_first_state() -> None:
    """Open where an element may be, otherwise sticking."""
    block = mq.textbook.load("two_blocks")
    first, second = (joint.name for joint in block.joints)
    elements = mq.Stop("wall", first, at=2.0), mq.Friction("dry", second, 0.3, 5.0)
    modes = mq.derive_modes(replace(block, switching=elements), only="single").modes
    assert [tuple(mode.states.values()) for mode in modes] == [
        ("open", "sticks"),
        ("closed", "sticks"),
        ("open", "slips +"),
        ("open", "slips -"),
    ]


def test_constraints_that_hold_in_every_mode_are_refused() -> None:
    linkage = mq.textbook.load("four_bar_linkage")
    dry = mq.Friction("dry", linkage.joints[0].name, 0.1, 1.0)
    with pytest.raises(mq.DerivationError, match="'four_bar_linkage' has constraints that hold in"):
        mq.derive_modes(replace(linkage, switching=(dry,)))


def test_friction_in_space_is_against_slip() -> None:
    """A ball on a level floor: T = −μ m g s/|s|, in the plane of the floor (Coriolis, 1835)."""
    ball = mq.Mechanism(
        "ball",
        (mq.Body("ground"), mq.Body("body", mq.ball(m, r))),
        (mq.Floating("free", "ground", "body"),),
        parameters=PARAMETERS,
        gravity=(0, 0, -g),
        switching=(mq.Contact("floor", "body", radius=r, mu=mu),),
    )
    modes = mq.derive_modes(ball)
    text = str(modes["slips"])
    assert "N_floor = m g\n" in text
    assert "T_floor_x = -N_floor s_floor_x mu/s_floor\n" in text
    assert "where s_floor = sqrt(s_floor_x^2 + s_floor_y^2)\n" in text
    assert modes["sticks"].conditions[-1] == "sticks always, as no friction is needed"
    meanings = dict(modes.symbols)
    assert meanings["T_floor_y"] == "friction of floor along y of its plane"
    names = [*ball.coordinates, *ball.velocities, *ball.values]
    upright = dict.fromkeys(names, 0.0) | {"free_qw": 1.0, **ball.values}
    moving = upright | {"free_vx": 3.0, "free_vy": 5.0, "free_wx": -10.0, "free_wy": 0.0}
    forces = modes["slips"].forces
    x, y = (float(forces[f"T_floor_{row}"].subs(moving)) for row in "xy")
    # of r ω × z + v
    slip = np.array([3.0, 5.0 - 10.0 * ball.values["r"]])
    values = ball.values
    expected = -values["mu"] * values["m"] * values["g"] * slip / np.linalg.norm(slip)
    np.testing.assert_allclose([x, y], expected, rtol=1e-14, atol=0)
    verdict = mq.verify(ball, samples=5)
    assert verdict.agrees
    assert len(verdict.table[0]) == 5, "open, sticks, slips and an impact"


def test_a_tippe_top_glides_in_letters_and_rolls_by_the_equations_of_its_forces() -> None:
    top = mq.textbook.load("tippe_top")
    modes = mq.derive_modes(top)
    glides, rolls = modes["slips"], modes["sticks"]
    assert not glides.remark
    assert len(rolls.unsolved) == 3
    assert "sticks if sqrt(T_floor_x^2 + T_floor_y^2) ≤ N_floor mu" in rolls.conditions
    assert "top_wz' = (A_top_13 T_floor_y - A_top_23 T_floor_x) r/J_3" in str(rolls)
    # upright and slipping along x: N (1/m + c μ (c − r) 0/J_1) = g, as A_13 and A_23 are zero
    here = dict.fromkeys((*top.coordinates, *top.velocities), 0.0)
    here |= {"top_qw": 1.0, "top_vx": 0.3, **top.values}
    N, T = (float(glides.forces[name].subs(here)) for name in ("N_floor", "T_floor_x"))
    assert pytest.approx(0.02 * 9.81, rel=1e-14) == N
    assert pytest.approx(-0.3 * N, rel=1e-14) == T
    assert mq.verify(top, samples=5).agrees


def test_friction_meets_a_rate_that_time_prescribes() -> None:
    shaken = mq.textbook.load("base_excited_mass")
    names = [joint.name for joint in shaken.joints]
    dry = tuple(mq.Friction(f"dry in {name}", name, 0.1, 1.0) for name in names)
    first, _ = mq.derive_modes(replace(shaken, switching=dry))["slips +", "slips +"].conditions
    assert "cos(" in first
    assert first.endswith("> 0")


def test_a_contact_with_a_body_that_time_moves_is_refused() -> None:
    shaken = mq.textbook.load("base_excited_mass")
    touch = mq.Contact("touch", shaken.bodies[-1].name)
    with pytest.raises(mq.DerivationError, match="'touch': the coordinate map depends on time"):
        mq.derive_modes(replace(shaken, switching=(touch,)))


def test_a_condition_that_fills_a_line_stands_by_itself() -> None:
    short, long = sp.symbols("k"), sum(sp.symbols("a:p"))
    for expression, begin in ((short, " $k$"), (long, "\n\\begin{align")):
        held = (ModeCondition("while", expression),)
        mode = ModeEquations({"belt": "sticks"}, {}, {}, held, {})
        latex = Modes(mq.textbook.load("stick_slip"), (mode,)).latex()
        assert f"while{begin}" in latex


F, v0 = mq.Parameter("F", 4.0, "N"), mq.Parameter("v", 0.3, "m/s")
k = mq.Parameter("k", 50.0, "N/m")
DRAWN = mq.JointForce("drawn", "slide", F)


def on_a_slide(
    element: mq.Stop | mq.Friction, *forces: mq.JointForce | mq.JointSpring
) -> mq.Mechanism:
    return mq.Mechanism(
        "slider",
        (mq.Body("ground"), mq.Body("block", mq.box(m, (0.1, 0.1, 0.1)))),
        (mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        forces=forces,
        parameters=(m, k, F, v0),
        gravity=(0, 0, 0),
        switching=(element,),
    )


def test_modes_say_between_which_ends_of_a_side_they_hold() -> None:
    """In letters: |x + b/2 + L/2| ≤ L/2 for the block's corner, |x| ≤ b/2 for the table's."""
    b, L, g = (mq.Parameter(*given) for given in (("b", 0.4, "m"), ("L", 2.0, "m"), ("g", 9.81)))
    sled = make_sled(0.4)
    front, lip = sled.switching
    assert isinstance(front, mq.Contact)
    assert isinstance(lip, mq.Contact)
    top = mq.Placement((-L / 2, 0, 0))
    corners = (
        replace(front, center=(b / 2, 0, 0), plane=top, length=L),
        replace(lip, length=b),
    )
    letters = replace(sled, parameters=(b, L, g), gravity=(0, 0, -g), switching=corners)
    modes = mq.derive_modes(letters)
    assert modes["closed", "open"].conditions == (
        "while |(b + L + 2 x)/2| ≤ L/2",
        "while g ≥ 0",
        "while lip is apart, or beyond an end of its side",
    )
    assert "while |x| ≤ b/2" in modes["open", "closed"].conditions
    assert mq.verify(letters, samples=5).agrees


@pytest.mark.parametrize(
    ("mechanism", "state", "lines"),
    [
        # an elastic stop presses by what it is pressed in, k (x − ½)
        (
            on_a_slide(mq.Stop("wall", "slide", at=0.5, stiffness=k)),
            "closed",
            ["x'' = k (1 - 2 x)/(2 m)", "N_wall = k (2 x - 1)/2", "while k (2 x - 1)/2 ≥ 0"],
        ),
        (
            on_a_slide(mq.Stop("wall", "slide", at=0.5), DRAWN),
            "open",
            ["x'' = F/m", "while wall is apart"],
        ),
        # a latch holds a block that is drawn away with up to 4 N
        (
            on_a_slide(mq.Stop("wall", "slide", at=0.5, side=-1, holds=4.0), DRAWN),
            "closed",
            ["x'' = 0", "N_wall = -F", "while -F ≥ -4"],
        ),
        (
            on_a_slide(mq.Stop("wall", "slide", at=0.5), mq.JointForce("back", "slide", -3.0)),
            "closed",
            ["x'' = 0", "N_wall = -3", "never, as N_wall would be -3"],
        ),
        (
            on_a_slide(mq.Stop("wall", "slide", at=0.5), mq.JointForce("on", "slide", 3.0)),
            "closed",
            ["x'' = 0", "N_wall = 3", "wall presses always"],
        ),
        # a belt that moves at v: friction is against the slip x' − v
        *(
            (
                on_a_slide(
                    mq.Friction("dry", "slide", 0.3, F, mu_static=0.4, speed=v0),
                    mq.JointSpring("spring", "slide", k),
                ),
                state,
                lines,
            )
            for state, lines in (
                ("sticks", ["x'' = 0", "R_dry = k x", "sticks if |k x/F| ≤ 0.4"]),
                ("slips +", ["x'' = -0.1 (10 k x + 3 F)/m", "R_dry = -0.3 F", "while x' - v > 0"]),
                ("slips -", ["x'' = 0.1 (3 F - 10 k x)/m", "R_dry = 0.3 F", "while x' - v < 0"]),
            )
        ),
        # without a load nothing rubs, and a block that nothing moves rests without friction
        (
            on_a_slide(mq.Friction("dry", "slide", 0.3, 0.0), DRAWN),
            "sticks",
            ["x'' = 0", "R_dry = -F", "sticks if -F = 0"],
        ),
        (
            on_a_slide(mq.Friction("dry", "slide", 0.3, 0.0)),
            "sticks",
            ["x'' = 0", "sticks always, as no friction is needed"],
        ),
    ],
)
def test_a_mode_says_its_forces_and_when_it_holds(
    mechanism: mq.Mechanism, state: str, lines: list[str]
) -> None:
    title, *found = str(mq.derive_modes(mechanism)[state]).splitlines()
    assert title.endswith(f" {state}:")
    assert [line.strip() for line in found] == lines


def test_what_presses_itself_against_a_stop_is_not_determined_where_it_also_sticks() -> None:
    """A stop along a slide and friction in the same slide share what holds the block."""
    wall, dry = mq.Stop("wall", "slide", at=0.5), mq.Friction("dry", "slide", 0.3, "wall")
    both = replace(on_a_slide(wall, DRAWN), switching=(wall, dry))
    modes = mq.derive_modes(both)
    assert "its forces are not determined by rigid bodies" in str(modes["closed", "sticks"])
    slips = modes["closed", "slips +"]
    assert slips.accelerations["x''"] == 0
    presses, rubs = (float(slips.forces[name] / sp.Symbol("F")) for name in ("N_wall", "R_dry"))
    assert (presses, rubs) == pytest.approx((1 / 1.3, -0.3 / 1.3), rel=1e-12)


@pytest.mark.slow  # 6 s, of minutes where fractions were solved for as fractions
def test_the_open_mode_of_a_linkage_is_solved_in_letters() -> None:
    crank = mq.textbook.load("clearance_slider_crank")
    (mode,) = mq.derive_modes(crank, only=[{e.name: "open" for e in crank.switching}]).modes
    q, v = np.array([0.4, -0.9, 0.3]), np.array([2.0, -1.0, 0.5])
    letters = zip((*crank.coordinates, *crank.velocities), (*q, *v), strict=True)
    values = crank.values | dict(letters)
    named = {sp.Symbol(name): value for name, value in values.items()}
    solved = [float(formula.subs(named)) for formula in mode.accelerations.values()]
    rhs = mq.Reference(replace(crank, switching=())).rhs()
    free = rhs(0.0, np.concatenate([q, v]))[3:]
    np.testing.assert_allclose(solved, free, rtol=1e-10, atol=0)


def test_modes_too_long_to_be_read_are_told_by_the_equations_they_solve() -> None:
    """They were solved for minutes; what is told gives the accelerations of the engine's side."""
    crank = mq.textbook.load("clearance_slider_crank")
    names = [element.name for element in crank.switching]
    states = dict(zip(names, ("slips +", "open", "open", "open"), strict=True))
    modes = mq.derive_modes(crank, only=[states])
    (mode,) = modes.modes
    assert not mode.accelerations
    assert "it is too long to be read; they follow from" in str(modes)
    assert "T_upper_left = -N_upper_left mu" in str(modes)
    assert "while N_upper_left ≥ 0" in mode.conditions
    assert "it is too long to be read" in modes._repr_html_()
    assert modes.latex().count("= 0") == len(mode.unsolved) == 4
    q, v = np.array([[0.4, -0.9, 0.3]]), np.array([[2.0, -1.0, 0.5]])
    numbers = (*q[0], *v[0])
    letters = dict(zip((*crank.coordinates, *crank.velocities), numbers, strict=True))
    named = {sp.Symbol(name): x for name, x in (crank.values | letters).items()}
    unknowns = [sp.Symbol(f"{name}'") for name in crank.velocities]
    unknowns.append(sp.Symbol("N_upper_left"))
    matrix, right = sp.linear_eq_to_matrix([law.subs(named) for law in mode.unsolved], unknowns)
    solved = np.linalg.solve(*(np.array(part.tolist(), dtype=float) for part in (matrix, right)))
    at = States(replace(crank, switching=()), q, v, np.zeros(1), np.zeros((1, 3)))
    expected, _ = solve_mode(crank, states, at)
    np.testing.assert_allclose(solved[:, 0], expected[0, :4], rtol=1e-9, atol=0)


def test_two_feet_that_stick_share_the_force_between_them_however_a_box_is_turned() -> None:
    """Its modes without accelerations had numbers of 10³³, and code of them did not run."""
    feet = [{"c0": OPEN, "c1": state, "c2": STICKS} for state in (STICKS, OPEN, SLIPS)]
    both, alone, beside = mq.derive_modes(make_standing_box(0.3, feet=TRIPOD), only=feet).modes
    assert both.remark == "its forces are not determined by rigid bodies"
    for mode in (alone, beside):
        assert "it is too long to be read" in mode.remark
        numbers = [abs(n) for law in mode.unsolved for n in law.atoms(sp.Number)]
        assert max(numbers) < 100


def test_a_coefficient_after_stribeck_is_written_with_its_rate() -> None:
    """Of numbers alone, without letters, a mode is solved as well."""
    rate = sp.Symbol("x'")
    bodies = mq.Body("ground"), mq.Body("block", mq.box(1.0, (0.1, 0.1, 0.1)))
    slide = mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x")
    dry = mq.Friction("dry", "slide", 0.2 + 0.1 * sp.exp(-((rate / 0.5) ** 2)), 2.0, mu_static=0.3)
    modes = mq.derive_modes(mq.Mechanism("block", bodies, (slide,), switching=(dry,)))
    forward = modes["slips +"].accelerations["x''"]
    for speed in (0.1, 0.4, 2.0):
        expected = -2.0 * (0.2 + 0.1 * math.exp(-((speed / 0.5) ** 2)))
        assert float(forward.subs(rate, speed)) == pytest.approx(expected, rel=1e-12, abs=0)


def test_roots_of_angles_are_solved_for_as_letters() -> None:
    """A slope of 30° has the sine 1/2 and the cosine √3/2."""
    slides = mq.derive_modes(make_corner(0.2))["slips +", "open"]
    along = 9.81 * (0.5 - 0.2 * np.sqrt(0.75))
    assert float(slides.accelerations["x''"]) == pytest.approx(along * np.sqrt(0.75), rel=1e-9)
    assert float(slides.accelerations["z''"]) == pytest.approx(-along / 2, rel=1e-9)


def make_box(*levels: int, friction: mq.Parameter | float = mu) -> mq.Mechanism:
    """Return a box on an incline with the corners below its center, above it, or both."""
    b, h = mq.Parameter("b", 0.2, "m"), mq.Parameter("h", 0.4, "m")
    bodies = mq.Body("ground"), mq.Body("block", mq.box(m, (b, b, h)))
    plane = mq.Planar("plane", "ground", "block", axis=(0, -1, 0), names=("x", "z", "th"))
    corners = [
        mq.Contact(f"{name} {level}", "block", (side * b / 2, 0, level * h / 2), mu=friction)
        for level in levels
        for name, side in (("rear", -1), ("front", 1))
    ]
    return mq.Mechanism(
        "block",
        bodies,
        (plane,),
        parameters=(m, g, mu, alpha, b, h),
        gravity=INCLINED,
        switching=tuple(corners),
    )


def test_a_block_on_two_corners_is_told_where_it_stands_and_tips() -> None:
    """At th = 0, z = h/2: it slides as long as mu <= b/h, and tips otherwise."""
    only = [{"rear -1": "slips +", "front -1": "slips +"}]
    (slides,) = mq.derive_modes(make_box(-1), only=only).modes
    assert str(slides).splitlines()[1:] == [
        "  x'' = g (sin(alpha) - mu cos(alpha))",
        "  z'' = 0",
        "  th'' = 0",
        "  N_rear__1 = m g (b - mu h) cos(alpha)/(2 b)",
        "  T_rear__1 = m g mu (mu h - b) cos(alpha)/(2 b)",
        "  N_front__1 = m g (mu h + b) cos(alpha)/(2 b)",
        "  T_front__1 = -m g mu (mu h + b) cos(alpha)/(2 b)",
        "  at th = 0",
        "  at z = h/2",
        "  while m g (b - mu h) cos(alpha)/(2 b) ≥ 0",
        "  while x' > 0",
        "  while m g (mu h + b) cos(alpha)/(2 b) ≥ 0",
    ]


@pytest.mark.parametrize(
    ("touching", "place"),
    [
        (("rear -1", "front -1"), ["at th = 0", "at z = h/2"]),
        (("rear 1", "front 1"), ["at th = pi", "at z = h/2"]),
        (("rear 1", "rear -1"), ["at th = pi/2", "at z = b/2"]),
        (("front 1", "front -1"), ["at th = -pi/2", "at z = b/2"]),
    ],
)
def test_a_box_lies_on_the_side_that_touches(touching: tuple[str, str], place: list[str]) -> None:
    box = make_box(-1, 1, friction=0.0)
    states = {corner.name: "open" for corner in box.switching} | dict.fromkeys(touching, "closed")
    (mode,) = mq.derive_modes(box, only=[states]).modes
    assert [line for line in mode.conditions if line.startswith("at")] == place


def test_stribeck_s_friction_is_written_as_it_was_given() -> None:
    """As a fraction its exponential stood above and below the line, and overflowed."""
    v, mu_k, mu_s, v_s = mq.velocity("x"), 0.1, 0.25, 0.05
    falling = mu_k + (mu_s - mu_k) * mq.exp(-((v / v_s) ** 2))
    dry = mq.Friction("dry", "slide", falling, 9.81, mu_static=mu_s)
    slips = mq.derive_modes(replace(block(), switching=(dry,)))["slips +"]
    assert str(slips.accelerations["x''"]).count("exp(-400") == 1
    rate, level = sp.Symbol("x'"), {sp.Symbol("alpha"): 0.0, sp.Symbol("m"): 1.0}
    fast = float(slips.forces["R_dry"].subs(level).subs(rate, 5.0))
    assert fast == pytest.approx(-mu_k * 9.81, rel=1e-15)


def test_modes_of_a_mechanism_with_several_contacts_end() -> None:
    """A woodpecker with its sleeve's edge on the pole took minutes for each such mode."""
    bird = mq.textbook.load("woodpecker")
    names = [element.name for element in bird.switching]
    only = [dict(zip(names, ("open", "open", "slips +"), strict=True))]
    (mode,) = mq.derive_modes(bird, only=only).modes
    assert len(mode.unsolved) == 4
    assert not mode.accelerations


@pytest.mark.parametrize(("digits", "calls"), [(3, 1), (60, 0)])
def test_formulas_with_numbers_that_no_one_reads_are_not_simplified(
    digits: int, calls: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The modes of a hinge and two slides in decimals of 16 digits took more than a minute."""
    counted = list[Any]()

    def count(formula: Any) -> Any:
        counted.append(formula)
        return formula

    monkeypatch.setattr(import_module("sympy.simplify.fu"), "TR10i", count)
    x, k = sp.Symbol("x"), sp.Symbol("k")
    formula = (10**digits + 1) * sp.sin(x) ** 2 / (k * sp.cos(x) + 3) + k
    assert sp.expand(switching._shorten(formula) - formula).equals(0)
    assert len(counted) == calls


def test_numbers_of_hundreds_of_digits_do_not_overflow() -> None:
    x, k, large = sp.Symbol("x"), sp.Symbol("k"), sp.Integer(10) ** 400
    formula = ((large + 1) * sp.sin(x) ** 2 + large) / (3 * large * k * sp.cos(x) + large + 7)
    compute = sp.lambdify([x, k], switching._shorten(formula), "math")
    expected = (math.sin(0.3) ** 2 + 1) / (6 * math.cos(0.3) + 1)
    assert compute(0.3, 2.0) == pytest.approx(expected, rel=1e-14)
