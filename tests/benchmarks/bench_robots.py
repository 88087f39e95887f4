"""Read and verify public robots: what is read, what agrees, which flaws they have, in what time.

    python tests/benchmarks/bench_robots.py [FOLDER …] [--engines pinocchio,mujoco] [--samples 10]

Without folders it takes the robots of example-robot-data and every URDF file of the installed
packages among `PACKAGES`. Files from elsewhere (a clone of a public repository, say) are given by
their folder; their texts are not kept here. Sources and licenses: example-robot-data 6.0.0 (BSD-2
and the licenses of each robot, stated in its folder), pybullet (zlib), rtb-data (MIT), icub-models
(CC BY-SA 4.0), airo-models (MIT and those of each robot).
"""

from __future__ import annotations

import argparse
import hashlib
import sys
import time
from collections import Counter
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import mecanique as mq
from mecanique.verification.compare import compare
from mecanique.verification.originals.engines import read_by

PACKAGES = ("pybullet", "rtb-data", "icub-models", "airo-models")


def main() -> None:
    """Print a line for each file with moving joints, and the sums."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--engines", default="pinocchio")
    parser.add_argument("--samples", type=int, default=10)
    arguments = parser.parse_args()
    engines = arguments.engines.split(",")
    counts: Counter[str] = Counter()
    print(f"{'file':60} {'nv':>3}  {'seconds':>7}  result")
    for name, file in _files(arguments.folders):
        start = time.perf_counter()
        size, result = _judge(file, engines, arguments.samples, counts)
        if size:
            print(f"{name[-60:]:60} {size:>3}  {time.perf_counter() - start:7.2f}  {result}")
            sys.stdout.flush()
    print()
    for what, count in sorted(counts.items()):
        print(f"{count:5}  {what}")


def _judge(file: Path, engines: list[str], samples: int, counts: Counter[str]) -> tuple[str, str]:
    """Return the number of velocities, and what comes of a file; nothing if none of it moves."""
    try:
        mechanism = mq.read_urdf(file)
    except mq.MecaniqueError as error:
        counts["refused"] += 1
        return "-", f"refused: {str(error).replace(str(file), '')[:70]}"
    if not mechanism.nv:
        return "", ""
    counts["read"] += 1
    told = []
    flaws = mechanism.origin.flaws if mechanism.origin else ()
    if flaws:
        counts["with flaws"] += 1
        codes = Counter(flaw.code for flaw in flaws)
        told.append(", ".join(f"{code} ×{count}" for code, count in sorted(codes.items())))
    try:
        verdict = compare(mechanism, samples, 0, quick=True)
        agrees = "agrees" if verdict.agrees else "DISAGREES"
        told.insert(0, f"{agrees} {verdict.worst:.0e}")
    except mq.MecaniqueError as error:
        agrees = "not compared"
        told.insert(0, f"not compared: {str(error)[:60]}")
    counts[agrees] += 1
    for reading in read_by(mechanism, engines, 0):
        title = reading.engine.split()[0]
        if reading.refused:
            counts[f"{title} refuses the file"] += 1
            told.append(f"{title} refuses")
        elif reading.differs:
            counts[f"{title} reads it otherwise"] += 1
            told.append(f"{title} reads it otherwise ({reading.worst:.1g})")
    return str(mechanism.nv), "; ".join(told)


def _files(folders: list[Path]) -> Iterator[tuple[str, Path]]:
    """Yield name and path of every file, equal texts once."""
    found: list[tuple[str, Path]] = []
    for folder in folders:
        found += [(str(f.relative_to(folder)), f) for f in sorted(folder.rglob("*.urdf"))]
    if not folders:
        found += [(name, mq.robot(name)) for name in mq.robots()]
        for package in PACKAGES:
            try:
                files = distribution(package).files or []
            except PackageNotFoundError:
                continue
            paths = [(str(f), Path(str(f.locate()))) for f in files if f.suffix == ".urdf"]
            found += [(name, path) for name, path in paths if path.is_file()]
    seen: set[str] = set()
    for name, file in found:
        digest = hashlib.sha256(file.read_bytes()).hexdigest()
        if digest not in seen:
            seen.add(digest)
            yield name, file


if __name__ == "__main__":
    main()
