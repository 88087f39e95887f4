"""A page for a class: figure, free-body diagram, and motion, equations and verdict offline."""

from __future__ import annotations

import mecanique as mq


def main() -> None:
    motion = mq.simulate(mq.textbook.load("cart_pole"), q={"q": 1.0}, duration=3.0)
    mq.picture(motion, path="cart_pole.svg")
    mq.picture(motion, 0.5, "cart.svg", free_body="cart")
    page = mq.export(motion, "cart_pole.html")
    print(f"{page}: {page.stat().st_size / 1e6:.2f} MB; open it in a browser, no network needed")


if __name__ == "__main__":
    main()
