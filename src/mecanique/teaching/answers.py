"""Answers of a class, read so that what one student hands in never stops the others."""

from __future__ import annotations

import codecs
import json
import os
import stat
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, final
from unicodedata import category

from mecanique.errors import InputError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

_TEXTS = (".txt", ".tex", ".mml", ".md")
_TABLES = (".toml", ".json")
_LONGEST_TEXT, _LONGEST_TABLE = 80_000, 1_000_000
"""Bytes; the checker takes 20,000 characters."""


@final
@dataclass(frozen=True)
class Submission:
    """What a student handed in."""

    student: str  # the name, of the folder or of the table
    texts: dict[str, str] = field(default_factory=dict)  # the answers, by question
    # why an answer cannot be read, by question
    faults: dict[str, str] = field(default_factory=dict)
    fault: str = ""  # why none can, or ""


def read_table(path: Path) -> dict[str, Any]:
    """Return what a TOML or JSON file holds."""
    text = _read(path, _LONGEST_TABLE)
    try:
        if path.suffix.lower() == ".json":
            table = json.loads(text, object_pairs_hook=_unite)
        else:
            table = tomllib.loads(text)
    except RecursionError:
        raise InputError(f"{_name(path)} cannot be read: it is nested too deeply") from None
    except ValueError as error:
        raise InputError(f"{_name(path)} cannot be read: {error}") from None
    if not isinstance(table, dict):
        raise InputError(f"expected a table in {_name(path)}, got a {type(table).__name__}")
    return table


def collect(folder: Path, questions: Sequence[str]) -> list[Submission]:
    """Return what each student handed in, by name, from a folder of folders or tables."""
    if not folder.is_dir():
        raise InputError(f"expected a folder of answers, got {str(folder)!r}")
    places: dict[str, list[Path]] = {}
    for path in sorted(folder.iterdir(), key=lambda path: os.fsencode(path.name)):
        if path.name.startswith((".", "__MACOSX")):
            continue  # what file managers and archives leave behind
        if path.suffix.lower() in _TABLES and not _is_folder(path):
            places.setdefault(_display(path.stem), []).append(path)
        elif _is_folder(path) or path.is_symlink():
            places.setdefault(_display(path.name), []).append(path)
    return [_submission(student, folders, questions) for student, folders in places.items()]


def _submission(student: str, places: list[Path], questions: Sequence[str]) -> Submission:
    try:
        path = _only(places)
        if _is_folder(path):
            return _read_folder(student, path, questions)
        table = read_table(path)
    except (InputError, OSError) as error:
        return Submission(student, fault=str(error))
    texts, faults = {}, {}
    for question in questions:
        value = table.get(question, "")
        if isinstance(value, (str, int, float)):
            texts[question] = str(value)
        else:
            faults[question] = f"expected a text in {_name(path)}, got a {type(value).__name__}"
    return Submission(student, texts, faults)


def _read_folder(student: str, folder: Path, questions: Sequence[str]) -> Submission:
    places: dict[str, list[Path]] = {}
    texts, faults = {}, {}
    by_name = {question.casefold(): question for question in questions}
    for path in sorted(folder.iterdir()):
        question = path.stem if path.stem in questions else by_name.get(path.stem.casefold(), "")
        if question and path.suffix.lower() in _TEXTS:
            places.setdefault(question, []).append(path)
        elif question:
            faults[question] = f"expected a text ({', '.join(_TEXTS)}), got {_name(path)}"
    for question, paths in places.items():
        try:
            texts[question] = _read(_only(paths), _LONGEST_TEXT)
            faults.pop(question, None)
        except (InputError, OSError) as error:
            faults[question] = str(error)
    return Submission(student, texts, faults)


def _only(places: list[Path]) -> Path:
    """Return the one place of several; whichever of two is meant is not guessed."""
    if len(places) > 1:
        raise InputError(f"expected one of {', '.join(map(_name, places))}, got them all")
    if places[0].is_symlink():
        raise InputError(f"{_name(places[0])} is a link; links are not followed")
    return places[0]


def _read(path: Path, most: int) -> str:
    # a pipe or a device would make an ordinary open wait, or never end
    waiting = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    try:
        descriptor = os.open(path, os.O_RDONLY | waiting)
        with os.fdopen(descriptor, "rb") as file:
            if not stat.S_ISREG(os.fstat(descriptor).st_mode):
                raise InputError(f"{_name(path)} is no regular file")
            data = file.read(most + 1)
    except IsADirectoryError:
        raise InputError(f"{_name(path)} is a folder, not a file") from None
    except OSError as error:
        raise InputError(f"{_name(path)} cannot be read: {error.strerror}") from None
    if len(data) > most:
        raise InputError(f"{_name(path)} is longer than {most:,} bytes")
    return _decode(data, path)


def _decode(data: bytes, path: Path) -> str:
    """Return a file's text: UTF-8, UTF-16 with its mark, or an answer from an old editor."""
    code = "utf-8-sig"
    if data.startswith((codecs.BOM_UTF32_LE, codecs.BOM_UTF32_BE)):
        code = "utf-32"  # whose mark begins as that of UTF-16
    elif data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        code = "utf-16"
    elif b"\0" in data:
        raise InputError(f"{_name(path)} is no text; save it as UTF-8")
    try:
        return data.decode(code)
    except UnicodeDecodeError:
        if code != "utf-8-sig" or path.suffix.lower() in _TABLES:
            raise InputError(f"{_name(path)} cannot be read: it is not UTF-8") from None
    return data.decode("cp1252", "replace")


def _unite(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return a table of JSON, in which no name may stand twice."""
    table = dict(pairs)
    if len(table) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"{twice!r} stands twice")
    return table


def _is_folder(path: Path) -> bool:
    return path.is_dir() and not path.is_symlink()


def _name(path: Path) -> str:
    return _display(path.name)


def _display(name: str) -> str:
    """Return a file's name as text, with escapes for bytes that are not UTF-8."""
    return write_visibly(os.fsencode(name).decode("utf-8", "backslashreplace"))


def write_visibly(text: str) -> str:
    """Return a text with control characters and halves of surrogates written as escapes."""
    return "".join(
        c if c in "\n\t" or category(c) not in ("Cc", "Cs") else f"\\x{ord(c):02x}" for c in text
    )
