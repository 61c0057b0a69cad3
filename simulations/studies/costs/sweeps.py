"""Many scenes by one sweep against as many commands: wall and CPU seconds of processes of their own."""

import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from itertools import product
from pathlib import Path

from .cases import Case

K, AMPLITUDES = (-0.1, 0.0, 0.2, 0.4, 0.6), (0.3, 0.5, 0.7, 0.9)  # 20 scenes, each with a mesh of its own


def measure(case: Case) -> dict:
    """Seconds from the first process's start to the last one's end; forms are compiled before."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scene = folder / "scene.toml"
        scene.write_text(case.text, encoding="utf-8")
        sets = [word for key, value in case.sets.items() for word in ("--set", f"{key}={value}")]
        values = [("--set", f"solid.k={k}", "--set", f"load.amplitude={q}") for k, q in product(K, AMPLITUDES)]
        commands = [["simulations.fretting", *one, "--output", str(folder / str(n))] for n, one in enumerate(values)]
        if "sweep" in case.level:
            vary = [f"solid.k={','.join(map(str, K))}", f"load.amplitude={','.join(map(str, AMPLITUDES))}"]
            commands = [["simulations.sweep", "--vary", vary[0], "--vary", vary[1], "--output", str(folder / "sweep")]]
            commands[0] += ["--folders"] if "folders" in case.level else []
        _run(1, "simulations.fretting", str(scene), *sets, "--quiet", "--output", str(folder / "first"))
        wall, cpu = time.perf_counter(), _cpu()
        for module, *words in commands:
            _run(case.ranks, module, str(scene), *sets, *words, "--quiet")
        return {"wall_s": time.perf_counter() - wall, "cpu_s": _cpu() - cpu}


def run_apart(ranks: int, module: str, *words: str) -> subprocess.CompletedProcess:
    """A command of this package in a process of its own, or under mpirun; one thread a rank."""
    command = [sys.executable, "-m", module, *words]
    if ranks > 1:
        command = [shutil.which("mpirun") or "mpirun", "-n", str(ranks), *command]
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    return subprocess.run(command, text=True, capture_output=True, stdin=subprocess.DEVNULL, env=environment)


def _run(ranks, module, *words):
    done = run_apart(ranks, module, *words)
    if done.returncode:
        raise RuntimeError(f"exit code {done.returncode} of {module}: {done.stderr.strip()[-100:]}")


def _cpu() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
