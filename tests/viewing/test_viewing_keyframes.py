"""Packed key frames give back what went in, to the tolerance they promise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from viewing_scenes import pendulum, swarm

import mecanique as mq
from mecanique.errors import InputError
from mecanique.viewing.page.page import Packed, pack, resample, varints
from mecanique.viewing.scene.scene import Arrow, Scene
from mecanique.viewing.show import scene


def integers(data: bytes) -> list[int]:
    """Variable-length integers, read one byte after another."""
    found, value, shift = [], 0, 0
    for byte in data:
        value |= (byte & 0x7F) << shift
        shift += 7
        if byte < 0x80:
            found.append((value >> 1) ^ -(value & 1))
            value, shift = 0, 0
    return found


def table(packed: Packed) -> NDArray[np.float64]:
    """The columns as the page sums them back; those that are not written hold their first value."""
    header, n = packed.header, packed.header["n"]
    numbers = iter(integers(packed.body))
    columns = []
    for order, step, start in zip(header["orders"], header["steps"], header["start"], strict=True):
        if order < 0:
            columns.append(np.full(n, start))
            continue
        column = np.array([next(numbers) for _ in range(n)], dtype=np.float64)
        for _ in range(order):
            column = np.cumsum(column)
        columns.append(column * step)
    assert next(numbers, None) is None
    return np.stack(columns, axis=1)


@settings(deadline=None)
@given(st.lists(st.integers(-(2**33), 2**33 - 1), max_size=40))
def test_integers_come_back(whole: list[int]) -> None:
    assert integers(varints(np.array(whole, dtype=np.int64))) == whole


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**31))
def test_columns_come_back_to_half_a_step(seed: int) -> None:
    rng = np.random.default_rng(seed)
    scene = swarm(2, 1.0)
    jumps = replace(scene, positions=scene.positions + rng.normal(size=scene.positions.shape))
    found = table(pack(jumps))
    assert np.abs(found[:, :3] - jumps.positions[:, 0]).max() < 1e-4
    assert np.abs(found[:, 3:7] - jumps.quaternions[:, 0]).max() < 2.6e-5


def test_a_tiny_mechanism_keeps_its_shape() -> None:
    scene = swarm(3, 1.0)
    tiny = replace(scene, positions=1e-4 * scene.positions, arrows=(), traces=())
    found = table(pack(tiny))
    assert np.abs(found[:, 7:10] - tiny.positions[:, 1]).max() < 1e-4 * np.ptp(tiny.positions)


def test_points_that_ride_on_a_body_are_not_written() -> None:
    scene = pendulum()
    packed = pack(scene)
    first = 7 * len(scene.bodies)
    assert {column for column, *_ in packed.header["anchors"]} == {
        first,
        first + 12,
        first + 18,
        first + 24,
    }
    column, body, *local = packed.header["anchors"][0]
    assert (column, body) == (first, 1)
    assert local == pytest.approx([0, 0, -0.5], abs=1e-9)


def test_a_point_that_slides_is_written() -> None:
    scene = pendulum()
    slide = scene.arrows[0].origin + 0.01 * scene.t[:, None]
    moved = replace(
        scene, arrows=(Arrow("slides", "load", "bar", slide, scene.arrows[0].vector),), traces=()
    )
    packed = pack(moved)
    assert packed.header["anchors"] == []
    assert np.abs(table(packed)[:, 14:17] - slide).max() < 1e-4


@pytest.mark.parametrize(
    ("times", "expected"),
    [
        (np.linspace(0, 1, 61), 61),
        (np.linspace(0, 1, 31), 31),
        (np.linspace(0, 1, 1001), 61),
        (np.array([0.0, 0.1, 1.0]), 61),
        (np.linspace(0, 3600, 100_001), 7200),
        (np.linspace(0, 0.03, 1001), 241),
        (np.linspace(0, 0.03, 7), 7),
        (np.array([2.0]), 1),
    ],
)
def test_times_are_even_and_not_too_many(times: NDArray[np.float64], expected: int) -> None:
    found = resample(times)
    assert len(found) == expected
    assert (found[0], found[-1]) == (times[0], times[-1])
    assert np.ptp(np.diff(found)) < 1e-9 if len(found) > 1 else True


def test_a_page_asks_for_the_instants_that_it_plays() -> None:
    """Not for the forces at every sample; and between few samples it follows the motion."""
    mechanism = mq.textbook.load("simple_pendulum")
    for samples in (1001, [0.0, 0.1, 1.0]):
        motion = mq.simulate(mechanism, q={"q": 1.0}, duration=1.0, samples=samples)
        shown = scene(motion)
        assert len(shown.t) == 61
        places = motion.poses(shown.t)[..., :3, 3]
        np.testing.assert_allclose(shown.positions, places, rtol=0, atol=1e-12)
        assert shown.arrows[0].vector.shape == (61, 3)


def test_a_page_has_frames_enough_for_what_is_short_or_spins() -> None:
    mechanism = mq.textbook.load("simple_pendulum")
    short = scene(mq.simulate(mechanism, v={"q": 100.0}, duration=0.05))
    fast = scene(mq.simulate(mechanism, v={"q": 100.0}, duration=1.0))
    assert pack(short).header["n"] == len(short.t) == 241
    assert pack(fast).header["n"] == len(fast.t) == 200  # 100 rad, half a radian each


def test_uneven_times_are_followed() -> None:
    scene = pendulum(duration=2.0, fps=500)
    keep = np.sort(np.random.default_rng(0).choice(len(scene.t) - 2, 600, replace=False) + 1)
    keep = np.concatenate([[0], keep, [len(scene.t) - 1]])
    sparse = Scene(
        title="uneven",
        t=scene.t[keep],
        bodies=scene.bodies,
        positions=scene.positions[keep],
        quaternions=scene.quaternions[keep],
    )
    packed = pack(sparse)
    exact = pendulum(duration=2.0, fps=60)
    assert np.abs(table(packed)[:, 10:14] - exact.quaternions[:, 1]).max() < 1e-3


def test_a_scene_says_what_is_wrong_with_it() -> None:
    scene = pendulum(duration=0.1)
    with pytest.raises(InputError, match=r"strictly increasing"):
        replace(scene, t=scene.t[::-1])
    with pytest.raises(
        InputError, match=r"positions of a scene: expected shape \(7, 2, 3\), got \(2, 3\)"
    ):
        replace(scene, positions=np.zeros((2, 3)))
    with pytest.raises(InputError, match=r"unit length"):
        replace(scene, quaternions=2 * scene.quaternions)
    with pytest.raises(InputError, match=r"'weight' sits on 'bar', which is no body"):
        replace(scene, bodies=(scene.bodies[0], replace(scene.bodies[1], name="rod")))
    with pytest.raises(InputError, match=r"two of the scene's body names are equal"):
        replace(scene, bodies=(scene.bodies[0], scene.bodies[0]), arrows=(), joints=())
    bad = replace(scene.arrows[0], vector=np.full((7, 3), np.nan))
    with pytest.raises(InputError, match=r"vector of arrow 'weight': expected finite numbers"):
        replace(scene, arrows=(bad,))


def test_quaternions_are_made_continuous() -> None:
    scene = pendulum(duration=1.0)
    signs = np.where(np.arange(len(scene.t)) % 3 == 0, -1.0, 1.0)
    flipped = replace(scene, quaternions=scene.quaternions * signs[:, None, None])
    assert np.abs(np.diff(flipped.quaternions, axis=0)).max() < 0.1
