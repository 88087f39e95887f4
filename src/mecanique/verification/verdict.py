"""The outcome of a comparison: what agrees, how well, and where it is worst."""

from __future__ import annotations

import json
import math
import platform
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from html import escape
from typing import Any, final

import numpy as np

from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.origin import Finding
from mecanique.reference.engine.package import MISSING, STAND_IN, engine_package, has_pinocchio
from mecanique.version import __version__
from mecanique.wording import Legible, enumerate_words, say_count, write_table

_MOST_CHANGES = 40
"""As many changes stand in the text; JSON has all of them."""


@final
@dataclass(frozen=True, repr=False)
class Change(Legible):
    """One difference between two descriptions, a `Cause`."""

    where: str  # the link or joint, e.g. "link 'arm'"; empty for the whole
    what: str  # what differs, e.g. "mass"
    before: str = ""  # in the first, as words
    after: str = ""  # in the second, as words
    slip: str = ""  # the mistake it looks like, or empty
    # relative change of the mass matrix and the bias that it alone makes; NaN if it was not
    # applied alone, as with what is added or removed
    weight: float = float("nan")

    @property
    def kind(self) -> str:
        """What differs, as of any `Cause`."""
        return self.what

    @property
    def text(self) -> str:
        """What differs and how, as of any `Cause`."""
        values = f" {self.before} → {self.after}" if self.before or self.after else ""
        return f"{self.what}{values}: {self.slip}" if self.slip else self.what + values

    def __str__(self) -> str:
        return f"{self.where}: {self.text}" if self.where else self.text

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data; a weight that is not known is None."""
        known = self.weight == self.weight
        return {**asdict(self), "weight": self.weight if known else None}


@final
@dataclass(frozen=True, repr=False)
class Difference(Legible):
    """What differs between two descriptions, the structure first, then by weight.

    Args:
        first: name of the first.
        second: name of the second.
        changes: what differs.
        notes: what was not compared.

    Example:
        >>> light, heavy = (mq.textbook.load("double_pendulum", m2=m) for m in (1.0, 1.5))
        >>> difference = mq.diff(light, heavy)
        >>> difference.same
        False
        >>> print(difference.changes[0])
        link 'rod2': mass 1 → 1.5 kg (+50 %)
    """

    first: str
    second: str
    changes: tuple[Change, ...]
    notes: tuple[str, ...] = ()

    @property
    def same(self) -> bool:
        """Whether nothing differs."""
        return not self.changes

    @property
    def summary(self) -> str:
        """The outcome in one sentence."""
        names = f"{self.first} and {self.second}"
        if self.same:
            return f"{names} describe the same mechanism"
        slips = sum(bool(change.slip) for change in self.changes)
        likely = f", {say_count(slips, 'likely slip')}" if slips else ""
        return f"{names}: {say_count(len(self.changes), 'difference')}{likely}"

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data, ready for JSON."""
        rows = [change.to_dict() for change in self.changes]
        head = {"first": self.first, "second": self.second, "same": self.same}
        return {**head, "changes": rows, "notes": list(self.notes)}

    def to_json(self) -> str:
        """Return everything as JSON text."""
        return json.dumps(self.to_dict(), ensure_ascii=False, allow_nan=False, indent=2)

    def __str__(self) -> str:
        lines = []
        for change in self.changes[:_MOST_CHANGES]:
            known = change.weight == change.weight
            weight = f"{100 * change.weight:8.2g} %" if known else " " * 10
            lines.append(f"{weight}  {change}")
        rest = len(self.changes) - _MOST_CHANGES
        if rest > 0:
            lines.append(f"… and {rest} more in to_json(), --json")
        head = [" of M, bias"] if any(c.weight == c.weight for c in self.changes) else []
        return "\n".join([self.summary, *head, *lines, *self.notes])


READ_ALIKE = 1e-6
"""A larger relative difference is one of what was read, not of how it is computed."""

_MOST_LISTED = 6
"""As many sentences on one engine's reading stand in the text of a verdict."""


