"""How often the search for causes names a slip put into the text of a robot's URDF. Run by hand.

    python tests/benchmarks/bench_slips.py [one,two,noise] [--seed 0] [--robots panda,a1]
        [--kinds center] [--table docs/slips.md]

Each slip is made in the XML of a public robot, without this package, and what Pinocchio answers for
the changed text is given to `verify` as functions, so that only numbers are left of it. The result
is the place at which kind and link or joint are named, 1 being first, what cannot be told apart
from the first coming next. For two slips, the first cause must name both. "noise" adds 5 % rms to
the torques of 300 samples with a mass that some joint feels by 3 %, and asks for link and mass.
"""

from __future__ import annotations

import argparse
import re
import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from time import process_time
from typing import Any, NamedTuple

import numpy as np

import mecanique as mq
from mecanique.verification.verdict import LikelyCause

ROBOTS = (
    "panda",
    "ur5_robot",
    "kinova",
    "z1",
    "xarm7",
    "so100",
    "a1",
    "solo12",
    "hyq_no_sensors",
    "tiago_pro",
    "talos_reduced",
)
PAIRS, NOISY = ROBOTS[:2], ROBOTS[:9]
"""Robots in which two slips at once are made, and those with noise: larger ones take long."""

LEAST = 1e-6
"""Slips that change less than this part of every torque are passed over."""

LINK = ("link mass", "root mass", "mass unit")
TURN = ("wrong axes", "product sign", "inertia turn")
ORIGIN = ("joint origin",)
RPY = ("joint turn", "frame", "degree")
Tree = ET.Element
Rng = np.random.Generator


@dataclass(frozen=True)
class Slip:
    """A slip made in a tree of XML.

    Args:
        kinds: what a right answer may call it.
        where: link or joint, as a cause says it.
        armature: joint and its rotor's inertia, which URDF has no tag for.
    """

    kinds: tuple[str, ...]
    where: str
    armature: tuple[str, float] | None = None


def triple(element: Tree | None, key: str) -> np.ndarray:
    """Three numbers of an attribute; zeros by default."""
    text = None if element is None else element.get(key)
    return np.array([float(word) for word in (text or "0 0 0").split()])


def put(element: Tree, key: str, values: Any) -> None:
    """Write three numbers into an attribute."""
    element.set(key, " ".join(repr(float(x)) for x in values))


def under(element: Tree, tag: str) -> Tree:
    """The child of a tag, made where it is missing."""
    found = element.find(tag)
    return ET.SubElement(element, tag) if found is None else found


def matrix(rpy: Any) -> np.ndarray:
    """Rz(yaw) Ry(pitch) Rx(roll)."""
    x, y, z = (about(axis, angle) for axis, angle in zip(np.eye(3), rpy, strict=True))
    return np.asarray(z @ y @ x)


def about(axis: Any, angle: float) -> np.ndarray:
    """Turn about a unit axis."""
    x, y, z = axis
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K)


def angles(R: np.ndarray) -> tuple[float, float, float]:
    """Roll, pitch and yaw of a turn."""
    pitch = -np.arcsin(np.clip(R[2, 0], -1, 1))
    if abs(R[2, 0]) > 1 - 1e-12:
        return 0.0, float(pitch), float(np.arctan2(-R[0, 1], R[1, 1]))
    return (
        float(np.arctan2(R[2, 1], R[2, 2])),
        float(pitch),
        float(np.arctan2(R[1, 0], R[0, 0])),
    )


def some_joint(tree: Tree, rng: Rng) -> Tree:
    """A joint that moves."""
    found = [j for j in tree.findall("joint") if j.get("type") not in ("fixed", None)]
    return found[rng.integers(len(found))]


def some_link(tree: Tree, rng: Rng) -> Tree:
    """A link with mass beyond a joint that moves."""
    moved = {
        child.get("link")
        for j in tree.findall("joint")
        if j.get("type") != "fixed" and (child := j.find("child")) is not None
    }
    found = [
        link
        for link in tree.findall("link")
        if link.get("name") in moved and link.find("inertial/mass") is not None
    ]
    return found[rng.integers(len(found))]


def joint_where(joint: Tree) -> str:
    """How a cause names it."""
    return f"joint {joint.get('name')!r}"


