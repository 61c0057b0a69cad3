"""The scene: checked, resolved to numbers and scaled; which effects are on, and why."""

from .errors import SceneError, one_line, rounded, shown
from .reading import DEFAULT_SCENE, language, make_scene, parse
from .scene import Scene

__all__ = ["DEFAULT_SCENE", "Scene", "SceneError", "language", "make_scene", "one_line", "parse", "rounded", "shown"]
