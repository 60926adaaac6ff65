"""Copies the docstrings of the compiled module into its stubs, where editors look for them.

Signatures and types in `_vellus.pyi` are written by hand. The docstrings are those of the Rust sources.

Usage, with the wheel installed: python stub_docs.py
"""

import ast
import inspect
from pathlib import Path

STUBS = Path(__file__).resolve().parents[1] / "python/vellus/_vellus.pyi"


def entries(tree, module):
    """Pairs of a definition in the stubs and the object of the module, for everything that is public."""
    for node in tree.body:
        if isinstance(node, (ast.ClassDef, ast.FunctionDef)) and not node.name.startswith("_"):
            owner = getattr(module, node.name)
            yield node, owner
            for member in node.body if isinstance(node, ast.ClassDef) else ():
                is_setter = any(isinstance(d, ast.Attribute) for d in getattr(member, "decorator_list", ()))
                if isinstance(member, ast.FunctionDef) and not member.name.startswith("_") and not is_setter:
                    yield member, getattr(owner, member.name)


def block(text, indent):
    """The lines of a docstring."""
    lines = text.split("\n")
    if len(lines) == 1:
        return [f'{indent}"""{text}"""']
    rest = [indent + line if line else "" for line in lines[1:]]
    return [f'{indent}"""{lines[0]}', *rest, f'{indent}"""']


def documented(text, module):
    """The text of the stubs, with the docstrings of the module."""
    lines = text.split("\n")
    for node, public in sorted(entries(ast.parse(text), module), key=lambda entry: -entry[0].lineno):
        first = node.body[0]
        doc = block(inspect.getdoc(public) or "", " " * (node.col_offset + 4))
        is_doc = isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant)
        if is_doc and isinstance(first.value.value, str):
            lines[first.lineno - 1 : first.end_lineno] = doc
        elif is_doc:
            # The body `...`, on the line where the signature ends.
            end = first.lineno - 1
            lines[end : end + 1] = [lines[end].removesuffix("...").rstrip(), *doc]
        else:
            start = first.lineno - 1 - len(getattr(first, "decorator_list", ()))
            lines[start:start] = doc
    return "\n".join(lines)


if __name__ == "__main__":
    from vellus import _vellus

    STUBS.write_text(documented(STUBS.read_text(), _vellus))
