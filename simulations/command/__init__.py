"""Shared by all commands: command line, progress lines, and the ways to end."""

from .stopping import stopping

stopping.listen_as_command()  # before the libraries are loaded, which takes seconds
