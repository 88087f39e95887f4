"""Every public name has an example, which runs and gives what it says."""

from __future__ import annotations

import doctest
import inspect
from pathlib import Path
from types import UnionType

import pytest

import mecanique as mq
from mecanique.viewing.live.live import LiveView


def text_of(name: str) -> str:
    """Return the documentation of a public name, without that of its bases."""
    thing = getattr(mq, name)
    if isinstance(thing, UnionType):
        from generate import text_below

        return text_below(name)
    return inspect.cleandoc(thing.__doc__ or "")


@pytest.fixture
def interrupted(monkeypatch: pytest.MonkeyPatch) -> None:
    """End a view by Ctrl-C as soon as it is served, without its address."""

    def interrupt(*_: object, **options: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(LiveView, "announce", lambda view: view.await_page())
    monkeypatch.setattr(LiveView, "stream", interrupt)


@pytest.mark.usefixtures("interrupted")
@pytest.mark.parametrize("name", mq.__all__)
def test_the_example_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # some write a file
    text = text_of(name)
    if inspect.isfunction(getattr(mq, name)):
        assert "Returns:\n" in text or name in ("inspect", "view")
    test = doctest.DocTestParser().get_doctest(text, {"mq": mq}, name, None, 0)
    assert test.examples, "has no example"
    said: list[str] = []
    runner = doctest.DocTestRunner(verbose=False, optionflags=doctest.NORMALIZE_WHITESPACE)
    result = runner.run(test, out=said.append)
    assert result.failed == 0, "".join(said)


def test_a_wrong_example_is_found() -> None:
    test = doctest.DocTestParser().get_doctest(">>> mq.cos(0)\n2\n", {"mq": mq}, "", None, 0)
    assert doctest.DocTestRunner(verbose=False).run(test, out=lambda text: None).failed == 1