def link_where(link: Tree) -> str:
    """How a cause names it."""
    return f"link {link.get('name')!r}"


def origin_centimeter(tree: Tree, rng: Rng) -> Slip:
    """The origin of a joint is 1 cm off along an axis."""
    joint = some_joint(tree, rng)
    origin = under(joint, "origin")
    put(origin, "xyz", triple(origin, "xyz") + 0.01 * np.eye(3)[rng.integers(3)])
    return Slip(ORIGIN, joint_where(joint))


def origin_mirrored(tree: Tree, rng: Rng) -> Slip:
    """A coordinate of a joint's origin has the other sign."""
    joint = some_joint(tree, rng)
    origin = under(joint, "origin")
    xyz = triple(origin, "xyz")
    xyz[rng.integers(3)] *= -1
    put(origin, "xyz", xyz)
    return Slip(ORIGIN, joint_where(joint))


def rpy_order(tree: Tree, rng: Rng) -> Slip:
    """Roll, pitch and yaw of a joint are applied in the other order."""
    joint = some_joint(tree, rng)
    origin = under(joint, "origin")
    x, y, z = (about(*pair) for pair in zip(np.eye(3), triple(origin, "rpy"), strict=True))
    put(origin, "rpy", angles(x @ y @ z))
    return Slip(RPY, joint_where(joint))


def rpy_exchanged(tree: Tree, rng: Rng) -> Slip:
    """Two of roll, pitch and yaw of a joint are exchanged."""
    joint = some_joint(tree, rng)
    origin = under(joint, "origin")
    put(origin, "rpy", triple(origin, "rpy")[[(1, 0, 2), (2, 1, 0), (0, 2, 1)][rng.integers(3)],])
    return Slip(RPY, joint_where(joint))


def joint_turned(tree: Tree, rng: Rng) -> Slip:
    """A joint stands turned by some degrees."""
    joint = some_joint(tree, rng)
    origin = under(joint, "origin")
    axis, angle = np.eye(3)[rng.integers(3)], np.deg2rad(rng.uniform(2, 20))
    put(origin, "rpy", angles(matrix(triple(origin, "rpy")) @ about(axis, angle)))
    return Slip(RPY, joint_where(joint))


def inertial_turned(tree: Tree, rng: Rng) -> Slip:
    """The axes of an inertia are turned by any rotation."""
    link = some_link(tree, rng)
    origin = under(under(link, "inertial"), "origin")
    axis = rng.normal(size=3)
    turn = about(axis / np.linalg.norm(axis), rng.uniform(0.2, 3.0))
    put(origin, "rpy", angles(matrix(triple(origin, "rpy")) @ turn))
    return Slip(TURN, link_where(link))


def center_off(tree: Tree, rng: Rng) -> Slip:
    """A center of mass is 1 cm off along an axis."""
    link = some_link(tree, rng)
    origin = under(under(link, "inertial"), "origin")
    put(origin, "xyz", triple(origin, "xyz") + 0.01 * np.eye(3)[rng.integers(3)])
    return Slip(("center of mass",), link_where(link))


def armature(tree: Tree, rng: Rng) -> Slip:
    """A rotor that the other side does not count."""
    joint = some_joint(tree, rng)
    name = str(joint.get("name"))
    return Slip(("armature",), joint_where(joint), (name, float(10 ** rng.uniform(-2, 0))))


def mass(tree: Tree, rng: Rng) -> Slip:
    """A mass is wrong by some percent, its inertia is not."""
    link = some_link(tree, rng)
    found = under(under(link, "inertial"), "mass")
    found.set("value", repr(float(str(found.get("value"))) * rng.uniform(1.05, 1.5)))
    return Slip(LINK, link_where(link))


def mass_left_out(tree: Tree, rng: Rng) -> Slip:
    """A link has lost its inertial."""
    link = some_link(tree, rng)
    link.remove(under(link, "inertial"))
    return Slip(LINK, link_where(link))


def inertia_factor(tree: Tree, rng: Rng) -> Slip:
    """All entries of an inertia are ten times too large."""
    link = some_link(tree, rng)
    inertia = under(under(link, "inertial"), "inertia")
    for key, text in inertia.attrib.items():
        inertia.set(key, repr(10 * float(text)))
    return Slip(("inertia", "mass unit"), link_where(link))


