"""The rules of the linter: what each code means, why it matters and how to mend it.

An "error" is what `read_urdf(strict=True)` refuses; without strict, those errors are read past
that no equation of motion needs. A "warning" is likely a mistake, or says that something
which moves the mechanism is left out. An "info" says that other programs read the same text
differently, or what is not used.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import cast, final

from mecanique.model.mechanism.origin import Severity
from mecanique.urdf.limits import MOST_DEPTH, MOST_VELOCITIES


@final
@dataclass(frozen=True)
class Rule:
    """A rule of the linter.

    Args:
        code: e.g. "M204"; M0 files, M1 structure, M2 masses, M3 joints, M4 mimic, M5 pictures, M6
            drake: tags, M7 engines.
        name: the rule in words, e.g. "triangle-inequality".
        severity: of its findings.
        why: why it matters.
        remedy: how to mend what it finds.
    """

    code: str
    name: str
    severity: Severity
    why: str
    remedy: str


_TABLE = """
# M0: the file, its XML and what may be read of it

M001 unreadable-file error
    Nothing can be read from it.
    > Give the path of a robot's description, or its text.

M002 malformed-xml error
    No XML reader can go on from there.
    > Mend the XML at this line.

M003 document-type error
    Entities make a text grow without bound or read other files.
    > Remove the <!DOCTYPE …>; no description needs one.

M004 too-large error
    It would fill the memory.
    > Split the robot, or remove what does not describe it.

M005 not-a-robot error
    It describes no robot.
    > Name a file whose outermost element is <robot>, or in other formats <mujoco> or <sdf>.

M006 unexpanded-xacro error
    Macros and ${…} are no numbers; engines drop or zero what they cannot read.
    > Read the .xacro file itself (extra xacro), or expand it: xacro FILE.xacro > FILE.urdf.

M007 late-declaration error
    XML allows nothing before its declaration, and strict readers refuse the file.
    > Remove what stands before <?xml … ?>.

M008 xacro-in-urdf info
    Engines that read the file itself drop or zero what they cannot read.
    > Call it .xacro, or expand it: xacro FILE > OTHER.urdf.

# M1: elements, names and the tree of links

M101 no-robot-name error
    URDF parsers refuse the file.
    > Add name=… to <robot>.

M102 no-links error
    There is nothing to move.
    > Describe at least one <link>.

M103 missing error
    Engines drop the element or take a silent default.
    > Write it out.

M104 bad-number error
    Pinocchio drops the whole inertial at an unreadable number, others take zero.
    > Write plain numbers with a decimal point, separated by spaces.

M105 bad-name error
    Nothing can refer to it safely.
    > Give it a printable name.

M106 duplicate-name error
    It is unclear which one is meant.
    > Rename one of them.

M107 unknown-link error
    The joint hangs in the air.
    > Correct the name or add the link.

M108 self-joint error
    A link cannot move against itself.
    > Give the joint another child.

M109 two-parents error
    URDF describes trees; a second parent would close a loop.
    > Keep one of the joints.

M110 cycle error
    No link of the cycle hangs on the root; Pinocchio drops them.
    > Open the cycle.

M111 disconnected error
    A URDF has one root; the rest would vanish or be refused.
    > Join all parts by joints to one root.

M112 duplicate-element error
    Engines read the first or the last one.
    > Keep one.

M113 misspelt warning
    What is misspelt is silently ignored by every engine.
    > Correct the spelling.

M114 reserved-name warning
    The name has a meaning of its own in an engine: the link or joint may be mistaken or
    ignored.
    > Choose another name.

M115 not-sound error
    The equations of motion would be meaningless.
    > See the message.

M116 blank-in-number warning
    urdfdom, the parser of Pinocchio and ROS, reads no number with a blank behind it, and no
    vector with tabs or line breaks; others do.
    > Separate numbers by single blanks, with none around them (--fix does).

# M2: masses, centers of mass and inertias

M201 negative-mass error
    No body weighs less than nothing.
    > Give a mass of at least 0 kg.

M202 negative-inertia error
    Kinetic energy may be negative; MuJoCo refuses, Drake warns and puts in a ball of water of
    the same mass.
    > Compute the inertia again (--fix --balance writes the nearest one of a real body).

