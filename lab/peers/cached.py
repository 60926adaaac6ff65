"""Error over processor time with a radiance cache, beside the peers. Called by run.py --cache.

usage: cached.py OUT VELLUS [--quick]

The error of pictures with a cache is measured against the converged picture without one: its bias counts as error. That
of the peers is measured against their own converged pictures.
"""

import json
import sys
from pathlib import Path

import numpy as np

import scene
from compare import CYCLES, LLVM, MULTI, Table, machine, start
from measure import Quality, pictures
from renderers import Vellus

SIZE = (240, 135)
# Samples a pixel that fill the cache.
FILL = 16
CACHED = f"Vellus, cache of {FILL}"


def measure(table, ball, out, program, spps, count):
    table.line(f"## {ball}: whole ball at {SIZE[0]}×{SIZE[1]}")
    renderers = [start(kind, out, program, ball) for kind in (LLVM, CYCLES, MULTI)]
    renderers.append(Vellus(CACHED, out, ball, program, "--mode", "multiscale", "--radiance-cache", FILL))
    taken = pictures(renderers, spps, count, out / "cached.npy", SIZE)
    for renderer in renderers:
        renderer.close()
    found = {name: Quality(taken[name]) for name in (LLVM, CYCLES, MULTI)}
    found[CACHED] = Quality.against(found[MULTI], taken[CACHED])
    rows = []
    for name, q in found.items():
        for i, spp in enumerate(q.spps):
            rows.append([name, spp, f"{q.seconds[i]:.2f}", f"{q.mse[i] ** 0.5:.5f}", f"{q.relative[i]:.5f}"])
    table.rows(["renderer", "samples per pixel", "cpu-s", "RMSE", "relMSE"], rows)
    # The time that each renderer needs to the error of the cache's last row.
    goal, own = found[CACHED].mse[-1], found[CACHED].seconds[-1]
    rows = [[name, f"{q.seconds_to(goal):.1f}", f"{q.seconds_to(goal) / own:.2f}"] for name, q in found.items()]
    table.rows(["to the cache's last RMSE", "cpu-s", "times that of the cache"], rows)
    fur = np.abs(found[MULTI].mean - np.array(scene.SKY)).max(-1) > 0.05
    means = {name: q.mean[fur].mean(0) for name, q in found.items()}
    ratios = [[name, *(f"{x:.4f}" for x in mean / means[MULTI])] for name, mean in means.items()]
    table.rows([f"mean over fur / {MULTI}", "R", "G", "B"], ratios)
    return {name: {"spp": q.spps, "cpu": q.seconds, "mse": q.mse, "relmse": q.relative} for name, q in found.items()}


def main():
    out, program, quick = Path(sys.argv[1]), Path(sys.argv[2]), "--quick" in sys.argv
    table, record = Table(), {}
    table.line("# A radiance cache beside the peers")
    table.line()
    table.line(f"{machine()}; {'quick' if quick else 'full'} run.")
    table.line()
    for ball in ("10K", "white", "200K"):
        spps = (4, 16) if quick else (4, 16, 64)
        record[ball] = measure(table, ball, out, program, spps, 3 if quick else 4)
    (out / "cached.md").write_text(table.text)
    (out / "cached.json").write_text(json.dumps(record, indent=1))


if __name__ == "__main__":
    main()
