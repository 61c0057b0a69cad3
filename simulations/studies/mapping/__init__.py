"""Maps of the energy that a cycle dissipates over grading, load and profile, by the theory and by simulation."""
