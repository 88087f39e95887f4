"""Read and verify public robots: what is read, what agrees, which flaws they have, in what time.

    python tests/benchmarks/bench_robots.py [FOLDER …] [--engines pinocchio,mujoco] [--samples 10]
        [--table docs/robots.md]

Of the files that one of the engines loads it says how many are read and agree, and names the rest.


Without folders it takes the robots of example-robot-data and every URDF file of the installed
packages among `PACKAGES`. Files from elsewhere are given by their folder: a clone of a public
repository, or what `pip install --no-deps --target FOLDER PACKAGE` leaves there; their texts are
not kept here. Sources and licenses are in `PACKAGES`; each robot of example-robot-data has its own
in its folder. With --table, a page for the documentation is written.
"""

from __future__ import annotations

import argparse
import hashlib
import platform
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import Distribution, PackageNotFoundError, distribution, version
from pathlib import Path

import mecanique as mq
from mecanique.verification.compare import compare
from mecanique.verification.engines import engine_of, read_by

PACKAGES = {
    "airo-models": "MIT",
    "armar": "CC BY-NC 4.0",
    "dexmate-urdf": "of its own",
    "hello-robot-stretch-urdf": "of its own",
    "icub-models": "CC BY-SA 4.0",
    "jvrc-description": "Apache 2.0",
    "orca-arm": "not stated",
    "pybullet": "zlib",
    "robot-properties-fingers": "BSD-3-Clause",
    "rtb-data": "MIT",
    "synriard": "GPL 3.0",
    "upkie-description": "Apache 2.0",
    "urdfenvs": "GPL 3.0 or later",
}
"""Packages with URDF files, and their licenses."""

OWN = "example-robot-data"


@dataclass(frozen=True)
class Robot:
    """A file, and what came of it.

    Args:
        source: the package it is from.
        name: its path in the package.
        size: number of velocities.
        outcome: "agrees", "disagrees", "refused", "no mass" where nothing that moves has any, or
            "not compared".
        worst: largest relative difference from the engine.
        remarks: flaws and what engines make of the file.
        seconds: processor time of reading and comparing.
        loaded: the engines that load it, with joints that move.
    """

    source: str
    name: str
    size: int
    outcome: str
    worst: float = 0.0
    remarks: tuple[str, ...] = ()
    seconds: float = 0.0
    loaded: tuple[str, ...] = ()

    def __str__(self) -> str:
        worst = f" {self.worst:.0e}" if self.outcome in ("agrees", "disagrees") else ""
        said = "; ".join((self.outcome + worst, *self.remarks))
        return f"{self.name[-60:]:60} {self.size:>3}  {self.seconds:7.2f}  {said}"


def main() -> None:
    """Print a line for each file with moving joints, and the sums."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--engines", default="pinocchio")
    parser.add_argument("--samples", type=int, default=10)
    parser.add_argument("--table", type=Path)
    arguments = parser.parse_args()
    engines = arguments.engines.split(",")
    robots: list[Robot] = []
    print(f"{'file':60} {'nv':>3}  {'seconds':>7}  result")
    for source, name, file in _files(arguments.folders):
        robot = _judge(source, name, file, engines, arguments.samples)
        if robot is not None:
            robots.append(robot)
            print(robot, flush=True)
    print()
    for what, count in sorted(Counter(robot.outcome for robot in robots).items()):
        print(f"{count:5}  {what}")
    print(f"\n{_share(robots, engines)}")
    for robot in robots:
        if robot.loaded and robot.outcome not in ("agrees", "no mass"):
            print(f"{' '.join(robot.loaded)}: {robot.source} {robot}")
    if arguments.table:
        arguments.table.write_text(_page(robots, arguments), encoding="utf-8")


def _judge(source: str, name: str, file: Path, engines: list[str], samples: int) -> Robot | None:
    """Return what comes of a file; nothing if none of it moves."""
    start = time.process_time()
    try:
        mechanism = mq.read_urdf(file)
    except mq.MecaniqueError as error:
        why = [f"line {f.line}: {f.sentence}" for f in mq.lint(file) if f.stops] or [str(error)]
        more = (f"and {len(why) - 2} more",) if len(why) > 2 else ()
        loaded = tuple(engine for engine in engines if _loads(engine, file))
        return Robot(source, name, 0, "refused", remarks=(*why[:2], *more), loaded=loaded)
    if not mechanism.nv:
        return None
    remarks = list[str]()
    flaws = mechanism.origin.flaws if mechanism.origin else ()
    for code, count in sorted(Counter(flaw.code for flaw in flaws).items()):
        remarks.append(f"{code} ×{count}" if count > 1 else code)
    outcome, worst = "not compared", 0.0
    try:
        verdict = compare(mechanism, samples, 0, quick=True)
        outcome, worst = ("agrees" if verdict.agrees else "disagrees"), verdict.worst
    except mq.MecaniqueError as error:
        if "nothing that moves has mass" in str(error):
            outcome = "no mass"
        else:
            remarks.append(str(error)[:160])
    known = list[str]()
    for engine, reading in zip(engines, read_by(mechanism, engines, 0), strict=True):
        if not reading.refused:
            known.append(engine)
        title = reading.engine.split()[0]
        if reading.refused:
            remarks.append(f"{title} refuses the file")
        elif reading.differs:
            remarks.append(f"{title} reads it otherwise")
    seconds = time.process_time() - start
    return Robot(source, name, mechanism.nv, outcome, worst, tuple(remarks), seconds, tuple(known))


def _loads(engine: str, file: Path) -> bool:
    """Whether an engine loads a file that is refused here, and finds joints in it that move."""
    try:
        return bool(engine_of(engine).read(file.read_bytes(), (0.0, 0.0, -9.81), {}, {}).joints)
    except mq.MecaniqueError:
        return False


def _share(robots: list[Robot], engines: list[str]) -> str:
    """Say how many of the files that engines load are read and agree."""
    loaded = [robot for robot in robots if robot.loaded]
    massive = [robot for robot in loaded if robot.outcome != "no mass"]
    said = (
        f"Of {len(loaded)} files that one of these engines loads, {len(loaded) - len(massive)} "
        "have moving parts without any mass: they are read, and have no equations of motion. Of "
        f"the other {len(massive)}, {_agreeing(massive)} are read and agree."
    )
    for engine in engines:
        own = [robot for robot in massive if engine in robot.loaded]
        said += f" Of the {len(own)} that {engine_of(engine).title} loads, {_agreeing(own)} do."
    return said


def _agreeing(robots: list[Robot]) -> str:
    agree = sum(robot.outcome == "agrees" for robot in robots)
    return f"{agree} ({100 * agree / max(1, len(robots)):.1f} %)"


def _files(folders: list[Path]) -> Iterator[tuple[str, str, Path]]:
    """Yield source, name and path of every file, equal texts once."""
    found: list[tuple[str, str, Path]] = []
    for folder in folders:
        source = _name_of(folder)
        for file in sorted(folder.rglob("*.urdf")):
            found.append((source, str(file.relative_to(folder)), file))
    if not folders or OWN in map(str, folders):
        found += _installed()
    seen: set[str] = set()
    for source, name, file in found:
        digest = hashlib.sha256(file.read_bytes()).hexdigest()
        if digest not in seen:
            seen.add(digest)
            yield source, name, file


def _installed() -> Iterator[tuple[str, str, Path]]:
    root = mq.robot("panda").parents[2]
    for file in sorted(root.rglob("*.urdf")):
        yield f"{OWN} {version(OWN)}", str(file.relative_to(root)), file
    for package in PACKAGES:
        try:
            files = distribution(package).files or []
        except PackageNotFoundError:
            continue
        for each in files:
            path = Path(str(each.locate()))
            if path.suffix == ".urdf" and path.is_file():
                yield f"{package} {version(package)}", str(each), path


def _name_of(folder: Path) -> str:
    """Name and version of the package that was installed there, or else the folder's name."""
    for stated in folder.glob("*.dist-info"):
        found = Distribution.at(stated)
        return f"{found.metadata['Name'].replace('_', '-')} {found.version}"
    return folder.name


