"""Write the step of a derivation that names redundant constraints."""

from __future__ import annotations

from mecanique.derivation.numeric.constraints.redundancy import find_redundancy
from mecanique.derivation.symbolic.derivation import Stage
from mecanique.errors import DerivationError
from mecanique.model.mechanism import Mechanism


def redundancy_stages(mechanism: Mechanism, *, of_work: bool = False) -> list[Stage]:
    """Return the step that names redundant constraints, or no step if there are none.

    Args:
        mechanism: the mechanism with the constraints.
        of_work: whether the method is virtual work, in which their forces do not appear.
    """
    if not mechanism.constrained:
        return []
    try:
        rows, shared = find_redundancy(mechanism)
    except DerivationError:  # no position satisfies the constraints
        return []
    if not rows:
        return []
    verb, own = ("follows", "it restrains") if len(rows) == 1 else ("follow", "they restrain")
    sentence = (
        f"In every position that the constraints allow, {_list(rows)} {verb} from the others and "
        f"from how the joints lead the bodies: {own} nothing more."
    )
    if not of_work and len(shared) == 1:
        sentence += f" The force of {shared[0]} is undetermined."
    elif not of_work:
        sentence += (
            f" The forces of {_list(shared)} are undetermined individually; only their combined "
            "effect follows from the motion."
        )
    return [Stage("Redundant constraints", sentence, ())]


def _list(names: tuple[str, ...]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if names[1:] else names)
