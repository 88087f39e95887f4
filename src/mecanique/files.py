"""Files that are written whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from secrets import token_hex
from typing import IO


@contextmanager
def write_whole(path: Path) -> Iterator[IO[bytes]]:
    """Open a new file that takes a path's place at the end of the block, unless the block raises.

    Args:
        path: its directory must exist.
    """
    beside = path.parent / f".{path.name}.{token_hex(6)}.part"
    try:
        with beside.open("xb") as file:
            yield file
        os.replace(beside, path)
    finally:
        beside.unlink(missing_ok=True)


def as_bytes(content: str | bytes) -> bytes:
    """Return what is written to a file.

    Args:
        content: text, or bytes as they are.
    """
    return content.encode() if isinstance(content, str) else content
