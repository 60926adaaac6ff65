"""Hair and fur: fibre scattering for arrays of queries, fits, and a renderer."""

from ._vellus import __version__

__all__ = ["__version__"]
