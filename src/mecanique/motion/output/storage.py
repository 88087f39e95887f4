"""Store motions in npz files; export them as CSV, Parquet and data frames.

A file states where its mechanism comes from, so that it is found again.
"""

from __future__ import annotations

import json
import os
import struct
import zipfile
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from itertools import islice, product
from os import PathLike
from pathlib import Path
from typing import IO, Any, TypeVar, final

import numpy as np

from mecanique.arrays import spread
from mecanique.errors import InputError, MecaniqueError
from mecanique.files import write_whole
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import add_unit, per_second, units
from mecanique.motion.record.curve import Curve
from mecanique.motion.record.events import Occurrence
from mecanique.motion.record.rates import Rates
from mecanique.motion.record.trajectory import Statistics, Trajectory
from mecanique.motion.tolerances import ANOTHER

MAX_TRIALS = 1000
"""Most combinations of whole-number options to try."""


def provenance(mechanism: Mechanism) -> dict[str, Any]:
    """Return what identifies a mechanism: names, values, and its catalogue entry or URDF text."""
    about: dict[str, Any] = {
        "mechanism": mechanism.name,
        "coordinates": list(mechanism.coordinates.names),
        "velocities": list(mechanism.velocities),
        "parameters": mechanism.values,
        "catalogue": _from_catalogue(mechanism),
    }
    if about["catalogue"] is None:
        from mecanique.urdf import write_urdf

        try:
            about["urdf"] = write_urdf(mechanism)
        except MecaniqueError:
            # not every mechanism can be written; the user must then give it to load the motion
            about["urdf"] = None
    return about


def recover(about: dict[str, Any], mechanism: Mechanism | None, path: str) -> Mechanism:
    """Return the mechanism of a saved motion, checked against what the file states."""
    if mechanism is None:
        place = about.get("catalogue")
        if not isinstance(place, dict):
            raise InputError(
                f"{path!r} is a motion of {about.get('mechanism')!r}, "
                "which is not in the catalogue; "
                "give the mechanism: Motion.load(path, mechanism)"
            )
        from mecanique import textbook

        try:
            mechanism = textbook.load(str(place["system"]), **place["values"])
        except (MecaniqueError, KeyError, TypeError) as error:
            raise InputError(
                f"{path!r} names a system that the catalogue does not have: {error}"
            ) from None
    for what, have in (
        ("coordinates", list(mechanism.coordinates.names)),
        ("velocities", list(mechanism.velocities)),
        ("parameters", mechanism.values),
    ):
        if about.get(what) != have:
            raise InputError(
                f"{path!r} is a motion of {about.get('mechanism')!r} with other {what}: "
                f"expected {about.get(what)}, got {have}"
            )
    return mechanism


def _from_catalogue(mechanism: Mechanism) -> dict[str, Any] | None:
    """The system and the values that build this very mechanism, if the catalogue has it."""
    from mecanique import textbook

    if not textbook.catalogue.is_known(mechanism.name):
        return None
    system = textbook.entry(mechanism.name)
    known = {parameter.symbol for parameter in system.parameters}
    values: dict[str, float] = {
        symbol: value for symbol, value in mechanism.values.items() if symbol in known
    }
    # options are not among the parameters of what they build; they count bodies or joints, so small
    # numbers do
    numbers = range(1, len(mechanism.bodies) + 2)
    for chosen in islice(product(numbers, repeat=len(system.options)), MAX_TRIALS):
        trial = dict(zip(system.options, chosen, strict=True))
        try:
            if textbook.load(mechanism.name, **values, **trial) == mechanism:
                return {"system": mechanism.name, "values": {**values, **trial}}
        except MecaniqueError:
            continue
    return None


FORMAT = "mecanique motion 1"
"""First line of every file's description."""

_Kind = TypeVar("_Kind", bound=Trajectory)

MOST_UNPACKED, MOST_RATIO = 2**26, 200
"""A file may unpack to so many bytes and this many times its size; times do not pack so well."""

_STEPS = ("t", "q", "v", "a", "breaks")


