"""What every command shares: its command line, its progress lines, and how it ends."""

from .stopping import stopping

stopping.listen_as_command()  # before the libraries are loaded, which takes seconds
