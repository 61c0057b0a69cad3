"""Press a rigid cylinder onto a graded half-plane without friction:  python -m simulations.indentation [SCENE.toml]."""

from . import fretting
from .command.command import run

DEFAULT_SCENE = """\
title = "Frictionless indentation of a graded half-plane"
[solid]
E0 = 210e9            # Pa, modulus at depth y0
k = 0.3
nu = 0.3
y0_over_a0 = 10.0
[indenter]
R = 0.1               # m
[load]
P = 1.0e6             # N/m
"""


def main(arguments: list[str]):
    """A scene without tangential load: half the domain, no friction in the forms, the unknowns or the files."""
    fretting.main(arguments, "simulations.indentation", __doc__, DEFAULT_SCENE, has_friction=False)


if __name__ == "__main__":
    run(main)
