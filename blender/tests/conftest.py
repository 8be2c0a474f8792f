"""Blender as a module, with the add-on registered. Without both there is nothing to test."""

import sys
from pathlib import Path

import pytest

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1])]
pytest.importorskip("bpy")
pytest.importorskip("cosine_lobes")

import cosine_lobes_engine  # noqa: E402


@pytest.fixture(scope="session", autouse=True)
def registered():
    # Installed by blender/check, it is registered already.
    import bpy

    if not hasattr(bpy.types.Scene, "cosine_lobes"):
        cosine_lobes_engine.register()
    yield
