"""Find what is wrong in a URDF, line by line, and mend what has one safe remedy."""

from __future__ import annotations

from pathlib import Path

import mecanique as mq
from mecanique.urdf.lint import as_text, mend

FAULTY = """<robot>
  <link name="base"/>
  <link name="arm">
    <inertial>
      <origin xyz="0 0 -0.3"/>
      <mass value="2.0"/>
      <inertia ixx="0.06" iyy="0.06" izz="0.2"/>
    </inertial>
  </link>
  <joint name="hinge" type="continuous">
    <parent link="base"/>
    <child link="arm"/>
    <axis xyz="0 -2 0"/>
  </joint>
</robot>
"""


def main() -> None:
    path = Path("arm.urdf")
    # no body has such moments: izz is more than ixx + iyy, a slip of the decimal point that only
    # its author can mend
    mended = mend(FAULTY, name="arm")
    for text in (FAULTY, mended, mended.replace('izz="0.2"', 'izz="0.02"')):
        path.write_text(text, encoding="utf-8")
        print(as_text(mq.lint(path)), end="\n\n")
    print(mq.read_urdf(path))


if __name__ == "__main__":
    main()
