"""Find the mesh files of a URDF: in packages and on the search path, and nowhere else."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path
from typing import TypeAlias, final

PackagePath: TypeAlias = str | os.PathLike[str] | Iterable[str | os.PathLike[str]]
"""Folders that hold packages: a path, several joined by the system's separator, or a sequence."""

_PATHS = ("ROS_PACKAGE_PATH", "GZ_SIM_RESOURCE_PATH", "SDF_PATH", "GAZEBO_MODEL_PATH")
"""Variables of the environment with folders that hold packages of ROS and models of Gazebo."""

_MOST_NAMED = 4
"""So many folders of the search path are named where something is not found."""

_MOST_ABOVE, _MOST_FOLDERS = 4, 1000
"""How far above the file, and among how many folders there, a package of any name is sought."""

_SUFFIXES = {
    ".stl",
    ".dae",
    ".obj",
    ".ply",
    ".glb",
    ".gltf",
    ".off",
    ".msh",
    ".wrl",
    ".3ds",
    ".stlb",
    ".mesh",
    ".vtk",
}


@final
class OutsideError(Exception):
    """A mesh path climbs out of its package; the reader turns this into a finding."""


@final
class MeshSearch:
    """Find mesh files.

    Only the URDF's own folder, the packages around it and the folders of the search path are
    searched, and only for suffixes of mesh formats: a URDF cannot make the viewer show other files.
    """

    def __init__(self, file: Path | None, package_path: PackagePath | None = None) -> None:
        self._folder = None if file is None else Path(os.path.abspath(file)).parent
        self._path = list_folders(package_path)
        self._path += [folder for name in _PATHS for folder in list_folders(os.environ.get(name))]
        prefixes = list_folders(os.environ.get("AMENT_PREFIX_PATH"))
        self._path += [prefix / "share" for prefix in prefixes]
        self._path += _find_fetched()
        self._located: dict[str, Path | None] = {}

    def find(self, uri: str) -> Path | None:
        """Return the file of a mesh, None if there is none; refuse a path out of its package."""
        if uri not in self._located:
            self._located[uri] = self._search(uri)
        return self._located[uri]

    def package(self, name: str) -> Path | None:
        """Return the folder of a package, or None if it is not found."""
        if name in ("", ".", "..") or "/" in name or "\\" in name:
            return None
        return next((folder for folder in self._packages(name) if folder.is_dir()), None)

    @property
    def searched(self) -> str:
        """Where packages are looked for, in words."""
        around = [] if self._folder is None else [f"{self._folder} and above"]
        named = [str(folder) for folder in self._path[:_MOST_NAMED]]
        if len(self._path) > _MOST_NAMED:
            named.append(f"{len(self._path) - _MOST_NAMED} more folders")
        return ", ".join([*named, *around]) or "the empty search path"

    def _search(self, uri: str) -> Path | None:
        scheme, separator, rest = uri.partition("://")
        if not separator:
            scheme, rest = "", uri
        rest = rest.replace("\\", "/")
        if scheme in ("package", "model"):
            package, _, inside = rest.lstrip("/").partition("/")
            inside = inside.lstrip("/")  # after package://name//, still below the package
            # a drive of Windows would take the place of all before it
            drive = any(part[1:2] == ":" for part in rest.split("/"))
            if _climbs(inside) or drive or package in ("", ".", ".."):
                raise OutsideError
            candidates: Iterable[Path] = (root / inside for root in self._packages(package))
        elif scheme in ("", "file"):
            if os.name == "nt":
                rest = re.sub(r"^/(?=[A-Za-z]:/)", "", rest)  # file:///C:/parts/arm.stl
            if os.path.isabs(rest):
                candidates = [Path(os.path.normpath(rest))]
            elif self._folder is None:
                return None
            else:
                candidates = [Path(os.path.normpath(self._folder / rest))]
            roots = {*self._roots()}
            if not any(roots & {path, *path.parents} for path in candidates):
                if _climbs(rest):
                    raise OutsideError
                return None
        else:
            return None
        return next((path for path in candidates if _is_mesh(path)), None)

    def _packages(self, package: str) -> Iterator[Path]:
        """Folders that may be a package: on the search path, then around the URDF file."""
        for folder in self._path:
            if folder.name == package:
                yield folder
            yield folder / package
        if self._folder is not None:
            for folder in (self._folder, *self._folder.parents):
                if folder.name == package or _declares(folder, package):
                    yield folder
                yield folder / package
                yield folder / "models" / package  # beside the worlds of Gazebo
        # folders of another name whose package.xml has this one
        for folder in (*self._path, *self._around):
            for inside in _list_packages(folder):
                if _declares(inside, package):
                    yield inside

    @property
    def _around(self) -> list[Path]:
        """Folders near the file that may hold packages beside its own."""
        return [] if self._folder is None else [*self._folder.parents][:_MOST_ABOVE]

    def _roots(self) -> Iterator[Path]:
        """Folders that may contain plain paths."""
        yield from self._path
        if self._folder is not None:
            yield self._folder
            for folder in (self._folder, *self._folder.parents):
                if (folder / "package.xml").is_file():
                    yield folder
                    break


def _list_packages(folder: Path) -> list[Path]:
    """Return the folders in a folder that have a package.xml, the first thousand looked at."""
    try:
        inside = sorted(islice(folder.iterdir(), _MOST_FOLDERS))
        return [path for path in inside if (path / "package.xml").is_file()]
    except OSError:
        return []


def _declares(folder: Path, package: str) -> bool:
    """Whether the package.xml of a folder, whatever that is called, has this name."""
    try:
        text = (folder / "package.xml").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return False
    match = re.search(r"<name>\s*([^<\s]+)\s*</name>", text)
    return match is not None and match.group(1) == package


def _find_fetched() -> list[Path]:
    """Return the repositories that robot_descriptions has fetched, and the folders in them."""
    location = os.environ.get("ROBOT_DESCRIPTIONS_CACHE") or "~/.cache/robot_descriptions"
    try:
        cache = Path(location).expanduser()
        fetched = [folder for folder in sorted(cache.glob("*")) if folder.is_dir()]
        inside = [subfolder for folder in fetched for subfolder in sorted(folder.glob("[!.]*"))]
        return fetched + [folder for folder in inside if folder.is_dir()]
    except (OSError, RuntimeError):  # no home, or one that cannot be read
        return []


def list_folders(path: PackagePath | None) -> list[Path]:
    """Return the folders of a search path."""
    if path is None:
        return []
    if isinstance(path, (str, os.PathLike)):
        return [Path(os.path.abspath(part)) for part in os.fspath(path).split(os.pathsep) if part]
    return [Path(os.path.abspath(part)) for part in path]


def _climbs(path: str) -> bool:
    """Whether a path leads above its start at any point."""
    depth = 0
    for part in path.split("/"):
        depth += -1 if part == ".." else part not in ("", ".")
        if depth < 0:
            return True
    return False


def _is_mesh(path: Path) -> bool:
    try:
        return path.suffix.lower() in _SUFFIXES and path.is_file()
    except (OSError, ValueError):  # a name too long, or one the file system cannot hold
        return False
