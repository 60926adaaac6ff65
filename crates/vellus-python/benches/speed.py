"""Compares the speed of the package with that of the same queries in Rust.

Usage: python speed.py RUST_PROGRAM [COUNT] with the example `batch` of this crate:
cargo build --release -p vellus-python --example batch; python speed.py target/release/examples/batch
"""

import statistics
import subprocess
import sys
import time

import numpy as np
import vellus

REPEATS = 11


def unit(rng, count):
    vectors = rng.normal(size=(count, 3))
    return (vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)).astype(np.float32)


def seconds(function):
    start = time.perf_counter()
    function()
    return time.perf_counter() - start


def main():
    program = sys.argv[1]
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 10_000_000
    rng = np.random.default_rng(1)
    wi, wo = unit(rng, count), unit(rng, count)
    h = rng.uniform(-1, 1, count).astype(np.float32)
    bcsdf = vellus.Bcsdf("red-fox")
    rust = subprocess.Popen([program, "bench", str(count)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def in_rust():
        rust.stdin.write("\n")
        rust.stdin.flush()
        return float(rust.stdout.readline().split()[0])

    in_rust()
    bcsdf.eval(wi=wi, wo=wo, h=h)
    # Interleaved, so that both see the same load and temperature.
    pairs = [(seconds(lambda: bcsdf.eval(wi=wi, wo=wo, h=h)), in_rust()) for _ in range(REPEATS)]
    rust.stdin.close()
    rust.wait()
    python, native = (statistics.median(times) for times in zip(*pairs))
    ratio = statistics.median(a / b for a, b in pairs)
    print("| queries | time | per query |")
    print("|---|---|---|")

    def row(name, time, queries):
        each = time / queries
        each = f"{1e6 * each:.1f} µs" if each > 1e-6 else f"{1e9 * each:.0f} ns"
        print(f"| {name} | {time:.3g} s | {each} |")

    row(f"{count:.0e} near, Rust", native, count)
    row(f"{count:.0e} near, float32", python, count)
    wide = {name: array.astype(np.float64) for name, array in {"wi": wi, "wo": wo, "h": h}.items()}
    row(f"{count:.0e} near, float64", min(seconds(lambda: bcsdf.eval(**wide)) for _ in range(3)), count)
    one = min(seconds(lambda: bcsdf.eval(wi=wi, wo=wo[0], h=h[0])) for _ in range(3))
    row(f"{count:.0e} near, one wo and h", one, count)
    few = slice(0, count // 10)
    each = min(seconds(lambda: bcsdf.eval(wi=wi[few], wo=wo[few], window="far")) for _ in range(3))
    row(f"{count / 10:.0e} far", each, count // 10)
    u = rng.random((count // 10, 5), dtype=np.float32)
    drawn = min(seconds(lambda: bcsdf.sample(wo[few], u, h[few])) for _ in range(3))
    row(f"{count / 10:.0e} near samples", drawn, count // 10)
    a, b = wi[0], wo[0]
    calls = 20_000
    single = statistics.median(seconds(lambda: [bcsdf.eval(wi=a, wo=b, h=0.3) for _ in range(calls)]) for _ in range(5))
    row(f"{calls} calls with one query", single, calls)
    print(f"\nPython over Rust, median of {REPEATS} interleaved pairs: {ratio:.3f}")


if __name__ == "__main__":
    main()
