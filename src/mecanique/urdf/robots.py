"""The robots of the package example-robot-data: URDF files and meshes; its Python is not used."""

from __future__ import annotations

import importlib
import sys
from collections import Counter
from collections.abc import Iterator
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, distribution
from importlib.util import find_spec
from pathlib import Path

from mecanique.errors import InputError, UnknownNameError

_INSIDE = Path("share", "example-robot-data", "robots")


def robots() -> tuple[str, ...]:
    """Return the names of all robots known to `robot`.

    Returns:
        Names, sorted.

    Raises:
        InputError: if example-robot-data is not installed.

    Example:
        >>> 'panda' in mq.robots()
        True
    """
    return tuple(_files())


def robot(name: str) -> Path:
    """Return the file of a robot of example-robot-data, or of robot_descriptions.

    Args:
        name: its file's name without ".urdf", e.g. "panda"; with its folder where files share a
            name, e.g. "anymal_b_simple/anymal"; or a name of robot_descriptions, which ends in
            "_description".

    Returns:
        The path of the file.

    Raises:
        UnknownNameError: if there is none, with the nearest names.
        InputError: if several have the name, with all of them, or if the package it is sought in is
            not installed.

    Example:
        >>> mq.robot("panda").name
        'panda.urdf'
        >>> mq.read_urdf(mq.robot("ur5_robot")).nv
        6
    """
    files = _files()
    if name in files:
        return files[name]
    sharing = [known for known in files if known.partition("/")[2] == name]
    if sharing:
        raise InputError(
            f"several robots are called {name!r}; expected one of {', '.join(map(repr, sharing))}"
        )
    folder, _, stem = str(name).partition("/")
    if stem in files and files[stem] in _folders().get(folder, ()):
        return files[stem]
    if (path := find_in_library(str(name))) is not None:
        return path
    raise UnknownNameError("robot", name, files)


def find_in_library(name: str) -> Path | None:
    """Return the file of a name of robot_descriptions, which fetches it if it must."""
    if not name.endswith("_description") or not name.isidentifier():
        return None
    if find_spec("robot_descriptions") is None:
        raise InputError(
            f"there is no file {name!r}, and robot_descriptions, whose names end so, is not "
            "installed: pip install robot_descriptions"
        )
    try:
        module = importlib.import_module(f"robot_descriptions.{name}")
    except ModuleNotFoundError:
        return None
    except Exception as error:
        # it clones repositories, which may fail in many ways; git says why behind "fatal: "
        cause = str(error).rpartition("fatal: ")[2].strip().rstrip("'").partition("\n")[0]
        raise InputError(f"robot_descriptions does not give {name!r}: {cause}") from None
    paths = (getattr(module, what, None) for what in ("URDF_PATH", "MJCF_PATH", "XACRO_PATH"))
    return next((Path(path) for path in paths if path), None)


@lru_cache(maxsize=1)
def _folders() -> dict[str, tuple[Path, ...]]:
    """Files of each robot's folder, by the folder's name without "_description"."""
    folders: dict[str, tuple[Path, ...]] = {}
    for data in _data():
        for folder in sorted(data.iterdir()):
            files = tuple(sorted(folder.rglob("*.urdf")))
            if files:
                folders.setdefault(folder.name.removesuffix("_description"), files)
        if folders:
            return folders
    raise InputError(
        "expected the package example-robot-data to be installed: pip install example-robot-data"
    )


@lru_cache(maxsize=1)
def _files() -> dict[str, Path]:
    files = [(folder, file) for folder, members in _folders().items() for file in members]
    count = Counter(file.stem for _, file in files)
    named = {
        (file.stem if count[file.stem] == 1 else f"{folder}/{file.stem}"): file
        for folder, file in files
    }
    return dict(sorted(named.items()))


def _data() -> Iterator[Path]:
    """Folders that may hold the robots: of the installed package, then of the environment."""
    try:
        package = distribution("example-robot-data")
        candidates = [Path(str(package.locate_file(str(Path("cmeel.prefix") / _INSIDE))))]
    except PackageNotFoundError:
        candidates = []
    candidates += [Path(entry, "cmeel.prefix") / _INSIDE for entry in sys.path]
    candidates.append(Path(sys.prefix) / _INSIDE)
    yield from (folder for folder in candidates if folder.is_dir())
