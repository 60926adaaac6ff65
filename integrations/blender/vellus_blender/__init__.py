"""Vellus in Blender: a render engine for hair and fur, and the export of its materials to USD."""

from . import engine, group, hook, settings

MODULES = (settings, group, engine, hook)


def register():
    for module in MODULES:
        module.register()


def unregister():
    for module in reversed(MODULES):
        module.unregister()
