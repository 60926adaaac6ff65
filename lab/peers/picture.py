"""The same view by all renderers side by side, and their differences."""

import numpy as np

import scene


def shown(image):
    """The transfer curve of sRGB."""
    x = np.clip(image, 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def smooth(image, radius=4):
    """Mean over a square, because single pixels are noise."""
    padded = np.pad(image, ((radius, radius), (radius, radius), (0, 0)), mode="edge")
    for axis in (0, 1):
        width = 2 * radius + 1
        padded = sum(np.roll(padded, -k, axis) for k in range(width)) / width
    return padded[: image.shape[0], : image.shape[1]]


def tint(ratio):
    """Grey at 1, red above, blue below; full colour at a difference of 20 %."""
    off = np.clip((ratio - 1) / 0.2, -1, 1)
    return np.stack([0.5 + 0.5 * off, 0.5 - 0.3 * abs(off), 0.5 - 0.5 * off], -1)


def compare(renderers, spp, file):
    """Writes the picture. Returns the header and the rows of the table."""
    import mitsuba as mi

    images = []
    for renderer in renderers:
        path = file.with_suffix(".npy")
        renderer.render(spp, 77, "close", scene.SIZE, path)
        images.append((renderer.name, np.load(path).astype(np.float64)))
    ours = next(image for name, image in images if name.startswith("Vellus"))
    # All renderers show the same sky. Pixels that differ from it are fur.
    sky = np.array(scene.SKY)
    fur = np.abs(smooth(ours) - sky).max(-1) > 0.2
    rows, ratios = [], []
    for name, image in images:
        mean = image[fur].mean(0)
        rows.append([name, *(f"{x:.4f}" for x in mean), *(f"{x:.3f}" for x in ours[fur].mean(0) / mean)])
        if image is not ours:
            ratios.append(tint(smooth(ours).mean(-1) / smooth(image).mean(-1)))
    blank = np.ones_like(ours)
    top = np.concatenate([shown(ours)] + [shown(image) for _, image in images if image is not ours], 1)
    bottom = np.concatenate([blank] + ratios, 1)
    path.unlink()
    mi.set_variant("scalar_rgb")
    sheet = (np.concatenate([top, bottom], 0) * 255 + 0.5).astype(np.uint8)
    mi.Bitmap(sheet).write(str(file))
    return ["mean over fur", "R", "G", "B", "Vellus / it: R", "G", "B"], rows
