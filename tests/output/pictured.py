"""Coarse runs along a path of loads, for those who look at what is drawn of them."""

from running import coarse_arguments

from simulations import fretting
from simulations.scene import make_scene


def along(folder, points, **changes):
    """Folder of a coarse run along ``points``."""
    scene = make_scene(dict.fromkeys(("load.P", "load.amplitude", "load.cycles")) | {"load.points": points})
    (folder / "path.toml").write_text(scene.to_toml())
    fretting.main([str(folder / "path.toml"), *coarse_arguments(folder / "run", **changes)])
    return folder / "run"