def inertia_entry(tree: Tree, rng: Rng) -> Slip:
    """One moment of inertia is wrong by a third."""
    link = some_link(tree, rng)
    inertia = under(under(link, "inertial"), "inertia")
    key = ("ixx", "iyy", "izz")[rng.integers(3)]
    inertia.set(key, repr(1.3 * float(str(inertia.get(key)))))
    return Slip(("inertia",), link_where(link))


def length(tree: Tree, rng: Rng) -> Slip:
    """The way to a joint is some percent longer."""
    joint = some_joint(tree, rng)
    origin = under(joint, "origin")
    put(origin, "xyz", triple(origin, "xyz") * rng.uniform(1.03, 1.3))
    return Slip(ORIGIN, joint_where(joint))


def millimeters(tree: Tree, rng: Rng) -> Slip:
    """The way to a joint is given in millimeters."""
    joint = some_joint(tree, rng)
    origin = under(joint, "origin")
    put(origin, "xyz", triple(origin, "xyz") * 1000)
    return Slip(("length unit",), joint_where(joint))


def axis_reversed(tree: Tree, rng: Rng) -> Slip:
    """An axis points the other way."""
    joint = some_joint(tree, rng)
    axis = under(joint, "axis")
    put(axis, "xyz", -triple(axis, "xyz") if axis.get("xyz") else (-1, 0, 0))
    return Slip(("axis sign",), joint_where(joint))


def axis_exchanged(tree: Tree, rng: Rng) -> Slip:
    """An axis is another one of the three."""
    joint = some_joint(tree, rng)
    axis = under(joint, "axis")
    xyz = triple(axis, "xyz") if axis.get("xyz") else np.array([1.0, 0, 0])
    put(axis, "xyz", np.roll(xyz, 1 + rng.integers(2)))
    return Slip(("joint axis", "axis sign"), joint_where(joint))


def axis_tilted(tree: Tree, rng: Rng) -> Slip:
    """An axis is some degrees off."""
    joint = some_joint(tree, rng)
    axis = under(joint, "axis")
    xyz = triple(axis, "xyz") if axis.get("xyz") else np.array([1.0, 0, 0])
    off = np.cross(xyz, rng.normal(size=3))
    put(axis, "xyz", xyz + np.tan(np.deg2rad(rng.uniform(2, 10))) * off / np.linalg.norm(off))
    return Slip(("joint axis",), joint_where(joint))


SLIPS: dict[str, Callable[[Tree, Rng], Slip]] = {
    "joint origin 1 cm off": origin_centimeter,
    "joint origin mirrored": origin_mirrored,
    "way to a joint longer": length,
    "way in millimeters": millimeters,
    "rpy in the other order": rpy_order,
    "rpy exchanged": rpy_exchanged,
    "joint turned": joint_turned,
    "axis reversed": axis_reversed,
    "axis exchanged": axis_exchanged,
    "axis tilted": axis_tilted,
    "inertial turned": inertial_turned,
    "center 1 cm off": center_off,
    "mass": mass,
    "inertial left out": mass_left_out,
    "inertia times ten": inertia_factor,
    "one moment of inertia": inertia_entry,
    "armature": armature,
}


def change(
    text: str, makers: list[Callable[[Tree, Rng], Slip]], seeds: list[int]
) -> tuple[Any, Any]:
    """Make slips in a text; return them and the mechanism that Pinocchio answers for."""
    tree = ET.fromstring(re.sub(r"<\?xml[^>]*\?>", "", text))
    slips = [
        make(tree, np.random.default_rng(seed)) for make, seed in zip(makers, seeds, strict=True)
    ]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "changed.urdf")
        ET.ElementTree(tree).write(path)
        mechanism = mq.read_urdf(path)
    for name, amount in (slip.armature for slip in slips if slip.armature):
        joints: list[Any] = list(mechanism.joints)
        joints = [replace(j, armature=amount) if j.name == name else j for j in joints]
        mechanism = replace(mechanism, joints=tuple(joints))
    return slips, mechanism


