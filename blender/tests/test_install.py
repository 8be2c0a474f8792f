"""The zip file as a person installs it: into an empty profile, with its wheel, and then F12."""

import os
import subprocess
import sys

import pytest

#: Run by a Blender that has neither the package nor the add-on on its path.
SCRIPT = """
import bpy, sys
import addon_utils
bpy.ops.wm.read_factory_settings()
addon_utils.extensions_refresh()
bpy.ops.extensions.package_install_files(filepath=sys.argv[1], repo="user_default", enable_on_install=True)
import cosine_lobes
assert cosine_lobes.__file__.startswith(sys.argv[2]), cosine_lobes.__file__
scene = bpy.context.scene
scene.render.engine, scene.render.resolution_percentage = "COSINE_LOBES", 10
scene.render.filepath = sys.argv[3]
bpy.ops.render.render(write_still=True)
print("RENDERED", scene.cosine_lobes.tolerance)
"""


def test_the_zip_installs_and_renders_the_startup_scene(tmp_path):
    addon = os.environ.get("LOBES_ADDON")
    if not addon:
        pytest.skip("LOBES_ADDON names no zip file: blender/check makes one")
    profile, picture = tmp_path / "user", tmp_path / "picture.png"
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    environment["BLENDER_USER_RESOURCES"] = str(profile)
    command = [sys.executable, "-c", SCRIPT, addon, str(profile), str(picture)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120)
    assert "RENDERED" in done.stdout, done.stdout + done.stderr
    assert picture.stat().st_size > 1000


def test_blender_s_own_panels_show_for_the_engine():
    import bpy

    shown = {panel.__name__ for panel in bpy.types.Panel.__subclasses__() if "COSINE_LOBES" in getattr(panel, "COMPAT_ENGINES", ())}
    wanted = {"DATA_PT_EEVEE_light", "DATA_PT_spot", "EEVEE_MATERIAL_PT_surface", "EEVEE_WORLD_PT_surface", "DATA_PT_lens", "RENDER_PT_format"}
    assert wanted <= shown and "RENDER_PT_eevee_sampling" not in shown


def test_the_add_on_leaves_without_a_trace():
    import bpy

    import cosine_lobes_engine

    cosine_lobes_engine.unregister()
    try:
        assert not hasattr(bpy.types.Scene, "cosine_lobes")
        left = [p.__name__ for p in bpy.types.Panel.__subclasses__() if "COSINE_LOBES" in getattr(p, "COMPAT_ENGINES", ())]
        # Its own classes, which Python keeps.
        assert all(name.endswith("cosine_lobes") for name in left)
    finally:
        cosine_lobes_engine.register()
