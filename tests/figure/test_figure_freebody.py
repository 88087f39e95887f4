"""Bodies cut free, in letters: components along axes, and no label over another or over a line."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from systems import derive_system

from mecanique import textbook
from mecanique.figure.freebody import acting, cut_free, fit_body
from mecanique.figure.paper.lettering import frame, lines_of, measure_crossings, overlap
from mecanique.figure.paper.marks import Mark, Stroke, Words
from mecanique.figure.setting import Setting, posture, setting
from mecanique.reference import Reference


@cache
def seen(name: str, speed: float = 0.0) -> Setting:
    mechanism = textbook.load(name)
    q = posture(mechanism, textbook.entry(name).start)
    reference = Reference(mechanism)
    v = np.full(mechanism.nv, speed)
    if mechanism.constrained:
        v = np.zeros(mechanism.nv)
    return setting(mechanism, reference, q, v, 0.3)


def texts(marks: Sequence[Mark]) -> list[str]:
    words = [mark for mark in marks if isinstance(mark, Words)]
    return ["".join(text for text, _ in word.parts) for word in words]


def worst_overlap(marks: Sequence[Mark]) -> float:
    frames = np.array([frame(mark) for mark in marks if isinstance(mark, Words)]).reshape(-1, 4)
    own = np.prod(frames[:, 2:] - frames[:, :2], axis=1)
    return float((overlap(frames, frames) - own).max(initial=0.0))


@pytest.mark.parametrize("numbers", [False, True])
@pytest.mark.parametrize("name", textbook.names())
def test_no_label_lies_over_another_or_over_a_line(name: str, numbers: bool) -> None:
    where = seen(name, 0.7)
    for body in where.mechanism.bodies:
        if body.name == where.mechanism.ground:
            continue
        marks = cut_free(where, body.name, numbers=numbers, resultants=numbers)
        assert worst_overlap(marks) == 0, (body.name, texts(marks))
        boxes = np.array([frame(mark) for mark in marks if isinstance(mark, Words)]).reshape(-1, 4)
        lines, _ = lines_of(marks)
        under = measure_crossings(boxes, lines, np.ones(len(lines)))
        assert under.max(initial=0.0) < 3.0, (body.name, texts(marks)[int(np.argmax(under))])


def arrows(marks: Sequence[Mark], style: str) -> list[np.ndarray]:
    """Directions of straight arrows, by their heads."""
    heads = [m.points for m in marks if isinstance(m, Stroke) and m.style == f"{style}-tip"]
    return [head[0] - (head[1] + head[2]) / 2 for head in heads]


def directions(marks: Sequence[Mark], style: str) -> list[np.ndarray]:
    return [way / np.hypot(*way) for way in arrows(marks, style)]


def has(ways: Sequence[np.ndarray], expected: Sequence[float] | np.ndarray) -> bool:
    return any(np.allclose(way, expected, rtol=0, atol=1e-6) for way in ways)


def test_inertia_forces_and_weights_name_the_mass_of_their_body() -> None:
    assert "2\u2009m\u2009aDEF,x" in texts(cut_free(seen("bars_and_springs"), "DEF"))
    said = texts(cut_free(seen("compound_pendulum", 0.7), "pendulum"))
    assert "(m1+m2)\u2009g" in said
    assert "(m1+m2)\u2009at" in said


def test_a_line_leads_to_a_joint_off_the_body() -> None:
    """The bead's slide has its origin in the center of the hoop."""
    dashed = [
        mark
        for mark in cut_free(seen("bead_on_hoop"), "bead")
        if isinstance(mark, Stroke) and mark.style == "dashed"
    ]
    assert dashed
    assert not any(
        isinstance(mark, Stroke) and mark.style == "dashed"
        for mark in cut_free(seen("slider_crank"), "slider")
    )


def test_a_rod_pulls_each_body_at_its_own_end() -> None:
    """The links of the governor have no mass: the force on an arm acts at its ball."""
    where = seen("governor")
    forces = [each for each in acting(where) if each.name == "link1"]
    assert {each.body for each in forces} == {"arm1", "sleeve"}
    for each in forces:
        (loop,) = (loop for loop in where.mechanism.loops if loop.name == "link1")
        frame = loop.frame_a if each.body == loop.body_a else loop.frame_b
        np.testing.assert_allclose(
            each.origin[0], where.point(each.body, frame.xyz), rtol=0, atol=1e-14
        )


