"""A robot from a URDF file: two derivations of its equations against Pinocchio's."""

from __future__ import annotations

import mecanique as mq


def main() -> None:
    mechanism = mq.read_urdf(mq.robot("solo12"), root="fixed")
    print(mechanism)
    verdict = mq.verify(mechanism, samples=20)
    print(verdict)
    assert verdict.agrees


if __name__ == "__main__":
    main()
