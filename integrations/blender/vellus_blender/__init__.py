"""Vellus in Blender: a render engine for hair and fur, and the export of its materials to USD."""

from . import engine, hook, settings

MODULES = (settings, engine, hook)


def register():
    for module in MODULES:
        module.register()


def unregister():
    for module in reversed(MODULES):
        module.unregister()
