"""The stubs say what the module has."""

import ast
import importlib.util
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import cosine_lobes as cl
from cosine_lobes import _native

PACKAGE = Path(cl.__file__).parent
STUB = PACKAGE / "_native.pyi"


def parameters(arguments: ast.arguments):
    names = [a.arg for a in (*arguments.posonlyargs, *arguments.args)]
    only = {a.arg for a in arguments.kwonlyargs}
    return [name for name in names if name not in ("self", "cls")], only, arguments.kwarg is not None


def stated(function):
    """Names of positional and of keyword parameters, as the module states them."""
    all_ = [p for p in inspect.signature(function).parameters.values() if p.name not in ("self", "cls")]
    only = {p.name for p in all_ if p.kind is p.KEYWORD_ONLY}
    positional = [p.name for p in all_ if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
    return positional, only, any(p.kind is p.VAR_KEYWORD for p in all_)


def test_every_name_and_parameter_is_in_the_stub():
    tree = ast.parse(STUB.read_text())
    items = {node.name: node for node in tree.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    own = {name for name in dir(_native) if not name.startswith("_")}
    assert own == {name for name in items if not name.startswith("_")} == set(cl.__all__) == set(_native.__all__)
    for name in own:
        node, value = items[name], getattr(_native, name)
        if isinstance(node, ast.FunctionDef):
            assert parameters(node.args) == stated(value), name
            continue
        members = {member.name: member for member in node.body if isinstance(member, ast.FunctionDef)}
        public = {member for member in vars(value) if not member.startswith("_")}
        assert public == {member for member in members if not member.startswith("_")}, name
        for member in public:
            attribute = inspect.getattr_static(value, member)
            is_property = any(isinstance(d, (ast.Name, ast.Attribute)) and "static" not in ast.dump(d) for d in members[member].decorator_list)
            assert is_property == inspect.isgetsetdescriptor(attribute), f"{name}.{member}"
            if not is_property:
                assert parameters(members[member].args) == stated(getattr(value, member)), f"{name}.{member}"
        if "__new__" in members:
            assert parameters(members["__new__"].args) == stated(value), name


def test_everything_has_a_text():
    for name in cl.__all__:
        value = getattr(cl, name)
        assert value.__doc__, name
        if inspect.isclass(value) and not issubclass(value, Exception):
            for member, attribute in vars(value).items():
                if not member.startswith("_") and inspect.isroutine(attribute):
                    assert attribute.__doc__, f"{name}.{member}"


@pytest.mark.skipif(importlib.util.find_spec("mypy") is None, reason="mypy is not installed")
def test_stubtest_agrees():
    words = [sys.executable, "-m", "mypy.stubtest", "cosine_lobes"]
    done = subprocess.run(words, cwd=PACKAGE.parent, check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.skipif(importlib.util.find_spec("mypy") is None, reason="mypy is not installed")
def test_examples_have_the_stated_types():
    folder = PACKAGE.parent
    files = [str(path) for path in sorted((folder / "examples").glob("*.py"))]
    if not files:
        pytest.skip("installed without examples")
    words = [sys.executable, "-m", "mypy", "--ignore-missing-imports", "--explicit-package-bases", *files]
    done = subprocess.run(words, cwd=folder, check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
