"""Coordinates are typed by their names, or by the letters that documents and figures print."""

from dataclasses import replace

import numpy as np
import pytest

import mecanique as mq
from mecanique.model.mechanism.letters import is_varied, letters_of_words

COIN = mq.textbook.load("rolling_coin")


def test_positions_and_velocities_are_given_by_printed_letters() -> None:
    by_letter = {"α": 1.0, "theta": 0.2, "φ": 3.0}
    by_name = {"yaw": 1.0, "lean": 0.2, "spin": 3.0}
    np.testing.assert_array_equal(COIN.position(by_letter), COIN.position(by_name))
    rates = {f"{letter}'": rate for letter, rate in by_letter.items()}
    np.testing.assert_array_equal(COIN.velocity(rates), COIN.velocity(by_name))
    links = mq.textbook.load("n_link_pendulum")
    assert links.position({"q₂": 1.0}).tolist() == [0.0, 1.0, 0.0, 0.0]
    with pytest.raises(mq.InputError, match="expected each coordinate once, got α, yaw"):
        COIN.position({"α": 1.0, "yaw": 1.0})
    # where anything rolls, ψ is a condition on velocities
    with pytest.raises(mq.UnknownNameError, match="unknown coordinate 'ψ'; known: x, y, z, yaw"):
        COIN.position({"ψ": 1.0})


def test_equations_are_reduced_to_coordinates_by_printed_letters() -> None:
    assert mq.derive(COIN).solved(["α", "θ'", "spin"]).independent == ("yaw", "lean", "spin")
    linkage = mq.textbook.load("four_bar_linkage")
    assert mq.reduce_loops(linkage, "ψ").text() == mq.reduce_loops(linkage, "psi").text()
    absolute = linkage.with_absolute_angles({"θ": "chi"})
    assert absolute == linkage.with_absolute_angles({"theta": "chi"})
    with pytest.raises(mq.UnknownNameError, match="unknown coordinate 'β'; known: x"):
        mq.derive(COIN).solved("β")


def test_a_motion_is_read_by_printed_letters() -> None:
    motion = mq.simulate(COIN, q={"θ": 0.1}, v={"φ": 3.0}, duration=0.05)
    for marks in ("", "'", "''"):
        np.testing.assert_array_equal(motion[f"φ{marks}"], motion[f"spin{marks}"])
    runs = mq.simulate_many(COIN, q={"θ": np.array([0.1, 0.2])}, v={"φ": 3.0}, duration=0.05)
    np.testing.assert_array_equal(runs["θ"], runs["lean"])


def test_a_ride_is_expanded_by_printed_letters() -> None:
    bicycle = mq.textbook.load("whipple_bicycle")
    at, v = {"z": 0.3}, {"x": 1.0}
    by_letter = mq.expand_in_speed(bicycle, at, v, ("φ", "δ"))
    by_name = mq.expand_in_speed(bicycle, at, v, ("roll", "steer"))
    np.testing.assert_array_equal(by_letter.K, by_name.K)


def test_a_variation_is_that_of_a_name() -> None:
    assert all(map(is_varied, ("δq", "δW", "δθ_2")))
    assert not any(map(is_varied, ("δ", "δ1", "δ'", "q", "qδ")))


def test_angles_that_are_given_have_letters_and_lengths_have_none() -> None:
    pendulum = mq.textbook.load("simple_pendulum")
    given = mq.Parameter("lean", 0.3, "rad"), mq.Parameter("yaw", 0.5, "m")
    letters = letters_of_words(replace(pendulum, parameters=(*pendulum.parameters, *given)))
    assert letters["lean"] == "theta"
    assert "yaw" not in letters
