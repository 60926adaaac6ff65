"""The package as a whole."""

import vellus


def test_version_is_that_of_the_crates():
    assert vellus.__version__.count(".") == 2
