"""Hand the cart-pole to a simulation tool as an FMU, and run it there (needs the extra fmpy)."""

from __future__ import annotations

import numpy as np

import mecanique as mq

try:
    from fmpy import simulate_fmu
except ImportError:
    raise SystemExit(
        "this example needs FMPy; install it with: pip install 'mecanique[fmpy]'"
    ) from None


def main() -> None:
    """Compare both kinds of simulation with `mq.simulate`, then with a pulling motor."""
    cart = mq.textbook.load("cart_pole")
    start = {"x": 0.0, "q": 2.5}
    code = mq.generate(mq.derive(cart), target="fmu", what="energy", q=start)
    print(code.verdict)
    path = str(code.write("model")[0])

    motion = mq.simulate(cart, q=start, duration=5.0)
    for kind in ("ModelExchange", "CoSimulation"):
        found = simulate_fmu(path, fmi_type=kind, stop_time=5.0, output_interval=0.05)
        off = np.abs(found["q"] - motion(found["time"]).q[:, 1]).max()
        print(f"{kind}: the angle differs from mq.simulate by at most {off:.0e} rad")

    pulled = simulate_fmu(path, stop_time=5.0, start_values={"tau_x'": 0.5, "m": 0.2})
    print(f"pulled with 0.5 N, the cart is at x = {pulled['x'][-1]:.2f} m after 5 s")


if __name__ == "__main__":
    main()
