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


def pictures(renderers, spps, count, path, size=SMALL, view="whole"):
    """Processor seconds and pictures of each renderer, for each number of samples. The renderers alternate.

    There are `count` pictures with the most samples, and three with fewer.
    """
    for renderer in renderers:
        renderer.warm(spps[-1], view, size)
    found = {renderer.name: {spp: [] for spp in spps} for renderer in renderers}
    for i, spp in enumerate(spps):
        for repeat in range(count if spp == spps[-1] else 3):
            for j, renderer in enumerate(renderers):
                # No two pictures have the same seed.
                seconds = renderer.render(spp, 1000 * (j + 1) + 100 * i + repeat, view, size, path)
                found[renderer.name][spp].append((seconds, np.load(path).astype(np.float64)))
    path.unlink()
    return found


class Quality:
    """Mean squared error of one renderer over processor time, against its own converged image.

    The converged image is the mean of the pictures with the most samples. The error of each of them is measured against
    the mean of the others. The variance of that mean follows from theirs and is subtracted, so the result does not
    depend on how many there are.
    """

    def __init__(self, taken):
        runs = list(taken.values())[-1]
        count, total = len(runs), sum(run[1] for run in runs)
        self.start(total / count, np.var([run[1] for run in runs], axis=0, ddof=1) / count)
        for spp, few in list(taken.items())[:-1]:
            self.compare(spp, few, self)
        # Against the mean of the others, whose variance is 1/(count - 1) of the variance of one.
        others = [(total - run[1]) / (count - 1) for run in runs]
        errors = [((run[1] - mean) ** 2 * (count - 1) / count, mean) for run, mean in zip(runs, others)]
        self.add(list(taken)[-1], [run[0] for run in runs], errors)
        # Error of the converged image, relative to the error of one of its renders.
        self.own = (1 / count) ** 0.5

    @classmethod
    def against(cls, reference, taken):
        """Errors against the converged image of another renderer: a difference of the means is an error too."""
        self = cls.__new__(cls)
        self.start(np.mean([run[1] for run in list(taken.values())[-1]], axis=0), None)
        for spp, runs in taken.items():
            self.compare(spp, runs, reference)
        return self

    def start(self, mean, variance):
        self.mean, self.variance = mean, variance
        self.spps, self.seconds, self.mse, self.relative = [], [], [], []

    def compare(self, spp, runs, reference):
        errors = [((run[1] - reference.mean) ** 2 - reference.variance, reference.mean) for run in runs]
        self.add(spp, [run[0] for run in runs], errors)

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
