"""Files are written whole, and a fault names the file that was asked for."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path
from time import process_time

import pytest
from click.testing import CliRunner

import mecanique as mq
from mecanique.cli import app
from mecanique.files import recognize, stem_of, write_whole


def full(*_: object) -> None:
    raise OSError(errno.ENOSPC, "No space left on device")


def test_a_full_disk_names_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "motion.csv"
    target.write_text("before", encoding="utf-8")
    with pytest.raises(OSError, match="No space left") as caught, write_whole(target):
        full()
    assert caught.value.filename == str(target)
    assert target.read_text(encoding="utf-8") == "before"
    assert [path.name for path in tmp_path.iterdir()] == ["motion.csv"]
    monkeypatch.setattr("os.fsync", full)
    result = CliRunner().invoke(app, ["urdf", "simple_pendulum", "-o", str(tmp_path / "a.urdf")])
    assert result.exit_code == 2
    assert f"{tmp_path / 'a.urdf'}" in result.stderr
    assert "No space left on device" in result.stderr


@pytest.mark.parametrize(
    ("name", "stem"),
    [
        ("rigid_bar_pendulum", "rigid_bar_pendulum"),
        ("Schubkurbel α", "Schubkurbel_α"),
        ("../up", "up"),
        ("..\\up", "up"),
        ("a/b", "a_b"),
        ("a:b?", "a_b"),
        ("CON", "CON_"),
        ("com1.arm", "com1.arm_"),
        ("console", "console"),
        ("x" * 300, "x" * 80),
        ("//", "mechanism"),
    ],
)
def test_a_file_is_called_after_a_mechanism_and_stays_in_its_folder(
    name: str, stem: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A robot's file may give it any name."""
    assert stem_of(name) == stem
    folder = tmp_path / "here"
    folder.mkdir()
    monkeypatch.chdir(folder)
    source = tmp_path / "robot.urdf"
    text = mq.write_urdf(mq.textbook.load("simple_pendulum"))
    source.write_text(text.replace('name="simple_pendulum"', f'name="{name}"'), encoding="utf-8")
    result = CliRunner().invoke(app, ["picture", str(source)])
    assert result.exit_code == 0, result.output
    assert [path.name for path in tmp_path.rglob("*.svg")] == [f"{stem}.svg"]
    assert (folder / f"{stem}.svg").is_file()


def test_a_missing_folder_is_named_by_the_file(tmp_path: Path) -> None:
    target = tmp_path / "nowhere" / "a.html"
    with pytest.raises(OSError, match="No such file") as caught, write_whole(target):
        pass
    assert caught.value.filename == str(target)


def test_what_is_named_is_on_the_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    done: list[str] = []
    monkeypatch.setattr("os.fsync", lambda _: done.append("synced"))
    replace = os.replace

    def name(part: Path, whole: Path) -> None:
        done.append("named")
        replace(part, whole)

    monkeypatch.setattr("os.replace", name)
    mq.write_urdf(mq.textbook.load("simple_pendulum"), tmp_path / "a.urdf")
    assert done == ["synced", "named"]


@pytest.mark.skipif(not Path("/dev/full").is_char_device(), reason="has no such device")
def test_a_full_disk_behind_a_redirection_is_told() -> None:
    words = [sys.executable, "-m", "mecanique", "urdf", "simple_pendulum"]
    with Path("/dev/full").open("w", encoding="utf-8") as out:
        run = subprocess.run(
            words, stdout=out, stderr=subprocess.PIPE, encoding="utf-8", check=False
        )
    assert run.returncode == 2
    assert run.stderr == "error: standard output: No space left on device\n"


@pytest.mark.skipif(not Path("/dev/full").is_char_device(), reason="has no such device")
def test_a_device_is_written_to_and_stays(tmp_path: Path) -> None:
    link = tmp_path / "full.csv"
    link.symlink_to("/dev/full")
    for path in (Path("/dev/full"), link):
        with pytest.raises(OSError, match="No space left") as caught, write_whole(path) as file:
            file.write(b"t,q")
        assert caught.value.filename == "/dev/full"
    assert link.is_symlink()
    assert Path("/dev/full").is_char_device()


@pytest.mark.skipif(os.name == "nt", reason="has no named pipes")
def test_a_pipe_is_written_to(tmp_path: Path) -> None:
    pipe = tmp_path / "motion.csv"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    with write_whole(pipe) as file:
        file.write(b"t,q")
    assert os.read(reader, 10) == b"t,q"
    os.close(reader)
    assert pipe.is_fifo()


@pytest.mark.skipif(os.name == "nt", reason="links need rights of an administrator")
def test_a_link_is_followed(tmp_path: Path) -> None:
    target, link = tmp_path / "run.csv", tmp_path / "last.csv"
    target.write_text("before", encoding="utf-8")
    link.symlink_to(target)
    with write_whole(link) as file:
        file.write(b"after")
    assert link.is_symlink()
    assert target.read_text(encoding="utf-8") == "after"


def test_comments_before_a_robot_take_no_time() -> None:
    start = process_time()
    assert recognize(b"<!-- a -->\n" * 400 + b"<robot/>") is None
    assert recognize(b"<!-- a -->\n" * 3 + b"<HTML>") == (
        "a web page",
        "Save the file itself, not the page that shows it.",
    )
    assert process_time() - start < 1
