from __future__ import annotations

import pickle
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mecanique as mq
from mecanique.model.mechanism_units import units


@pytest.fixture(scope="module")
def motion() -> mq.Motion:
    return mq.simulate(mq.textbook.load("cart_pole"), q={"q": 1.0}, duration=1.0)


@pytest.mark.parametrize(
    ("what", "labels"),
    [
        ("coordinates", {"t [s]", "x, q", "x', q'"}),
        ("phase", {"x [m]", "x' [m/s]", "q [rad]", "q' [rad/s]"}),
        ("energies", {"t [s]", "energy [J]"}),
        ("reactions", {"t [s]", "force [N]", "moment [N·m]"}),
    ],
)
def test_every_plot_has_units_on_its_axes(
    motion: mq.Motion, what: str, labels: set[str], tmp_path: Path
) -> None:
    pytest.importorskip("matplotlib")
    figure = motion.plot(what)
    found = {
        text for axes in figure.axes for text in (axes.get_xlabel(), axes.get_ylabel()) if text
    }
    assert found == labels
    assert all(np.size(line.get_xdata()) for axes in figure.axes for line in axes.lines)
    figure.savefig(tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 10_000


def test_a_notebook_shows_plots_without_being_set_up(motion: mq.Motion) -> None:
    pytest.importorskip("matplotlib")
    coin = mq.textbook.load("rolling_coin")
    speeds = mq.sweep_speeds(coin, {"z": coin.values["r"]}, {"spin": 1.0}, [1.0, 2.0])
    swaying = mq.linearize(mq.textbook.load("two_blocks")).response([1.0, 0.0])
    plots: tuple[Any, ...] = (motion.plot(), speeds.plot(), swaying.plot())
    for figure in plots:
        shown: bytes = figure._repr_png_()  # what IPython asks for
        assert shown.startswith(b"\x89PNG")
    again = pickle.loads(pickle.dumps(speeds.plot()))
    assert again.axes[0].get_xlabel() == "speed"


def test_plots_that_do_not_exist_are_refused(
    motion: mq.Motion, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(mq.UnknownNameError, match="unknown plot 'energy'; did you mean 'energies'"):
        motion.plot("energy")
    wrong = "unknown joint, loop or contact 'pim'; did you mean 'pin'"
    with pytest.raises(mq.UnknownNameError, match=wrong):
        motion.plot("reactions", "pim")
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    monkeypatch.delitem(sys.modules, "mecanique.motion.output.shown", raising=False)
    with pytest.raises(
        mq.InputError,
        match=r"plots need matplotlib; install it with: pip install 'mecanique\[plot\]'",
    ):
        motion.plot()


def test_units_follow_the_joints_and_the_map() -> None:
    q, s = mq.coordinate("q"), mq.coordinate("s")
    L = mq.Parameter("L", 2.0)
    mechanism = mq.Mechanism(
        "all",
        (mq.Body("ground"), *(mq.Body(name, mq.box(1.0, (1, 1, 1))) for name in "abcde")),
        (
            mq.Revolute("r", "ground", "a"),
            mq.Prismatic("p", "a", "b"),
            mq.Floating("f", "ground", "c"),
            mq.Prismatic("d", "ground", "d"),
            mq.Prismatic("e", "ground", "e"),
        ),
        coordinates=mq.Coordinates(
            ("q", "s"), {"r": 2 * q, "p": s + 0.5, "d": L * s / 2, "e": L * q}
        ),
        parameters=(L,),
    )
    found = units(mechanism)
    assert found["q"] == "rad"
    assert found["q'"] == "rad/s"
    assert found["s"] == "m"
    assert found["f_x"] == "m"
    assert found["f_qw"] == "1"
    assert found["f_vx"] == "m/s"
    assert found["f_wz"] == "rad/s"
    bead = units(mq.textbook.load("particle_on_circle"))
    assert "" not in bead.values()
