"""Other packages add systems, targets, engines and lint rules by entry points."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import mecanique as mq
from mecanique import plugins
from mecanique.textbook import catalogue

PROJECT = Path(__file__).parent / "example_plugin"
ROBOT = """<robot name="r">
  <link name="base"/>
  <link name="upperArm">
    <inertial>
      <origin xyz="0 0 -0.3"/><mass value="2"/>
      <inertia ixx="0.06" iyy="0.06" izz="0.02" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
  <joint name="hinge" type="continuous">
    <parent link="base"/><child link="upperArm"/><axis xyz="0 -1 0"/>
  </joint>
</robot>
"""


def forget() -> None:
    for cached in (plugins.list_plugins, catalogue.names, catalogue.entry):
        cached.cache_clear()


def install(folder: Path, entry_points: str) -> None:
    """Write what an installer writes, so that importlib.metadata finds the package."""
    data = folder / "mecanique_example-1.0.dist-info"
    data.mkdir()
    (data / "METADATA").write_text(
        "Metadata-Version: 2.1\nName: mecanique-example\nVersion: 1.0\n", encoding="utf-8"
    )
    (data / "entry_points.txt").write_text(entry_points, encoding="utf-8")


@pytest.fixture
def example(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The example package as if it were installed, with the entry points its project states."""
    text = (PROJECT / "pyproject.toml").read_text(encoding="utf-8")
    groups = re.findall(r'^\[project\.entry-points\."(.+)"\]\n((?:.+\n?)+)', text, re.MULTILINE)
    assert len(groups) == 4
    lines = (f"[{name}]\n{body.replace(chr(34), '')}" for name, body in groups)
    install(tmp_path, "\n".join(lines))
    monkeypatch.syspath_prepend(PROJECT / "src")
    monkeypatch.syspath_prepend(tmp_path)
    forget()
    yield
    forget()


@pytest.mark.usefixtures("example")
def test_a_system_is_in_the_catalogue() -> None:
    assert "sliding_block" in mq.textbook.names()
    block = mq.textbook.load("sliding_block", m=3.0)
    assert block.values["m"] == 3.0
    assert str(mq.derive(block)) == "z'' + g = 0"
    assert mq.verify(block, samples=5).agrees


@pytest.mark.usefixtures("example")
def test_a_target_is_held_to_the_same_verdict() -> None:
    code = mq.generate(mq.derive(mq.textbook.load("simple_pendulum")), "python_upper", samples=5)
    assert code.verdict is not None
    assert code.verdict.worst["acceleration"] < 1e-13
    with pytest.raises(mq.UnknownNameError, match="did you mean 'python_upper'"):
        mq.generate(mq.derive(mq.textbook.load("simple_pendulum")), "python_uper")


@pytest.mark.usefixtures("example")
def test_a_lint_rule_is_applied() -> None:
    (finding,) = (each for each in mq.lint(ROBOT) if each.code == "X001")
    assert (finding.line, finding.where, finding.severity) == (3, "link 'upperArm'", "info")
    assert finding.remedy == "Rename the link."


@pytest.mark.usefixtures("example")
def test_an_engine_reads_the_file() -> None:
    from mecanique.verification.engines import read_by

    (reading,) = read_by(mq.read_urdf(ROBOT), ["echo"], seed=0)
    assert "it reads no file, not even one of" in str(reading)
    with pytest.raises(mq.UnknownNameError, match="did you mean 'echo'"):
        read_by(mq.read_urdf(ROBOT), ["ecco"], seed=0)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (
            "no_such_module:X",
            r"'broken' of mecanique\.systems, which the package 'mecanique-example' adds, cannot "
            r"be loaded: ModuleNotFoundError: .*; mend or uninstall it",
        ),
        ("math:pi", "is a float, expected a System"),
    ],
)
def test_what_cannot_be_loaded_is_refused_by_name(
    value: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    install(tmp_path, f"[mecanique.systems]\nbroken = {value}\n")
    monkeypatch.syspath_prepend(tmp_path)
    forget()
    try:
        with pytest.raises(mq.InputError, match=message):
            mq.textbook.load("broken")
        assert mq.textbook.load("simple_pendulum").name == "simple_pendulum"
    finally:
        forget()
