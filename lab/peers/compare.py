"""Measures everything and writes the table. Called by run.py.

usage: compare.py OUT VELLUS [--quick]
"""

import json
import resource
import subprocess
import sys
import time
from pathlib import Path

import albedo
import picture
import scene
from measure import SMALL, Quality, pictures, rates, summary
from renderers import Cycles, Peer, Vellus

LLVM, SCALAR, CYCLES, NEAR, MULTI = "Mitsuba llvm", "Mitsuba scalar", "Cycles", "Vellus near", "Vellus multi-scale"
# The goals: samples per processor second of our near field, relative to the peer.
GOALS = {("10K", LLVM): 2.0, ("200K", LLVM): 1.6, ("10K", CYCLES): 3.0, ("200K", CYCLES): 3.0}
GOAL_QUALITY, GOAL_FRAME = 6.0, 1.2


class Table:
    """Markdown. Prints each line as it is added, and writes the file at the end."""

    def __init__(self):
        self.text = ""

    def line(self, text=""):
        print(text, flush=True)
        self.text += text + "\n"

    def rows(self, head, rows):
        self.line()
        for row in (head, ["---"] * len(head), *rows):
            self.line("| " + " | ".join(map(str, row)) + " |")
        self.line()


def goal(value, least=None, most=None):
    """A number, its goal, and whether it meets the goal."""
    met = value >= least if least else value <= most
    return f"{value:.2f} ({'≥' if least else '≤'} {least or most}: {'yes' if met else '**no**'})"


def machine():
    names = [line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")]
    return f"{len(names)} × {names[0]}, load {open('/proc/loadavg').read().split()[0]} at the start"


def start(kind, out, program, ball):
    if kind == LLVM:
        return Peer(kind, out, ball, "mitsuba_worker.py", "llvm_ad_rgb")
    if kind == SCALAR:
        return Peer(kind, out, ball, "mitsuba_worker.py", "scalar_rgb")
    if kind == CYCLES:
        return Cycles(kind, out, ball, "cycles_worker.py")
    return Vellus(kind, out, ball, program, "--mode", "near" if kind == NEAR else "multiscale")


def speed(table, ball, renderers, spp, repeats):
    found = rates(renderers, spp, repeats)
    middle = {name: summary(values)[0] for name, values in found.items()}
    table.line(f"## {ball} strands × {scene.BALLS[ball][1]}: {spp} samples per pixel, {repeats} alternating repeats")
    rows = []
    for r in renderers:
        spread = f"{100 * summary(found[r.name])[1]:.0f} %"
        ratio = middle[NEAR] / middle[r.name]
        least = GOALS.get((ball, r.name))
        ratio = goal(ratio, least=least) if least else f"{ratio:.2f}"
        rows.append([r.name, f"{middle[r.name]:.1f}", spread, ratio, f"{r.load:.1f}", f"{r.memory:.0f}"])
    head = ["renderer", "Ksamples/cpu-s", "±", "Vellus near / it", "load and build, cpu-s", "peak memory, MB"]
    table.rows(head, rows)
    table.line(f"Multi-scale frame over near-field frame: {goal(middle[NEAR] / middle[MULTI], most=GOAL_FRAME)}.")
    table.line()
    return {"rates": found}


def quality(table, ball, renderers, spps, count, out):
    taken = pictures(renderers, spps, count, out / "quality.npy")
    found = {name: Quality(runs) for name, runs in taken.items()}
    peer = found[LLVM]
    table.line(f"## Equal quality: {ball} strands, whole ball at {SMALL[0]}×{SMALL[1]}, fur thinner than a pixel")
    rows = []
    for name, q in found.items():
        for i, spp in enumerate(q.spps):
            rows.append([name, spp, f"{q.seconds[i]:.2f}", f"{q.mse[i] ** 0.5:.5f}", f"{q.relative[i]:.5f}"])
    table.rows(["renderer", "samples per pixel", "cpu-s", "RMSE", "relMSE"], rows)
    rows = []
    for name, q in found.items():
        # The time to the error of the peer's last row.
        times = [q.seconds_to(peer.mse[-1]), q.seconds_to(peer.relative[-1], relative=True)]
        ratios = [peer.seconds[-1] / t for t in times]
        first = goal(ratios[0], least=GOAL_QUALITY) if name == MULTI else f"{ratios[0]:.2f}"
        rows.append([name, f"{times[0]:.2f}", first, f"{times[1]:.2f}", f"{ratios[1]:.2f}"])
    head = ["to Mitsuba's last error", "cpu-s, same RMSE", "times faster", "cpu-s, same relMSE", "times faster"]
    table.rows(head, rows)
    means = [name + "".join(f" {x:.4f}" for x in q.mean.mean((0, 1))) for name, q in found.items()]
    table.line(f"Mean RGB of the converged images: {', '.join(means)}.")
    table.line(f"Their own error is {peer.own:.2f} of the error of the last rows; it is subtracted.")
    table.line()
    return {name: {"spp": q.spps, "cpu": q.seconds, "mse": q.mse, "relmse": q.relative} for name, q in found.items()}


def strand(table, program):
    table.line("## Albedo of one strand, lit perpendicular to its axis")
    values = {"exact": albedo.exact(), "Mitsuba": albedo.mitsuba(), "Vellus": albedo.ours(program)}
    table.rows(["", "R", "G", "B"], [[name, *(f"{x:.4f}" for x in rgb)] for name, rgb in values.items()])


def main():
    out, program, quick = Path(sys.argv[1]), Path(sys.argv[2]), "--quick" in sys.argv
    table, record, began = Table(), {}, time.time()
    table.line("# Vellus compared with its peers")
    commit = subprocess.run(["git", "describe", "--always", "--dirty"], capture_output=True, text=True).stdout.strip()
    table.line()
    table.line(f"{machine()}; Vellus {commit}; {'quick' if quick else 'full'} run.")
    table.line()
    strand(table, program)
    for ball, spp in (("10K", 16), ("200K", 8)):
        kinds = [LLVM, *([] if quick else [SCALAR]), CYCLES, NEAR, MULTI]
        renderers = [start(kind, out, program, ball) for kind in kinds]
        record[ball] = speed(table, ball, renderers, spp // 2 if quick else spp, 3)
        if ball == "10K" or not quick:
            compared = [r for r in renderers if r.name in (NEAR, LLVM, CYCLES)]
            file = out / f"comparison-{ball}.png"
            table.line(f"## Pictures: {ball} strands, {file.name}")
            table.rows(*picture.compare(compared, (16 if quick else 64) if ball == "10K" else 16, file))
        if ball == "200K" or not quick:
            chosen = [r for r in renderers if r.name in ((LLVM, MULTI) if quick else (LLVM, NEAR, MULTI))]
            record[f"{ball} quality"] = quality(table, ball, chosen, (4, 16, 64), 3 if quick else 8, out)
        for renderer in renderers:
            renderer.close()
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = (used.ru_utime + used.ru_stime) / 60
    table.line(f"Took {(time.time() - began) / 60:.1f} minutes, {spent:.1f} of processor time.")
    (out / "table.md").write_text(table.text)
    (out / "table.json").write_text(json.dumps(record, indent=1))


if __name__ == "__main__":
    main()
