"""Measure what starting costs: `import mecanique` beyond NumPy's own import, and `--help`.

Run it by hand: python tests/benchmarks/bench_import.py
"""

from __future__ import annotations

import subprocess
import sys
import time

ROUNDS = 7


def best(*command: str) -> float:
    """Shortest wall time of a command over some rounds [s]."""
    times = []
    for _ in range(ROUNDS):
        started = time.perf_counter()
        subprocess.run([sys.executable, *command], check=True, capture_output=True)
        times.append(time.perf_counter() - started)
    return min(times)


def main() -> None:
    """Print the figures and their limits."""
    bare = best("-c", "pass")
    numpy = best("-c", "import numpy")
    whole = best("-c", "import mecanique")
    print(f"python alone                {bare:.3f} s")
    print(f"import numpy                {numpy - bare:.3f} s on top of python")
    print(f"import mecanique            {whole - numpy:.3f} s on top of numpy (limit 0.15 s)")
    print(
        f"mecanique --help            {best('-m', 'mecanique', '--help'):.3f} s in all "
        f"(limit 0.5 s)"
    )


if __name__ == "__main__":
    main()
