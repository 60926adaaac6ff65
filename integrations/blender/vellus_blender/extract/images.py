"""Images of Blender as linear RGB."""

import numpy as np


def to_linear(x):
    """sRGB to linear."""
    return np.where(x <= 0.04045, x / 12.92, ((np.maximum(x, 0) + 0.055) / 1.055) ** 2.4)


DATA = {"Non-Color", "Raw", "Generic Data", "Linear Rec.709"}


def pixels(image, warn):
    """An image as (height, width, 3) float32, linear, top row first. `None` with a warning if it cannot be read."""
    width, height = image.size
    if width * height == 0:
        warn(f"the image {image.name} is missing: {image.filepath or 'it has no file'}")
        return None
    values = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(values)
    values = values.reshape(height, width, image.channels)[::-1]
    rgb = values[..., :3] if image.channels >= 3 else np.repeat(values[..., :1], 3, 2)
    space = image.colorspace_settings.name
    if not image.is_float and space not in DATA:
        if space != "sRGB":
            warn(f"the image {image.name} has the colour space {space}: it is read as sRGB")
        rgb = to_linear(rgb)
    return np.ascontiguousarray(rgb, np.float32)


def wrap_of(node):
    """The wrap mode of an image texture."""
    return {"REPEAT": "repeat", "EXTEND": "clamp", "CLIP": "black", "MIRROR": "mirror"}.get(node.extension, "repeat")
