"""The force in a pendulum's pin: m g (5 cos q − 3 cos q0)/2 along it, m g sin(q)/4 across."""

from __future__ import annotations

import numpy as np

import mecanique as mq


def main() -> None:
    mechanism = mq.textbook.load("rigid_bar_pendulum")
    start = 2.0
    motion = mq.simulate(mechanism, q={"q": start}, duration=3.0)
    weight = mechanism.values["m"] * mechanism.values["g"]
    for t, q in list(zip(motion.t, motion["q"], strict=True))[::30]:
        force = mq.Reference(mechanism).reactions({"q": q}, {"q": motion(t).v[0]})["pin"].force
        along = force @ [-np.sin(q), 0, np.cos(q)]
        across = force @ [np.cos(q), 0, np.sin(q)]
        assert abs(along - weight * (5 * np.cos(q) - 3 * np.cos(start)) / 2) < 1e-7
        assert abs(across - weight * np.sin(q) / 4) < 1e-12
        print(
            f"t = {t:.2f} s  q = {q:+.3f}  along the rod {along:+8.3f} N  across {across:+8.3f} N"
        )


if __name__ == "__main__":
    main()
