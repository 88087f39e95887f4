"""A small engine that replaces Pinocchio where it is not installed: the same names, in NumPy.

It reads the same URDF text and provides the functions of Pinocchio that this package uses, by the
recursions of Featherstone (Rigid Body Dynamics Algorithms, 2008), some hundred times more slowly.
It is independent of the derivation; but as it is our own code, a verdict with it says that the
engine is missing.
"""

from mecanique.reference.standin.algorithms import (
    aba,
    computeFrameJacobian,
    computeGeneralizedGravity,
    computeJointJacobians,
    computeJointJacobiansTimeVariation,
    computePotentialEnergy,
    crba,
    forwardKinematics,
    framesForwardKinematics,
    nonLinearEffects,
    rnea,
)
from mecanique.reference.standin.model import (
    BODY,
    Data,
    JointModelRevoluteUnaligned,
    Model,
    ReferenceFrame,
    StdVec_Force,
    buildModelFromXML,
)
from mecanique.reference.standin.spatial import SE3, Force, Inertia, Motion, log3

__all__ = [
    "BODY",
    "SE3",
    "Data",
    "Force",
    "Inertia",
    "JointModelRevoluteUnaligned",
    "Model",
    "Motion",
    "ReferenceFrame",
    "StdVec_Force",
    "aba",
    "buildModelFromXML",
    "computeFrameJacobian",
    "computeGeneralizedGravity",
    "computeJointJacobians",
    "computeJointJacobiansTimeVariation",
    "computePotentialEnergy",
    "crba",
    "forwardKinematics",
    "framesForwardKinematics",
    "log3",
    "nonLinearEffects",
    "rnea",
]

__version__ = "stand-in"
