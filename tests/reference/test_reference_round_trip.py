"""Written and read again, a mechanism moves as before: the judge is its dynamics, not its XML."""

from __future__ import annotations

import pytest
from reference_samples import states

from mecanique.model import JointForce, Mechanism
from mecanique.model.forces import Force, Torque
from mecanique.reference import Reference
from mecanique.textbook import load, names
from mecanique.urdf import read_urdf, write_urdf


def without_what_urdf_lacks(mechanism: Mechanism) -> Mechanism:
    """The tree alone, without loads and coordinate map."""
    kept = tuple(
        force for force in mechanism.forces if not isinstance(force, (Force, Torque, JointForce))
    )
    return Mechanism(
        mechanism.name,
        mechanism.bodies,
        mechanism.joints,
        kept,
        parameters=mechanism.parameters,
        gravity=mechanism.gravity,
        ground=mechanism.ground,
    )


@pytest.mark.parametrize("name", names())
def test_the_same_tree_comes_back(name: str) -> None:
    own = without_what_urdf_lacks(load(name))
    gravity = [own.evaluate(g) for g in own.gravity]
    back = read_urdf(write_urdf(own), gravity=gravity)
    mine, theirs = Reference(own), Reference(back)
    for q, v, _ in states(own, 3):
        assert theirs.mass_matrix(q) == pytest.approx(mine.mass_matrix(q), rel=1e-13, abs=1e-13)
        assert theirs.bias(q, v) == pytest.approx(mine.bias(q, v), rel=1e-12, abs=1e-12)
        assert theirs.energy(q, v) == pytest.approx(mine.energy(q, v), rel=1e-12, abs=1e-12)
        assert theirs.forces(q, v) == pytest.approx(mine.forces(q, v), rel=1e-11, abs=1e-11)
