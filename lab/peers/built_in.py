"""Error over processor time on the built-in scenes, with and without a radiance cache, beside the peers. Called by
run.py --scenes.

usage: built_in.py OUT VELLUS [--quick] [SCENE...]

All renderers have the same strands, lobes, plain surfaces and lights: usd_scenes.py. The error of pictures with a cache
is measured against our converged picture without one: its bias counts as error. That of the peers is measured against
their own converged pictures.
"""

import json
import subprocess
import sys
from pathlib import Path

from compare import Table, machine
from measure import Quality, pictures
from renderers import Cycles, Peer, Vellus, fur
from usd_scenes import ABSORPTION, convert

# 3:2, like the scenes' cameras.
SIZE = (192, 128)
# Samples a pixel that fill the cache.
FILL = 8
# Few and many samples a pixel. Light fur takes long, and in Mitsuba so do many instances.
SAMPLES = {"polar-bear": (8, 32), "hamster": (8, 32), "hamsters": (1, 4)}
USUAL, QUICK = (16, 64), (4, 16)
MULTI, CACHED, LLVM, CYCLES = "Vellus multi-scale", f"Vellus, cache of {FILL}", "Mitsuba llvm", "Cycles"
VIEW = "its camera"


def prepare(name, out, program, small):
    source = out / "scenes" / f"{name}.usda"
    command = [program, "scene", name, "-o", source, *(["--small"] if small else [])]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    convert(name, source, source.with_suffix(".usdc"))
    source.unlink()


def start(kind, name, out, program):
    if kind == LLVM:
        return Peer(kind, out, name, "built_in_mitsuba.py", "llvm_ad_rgb")
    if kind == CYCLES:
        return Cycles(kind, out, name, "built_in_cycles.py")
    cache = ["--radiance-cache", FILL] if kind == CACHED else []
    return Vellus(kind, out, name, program, "--mode", "multiscale", *cache)


def measure(table, name, out, program, spps, count):
    # Cycles does not share the strands of the herd.
    kinds = (MULTI, CACHED, LLVM) if name == "hamsters" else (MULTI, CACHED, LLVM, CYCLES)
    renderers = [start(kind, name, out, program) for kind in kinds]
    taken = pictures(renderers, spps, count, out / "built-in.npy", SIZE, VIEW)
    memory = {renderer.name: renderer.memory for renderer in renderers}
    for renderer in renderers:
        renderer.close()
    for text in (out / "scenes").glob(f"{name}-*.txt"):
        text.unlink()
    found = {kind: Quality(runs) for kind, runs in taken.items() if kind != CACHED}
    found[CACHED] = Quality.against(found[MULTI], taken[CACHED])
    covered = fur(out / "scenes" / f"{name}.usdc", out, program, SIZE)[..., None]
    mean = lambda q: (q.mean * covered).sum((0, 1)) / covered.sum()
    # The time that each renderer needs to the error of the cache's last row.
    last = found[CACHED]
    for kind, q in found.items():
        times = [q.seconds_to(last.mse[-1]), q.seconds_to(last.relative[-1], relative=True)]
        ratios = [f"{time / last.seconds[-1]:.2f}" for time in times]
        colors = [*(mean(q) / mean(found[MULTI])), q.mean.mean() / found[MULTI].mean.mean()]
        rms = f"{q.mse[-1] ** 0.5:.4f}"
        row = [name, kind, q.spps[-1], f"{q.seconds[-1]:.1f}", rms, f"{q.relative[-1]:.4f}", *ratios]
        table.append(row + [f"{memory[kind]:.0f}", *(f"{x:.3f}" for x in colors)])
    return {kind: {"cpu": q.seconds, "mse": q.mse, "relmse": q.relative} for kind, q in found.items()}


def main():
    out, program, quick = Path(sys.argv[1]), Path(sys.argv[2]), "--quick" in sys.argv
    rows, record = [], {}
    for name in [name for name in sys.argv[3:] if name in ABSORPTION] or ABSORPTION:
        prepare(name, out, program, quick)
        found = []
        spps = SAMPLES.get(name, USUAL)
        record[name] = measure(found, name, out, program, min(spps, QUICK) if quick else spps, 3)
        print(*found, sep="\n", flush=True)
        rows += found
    table = Table()
    size, small = f"{SIZE[0]}×{SIZE[1]}", " (small)" if quick else ""
    table.line(f"# Built-in scenes{small} at {size}")
    table.line()
    table.line(f"{machine()}. Ratios: processor time to the error of the pictures with a cache, over theirs.")
    table.line()
    header = ["scene", "renderer", "samples", "cpu-s", "RMSE", "relMSE", "time to RMSE", "to relMSE", "MB"]
    table.rows(header + ["fur's mean R", "G", "B", "picture's mean"], rows)
    (out / "scenes.md").write_text(table.text)
    (out / "scenes.json").write_text(json.dumps(record, indent=1))


if __name__ == "__main__":
    main()
