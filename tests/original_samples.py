"""Files that several engines read themselves."""

from __future__ import annotations

from typing import Literal

import mecanique as mq
from mecanique.urdf import read_urdf

ARM = """<robot name="r">
<link name="base"/>
<link name="l"><inertial><origin xyz="0 0 -0.5"/><mass value="1"/>
<inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="k"><inertial><origin xyz="0 0.1 -0.2"/><mass value="0.5"/>
<inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0.001" ixz="0" iyz="0"/></inertial></link>
<joint name="j" type="revolute"><parent link="base"/><child link="l"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="i" type="continuous"><parent link="l"/><child link="k"/><origin xyz="0 0 -1"/>
<axis xyz="0 0.6 0.8"/><mimic joint="j"/></joint>
</robot>"""

LINK = """<link name="{}"><inertial><origin xyz="0.1 0 0.2" rpy="0.1 0.2 0.3"/><mass value="2"/>
<inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0" ixz="0.01" iyz="0"/></inertial></link>"""
PAIR = """<robot name="r">{}{}<joint name="j" type="TYPE"><parent link="a"/><child link="b"/>
<origin xyz="0 0.1 1" rpy="0.3 0 0.2"/><axis xyz="AXIS"/></joint></robot>""".format(
    *map(LINK.format, "ab")
)
MOVING = """<mujoco model="m"><worldbody>
<body name="b" pos="1 2 3" euler="30 0 0"><freejoint name="f"/>
<geom type="box" size=".1 .2 .3" pos="0.1 0 0"/>
<body name="c" pos="0 0 1" euler="0 20 0"><joint name="s" type="ball" pos="0.1 0 0" damping="0.2"/>
<geom size=".1" pos="0.3 0 0"/></body></body>
<body name="d"><freejoint/><geom type="box" size=".1 .2 .3" pos="0 0.1 0"/></body>
</worldbody></mujoco>"""
JOINTED = """<sdf version="1.9"><model name="m"><link name="a">MASS</link>
<link name="b"><pose>1 0 0 0.2 0.3 0</pose>MASS</link><link name="c">MASS</link>
<joint name="u" type="universal"><parent>a</parent><child>b</child><pose>0 0 1 0.3 0 0</pose>
<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2></joint>
<joint name="s" type="ball"><parent>b</parent><child>c</child><pose>0 0 1 0.3 0 0</pose></joint>
</model></sdf>""".replace("MASS", "<inertial><pose>0.1 0 0.2 0 0 0</pose><mass>2</mass></inertial>")


CARRIED = """<robot name="r"><link name="base"/>{}{}
<joint name="i" type="continuous"><parent link="base"/><child link="a"/>
<origin xyz="0.2 0 0.3" rpy="0.4 0 0.1"/><axis xyz="0.8 0 0.6"/></joint>{}</robot>""".format(
    *map(LINK.format, "ab"), PAIR[PAIR.index("<joint") : PAIR.index("</robot>")]
)


def carried(kind: str, axis: str) -> mq.Mechanism:
    """A pair on a hinge, so that what the second joint shifts counts."""
    return read_urdf(CARRIED.replace("TYPE", kind).replace("AXIS", axis))


def pair(
    kind: str, axis: str = "0 0.6 0.8", root: Literal["fixed", "floating"] = "fixed"
) -> mq.Mechanism:
    return read_urdf(PAIR.replace("TYPE", kind).replace("AXIS", axis), root=root)
