"""The main job on real input, from dimensions and measured spectra to pictures: `make demo`.

Leaves out/demo/index.html with every file that it names. Runs with the bpy wheel, PYTHONPATH=addon.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "addon"), str(Path(__file__).resolve().parent)]

import numpy as np  # noqa: E402
import pictures  # noqa: E402
import studio  # noqa: E402
import togishi_core  # noqa: E402
from page import Picture, Section, write_page  # noqa: E402
from togishi import blender_versions  # noqa: E402
from togishi.core import bake_cost  # noqa: E402

WHOLE, CLOSE, COMPARED = (1600, 360), (1200, 520), (960, 416)
BESIDE = {WHOLE: (800, 180), CLOSE: (480, 208)}  # sizes of the references beside them
MIDDLE_MM, CLOSE_UP_MM = 262.0, 430.0
SAMPLES = 16
CLOSE_UP_LAMPS_MM = (330.0, 530.0)
SWEEP_FRAMES, SWEEP_SIZE = 72, (960, 240)
ELSEWHERE_SIZE, ELSEWHERE_SAMPLES = (780, 338), {"CYCLES": 48, "EEVEE": 8}

Step = Callable[[], Section]


class Demo:
    """The scene that the steps share, and where their files go."""

    def __init__(self, out: Path, togishi_command: Path) -> None:
        self.out = out
        self.command = togishi_command
        self.scene = studio.empty_scene()
        self.blade = studio.add_blade((4096, 512))
        self.exposure = 1.0

    def save(self, name: str, picture: np.ndarray, caption: str) -> Picture:
        pictures.save(self.out / name, picture)
        return Picture(name, caption)

    def togishi(self, *arguments: str) -> str:
        """The command line's standard output; its error message is ours where it fails."""
        done = subprocess.run(
            [str(self.command), *arguments], capture_output=True, text=True, check=False
        )
        if done.returncode:
            raise RuntimeError(f"togishi {' '.join(arguments)}: {done.stderr.strip()}")
        return done.stdout

    # --- steps ----------------------------------------------------------------------------------

    def input_files(self) -> Section:
        """What the pictures are made from, by the command line as an archive would run it."""
        measures = json.loads(
            self.togishi("--json", "katana", "-o", str(self.out / "blade.ply"), "--detail", "0.5")
        )
        self.togishi("bake", "-o", str(self.out / "blade_maps.exr"))
        spectra = [json.loads(self.togishi("--json", "spectrum", n)) for n in ("D65", "A", "LPS")]
        rows = [["measured again on the finished mesh", "mm"]]
        rows += [
            [key.removesuffix("_mm"), f"{value:.2f}"]
            for key, value in sorted(measures["measures"].items())
            if key.endswith("_mm")
        ]
        lights = ", ".join(s["title"] for s in spectra)
        return Section(
            "From figures to a blade",
            "Everything below is made from the blade's documented dimensions, the measured refractive index of iron "
            f"(Johnson & Christy 1974), the CIE 1931 observer and lamp spectra ({lights}). "
            "blade.ply and blade_maps.exr lie beside this page.",
            table=rows,
        )

    def shoot(self, name: str, size: tuple[int, int], caption: str, level: float = 99.0) -> Picture:
        """A final render by our engine, exposed for the level-th percentile of what is not black."""
        shot = studio.shoot(self.scene, self.out, size, "TOGISHI", SAMPLES)
        self.exposure = pictures.exposure_of(shot.rgb, shot.rgb.sum(axis=-1) > 1e-6, level)
        return self.save(
            f"{name}.png",
            pictures.to_display(shot.rgb, self.exposure),
            f"{caption} {shot.seconds:.1f} s.",
        )

    def beside(self, name: str, size: tuple[int, int]) -> list[Picture]:
        """The reference of the last picture, smaller, with the same exposure, and the difference from our renderer's."""
        result = studio.compare(self.scene, BESIDE[size])
        return [
            self.save(
                f"{name}_reference.png",
                pictures.to_display(result.reference_rgb, self.exposure),
                f"Reference: 61 wavelengths summed in double precision. {result.reference_seconds:.1f} s.",
            ),
            self.save(
                f"{name}_difference.png",
                pictures.difference_map(result.delta_e, DIFFERENCE_SCALE),
                f"ΔE00, black 0 to yellow {DIFFERENCE_SCALE}; largest {result.worst:.4f}.",
            ),
        ]

    def whole(self) -> Section:
        studio.aim_camera(self.scene, self.blade, MIDDLE_MM, 1010.0)
        studio.light(self.scene, self.blade, 9.0, lamps=(31, 1), room=0.08)
        caption = f"31 lamps in a row, 9° off the mirror direction; {SAMPLES} samples a pixel in"
        return Section(
            "The whole blade",
            "The ji mirrors the dark room and is nearly black; the ha, five degrees rough, still catches the lamps.",
            [[self.shoot("whole", WHOLE, caption)], self.beside("whole", WHOLE)],
        )

    def hamon(self) -> Section:
        studio.aim_camera(self.scene, self.blade, CLOSE_UP_MM, 72.0)
        shown = []
        for name, angle, text in (
            ("off", 11.0, "Off the mirror direction: the ha glows, the ji is nearly black."),
            ("between", 5.0, "Between: the nioiguchi stands out as a bright misty line."),
            (
                "mirror",
                0.0,
                "In the mirror direction: the ji flashes, with its hada; the ha stays behind.",
            ),
        ):
            studio.light(
                self.scene,
                self.blade,
                angle,
                along_mm=CLOSE_UP_LAMPS_MM,
                lamps=(15, 3),
                room=0.25,
            )
            shown.append([self.shoot(f"hamon_{name}", CLOSE, f"{text} {angle:.0f}°,", 99.9)])
            shown.append(self.beside(f"hamon_{name}", CLOSE))
        return Section(
            "The hamon, as the lamp moves",
            "72 mm of the blade under a small soft box. Each picture has its own exposure, as an eye would.",
            shown,
        )

    def kissaki(self) -> Section:
        studio.aim_camera(self.scene, self.blade, 705.0, 78.0)
        shown = []
        for name, angle in (("kissaki_off", 9.0), ("kissaki_mirror", 2.0)):
            studio.light(
                self.scene, self.blade, angle, along_mm=(560.0, 850.0), lamps=(15, 3), room=0.25
            )
            shown.append(
                self.shoot(name, CLOSE, f"{angle:.0f}° off the mirror direction of the ji,")
            )
        return Section(
            "The point",
            "Yokote, ko-shinogi and fukura; the boshi turns back along the mune.",
            [shown],
        )

    def anisotropy(self) -> Section:
        studio.aim_camera(self.scene, self.blade, CLOSE_UP_MM, 150.0)
        studio.light(self.scene, self.blade, 1.0, along_mm=(360.0, 500.0), lamps=(3, 1), room=0.25)
        settings = self.blade.active_material.togishi
        kept = {p: (getattr(settings, p).mu_t_deg, getattr(settings, p).mu_b_deg) for p in PARTS}
        anisotropic = self.shoot("anisotropic", CLOSE, "As polished,")
        exposure = self.exposure
        beside_anisotropic = self.beside("anisotropic", CLOSE)
        try:
            for part, (mu_t_deg, mu_b_deg) in kept.items():
                lobe = getattr(settings, part)
                lobe.mu_t_deg = lobe.mu_b_deg = (mu_t_deg * mu_b_deg) ** 0.5
            studio.bake(self.blade)
            shot = studio.shoot(self.scene, self.out, CLOSE, "TOGISHI", SAMPLES)
            beside_isotropic = self.beside("isotropic", CLOSE)
        finally:
            for part, (mu_t_deg, mu_b_deg) in kept.items():
                lobe = getattr(settings, part)
                lobe.mu_t_deg, lobe.mu_b_deg = mu_t_deg, mu_b_deg
            studio.bake(self.blade)
        isotropic = self.save(
            "isotropic.png",
            pictures.to_display(shot.rgb, exposure),
            f"The same lobes made round, same exposure, {shot.seconds:.1f} s.",
        )
        return Section(
            "Anisotropic and isotropic",
            "The polisher's strokes scatter light across themselves: highlights are long across the strokes. Three lamps, "
            "and their flashes in the ji.",
            [[anisotropic, *beside_anisotropic], [isotropic, *beside_isotropic]],
        )

    def spectra(self) -> Section:
        studio.aim_camera(self.scene, self.blade, CLOSE_UP_MM, 72.0)
        rows: list[list[Picture]] = []
        table = [["light", "largest ΔE00", "mean ΔE00", "GPU", "reference"]]
        for spectrum, title in (
            ("D65", "daylight D65"),
            ("A", "filament lamp A"),
            ("LPS", "low-pressure sodium lamp"),
        ):
            studio.light(
                self.scene,
                self.blade,
                4.0,
                spectrum=spectrum,
                along_mm=CLOSE_UP_LAMPS_MM,
                lamps=(13, 1),
            )
            result = studio.compare(self.scene, COMPARED)
            exposure = pictures.exposure_of(result.reference_rgb, result.steel, 97.0)
            rows.append(
                [
                    self.save(
                        f"{spectrum}_gpu.png",
                        pictures.to_display(result.rgb, exposure),
                        f"{title}: the viewport's picture.",
                    ),
                    self.save(
                        f"{spectrum}_reference.png",
                        pictures.to_display(result.reference_rgb, exposure),
                        "Reference: 61 wavelengths summed in double precision.",
                    ),
                    self.save(
                        f"{spectrum}_difference.png",
                        pictures.difference_map(result.delta_e, DIFFERENCE_SCALE),
                        f"ΔE00, black 0 to yellow {DIFFERENCE_SCALE}; largest {result.worst:.4f}.",
                    ),
                ]
            )
            table.append(
                [
                    title,
                    f"{result.worst:.4f}",
                    f"{result.mean:.4f}",
                    f"{result.gpu_seconds * 1e3:.0f} ms",
                    f"{result.reference_seconds * 1e3:.0f} ms",
                ]
            )
        return Section(
            "Three lamps, each beside the reference",
            "The viewport looks one small table up per angle; the reference sums every wavelength. A ΔE00 below 1 cannot "
            "be seen; the scale of the maps is a tenth of that.",
            rows,
            table,
        )

    def elsewhere(self) -> Section:
        studio.aim_camera(self.scene, self.blade, CLOSE_UP_MM, 72.0)
        # Few lamps: EEVEE loses light on software OpenGL where many stand apart.
        studio.light(self.scene, self.blade, 3.0, along_mm=(405.0, 455.0), lamps=(3, 1), room=0.25)
        shown, exposure = [], 1.0
        for name, engine, samples in (
            ("Togishi", "TOGISHI", SAMPLES),
            ("Cycles", "CYCLES", ELSEWHERE_SAMPLES["CYCLES"]),
            ("EEVEE", blender_versions.eevee_engine(), ELSEWHERE_SAMPLES["EEVEE"]),
        ):
            shot = studio.shoot(self.scene, self.out, ELSEWHERE_SIZE, engine, samples)
            if name == "Togishi":
                exposure = pictures.exposure_of(shot.rgb, shot.rgb.sum(axis=-1) > 0.0, 97.0)
            shown.append(
                self.save(
                    f"in_{name.lower()}.png",
                    pictures.to_display(shot.rgb, exposure),
                    f"{name}, {samples} samples: {shot.seconds:.1f} s.",
                )
            )
        costs = bake_cost.costs("iron_johnson_christy", "D65")
        table = [["node group baked for D65, used under", "largest ΔE00 over all angles"]]
        table += [[light, f"{cost:.2f}"] for light, cost in costs.items()]
        return Section(
            "The same blade in Cycles and EEVEE",
            "The node group Togishi Steel uses the same tables and maps, so a blade can be rendered without our engine. It "
            "is baked for one light; the table says what that costs under others. EEVEE knows no anisotropy: several "
            "lobes, bent along the wide axis, stand in for it. All three at one exposure.",
            [shown],
            table,
        )

    def sweep(self) -> Section:
        """Frames by the headless command, as a render farm makes them."""
        folder = self.out / "sweep"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        blend = self.out / "light_sweep.blend"
        environment = {**os.environ, "PYTHONPATH": str(ROOT / "addon")}
        start = time.perf_counter()
        for command in (
            [sys.executable, str(ROOT / "blend_files" / "light_sweep.py"), str(blend)],
            [
                *(sys.executable, "-m", "togishi", "render", str(blend)),
                *("-o", str(folder / "####.png"), "-f", f"1-{SWEEP_FRAMES}", "--samples", "6"),
                *("--resolution", f"{SWEEP_SIZE[0]}x{SWEEP_SIZE[1]}"),
            ],
            [
                *(
                    "ffmpeg",
                    "-y",
                    "-loglevel",
                    "error",
                    "-framerate",
                    "24",
                    "-i",
                    str(folder / "%04d.png"),
                ),
                *(
                    "-c:v",
                    "libx264",
                    "-pix_fmt",
                    "yuv420p",
                    "-crf",
                    "16",
                    str(self.out / "sweep.mp4"),
                ),
            ],
        ):
            done = subprocess.run(
                command, capture_output=True, text=True, env=environment, check=False
            )
            if done.returncode:
                raise RuntimeError(f"{' '.join(command)}: {done.stderr.strip()[-800:]}")
        seconds = time.perf_counter() - start
        chosen = [1 + round(i * (SWEEP_FRAMES - 1) / 11) for i in range(12)]
        sheet = pictures.contact_sheet(
            [pictures.load(folder / f"{frame:04d}.png") for frame in chosen], 2
        )
        return Section(
            "A lamp carried along the blade",
            f"{SWEEP_FRAMES} frames by `python -m togishi render` in {seconds:.0f} s.",
            [
                [Picture("sweep.mp4", "The sweep as a film.")],
                [self.save("sweep_sheet.png", sheet, "Every sixth frame, in reading order.")],
            ],
        )


