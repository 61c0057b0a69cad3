"""The discrete problem: mesh, spaces and stiffness of the body, contact terms, slip memory, surface quantities."""

import logging

import ffcx  # noqa: F401  # dolfinx would import it later

# On import ffcx has all of Python's warnings logged, where nobody sees them unless a handler was set up.
_handlers = logging.getLogger("py.warnings").handlers + logging.root.handlers
if all(isinstance(handler, logging.NullHandler) for handler in _handlers):
    logging.captureWarnings(False)
