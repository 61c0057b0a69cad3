"""Coupled frictional contact under fretting loads without load steps: a reference of high accuracy."""

from .loop import CoupledLoop
from .state import CoupledState

__all__ = ["CoupledLoop", "CoupledState"]
