"""Forty faults of reading, ten of each source: whom the engines' jury blames.

Of robots whose roots are fixed, and once more of those that float.

Run by hand with the extra `engines`: python tests/benchmarks/bench_jury.py
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import get_args

sys.path.insert(0, str(Path(__file__).parents[1] / "verification"))

from reading_faults import FAULTS, PACKAGES, Root, blame

from mecanique.verification.verdict import OURS


def main() -> None:
    """Print a table of faults, and whom the jury blames."""
    for root in get_args(Root):
        print(f"\nroot: {root}")
        _try_all(root)


def _try_all(root: Root) -> None:
    engines = [name for name in PACKAGES if name != "exudyn"]
    sources = (OURS, *engines)
    right = 0
    print(f"{'fault':22} {'robot':16} {'read wrongly by':16} blamed")
    for k, fault in enumerate(FAULTS):
        for m, culprit in enumerate(sources):
            jury = [*engines, "exudyn"]
            robot, blamed, readings = blame(culprit, k + m, fault, jury, 40 * k + m, root)
            right += blamed == (culprit,)
            told = ", ".join(blamed) or "nobody"
            if blamed != (culprit,):
                told += "  (" + "; ".join(r.said or f"{r.engine} agrees" for r in readings) + ")"
            print(f"{fault:22} {robot:16} {culprit:16} {told}")
    print(f"{right} of {len(FAULTS) * len(sources)} blamed on the right one")


if __name__ == "__main__":
    main()
