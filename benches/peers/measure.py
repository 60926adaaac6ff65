"""What is measured: samples a processor second, and error against processor time."""

from statistics import median

import numpy as np

import scene

# Fur thinner than a pixel: pixels four times as large in area.
SMALL = (scene.SIZE[0] // 2, scene.SIZE[1] // 2)
# Two colours closer than that are equally dark.
DARK = 0.01


def rates(renderers, spp, repeats):
    """Thousand samples a processor second of each, all repeats, in turns."""
    samples = scene.SIZE[0] * scene.SIZE[1] * spp / 1000
    for renderer in renderers:
        # Compiles kernels, fills caches.
        renderer.render(spp, 0, "close")
    found = {renderer.name: [] for renderer in renderers}
    for repeat in range(repeats):
        for renderer in renderers:
            found[renderer.name].append(samples / renderer.render(spp, repeat + 1, "close"))
    return found


def summary(values):
    """Median, and half the range relative to it."""
    middle = median(values)
    return middle, (max(values) - min(values)) / 2 / middle


class Quality:
    """Mean squared error over processor time of one renderer, against its own converged image.

    That image is the mean of `count` independent renders; the variance between them is the error of one against
    the image they converge to (Bessel's correction: no bias from their own number). Renders with fewer samples are
    compared with that mean, less the mean's own variance.
    """

    def __init__(self, renderer, spps, count, path):
        def image(spp, seed):
            seconds = renderer.render(spp, seed, "whole", SMALL, path)
            return seconds, np.load(path).astype(np.float64)

        renderer.render(spps[-1], 0, "whole", SMALL)
        runs = [image(spps[-1], 1000 + i) for i in range(count)]
        stack = np.stack([run[1] for run in runs])
        self.mean, variance = stack.mean(0), stack.var(0, ddof=1)
        scale = self.mean.mean(-1, keepdims=True) ** 2 + DARK**2
        self.spps, self.seconds, self.mse, self.relative = [], [], [], []
        for spp in spps[:-1]:
            few = [image(spp, 2000 + i) for i in range(3)]
            error = np.mean([(run[1] - self.mean) ** 2 for run in few], 0) - variance / count
            self.add(spp, median(run[0] for run in few), error, scale)
        self.add(spps[-1], median(run[0] for run in runs), variance, scale)
        # How far the converged image itself is off, beside what is measured at the most samples.
        self.own = (1 / count) ** 0.5

    def add(self, spp, seconds, error, scale):
        self.spps.append(spp)
        self.seconds.append(seconds)
        self.mse.append(error.mean())
        self.relative.append((error / scale).mean())

    def seconds_to(self, error, relative=False):
        """Processor seconds to that error: between measured numbers of samples, or beyond them, a power law."""
        x, y = np.log(self.relative if relative else self.mse), np.log(self.seconds)
        order = np.argsort(x)
        x, y = x[order], y[order]
        i = int(np.clip(np.searchsorted(x, np.log(error)) - 1, 0, len(x) - 2))
        return float(np.exp(y[i] + (np.log(error) - x[i]) * (y[i + 1] - y[i]) / (x[i + 1] - x[i])))
