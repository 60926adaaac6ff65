"""The properties of the plugins, read and checked by `vellus.Fiber`."""

import mitsuba as mi

import vellus


def read(props):
    """The fibre that the properties of a plugin describe.

    `preset` and `exit` are strings; all other properties are parameters of `vellus.Fiber`, with its names, units and
    ranges. Colours are `rgb` or lists of three numbers.

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
            try:
                parameters[name] = [float(value[c]) for c in range(len(value))]
            except (TypeError, IndexError):
                raise ValueError(f"vellus: {name} is not a number or a colour: textures are not supported") from None
    return fiber(props["preset"] if "preset" in props else None, parameters)


def fiber(preset, parameters):
    """`vellus.Fiber` with errors that name the plugin."""
    try:
        return vellus.Fiber(preset, **parameters) if preset else vellus.Fiber(**parameters)
    except (TypeError, ValueError) as error:
        raise ValueError(f"vellus: {error}") from None


def needs_arrays(what):
    """Raises `RuntimeError` in variants that the plugins do not support."""
    variant = mi.variant()
    if not variant.startswith(("llvm", "cuda")) or not variant.endswith("rgb"):
        raise RuntimeError(f"{what} needs a vector variant with RGB, such as llvm_ad_rgb: this one is {variant}")
