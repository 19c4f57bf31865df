"""Fitting a goniometer's scans in the add-on: file, fit, plots, table, application, undo, refusals."""

from __future__ import annotations

import json
import threading

import bpy
import numpy as np
import pytest
from ui_fixtures import add_katana, addon  # noqa: F401

pytestmark = pytest.mark.usefixtures("addon")

from togishi import blade_object, measurement, properties  # noqa: E402
from togishi.core import fit_apply, fit_table, native  # noqa: E402

TRUTH = {"mu_t_deg": 4.0, "mu_b_deg": 2.5, "rho_deg": 30.0}


def truth() -> dict:
    material = native.core().default_material()
    material["parts"]["ha"].update(TRUTH)
    material["parts"]["ji"].update(mu_t_deg=1.0, mu_b_deg=1.0, rho_deg=0.0)
    return material


def write_scans(path, part="hamon", **options):
    """Few readings: what is tested is the way of the data, not the fit."""
    options = {"channels": ["intensity_550nm"], "step_deg": 0.5, "pedestal": 0.005, **options}
    scans = native.core().simulate_scan(truth(), part, options)
    path.write_text(scans.to_text(), encoding="utf-8")
    return path


def fit(path, **settings) -> set[str]:
    return bpy.ops.scene.togishi_measurement_fit(filepath=str(path), **settings)