def save(motion: Trajectory, path: str | PathLike[str]) -> None:
    """Write a motion to an npz file, whole or not at all; nothing in it is pickled."""
    from importlib.metadata import version

    path = Path(path)
    path = path if path.suffix else path.with_suffix(".npz")
    s, watched = motion.statistics, motion.event_names
    if motion.watched is not None:
        watched = tuple(event.name for event in motion.watched)
    about = {
        "format": FORMAT,
        "mecanique": version("mecanique"),
        "numpy": np.__version__,
        "method": motion.method,
        "statistics": [s.steps, s.evaluations, s.seconds, s.rtol, s.atol, s.share],
        "smooth": motion.curve.smooth,
        "close": motion.curve.close,
        "events": [event.name for event in motion.events],
        "watched": watched,
        **provenance(motion.mechanism),
    }
    arrays = {f"step_{name}": getattr(motion.curve, name) for name in _STEPS}
    happened = [
        np.concatenate([[event.t], event.q, event.v, event.after]) for event in motion.events
    ]
    width = 1 + motion.mechanism.nq + 2 * motion.mechanism.nv
    arrays |= {
        "t": motion.t,
        "q": motion.q,
        "v": motion.v,
        "events": np.array(happened).reshape(-1, width),
    }
    text = np.array(json.dumps(about, ensure_ascii=False))
    _write(path, lambda file: np.savez_compressed(file, about=text, **arrays))


def load(path: str | PathLike[str], mechanism: Mechanism | None, kind: type[_Kind]) -> _Kind:
    """Read a motion that `save` wrote, and check that the mechanism is the file's."""
    saved = _read(path)
    mechanism = recover(saved.about, mechanism, os.fspath(path))
    if not saved.fits(mechanism):
        raise InputError(f"{os.fspath(path)!r} is damaged: its arrays do not fit each other")
    step_t, step_q, step_v, step_a, breaks = saved.steps
    curve = Curve(
        t=step_t,
        q=step_q,
        v=step_v,
        a=step_a,
        breaks=breaks,
        rates=Rates.of(mechanism),
        smooth=saved.smooth,
        close=saved.close,
    )
    cut = np.cumsum([1, mechanism.nq, mechanism.nv])
    events = []
    for name, row in zip(saved.names, saved.happened, strict=True):
        time, *state = np.split(row, cut)
        events.append(Occurrence(name, float(time[0]), *state))
    motion = kind(
        mechanism=mechanism,
        t=saved.t,
        q=saved.q,
        v=saved.v,
        path=curve,
        method=saved.method,
        statistics=saved.statistics,
        events=tuple(events),
        event_names=saved.watched,
    )
    _check_accelerations(motion, os.fspath(path))
    return motion


@final
@dataclass(frozen=True, eq=False)
class _Saved:
    """What a file holds, before it is known to fit a mechanism."""

    about: dict[str, Any]  # its description, which says whose motion it is
    t: np.ndarray
    q: np.ndarray
    v: np.ndarray
    # times, positions, velocities and accelerations of the steps, and the breaks
    steps: list[np.ndarray]
    happened: np.ndarray  # a row for each event
    names: list[str]
    # names of the events that were watched for; None in older files
    watched: tuple[str, ...] | None
    method: str  # which method integrated it and why
    smooth: bool
    close: bool
    statistics: Statistics

    def fits(self, m: Mechanism) -> bool:
        """Return whether the arrays fit each other and a mechanism."""
        step_t, step_q, step_v, step_a, breaks = self.steps
        n, count = len(np.atleast_1d(self.t)), len(np.atleast_1d(step_t))
        shapes: list[tuple[np.ndarray, tuple[int, ...]]] = [
            (self.t, (n,)),
            (self.q, (n, m.nq)),
            (self.v, (n, m.nv)),
            (step_t, (count,)),
            (step_q, (count, m.nq)),
            (step_v, (count, m.nv)),
            (step_a, (count, m.nv)),
            (self.happened, (len(self.names), 1 + m.nq + 2 * m.nv)),
        ]
        whole = (
            all(array.shape == expected for array, expected in shapes)
            and breaks.ndim == 1
            and n > 0
            and count > 0
        )
        known = (self.t, self.q, self.v, step_t, step_q, step_v, step_a)
        numeric = all(array.dtype == np.float64 for array in known)
        if not (whole and numeric and breaks.dtype.kind == "i" and len(breaks) and breaks[0] == 0):
            return False
        inside = bool((np.diff(breaks) > 0).all() and breaks[-1] < count)
        ordered = bool((np.diff(self.t) > 0).all() and (np.diff(step_t) >= 0).all())
        return inside and ordered and all(bool(np.isfinite(array).all()) for array in known)


