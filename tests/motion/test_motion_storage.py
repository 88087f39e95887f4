from __future__ import annotations

import csv
import json
import sys
import zipfile
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

import mecanique as mq
from mecanique.motion import Event


@pytest.fixture(scope="module")
def motion() -> mq.Motion:
    mechanism = mq.textbook.load("two_blocks", m1=3.0)
    return mq.simulate(mechanism, q=[0.2, -0.1], duration=2.0, events=[Event("home", "q1")])


def test_a_motion_comes_back_as_it_was(motion: mq.Motion, tmp_path: Path) -> None:
    motion.save(tmp_path / "run")
    assert [path.name for path in tmp_path.iterdir()] == ["run.npz"]
    back = mq.Motion.load(tmp_path / "run.npz")
    assert back.mechanism == motion.mechanism
    for name in ("t", "q", "v", "a"):
        np.testing.assert_array_equal(getattr(back, name), getattr(motion, name))
    np.testing.assert_array_equal(back(1.2345).q, motion(1.2345).q)
    np.testing.assert_array_equal(back.energy().total, motion.energy().total)
    assert (back.method, back.statistics) == (motion.method, motion.statistics)
    assert [(e.name, e.t) for e in back.events] == [(e.name, e.t) for e in motion.events]
    assert back.audit().ok


def test_options_of_the_catalogue_are_found_again(tmp_path: Path) -> None:
    mechanism = mq.textbook.load("n_link_pendulum", n=3)
    motion = mq.simulate(mechanism, q={mechanism.coordinates[0]: 0.5}, duration=0.2)
    motion.save(tmp_path / "a.npz")
    assert mq.Motion.load(tmp_path / "a.npz").mechanism == mechanism


def ramp(mass: float, force: float = 1.0) -> mq.Mechanism:
    return mq.Mechanism(
        "ramp",
        (mq.Body("ground"), mq.Body("block", mq.particle(mass))),
        (mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        forces=(mq.Force("push", "block", (0, 0, 0), (force, 0, 0)),),
    )


def test_a_mechanism_outside_the_catalogue_must_be_given_and_is_checked(
    tmp_path: Path, motion: mq.Motion
) -> None:
    path = tmp_path / "ramp.npz"
    mq.simulate(ramp(2.0), duration=1.0).save(path)
    with np.load(path) as file:
        about = json.loads(str(file["about"]))
    assert about["catalogue"] is None
    assert "<robot" in about["urdf"]
    assert mq.Motion.load(path, ramp(2.0))["x"][-1] == pytest.approx(0.25, rel=1e-12)
    with pytest.raises(
        mq.InputError, match=r"'ramp', which is not in the catalogue; give the mechanism"
    ):
        mq.Motion.load(path)
    with pytest.raises(
        mq.InputError, match="a motion of another mechanism than 'ramp': its accelerations differ"
    ):
        mq.Motion.load(path, ramp(3.0))
    with pytest.raises(
        mq.InputError, match=r"with other coordinates: expected \['x'\], got \['q1', 'q2'\]"
    ):
        mq.Motion.load(path, motion.mechanism)


def test_other_parameters_are_reported(motion: mq.Motion, tmp_path: Path) -> None:
    motion.save(tmp_path / "a.npz")
    with pytest.raises(mq.InputError, match="with other parameters"):
        mq.Motion.load(tmp_path / "a.npz", mq.textbook.load("two_blocks"))


def test_an_implicit_method_and_a_quaternion_come_back(tmp_path: Path) -> None:
    mechanism = mq.textbook.load("free_rigid_body")
    v = {name: 1.0 + 0.7 * k for k, name in enumerate(mechanism.velocities)}
    motion = mq.simulate(mechanism, v=v, duration=1.0, rtol=1e-6, method="bdf")
    motion.save(tmp_path / "a.npz")
    back = mq.Motion.load(tmp_path / "a.npz")
    np.testing.assert_array_equal(back([0.1, 0.77]).q, motion([0.1, 0.77]).q)


def rewritten(source: Path, target: Path, **changes: object) -> Path:
    with np.load(source) as file:
        arrays = {name: file[name] for name in file.files}
    for name, value in changes.items():
        if value is None:
            del arrays[name]
        else:
            arrays[name] = np.asarray(value)
    np.savez(target, **arrays)
    return target


def test_damaged_files_are_refused(motion: mq.Motion, tmp_path: Path) -> None:
    good = tmp_path / "good.npz"
    motion.save(good)
    bad = tmp_path / "bad.npz"
    with pytest.raises(mq.InputError, match=r"cannot read .*missing\.npz': No such file"):
        mq.Motion.load(tmp_path / "missing.npz")
    bad.write_bytes(b"not a zip")
    with pytest.raises(mq.InputError, match="is no motion saved by mecanique, or is damaged"):
        mq.Motion.load(bad)
    bad.write_bytes(good.read_bytes()[:-300])
    with pytest.raises(mq.InputError, match="is no motion saved by mecanique, or is damaged"):
        mq.Motion.load(bad)
    with pytest.raises(mq.InputError, match="is no motion saved"):
        mq.Motion.load(rewritten(good, bad, about=None))
    with pytest.raises(
        mq.InputError, match="expected a file of format 'mecanique motion 1', got 'other'"
    ):
        mq.Motion.load(rewritten(good, bad, about=json.dumps({"format": "other"})))
    with pytest.raises(mq.InputError, match="arrays do not fit each other"):
        mq.Motion.load(rewritten(good, bad, q=motion.q[:-1]))
    with pytest.raises(mq.InputError, match="arrays do not fit each other"):
        mq.Motion.load(rewritten(good, bad, t=motion.t[::-1]))
    with pytest.raises(mq.InputError, match="arrays do not fit each other"):
        mq.Motion.load(rewritten(good, bad, step_v=np.full_like(motion.curve.v, np.nan)))
    pickled = np.array([{"a": 1}], dtype=object)
    with pytest.raises(mq.InputError, match="is no motion saved by mecanique, or is damaged"):
        mq.Motion.load(rewritten(good, bad, t=pickled))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        # the mark of an array, and the brackets of its description
        (b"NUMPY", b"NUMPX", "its arrays do not fit each other"),
        (b"'shape': (", b"'shape': [", "is no motion saved by mecanique, or is damaged"),
    ],
)
def test_an_array_whose_head_is_damaged_is_refused(
    motion: mq.Motion, tmp_path: Path, old: bytes, new: bytes, words: str
) -> None:
    motion.save(tmp_path / "good.npz")
    bad = tmp_path / "bad.npz"
    with zipfile.ZipFile(tmp_path / "good.npz") as good, zipfile.ZipFile(bad, "w") as file:
        for name in good.namelist():
            data = good.read(name)
            file.writestr(name, data.replace(old, new) if name == "step_v.npy" else data)
    with pytest.raises(mq.InputError, match=words):
        mq.Motion.load(bad)


