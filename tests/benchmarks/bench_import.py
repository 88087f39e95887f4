"""Measure what starting costs: `import mecanique`, its model, and `--help`.

Run it by hand: python tests/benchmarks/bench_import.py
"""

from __future__ import annotations

import resource
import subprocess
import sys

ROUNDS = 7


def best(*command: str) -> float:
    """Return the least processor time of a command over some rounds [s]."""
    times = []
    for _ in range(ROUNDS):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, *command], check=True, capture_output=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        times.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return min(times)


def main() -> None:
    """Print the figures and their limits."""
    bare = best("-c", "pass")
    numpy = best("-c", "import numpy")
    beside = best("-c", "import numpy, mecanique")
    model = best("-c", "import numpy, mecanique; mecanique.Mechanism")
    told = best("-m", "mecanique", "--help")
    print(f"python alone               {bare:.3f} s of processor time")
    print(f"import numpy               {numpy - bare:.3f} s beyond python")
    print(f"import mecanique           {beside - numpy:.3f} s beyond numpy (limit 0.03 s)")
    print(f"mecanique.Mechanism        {model - beside:.3f} s more, on first use")
    print(f"mecanique --help           {told:.3f} s in all (limit 0.2 s)")


if __name__ == "__main__":
    main()
