"""All commands under one name:  graded-fretting COMMAND …  is  python -m simulations.MODULE …"""

import os
import sys
from difflib import get_close_matches
from runpy import run_module

from .version import __version__

COMMANDS = {  # name: module, its arguments, what it does
    "fretting": ("fretting", "[SCENE.toml]", "press a cylinder onto a graded half-plane and rock it"),
    "indentation": ("indentation", "[SCENE.toml]", "press it without friction"),
    "sweep": ("sweep", "[SCENE.toml] --vary KEY=VALUES", "many scenes, one table"),
    "report": ("report", "DIR", "one page about a run"),
    "ablation": ("studies.ablation", "", "what each effect costs and changes"),
    "body_stress": ("studies.body_stress", "DIR", "stress in the body at the states of a run"),
    "claims": ("studies.claims", "", "the paper's sentences, decided by numbers"),
    "cost": ("studies.cost", "", "error against seconds"),
    "bulk_strain": ("studies.bulk_strain", "", "what bulk strain does to traction and stick zone"),
    "coupling": ("studies.coupling", "", "what coupling changes"),
    "coupled_loops": ("studies.coupled_loops", "", "the reference of coupled loops and its own error"),
    "critical_friction": ("studies.critical_friction", "", "friction above which slip is not unique"),
    "figures": ("studies.figures", "[NUMBER ...]", "the paper's figures"),
    "maps": ("studies.maps", "", "which grading loses least energy"),
    "stability": ("studies.stability", "", "hard cases"),
    "campaign": ("studies.campaign", "", "stated beside true errors of random scenes"),
}
WRONG_INPUT = 2
STACK = ("basix", "dolfinx", "gmsh", "mpi4py", "petsc4py", "ufl")  # which no wheel brings


def main():
    """Run the command that the command line begins with; without one, list them all."""
    name, *arguments = sys.argv[1:] or ["--help"]
    if name == "--version":
        show(f"graded-fretting {__version__}")
    elif name in ("-h", "--help"):
        show(listing())
    elif name in COMMANDS:
        sys.argv[1:] = arguments
        try:
            run_module(f"{__package__}.{COMMANDS[name][0]}", run_name="__main__", alter_sys=True)
        except ModuleNotFoundError as error:
            if error.name not in STACK:
                raise
            sys.exit(f"{error}: the commands need FEniCSx 0.9, which README.md says how to get; `analytic` does not")
    else:
        close = get_close_matches(name, COMMANDS, n=1)
        known = f"did you mean {close[0]}?" if close else f"one of {', '.join(COMMANDS)}"
        print(f"command {name!r} is not known: {known}", file=sys.stderr)
        sys.exit(WRONG_INPUT)


def show(text: str):
    """Print, where somebody listens: as ``| head -1`` does not for long."""
    try:
        print(text, flush=True)
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def listing() -> str:
    """The commands, a line each."""
    lines = [f"graded-fretting {__version__}", "", "graded-fretting COMMAND, or python -m simulations.MODULE; --help"]
    for name, (module, arguments, what) in COMMANDS.items():
        lines.append(f"  {f'{name} {arguments}':38s} {module:25s} {what}")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
