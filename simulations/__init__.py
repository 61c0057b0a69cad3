"""Simulations of frictional contact and fretting: from a scene to files, or to arrays.

    from simulations import run
    result = run({"load.amplitude": 0.6})
    print(result.a, result.pressure.shape)

What is exported is loaded when it is first asked for (docs/library.md).
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .version import __version__

if TYPE_CHECKING:
    from .api import Result, run
    from .loading.stepping import SolveError
    from .output.body_states import body_functions
    from .runs.checks import ChecksWarning
    from .runs.comparison import compare
    from .runs.reference import closed_form, of_same_physics
    from .runs.simulation import Simulation
    from .scene import DEFAULT_SCENE, Scene, SceneError, language, make_scene, parse
    from .studies.sweeping import sweep

_EXPORTS = {
    "body_functions": "output.body_states",
    "ChecksWarning": "runs.checks",
    "compare": "runs.comparison",
    "SceneError": "scene",
    "Result": "api",
    "make_scene": "scene",
    "run": "api",
    "SolveError": "loading.stepping",
    "closed_form": "runs.reference",
    "of_same_physics": "runs.reference",
    "DEFAULT_SCENE": "scene",
    "Scene": "scene",
    "language": "scene",
    "parse": "scene",
    "Simulation": "runs.simulation",
    "sweep": "studies.sweeping",
}
__all__ = ["__version__", *_EXPORTS]


def __getattr__(name: str) -> Any:
    if name not in _EXPORTS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = import_module(f".{_EXPORTS[name]}", __name__)
    value = getattr(module, name)
    globals()[name] = value
    return value