def functions(mechanism: Any) -> dict[str, Callable[..., Any]]:
    """What Pinocchio says of a mechanism."""
    reference = mq.Reference(mechanism)
    return {"M": reference.mass_matrix, "bias": reference.bias}


def feels(ours: Any, theirs: Any) -> float:
    """The largest part of a joint's torques that a slip changes."""
    rng = np.random.default_rng(7)
    one, other = mq.Reference(ours), mq.Reference(theirs)
    states = rng.normal(size=(10, 3, ours.nv))
    mine, yours = (
        np.array([side.inverse_dynamics(*state) for state in states]) for side in (one, other)
    )
    sizes = np.sqrt((mine**2).mean(axis=0))
    return float((np.abs(mine - yours).max(axis=0) / np.maximum(sizes, 1e-9 * sizes.max())).max())


class Trial(NamedTuple):
    """What came of a trial.

    Args:
        robot: its name.
        kind: of the slip, or the first of two.
        place: at which it was named; 0 for not at all, -1 where two were named up to twins.
        wanted: what should be named.
        said: what was named first.
        seconds: what the verdict took.
        seen: how large the smaller slip is, of the torques.
    """

    robot: str
    kind: str
    place: int
    wanted: str
    said: str
    seconds: float
    seen: float


class Weighing(NamedTuple):
    """What came of noisy samples: the link and mass [kg] that were named, and the true ones."""

    robot: str
    link: str
    mass: float
    said: str
    is_link: bool
    found: float
    sigma: float
    seconds: float

    @property
    def off(self) -> float:
        """How far the mass is off, in standard deviations."""
        return abs(self.found - self.mass) / self.sigma


def is_named(cause: LikelyCause, slip: Slip) -> bool:
    """Whether a cause is the slip."""
    return cause.kind in slip.kinds and cause.where == slip.where


def place_of(causes: tuple[LikelyCause, ...], slips: list[Slip]) -> int:
    """At which place slips are named."""
    if not causes:
        return 0
    first = causes[0]
    if len(slips) == 2:
        parts = first.parts
        if all(any(is_named(part, slip) for part in parts) for slip in slips):
            return 1
        known = [one for part in parts for one in (part, *part.alike)]
        return -all(any(is_named(one, slip) for one in known) for slip in slips)
    named = list(dict.fromkeys((c.kind, c.where) for c in (first, *first.alike, *causes[1:])))
    (slip,) = slips
    hits = [
        k for k, (kind, where) in enumerate(named, 1) if kind in slip.kinds and where == slip.where
    ]
    return hits[0] if hits else 0


def find(robot: str, number: int, kind: str, seed: int, *, two: bool) -> Trial | None:
    """Make one slip or two in a robot and ask for the cause; nothing where none can be made."""
    path = mq.robot(robot)
    text, ours = path.read_text(encoding="utf-8-sig"), mq.read_urdf(path)
    rng = np.random.default_rng([seed, number, list(SLIPS).index(kind)])
    for _ in range(20):
        second = [list(SLIPS)[rng.integers(len(SLIPS))]] if two else []
        makers = [SLIPS[name] for name in (kind, *second)]
        seeds = rng.integers(10**6, size=len(makers)).tolist()
        slips, theirs = change(text, makers, seeds)
        apart = len({slip.where.partition(" ")[2] for slip in slips}) == len(slips)
        if not apart or not all(is_known(ours, slip) for slip in slips):
            continue
        each = zip(makers, seeds, strict=True)
        alone = [change(text, [make], [seed])[1] for make, seed in each]
        seen = min(feels(ours, one) for one in alone)
        if seen > LEAST:
            break
    else:
        return None
    start = process_time()
    causes = mq.verify(ours, against=functions(theirs), samples=12).causes
    seconds = process_time() - start
    said = str(causes[0]) if causes else "nothing"
    wanted = " and ".join(f"{slip.kinds[0]} of {slip.where}" for slip in slips)
    return Trial(robot, kind, place_of(causes, slips), wanted, said, seconds, seen)


def is_known(ours: Any, slip: Slip) -> bool:
    """Whether a slip names something that the mechanism has."""
    names = {f"joint {j.name!r}" for j in ours.joints} | {f"link {b.name!r}" for b in ours.bodies}
    return slip.where in names


