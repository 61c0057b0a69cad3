"""Plane-strain contact and fretting of power-law graded half-planes: closed forms, and two mesh-free solvers.

Numbers in brackets are the equations of Heß, Giesa, Riechert, Wilhayn, Appl. Sci. 2026, 16(1), 473;
[X1] ... [X7] mark results beyond the paper. docs/equations.md lists where each is found and tested.
"""

from .bulk_strain import StretchedLoop, StretchedPartialSlip
from .checks import ContactNotConverged, UndefinedDisplacementError
from .coupled import CoupledLoop
from .cylinder import CylinderContact
from .fretting import FrettingLoop
from .half_plane.layered_kernel import LayeredKernel
from .half_plane.solver import HalfPlaneContact
from .half_plane.surface_kernel import PowerLawKernel
from .material import GradedHalfPlane
from .normal import ProfileContact, normal_contact
from .partial_slip import PartialSlip
from .point_force import point_force_displacement, point_force_stress
from .pressing_with_friction import PressingWithFriction
from .profile import PowerProfile, Profile
from .punch_superposition import PunchSuperposition
from .spring_path import SpringPath
from .tangential import UniformShift, from_displacement, from_traction
from .two_bodies import GradedPair

__all__ = [
    "ContactNotConverged",
    "CoupledLoop",
    "CylinderContact",
    "FrettingLoop",
    "GradedHalfPlane",
    "GradedPair",
    "HalfPlaneContact",
    "LayeredKernel",
    "PartialSlip",
    "PowerLawKernel",
    "PowerProfile",
    "PressingWithFriction",
    "Profile",
    "ProfileContact",
    "PunchSuperposition",
    "SpringPath",
    "StretchedLoop",
    "StretchedPartialSlip",
    "UndefinedDisplacementError",
    "UniformShift",
    "from_displacement",
    "from_traction",
    "normal_contact",
    "point_force_displacement",
    "point_force_stress",
]
