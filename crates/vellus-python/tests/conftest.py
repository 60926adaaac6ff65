import csv
import json
import os
import signal
from pathlib import Path

import numpy as np
import pytest
from vellus import Fiber

# A shell that starts the tests in the background lets them ignore Ctrl-C, and its tests would wait without end.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def reference():
    """Arguments and results of the same queries in Rust, by preset."""
    path = os.environ.get("VELLUS_REFERENCE")
    if path is None:
        pytest.skip("VELLUS_REFERENCE does not name the output of the example `batch values`")
    with open(path) as file:
        return json.load(file)


def vectors():
    """The fibres and the queries of the golden vectors. `vectors/README.md` explains the columns."""
    folder = Path(__file__).resolve().parents[3] / "vectors"
    with open(folder / "fibers.csv") as file:
        rows = list(csv.DictReader(file))
    # Three columns with the names of the channels are one colour.
    color = lambda row, name: [float(row[f"{name}.{channel}"]) for channel in "rgb"]
    plain = [name for name in rows[0] if name not in ("name", "exit") and "." not in name]
    fibers = [
        Fiber(
            exit=row["exit"],
            sigma_ca=color(row, "sigma_ca"),
            sigma_ma=color(row, "sigma_ma"),
            **{name: float(row[name]) for name in plain},
        )
        for row in rows
    ]
    return fibers, np.loadtxt(folder / "queries.csv", np.float32, delimiter=",", skiprows=1)


def unit(rng, *shape):
    vectors = rng.normal(size=(*shape, 3))
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


@pytest.fixture
def rng():
    return np.random.default_rng(7)
