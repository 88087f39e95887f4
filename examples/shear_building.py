"""A five-storey building: its frequencies, its shapes, and its roof in an earthquake."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import mecanique as mq


def earthquake(seconds: float = 4.0, step: float = 0.02) -> mq.Record:
    """Return a synthetic record of ground acceleration, noise that swells and dies away [m/s²]."""
    t = np.arange(0.0, seconds + step, step)
    noise = np.convolve(
        np.random.default_rng(1940).normal(size=t.size), np.ones(5) / 5, mode="same"
    )
    return mq.Record(t, 4.0 * noise * (t / 2) ** 2 * np.exp(2 - t))


def main() -> None:
    building = mq.textbook.load("shear_building", c=2e4)
    modes = mq.linearize(building)
    for frequency, damping in zip(modes.frequencies, modes.damping, strict=True):
        print(f"f = {frequency / (2 * np.pi):5.2f} Hz, damping {100 * damping:4.1f} %")
    record = earthquake()
    shaken = replace(
        building, inputs=tuple(replace(each, signal=record) for each in building.inputs)
    )
    motion = mq.simulate(shaken, duration=4.0, rtol=1e-6)
    roof = motion["u5"]
    print(
        f"ground shakes with {abs(record.values).max():.2f} m/s², the roof goes "
        f"{1000 * abs(roof).max():.0f} mm"
    )
    assert motion.audit().ok


if __name__ == "__main__":
    main()
