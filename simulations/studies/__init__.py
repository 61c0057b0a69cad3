"""What uses many runs; each study is a command,  python -m simulations.studies.NAME  (all share one engine).

NAME: ablation, cost, stability, maps, coupling, figures, claims, body_stress.
"""