@final
@dataclass(frozen=True)
class EngineReading:
    """What an engine makes of the file itself."""

    engine: str  # its name, e.g. "Pinocchio 4.1.0"
    # the largest relative difference in mass matrix and bias; None if it was not compared
    worst: float | None
    refused: str = ""  # why the engine does not read the file, or empty
    remarks: tuple[str, ...] = ()  # what differs, with lines and reasons
    missing: str = ""  # what to install so that the engine can read the file, or empty
    alike: tuple[str, ...] = ()  # the other sources that read the same, "mecanique" among them

    @property
    def differs(self) -> bool:
        """Whether it reads something else than mecanique."""
        return self.worst is not None and not self.worst <= READ_ALIKE

    @property
    def said(self) -> str:
        """What it does with the file in a few words; empty if it reads it as mecanique does."""
        if self.missing:
            return f"{self.engine} did not read the file: it is not installed"
        if self.refused:
            return f"{self.engine} refuses the file itself"
        return f"{self.engine} reads the file itself otherwise" if self.differs else ""

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data, ready for JSON."""
        known = self.worst is not None and math.isfinite(self.worst)
        return {**asdict(self), "worst": self.worst if known else None, "differs": self.differs}

    def sentences(self) -> tuple[str, ...]:
        """Return the remarks on it; none if it reads the file as mecanique does."""
        head = self.said
        if self.missing:
            return (f"{head} ({self.missing})",)
        if self.refused:
            return (f"{head}: {self.refused}", *self.remarks)
        if not self.differs:
            return ()
        if self.worst is not None and math.isfinite(self.worst):
            head += f": its M and bias differ by up to {100 * self.worst:.2g} %"
        rest = len(self.remarks) - _MOST_LISTED
        more = (f"… and {say_count(rest, 'remark')} more in --json",) if rest > 0 else ()
        return (head, *self.remarks[:_MOST_LISTED], *more)


OURS = "mecanique"
"""What it is called among the sources that read a file."""


def dissenters_among(readings: Sequence[EngineReading]) -> tuple[str, ...]:
    """Return the sources that read a file otherwise than most; empty without a majority."""
    groups = {r.engine: {r.engine, *r.alike} for r in readings if r.worst is not None}
    groups[OURS] = {OURS, *(name for name, group in groups.items() if OURS in group)}
    largest = max(groups.values(), key=len)
    if 2 * len(largest) <= len(groups):
        return ()
    return tuple(name for name in groups if name not in largest)


REMOVED = 1e-8
"""A relative difference below this counts as removed."""


@final
@dataclass(frozen=True, repr=False)
class LikelyCause(Legible):
    """A change of the mechanism that explains a difference, a `Cause`."""

    kind: str  # of the mistake, e.g. "armature"
    where: str  # link, joint or coordinate; empty for the whole mechanism
    text: str  # what the other source seems to do, in words
    before: float  # relative difference without the change
    after: float  # relative difference with it
    # what explains the difference as well and cannot be told apart from it
    alike: tuple[LikelyCause, ...] = ()
    # the two mistakes that explain it together, if no single one does
    parts: tuple[LikelyCause, ...] = ()

    @property
    def removes(self) -> bool:
        """Whether the change removes the difference."""
        return self.after <= REMOVED

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data."""
        nested = {
            "alike": [cause.to_dict() for cause in self.alike],
            "parts": [cause.to_dict() for cause in self.parts],
        }
        return {**asdict(self), **nested}

    def __str__(self) -> str:
        left = f"the difference falls from {self.before:.1e} to {self.after:.1e}"
        others = (
            f"; cannot be told apart from: {'; '.join(cause.text for cause in self.alike)}"
            if self.alike
            else ""
        )
        return f"{self.text} ({left}){others}"


NOT_INSTALLED = "not installed"
"""The version of an engine that is missing."""

SOLVED_ALIKE = 1e-9
"""Largest relative difference that counts as agreement of what is solved for, or has forces."""

_FEW = 4
"""States of more coordinates than this are no reading: they are given on request."""

_MOST_FLAWS = 10
"""As many flaws of a description stand in the text of a verdict; JSON has all of them."""

_UNEXPLAINED = "no single change among those tried removes the difference"