def _page(robots: list[Robot], arguments: argparse.Namespace) -> str:
    sources: dict[str, list[Robot]] = {}
    for robot in robots:
        sources.setdefault(robot.source, []).append(robot)
    engine = f"Pinocchio {version('pin')}, Python {platform.python_version()}"
    lines = [
        "# Robots of the world",
        "",
        "Public URDF files with moving joints, equal texts once; each is read, derived and",
        f"compared with Pinocchio at {arguments.samples} states.",
        "A flaw is an error in the file that its equations of motion do without; rules are",
        "explained under [lint](lint.md). Times are processor time for reading, deriving and",
        f"comparing, beside other work on a virtual machine with 2 cores ({engine}).",
        "",
        f"{_share(robots, arguments.engines.split(','))} The engines read the original text.",
        "",
        "Written by `python tests/benchmarks/bench_robots.py FOLDER … --engines "
        f"{arguments.engines} --samples {arguments.samples} --table docs/robots.md`. The first "
        "sources are public repositories, of which only files that do not agree are listed; the "
        "others are packages.",
        "",
        "| source | license | files | read | agree | with flaws | read otherwise or refused by an"
        " engine | median time | longest |",
        "|---|---|--:|--:|--:|--:|--:|--:|--:|",
    ]
    for source, own in sources.items():
        package = source.split()[0]
        licence = (
            "BSD-2-Clause, and each robot's"
            if package == OWN
            else PACKAGES.get(package, "each robot's")
        )
        lines.append(f"| {source.replace('+', '/')} | {licence} | {_sums(own)} |")
    lines.append(f"| **all** | | {_sums(robots)} |")
    for source, own in sources.items():
        repository = "+" in source
        if repository and all(robot.outcome in ("agrees", "no mass") for robot in own):
            continue
        lines += [
            "",
            f"## {source.replace('+', '/')}",
            "",
            "| file | velocities | verdict | remarks | time |",
        ]
        lines.append("|---|--:|---|---|--:|")
        for robot in own:
            verdict = robot.outcome
            if repository and verdict in ("agrees", "no mass"):
                continue
            if verdict in ("agrees", "disagrees"):
                verdict += f", {robot.worst:.0e}"
            said = "; ".join(robot.remarks).replace("|", "\\|").replace("<", "&lt;")
            cells = (f"`{robot.name}`", robot.size or "", verdict, said, f"{robot.seconds:.2f} s")
            lines.append("| " + " | ".join(map(str, cells)) + " |")
    return "\n".join([*lines, ""])


def _sums(robots: list[Robot]) -> str:
    read = [robot for robot in robots if robot.outcome != "refused"]
    agree = sum(robot.outcome == "agrees" for robot in robots)
    flawed = sum(any(r.startswith("M") and r[1:4].isdigit() for r in x.remarks) for x in read)
    engines = sum(any("otherwise" in r or "refuses the" in r for r in x.remarks) for x in read)
    times = sorted(robot.seconds for robot in read) or [0.0]
    took = f"{times[len(times) // 2]:.2f} s | {times[-1]:.1f} s"
    return f"{len(robots)} | {len(read)} | {agree} | {flawed} | {engines} | {took}"


if __name__ == "__main__":
    main()
