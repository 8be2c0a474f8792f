"""The code of the document and the examples runs."""

import re
import runpy
import sys

import numpy as np
import pytest

from conftest import ROOT

DOCUMENT = ROOT / "docs" / "python.md"
EXAMPLES = ROOT / "python" / "examples"


def test_the_code_of_the_document_runs(monkeypatch, tmp_path):
    blocks = re.findall(r"```python\n(.*?)```", DOCUMENT.read_text(), re.DOTALL)
    assert len(blocks) == 5
    text = "\n".join(blocks)
    for whole, less in [
        ('load("scenes/soft_spheres.toml")', f'load({str(ROOT / "scenes" / "soft_spheres.toml")!r}, size=(32, 18))'),
        ("size=(640, 360)", "size=(32, 18)"),
        ("size=(320, 180)", "size=(16, 9)"),
        ("range(100)", "range(3)"),
        ('bake("room.glb", "baked.glb"', f'bake({str(ROOT / "bake" / "tests" / "room.toml")!r}, "baked.glb", page=256, samples=1'),
    ]:
        assert whole in text
        text = text.replace(whole, less)
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    exec(compile(text, str(DOCUMENT), "exec"), names)  # noqa: S102
    assert names["irradiance"].shape == (50, 3) and (names["irradiance"] > 0).all()
    assert names["light"].shape == (256, 256, 3) and names["light"].max() > 0
    assert names["report"]["texels"] > 100 and (tmp_path / "baked.lightmap0.png").exists()
    assert names["renderer"].size == (16, 9) and (tmp_path / "picture.png").stat().st_size > 100


@pytest.mark.parametrize(
    "name, words, last",
    [
        ("light_sweep", ["-n", "2", "--size", "32", "18", "-o", "out"], "built anew since the first picture: nothing"),
        ("day_of_sun", ["-n", "3", "--size", "32", "18", "-o", "out"], "hierarchies built: 1, in 3 frames"),
        ("shadow_study", ["-n", "60", "-o", "study.png"], None),
    ],
)
def test_examples_run(monkeypatch, capsys, tmp_path, name, words, last):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [name, *words])
    names = runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")
    lines = capsys.readouterr().out.splitlines()
    if last is not None:
        assert lines[-1] == last
        pictures = sorted((tmp_path / "out").glob("*.png"))
        assert len(pictures) == int(words[1]) and all(picture.stat().st_size > 100 for picture in pictures)
        return
    x = np.linspace(0.4, 2.6, 60)
    for radius in (0.25, 2.0):
        error = np.abs(names["rendered"](radius, x) - names["integrated"](radius, x))
        assert error.mean() < 2e-4 and error.max() < 2e-3
