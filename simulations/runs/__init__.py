"""A simulation from scene to states; its reference, errors, checks, energy and limits."""

import sys
from importlib import import_module
from types import ModuleType


class _Callable(ModuleType):
    """This package once imported is also what ``from simulations import run`` finds: it can be called like it."""

    def __call__(self, *arguments, **options):
        return import_module(__name__.rpartition(".")[0] + ".api").run(*arguments, **options)


sys.modules[__name__].__class__ = _Callable
