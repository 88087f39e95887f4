"""Mechanisms as URDF text."""

from mecanique.urdf.write import write_urdf

__all__ = ["write_urdf"]
