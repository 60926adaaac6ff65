"""The properties of the plugins, read and checked by `vellus.Fiber`."""

import mitsuba as mi
import numpy as np

import vellus


def read(props):
    """The fibre that the properties of a plugin describe.

    `preset` and `exit` are strings; all other properties are parameters of `vellus.Fiber`, with its names, units and
    ranges. Colours are `rgb`, `srgb`, lists of three numbers, or spectra that are uniform.

    Raises `ValueError` for a name that is unknown, and for a value out of range; it names both.
    """
    parameters = {}
    for name in props.keys():
        value = props[name]
        if name in ("preset", "exit"):
            if not isinstance(value, str):
                raise ValueError(f"vellus: {name} must be a text, not {value!r}")
            if name == "exit":
                parameters[name] = value
        elif isinstance(value, bool) or isinstance(value, str):
            raise ValueError(f"vellus: {name} = {value!r} is not a number or a colour")
        elif isinstance(value, (int, float)):
            parameters[name] = float(value)
        else:
            parameters[name] = color(name, value)
    return fiber(props["preset"] if "preset" in props else None, parameters)


def color(name, value):
    """The numbers of a property that is no plain number: RGB, or one number.

    Raises `ValueError` for everything that is no constant, such as an image.
    """
    try:
        if isinstance(value, mi.Texture):
            # `srgb` and `uniform` have this parameter. Images and spectra over wavelengths have others.
            value = mi.traverse(value)["value"]
        elif hasattr(value, "is_uniform"):
            # A `spectrum`, which the parser leaves as it is.
            value = value.values if value.is_uniform() else None
        return [float(x) for x in np.ravel(value)]
    except (KeyError, TypeError, ValueError):
        what = "a number, a colour or a uniform spectrum: other spectra and textures are not supported"
        raise ValueError(f"vellus: {name} is not {what}") from None


def fiber(preset, parameters):
    """`vellus.Fiber` with errors that name the plugin."""
    try:
        found = vellus.Fiber(preset, **parameters) if preset else vellus.Fiber(**parameters)
    except (TypeError, ValueError) as error:
        raise ValueError(f"vellus: {error}") from None
    if found.aspect_ratio != 1:
        raise ValueError(f"vellus: aspect_ratio = {found.aspect_ratio} must be 1: curves of Mitsuba are round")
    return found


def needs_arrays(what):
    """Raises `RuntimeError` in variants that the plugins do not support."""
    variant = mi.variant()
    if not variant.startswith(("llvm", "cuda")) or not variant.endswith("rgb"):
        raise RuntimeError(f"{what} needs a vector variant with RGB, such as llvm_ad_rgb: this one is {variant}")
