"""Quantities of the body in files: displacement, stresses and what follows from them, SI units.

Axes of the files: x along +Q, y upwards, out of the body, whose surface is y = 0.
"""

import numpy as np

from ..scene.output import FIELDS, STRESSES

UNITS = dict.fromkeys(FIELDS, "Pa") | {"displacement": "m", "energy_density": "J/m³"}
MEANING = {
    "displacement": "displacement",
    **{name: f"component {name[-2:]} of the stress" for name in STRESSES},
    "principal_1": "largest principal stress",
    "principal_2": "middle principal stress",
    "principal_3": "smallest principal stress",
    "max_shear": "largest shear stress, (principal_1 - principal_3)/2",
    "von_mises": "von Mises equivalent stress",
    "energy_density": "elastic energy per volume",
}
DOWN_TO_UP = np.array([1.0, 1.0, -1.0, 1.0])  # signs of xx, yy, xy, zz where y turns round


def from_stress(stress: np.ndarray, young, nu: float) -> dict[str, np.ndarray]:
    """Every field but the displacement, from xx, yy, xy, zz (..., 4) [Pa] in plane strain and E (...) [Pa].

    The energy density is infinite where E is 0 or infinite, on the surface of a power law.
    """
    xx, yy, xy, zz = np.moveaxis(np.asarray(stress, float), -1, 0)
    mean, radius = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
    principal = np.sort(np.stack([mean - radius, mean + radius, zz]), axis=0)
    differences = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    finite = np.isfinite(young) & (young > 0)
    energy = (1 + nu) * (xx**2 + yy**2 + 2 * xy**2 - nu * (xx + yy) ** 2) / (2 * np.where(finite, young, 1.0))
    found = dict(zip(STRESSES, (xx, yy, xy, zz), strict=True))
    return found | {
        "principal_1": principal[2],
        "principal_2": principal[1],
        "principal_3": principal[0],
        "max_shear": (principal[2] - principal[0]) / 2,
        "von_mises": np.sqrt(differences / 2 + 3 * xy**2),
        "energy_density": np.where(finite, energy, np.inf),
    }
