"""Name the forces of a scene: as arrows, and as rows of the ledger of virtual work."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Protocol, TypeVar

from mecanique.model.mechanism import Mechanism
from mecanique.viewing.scene.scene import ArrowUnit


class Named(Protocol):
    """The name of a force, and the body it acts on."""

    @property
    def name(self) -> str:
        """Of the force, the joint or the body."""

    @property
    def kind(self) -> str:
        """What makes it."""

    @property
    def body(self) -> str:
        """The body it acts on."""


AnyAction = TypeVar("AnyAction", bound=Named)


def name_arrows(
    actions: Iterable[AnyAction],
) -> Iterator[tuple[str, AnyAction, ArrowUnit]]:
    """Yield the name of each arrow, its action and the unit of what it shows, force or moment.

    Args:
        actions: the forces on the bodies, in the order of `actions_of`.
    """
    used: dict[str, int] = {}
    for action in actions:
        plain = {"weight": f"weight of {action.body}", "inertia": f"inertia of {action.body}"}
        base = plain.get(action.kind, f"{action.name} on {action.body}")
        parts: tuple[tuple[ArrowUnit, str], ...] = (("N", ""), ("N·m", " moment"))
        for unit, what in parts:
            name = base + what
            used[name] = used.get(name, 0) + 1
            yield (name if used[name] == 1 else f"{name} ({used[name]})"), action, unit


def group_work(
    mechanism: Mechanism, actions: Iterable[AnyAction]
) -> list[tuple[str, list[AnyAction]]]:
    """Return the actions of each force, with its name in the ledger.

    Args:
        mechanism: on whose bodies they act.
        actions: every force on the moving bodies.
    """
    held = {each.name for each in (*mechanism.joints, *mechanism.loops, *mechanism.contacts)}
    groups: dict[tuple[str, str], list[AnyAction]] = {}
    for action in actions:
        groups.setdefault((action.kind, action.name), []).append(action)
    found = []
    for (kind, name), group in groups.items():
        titles = {
            "weight": f"weight of {name}",
            "inertia": f"inertia of {name}",
            "reaction": f"reaction at {name}" if name in held else name,
        }
        found.append((titles.get(kind, name), group))
    return found
