"""The terms of each equation are in one unit."""

from __future__ import annotations

import pytest
from systems import derive_system

from mecanique import textbook
from mecanique.cli import derive as derivations
from mecanique.derivation.glossary import find_units

NUMBERS = {"squeezer"}
"""Systems whose description holds plain numbers for quantities with a unit."""

READ = [name for name in textbook.names() if textbook.load(name).nv <= 5 and name not in NUMBERS]


@pytest.mark.parametrize("name", READ)
def test_all_terms_of_an_equation_are_in_one_unit(name: str) -> None:
    equations = derive_system(name)
    if not equations.symbolic:
        pytest.skip(equations.why_not)
    for equation in equations.equations:
        found = find_units(equations.derivation, equation)
        assert None not in found
        assert len(set(found)) == 1


def test_units_are_those_of_the_printed_line() -> None:
    cart = derive_system("two_blocks")
    assert cart.units == ("N", "N")
    pendulum = derive_system("rigid_bar_pendulum")
    assert pendulum.units == ("1/s²",)
    loop = derive_system("slider_crank", "newton_euler")
    assert loop.units == ("N·m", "N", "N", "m", "m")
    said = derivations.derivation(
        textbook.load("two_blocks"), "lagrange", "text", False, units=True
    )
    assert [line[-4:] for line in said.splitlines()] == [" [N]", " [N]"]
