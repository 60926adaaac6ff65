"""What the types of the stubs accept and refuse. `test_stubs.py` checks it with mypy and runs `accepted`."""

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

import vellus


class Convertible:
    """NumPy makes an array of it."""

    def __array__(self, dtype: object = None, copy: object = None) -> NDArray[np.float64]:
        return np.array([0.0, 1.0, 0.0])


def accepted() -> None:
    """Everything here also works."""
    single = np.array([0.1, 0.2, 0.3], np.float32)
    # A number is anything that has a float, and a colour also any iterable of them.
    vellus.Fiber("cat", kappa=np.float32(0.5), g=Fraction(1, 2), beta_m=8)
    vellus.Fiber(sigma_ca=(x / 10 for x in range(3)), sigma_ma={"r": 1, "g": 2, "b": 3}.values())
    vellus.Fiber(sigma_ca=single).replace(reflectance=[0.1, np.float64(0.2), Fraction(1, 4)])
    vellus.fit(vellus.Profile.measure("cat", step=np.array([8, 8])), starts=np.int64(1), fix={"sigma_ca": 0.1})

    # Arrays of any size of float or integer, lists of numbers and arrays, numbers.
    bcsdf = vellus.Bcsdf("cat")
    wo = vellus.direction(20, range(0, 90, 30))
    bcsdf.eval([[0, 1, 0]], wo, single)
    bcsdf.pdf(Convertible(), [wo[0], wo[1]], np.float32(0.3))
    bcsdf.energy(np.array([0, 1, 0]), 1)
    bcsdf.eval(wo.astype(np.float16), wo, 0.3, check=False)

    # Windows.
    for window in (single[:2], vellus.pixel_window(single, 0.5)):
        bcsdf.energy(wo, window=window)
    bcsdf.energy(wo, window="far")
    bcsdf.energy(wo, window=(-0.5, 0.5))
    bcsdf.energy(wo, window=[[-1, 0], [0, 1], [-1, 1]])

    # Results.
    value: NDArray[np.float32 | np.float64] = bcsdf.eval(wo, wo, 0.3)
    lobe: NDArray[np.int8] = bcsdf.sample(wo, np.full(4, 0.5), 0.3).lobe
    far: NDArray[np.float32] = vellus.profile("cat", np.float32(-30), [10, 20], range(0, 180, 90))
    assert (value * 2).sum() > 0 and lobe.min() >= 0 and far.shape == (2, 2, 3)


def refused() -> None:
    """An error in each line, which mypy must find."""
    bcsdf, wo = vellus.Bcsdf("cat"), vellus.direction(0, 0)
    bcsdf.eval(wo, wo, window="fra")  # type: ignore[arg-type]
    bcsdf.eval(wo, wo, window=0.5)  # type: ignore[arg-type]
    bcsdf.eval("wi", wo, 0.3)  # type: ignore[arg-type]
    bcsdf.eval(wo, wo, ["0.3"])  # type: ignore[arg-type]
    bcsdf.eval(wo, wo, 0.3j)  # type: ignore[arg-type]
    bcsdf.eval(wo, wo, Fraction(1, 3))  # type: ignore[arg-type]
    vellus.Fiber(kappa="0.5")  # type: ignore[arg-type]
    vellus.Fiber(sigma_ca="0.1")  # type: ignore[arg-type]
    vellus.Fiber(sigma_ca=["0.1"])  # type: ignore[list-item]
    vellus.Fiber(exit="closed")  # type: ignore[arg-type]
    vellus.Fiber(kapa=0.5)  # type: ignore[call-arg]
    vellus.Profile.measure("cat", step=(x for x in (8, 8)))  # type: ignore[arg-type]
    vellus.Profile.measure("cat", seed=1.5)  # type: ignore[arg-type]
    whole: NDArray[np.int64] = bcsdf.eval(wo, wo, 0.3)  # type: ignore[assignment]
    print(whole)
