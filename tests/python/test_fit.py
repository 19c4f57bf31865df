"""Scans and their fit, as Python and a shell see them."""

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
import togishi_core

MATERIAL = togishi_core.load_material("polished_katana")
QUICK = {"channels": ["intensity_550nm"], "protocol": "a", "step_deg": 0.4}


def run(togishi: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(togishi), *arguments], capture_output=True, text=True, timeout=120, check=False
    )


def values(fit: togishi_core.Fit) -> dict[str, float]:
    return {p["name"]: p["value"] for p in fit.record["parameter"]}


def test_from_a_scan_to_a_material(tmp_path: Path) -> None:
    scans = togishi_core.simulate_scan(MATERIAL, "hamon", {**QUICK, "tilt_t_deg": 0.1})
    path = tmp_path / "ha.csv"
    path.write_text(scans.to_text())
    (read,) = togishi_core.read_scans([str(path)])
    assert read.readings == scans.readings == 4 * 101
    np.testing.assert_array_equal(read.scans[1]["intensity"], scans.scans[1]["intensity"])
    seen: list[float] = []
    fit = togishi_core.fit_scans(read, progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == 1
    truth = MATERIAL["parts"]["ha"]
    assert values(fit)["mu_t_deg"] == pytest.approx(truth["mu_t_deg"], rel=0.01)
    assert values(fit)["mu_b_deg"] == pytest.approx(truth["mu_b_deg"], rel=0.01)
    assert fit.record["input"][0]["sha256"] == read.inputs[0]["sha256"]
    for scan, fitted in zip(read.scans, fit.scans, strict=True):
        assert fitted["modelled"].shape == scan["intensity"].shape
        assert np.isfinite(fitted["residual_sigma"]).all()
    curve = fit.curve(0, read.scans[0]["receive_deg"])
    np.testing.assert_allclose(curve, fit.scans[0]["modelled"], rtol=1e-9)
    widths = fit.mu_eff_deg(np.array([0.0, 90.0, 180.0]))
    assert widths[0] == pytest.approx(widths[2])

    material = togishi_core.material_from_fits([fit], MATERIAL, "fitted")
    assert material["weights"] == "measured"
    assert material["parts"]["ha"]["mu_t_deg"] == fit.lobe["mu_t_deg"]
    toml = tmp_path / "fitted.toml"
    toml.write_text(togishi_core.material_to_toml(material))
    assert togishi_core.load_material(str(toml)) == material
    assert material["fit"]["ha"]["parameter"][0]["unit"] == "1/sr"


def test_cancel_and_errors_pass_through() -> None:
    scans = togishi_core.simulate_scan(MATERIAL, "hamon", QUICK)
    with pytest.raises(InterruptedError):
        togishi_core.fit_scans(scans, progress=lambda done: False)

    def fail(done: float) -> None:
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        togishi_core.fit_scans(scans, progress=fail)


@pytest.mark.parametrize(
    ("options", "word"),
    [({"startz": 3}, "startz"), ({"starts": 2.5}, "starts"), ({"haze": "maybe"}, "haze"),
     ({"tilt": 1}, "tilt"), ({"metal": "cheese"}, "cheese"), ({"gain_prior": "x"}, "gain_prior")],
)  # fmt: skip
def test_fit_options_are_checked(options: dict, word: str) -> None:
    scans = togishi_core.simulate_scan(MATERIAL, "hamon", QUICK)
    with pytest.raises(togishi_core.InputError, match=word):
        togishi_core.fit_scans(scans, options)


@pytest.mark.parametrize(
    ("options", "word"),
    [({"noise": 3}, "noise"), ({"protocol": "z"}, "protocol"), ({"seed": -1}, "seed"),
     ({"channels": ["loudness"]}, "loudness"), ({"pedestal": float("nan")}, "pedestal"),
     ({"step_deg": 0}, "step_deg"), ({"turns_deg": "0"}, "turns_deg")],
)  # fmt: skip
def test_simulation_options_are_checked(options: dict, word: str) -> None:
    with pytest.raises(togishi_core.InputError, match=word):
        togishi_core.simulate_scan(MATERIAL, "hamon", options)


def test_defaults_are_what_the_functions_take() -> None:
    defaults = togishi_core.simulation_defaults()
    scans = togishi_core.simulate_scan(MATERIAL, "hamon", {**defaults, **QUICK})
    assert scans.part == "hamon"
    togishi_core.fit_scans(scans, togishi_core.fit_defaults())


def test_command_line(togishi_cli: Path, tmp_path: Path) -> None:
    ha, ji, out = tmp_path / "ha.csv", tmp_path / "ji.csv", tmp_path / "blade.toml"
    done = run(
        togishi_cli, "simulate-scan", "-o", str(ha), "--channel", "intensity_550nm", "--step", "0.4",
        "--tilt-t-deg", "0.1", "--seed", "5",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    done = run(
        togishi_cli, "simulate-scan", "-o", str(ji), "--part", "ji", "--protocol", "b",
        "--channel", "intensity_550nm", "--json",
    )  # fmt: skip
    assert json.loads(done.stdout)["scans"] == 6
    done = run(togishi_cli, "fit", str(ha), str(ji), "-o", str(out), "--json", "--curves")
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert [fit["part"] for fit in report["fits"]] == ["ji", "ha"]
    for fit in report["fits"]:
        assert 0.8 < fit["chi2_reduced"] < 1.2
        assert len(fit["correlations"]) == len(fit["parameters"])
        assert len(fit["scans"][0]["rows"]) > 50
    material = togishi_core.load_material(str(out))
    assert set(material["fit"]) == {"ji", "ha"}
    assert run(togishi_cli, "info", str(out)).returncode == 0
    assert "mu_t_deg" in run(togishi_cli, "fit", str(ha)).stdout


@pytest.mark.parametrize(
    "arguments",
    [["fit"], ["fit", "/no/such.csv"], ["fit", "{ha}", "-o", "x.csv"], ["fit", "{ha}", "--set", "part"],
     ["fit", "{ha}", "--haze", "maybe"], ["fit", "{ha}", "--starts", "0"], ["fit", "{ha}", "{ha}"],
     ["simulate-scan", "-o", "/no/such/folder/x.csv"], ["simulate-scan", "-o", "x.csv", "--part", "tsuba"]],
)  # fmt: skip
def test_wrong_arguments_end_with_2(
    togishi_cli: Path, tmp_path: Path, arguments: list[str]
) -> None:
    ha = tmp_path / "ha.csv"
    ha.write_text(togishi_core.simulate_scan(MATERIAL, "hamon", QUICK).to_text())
    done = run(togishi_cli, *[a.replace("{ha}", str(ha)) for a in arguments])
    assert done.returncode == 2, done.stdout
    assert done.stderr
