"""What uses many runs: cost, stability, ablation, figures, claims, maps, coupling. Each is  python -m simulations.studies.NAME."""
