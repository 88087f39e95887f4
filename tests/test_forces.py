"""Every type of force describes itself and has a law on each side of the wall."""

from __future__ import annotations

import pytest

import mecanique as mq
from mecanique.derivation.laws import laws_of
from mecanique.derivation.scalars.elementary import sqrt
from mecanique.derivation.scalars.series import Ring
from mecanique.derivation.symbolic.forces import assume_length, length_names
from mecanique.errors import DerivationError, EngineError
from mecanique.model.force_base import BodyLoad, FieldLoad, JointLoad, LineLoad
from mecanique.reference.engine.forces.loads import law_of

FORCES: tuple[mq.AnyForce, ...] = (
    mq.Spring("spring", "a", (0, 0, 0), "b", (1, 0, 0), stiffness=2.0, free_length=1.0),
    mq.Damper("damper", "a", (0, 0, 0), "b", (1, 0, 0), damping=3.0),
    mq.JointSpring("joint spring", "hinge", stiffness=2.0, reference=0.5),
    mq.JointDamper("joint damper", "hinge", damping=3.0),
    mq.JointForce("drive", "hinge", force=mq.time()),
    mq.CentralForce("central", "a", (0, 0, 0), "b", (1, 0, 0), -1.0 / mq.distance()),
    mq.Potential("well", "hinge", mq.coordinate("q") ** 2),
    mq.PotentialField("field", "a", (0, 0, 1), mq.position()[2] ** 2),
    mq.Force("force", "a", (0, 0, 1), (0, mq.coordinate("q"), 0), axes="b"),
    mq.Torque("torque", "a", (0, 0, mq.velocity("q"))),
)


def leaves(base: type) -> set[type]:
    return {base} if not base.__subclasses__() else set().union(*map(leaves, base.__subclasses__()))


def test_every_type_is_among_the_samples() -> None:
    types = {leaf for base in (LineLoad, JointLoad, BodyLoad, FieldLoad) for leaf in leaves(base)}
    types = {leaf for leaf in types if leaf.__module__ == mq.Spring.__module__}
    assert {type(force) for force in FORCES} == types
    for leaf in types:
        assert leaf.__name__ in mq.__all__


@pytest.mark.parametrize("force", FORCES, ids=lambda force: force.name)
def test_a_force_describes_itself(force: mq.AnyForce) -> None:
    assert force.kind in {"spring", "damper", "load"}
    assert force.conservative == (force.kind == "spring" or force.name in ("central", "field"))
    assert force.coefficient
    varies = {"drive": {"t"}, "force": {"q"}, "torque": {"q'"}}
    varies |= {"central": {"distance"}, "well": {"q"}, "field": {"position_z"}}
    assert force.symbols == varies.get(force.name, set())
    if isinstance(force, LineLoad):
        assert [end.body for end in force.ends] == ["a", "b"]
    if isinstance(force, BodyLoad):
        assert (force.wrench.force is None) == (force.name == "torque")
        assert force.bodies == (("a", "b") if force.name == "force" else ("a",))


@pytest.mark.parametrize("force", FORCES, ids=lambda force: force.name)
def test_every_force_between_two_ends_has_a_law_on_each_side(force: mq.AnyForce) -> None:
    laws = laws_of(force, lambda scalar: scalar)
    assert bool(laws) == (not isinstance(force, BodyLoad))
    if not isinstance(force, BodyLoad):
        law = law_of(force)
        given = law.drive is not None or law.potential is not None
        assert any((law.stiffness, law.damping, given))


def test_a_force_without_a_law_is_refused() -> None:
    class Muscle(LineLoad):
        kind = "load"
        letter = "name"

    muscle = Muscle("muscle", "a", (0, 0, 0), "b", (1, 0, 0))
    with pytest.raises(DerivationError, match="no law is known for force 'muscle', a Muscle"):
        laws_of(muscle, float)
    with pytest.raises(EngineError, match="no law is known for force 'muscle', a Muscle"):
        law_of(muscle)


def test_a_root_in_a_length_is_the_length_only_where_nothing_is_added_to_it() -> None:
    ring = Ring()
    x, h = ring.coordinate("x"), ring.parameter("h")
    rho, other = (sqrt(x**2 + (k * h) ** 2, name=f"rho{k}") for k in (1, 2))
    lengths = {"spring": rho, "band": other + h, "cord": rho, "bar": x, "rod": h * sqrt(1 + x**2)}
    assert length_names(ring, lengths.items()) == {
        "rho1": "length of the spring and the cord [m]",
        "rho2": "root in the length of the band",
    }
    twice = [("spring", rho), ("band", 2 * rho)]
    for told in (twice, twice[::-1]):
        meanings = length_names(ring, told)
        assert meanings["rho1"].startswith("root in the length of ")
        assert meanings["rho2"] == "root"


def test_a_length_that_is_no_root_is_taken_as_positive_if_it_can_change_its_sign() -> None:
    """A rational length may: √(x + l)² is x + l, and √2 (x + l) for a diagonal."""
    ring = Ring()
    x, l = ring.coordinate("x"), ring.parameter("l")
    for length in (x + l, sqrt(ring.number(2)) * (x + l)):
        (taken,) = assume_length("spring", length)
        assert (taken.subject, taken.positive) == ("the length of the spring", length)
    assert not assume_length("spring", l)
    assert not assume_length("spring", sqrt(x**2 + l**2))