def pixels_of(image) -> np.ndarray:
    pixels = np.empty(image.size[0] * image.size[1] * 4, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(image.size[1], image.size[0], 4)


def test_fit_keeps_records_and_pictures(tmp_path):
    assert fit(write_scans(tmp_path / "ha.csv")) == {"FINISHED"}
    kept = bpy.context.scene.togishi_measurement
    assert kept.title == "ha.csv"
    assert [item.name for item in kept.fits] == ["hamon"]
    lobe = fit_table.lobe_of(json.loads(kept.fits[0].record_json))
    assert lobe["mu_t_deg"] == pytest.approx(4.0, rel=5e-3)
    assert lobe["mu_b_deg"] == pytest.approx(2.5, rel=5e-3)
    assert lobe["rho_deg"] == pytest.approx(30.0, abs=0.3)
    for image, width in ((kept.fits[0].scans_image, 1600), (kept.fits[0].mu_eff_image, 1000)):
        assert image.size[0] == width
        assert image.packed_file is not None
        pixels = pixels_of(image)
        # Light ground, dark ink, and the colour of what was measured.
        assert np.median(pixels[..., :3]) > 0.95
        assert (pixels[..., :3].max(axis=2) < 0.3).mean() > 1e-3
        assert (pixels[..., 2] - pixels[..., 0] > 0.2).mean() > 3e-4
    # The title stands above: rows run upwards.
    rows = pixels_of(kept.fits[0].scans_image)[..., 0].min(axis=1)
    assert rows[-60:].min() < 0.4
    assert rows[:8].min() > 0.9


def test_a_fit_survives_saving(tmp_path):
    fit(write_scans(tmp_path / "ha.csv"))
    record = bpy.context.scene.togishi_measurement.fits[0].record_json
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene.blend"))
    kept = bpy.context.scene.togishi_measurement.fits[0]
    assert kept.record_json == record
    assert pixels_of(kept.scans_image).std() > 0.01


def test_both_parts_in_one_measurement(tmp_path):
    write_scans(tmp_path / "ha.csv")
    write_scans(tmp_path / "ji.csv", "ji", protocol="b", step_deg=1.0, incidences_deg=[25, 45])
    files = [{"name": "ha.csv"}, {"name": "ji.csv"}]
    assert bpy.ops.scene.togishi_measurement_fit(directory=str(tmp_path), files=files) == {
        "FINISHED"
    }
    kept = bpy.context.scene.togishi_measurement
    assert [item.name for item in kept.fits] == ["ji", "hamon"]
    images = len(bpy.data.images)
    assert fit(tmp_path / "ha.csv") == {"FINISHED"}
    assert [item.name for item in kept.fits] == ["hamon"]
    assert len(bpy.data.images) == images - 2


def test_apply_to_ha_is_what_the_core_makes_of_it(tmp_path):
    path = write_scans(tmp_path / "ha.csv")
    material = blade_object.blade_material(add_katana())
    before = properties.material_dict(material)
    fit(path)
    assert bpy.ops.scene.togishi_measurement_apply(part="ha") == {"FINISHED"}
    after = properties.material_dict(material, with_fits=True)
    core = native.core()
    expected = core.material_from_fits([core.fit_scans(core.read_scans([str(path)])[0])], before)
    assert after["weights"] == expected["weights"] == "measured"
    assert after["metal"] == expected["metal"]
    for part in expected["parts"]:
        for name, value in expected["parts"][part].items():
            np.testing.assert_allclose(after["parts"][part][name], value, rtol=1e-5, atol=1e-5)
    assert "ha.csv" in after["source"]
    saved = tmp_path / "fitted.toml"
    assert bpy.ops.material.togishi_save(filepath=str(saved)) == {"FINISHED"}
    record = core.load_material(str(saved))["fit"]["ha"]
    assert record["input"][0]["sha256"] == core.read_scans([str(path)])[0].inputs[0]["sha256"]
    # What is edited is no measurement any more.
    material.togishi.ha.mu_t_deg = 6.0
    assert "fit" not in properties.material_dict(material, with_fits=True)


def test_apply_to_hadori_and_undo(tmp_path):
    bpy.context.preferences.edit.use_global_undo = True
    add_katana()
    fit(write_scans(tmp_path / "ha.csv"))
    bpy.ops.ed.undo_push(message="before")
    name = blade_object.blade_material(bpy.context.active_object).name
    before = properties.material_dict(bpy.data.materials[name])
    assert bpy.ops.scene.togishi_measurement_apply(part="hadori") == {"FINISHED"}
    bpy.ops.ed.undo_push(message="applied")
    after = properties.material_dict(bpy.data.materials[name])
    assert after["parts"]["hadori"]["mu_t_deg"] == pytest.approx(4.0, rel=5e-3)
    assert after["parts"]["ha"]["mu_t_deg"] == before["parts"]["ha"]["mu_t_deg"]
    bpy.ops.ed.undo()
    assert properties.material_dict(bpy.data.materials[name]) == before


def test_a_relative_scale_leaves_the_weights_normalised(tmp_path):
    material = blade_object.blade_material(add_katana())
    fit(write_scans(tmp_path / "ha.csv", calibration="relative"))
    assert bpy.ops.scene.togishi_measurement_apply(part="ha") == {"FINISHED"}
    assert material.togishi.weights == "normalised"
    assert material.togishi.ha.mu_t_deg == pytest.approx(4.0, rel=5e-3)


def test_refusals_change_nothing(tmp_path):
    material = blade_object.blade_material(add_katana())
    with pytest.raises(RuntimeError, match=r"Nothing was fitted.*missing"):
        fit(tmp_path / "missing.csv")
    path = write_scans(tmp_path / "ha.csv")
    path.write_text(path.read_text().replace("receive_deg", "detector"), encoding="utf-8")
    with pytest.raises(RuntimeError, match="Nothing was fitted"):
        fit(path)
    assert len(bpy.context.scene.togishi_measurement.fits) == 0
    assert not bpy.ops.scene.togishi_measurement_apply.poll()
    fit(write_scans(tmp_path / "ha.csv"))
    before = properties.material_dict(material)
    with pytest.raises(RuntimeError, match="allowed are ha, hadori"):
        bpy.ops.scene.togishi_measurement_apply(part="ji")
    with pytest.raises(RuntimeError, match="the measurement has 1"):
        bpy.ops.scene.togishi_measurement_apply(part="ha", index=3)
    assert properties.material_dict(material) == before


def test_a_cancelled_job_has_no_result(tmp_path):
    job = measurement.FitJob([str(write_scans(tmp_path / "ha.csv", step_deg=0.02))], {})
    job.cancel()
    job.start()
    with pytest.raises(InterruptedError):
        job.result()
    assert not measurement.is_running()
    assert "togishi-fit" not in {thread.name for thread in threading.enumerate()}


def test_the_fit_runs_beside_the_main_thread(tmp_path):
    job = measurement.FitJob([str(write_scans(tmp_path / "ha.csv", step_deg=0.02))], {})
    job.start()
    turns = 0
    while not job.done:
        turns += 1
    assert turns > 100
    assert 0.0 < job.share <= 1.0
    assert len(job.result()) == 1


@pytest.mark.parametrize(
    ("value", "sigma", "text"),
    [
        (7.99812, 0.00372, "7.9981 ± 0.0037"),
        (45.0, 12.0, "45 ± 12"),
        (1201.3, 240.0, "1201 ± 2.4e+02"),
        (2.0, 0.0, "2"),
        (1e-3, 1e-15, "0.001 ± 1e-15"),
        (3.0, float("inf"), "3"),
    ],
)
def test_values_are_written_as_sure_as_they_are(value, sigma, text):
    assert fit_table.measured_text(value, sigma) == text


def test_table_says_why_something_is_not_determined(tmp_path):
    # One turn of the sample sees one direction of the lobe only.
    fit(write_scans(tmp_path / "ha.csv", turns_deg=[0.0]))
    table = fit_table.fit_table(bpy.context.scene.togishi_measurement.fits[0].record_json)
    rows = {row.label: row for row in table.rows}
    assert rows["β"].determined or rows["β"].reason
    assert rows["ρ"].value == "not determined"
    assert rows["ρ"].reason
    assert "reduced χ²" in table.summary[0]


def test_normalised_weight_is_the_shared_formula():
    for mu_t, mu_b in ((0.5, 0.3), (5.0, 5.0), (12.0, 9.0)):
        part = {"mu_t_deg": mu_t, "mu_b_deg": mu_b, "rho_deg": 20.0}
        expected = np.log(2) / (4 * np.pi * np.radians(mu_t) * np.radians(mu_b))
        assert fit_apply.normalised_weight(part) == pytest.approx(expected, rel=1e-6)
