"""Files that are written whole or not at all, and files that are not what their name says."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from secrets import token_hex
from typing import IO

from mecanique.errors import InputError

_PAGE = "Save the file itself, not the page that shows it."
_MISTAKEN = (
    (b"<!doctype html", "a web page", _PAGE),
    (b"<html", "a web page", _PAGE),
    (
        b"version https://git-lfs",
        "a pointer of Git LFS to the file",
        "Fetch the file itself: git lfs pull.",
    ),
    (b"pk\x03\x04", "a zip archive", "Unpack it first."),
    (b"\x1f\x8b", "compressed by gzip", "Unpack it first."),
)
"""How files begin that are often taken for others, what they are, and what to do."""

UNPACKED: dict[str, str] = {}
"""Archives by the folders that they are unpacked into."""


def name_file(file: str) -> str:
    """Return what a user calls a file: one of an archive stands in that, not where it is kept."""
    for folder, archive in UNPACKED.items():
        if file.startswith(folder):
            return archive + file.removeprefix(folder)
    return file


def stem_of(name: str) -> str:
    """Return the stem of a file called after a mechanism, in any system's current folder."""
    stem = re.sub(r"[^\w.-]+", "_", name)[:80].strip("._") or "mechanism"
    # devices of Windows, whatever ending they have
    device = re.fullmatch(r"(con|prn|aux|nul|(com|lpt)\d)(\..*)?", stem, re.IGNORECASE)
    return f"{stem}_" if device else stem


@contextmanager
def write_whole(path: Path) -> Iterator[IO[bytes]]:
    """Open a new file that takes a path's place at the end of the block, unless the block raises.

    A link is followed; a device or a pipe is written to, as it has no place to take.
    """
    path = path.resolve() if path.is_symlink() else path
    whole = path.is_file() or not path.exists()
    beside = path.parent / f".{path.name}.{token_hex(6)}.part"
    try:
        with beside.open("xb") if whole else path.open("wb") as file:
            yield file
            if not whole:
                return
            # a name must not stand for a content that a crash may still lose
            file.flush()
            os.fsync(file.fileno())
        os.replace(beside, path)
    except OSError as error:
        if error.filename in (None, str(beside), beside):
            # writing names no file, and opening one that nobody has heard of
            error.filename = str(path)
        raise
    finally:
        beside.unlink(missing_ok=True)


def require_directory(path: str | os.PathLike[str]) -> Path:
    """Return a path to write to, whose directory exists."""
    target = Path(path)
    if not target.parent.is_dir():
        raise InputError(f"expected a path in a directory that exists, got {os.fspath(path)!r}")
    return target


def write_text(path: str | os.PathLike[str], text: str) -> Path:
    """Write text to a file as a whole or not at all, and return its path."""
    target = require_directory(path)
    with write_whole(target) as file:
        file.write(text.encode())
    return target


def as_bytes(content: str | bytes) -> bytes:
    """Return what is written to a file."""
    return content.encode() if isinstance(content, str) else content


def recognize(content: bytes) -> tuple[str, str] | None:
    """Return what a file is that was taken for another, and a remedy; None for anything else."""
    head = content[:4000].removeprefix(b"\xef\xbb\xbf").lstrip()
    while head.startswith((b"<?xml", b"<!--")):
        head = head.partition(b"?>" if head.startswith(b"<?") else b"-->")[2].lstrip()
    start = head[:40].lower()
    for beginning, name, remedy in _MISTAKEN:
        if start.startswith(beginning):
            return name, remedy
    return None
