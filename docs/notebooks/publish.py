"""Executes the notebooks of this folder, and writes them as pages of the book.

Usage: python publish.py [--check] [NAME...]

It needs the packages vellus, nbconvert, ipykernel and matplotlib. Pages go to `docs/book/src/notebooks`, and their
pictures to `docs/book/src/notebooks/NAME`. With --check it executes the notebooks and writes nothing. Without names it
takes all notebooks.
"""

import argparse
import re
import shutil
import sys
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from nbconvert import MarkdownExporter
from traitlets.config import Config

NOTEBOOKS = Path(__file__).parent
PAGES = NOTEBOOKS.parent / "book" / "src" / "notebooks"
LARGEST_PICTURE = 150_000
SECONDS = 900


def page(name, notebook):
    """The notebook as Markdown, and its pictures by file name."""
    for cell in notebook.cells:
        # The output of a progress bar is no part of a page.
        cell["outputs"] = [o for o in cell.get("outputs", []) if o.get("name") != "stderr"]
    config = Config()
    config.ExtractOutputPreprocessor.output_filename_template = name + "/{cell_index}{extension}"
    text, resources = MarkdownExporter(config=config).from_notebook_node(notebook)
    text = re.sub(r"!\[\w+\]\(", "![Output](", text)
    text = "\n".join(line.rstrip() for line in text.strip().splitlines())
    note = f"\n\n---\n\nThis page is the notebook `docs/notebooks/{name}.ipynb`. `publish.py` in that folder executed it.\n"
    return re.sub(r"\n{3,}", "\n\n", text) + note, resources.get("outputs", {})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="execute only")
    parser.add_argument("names", nargs="*", metavar="NAME")
    arguments = parser.parse_args()
    for path in sorted(NOTEBOOKS.glob("*.ipynb")):
        name = path.stem
        if arguments.names and name not in arguments.names:
            continue
        notebook = nbformat.read(path, as_version=4)
        if any(cell.get("outputs") for cell in notebook.cells):
            sys.exit(f"{path.name} has stored outputs: clear them")
        NotebookClient(notebook, timeout=SECONDS, resources={"metadata": {"path": NOTEBOOKS}}).execute()
        text, pictures = page(name, notebook)
        for file, data in pictures.items():
            if len(data) > LARGEST_PICTURE:
                sys.exit(f"{file} has {len(data)} bytes: a picture may have {LARGEST_PICTURE}")
        print(f"{name}: {len(pictures)} pictures")
        if arguments.check:
            continue
        shutil.rmtree(PAGES / name, ignore_errors=True)
        (PAGES / name).mkdir(parents=True)
        (PAGES / f"{name}.md").write_text(text)
        for file, data in pictures.items():
            (PAGES / file).write_bytes(data)


if __name__ == "__main__":
    main()
