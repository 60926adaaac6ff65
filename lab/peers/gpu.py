"""Our GPU path beside Mitsuba on the same GPU, in wall-clock time. Called by run.py --gpu.

usage: gpu.py OUT VELLUS [--quick]

Mitsuba runs its CUDA variant if OptiX is there, and its LLVM variant on all cores. Both renderers trace equal samples,
in turns. The raccoon is rendered one sample at a time: 15 of these a second are enough for a viewer.
"""

import json
import re
import subprocess
import sys
from pathlib import Path

import scene
from compare import Table, machine
from measure import summary
from renderers import Peer

GOAL_PEER, GOAL_RAYS, GOAL_FRAMES = 3.0, 150.0, 15.0


def ours(program, arguments):
    """Millions of rays, and seconds, of one render; and what it says about the device."""
    command = [program, "render", *arguments, "--device", "gpu", "--filter", "box", "--layers", "beauty"]
    run = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    if run.returncode:
        sys.exit(f"vellus: {run.stderr.strip()}")
    rays, seconds = re.search(r"([\d.]+) Mrays in ([\d.]+) s", run.stderr).groups()
    return float(rays), float(seconds), re.search(r"the GPU (.*) renders", run.stderr)[1]


def peers(out, ball):
    """Mitsuba's variants that start here."""
    found = []
    for variant in ("cuda_ad_rgb", "llvm_ad_rgb"):
        try:
            found.append(Peer(f"Mitsuba {variant}", out, ball, "mitsuba_worker.py", variant))
        except RuntimeError as error:
            print(f"{variant} does not start here: {error}", file=sys.stderr)
    return found


def measure(table, ball, out, program, size, spp, repeats):
    table.line(f"## {ball} strands at {size[0]}×{size[1]}, {spp} samples a pixel, {repeats} alternating repeats")
    others, picture = peers(out, ball), out / "gpu.exr"
    view = ["--camera", "close", "--size", f"{size[0]}x{size[1]}", "--max-depth", scene.BOUNCES[ball]]
    for other in others:
        other.warm(spp, "close", size)
    samples = size[0] * size[1] * spp / 1e6
    rates, rays = {"Vellus": []} | {other.name: [] for other in others}, []
    for repeat in range(repeats):
        file = out / "scenes" / f"{ball}.usdc"
        traced, seconds, device = ours(program, [file, *view, "--spp", spp, "--seed", repeat, "--output", picture])
        rates["Vellus"].append(samples / seconds)
        rays.append(traced / seconds)
        for other in others:
            other.render(spp, repeat + 1, "close", size)
            rates[other.name].append(samples / other.wall)
    for other in others:
        other.close()
    middle = {name: summary(values) for name, values in rates.items()}
    best = max((middle[other.name][0] for other in others), default=None)
    rows = [
        [name, f"{rate:.2f}", f"{100 * spread:.0f} %", f"{middle['Vellus'][0] / rate:.2f}"]
        for name, (rate, spread) in middle.items()
    ]
    table.rows([f"renderer ({device})", "Msamples/s", "±", "Vellus / it"], rows)
    table.line(f"{summary(rays)[0]:.1f} million rays a second (aim at 200K: {GOAL_RAYS:.0f}).")
    if best:
        table.line(f"{middle['Vellus'][0] / best:.2f} times the faster variant of Mitsuba (aim: {GOAL_PEER:.0f}).")
    table.line()
    return {"rates": rates, "rays": rays}


def main():
    out, program, quick = Path(sys.argv[1]), Path(sys.argv[2]), "--quick" in sys.argv
    table, record = Table(), {}
    table.line("# The GPU path beside Mitsuba")
    table.line()
    table.line(f"{machine()}; {'quick' if quick else 'full'} run; wall-clock time.")
    table.line()
    size, spp, repeats = ((96, 54), 2, 1) if quick else ((1280, 720), 64, 3)
    for ball in ("10K", "200K"):
        record[ball] = measure(table, ball, out, program, size, spp, repeats)
    scene_options = ["raccoon", "--size", f"{size[0]}x{size[1]}", "--spp", spp, "--output", out / "gpu.exr"]
    times = [ours(program, scene_options)[1] for _ in range(repeats)]
    frames = summary([spp / seconds for seconds in times])[0]
    record["raccoon"] = times
    table.line(f"Raccoon at {size[0]}×{size[1]}: {frames:.2f} samples of each pixel a second (aim: {GOAL_FRAMES:.0f}).")
    (out / "gpu.md").write_text(table.text)
    (out / "gpu.json").write_text(json.dumps(record, indent=1))


if __name__ == "__main__":
    main()
