"""The page of a motion shows the forces of contacts where they act, and none that is not known."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from rolling_samples import sleigh

from mecanique import Motion, Reference, export, simulate
from mecanique.model.constraints.contacts import Rolling
from mecanique.textbook import entry, load
from mecanique.viewing.scene.from_motion import fit, names_of, scene_of


@cache
def motion_of(name: str) -> Motion:
    system = entry(name)
    v = {key.removesuffix("'"): value for key, value in system.start_velocity.items()}
    return simulate(load(name), q=dict(system.start), v=v, duration=0.5, samples=6)


@pytest.mark.parametrize("name", ["whipple_bicycle", "rolling_disk", "rolling_coin"])
def test_a_contact_pushes_at_the_point_where_it_touches_without_a_couple(name: str) -> None:
    """That point is on the plane, and on the rim."""
    mechanism, complete = load(name), scene_of(motion_of(name))
    scene = fit(complete, names_of(complete))
    arrows = {arrow.name: arrow for arrow in scene.arrows}
    places = {body.name: k for k, body in enumerate(scene.bodies)}
    for contact in mechanism.contacts:
        assert isinstance(contact, Rolling)
        arrow = arrows[f"{contact.name} on {contact.body}"]
        assert f"{contact.name} on {contact.body} moment" not in arrows
        normal = np.array([mechanism.evaluate(row[2]) for row in contact.plane.rotation])
        start = np.array(mechanism.evaluate_all(contact.plane.xyz))
        np.testing.assert_allclose((arrow.origin - start) @ normal, 0.0, rtol=0, atol=1e-13)
        hub = scene.positions[:, places[contact.body]]
        spoke = np.linalg.norm(arrow.origin - hub, axis=1)
        np.testing.assert_allclose(spoke, mechanism.evaluate(contact.radius), rtol=0, atol=1e-14)


@pytest.mark.parametrize("name", ["whipple_bicycle", "rolling_disk", "rolling_coin"])
def test_the_forces_that_are_shown_balance(name: str) -> None:
    scene = scene_of(motion_of(name))
    largest = max(float(np.abs(arrow.vector).max()) for arrow in scene.arrows)
    for body in scene.bodies:
        force, moment = np.zeros((2, len(scene.t), 3))
        for arrow in scene.arrows:
            if arrow.body == body.name and arrow.unit == "N":
                force += arrow.vector
                moment += np.cross(arrow.origin, arrow.vector)
            elif arrow.body == body.name:
                moment += arrow.vector
        np.testing.assert_allclose(force, 0.0, rtol=0, atol=1e-13 * largest)
        np.testing.assert_allclose(moment, 0.0, rtol=0, atol=1e-13 * largest)


def test_the_point_of_contact_is_the_one_about_which_there_is_no_moment() -> None:
    """The reaction of a wheel is reported at its hub; moved to the point, it is a force alone."""
    motion = motion_of("whipple_bicycle")
    q, v, t = motion.q[-1], motion.v[-1], motion.t[-1]
    at_hub = motion.reference.reactions(q, v, t)["rear_contact"]
    place = motion.reference.contact_points(q, t)["rear_contact"]
    assert np.abs(at_hub.moment).max() > 1e-3
    np.testing.assert_allclose(at_hub.about(place).moment, 0.0, rtol=0, atol=1e-14)
    assert Reference(load("simple_pendulum")).contact_points([0.3]) == {}


def test_reactions_are_undetermined_and_said_to_be(tmp_path: Path) -> None:
    mechanism = sleigh(by_element=False)
    motion = simulate(mechanism, v={"x": 1.0, "theta": 1.0}, duration=0.5)
    page = export(motion, tmp_path / "page.html").read_text(encoding="utf-8")
    assert "does not say by which force it acts" in page
