import json
import os
import signal

import numpy as np
import pytest

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


def unit(rng, *shape):
    vectors = rng.normal(size=(*shape, 3))
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


@pytest.fixture
def rng():
    return np.random.default_rng(7)