M203 triangle-inequality error
    No distribution of mass has these principal moments; Pinocchio takes them silently, MuJoCo
    refuses, Drake warns and puts in a ball of water of the same mass.
    > Compute the inertia about the center of mass again, with enough digits (--fix --balance
      writes the nearest one of a real body).

M204 inertia-without-mass warning
    A body that resists turning has mass; MuJoCo refuses it, Drake warns and puts in a ball of
    water of 1 kg.
    > Give the mass, with enough digits.

M205 point-mass info
    It does not resist turning; Pinocchio's forward dynamics fails where nothing else does.
    > Give the inertia about the center of mass.

M206 massless-motion warning
    The mass matrix is singular: accelerations are undetermined, Pinocchio answers NaN, MuJoCo
    refuses.
    > Give the moving links mass, or make the joint fixed.

M207 tiny-mass warning
    Pinocchio loses the lever of masses below 2.2e-16 kg, silently.
    > Use other units, or drop the mass.

M208 inertia-units warning
    Inertias in g·mm², kg·mm² or about another point are the most common mistakes in URDF
    files.
    > Give kg·m² about the center of mass.

M209 mass-units warning
    A mass in grams is a thousand times too heavy.
    > Give the mass in kg.

M210 inertia-about-wrong-point warning
    URDF means the inertia about the center of mass, where <inertial><origin> puts it.
    > Give the center in <inertial><origin> and the inertia about it.

M211 root-mass info
    With a fixed root it moves nothing, and ROS warns about it; with a floating root it
    counts.
    > Leave it, or put an empty root link before it.

M212 sides-differ warning
    A slip in one of two sides, such as a sign that was not mirrored, escapes every engine.
    > Compare both links: mirrored at the plane x–z, y, ixy and iyz change their signs.

M213 center-outside warning
    A center of mass outside of the body is likely in other units or another frame.
    > Give the center in the link's frame, in meters (`mecanique inertia` computes it).

M214 density warning
    No material is denser than osmium, and no part lighter than air.
    > Compare mass and shape, e.g. their units (`mecanique inertia`).

# M3: joints, their axes, limits and damping

M301 unknown-joint-type error
    How it moves is not known.
    > Use a type of URDF or of <drake:joint>.

M302 zero-axis error
    It points nowhere; Pinocchio answers NaN.
    > Give the direction.

M303 axis-not-unit warning
    Every engine makes it a unit vector.
    > Write a unit vector (--fix does).

M304 axis-missing warning
    URDF means x; many people mean z.
    > Write the axis (--fix writes x).

M305 planar-axis warning
    Pinocchio and Drake ignore the axis of a planar joint and take z; mecanique takes the axis
    given.
    > Turn the joint's origin so that the normal is z.

M306 inverted-limits error
    No position lies between them.
    > Give lower ≤ upper.

M307 limit-missing warning
    URDF demands effort and velocity of revolute and prismatic joints; Pinocchio and ROS
    refuse the file.
    > Add <limit lower=… upper=… effort=… velocity=…/>, or type="continuous".

M308 locked-by-limits warning
    Bounds left out mean 0 in URDF.
    > Write lower and upper.

M309 degrees warning
    URDF means radians everywhere.
    > Multiply by π/180.

M310 millimeters warning
    URDF means meters everywhere.
    > Divide lengths by 1000.

M311 negative-damping error
    It would feed energy in.
    > Give a damping of at least 0.

M312 damping-of-many error
    The damping of a joint with several coordinates is not modeled; equations without it would
    be wrong.
    > Remove it, or put drake: dampers between points.

M313 friction warning
    Dry friction is left out of the equations here and in Pinocchio and Drake; MuJoCo applies
    it.
    > Set it to 0, or know that it is missing.

M314 joint-dialect warning
    URDF readers differ on which joints stand in <joint> and which in <drake:joint>.
    > Use <joint> for URDF's types and <drake:joint> for ball, planar and universal.

# M4: joints that follow another

M401 mimic-unknown error
    It follows a joint that is not there.
    > Correct the name.

M402 mimic-cycle error
    The joints would follow themselves.
    > Let one of them move freely.

M403 mimic-kind error
    Only joints with one coordinate can follow or be followed.
    > Remove the <mimic>.

M404 mimic-read-differently info
    MuJoCo up to 3.12 drops <mimic>, Pinocchio only obeys it when asked (mimic=True);
    mecanique and Drake obey.
    > Know it when comparing.

