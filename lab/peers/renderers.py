"""The renderers. All have the methods `render` and `close`."""

import json
import re
import subprocess
import sys
from pathlib import Path

import scene

HERE = Path(__file__).resolve().parent


class Peer:
    """A peer in a long-running process."""

    def __init__(self, name, out, ball, script, *arguments):
        self.name = name
        log = open(out / f"{script}.log", "w")
        command = [sys.executable, HERE / script, *arguments, out / "scenes", ball]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log, text=True)
        answer = self.answer()
        self.load, self.memory, self.wall = answer["load"], answer["memory"], None

    def answer(self):
        line = self.process.stdout.readline()
        if not line:
            raise RuntimeError(f"{self.name} ended: see its log in target/peers")
        return json.loads(line)

    def ask(self, spp, seed, view, size, path):
        request = {"spp": spp, "seed": seed, "view": view, "size": size, "path": str(path or "")}
        print(json.dumps(request), file=self.process.stdin, flush=True)
        answer = self.answer()
        self.memory, self.wall = answer["memory"], answer.get("wall")
        return answer["cpu"]

    def warm(self, spp, view, size=scene.SIZE):
        """Compiles what the view needs."""
        self.ask(spp, 0, view, size, None)

    def render(self, spp, seed, view, size=scene.SIZE, path=None):
        """Processor seconds of the render."""
        return self.ask(spp, seed, view, size, path)

    def close(self):
        self.process.stdin.close()
        self.process.wait()


class Cycles(Peer):
    """Builds the scene again for each render, so there is nothing to warm."""

    def warm(self, spp, view, size=scene.SIZE):
        pass


class Vellus:
    """Our command. It prints the time of rendering."""

    def __init__(self, name, out, ball, program, *options):
        self.name, self.program, self.options = name, program, options
        self.file, self.bounces = out / "scenes" / f"{ball}.usdc", scene.BOUNCES.get(ball, scene.MANY)
        self.picture = out / f"{name.replace(' ', '-').lower()}.exr"
        self.load = self.memory = None

    def warm(self, spp, view, size=scene.SIZE):
        pass

    def render(self, spp, seed, view, size=scene.SIZE, path=None):
        picture = path.with_suffix(".exr") if path else self.picture
        command = [self.program, "render", self.file, *self.options]
        # Built-in scenes have one camera.
        command += ["--camera", view] if view in scene.VIEWS else []
        command += ["--max-depth", self.bounces, "--size", f"{size[0]}x{size[1]}", "--spp", spp, "--seed", seed]
        command += ["--filter", "box", "--layers", "beauty", "--float", "--output", picture]
        # GNU time measures this too, but is not installed everywhere.
        code = (
            "import resource, subprocess, sys\n"
            "subprocess.run(sys.argv[1:], check=True, stdout=sys.stderr)\n"
            "u = resource.getrusage(resource.RUSAGE_CHILDREN)\n"
            "print(u.ru_utime + u.ru_stime, u.ru_maxrss)"
        )
        command = [sys.executable, "-c", code, *map(str, command)]
        run = subprocess.run(command, capture_output=True, text=True)
        if run.returncode:
            raise RuntimeError(f"{self.name}: {run.stderr}")
        total, memory = map(float, run.stdout.split())
        spent = float(re.search(r"([\d.]+) s of processor time", run.stderr)[1])
        # Including reading and writing files.
        self.load, self.memory = total - spent, memory / 1000
        if path:
            save(picture, path)
        return spent

    def close(self):
        self.picture.unlink(missing_ok=True)
        self.picture.with_suffix(".png").unlink(missing_ok=True)


def save(picture, path):
    """Reads OpenEXR to NumPy, RGB."""
    import mitsuba
    import numpy

    mitsuba.set_variant("scalar_rgb")
    kind = mitsuba.Bitmap.PixelFormat.RGB
    bitmap = mitsuba.Bitmap(str(picture)).convert(kind, mitsuba.Struct.Type.Float32, False)
    numpy.save(path, numpy.array(bitmap))
    picture.unlink()
    picture.with_suffix(".png").unlink()


def fur(file, out, program, size):
    """The share of each pixel that fibres cover."""
    import mitsuba
    import numpy

    mitsuba.set_variant("scalar_rgb")
    picture = out / "fur.exr"
    command = [program, "render", file, "--size", f"{size[0]}x{size[1]}", "--spp", 16, "--max-depth", 1]
    command += ["--filter", "box", "--layers", "beauty,fibers", "-o", picture]
    subprocess.run(list(map(str, command)), check=True, capture_output=True)
    # Channels: R, G, B, fibers.A.
    found = numpy.array(mitsuba.Bitmap(str(picture)))[..., 3].astype(numpy.float64)
    picture.unlink()
    picture.with_suffix(".png").unlink()
    return found
