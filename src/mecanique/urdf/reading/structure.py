"""The tree of links and joints: one root, no cycle, no second parent."""

from __future__ import annotations

from mecanique.urdf.findings import Report
from mecanique.urdf.reading.joints import JointText
from mecanique.urdf.reading.links import Link


def root_of(
    links: list[Link], joints: list[JointText], report: Report, complete: bool
) -> str | None:
    """Return the name of the root link; report joints that form no tree, and return None.

    Args:
        links: all links.
        joints: all joints.
        report: where faults are noted.
        complete: whether every joint and link could be read; if not, disconnected parts are not
            reported.
    """
    by_name = {link.name: link for link in links}
    carrier: dict[str, JointText] = {}
    sound = complete and bool(links)
    for joint in joints:
        before = len(report.findings)
        for role, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in by_name:
                report.add("M107", joint.element, joint.where, f"its {role} {name!r} is no link")
        if joint.parent == joint.child:
            report.add(
                "M108", joint.element, joint.where, f"it joins link {joint.child!r} to itself"
            )
        elif joint.child in carrier:
            other = carrier[joint.child]
            message = (
                f"its child {joint.child!r} is the child of {other.where} "
                f"at line {other.element.line} already"
            )
            report.add("M109", joint.element, joint.where, message)
        carrier.setdefault(joint.child, joint)
        sound = sound and len(report.findings) == before
    if not sound:
        return None
    roots = [link for link in links if link.name not in carrier]
    children: dict[str, list[str]] = {}
    for joint in joints:
        children.setdefault(joint.parent, []).append(joint.child)
    reached: set[str] = set()
    _reach([link.name for link in roots], children, reached)
    for link in links:
        if link.name not in reached:
            cycle = _cycle(link.name, carrier)
            report.add("M110", link.element, link.where, f"it hangs on itself: {cycle}")
            _reach([link.name], children, reached)
    for link in roots[1:]:
        message = f"it is no joint's child, and neither is link {roots[0].name!r}"
        report.add("M111", link.element, link.where, message)
    return roots[0].name if len(roots) == 1 and not report.stopped else None


def _reach(start: list[str], children: dict[str, list[str]], reached: set[str]) -> None:
    """Add all links that hang from some links."""
    reached.update(start)
    waiting = list(start)
    while waiting:
        for child in children.get(waiting.pop(), ()):
            if child not in reached:
                reached.add(child)
                waiting.append(child)


def _cycle(link: str, carrier: dict[str, JointText]) -> str:
    chain = [link]
    while carrier[chain[-1]].parent not in chain[:6] and len(chain) < 6:
        chain.append(carrier[chain[-1]].parent)
    names = [*chain, carrier[chain[-1]].parent]
    return " ← ".join(names)