def weigh(robot: str, number: int, seed: int) -> Weighing:
    """Find a wrong mass from noisy torques."""
    path = mq.robot(robot)
    text, ours = path.read_text(encoding="utf-8-sig"), mq.read_urdf(path)
    rng = np.random.default_rng([seed, number])
    while True:
        slips, theirs = change(text, [mass], [int(rng.integers(10**6))])
        if feels(ours, theirs) > 0.03:
            break
    link = slips[0].where.split("'")[1]
    true = theirs.evaluate(next(b for b in theirs.bodies if b.name == link).mass)
    q, v, a = (rng.uniform(-1.5, 1.5, size=(300, ours.nv)) for _ in range(3))
    reference = mq.Reference(theirs)
    tau = np.array([reference.inverse_dynamics(*row) for row in zip(q, v, a, strict=True)])
    tau += 0.05 * np.sqrt((tau**2).mean(axis=0)) * rng.normal(size=tau.shape)
    velocities = ours.velocities
    heads = [*ours.coordinates, *velocities, *(f"{name}'" for name in velocities)]
    heads += [f"tau_{name.removesuffix(chr(39))}" for name in velocities]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "samples.csv")
        table = np.hstack([q, v, a, tau])
        np.savetxt(file, table, delimiter=",", header=",".join(heads), comments="")
        start = process_time()
        causes = mq.verify(ours, against=file).causes
    seconds = process_time() - start
    if not causes:
        return Weighing(robot, link, true, "nothing", False, np.nan, np.nan, seconds)
    first = causes[0]
    hit = is_named(first, slips[0])
    mean, sigma = np.nan, np.nan
    if hit and (read := re.search(r"([\d.]+) ± ([\d.e-]+) kg", first.text)):
        mean, sigma = float(read[1]), float(read[2])
    return Weighing(robot, link, true, str(first), hit, mean, sigma, seconds)