PARTS = ("ji", "ha", "hadori", "shinogi_ji", "mune", "kissaki")
DIFFERENCE_SCALE = 0.1


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/demo"))
    parser.add_argument(
        "--togishi", type=Path, default=ROOT / "build" / "release" / "cpp_core" / "cli" / "togishi"
    )
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    start = time.perf_counter()
    demo = Demo(options.out.resolve(), options.togishi)
    print(
        f"[demo] the blade stands, with its maps: {time.perf_counter() - start:.1f} s", flush=True
    )
    steps: tuple[tuple[str, Step], ...] = (
        ("files by the command line", demo.input_files),
        ("the whole blade", demo.whole),
        ("the hamon as the lamp moves", demo.hamon),
        ("the point", demo.kissaki),
        ("anisotropic and isotropic", demo.anisotropy),
        ("three lamps beside the reference", demo.spectra),
        ("Cycles and EEVEE", demo.elsewhere),
        ("the light sweep", demo.sweep),
    )
    sections = []
    for number, (title, step) in enumerate(steps, 1):
        began = time.perf_counter()
        print(f"[demo] {number}/{len(steps)} {title} …", flush=True)
        sections.append(step())
        print(f"[demo]     {time.perf_counter() - began:.1f} s", flush=True)
    sections.append(sections.pop(0))  # pictures first, the record of their making last
    total = time.perf_counter() - start
    write_page(
        options.out / "index.html",
        "Togishi 研ぎ師",
        f"A Japanese sword from measured figures. Made in {total:.0f} s by version {togishi_core.__version__}.",
        sections,
    )
    studio.close()
    print(f"[demo] {options.out / 'index.html'} in {total:.0f} s", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
