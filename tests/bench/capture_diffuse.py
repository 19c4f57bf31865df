"""Photographs under diffuse light: w and half widths of a generated blade, photographed by the reference evaluation.

    python tests/bench/capture_diffuse.py --out ROWS [--seed 1] [--kind blade]

`togishi capture simulate` photographs a katana of known maps (noise, blur, 12 bits) under strip lights in three places;
`togishi capture diffuse` gives w from one picture with the blade's own lobes, and half widths and w from two with lobes
that are told it 12 % wrong.
"""

from __future__ import annotations

import base64
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from bench_rows import (
    Measurement,
    ResultsError,
    Row,
    command_line,
    togishi_command,
    write_measurement,
)

REPOSITORY = Path(__file__).resolve().parents[2]
MATERIAL = REPOSITORY / "data/materials/sashikomi_katana.toml"
WRONG = 1.12
LIGHT = 'light = "line:550"'
"""One wavelength, as through a narrow filter: a spectrum makes the reference five times slower, and nothing else."""
ONE, TWO = ["3"], ["1", "2"]
"""Photographs of the example set-up: beside the mirror direction of the ji, where the ha's radiance turns; and the two
strips 3 degrees apart about it."""


def togishi(*arguments: object) -> str:
    program = togishi_command()
    done = subprocess.run(
        [str(program), *map(str, arguments)], stdout=subprocess.PIPE, check=True, text=True
    )
    return done.stdout


def material_off_by(folder: Path, factor: float) -> Path:
    """The blade's material with other half widths of ji and ha."""
    text = MATERIAL.read_text(encoding="utf-8")
    for part in ("ji", "ha"):
        start = text.index(f"[parts.{part}]")
        end = text.index("[", start + 1)
        table = re.sub(
            r"(mu_[tb]_deg = )([0-9.]+)",
            lambda found: f"{found[1]}{float(found[2]) * factor:.6f}",
            text[start:end],
        )
        text = text[:start] + table + text[end:]
    path = folder / "off.toml"
    path.write_text(text, encoding="utf-8")
    return path


def evaluated(folder: Path, name: str, photographs: list[str], *more: object) -> Any:
    previews = folder / name
    previews.mkdir()
    return json.loads(
        togishi(
            "--json",
            *("capture", "diffuse", folder / "pictures/setup.toml"),
            *("-o", folder / f"{name}.exr", "--truth", folder / "pictures/truth.exr"),
            *("--preview", previews, "--only", *photographs, *more),
        )
    )


def picture(path: Path) -> str:
    return base64.b64encode(path.read_bytes()).decode()


def measure(kind: str, seed: int, quick: bool) -> Measurement:
    measured = Measurement()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        setup = togishi("capture", "simulate", "--example", kind)
        setup = setup.replace('light = "D65"', LIGHT)
        if quick:
            setup = re.sub(r"width_px = \d+", "width_px = 48", setup)
        (folder / "setup.toml").write_text(setup, encoding="utf-8")
        togishi(
            *("capture", "simulate", folder / "setup.toml", "--seed", seed),
            *("-o", folder / "pictures"),
        )
        one = evaluated(folder, "one", ONE)
        wrong = material_off_by(folder, WRONG)
        two = evaluated(folder, "two", TWO, "--material", wrong)
        how = f"{two['seen']} pixels of a generated {kind}, SNR 100, 12 bit, blur 0.6 pixels, seed {seed}"
        errors = two["errors"]
        measured.rows = [
            Row(
                "capture.diffuse_w_p90",
                max(one["errors"]["w_p90"], errors["w_p90"]),
                "",
                0.08,
                "<=",
                how=f"the worse of one source ({one['errors']['w_p90']:.3f}, lobes known) and two positions "
                f"({errors['w_p90']:.3f}, lobes told 12 % off); {how}",
            ),
            Row(
                "capture.diffuse_mu_p90_pct",
                errors["mu_p90_pct"],
                "%",
                10,
                "<=",
                how=f"two positions, leading lobe, where the photographs tell it; told 12 % off; {how}",
            ),
            Row(
                "capture.diffuse_masked_share",
                one["masked_share_w"],
                "",
                how="w, one source: share of the surface where it is masked",
            ),
            Row(
                "capture.diffuse_masked_share.two_w",
                two["masked_share_w"],
                "",
                how="w, two positions",
            ),
            Row(
                "capture.diffuse_masked_share.two_mu",
                two["masked_share_mu"],
                "",
                how="half width, two positions",
            ),
            Row(
                "capture.diffuse_coverage.w",
                errors["w_coverage"],
                "",
                how="share of the errors within one sigma; w = 0 and 1 are bounds, so more than 68 %",
            ),
            Row("capture.diffuse_coverage.mu", errors["mu_coverage"], "", how="the same of ln μ"),
        ]
        measured.pictures = {
            "w of a blade from one photograph under a strip light (coloured: masked)": picture(
                folder / "one/w.png"
            ),
            "w from two positions": picture(folder / "two/w.png"),
            "Half width of the leading lobe from two positions (violet: not told)": picture(
                folder / "two/mu.png"
            ),
        }
    return measured


def main() -> int:
    parser = command_line(__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", choices=("blade", "plate"), default="blade")
    options = parser.parse_args()
    write_measurement(options.out, measure(options.kind, options.seed, options.quick))
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (ResultsError, subprocess.CalledProcessError) as error:
        sys.exit(f"{Path(__file__).name}: {error}")