def _read(path: str | PathLike[str]) -> _Saved:
    """Return what a file holds; refuse what is no motion."""
    try:
        # NumPy leaves a file that it opened itself open if it is damaged
        with open(path, "rb") as handle:
            _refuse_bomb(handle)
            file = np.load(handle, allow_pickle=False)
            data = {name: file[name] for name in file.files}
        about = json.loads(str(data["about"]))
        if about["format"] != FORMAT:
            raise InputError(
                f"expected a file of format {FORMAT!r}, got {about['format']!r} in "
                f"{os.fspath(path)!r}"
            )
        watched = about.get("watched")
        numbers = about["statistics"]
        return _Saved(
            about=about,
            t=data["t"],
            q=data["q"],
            v=data["v"],
            steps=[data[f"step_{name}"] for name in _STEPS],
            happened=data["events"],
            names=list(about["events"]),
            watched=None if watched is None else tuple(map(str, watched)),
            method=str(about["method"]),
            smooth=bool(about["smooth"]),
            close=bool(about["close"]),
            statistics=Statistics(int(numbers[0]), int(numbers[1]), *map(float, numbers[2:6])),
        )
    except MecaniqueError:
        raise
    except OSError as error:
        raise InputError(f"cannot read {os.fspath(path)!r}: {error.strerror or error}") from None
    except (
        ArithmeticError,
        MemoryError,
        NotImplementedError,
        RecursionError,
        RuntimeError,
        SyntaxError,
        struct.error,
        zlib.error,
        ValueError,
        KeyError,
        TypeError,
        IndexError,
        AttributeError,
        EOFError,
        zipfile.BadZipFile,
    ) as error:
        raise InputError(
            f"{os.fspath(path)!r} is no motion saved by mecanique, or is damaged ({error})"
        ) from None


def _refuse_bomb(file: IO[bytes]) -> None:
    """Raise ValueError if what a file unpacks to is out of proportion to it; go to its start."""
    size = file.seek(0, os.SEEK_END)
    with zipfile.ZipFile(file) as archive:
        unpacked = sum(member.file_size for member in archive.infolist())
    if unpacked > MOST_UNPACKED + MOST_RATIO * size:
        raise ValueError(f"its {size} bytes unpack to {unpacked}")
    file.seek(0)


def to_csv(motion: Trajectory, path: str | PathLike[str]) -> None:
    """Write t, q, v and a to a CSV file: a header with units, then a row per sample, all digits."""
    header = ",".join(f'"{title}"' if "," in title else title for title in _titles(motion))
    table = np.column_stack([motion.t, motion.q, motion.v, motion.a])

    def write(file: IO[bytes]) -> None:
        file.write(f"{header}\n".encode())
        for row in table.tolist():
            file.write((",".join(map(repr, row)) + "\n").encode())

    _write(Path(path), write)


def to_frame(motion: Trajectory) -> Any:
    """Return q, v and a as a pandas DataFrame over t; units are in `frame.attrs["units"]`."""
    try:
        import pandas as pd
    except ImportError:
        raise InputError(
            "data frames need pandas; install it with: pip install 'mecanique[frames]'"
        ) from None
    frame = pd.DataFrame(
        np.column_stack([motion.q, motion.v, motion.a]),
        index=pd.Index(motion.t, name="t"),
        columns=list(motion.names),
    )
    frame.attrs["units"] = {"t": "s", **_units(motion)}
    return frame


def to_parquet(motion: Trajectory, path: str | PathLike[str]) -> None:
    """Write t, q, v and a to a Parquet file, with the units in the schema's metadata."""
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        raise InputError(
            "Parquet files need pyarrow; install it with: pip install 'mecanique[parquet]'"
        ) from None
    columns = [motion.t, *np.column_stack([motion.q, motion.v, motion.a]).T]
    table = pa.table(
        {name: pa.array(column) for name, column in zip(("t", *motion.names), columns, strict=True)}
    )
    table = table.replace_schema_metadata(
        {"units": json.dumps({"t": "s", **_units(motion)}, ensure_ascii=False)}
    )
    _write(Path(path), lambda file: pq.write_table(table, file))


def _units(motion: Trajectory) -> dict[str, str]:
    known = units(motion.mechanism)
    return known | {f"{name}'": per_second(known[name]) for name in motion.mechanism.velocities}


def _titles(motion: Trajectory) -> list[str]:
    known = _units(motion)
    return ["t [s]", *(add_unit(name, known[name]) for name in motion.names)]


def _write(path: Path, write: Callable[[Any], object]) -> None:
    try:
        with write_whole(path) as file:
            write(file)
    except OSError as error:
        raise InputError(f"cannot write {os.fspath(path)!r}: {error.strerror or error}") from None


def _check_accelerations(motion: Trajectory, path: str) -> None:
    """Refuse a file of another mechanism that has the same names."""
    curve = motion.curve
    at = spread(len(curve.t), 5)
    found_a = motion.reference.acceleration(curve.q[at], curve.v[at], curve.t[at])
    gap = np.abs(found_a - curve.a[at]).max()
    size = 1 + np.abs(curve.a[at]).max()
    if not gap <= ANOTHER * size:
        raise InputError(
            f"{path!r} holds a motion of another mechanism than {motion.mechanism.name!r}: its "
            "accelerations differ by "
            f"{gap:.2g} (of {size:.2g}); give the mechanism, inputs included, that moved"
        )
