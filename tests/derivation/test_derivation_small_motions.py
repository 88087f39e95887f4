"""Small motions in letters, as LaTeX aligns them."""

from __future__ import annotations

from systems import derive_system

from mecanique.derivation.linear import linearize_equations


def test_each_line_is_aligned_once_at_its_equals_sign() -> None:
    """Of one degree of freedom; the natural frequency and the damping ratio follow."""
    small = linearize_equations(derive_system("base_excited_mass").derivation, {"u": 0.0})
    assert small.latex() == "\n".join(
        [
            r"\begin{aligned}",
            r"\ddot{u} + \frac{c}{m} \dot{u} + \frac{k u}{m} &= X W^{2} \sin(W t) \\",
            r"\omega &= \sqrt{\frac{k}{m}} \\",
            r"\zeta &= \frac{c}{2 \sqrt{m k}}",
            r"\end{aligned}",
        ]
    )


def test_the_equations_of_several_stand_one_below_the_other() -> None:
    place = {"x": 0.0, "q": 0.0}
    small = linearize_equations(derive_system("cart_pole").derivation, place)
    lines = small.latex().split("\n")
    assert lines[0] == r"\begin{aligned}"
    assert lines[-1] == r"\end{aligned}"
    assert [line.count("&=") for line in lines[1:-1]] == [1, 1]
    assert [line.endswith(r" \\") for line in lines[1:-1]] == [True, False]