M405 mimic-chain warning
    Pinocchio refuses joints that mimic a mimicking joint; mecanique composes them.
    > Mimic the joint that moves freely.

M406 mimic-constant warning
    With multiplier 0 the joint stands still.
    > Use type fixed.

M407 mimic-fixed warning
    A fixed joint cannot follow; the <mimic> is left out.
    > Remove the <mimic>, or let the joint move.

# M5: meshes, shapes and colors

M501 mesh-not-found warning
    It is not drawn.
    > Add its package's folder to --package-path, ROS_PACKAGE_PATH or AMENT_PREFIX_PATH.

M502 mesh-outside error
    A path that climbs out of its package could read any file.
    > Write package://PACKAGE/… without '..'.

M503 no-shape warning
    It is not drawn.
    > Use box, cylinder, sphere or mesh.

M504 flat-shape warning
    It is not drawn.
    > Give positive sizes.

M505 unknown-material warning
    It is drawn in its mesh's own color or none.
    > Describe the material.

M506 color-range warning
    Colors run from 0 to 1.
    > Divide by 255.

M507 collision-unused info
    Contact is not modeled: bodies pass through one another; MuJoCo and Drake collide them.
    > Know it when comparing.

M508 unreadable-mesh warning
    Neither its volume nor its inertia is known, and no page shows it.
    > Write it as STL, OBJ or COLLADA again.

# M6: the tags of Drake and of mecanique

M601 unknown-drake-tag warning
    Neither mecanique nor Drake may know it.
    > Correct the spelling.

M602 drake-value error
    The force is not what was meant.
    > Give every value Drake asks for.

M603 drake-unknown-name error
    The force acts on nothing.
    > Correct the name.

M604 not-modeled error
    Equations without it would be those of another mechanism.
    > Remove it to derive the open tree.

M605 bushing error
    A bushing is modeled where it equals a spring and damper in one joint: its two frames
    coincide at the joint and the joint's axis is one of theirs.
    > Place both frames at the joint, one on its parent, one on its child.

M606 drake-only info
    Pinocchio and MuJoCo ignore all drake: tags.
    > Know it when comparing.

M607 drake-namespace warning
    Strict XML readers refuse a prefix that is not declared.
    > Add xmlns:drake="http://drake.mit.edu" to <robot> (--fix does).

M608 rotor info
    The rotor adds inertia × ratio² at the joint in mecanique and Drake; Pinocchio and MuJoCo
    ignore it.
    > Know it when comparing.

M609 drake-differs info
    The same tag gives another force in Drake.
    > Know it when comparing.

M610 mecanique-only info
    Other programs ignore it: they see loops open and bodies slip, and do not know what guides
    mimic joints.
    > Know it when comparing.

# M7: what engines make of a text

M701 too-many-coordinates warning
    Pinocchio's memory grows with the cube of the number of coordinates (8 GB at 500).
    > Stay at or below {most_velocities} coordinates to verify against Pinocchio.

M702 too-deep warning
    Pinocchio crashes on chains of thousands of links.
    > Stay at or below {most_depth:,}.

M703 not-used info
    It does not enter the equations of motion.
    > There is nothing to mend.

M704 damping-read-differently info
    mecanique, Drake and MuJoCo apply it; Pinocchio reads it and does not.
    > Know it when comparing.

M705 version warning
    Older parsers take only 1.0 and refuse the rest.
    > Write version="1.0" or none.

M706 joint-read-differently info
    Drake leaves a floating joint's child free and refuses <joint type=planar>; MuJoCo makes
    planar three joints.
    > Know it when comparing.
"""
"""Code, name and severity of each rule, then why it matters, and behind ">" how to mend it."""


_BLOCK = re.compile(r"^(M\d+) (\S+) (\w+)\n((?:    .*\n)+)", re.MULTILINE)


def _read_table() -> dict[str, Rule]:
    """Return the rules of the table by code."""
    rules = {}
    for code, name, severity, text in _BLOCK.findall(_TABLE):
        why, remedy = (" ".join(part.split()) for part in text.split("\n    > "))
        if code in ("M701", "M702"):
            remedy = remedy.format(most_velocities=MOST_VELOCITIES, most_depth=MOST_DEPTH)
        rules[code] = Rule(code, name, cast("Severity", severity), why, remedy)
    return rules


RULES: dict[str, Rule] = _read_table()
"""Every rule by its code."""
