"""The reference of the Python package as Markdown, from its source: `python python.py FOLDER`."""

import ast
import inspect
import sys
from pathlib import Path

FOLDER = Path(sys.argv[1])
KINDS = (ast.FunctionDef, ast.ClassDef)


def documented(node):
    return inspect.cleandoc(ast.get_docstring(node) or "")


def signature(name, function):
    arguments = ast.unparse(function.args)
    returns = f" -> {ast.unparse(function.returns)}" if function.returns else ""
    short = f"{name}({arguments}){returns}"
    if len(short) <= 100:
        return short
    parts = [function.args.posonlyargs + function.args.args, function.args.kwonlyargs]
    fixed = [None] * (len(parts[0]) - len(function.args.defaults)) + function.args.defaults
    written = [one(argument, default) for argument, default in zip(parts[0], fixed)]
    if parts[1]:
        written += ["*", *map(one, parts[1], function.args.kw_defaults)]
    return "\n".join([f"{name}(", *(f"    {line}," for line in written), f"){returns}"])


def one(argument, default):
    annotation = f": {ast.unparse(argument.annotation)}" if argument.annotation else ""
    value = "" if default is None else f" = {ast.unparse(default)}" if annotation else f"={ast.unparse(default)}"
    return argument.arg + annotation + value


def section(name, node, level="##"):
    yield f"{level} {name}\n"
    if isinstance(node, ast.FunctionDef):
        yield f"```text\n{signature(name.removeprefix('plot.'), node)}\n```\n"
    yield documented(node) + "\n"
    for member in node.body if isinstance(node, ast.ClassDef) else ():
        if isinstance(member, KINDS) and not member.name.startswith("_") and documented(member):
            yield f"- **{member.name}**: {' '.join(documented(member).split())}"
    yield ""


init = ast.parse((FOLDER / "__init__.py").read_text())
named = next(ast.literal_eval(n.value) for n in init.body if isinstance(n, ast.Assign) and n.targets[0].id == "__all__")
modules = {path.stem: ast.parse(path.read_text()) for path in FOLDER.glob("*.py")}
found = {n.name: n for tree in modules.values() for n in tree.body if isinstance(n, KINDS)}
for name in sorted(named, key=lambda name: (name[0].isupper(), name)):
    if name in modules and name not in found:
        parts = [n for n in modules[name].body if isinstance(n, KINDS) and not n.name.startswith("_")]
        for part in parts:
            print("\n".join(section(f"{name}.{part.name}", part)))
    else:
        print("\n".join(section(name, found[name])))
