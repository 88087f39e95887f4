"""Whatever is done to a URDF, the outcome is a sound mechanism or a clear refusal, and soon."""

from __future__ import annotations

import random
import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from urdf_mutations import SAMPLE, STRANGE, mutated, outcome

import mecanique as mq
from mecanique.safe_xml import MOST_ELEMENTS
from mecanique.urdf.lint import lint
from mecanique.urdf.parse import MOST_BYTES
from mecanique.urdf.read import read_urdf


def test_the_sample_is_read() -> None:
    assert outcome(SAMPLE) == "read"
    mechanism = read_urdf(SAMPLE)
    assert (len(mechanism.forces), len(mechanism.loops), mechanism.nq) == (5, 1, 5)


@settings(max_examples=150, deadline=5000, derandomize=True)
@given(rng=st.randoms(use_true_random=False), count=st.integers(1, 6))
def test_damaged_texts(rng: random.Random, count: int) -> None:
    assert outcome(mutated(SAMPLE, rng, count)) in ("read", "refused")


@settings(max_examples=100, deadline=5000, derandomize=True)
@given(st.text(min_size=1))
def test_any_text(text: str) -> None:
    assert outcome(f"<robot name='r'><link name='{text}'/></robot>") in ("read", "refused")
    assert outcome(f"<{text}") == "refused"


@settings(max_examples=100, deadline=5000, derandomize=True)
@given(data=st.binary())
def test_any_bytes(data: bytes, tmp_path_factory: pytest.TempPathFactory) -> None:
    file = tmp_path_factory.getbasetemp() / "any.urdf"
    for content in (data, b"\xef\xbb\xbf" + data, SAMPLE.encode()[: len(data) * 10] + data):
        file.write_bytes(content)
        assert any(finding.severity == "error" for finding in lint(file))
        with pytest.raises(mq.UrdfError):
            read_urdf(file)


@pytest.mark.parametrize("strange", STRANGE)
def test_each_strange_value_at_each_place(strange: str) -> None:
    """Every 14th value of the sample is replaced; the next strange value begins one further on."""
    parts = SAMPLE.split('"')
    first = 3 + 2 * (STRANGE.index(strange) % 14)
    outcomes = {
        outcome('"'.join([*parts[:k], strange, *parts[k + 1 :]]))
        for k in range(first, len(parts) - 1, 28)
    }
    assert outcomes <= {"read", "refused"}


def _seconds(text: str) -> float:
    start = time.process_time()
    assert outcome(text) == "refused"
    return time.process_time() - start


def _links(count: int) -> str:
    return "".join(f'<link name="l{k}"/>' for k in range(count))


def _joints(count: int, more: str = "") -> str:
    return "".join(
        f'<joint name="j{k}" type="continuous"><parent link="l{k}"/>'
        f'<child link="l{k + 1}"/><axis xyz="0 0 1"/>'
        f"{more.format(k=k, next=(k + 1) % count)}</joint>"
        for k in range(count)
    )


def test_entity_bombs_and_external_entities_end_at_once() -> None:
    ten = "".join(f'<!ENTITY e{k + 1} "{f"&e{k};" * 10}">' for k in range(10))
    bomb = f'<!DOCTYPE r [<!ENTITY e0 "x">{ten}]><robot name="&e10;"/>'
    outside = '<!DOCTYPE r SYSTEM "file:///dev/zero"><robot name="r"/>'
    for text in (bomb, outside):
        assert _seconds(text) < 0.5
        assert [finding.code for finding in lint(text)] == ["M003"]


@pytest.mark.parametrize(
    "text",
    [
        "<robot name='r'>" + "<a>" * 200_000,
        pytest.param(
            "<robot name='r'>" + "<a/>" * (MOST_ELEMENTS + 1) + "</robot>", marks=pytest.mark.slow
        ),
        "<robot name='" + "r" * MOST_BYTES + "'/>",
    ],
    ids=["deep", "many", "large"],
)
def test_caps(text: str) -> None:
    (finding,) = lint(text)
    assert finding.code == "M004"


@pytest.mark.slow
def test_large_faulty_files_end_soon() -> None:
    """Every fault at every joint of thousands: no step is quadratic."""
    count = 3000
    mimic_cycle = '<mimic joint="j{next}"/>'
    pairs = "".join(
        f'<joint name="a{k}" type="fixed"><parent link="l{k}"/><child link="l{k + 1}"/></joint>'
        f'<joint name="b{k}" type="fixed"><parent link="l{k + 1}"/><child link="l{k}"/></joint>'
        for k in range(2, count, 2)
    )
    spring = SAMPLE[
        SAMPLE.index("  <drake:linear_spring") : SAMPLE.index("  <drake:ball_constraint>")
    ]
    texts = [
        f'<robot name="r">{_links(count + 1)}{_joints(count, mimic_cycle)}</robot>',
        f'<robot name="r">{_links(count + 1)}{_joints(count)}{_joints(count)}</robot>',
        f'<robot name="r">{_links(count + 1)}{pairs}</robot>',
        f'<robot name="r">{_links(1)}{_joints(count)}</robot>',
        f'<robot name="r">{_links(count)}</robot>',
        f'<robot name="r">{"<link name=" + chr(34) + "l" + chr(34) + "/>" * 1}'
        f"{_links(3)}{spring * 1000}</robot>",
    ]
    for text in texts:
        assert _seconds(text) < 10


@pytest.mark.slow
def test_long_chains_end_soon() -> None:
    count = 5000
    start = time.process_time()
    assert outcome(f'<robot name="r">{_links(count + 1)}{_joints(count)}</robot>') == "read"
    assert time.process_time() - start < 20
