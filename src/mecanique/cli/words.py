"""Interpret the words of a command: a system, numbers by name, a motion to simulate."""

from __future__ import annotations

import errno
import functools
import math
import runpy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar, final

from click.exceptions import Exit

import mecanique as mq
from mecanique.cli.options import FileOptions, reads_files
from mecanique.cli.printing import complain, inform, progress

if TYPE_CHECKING:
    from mecanique.motion.motion import Motion


P = ParamSpec("P")
R = TypeVar("R")

_PLAINLY = FileOptions()


@final
@dataclass(frozen=True)
class Chosen:
    """The mechanism a command works on, and the motion that its words describe."""

    mechanism: mq.Mechanism
    system: str  # the word that names it
    reading: FileOptions
    q: Sequence[str] = ()  # as given after -q
    v: Sequence[str] = ()
    start: dict[str, float] = field(default_factory=dict)  # position, with what is given
    velocity: dict[str, float] = field(default_factory=dict)
    duration: float = 10.0  # of the motion [s]
    given: Sequence[str] = ()  # symbols of the parameters after -p

    def tell_omissions(self) -> None:
        """Say what the reader of a file has left out, which is in no verdict."""
        if self.mechanism.origin is not None and self.mechanism.about:
            inform(self.mechanism.about)


def choose(
    system: str,
    parameters: Sequence[str] = (),
    reading: FileOptions = _PLAINLY,
    q: Sequence[str] = (),
    v: Sequence[str] = (),
) -> Chosen:
    """Return the mechanism that a word names: a textbook system, else a file, else a robot."""
    values = numbers(parameters, "-p")
    start, velocity = numbers(q, "-q"), numbers(v, "-v")
    if mq.textbook.catalogue.is_known(system):
        for option, given in (
            ("--root floating", reading.root == "floating"),
            ("--loops", reading.loops is not None),
            ("--arg", reading.arguments),
            ("--keep", reading.keep),
        ):
            if given:
                raise mq.InputError(
                    f"expected a URDF file or a robot for {option}, got the system {system!r}"
                )
        entry = mq.textbook.entry(system)
        mechanism, duration = mq.textbook.load(system, **values), entry.duration
        start, velocity = {**entry.start, **start}, {**entry.start_velocity, **velocity}
    else:
        mechanism, duration = reading.read(find_file(system, reading)), Chosen.duration
        mechanism = mechanism.replace(**values) if values else mechanism
    rates = {name.removesuffix("'"): value for name, value in velocity.items()}
    return Chosen(
        mechanism=mechanism,
        system=system,
        reading=reading,
        q=q,
        v=v,
        start=start,
        velocity=rates,
        duration=duration,
        given=tuple(values),
    )


def find_file(system: str, reading: FileOptions = _PLAINLY) -> Path:
    """Return the file of a description that a word names."""
    from mecanique.formats.locate import list_deeper, locate
    from mecanique.formats.scope import SCOPES

    path, robots = locate(system, reading.package_path or None), mq.robots()
    if path is not None:
        if deeper := list_deeper(system, path):
            more = f" and {len(deeper) - 1} more" if len(deeper) > 1 else ""
            inform(f"Reading {path}; name {deeper[0]}{more}, deeper in the folder, to read them")
        return path
    suffixes = (".xacro", *(suffix for scope in SCOPES.values() for suffix in scope.suffixes))
    folders = {known.partition("/")[0] for known in robots if "/" in known}
    if system.endswith(suffixes) or ("/" in system and system.partition("/")[0] not in folders):
        raise mq.InputError(f"expected a URDF, MJCF or SDF file, but there is no file {system!r}")
    try:
        return mq.robot(system)
    except mq.UnknownNameError:
        raise mq.UnknownNameError(
            "system", system, (*mq.textbook.names(), *mq.textbook.names(corners=True), *robots)
        ) from None


def source(
    word: str, reading: FileOptions
) -> Mapping[str, Callable[..., Any]] | Path | mq.Mechanism:
    """Return the source to compare a mechanism with."""
    from mecanique.verification.foreign import Functions

    path = Path(word)
    if path.suffix.lower() in (".csv", ".fmu", ".so", ".dylib", ".dll"):
        return path
    if path.suffix != ".py":
        known = mq.textbook.catalogue.is_known(word)
        return choose(word, reading=_PLAINLY if known else reading).mechanism
    if not path.is_file():
        raise mq.InputError(f"expected a Python file, but there is no file {word!r}")
    try:
        defined = runpy.run_path(word)
    except (Exception, SystemExit) as error:
        # an exit of the file would end this program as if all agreed
        raise mq.InputError(f"{word} raised {type(error).__name__}: {error}") from error
    answers = ("M", "C", "g", *(item.name for item in fields(Functions) if item.name != "by"))
    functions = {name: defined[name] for name in answers if callable(defined.get(name))}
    if not functions:
        raise mq.InputError(f"expected functions among {', '.join(answers)} in {word}, found none")
    return functions


def numbers(words: Sequence[str], option: str) -> dict[str, float]:
    """Return the numbers of words like "name=value"."""
    values: dict[str, float] = {}
    for word in words:
        name, sign, text = word.partition("=")
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not (name.strip() and sign and math.isfinite(value)):
            raise mq.InputError(
                f"expected NAME=VALUE with a finite number after {option}, e.g. l=2.0, got {word!r}"
            )
        values[name.strip()] = value
    return values


def simulate_motion(
    chosen: Chosen, duration: float | None, rtol: float, limits: str | None = None
) -> Motion:
    """Simulate the motion that the words describe."""
    try:
        bounce = limits if limits in (None, "stop") else float(limits or "")
    except ValueError:
        raise mq.InputError(
            f"expected stop or a number in 0…1 after --limits, got {limits!r}"
        ) from None
    seconds = chosen.duration if duration is None else duration
    with progress(f"Simulating {seconds:g} s") as advance:
        return mq.simulate(
            chosen.mechanism,
            q=chosen.start,
            v=chosen.velocity,
            duration=seconds,
            rtol=rtol,
            limits=bounce,
            progress=advance,
        )


def report_errors(command: Callable[P, R]) -> Callable[P, R]:
    """Report errors that the user can correct in one message."""

    @functools.wraps(command)
    def safe(*args: P.args, **kwargs: P.kwargs) -> R:
        try:
            return command(*args, **kwargs)
        except mq.MecaniqueError as error:
            complain(str(error))
            if isinstance(error.__cause__, KeyboardInterrupt):
                raise Exit(130) from None
        except KeyboardInterrupt:
            raise Exit(130) from None
        except BrokenPipeError:
            raise
        except OSError as error:
            unnamed = "standard output" if error.errno == errno.ENOSPC else "a file"
            complain(f"{error.filename or unnamed}: {error.strerror or error}")
        raise Exit(2)

    return safe


def takes_system(command: Callable[..., R]) -> Callable[..., R]:
    """Give a command the options of reading; it takes SYSTEM, -p, -q and -v as `chosen`."""

    @report_errors
    @reads_files
    @functools.wraps(command)
    def takes(
        *args: Any,
        system: str,
        parameters: Sequence[str],
        reading: FileOptions,
        q: Sequence[str] = (),
        v: Sequence[str] = (),
        **kwargs: Any,
    ) -> R:
        return command(*args, chosen=choose(system, parameters, reading, q, v), **kwargs)

    return takes
