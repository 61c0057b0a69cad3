"""Simulations of frictional contact and fretting: from a scene to files, or to arrays.

    from . import run
    result = run({"load.amplitude": 0.6})
    print(result.a, result.pressure.shape)

What is exported is loaded when it is first asked for (docs/library.md).
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from .api import Result, make_scene, run
    from .loading.stepping import SolveError
    from .run.checks import ChecksWarning
    from .run.comparison import compare
    from .run.reference import closed_form, of_same_physics
    from .run.simulation import Simulation
    from .scene.language import SceneError
    from .scene.scene import DEFAULT_SCENE, Scene, language, parse, resolve

_EXPORTS = {
    "ChecksWarning": "run.checks",
    "compare": "run.comparison",
    "SceneError": "scene.language",
    "Result": "api",
    "make_scene": "api",
    "run": "api",
    "SolveError": "loading.stepping",
    "closed_form": "run.reference",
    "of_same_physics": "run.reference",
    "DEFAULT_SCENE": "scene.scene",
    "Scene": "scene.scene",
    "language": "scene.scene",
    "parse": "scene.scene",
    "resolve": "scene.scene",
    "Simulation": "run.simulation",
}
__all__ = [
    "ChecksWarning",
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