def test_what_cannot_be_written_leaves_nothing_behind(motion: mq.Motion, tmp_path: Path) -> None:
    with pytest.raises(mq.InputError, match=r"cannot write .*: No such file or directory"):
        motion.save(tmp_path / "nowhere" / "a.npz")
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(mq.InputError, match=r"cannot write .*folder\.csv"):
        motion.to_csv(tmp_path / "folder.csv")
    assert [path.name for path in tmp_path.iterdir()] == ["folder.csv"]


def test_csv_has_units_and_every_digit(motion: mq.Motion, tmp_path: Path) -> None:
    motion.to_csv(tmp_path / "a.csv")
    with open(tmp_path / "a.csv", newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    assert header == [
        "t [s]",
        "q1 [m]",
        "q2 [m]",
        "q1' [m/s]",
        "q2' [m/s]",
        "q1'' [m/s²]",
        "q2'' [m/s²]",
    ]
    table = np.array(rows, dtype=float)
    np.testing.assert_array_equal(table, np.column_stack([motion.t, motion.q, motion.v, motion.a]))


def test_a_data_frame_has_the_names(motion: mq.Motion, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pandas")
    frame = motion.to_frame()
    assert tuple(frame.columns) == motion.names
    assert frame.index.name == "t"
    np.testing.assert_array_equal(frame["q2'"], motion["q2'"])
    assert frame.attrs["units"]["q2''"] == "m/s²"
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(
        mq.InputError, match=r"need pandas; install it with: pip install 'mecanique\[frames\]'"
    ):
        motion.to_frame()


def test_parquet_has_units_and_every_digit(motion: mq.Motion, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    motion.to_parquet(tmp_path / "a.parquet")
    table = parquet.read_table(tmp_path / "a.parquet")
    assert table.column_names == ["t", *motion.names]
    for name in motion.names:
        assert np.array_equal(table[name].to_numpy(), motion[name])
    units = json.loads(table.schema.metadata[b"units"])
    assert units.keys() == {"t", *motion.names}
    assert units["t"] == "s"


def test_without_pyarrow_parquet_says_how_to_get_it(
    motion: mq.Motion, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(
        mq.InputError, match=r"need pyarrow; install it with: pip install 'mecanique\[parquet\]'"
    ):
        motion.to_parquet("never.parquet")


def test_every_damaged_file_is_refused_alike(motion: mq.Motion, tmp_path: Path) -> None:
    path = tmp_path / "motion.npz"
    motion.save(path)
    whole = path.read_bytes()
    rng = np.random.default_rng(0)
    for _ in range(300):
        data = bytearray(whole)
        for at in rng.integers(0, len(data), 3):
            data[at] = int(rng.integers(256))
        path.write_bytes(bytes(data))
        with suppress(mq.InputError):
            mq.Motion.load(path)


def test_a_file_that_unpacks_to_far_more_than_it_holds_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "bomb.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("q.npy", bytes(100 * 2**20))
    with pytest.raises(mq.InputError, match=r"is damaged \(its \d+ bytes unpack to 104857600\)"):
        mq.Motion.load(path)
