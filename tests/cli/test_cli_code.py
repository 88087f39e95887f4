"""`mecanique code`: what it writes and prints, and how it ends."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from mecanique.cli import app
from mecanique.reference.engine.package import has_pinocchio


def call(*words: str) -> Result:
    return CliRunner().invoke(app, ["code", *words])


def test_code_is_written_with_its_test(tmp_path: Path) -> None:
    done = call("cart_pole", "--what", "rhs,energy", "--samples", "10", "-o", str(tmp_path / "c"))
    assert done.exit_code == 0, done.output
    names = ("cart_pole.h", "cart_pole.c", "test_cart_pole.c")
    assert [line.split("/")[-1] for line in done.stdout.splitlines()[:3]] == list(names)
    engine = "Pinocchio" if has_pinocchio() else "a stand-in for Pinocchio"
    assert f"compared with {engine} at 10 random states" in done.stdout
    assert "void cart_pole_rhs(" in (tmp_path / "c" / "cart_pole.h").read_text(encoding="utf-8")


def test_code_takes_parameters_a_name_and_numbers(tmp_path: Path) -> None:
    words = ["simple_pendulum", "--target", "python", "-p", "l=2.5", "--numbers", "--name", "swing"]
    done = call(*words, "--samples", "10", "--json", "-o", str(tmp_path))
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    assert [Path(path).name for path in told["files"]] == ["swing.py", "test_swing.py"]
    assert told["operations"]["acceleration"] <= 4
    assert told["worst"]["acceleration"] < 1e-13
    assert "PARAMETERS = {}" in (tmp_path / "swing.py").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("cart_pole", "--target", "fortran"), "unknown target 'fortran'"),
        (("cart_pole", "--what", "speed"), "unknown quantity 'speed'"),
        (
            ("cart_pole", "--what", "multipliers"),
            "expected a mechanism with loops, contacts or velocity",
        ),
        (("cart_pole", "--name", "a b"), "expected a name of ASCII letters"),
        (("cart_pole", "--root", "floating"), "expected a URDF file or a robot"),
        (("no_such_system",), "no_such_system"),
    ],
)
def test_what_is_asked_wrongly_ends_with_two(words: tuple[str, ...], message: str) -> None:
    done = call(*words)
    assert done.exit_code == 2
    assert message in done.output


def test_code_of_a_robot_is_called_as_it_was_asked_for(tmp_path: Path) -> None:
    """The file of solo12 calls it solo."""
    words = ["code", "solo12", "--target", "python", "--what", "energy", "--samples", "2"]
    run = CliRunner().invoke(app, [*words, "-o", str(tmp_path)])
    assert run.exit_code == 0, run.output
    assert (tmp_path / "solo12.py").is_file()
