"""What the project says about itself agrees: versions, dependencies, the public API, the paper."""

from __future__ import annotations

import inspect
import re
import sys
from pathlib import Path
from typing import Any

import pytest

import mecanique as mq

ROOT = Path(__file__).parents[1]
SNAPSHOT = ROOT / "tests" / "public_api.txt"
CONDA = {"pin": "pinocchio", "meshcat": "meshcat-python"}
"""Packages that conda-forge calls otherwise."""


def read(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def describe_api() -> str:
    """Return every public name with its arguments and, for classes, its public members."""
    lines = []
    for name in mq.__all__:
        thing: Any = getattr(mq, name)
        if inspect.isclass(thing):
            lines.append(f"class {name}{arguments(thing)}")
            ours = [base for base in thing.__mro__ if base.__module__.startswith("mecanique.")]
            for member in sorted({member for base in ours for member in vars(base)}):
                value = inspect.getattr_static(thing, member)
                if member.startswith("_") or not documents(value):
                    continue
                called = getattr(thing, member)
                lines.append(f"    {member}{arguments(called) if callable(called) else ''}")
        else:
            lines.append(f"{name}{arguments(thing) if inspect.isfunction(thing) else ''}")
    return "\n".join([*lines, ""])


def arguments(thing: Any) -> str:
    """Return the names and defaults of arguments; annotations may be written otherwise."""
    try:
        signature = inspect.signature(thing)
    except ValueError:
        return "(...)"
    bare = [
        each.replace(annotation=inspect.Parameter.empty) for each in signature.parameters.values()
    ]
    empty = inspect.Signature.empty
    return str(signature.replace(parameters=bare, return_annotation=empty))


def documents(value: Any) -> bool:
    return (
        callable(value)
        or isinstance(value, (property, classmethod, staticmethod))
        or (type(value).__name__ == "cached_property")
    )


@pytest.mark.skipif(sys.version_info < (3, 11), reason="defaults of enumerations print otherwise")
def test_the_public_api_is_that_of_the_snapshot() -> None:
    """Write it anew by `python tests/test_project.py`, and tell users in the changelog."""
    assert describe_api().splitlines() == SNAPSHOT.read_text(encoding="utf-8").splitlines()


def test_one_version_everywhere() -> None:
    (version,) = re.findall(
        r'^__version__ = "(.+)"$', read("src/mecanique/version.py"), re.MULTILINE
    )
    assert f"version: {version}\n" in read("CITATION.cff")
    assert f'version: "{version}"\n' in read(".ci/conda/recipe.yaml")


def addresses(text: str) -> list[str]:
    """Return the addresses of the project that pyproject.toml names."""
    table = re.search(r"^\[project\.urls\]\n((?:.+\n)*)", text, re.MULTILINE)
    return re.findall(r'^Homepage = "(.+)"$', table[1], re.MULTILINE) if table else []


def test_one_address_everywhere() -> None:
    """Where pyproject.toml names a homepage, and only there, the others name the same one."""
    homepage = addresses(read("pyproject.toml"))
    cited = re.findall(r'^url: "(.+)"$', read("CITATION.cff"), re.MULTILINE)
    packed = re.findall(r"^  homepage: (.+)$", read(".ci/conda/recipe.yaml"), re.MULTILINE)
    assert cited == packed == homepage


def test_an_address_is_found_once_it_is_there() -> None:
    given = '[project.urls]\nHomepage = "https://example.org"\nIssues = "x"\n\n[next]\n'
    assert addresses(given) == ["https://example.org"]


def test_the_recipe_has_every_dependency() -> None:
    (block,) = re.findall(r"^dependencies = \[\n(.*?)^\]", read("pyproject.toml"), re.S | re.M)
    (run,) = re.findall(r"^  run:\n(.*?)^\n", read(".ci/conda/recipe.yaml"), re.S | re.M)
    wanted = {
        f"{CONDA.get(name, name)} >={version}"
        for name, version in re.findall(r'"([\w-]+)>=([\d.]+)', block)
    }
    assert set(re.findall(r"- (.+)", run)) == {"python >=3.10", *wanted}


def test_the_constraints_name_every_dependency_and_no_place() -> None:
    text = read(".ci/constraints.txt")
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    shape = r"[\w.-]+==[\w.+!]+(?: ; python_version >= \"3\.\d+\")?"
    assert [line for line in lines if not re.fullmatch(shape, line)] == []
    pinned = {re.sub(r"[-_.]+", "-", line.partition("==")[0]).lower() for line in lines}
    project = pytest.importorskip("tomllib").loads(read("pyproject.toml"))["project"]
    extras = project["optional-dependencies"]
    wanted = [
        *project["dependencies"],
        *(one for name in ("test", "docs", "lint") for one in extras[name]),
    ]
    elsewhere = {"tomli"}  # of Python 3.10 alone
    for requirement in wanted:
        name = re.split(r"[ ;<>=\[]", requirement)[0].lower()
        assert name in pinned | elsewhere, name


def test_the_paper_cites_what_it_lists() -> None:
    listed = set(re.findall(r"^@\w+\{(\w+),", read("docs/paper/paper.bib"), re.MULTILINE))
    assert set(re.findall(r"@(\w+)", read("docs/paper/paper.md"))) == listed


@pytest.mark.parametrize(
    "name", ["AGENTS.md", "CITATION.cff", "CODE_OF_CONDUCT.md", "CONTRIBUTING.md", "SECURITY.md"]
)
def test_the_files_of_a_project_name_what_is_there(name: str) -> None:
    for path in re.findall(r"`((?:docs|tests|src|\.ci)/[\w./-]+)`", read(name)):
        assert (ROOT / path).exists(), f"{name}: {path}"


if __name__ == "__main__":
    SNAPSHOT.write_text(describe_api(), encoding="utf-8")
