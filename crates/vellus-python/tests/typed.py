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

    # Standard deviations and cells as numbers, lists or arrays; one profile or several.
    theta, phi = np.arange(10.0, 50, 6), np.arange(0, 180, 12)
    measured = vellus.profile("cat", -30, theta, phi)[..., 0]
    profiles = [
        vellus.Profile(theta[:, None], phi, measured, theta_o=-30, sigma=0.02 * measured, blur=np.float32(5)),
        vellus.Profile(theta[:, None], phi, measured, theta_o=-30, sigma=1, blur=(5, 2.5)),
    ]
    fit = vellus.fit((p for p in profiles), starts=1, separate=["sigma_ca"], share=("scale",), free=["background"])
    interval: tuple[float, float] | None = fit.estimates["eta"].interval
    part: vellus.FitPart = fit.parts[1]
    assert interval is not None and part.fiber.eta == fit.fiber.eta and fit.plot("slices", 1).size[0] > 0

    # Arrays of any size of float or integer, lists of numbers and arrays, numbers.
    bcsdf = vellus.Bcsdf("cat")
    wo = vellus.direction(20, range(0, 90, 30))
    bcsdf.eval(wi=[[0, 1, 0]], wo=wo, h=single)
    bcsdf.pdf(wi=Convertible(), wo=[wo[0], wo[1]], h=np.float32(0.3))
    bcsdf.energy(np.array([0, 1, 0]), 1)
    bcsdf.eval(wi=wo.astype(np.float16), wo=wo, h=0.3, check=False)

    # Windows.
    for window in (single[:2], vellus.pixel_window(single, 0.5)):
        bcsdf.energy(wo, window=window)
    bcsdf.energy(wo, window="far")
    bcsdf.energy(wo, window=(-0.5, 0.5))
    bcsdf.energy(wo, window=[[-1, 0], [0, 1], [-1, 1]])

    # Strands, with counts and without.
    scene = vellus.Scene()
    scene.add_look("cat")
    points = np.linspace([0, 0, 0], [0, 1, 0], 4)
    scene.add_strands(points, [4], 0.1)
    scene.add_strands(points[None], radii=0.1)

    # Results.
    value: NDArray[np.float32 | np.float64] = bcsdf.eval(wi=wo, wo=wo, h=0.3)
    lobe: NDArray[np.int8] = bcsdf.sample(wo, np.full(4, 0.5), 0.3).lobe
    far: NDArray[np.float32] = vellus.profile("cat", np.float32(-30), [10, 20], range(0, 180, 90))
    assert (value * 2).sum() > 0 and lobe.min() >= 0 and far.shape == (2, 2, 3)


def refused() -> None:
    """An error in each line, which mypy must find."""
    bcsdf, wo = vellus.Bcsdf("cat"), vellus.direction(0, 0)
    bcsdf.eval(wo, wo, 0.3)  # type: ignore[call-arg]
    bcsdf.eval(wi=wo, wo=wo, window="fra")  # type: ignore[arg-type]
    bcsdf.eval(wi=wo, wo=wo, window=0.5)  # type: ignore[arg-type]
    bcsdf.eval(wi="wi", wo=wo, h=0.3)  # type: ignore[arg-type]
    bcsdf.eval(wi=wo, wo=wo, h=["0.3"])  # type: ignore[arg-type]
    bcsdf.eval(wi=wo, wo=wo, h=0.3j)  # type: ignore[arg-type]
    bcsdf.eval(wi=wo, wo=wo, h=Fraction(1, 3))  # type: ignore[arg-type]
    vellus.Fiber(kappa="0.5")  # type: ignore[arg-type]
    vellus.Fiber(sigma_ca="0.1")  # type: ignore[arg-type]
    vellus.Fiber(sigma_ca=["0.1"])  # type: ignore[list-item]
    vellus.Fiber(exit="closed")  # type: ignore[arg-type]
    vellus.Fiber(kapa=0.5)  # type: ignore[call-arg]
    vellus.Profile.measure("cat", step=(x for x in (8, 8)))  # type: ignore[arg-type]
    vellus.Profile.measure("cat", seed=1.5)  # type: ignore[arg-type]
    vellus.Profile([0], [0], [1], theta_o=0, blur="5")  # type: ignore[arg-type]
    vellus.fit("cat")  # type: ignore[arg-type]
    whole: NDArray[np.int64] = bcsdf.eval(wi=wo, wo=wo, h=0.3)  # type: ignore[assignment]
    print(whole)
