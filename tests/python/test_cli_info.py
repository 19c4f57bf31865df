"""togishi info over blade presets; maps: test_cli_bake.py, tables and materials:
test_cli_spectrum.py."""

import json
from pathlib import Path

import pytest
import togishi_core

BLADES = sorted((Path(__file__).parents[2] / "data" / "blades").glob("*.toml"))


@pytest.mark.parametrize("path", BLADES, ids=lambda path: path.stem)
def test_presets(togishi, path):
    done = togishi("--json", "info", path)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    preset = togishi_core.katana_presets()[path.stem]
    assert found["kind"] == "blade preset"
    assert found["checks"] == "passed"
    for key in ("title", "source", "licence"):
        assert found[key] == preset[key]
    assert {key: found[key] for key in preset["parameters"]} == preset["parameters"]
    text = togishi("info", path).stdout
    assert preset["title"] in text
    assert "nagasa_mm" in text


HEAD = 'title = "t"\nsource = "s"\nlicence = "l"\n'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (HEAD + "[katana]\nnagase_mm = 3\n", ["nagase_mm"]),
        (HEAD + "[ katana ]\nnagasa_mm = nan\n", ["nagasa_mm", "nan"]),
        (HEAD + "katana = { sori_mm = 400 }\n", ["sori_mm", "400"]),
        ("[katana]\n", ["title", "missing"]),
        ("[katana]\nnagasa_mm = = 3\n", ["line 2", "TOML"]),
        ("x" * 2_000_000 + "\n[katana]\n", ["mine.toml"]),
        ("[katana]\n" + "#" * 2_000_000, ["size", "1 MiB"]),
    ],
)
def test_bad_presets(togishi, tmp_path, text, words):
    path = tmp_path / "mine.toml"
    path.write_text(text)
    done = togishi("info", path)
    assert done.returncode == 2
    assert done.stdout == ""
    assert "mine.toml" in done.stderr
    assert "allowed:" in done.stderr
    for word in words:
        assert word in done.stderr, done.stderr