@final
@dataclass(frozen=True)
class Row:
    """One quantity from two sources."""

    quantity: str  # what is compared, e.g. "mass matrix"
    sources: tuple[str, str]  # the two sources, e.g. ("jets", "Pinocchio")
    # the relative difference at the state where it is largest compared with what is allowed
    # there; infinite if a source gave a value that is not finite
    worst: float
    q: tuple[float, ...]  # coordinates where it occurs, shape (nq,)
    v: tuple[float, ...]  # velocities where it occurs, shape (nv,)
    t: float  # time where it occurs [s]
    remark: str = ""  # what else is to be known, or empty
    # relative difference that rounding alone explains there, from the conditioning of what is
    # solved, or the terms of the entry; 0 if it is not known
    rounding: float = 0.0
    # names of the velocities, or the axis, of the entry where it is, if any
    entry: tuple[str, ...] = ()
    by_entry: bool = False  # whether each entry is judged by itself, by the terms that it sums
    # what counts as agreement however little rounding explains; 0 if rounding alone decides
    tolerance: float = SOLVED_ALIKE

    def __post_init__(self) -> None:
        # a NaN compares false with everything and would be lost by max(): it counts as infinitely
        # wrong
        object.__setattr__(self, "worst", math.inf if math.isnan(self.worst) else float(self.worst))

    @property
    def allowed(self) -> float:
        """The largest difference that agrees: the tolerance, or what rounding makes."""
        return max(self.tolerance, self.rounding)

    @property
    def agrees(self) -> bool:
        """Whether the difference is within what is allowed."""
        return self.worst <= self.allowed


