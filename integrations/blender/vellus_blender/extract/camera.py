"""The camera of the scene."""

import numpy as np

from .arrays import matrix


def rigid(m):
    """The rotation and translation of a matrix."""
    out = np.eye(4)
    u, _, vt = np.linalg.svd(m[:3, :3])
    out[:3, :3] = u @ vt
    if np.linalg.det(out[:3, :3]) < 0:
        out[:3, 0] *= -1
    out[:3, 3] = m[:3, 3]
    return out


def read_camera(owner, width, height, warn):
    """A dict with `matrix`, `film_height` (over the focal length), `focus_distance`, `aperture` (radius) and `shift`.

    The shift is in widths and heights of the picture, to the right and upward. `width` and `height` are those of the
    whole picture.
    """
    camera = owner.data
    if camera.type != "PERSP":
        return None
    m = rigid(matrix(owner.matrix_world))
    is_wide = camera.sensor_fit == "HORIZONTAL" or camera.sensor_fit == "AUTO" and width >= height
    sensor = camera.sensor_height if camera.sensor_fit == "VERTICAL" else camera.sensor_width
    fit = sensor / camera.lens
    film_height = fit * height / width if is_wide else fit
    side = width if is_wide else height
    focus, aperture = 10.0, 0.0
    dof = camera.dof
    if dof.use_dof:
        focus = dof.focus_distance
        if dof.focus_object:
            away = np.array(dof.focus_object.matrix_world.translation) - m[:3, 3]
            focus = abs(float(away @ -m[:3, 2]))
        # The focal length is in millimetres, the scene in metres.
        aperture = 0.5e-3 * camera.lens / dof.aperture_fstop
        if dof.aperture_blades >= 3 or dof.aperture_ratio != 1:
            warn("Camera: the aperture is round: blades and ratio are ignored")
    return {
        "matrix": m,
        "film_height": film_height,
        "focus_distance": max(focus, 1e-4),
        "aperture": aperture,
        "shift": (camera.shift_x * side / width, camera.shift_y * side / height),
    }


def without_shift(camera, size, crop):
    """A camera without shift, and a larger picture that contains the shifted one: (camera, size, crop).

    The film is in the same plane, so the perspective is the same. The shift is rounded to whole pixels.
    `crop` is left, top, width and height.
    """
    (width, height), (left, top, *part) = size, crop
    right, up = round(camera["shift"][0] * width), round(camera["shift"][1] * height)
    large = (width + 2 * abs(right), height + 2 * abs(up))
    film_height = camera["film_height"] * large[1] / height
    crop = (left + abs(right) + right, top + abs(up) - up, *part)
    return {**camera, "film_height": film_height, "shift": (0.0, 0.0)}, large, crop
