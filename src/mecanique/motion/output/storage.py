"""Store motions in npz files; export them as CSV, Parquet and data frames.

A file states where its mechanism comes from, so that it is found again.
"""

from __future__ import annotations

import json
import os
import sys
import zipfile
from collections.abc import Callable
from itertools import islice, product
from os import PathLike
from pathlib import Path
from typing import IO, Any, TypeVar

import numpy as np

from mecanique.arrays import spread
from mecanique.errors import InputError, MecaniqueError
from mecanique.files import write_whole
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import add_unit, per_second, units
from mecanique.motion.record.curve import Curve
from mecanique.motion.record.events import Occurrence
from mecanique.motion.record.rates import Rates
from mecanique.motion.tolerances import ANOTHER
from mecanique.motion.trajectory import Statistics, Trajectory, settle

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

_SHAPES = {
    "t": "samples",
    "q": "samples nq",
    "v": "samples nv",
    "step_t": "steps",
    "step_q": "steps nq",
    "step_v": "steps nv",
    "step_a": "steps nv",
    "step_breaks": "stretches",
    "events": "events width",
}
"""The arrays of a file: samples, steps, and a row (t, q, v, v after it) for each event."""


def save(motion: Trajectory, path: str | PathLike[str]) -> None:
    """Write a motion to an npz file, whole or not at all; nothing in it is pickled."""
    from importlib.metadata import version

    path = Path(path)
    path = path if path.suffix else path.with_suffix(".npz")
    s, m, curve, watched = motion.statistics, motion.mechanism, settle(motion), motion.event_names
    if motion.watched is not None:
        watched = tuple(event.name for event in motion.watched)
    about = {
        "format": FORMAT,
        "mecanique": version("mecanique"),
        "numpy": np.__version__,
        "method": motion.method,
        "statistics": [s.steps, s.evaluations, s.seconds, s.rtol, s.atol, s.share],
        "smooth": curve.smooth,
        "close": curve.close,
        "events": [event.name for event in motion.events],
        "watched": watched,
        **provenance(m),
    }
    happened = [
        np.concatenate([[event.t], event.q, event.v, event.after]) for event in motion.events
    ]
    events = np.array(happened).reshape(-1, 1 + m.nq + 2 * m.nv)
    values = (motion.t, motion.q, motion.v, curve.t, curve.q, curve.v, curve.a, curve.breaks)
    arrays: dict[str, Any] = dict(zip(_SHAPES, (*values, events), strict=True))
    text = np.array(json.dumps(about, ensure_ascii=False))
    _write(path, lambda file: np.savez_compressed(file, about=text, **arrays))


def load(path: str | PathLike[str], mechanism: Mechanism | None, kind: type[_Kind]) -> _Kind:
    """Read a motion that `save` wrote, and check that the mechanism is the file's."""
    name = os.fspath(path)
    try:
        data = read_arrays(path)
        if np.frombuffer(data["about"].tobytes(), np.uint32).max() > sys.maxunicode:
            raise ValueError("its description is no text")
        about = json.loads(str(data["about"]))
        if about["format"] != FORMAT:
            raise InputError(
                f"expected a file of format {FORMAT!r}, got {about['format']!r} in {name!r}"
            )
        # what has lost the mark of an array is read as bytes
        arrays = {name: np.asarray(data[name]) for name in _SHAPES}
        watched, numbers = about.get("watched"), about["statistics"]
        statistics = Statistics(int(numbers[0]), int(numbers[1]), *map(float, numbers[2:6]))
        method, event_names = str(about["method"]), None
        if watched is not None:  # older files do not say
            event_names = tuple(map(str, watched))
        names, smooth, close = list(about["events"]), bool(about["smooth"]), bool(about["close"])
    except InputError:
        raise
    except Exception as error:  # numpy and json may raise anything of hostile bytes
        raise InputError(
            f"{name!r} is no motion saved by mecanique, or is damaged ({error})"
        ) from None
    mechanism = recover(about, mechanism, name)
    if not _fit(arrays, mechanism, len(names)):
        raise InputError(f"{name!r} is damaged: its arrays do not fit each other")
    t, q, v, step_t, step_q, step_v, step_a, breaks, happened = arrays.values()
    curve = Curve(
        t=step_t,
        q=step_q,
        v=step_v,
        a=step_a,
        breaks=breaks,
        rates=Rates.of(mechanism),
        smooth=smooth,
        close=close,
    )
    cut = np.cumsum([1, mechanism.nq, mechanism.nv])
    events = []
    for event, row in zip(names, happened, strict=True):
        time, *state = np.split(row, cut)
        events.append(Occurrence(event, float(time[0]), *state))
    motion = kind(
        mechanism=mechanism,
        t=t,
        q=q,
        v=v,
        path=curve,
        method=method,
        statistics=statistics,
        events=tuple(events),
        event_names=event_names,
    )
    _check_accelerations(motion, name)
    return motion


def _fit(arrays: dict[str, np.ndarray], m: Mechanism, events: int) -> bool:
    """Return whether arrays have the shapes of a mechanism's motion, and times in order."""
    sizes = {"nq": m.nq, "nv": m.nv, "events": events, "width": 1 + m.nq + 2 * m.nv}
    for name, shape in _SHAPES.items():
        array, expected = arrays[name], shape.split()
        whole = array.dtype.kind == "i" if name == "step_breaks" else array.dtype == np.float64
        if not whole or array.ndim != len(expected) or not np.isfinite(array).all():
            return False
        # the first array of samples, steps or stretches says how many there are
        if any(sizes.setdefault(k, n) != n for k, n in zip(expected, array.shape, strict=True)):
            return False
    t, step_t, breaks = arrays["t"], arrays["step_t"], arrays["step_breaks"]
    if not (len(t) and len(step_t) and len(breaks)):
        return False
    inside = breaks[0] == 0 and (np.diff(breaks) > 0).all() and breaks[-1] < len(step_t)
    return bool(inside and (np.diff(t) > 0).all() and (np.diff(step_t) >= 0).all())


def read_arrays(path: str | PathLike[str]) -> dict[str, np.ndarray]:
    """Return the arrays of an npz file; refuse one that unpacks to far more than its size."""
    try:
        # NumPy leaves a file that it opened itself open if it is damaged
        with open(path, "rb") as file:
            size = file.seek(0, os.SEEK_END)
            with zipfile.ZipFile(file) as archive:
                unpacked = sum(member.file_size for member in archive.infolist())
            if unpacked > MOST_UNPACKED + MOST_RATIO * size:
                raise ValueError(f"its {size} bytes unpack to {unpacked}")
            file.seek(0)
            arrays = np.load(file, allow_pickle=False)
            return {name: arrays[name] for name in arrays.files}
    except OSError as error:
        raise InputError(f"cannot read {os.fspath(path)!r}: {error.strerror or error}") from None


def to_csv(motion: Trajectory, path: str | PathLike[str]) -> None:
    """Write t, q, v and a to a CSV file: a header with units, then a row per sample, all digits."""
    known = _units(motion)
    titles = ["t [s]", *(add_unit(name, known[name]) for name in motion.names)]
    header = ",".join(f'"{title}"' if "," in title else title for title in titles)
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