def test_a_pendulum_has_its_components_along_and_across() -> None:
    """R_n towards the pin, R_t where the angle grows; -m a_n and -m a_t dashed, against n and t."""
    where = seen("rigid_bar_pendulum", 1.0)
    marks = cut_free(where, "rod")
    said = texts(marks)
    for letter in ("Rpin,n", "Rpin,t", "m\u2009g", "m\u2009an", "m\u2009at", "n", "t", "l", "q"):
        assert letter in said, letter
    (q,) = where.q
    n, t = np.array([np.sin(q), np.cos(q)]), np.array([np.cos(q), -np.sin(q)])
    forces = directions(marks, "force")
    assert has(forces, -n)
    assert has(forces, t)
    assert has(forces, [0.0, 1.0])
    inertia = directions(marks, "inertia")
    assert has(inertia, -n)
    assert has(inertia, -t)


def test_forces_on_what_rolls_are_along_the_axes_of_its_equations() -> None:
    """m a_x points up the incline, against x of its slide; the world's axes were drawn."""
    where = seen("rolling_disk")
    marks = cut_free(where, "disk")
    alpha = where.mechanism.values["alpha"]
    uphill = [-np.cos(alpha), -np.sin(alpha)]  # on paper y points down
    assert has(directions(marks, "inertia"), uphill)
    assert {"m\u2009ax", "x", "z"} <= {*texts(marks)}
    # alpha is the slope, so that the angular acceleration needs another letter
    assert "I\u2009ε" in texts(marks)
    assert "I\u2009α" not in texts(marks)


@pytest.mark.parametrize(
    ("name", "body", "counted"),
    [
        ("rigid_bar_pendulum", "rod", 1),
        ("rolling_disk", "disk", -1),
        ("double_pendulum", "rod1", 1),
    ],
)
def test_couples_of_inertia_turn_against_the_sense_of_moments(
    name: str, body: str, counted: int
) -> None:
    """As forces of inertia point against the axes, their letters have no sign."""
    marks = cut_free(seen(name), body)
    assert not [said for said in texts(marks) if said.startswith(("-", "−"))]
    bent = [m.points for m in marks if isinstance(m, Stroke) and m.style == "inertia"]
    (couple,) = (line for line in bent if len(line) > 2)
    before, after, *_ = np.diff(couple, axis=0)
    # on paper y points down
    assert np.sign(before[1] * after[0] - before[0] * after[1]) == -counted


def test_a_small_body_is_drawn_large_enough_for_its_forces() -> None:
    """The crank of a slider crank is a fifth of its mechanism's width."""
    for name, body in (("slider_crank", "crank"), ("rigid_bar_pendulum", "rod")):
        where = fit_body(seen(name), body)
        corners = np.concatenate([x.corners for x in where.solids if x.body == body])
        wide, high = np.ptp(where.camera.at(corners), axis=0)
        assert max(wide / 200, high / 120) == pytest.approx(1, rel=1e-9)


def test_a_reaction_on_the_parent_is_drawn_against_that_on_the_child() -> None:
    where = seen("double_pendulum", 0.4)
    first, second = (directions(cut_free(where, name), "force") for name in ("rod1", "rod2"))
    for way in ([1.0, 0.0], [0.0, -1.0]):  # x and up, at pin1 and, on rod2, at pin2
        assert has(first, way)
        assert has(second, way)
    assert has(first, [-1.0, 0.0])  # R_pin2 on rod1
    assert not has(second, [-1.0, 0.0])


@pytest.mark.parametrize(
    ("name", "body", "letters"),
    [
        ("cart_pole", "cart", {"F", "Fdamping", "Rpin,x", "Rpin,z", "M\u2009ax"}),
        ("double_pendulum", "rod1", {"Rpin1,x", "Rpin1,z", "Rpin2,x", "Rpin2,z", "m1\u2009ax"}),
        ("slider_crank", "rod", {"RA,x", "RA,z", "λB,x", "λB,z"}),
        ("two_blocks", "block2", {"F", "Fspring2", "Rslide2,z"}),
    ],
)
def test_what_is_zero_at_rest_has_its_letter(name: str, body: str, letters: set[str]) -> None:
    where = seen(name)
    upright = where if name == "slider_crank" else replace(where, q=np.zeros(where.q.shape))
    drawn = texts(cut_free(upright, body))
    assert letters <= set(drawn)
    numbered = texts(cut_free(upright, body, numbers=True))
    assert not any(text.startswith("Ddamping") for text in numbered)
    moving = texts(cut_free(seen(name, 0.7), body)) if name != "slider_crank" else drawn
    assert set(moving) - set(drawn) <= {"q1", "q"}  # and no letter of a force that cannot act


