"""The commands of the package:  python -m simulations."""

from importlib.util import find_spec

from . import __version__

COMMANDS = {
    "fretting [SCENE.toml]": "press a cylinder onto a graded half-plane and rock it; without a scene, the default one",
    "indentation [SCENE.toml]": "press it without friction",
    "report DIR": "one page about a run",
    "studies.ablation": "what each effect costs and changes",
    "studies.body_stress DIR": "stress in the body at the states of a run",
    "studies.claims": "the paper's sentences, decided by numbers",
    "studies.cost": "error against seconds",
    "studies.bulk_strain": "what bulk strain does to traction and stick zone",
    "studies.coupling": "what coupling changes",
    "studies.figures": "the paper's figures",
    "studies.maps": "which grading loses least energy",
    "studies.stability": "hard cases",
}


def main():
    """Print them, those that are there."""
    print(f"graded-fretting {__version__}\n\npython -m simulations.COMMAND [--help]")
    for command, what in COMMANDS.items():
        if find_spec(f"{__package__}.{command.partition(' ')[0]}"):
            print(f"  {command:26s} {what}")


if __name__ == "__main__":
    main()
