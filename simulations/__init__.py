"""Simulations of frictional contact and fretting: from a scene to files, or to arrays.

    from simulations import run
    result = run({"load.amplitude": 0.6})
    print(result.a, result.pressure.shape)

What is exported is loaded when it is first asked for (docs/library.md).
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from .comparison import compare
    from .language import SceneError
    from .library import Result, make_scene, run
    from .programme import SolveError
    from .reference import closed_form, of_same_physics
    from .scene import DEFAULT_SCENE, Scene, language, parse, resolve
    from .simulation import Simulation

_EXPORTS = {
    "compare": "comparison",
    "SceneError": "language",
    "Result": "library",
    "make_scene": "library",
    "run": "library",
    "SolveError": "programme",
    "closed_form": "reference",
    "of_same_physics": "reference",
    "DEFAULT_SCENE": "scene",
    "Scene": "scene",
    "language": "scene",
    "parse": "scene",
    "resolve": "scene",
    "Simulation": "simulation",
}
__all__ = [
    "DEFAULT_SCENE",
    "Result",
    "Scene",
    "SceneError",
    "Simulation",
    "SolveError",
    "closed_form",
    "compare",
    "language",
    "make_scene",
    "of_same_physics",
    "parse",
    "resolve",
    "run",
]


def __getattr__(name: str) -> Any:
    if name not in _EXPORTS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = import_module(f".{_EXPORTS[name]}", __name__)
    value = getattr(module, name)
    globals()[name] = value
    return value
