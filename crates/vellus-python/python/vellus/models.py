"""Earlier reflectance models for hair and fur, with the methods of `vellus.Bcsdf`."""

from ._vellus import MODEL_NAMES as NAMES
from ._vellus import Model

__all__ = ["NAMES", "Model"]
