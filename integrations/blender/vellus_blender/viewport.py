"""The picture of the viewport: a thread renders, and the window shows the newest pixels.

`Preview` knows neither Blender nor the GPU. `view_update` and `view_draw` of the engine use it.
"""

import threading

import numpy as np


class Cancelled(Exception):
    """The picture is out of date."""


class Preview:
    """One viewport. `redraw()` is called from the thread when there are new pixels."""

    def __init__(self, redraw):
        self.redraw = redraw
        self.lock = threading.Lock()
        self.thread = None
        self.stop = threading.Event()
        self.key = None
        self.pixels = None
        self.error = None
        self.done = 0.0

    def is_current(self, key):
        """Whether the pixels, or the thread that makes them, are those of this view."""
        return self.key == key

    def start(self, key, work):
        """Stops the thread and starts another one: `work(show)` calls `show(pixels, done)` now and then.

        `pixels` is (height, width, 4), top row first, and `done` in [0, 1]. `show` raises `Cancelled` when the picture
        is out of date. The old pixels stay until there are new ones of the same size.
        """
        self.cancel()
        self.key, self.error, self.done = key, None, 0.0
        stop = self.stop = threading.Event()

        def show(pixels, done):
            if stop.is_set():
                raise Cancelled
            with self.lock:
                self.pixels, self.done = np.ascontiguousarray(pixels[::-1], np.float32), done
            self.redraw()

        def run():
            try:
                work(show)
            except Cancelled:
                pass
            except Exception as error:  # the thread has no caller: the window shows the message
                self.error = str(error)
                self.redraw()

        self.thread = threading.Thread(target=run, daemon=True)
        self.thread.start()

    def cancel(self):
        """Stops the thread and waits for it."""
        self.stop.set()
        if self.thread:
            self.thread.join()
        self.thread, self.key = None, None

    def newest(self, size):
        """The newest pixels, bottom row first, if they have this (width, height)."""
        with self.lock:
            if self.pixels is None or self.pixels.shape[1::-1] != tuple(size):
                return None
            return self.pixels


def camera_of_view(view_matrix, window_matrix):
    """The camera of a 3D view, as `extract.camera.read_camera` makes it. `None` for an orthographic view.

    `window_matrix` is the projection: x over -z of the picture's middle and its extent follow from it.
    """
    projection = np.array(window_matrix, np.float64)
    if projection[3, 3] != 0:
        return None
    return {
        "matrix": np.linalg.inv(np.array(view_matrix, np.float64)),
        "film_height": 2 / projection[1, 1],
        "focus_distance": 10.0,
        "aperture": 0.0,
        "shift": (0.5 * projection[0, 2], 0.5 * projection[1, 2]),
    }


def draw(pixels, engine, scene):
    """Draws pixels into the bound framebuffer. Only a machine with a window can run this."""
    import gpu
    from gpu_extras.presets import draw_texture_2d

    height, width = pixels.shape[:2]
    buffer = gpu.types.Buffer("FLOAT", width * height * 4, pixels.ravel())
    texture = gpu.types.GPUTexture((width, height), format="RGBA16F", data=buffer)
    gpu.state.blend_set("ALPHA_PREMULT")
    engine.bind_display_space_shader(scene)
    draw_texture_2d(texture, (0, 0), width, height)
    engine.unbind_display_space_shader()
    gpu.state.blend_set("NONE")
