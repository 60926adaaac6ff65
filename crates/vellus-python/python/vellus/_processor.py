"""Its import fails on a processor that the extension was not compiled for.

The module's own code may need instructions that the processor lacks even to raise an error. One function does not.
"""

import ctypes
from importlib.util import find_spec


def missing():
    """The instructions that the processor lacks, or None."""
    found = find_spec("vellus._vellus")
    if found is None or found.origin is None:
        return None
    function = ctypes.CDLL(found.origin).vellus_missing_instructions
    function.restype = ctypes.c_char_p
    name = function()
    return name and name.decode()


if name := missing():
    raise ImportError(f"this build of vellus needs a processor with {name}: build it from source for this one")