def main() -> None:
    """Make the slips; print what is not named first, and the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", nargs="?", default="one,two,noise", help="with commas")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--robots", default=",".join(ROBOTS))
    parser.add_argument("--kinds", default="", help="a part of the names of the slips")
    parser.add_argument("--table", type=Path, help="write a page")
    arguments = parser.parse_args()
    names, what = arguments.robots.split(","), arguments.what.split(",")
    numbered = [(name, ROBOTS.index(name) if name in ROBOTS else 99) for name in names]
    kinds = [name for name in SLIPS if arguments.kinds in name]
    tried: dict[str, list[Trial]] = {"one": [], "two": []}
    for each in (each for each in tried if each in what):
        of = [one for one in numbered if each == "one" or one[0] in PAIRS]
        for robot, number in of:
            for kind in kinds:
                trial = find(robot, number, kind, arguments.seed, two=each == "two")
                if trial:
                    tried[each].append(trial)
                    if trial.place != 1:
                        print(f"{robot}: {kind}: {_tell(trial)}", flush=True)
        print("\n".join(_rows(tried[each], kinds)), flush=True)
    weighed = list[Weighing]()
    for robot, number in (one for one in numbered if "noise" in what and one[0] in NOISY):
        weighed.append(weigh(robot, number, arguments.seed))
        print(_tell_mass(weighed[-1]), flush=True)
    if arguments.table:
        page = "\n".join(_page(tried["one"], tried["two"], weighed, kinds))
        arguments.table.write_text(page + "\n", encoding="utf-8")


def _tell(trial: Trial) -> str:
    place = {0: "not named", -1: "named up to twins"}.get(trial.place, f"place {trial.place}")
    return f"{place}: {trial.wanted} (of the torques {trial.seen:.0e}); first: {trial.said[:300]}"


def _tell_mass(one: Weighing) -> str:
    off = f"{one.off:.1f} σ off" if one.is_link else "another link"
    return (
        f"{one.robot}: {one.link} {one.mass:.5g} kg: {off}: {one.said[:300]} [{one.seconds:.0f} s]"
    )


def _rows(trials: list[Trial], kinds: list[str]) -> Iterator[str]:
    """Yield the lines of a table of places, robot by kind."""
    names = list(dict.fromkeys(trial.robot for trial in trials))
    heads = [name.replace("_", " ") for name in names]
    yield "| slip | " + " | ".join(heads) + " | first | among three | tried |"
    yield "|---|" + ":-:|" * len(names) + "--:|--:|--:|"
    for kind in (*kinds, "all"):
        of = [trial for trial in trials if kind in (trial.kind, "all")]
        cells = []
        for name in names:
            here = [trial for trial in of if trial.robot == name]
            if kind == "all":
                cells.append(f"{sum(x.place == 1 for x in here)}/{len(here)}")
            else:
                cells.append(_MARKS.get(here[0].place, str(here[0].place)) if here else "")
        first = sum(trial.place == 1 for trial in of)
        three = sum(trial.place in (1, 2, 3, -1) for trial in of)
        yield f"| {kind} | {' | '.join(cells)} | {first} | {three} | {len(of)} |"


_MARKS = {0: "×", -1: "≈"}
"""Not named; two slips of which one was named by what cannot be told apart from it."""


def _page(
    one: list[Trial],
    two: list[Trial],
    weighed: list[Weighing],
    kinds: list[str],
) -> Iterator[str]:
    """Yield the lines of the page."""
    yield _HEAD.format(pin=version("pin"))
    if one:
        first = sum(trial.place == 1 for trial in one)
        three = sum(trial.place in (1, 2, 3) for trial in one)
        share = f"{100 * first / len(one):.0f} %"
        yield f"**Named first {first} of {len(one)} ({share}), among the first three {three}.**"
        yield from ("", *_rows(one, kinds), "")
        yield from _others(one)
    if two:
        first = sum(trial.place == 1 for trial in two)
        twins = sum(trial.place == -1 for trial in two)
        yield _TWO
        yield f"**Both named {first} of {len(two)}; {twins} more up to what cannot be told apart.**"
        yield from ("", *_rows(two, kinds), "")
        yield from _others(two)
    if weighed:
        right = sum(one.is_link for one in weighed)
        near = sum(one.is_link and one.off <= 3 for one in weighed)
        yield _NOISE
        yield f"**The right link {right} of {len(weighed)}, its mass within 3 σ {near}.**"
        yield from ("", "| robot | link | mass | named first | off |", "|---|---|--:|---|--:|")
        for each in weighed:
            said = each.said.split(" (the difference")[0].replace("|", r"\|")
            off = f"{each.off:.1f} σ" if each.is_link else "another link"
            yield f"| {each.robot} | `{each.link}` | {each.mass:.5g} kg | {said} | {off} |"


def _others(trials: list[Trial]) -> Iterator[str]:
    """Yield what was not named first, and what was."""
    rest = [trial for trial in trials if trial.place != 1]
    if rest:
        yield from ("| robot | slip | of the torques | named first |", "|---|---|--:|---|")
        for trial in rest:
            said = trial.said.split(" (the difference")[0].replace("|", r"\|")
            yield f"| {trial.robot} | {trial.wanted} | {trial.seen:.0e} | {said} |"
        yield ""


_HEAD = """# Slips in robots

How often the search for causes names a slip. Each is made in the XML of a public robot, and what
Pinocchio {pin} answers for the changed text goes to `verify(…, against=…)` as functions M and bias:
only numbers are left of the slip. A number says at which place its kind and its link or joint are
named, 1 being first; × not at all; nothing stands where a robot has no such slip. What gives the
same equations cannot be told apart: there the plainest change comes first, and the verdict says
what explains the numbers as well.

Written by `python tests/benchmarks/bench_slips.py --table docs/slips.md`, on a machine of 2 cores
with other work.

## One slip
"""

_TWO = """## Two slips at once

Another slip, of any kind, is made in another link or joint, and the first cause must name both.
≈ stands where one of them is named by what cannot be told apart from it: the two fingers of panda
move as one. Of the first link of ur5 the equations feel one number alone, so that its center is
not told from its inertia.
"""

_NOISE = """## A mass in noise

A mass is wrong by 5 to 50 %, and some joint's torques feel it by 3 %. All torques of 300 samples
get noise of 5 % of their rms, and `verify(…, against="samples.csv")` is asked for link and mass.
"""


if __name__ == "__main__":
    main()
