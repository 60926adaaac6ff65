"""The measurements: samples per processor second, and error over processor time."""

from statistics import median

import numpy as np

import scene

# Fur is thinner than a pixel: pixels have four times the area.
SMALL = (scene.SIZE[0] // 2, scene.SIZE[1] // 2)
# Two colours closer than this are equally dark.
DARK = 0.01


def rates(renderers, spp, repeats):
    """Thousands of samples per processor second of each renderer, for all repeats. The renderers alternate."""
    samples = scene.SIZE[0] * scene.SIZE[1] * spp / 1000
    for renderer in renderers:
        renderer.warm(spp, "close")
    found = {renderer.name: [] for renderer in renderers}
    for repeat in range(repeats):
        for renderer in renderers:
            found[renderer.name].append(samples / renderer.render(spp, repeat + 1, "close"))
    return found


def summary(values):
    """Median, and half the range relative to the median."""
    middle = median(values)
    return middle, (max(values) - min(values)) / 2 / middle


class Quality:
    """Mean squared error of one renderer over processor time, against its own converged image.

    The converged image is the mean of `count` independent renders. The error of each render is measured against the
    mean of the others. The variance of that mean follows from theirs and is subtracted, so the result does not depend
    on `count`.
    """

    def __init__(self, renderer, spps, count, path, size=SMALL, view="whole"):
        def image(spp, seed):
            seconds = renderer.render(spp, seed, view, size, path)
            return seconds, np.load(path).astype(np.float64)

        renderer.warm(spps[-1], view, size)
        runs = [image(spps[-1], 1000 + i) for i in range(count)]
        total = sum(run[1] for run in runs)
        self.mean = total / count
        self.spps, self.seconds, self.mse, self.relative = [], [], [], []
        self.variance = variance = np.var([run[1] for run in runs], axis=0, ddof=1) / count
        for spp in spps[:-1]:
            few = [image(spp, 2000 + i) for i in range(3)]
            errors = [((run[1] - self.mean) ** 2 - variance, self.mean) for run in few]
            self.add(spp, [run[0] for run in few], errors)
        # Against the mean of the others, whose variance is 1/(count - 1) of the variance of one.
        others = [(total - run[1]) / (count - 1) for run in runs]
        errors = [((run[1] - mean) ** 2 * (count - 1) / count, mean) for run, mean in zip(runs, others)]
        self.add(spps[-1], [run[0] for run in runs], errors)
        path.unlink()
        # Error of the converged image, relative to the error of one of its renders.
        self.own = (1 / count) ** 0.5

    @classmethod
    def against(cls, reference, renderer, spps, count, path, size, view="whole"):
        """Errors against the converged image of another renderer: a difference of the means is an error too."""
        self = cls.__new__(cls)
        self.spps, self.seconds, self.mse, self.relative, total = [], [], [], [], 0.0
        for spp in spps:
            errors, seconds = [], []
            for seed in range(count):
                seconds.append(renderer.render(spp, 3000 + seed, view, size, path))
                image = np.load(path).astype(np.float64)
                errors.append(((image - reference.mean) ** 2 - reference.variance, reference.mean))
                total = total + image * (spp == spps[-1]) / count
            self.add(spp, seconds, errors)
        path.unlink()
        self.mean = total
        return self

    def add(self, spp, seconds, errors):
        self.spps.append(spp)
        self.seconds.append(median(seconds))
        self.mse.append(np.mean([error.mean() for error, _ in errors]))
        relative = [error.mean(-1) / (mean.mean(-1) ** 2 + DARK**2) for error, mean in errors]
        self.relative.append(np.mean(relative))

    def seconds_to(self, error, relative=False):
        """Processor seconds to reach that error. Between and beyond the measured numbers of samples, a power law."""
        x, y = np.log(self.relative if relative else self.mse), np.log(self.seconds)
        order = np.argsort(x)
        x, y = x[order], y[order]
        i = int(np.clip(np.searchsorted(x, np.log(error)) - 1, 0, len(x) - 2))
        return float(np.exp(y[i] + (np.log(error) - x[i]) * (y[i + 1] - y[i]) / (x[i + 1] - x[i])))
