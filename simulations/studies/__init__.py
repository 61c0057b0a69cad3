"""What uses many runs: cost, stability, figures, maps, ... Each is a command: python -m simulations.studies.NAME."""
