"""Studies of many runs; each is a command,  python -m simulations.studies.NAME, which  python -m simulations  lists."""
