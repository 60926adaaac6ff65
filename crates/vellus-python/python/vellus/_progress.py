"""Progress bars of rendering, in terminals and notebooks."""

import sys


def _in_notebook():
    try:
        from IPython import get_ipython
    except ImportError:
        return False
    shell = get_ipython()
    return shell is not None and shell.__class__.__name__ == "ZMQInteractiveShell"


def _line(state, end=""):
    left = state.seconds * (1 - state.done) / max(state.done, 1e-9)
    text = f"\r{state.samples} of {state.total} samples, {100 * state.done:.0f} %, {left:.0f} s left  "
    sys.stderr.write(text + end)
    sys.stderr.flush()


def bar(callback, samples):
    """A callback that shows a bar and calls `callback`, or None where no bar can be shown.

    It uses tqdm if that is installed, and else a line of text.
    """
    notebook = _in_notebook()
    if not notebook and not sys.stderr.isatty():
        return callback
    try:
        from tqdm.auto import tqdm
    except ImportError:
        tqdm = None
    shown = tqdm(total=samples, unit="sample", leave=False) if tqdm else None

    def show(state):
        if shown is not None:
            shown.update(state.samples - shown.n)
            if state.done >= 1:
                shown.close()
        else:
            _line(state, "\n" if state.done >= 1 else "")
        return callback(state) if callback is not None else None

    return show
