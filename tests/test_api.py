"""The public names: sorted, importable, documented, and light to import."""

from __future__ import annotations

import inspect
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import mecanique as mq
from mecanique import errors, model

HEAVY = (
    "sympy",
    "scipy",
    "pinocchio",
    "meshcat",
    "rich",
    "click",
    "pydantic",
    "lark",
    "matplotlib",
    "example_robot_data",
)
ROOMS = {"derive", "verify", "view"}
"""Rooms whose name is a function's too."""


def public(name: str) -> Any:
    return getattr(mq, name)


def test_the_list_of_names_is_sorted_and_whole() -> None:
    assert mq.__all__ == sorted(mq.__all__)
    assert len(set(mq.__all__)) == len(mq.__all__)
    assert set(model.__all__) <= set(mq.__all__)
    assert set(errors.__all__) <= set(mq.__all__)


def test_dir_shows_the_public_names_alone() -> None:
    assert set(dir(mq)) == {*mq.__all__, "__version__"}
    mq.textbook.load("rigid_bar_pendulum")
    assert set(dir(mq)) == {*mq.__all__, "__version__"}


@pytest.mark.parametrize("name", mq.__all__)
def test_every_name_is_there_and_documented(name: str) -> None:
    thing = public(name)
    if name in {"AnyForce", "Joint"}:
        assert "Union" in type(thing).__name__ or hasattr(thing, "__args__")
        return
    assert (inspect.getdoc(thing) or "").strip(), name


@pytest.mark.parametrize("name", [name for name in mq.__all__ if inspect.isfunction(public(name))])
def test_functions_document_every_argument(name: str) -> None:
    text = inspect.getdoc(public(name)) or ""
    arguments = text.partition("Args:")[2].partition("Raises:")[0]
    for argument in inspect.signature(public(name)).parameters:
        assert f"{argument}:" in arguments, f"{name}({argument})"


@pytest.mark.parametrize("name", [name for name in mq.__all__ if inspect.isclass(public(name))])
def test_methods_are_documented(name: str) -> None:
    for word, member in vars(public(name)).items():
        if not word.startswith("_") and (
            callable(member) or isinstance(member, (property, classmethod))
        ):
            assert (inspect.getdoc(member) or "").strip(), f"{name}.{word}"


@pytest.mark.parametrize(
    "name",
    [n for n in mq.__all__ if inspect.isclass(public(n)) and not issubclass(public(n), Exception)],
)
def test_classes_are_final_unless_they_are_errors(name: str) -> None:
    assert getattr(public(name), "__final__", False) or getattr(
        public(name), "_is_protocol", False
    ), name


def test_names_that_do_not_exist_are_refused() -> None:
    with pytest.raises(AttributeError, match="module 'mecanique' has no attribute 'sumulate'"):
        public("sumulate")


def test_functions_win_over_rooms_of_the_same_name() -> None:
    for name in ROOMS & set(mq.__all__):
        assert inspect.isfunction(public(name)), name
    script = """
        import mecanique.derivation.numeric.recursion
        import mecanique.verification.compare, mecanique.reference
        import mecanique as mq
        mq.verify(mq.textbook.load("rigid_bar_pendulum"), samples=2)
        assert callable(mq.derive) and callable(mq.verify), (mq.derive, mq.verify)
    """
    run(script)


def test_every_error_is_a_mecanique_error_and_survives_pickling() -> None:
    samples = [
        mq.ClosureError("a"),
        mq.DerivationError("a"),
        mq.EngineError("a"),
        mq.FormulaError("a", "q + ", 4, ("k",)),
        mq.InputError("a"),
        mq.IntegrationError("a"),
        mq.MechanismError("m", ["a", "b"]),
        mq.UnknownNameError("system", "x", ["xy", "z"]),
        mq.UrdfError("a", file="f.urdf", line=3),
    ]
    assert {type(error).__name__ for error in samples} == set(errors.__all__) - {"MecaniqueError"}
    for error in samples:
        assert isinstance(error, mq.MecaniqueError)
        again = pickle.loads(pickle.dumps(error))
        assert type(again) is type(error)
        assert str(again) == str(error)
        assert vars(again) == vars(error)


def test_the_errors_say_where_and_what_else() -> None:
    assert str(mq.UrdfError("no name", file="a.urdf", line=3)) == "a.urdf:3: no name"
    assert str(mq.UrdfError("no name")) == "no name"
    assert str(mq.UnknownNameError("system", "pendulm", ["pendulum"])) == (
        "unknown system 'pendulm'; did you mean 'pendulum'?"
    )
    assert str(mq.UnknownNameError("body", "x", [])) == "unknown body 'x'; known: none"
    many = str(mq.UnknownNameError("body", "?", [f"link{k}" for k in range(20)]))
    assert many.endswith("link11, … (20 in all)")


def test_the_version_is_that_of_the_package() -> None:
    from importlib.metadata import version

    assert mq.__version__ == version("mecanique")


@pytest.mark.parametrize("module", ["mecanique", "mecanique.cli", "mecanique.textbook"])
def test_importing_loads_nothing_heavy(module: str) -> None:
    allowed = {"click"} if module == "mecanique.cli" else set()
    heavy = [name for name in HEAVY if name not in allowed]
    run(f"""
        import sys
        import {module}
        loaded = [name for name in {heavy!r} if name in sys.modules]
        assert not loaded, loaded
    """)


@pytest.mark.parametrize("heavy", ["numpy", "rich", "mecanique.model"])
def test_help_and_the_bare_import_load_neither_arrays_nor_the_model(heavy: str) -> None:
    run(f"""
        import sys
        import mecanique
        assert {heavy!r} not in sys.modules
        from mecanique.cli import app
        assert {heavy!r} not in sys.modules
    """)


def test_looking_at_the_names_loads_nothing_heavy() -> None:
    run(f"""
        import sys
        import mecanique as mq
        dir(mq), mq.textbook.names(), mq.Parameter("m", 1.0), mq.rod(1.0, 2.0), mq.derive, mq.verify
        loaded = [name for name in {HEAVY!r} if name in sys.modules]
        assert not loaded, loaded
    """)


def test_a_first_motion_and_its_page_import_only_what_they_need(tmp_path: Path) -> None:
    run(
        """
        import sys
        import mecanique as mq
        pendulum = mq.textbook.load("rigid_bar_pendulum")
        motion = mq.simulate(pendulum, q={"q": 1.0}, duration=0.1)
        never = {"scipy.integrate", "scipy.linalg", "scipy.optimize", "scipy.spatial"}
        later = {"mecanique.derivation", "mecanique.generation.targets.c", "numpy.ma"}
        assert not (never | later) & set(sys.modules), (never | later) & set(sys.modules)
        mq.export(motion, sys.argv[1])
        never |= {"meshcat", "tornado", "asyncio", "mecanique.generation.targets.fmu"}
        assert not never & set(sys.modules), never & set(sys.modules)
        """,
        str(tmp_path / "page.html"),
    )


def test_a_motion_shows_itself_in_a_notebook_with_nothing_else_imported() -> None:
    run("""
        import mecanique as mq
        motion = mq.simulate(mq.textbook.load("rigid_bar_pendulum"), duration=0.1)
        assert motion._repr_html_().startswith("<iframe")
    """)


def run(script: str, *arguments: str) -> None:
    """Run a script in a process of its own."""
    done = subprocess.run(
        [sys.executable, "-c", inspect.cleandoc(script), *arguments],
        capture_output=True,
        encoding="utf-8",
        check=False,
    )
    assert done.returncode == 0, done.stderr
