"""Studies of many runs; each is a command,  python -m simulations.studies.NAME  (all share one engine).

NAME: ablation, body_stress, bulk_strain, campaign, claims, cost, coupling, critical_friction, figures, maps, stability.
"""
