"""Every example is short and runs; the notebook's cells show what they are to show."""

from __future__ import annotations

import ast
import json
import os
import runpy
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

FOLDER = Path(__file__).parents[1] / "examples"
ON_PROCESSES = FOLDER / "ensemble.py"
EXAMPLES = sorted(set(FOLDER.glob("*.py")) - {ON_PROCESSES})
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))


def cells(path: Path, kind: str) -> list[dict[str, Any]]:
    notebook = json.loads(path.read_text(encoding="utf-8"))
    return [cell for cell in notebook["cells"] if cell["cell_type"] == kind]


def test_there_are_examples() -> None:
    assert EXAMPLES
    assert NOTEBOOKS
    assert ON_PROCESSES.is_file()


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(path), run_name="__main__")
    assert capsys.readouterr().out.strip()


@pytest.mark.parametrize("path", [*EXAMPLES, ON_PROCESSES], ids=lambda path: path.stem)
def test_an_example_has_at_most_40_lines(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 40


def test_the_faulty_urdf_is_mended_step_by_step(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(FOLDER / "faulty_urdf.py"), run_name="__main__")
    faulty, mended, sound, read = capsys.readouterr().out.split("\n\n")
    assert faulty.count(": error") > mended.count(": error") == 1
    assert sound == "nothing found"
    assert "hinge" in read


@pytest.mark.slow
def test_the_ensemble_is_run_by_processes_of_dask(tmp_path: Path) -> None:
    """As a program of its own: Dask's processes read the file again."""
    pytest.importorskip("distributed")
    patient = {f"DASK_DISTRIBUTED__COMM__TIMEOUTS__{what}": "300s" for what in ("CONNECT", "TCP")}
    done = subprocess.run(
        [sys.executable, str(ON_PROCESSES)],
        cwd=tmp_path,
        env={**os.environ, **patient},
        capture_output=True,
        encoding="utf-8",
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    first, *_, last = (float(line.split()[-2]) for line in done.stdout.splitlines())
    assert first < 1e-5
    assert last > 1e-2


@pytest.mark.parametrize(
    ("example", "package", "extra"),
    [(ON_PROCESSES, "distributed", "cluster"), (FOLDER / "fmu.py", "fmpy", "fmpy")],
)
def test_an_example_says_what_it_needs(
    example: Path, package: str, extra: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(SystemExit, match=rf"install it with: pip install 'mecanique\[{extra}\]'"):
        runpy.run_path(str(example), run_name="__main__")


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_of_format_4_short_and_without_outputs(path: Path) -> None:
    notebook = json.loads(path.read_text(encoding="utf-8"))
    assert set(notebook) == {"cells", "metadata", "nbformat", "nbformat_minor"}
    assert (notebook["nbformat"], notebook["nbformat_minor"]) == (4, 5)
    common = {"cell_type", "id", "metadata", "source"}
    code, words = cells(path, "code"), cells(path, "markdown")
    assert (
        len(code) + len(words)
        == len(notebook["cells"])
        == len({cell["id"] for cell in notebook["cells"]})
    )
    assert all(set(cell) == common for cell in words)
    assert all(set(cell) == common | {"execution_count", "outputs"} for cell in code)
    assert all(cell["execution_count"] is None and cell["outputs"] == [] for cell in code)
    assert all(isinstance(line, str) for cell in notebook["cells"] for line in cell["source"])
    assert sum(len(cell["source"]) for cell in code) <= 40


def shown(path: Path) -> list[Any]:
    """Run the code cells in order; return what each shows, its last expression."""
    space: dict[str, Any] = {"__name__": "__main__"}
    values = []
    for cell in cells(path, "code"):
        *body, last = ast.parse("".join(cell["source"])).body
        assert isinstance(last, ast.Expr), "a cell ends with what it shows"
        exec(compile(ast.Module(body, []), path.name, "exec"), space)
        values.append(eval(compile(ast.Expression(last.value), path.name, "eval"), space))
    return values


def test_the_notebook_shows_equations_verdict_and_motion(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    _, equations, verdict, _, motion = shown(FOLDER / "notebook.ipynb")
    assert r"\ddot{x}" in equations._repr_latex_()
    assert verdict.agrees
    assert "<" in verdict._repr_html_()
    assert capsys.readouterr().out.strip(), "the audit"
    assert "iframe" in motion._repr_html_()
    assert not list(tmp_path.iterdir())
