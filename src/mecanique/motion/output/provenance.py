"""State where a mechanism comes from in a saved motion, and find it again."""

from __future__ import annotations

from itertools import islice, product
from typing import Any

from mecanique.errors import InputError, MecaniqueError
from mecanique.model.mechanism import Mechanism

MAX_TRIALS = 1000
"""Most combinations of whole-number options to try."""


def provenance(mechanism: Mechanism) -> dict[str, Any]:
    """Return what identifies a mechanism: names, values, and its catalogue entry or URDF text."""
    about: dict[str, Any] = {
        "mechanism": mechanism.name,
        "coordinates": list(mechanism.coordinates.names),
        "velocities": list(mechanism.velocities),
        "parameters": mechanism.values,
        "catalogue": _from_catalogue(mechanism),
    }
    if about["catalogue"] is None:
        from mecanique.urdf import write_urdf

        try:
            about["urdf"] = write_urdf(mechanism)
        except MecaniqueError:
            # not every mechanism can be written; the user must then give it to load the motion
            about["urdf"] = None
    return about


def recover(about: dict[str, Any], mechanism: Mechanism | None, path: str) -> Mechanism:
    """Return the mechanism of a saved motion, checked against what the file states."""
    if mechanism is None:
        place = about.get("catalogue")
        if not isinstance(place, dict):
            raise InputError(
                f"{path!r} is a motion of {about.get('mechanism')!r}, "
                "which is not in the catalogue; "
                "give the mechanism: Motion.load(path, mechanism)"
            )
        from mecanique import textbook

        try:
            mechanism = textbook.load(str(place["system"]), **place["values"])
        except (MecaniqueError, KeyError, TypeError) as error:
            raise InputError(
                f"{path!r} names a system that the catalogue does not have: {error}"
            ) from None
    for what, have in (
        ("coordinates", list(mechanism.coordinates.names)),
        ("velocities", list(mechanism.velocities)),
        ("parameters", mechanism.values),
    ):
        if about.get(what) != have:
            raise InputError(
                f"{path!r} is a motion of {about.get('mechanism')!r} with other {what}: "
                f"expected {about.get(what)}, got {have}"
            )
    return mechanism


def _from_catalogue(mechanism: Mechanism) -> dict[str, Any] | None:
    """The system and the values that build this very mechanism, if the catalogue has it."""
    from mecanique import textbook

    if not textbook.catalogue.is_known(mechanism.name):
        return None
    system = textbook.entry(mechanism.name)
    known = {parameter.symbol for parameter in system.parameters}
    values: dict[str, float] = {
        symbol: value for symbol, value in mechanism.values.items() if symbol in known
    }
    # options are not among the parameters of what they build; they count bodies or joints, so small
    # numbers do
    numbers = range(1, len(mechanism.bodies) + 2)
    for chosen in islice(product(numbers, repeat=len(system.options)), MAX_TRIALS):
        trial = dict(zip(system.options, chosen, strict=True))
        try:
            if textbook.load(mechanism.name, **values, **trial) == mechanism:
                return {"system": mechanism.name, "values": {**values, **trial}}
        except MecaniqueError:
            continue
    return None
