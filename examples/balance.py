"""A controller in C: the cart-pole's equations as C, an optimal gain, and a loop that balances."""

from __future__ import annotations

import subprocess
from math import pi
from pathlib import Path

import numpy as np
from scipy.linalg import solve_continuous_are

import mecanique as mq

HERE = Path(__file__).parent


def main() -> None:
    cart = mq.textbook.load("cart_pole")
    code = mq.generate(mq.derive(cart), target="c", what=("rhs", "energy"))
    code.write("controller")
    print(code.verdict)

    upright = mq.linearize(cart, at={"x": 0.0, "q": pi})
    stiffness, damping = (np.linalg.solve(upright.M, part) for part in (upright.K, upright.C))
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-stiffness, -damping]])
    B = np.vstack([np.zeros((2, 1)), np.linalg.solve(upright.M, [[1.0], [0.0]])])
    gain = B.T @ solve_continuous_are(A, B, np.diag([10.0, 10.0, 1.0, 1.0]), np.eye(1))

    sources = ["controller/cart_pole.c", str(HERE / "balance.c")]
    command = ["cc", "-std=c99", "-O2", "-Icontroller", "-o", "controller/balance", *sources, "-lm"]
    subprocess.run(command, check=True)
    subprocess.run(["controller/balance", *map(str, gain[0])], check=True)


if __name__ == "__main__":
    main()
