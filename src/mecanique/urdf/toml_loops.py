"""Read loops, springs and dampers from a TOML file beside a URDF.

    [[loop]]
    name = "achilles"
    kind = "distance"                            # ball, hinge, weld, distance, pin or plate
    a = { link = "hip", xyz = [0, 0, 0.045] }    # rpy = [0, 0, 0]
    b = { link = "tarsus", xyz = [-0.1, 0, 0] }
    length = 0.5                                 # of a distance only [m]

    [[spring]]
    joint = "shin"
    stiffness = 1500                             # [N·m/rad or N/m]
    damping = 0.1                                # [N·m·s/rad or N·s/m]
    reference = 0                                # the position without force [rad or m]

URDF itself describes trees alone, so that a robot with rods and springs, such as Cassie, is
published as an open tree.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from mecanique.errors import InputError
from mecanique.model.constraints.loops import CLOSED, Loop
from mecanique.model.force_base import AnyForce
from mecanique.model.forces import JointDamper, JointSpring
from mecanique.model.mechanism import Mechanism
from mecanique.model.placement import Placement

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


_TABLES = {
    "loop": {"name", "kind", "a", "b", "length"},
    "spring": {"joint", "stiffness", "damping", "reference"},
}
_FRAME = {"link", "xyz", "rpy"}


def with_loops(mechanism: Mechanism, path: str | os.PathLike[str]) -> Mechanism:
    """Return a mechanism with the loops, springs and dampers of a TOML file."""
    file = Path(path)
    try:
        tables = tomllib.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(f"expected a TOML file, but there is no file {str(file)!r}") from None
    except (OSError, ValueError) as error:
        raise InputError(f"{file} cannot be read: {error}") from None
    unknown = sorted(tables.keys() - _TABLES)
    if unknown or not tables:
        said = f"got {unknown[0]!r}" if unknown else "got an empty file"
        raise InputError(f"expected tables [[loop]] and [[spring]] in {file}, {said}")
    loops = tuple(_loop(entry, str(file)) for entry in _entries(tables, "loop", str(file)))
    springs = [
        force
        for entry in _entries(tables, "spring", str(file))
        for force in _forces(entry, str(file))
    ]
    return replace(
        mechanism, loops=(*mechanism.loops, *loops), forces=(*mechanism.forces, *springs)
    )


def _entries(tables: Mapping[str, Any], kind: str, where: str) -> Iterator[Mapping[str, Any]]:
    entries = tables.get(kind, [])
    if not isinstance(entries, list) or not all(isinstance(table, dict) for table in entries):
        raise InputError(f"expected tables [[{kind}]] in {where}")
    for entry in entries:
        _refuse_unknown(entry, _TABLES[kind], f"a [[{kind}]] in {where}")
        yield entry


def _loop(entry: Mapping[str, Any], where: str) -> Loop:
    name, kind = (_text(entry, field, f"a [[loop]] in {where}") for field in ("name", "kind"))
    where = f"loop {name!r} in {where}"
    if kind not in CLOSED:
        raise InputError(f"{where}: expected a kind among {', '.join(CLOSED)}, got {kind!r}")
    ends = []
    for end in ("a", "b"):
        frame = entry.get(end)
        if not isinstance(frame, dict):
            raise InputError(f'{where}: expected {end} = {{ link = "…", xyz = [0, 0, 0] }}')
        _refuse_unknown(frame, _FRAME, f"frame {end} of {where}")
        place = Placement(*(_vector(frame, field, where) for field in ("xyz", "rpy")))
        ends.append((_text(frame, "link", f"frame {end} of {where}"), place))
    if ("length" in entry) != (kind == "distance"):
        raise InputError(f"{where}: expected a length of a distance, and of nothing else")
    length = _number(entry, "length", where) if kind == "distance" else 0.0
    (a, frame_a), (b, frame_b) = ends
    return Loop(
        name=name,
        kind=kind,  # type: ignore[arg-type]
        body_a=a,
        frame_a=frame_a,
        body_b=b,
        frame_b=frame_b,
        length=length,
    )


def _forces(entry: Mapping[str, Any], where: str) -> Iterator[AnyForce]:
    joint = _text(entry, "joint", f"a [[spring]] in {where}")
    where = f"the spring in joint {joint!r} in {where}"
    if not entry.keys() & {"stiffness", "damping"}:
        raise InputError(f"{where}: expected a stiffness or a damping")
    if "stiffness" in entry:
        rest = _number(entry, "reference", where) if "reference" in entry else 0.0
        yield JointSpring(f"{joint}_spring", joint, _number(entry, "stiffness", where), rest)
    if "damping" in entry:
        yield JointDamper(f"{joint}_spring_damper", joint, _number(entry, "damping", where))


def _refuse_unknown(entry: Mapping[str, Any], fields: set[str], where: str) -> None:
    unknown = sorted(entry.keys() - fields)
    if unknown:
        known = ", ".join(sorted(fields))
        raise InputError(f"unknown field {unknown[0]!r} of {where}; known: {known}")


def _text(entry: Mapping[str, Any], field: str, where: str) -> str:
    value = entry.get(field)
    if not isinstance(value, str) or not value:
        raise InputError(f'expected {field} = "…" of {where}, got {value!r}')
    return value


def _number(entry: Mapping[str, Any], field: str, where: str) -> float:
    value = entry.get(field)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise InputError(f"expected a number for {field} of {where}, got {value!r}")
    return float(value)


def _vector(entry: Mapping[str, Any], field: str, where: str) -> tuple[float, float, float]:
    value = entry.get(field, [0, 0, 0])
    if not isinstance(value, list) or len(value) != 3:
        raise InputError(f"expected three numbers for {field} of {where}, got {value!r}")
    x, y, z = (_number({field: component}, field, where) for component in value)
    return x, y, z