def test_what_cannot_act_is_not_drawn() -> None:
    """A rod without mass carries forces at its ends, none of its own."""
    assert not any("a" in text for text in texts(cut_free(seen("slider_crank"), "rod")))
    assert "RB,x" not in texts(cut_free(seen("two_blocks"), "block1"))


def test_the_force_of_a_loop_has_the_letter_of_the_equations() -> None:
    where = seen("slider_crank")
    assert {"λB,x", "λB,z"} <= set(texts(cut_free(where, "slider")))


def test_resultants_and_numbers_come_on_request() -> None:
    where = seen("rigid_bar_pendulum", 1.0)
    whole = texts(cut_free(where, "rod", resultants=True))
    assert "Rpin" in whole
    assert "Rpin,n" not in whole
    assert not any("=" in text for text in whole)
    numbered = texts(cut_free(where, "rod", numbers=True))
    assert any(text.startswith("Rpin,n = ") and text.endswith(" N") for text in numbered)


def test_a_load_has_the_letter_it_is_stated_by() -> None:
    assert "F" in texts(cut_free(seen("two_blocks"), "block2"))


def test_forces_of_elements_point_in_the_sense_of_the_equations() -> None:
    """R_F_z counts along z of the world, y of the frame that F has in CF, on DEF; on CF against."""
    where = seen("bars_and_springs")
    pin = where.mechanism.elements[0]
    along = where.frame(pin.body_a, pin.frame_a)[:3, 1]
    z = where.camera.at(along) / where.camera.scale
    for body, sense in (("DEF", 1.0), ("CF", -1.0)):
        marks = cut_free(where, body)
        assert "RF,z" in texts(marks)
        assert "RF,y" not in texts(marks)
        equations = derive_system("bars_and_springs", "newton_euler").text(steps=True)
        (balance,) = re.findall(rf"Cut free, {body} is .*?(?=\n\n)", equations, re.DOTALL)
        upward = next(line for line in balance.splitlines() if "R_F_z" in line and " = " in line)
        before = upward[: upward.index("R_F_z")].rstrip()
        # on paper y points down
        assert (-1.0 if before.endswith("-") else 1.0) == -sense * float(np.sign(z[1]))
        place = fit_body(where, body).at("DEF", pin.frame_b.xyz)
        heads = arrows_at(marks, place)
        assert any(float(head @ z) * sense > 0.99 for head in heads)


def arrows_at(marks: Sequence[Mark], place: np.ndarray) -> list[np.ndarray]:
    """Unit directions of arrows that start at a place, or beside it."""
    lines = [m.points for m in marks if isinstance(m, Stroke) and m.style == "force"]
    near = [line for line in lines if len(line) == 2 and np.hypot(*(line[0] - place)) < 16.0]
    return [(b - a) / np.hypot(*(b - a)) for a, b in near]


def test_arrows_along_one_line_stand_beside_each_other() -> None:
    """On the cart, its weight and the force of the pole's pin would lie on one another."""
    marks = cut_free(seen("cart_pole"), "cart")
    lines = [m.points for m in marks if isinstance(m, Stroke) and m.style == "force"]
    down = [line for line in lines if len(line) == 2 and line[1, 1] - line[0, 1] > 20.0]
    first, second = down
    assert abs(first[0, 0] - second[0, 0]) > 10.0


def test_moments_about_one_point_have_arcs_of_their_own() -> None:
    """The axes of a gyroscope meet, so that the moments of two hinges act at one point."""
    marks = cut_free(seen("gyroscope"), "inner")
    arcs = [m.points for m in marks if isinstance(m, Stroke) and m.style == "force"]
    radii = {round(float(np.ptp(line[:, 1]))) for line in arcs if len(line) > 20}
    assert len(radii) == 2
    places = [mark.at for mark in marks if isinstance(mark, Words)]
    letters = dict(zip(texts(marks), places, strict=True))
    assert np.hypot(*(letters["Mθ"] - letters["Mψ"])) > 12.0
