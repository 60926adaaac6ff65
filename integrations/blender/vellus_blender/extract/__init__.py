"""Reads the evaluated scene of Blender into plain arrays. Nothing here needs the package vellus."""

from .scene import Description, Problem, extract

__all__ = ["Description", "Problem", "extract"]