@final
@dataclass(frozen=True, repr=False)
class Verdict(Legible):
    """Whether independent sources give the same equations of motion.

    Args:
        mechanism: name of the mechanism.
        rows: one per quantity and pair of sources.
        samples: number of states.
        seed: of the random states.
        tolerance: largest relative difference that counts as agreement wherever rounding explains
            less; rows whose `tolerance` is 0 are judged by rounding alone.
        coordinates: names of the generalized coordinates.
        velocities: names of the generalized velocities.
        versions: of mecanique and what it stands on, by name.
        notes: what was left out of the comparison, and why.
        causes: likely causes of a disagreement, the likeliest first.
        given: where the states are from, if they are not random.
        flaws: errors in the description that its equations do without.
        readings: what engines make of the file itself that the mechanism was read from.
        difference: what differs between two descriptions that were compared.

    Example:
        >>> verdict = mq.verify(mq.textbook.load("rigid_bar_pendulum"), samples=5)
        >>> verdict.agrees, verdict.worst < 1e-9
        (True, True)
        >>> verdict.rows[0].quantity
        'mass matrix'
    """

    mechanism: str
    rows: tuple[Row, ...]
    samples: int
    seed: int
    tolerance: float
    coordinates: tuple[str, ...]
    velocities: tuple[str, ...]
    versions: Mapping[str, str]
    notes: tuple[str, ...] = ()
    causes: tuple[LikelyCause, ...] = ()
    given: str = ""
    flaws: tuple[Finding, ...] = ()
    readings: tuple[EngineReading, ...] = ()
    difference: Difference | None = None

    def with_causes(self, causes: tuple[LikelyCause, ...]) -> Verdict:
        """Return this verdict with likely causes of its differences; a note if there are none."""
        notes = self.notes if causes else (*self.notes, _UNEXPLAINED)
        return replace(self, causes=causes, notes=notes)

    @property
    def worst(self) -> float:
        """The largest relative difference; infinite if a value is not finite or none is there."""
        return max((row.worst for row in self.rows), default=math.inf)

    @property
    def agrees(self) -> bool:
        """Whether every difference is within what is allowed, and engines read the file alike."""
        differ = any(reading.differs for reading in self.readings)
        return bool(self.rows) and all(row.agrees for row in self.rows) and not differ

    @property
    def dissenters(self) -> tuple[str, ...]:
        """Who reads the file otherwise than most of all engines and mecanique; empty if none is."""
        return dissenters_among(self.readings)

    @property
    def summary(self) -> str:
        """The verdict in one sentence."""
        where = (
            f"{say_count(self.samples, 'state')} of {self.given}" if self.given else self._random
        )
        also = [f"{say_count(len(self.flaws), 'flaw')} in its description"] if self.flaws else []
        also += [r.said for r in self.readings if r.said and not r.differs]
        rest = "".join(f"; {remark}" for remark in also)
        if self.agrees:
            agreed = f"{self.mechanism}: agrees at {where}"
            return f"{agreed}, worst relative difference {self.worst:.1e}{rest}"
        rows = [row for row in self.rows if not row.agrees]
        bad = dict.fromkeys(row.quantity for row in rows)
        allowed = max((row.allowed for row in rows), default=self.tolerance)
        differ = [reading.said for reading in self.readings if reading.differs]
        names = ", ".join([*bad, *differ]) or "nothing was compared"
        said = f"{self.mechanism}: DISAGREES at {where}: {names} "
        return f"{said}(tolerance {allowed:.0e}){rest}"

    @property
    def _random(self) -> str:
        return f"{say_count(self.samples, 'random state')} (seed {self.seed})"

    def to_json(self) -> str:
        """Return everything as JSON text; a difference that is not finite is null."""
        return json.dumps(self.to_dict(), ensure_ascii=False, allow_nan=False, indent=2)

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data, ready for JSON; what is not finite is None."""
        return {
            "mechanism": self.mechanism,
            "agrees": self.agrees,
            "worst": _number(self.worst),
            "tolerance": self.tolerance,
            "samples": self.samples,
            "seed": self.seed,
            "rows": [
                {
                    "quantity": row.quantity,
                    "sources": list(row.sources),
                    "worst": _number(row.worst),
                    "agrees": row.agrees,
                    "tolerance": row.allowed,
                    "entry": list(row.entry),
                    "q": dict(zip(self.coordinates, map(_number, row.q), strict=True)),
                    "v": dict(zip(self.velocities, map(_number, row.v), strict=True)),
                    "t": row.t,
                    "remark": row.remark,
                }
                for row in self.rows
            ],
            "notes": list(self.notes),
            "causes": [cause.to_dict() for cause in self.causes],
            "flaws": [asdict(flaw) for flaw in self.flaws],
            "difference": None if self.difference is None else self.difference.to_dict(),
            "readings": [reading.to_dict() for reading in self.readings],
            "versions": dict(self.versions),
        }

    def state(self, row: Row) -> str:
        """Return the state where a row is worst, e.g. "q = 1.23, q' = -0.5, t = 0".

        Args:
            row: one of the rows.
        """
        names = (*self.coordinates, *self.velocities, "t")
        values = (*row.q, *row.v, row.t)
        return ", ".join(f"{name} = {value:.6g}" for name, value in zip(names, values, strict=True))

    @property
    def table(self) -> tuple[tuple[str, ...], ...]:
        """Worst relative differences as words: a head, a line per quantity, a column per pair."""
        pairs = tuple(dict.fromkeys(row.sources for row in self.rows))
        others = {second for _, second in pairs}
        heads = [first if len(others) == 1 else f"{first} = {second}" for first, second in pairs]
        what = f"difference from {others.pop()}" if len(others) == 1 else "relative difference"
        worst = {(row.quantity, row.sources): row for row in self.rows}
        lines = []
        for quantity in dict.fromkeys(row.quantity for row in self.rows):
            cells = (self._cell(worst.get((quantity, pair))) for pair in pairs)
            lines.append((quantity, *cells))
        return ((what, *heads), *lines)

    @property
    def remarks(self) -> tuple[str, ...]:
        """Remarks: where the sources disagree, the likely causes, what was left out."""
        known = self.causes[0].alike if self.causes else ()
        causes = [cause for cause in self.causes if cause not in known]
        lines = [f"likely cause {k}: {cause}" for k, cause in enumerate(causes, 1)]
        lines += [sentence for reading in self.readings for sentence in reading.sentences()]
        if dissenters := self.dissenters:
            sources = (OURS, *(r.engine for r in self.readings if r.worst is not None))
            others = enumerate_words([name for name in sources if name not in dissenters])
            alone = "stands alone" if len(dissenters) == 1 else "stand apart"
            lines.append(f"{enumerate_words(dissenters)} {alone}: {others} read the file alike")
        alike = [r.engine for r in self.readings if r.worst is not None and not r.differs]
        if not dissenters and any(not name.startswith("Pinocchio") for name in alike):
            lines.append(f"{enumerate_words([OURS, *alike])} read the file itself alike")
        short = len(self.coordinates) <= _FEW and self.difference is None
        for row in self.rows:
            pair = f"{row.quantity}, {' and '.join(row.sources)}"
            if row.remark:
                lines.append(f"{pair}: {row.remark}")
            if row.rounding > self.tolerance and not row.by_entry:
                where = f" at {self.state(row)}" if short else ""
                rounding = f"rounding may make {row.rounding:.1e}"
                lines.append(f"{pair}: {rounding}, from the conditioning{where}")
            if not row.agrees:
                entry = f" in entry ({', '.join(row.entry)})" if row.entry else ""
                more = f", rounding may make {row.rounding:.1e}," if row.by_entry else ""
                if short:
                    lines.append(f"{pair}: worst{entry}{more} at {self.state(row)}")
                elif entry:
                    lines.append(f"{pair}: worst{entry}{more}")
        lines += self._by_entry
        if not short and not all(row.agrees for row in self.rows):
            lines.append("the states where they differ most: worst_states, --states")
        return (*lines, *self.notes, *self._flaws)

    @property
    def worst_states(self) -> tuple[str, ...]:
        """Where what disagrees is worst, quantity by quantity, with the whole state."""
        return tuple(
            f"{row.quantity}, {' and '.join(row.sources)}: worst at {self.state(row)}"
            for row in self.rows
            if not row.agrees
        )

    @property
    def _flaws(self) -> tuple[str, ...]:
        listed = [f"flaw in line {f.line}: {f.sentence}. {f.remedy}" for f in self.flaws]
        if len(listed) > _MOST_FLAWS:
            rest = len(listed) - _MOST_FLAWS
            listed[_MOST_FLAWS:] = [f"… and {say_count(rest, 'flaw')} more; mecanique lint has all"]
        return tuple(listed)

    @property
    def _by_entry(self) -> list[str]:
        """What is judged entry by entry, and how strictly."""
        rows = [row for row in self.rows if row.by_entry]
        if not rows:
            return []
        names = ", ".join(dict.fromkeys(row.quantity for row in rows))
        most = max(row.rounding for row in rows)
        allowed = "what rounding may make of its terms"
        if any(row.tolerance for row in rows):
            allowed = f"the tolerance, or {allowed}"
        return [f"judged entry by entry, each within {allowed}, here up to {most:.0e}: {names}"]

    def __str__(self) -> str:
        widths = [max(map(len, column)) for column in zip(*self.table, strict=True)]
        lines = ["  ".join(map(str.ljust, line, widths)).rstrip() for line in self.table]
        first = [] if self.difference is None else [str(self.difference)]
        return "\n".join([*self._missing, *first, self.summary, *lines, *self.remarks])

    @property
    def _missing(self) -> list[str]:
        """The first remark of a verdict given without the engine."""
        return [MISSING] if any(STAND_IN in row.sources for row in self.rows) else []

    def _repr_html_(self) -> str:
        caption = " ".join([*self._missing, self.summary])
        remarks = "".join(f"<p>{escape(remark)}</p>" for remark in self.remarks)
        return write_table(caption, self.table) + remarks

    def _cell(self, row: Row | None) -> str:
        if row is None:
            return ""
        worst = f"{row.worst:.1e}" if math.isfinite(row.worst) else "not finite"
        return worst if row.agrees else f"{worst} !"


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def conclude(
    mechanism: Mechanism,
    rows: Iterable[Row],
    samples: int,
    seed: int,
    tolerance: float,
    *,
    notes: tuple[str, ...] = (),
) -> Verdict:
    """Return the verdict on a mechanism that rows lead to."""
    return Verdict(
        mechanism=mechanism.name,
        rows=tuple(rows),
        samples=samples,
        seed=seed,
        tolerance=tolerance,
        coordinates=mechanism.coordinates.names,
        velocities=mechanism.velocities,
        versions=versions(),
        notes=notes,
        flaws=mechanism.origin.flaws if mechanism.origin else (),
    )


def versions() -> dict[str, str]:
    """Return the versions of the programs involved, by name."""
    return {
        "mecanique": __version__,
        "numpy": np.__version__,
        "pin": str(engine_package().__version__) if has_pinocchio() else NOT_INSTALLED,
        "python": platform.python_version(),
    }
