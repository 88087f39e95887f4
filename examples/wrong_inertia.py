"""A file with a mistake in it, compared with measured samples: the verdict names the mistake."""

import csv
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import mecanique as mq


def pendulum(inertia: float) -> mq.Mechanism:
    """A rod of 2 kg and 1.2 m on a hinge, with a moment of inertia about its center."""
    rod = mq.Shape(2.0, (0, 0, -0.6), (inertia, inertia, 0, 0, 0, 0))
    hinge = mq.Revolute("hinge", "ground", "rod", axis=(0, -1, 0), coordinate="q")
    return mq.Mechanism(
        "rod", (mq.Body("ground"), mq.Body("rod", rod)), (hinge,), gravity=(0, 0, -9.81)
    )


def main() -> None:
    """Write samples of the true rod, and verify the wrong one against them."""
    true, wrong = pendulum(2.0 * 1.2**2 / 12), pendulum(2.0 * 1.2**2 / 3)
    q, v, a = np.random.default_rng(0).normal(size=(3, 40, 1))
    tau = mq.derive(true).inverse_dynamics(q, v, a)
    with TemporaryDirectory() as folder:
        path = Path(folder, "samples.csv")
        with path.open("w", encoding="utf-8", newline="") as stream:
            csv.writer(stream).writerows(
                [["q", "q'", "q''", "tau_q"], *np.hstack([q, v, a, tau]).tolist()]
            )
        print(mq.verify(true, against=path))
        print(mq.verify(wrong, against=path))


if __name__ == "__main__":
    main()
