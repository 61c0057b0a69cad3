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
    "studies.coupling": "what coupling changes",
    "studies.critical_friction": "from which friction on rates of stick and slip are not unique",
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
