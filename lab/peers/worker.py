"""Code that the peers' processes share: requests and answers as JSON lines, CPU time, memory."""

import json
import os
import resource
import sys
import time


def begin():
    """Keeps standard output for answers. The output of libraries goes to standard error."""
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    return answers


def requests():
    """Requests, until standard input ends."""
    for line in sys.stdin:
        yield json.loads(line)


def answer(file, **values):
    print(json.dumps(values), file=file, flush=True)


class Clock:
    """User and system time of all threads since this object was made."""

    def __init__(self):
        self.start, self.began = self.now(), time.monotonic()

    @staticmethod
    def now():
        usage = resource.getrusage(resource.RUSAGE_SELF)
        return usage.ru_utime + usage.ru_stime

    def seconds(self):
        return self.now() - self.start

    def wall(self):
        """Wall-clock seconds."""
        return time.monotonic() - self.began


def memory():
    """Peak resident memory in MB."""
    with open("/proc/self/status") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmHWM")) / 1000


def serve(file, world, sensor):
    """Renders a scene of Mitsuba for each request. `sensor` makes the camera of a request."""
    import mitsuba
    import numpy

    for request in requests():
        camera = sensor(request)
        clock = Clock()
        image = numpy.array(mitsuba.render(world, sensor=camera, spp=request["spp"], seed=request["seed"]))
        spent, wall = clock.seconds(), clock.wall()
        if request["path"]:
            numpy.save(request["path"], image.astype(numpy.float32))
        answer(file, cpu=spent, wall=wall, memory=memory())
