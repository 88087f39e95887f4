"""The examples of public functions run, and say what they return."""

from __future__ import annotations

import doctest
import inspect

import pytest

import mecanique as mq

WITHOUT = {
    # they open a page, write files, read robots or run for long
    "assembly_branches",
    "contact_events",
    "diff",
    "export",
    "floating",
    "floating_state",
    "frequency_response",
    "generate",
    "inertial_check",
    "inspect",
    "picture",
    "robot",
    "simulate_many",
    "sweep_speeds",
    "view",
}
"""Functions without an example."""

FUNCTIONS = [name for name in mq.__all__ if inspect.isfunction(getattr(mq, name))]


def test_the_exceptions_are_functions() -> None:
    assert set(FUNCTIONS) >= WITHOUT


@pytest.mark.parametrize("name", sorted(set(FUNCTIONS) - WITHOUT))
def test_the_example_runs(name: str) -> None:
    function = getattr(mq, name)
    text = inspect.getdoc(function) or ""
    assert "Returns:\n" in text
    test = doctest.DocTestParser().get_doctest(text, {"mq": mq}, name, None, 0)
    assert test.examples
    said: list[str] = []
    result = doctest.DocTestRunner(verbose=False).run(test, out=said.append)
    assert result.failed == 0, "".join(said)
