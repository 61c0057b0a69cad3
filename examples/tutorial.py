# %% [markdown]
# # From a scene to p, q, slip, w, stresses, a sweep and an effect of your own
#
# `./docker/run python examples/tutorial.py` runs all cells in about ten seconds and leaves its pictures in
# `results/tutorial`. Editors that know cells (`# %%`), and Jupyter with jupytext, open this file as a notebook.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from pydantic import Field

from simulations import fretting, make_scene, run, sweep
from simulations.output.body_states import read_states
from simulations.scene import effects
from simulations.scene.effects import Effect, Verdict
from simulations.scene.fields import Number

folder = Path("results/tutorial")
folder.mkdir(parents=True, exist_ok=True)

# %% [markdown]
# ## A scene
#
# Keys in SI units; what is not named has its default (docs/scene.md). The mesh here is coarse, good for about a
# per cent: leave its keys out, or set `solver.accuracy`, for results to be used.

# %%
coarse = {"mesh.facet": 0.05, "mesh.edge_facet": 0.01, "mesh.growth": 1.5, "mesh.first_layer": 0.01}
scene = make_scene(coarse | {"title": "Tutorial", "solid.k": 0.5, "load.amplitude": 0.8, "solver.increments": 4})
print(scene.to_toml())

# %% [markdown]
# ## p, q and slip
#
# `run` returns arrays: a row a load step, a column a surface node.

# %%
result = run(scene)
print(f"a = {1e3 * result.a:.4f} mm, c/a = {result.c / result.a:.4f}, {result.dissipated_energy:.4f} J/m a cycle")
errors = result.errors()  # relative to the closed form, which is exact at the Holl ratio
print({name: f"{error:.1e}" for name, error in errors.items()})
inside = np.abs(result.x) < 1.1 * result.a

figure, axes = plt.subplots(1, 3, figsize=(11, 3.2), layout="constrained")
curves = ((result.pressure, 1e-6, "pressure p [MPa]"), (result.traction, 1e-6, "traction q [MPa]"))
for axis, (values, unit, name) in zip(axes, (*curves, (result.slip, 1e6, "slip [µm]"))):
    axis.plot(1e3 * result.x[inside], unit * values[-1, inside])
    axis.set(xlabel="position x [mm]", ylabel=name)
figure.savefig(folder / "surface.png", dpi=120)

# %% [markdown]
# ## w: where the energy is lost
#
# In a cycle at constant P a point loses w = 4 q h_x, equation (51), with q and the slip h_x at +Q_A. Here +Q_A
# is the last state; slip is counted as the motion of the surface, so that it has the opposite sign.

# %%
w = -4 * result.traction[-1] * result.slip[-1]
energy = w @ result.weight
print(f"integral of w: {energy:.4f} J/m, work of friction in the cycle: {result.dissipated_energy:.4f} J/m")

figure, axis = plt.subplots(figsize=(5, 3.2), layout="constrained")
axis.plot(1e3 * result.x[inside], w[inside])
axis.set(xlabel="position x [mm]", ylabel="dissipated energy w [J/m²]")
figure.savefig(folder / "energy.png", dpi=120)

# %% [markdown]
# ## Stress in the body
#
# A command leaves a folder with tables, fields for ParaView and a picture (docs/files.md); so does the same
# command from Python. Below, von Mises stress at the end of the normal stage and at the states of the cycle.

# %%
(folder / "mine.toml").write_text(scene.to_toml())
fretting.main([str(folder / "mine.toml"), "--output", str(folder / "mine"), "--quiet", "--overwrite"])
states = read_states(folder / "mine")
for state in states:
    below = state.von_mises[np.ix_(state.y < 3 * result.a, np.abs(state.x) < 3 * result.a)]
    print(f"{state.label:14s} largest von Mises stress {below.max() / 1e6:.0f} MPa")

state = states[-1]
figure, axis = plt.subplots(figsize=(6, 3.2), layout="constrained")
filled = axis.contourf(1e3 * state.x, 1e3 * state.y, state.von_mises / 1e6, levels=20)
axis.set(xlim=(-2e3 * result.a, 2e3 * result.a), ylim=(2e3 * result.a, 0), aspect="equal")
axis.set(xlabel="position x [mm]", ylabel="depth y [mm]", title=state.label)
figure.colorbar(filled, label="von Mises stress [MPa]")
figure.savefig(folder / "body.png", dpi=120)

# %% [markdown]
# ## A sweep over k
#
# One table, a row a scene (docs/sweeps.md). At the Holl ratio of each k, so that the errors are those of the
# mesh alone.

# %%
table = sweep(scene, vary={"solid.k": [0.0, 0.25, 0.5, 0.75]}, sets=('solid.nu="holl"',))
table.to_csv(folder / "sweep.csv")
for row in table:
    print(f"k = {row['solid.k']}: {row['dissipated_energy[J/m]']:.4f} J/m, error {row['error_dissipated_energy']:+.1e}")

# %% [markdown]
# ## An effect of your own
#
# Springs that hold the surface, as a soft film does: a term of the virtual work, and an entry with its key and
# the reason why it is on.

# %%
STIFFNESS = 1e13  # Pa/m


def judge(scene):
    return Verdict(scene.effects.film > 0, f"effects.film = {scene.effects.film:g}", "the surface is held")


def work(scene, scales):
    stiffness = scene.effects.film * scales.displacement / scales.stress
    return lambda body, v: body.constant(stiffness) * (body.u[0] * v[0] + body.u[1] * v[1]) * body.surface_measure


key = (Number, Field(0.0, ge=0, le=1e30, description="stiffness of springs on the surface, Pa/m"))
film = Effect("film", judge, keys={"film": key}, work=work)
effects.add(film)
held = run({"effects.film": STIFFNESS}, scene)
effects.remove(film)
print(f"held by springs: energy {held.dissipated_energy / result.dissipated_energy - 1:+.1%}")
