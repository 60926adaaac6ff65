"""Error over processor time on the built-in scenes, with and without a radiance cache, beside Mitsuba. Called by run.py
--scenes.

usage: built_in.py OUT VELLUS [--quick] [SCENE...]

All renderers have the same strands, lobes, plain surfaces and lights: usd_scenes.py. The error of pictures with a cache
is measured against our converged picture without one: its bias counts as error. Mitsuba's is measured against its own
converged picture.
"""

import json
import subprocess
import sys
from pathlib import Path

from compare import Table, machine
from measure import Quality
from renderers import Peer, Vellus
from usd_scenes import ABSORPTION, convert

# 3:2, like the scenes' cameras.
SIZE = (192, 128)
# Samples a pixel that fill the cache.
FILL = 8
MULTI, CACHED, LLVM = "Vellus multi-scale", f"Vellus, cache of {FILL}", "Mitsuba llvm"
VIEW = "its camera"


def prepare(name, out, program, small):
    source = out / "scenes" / f"{name}.usda"
    command = [program, "scene", name, "-o", source, *(["--small"] if small else [])]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    convert(name, source, source.with_suffix(".usdc"))
    source.unlink()


def measure(table, name, out, program, spps, count):
    file = out / "built-in.npy"
    multi = Vellus(MULTI, out, name, program, "--mode", "multiscale")
    cached = Vellus(CACHED, out, name, program, "--mode", "multiscale", "--radiance-cache", FILL)
    mitsuba = Peer(LLVM, out, name, "built_in_worker.py", "llvm_ad_rgb")
    found = {r.name: Quality(r, spps, count, file, SIZE, VIEW) for r in (multi, mitsuba)}
    found[CACHED] = Quality.against(found[MULTI], cached, spps, count, file, SIZE, VIEW)
    for renderer in (multi, cached, mitsuba):
        renderer.close()
    for text in (out / "scenes").glob(f"{name}-*.txt"):
        text.unlink()
    memory = {multi.name: multi.memory, cached.name: cached.memory, mitsuba.name: mitsuba.memory}
    # The time that each renderer needs to the error of the cache's last row.
    last = found[CACHED]
    for kind, q in found.items():
        times = [q.seconds_to(last.mse[-1]), q.seconds_to(last.relative[-1], relative=True)]
        ratios = [f"{time / last.seconds[-1]:.2f}" for time in times]
        mean = q.mean.mean((0, 1)) / found[MULTI].mean.mean((0, 1))
        rms = f"{q.mse[-1] ** 0.5:.4f}"
        row = [name, kind, f"{q.seconds[-1]:.1f}", rms, f"{q.relative[-1]:.4f}", *ratios]
        table.append(row + [f"{memory[kind]:.0f}", *(f"{x:.3f}" for x in mean)])
    return {kind: {"cpu": q.seconds, "mse": q.mse, "relmse": q.relative} for kind, q in found.items()}


def main():
    out, program, quick = Path(sys.argv[1]), Path(sys.argv[2]), "--quick" in sys.argv
    spps = (4, 16) if quick else (4, 16, 64)
    # Mitsuba takes long for many instances.
    herd = (1, 4) if quick else (1, 4, 16)
    rows, record = [], {}
    for name in [name for name in sys.argv[3:] if name in ABSORPTION] or ABSORPTION:
        prepare(name, out, program, quick)
        record[name] = measure(rows, name, out, program, herd if name == "hamsters" else spps, 3)
        print(*rows[-3:], sep="\n", flush=True)
    table = Table()
    size, small = f"{SIZE[0]}×{SIZE[1]}", " (small)" if quick else ""
    table.line(f"# Built-in scenes{small} at {size}, {spps[-1]} samples a pixel ({herd[-1]} for the herd)")
    table.line()
    table.line(f"{machine()}. Ratios: processor time to the error of the pictures with a cache, over theirs.")
    table.line()
    header = ["scene", "renderer", "cpu-s", "RMSE", "relMSE", "time to RMSE", "to relMSE", "MB"]
    table.rows(header + ["mean R", "G", "B"], rows)
    (out / "scenes.md").write_text(table.text)
    (out / "scenes.json").write_text(json.dumps(record, indent=1))


if __name__ == "__main__":
    main()
