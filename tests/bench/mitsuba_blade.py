"""Photographs of a blade of known maps by Mitsuba 3, as a stranger would take them: capture_round_trip.py reads them.

Runs in .venv-mitsuba, with nothing of Togishi but the files that it is told. Reads from standard input

    {"mesh": "blade.obj", "maps": "truth.exr", "eta": 2.9, "k": 3.1, "samples": 512, "seed": 1,
     "camera": {"width_px": 200, "height_px": 80, "scale_px_per_mm": 2.5, "position_mm": [...], "right": [...],
     "down": [...]},
     "pictures": [{"file": "1.npy", "centre_mm": [...], "half_u_mm": [...], "half_v_mm": [...]}]}

and writes each picture as (height, width) numbers, the top row first: radiance under an evenly bright rectangle of radiance
1, without the camera's blur and noise.
Material: two plugins `roughconductor` (Beckmann, textured alpha_u and alpha_v, alpha = tan(mu)/sqrt(ln 2)), blended by a
texture of w. Its lobes lie along the blade's length or across it, so the maps' e2 is left out: 0.06 at most is allowed.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import mitsuba
import numpy as np
from mitsuba_textures import alpha, texture

BODY = (1, 3)
"""Parts ji and ha, as the channel `part` numbers them."""
MOST_E2 = 0.06


def planes(path: str) -> dict[str, np.ndarray]:
    bitmap = mitsuba.Bitmap(path)
    struct, values = bitmap.struct_(), np.array(bitmap)
    return {struct[index].name: values[..., index] for index in range(len(struct))}


def conductor(maps: dict[str, np.ndarray], lobe: str, wanted: dict[str, Any]) -> dict[str, Any]:
    body = np.isin(maps["part"], BODY)
    if np.abs(maps[f"{lobe}.e2"][body]).max() > MOST_E2:
        raise SystemExit(f"{wanted['maps']}: {lobe}.e2 is above {MOST_E2} in the ji or the ha")
    ln_mu, e1 = maps[f"{lobe}.ln_mu_deg"], maps[f"{lobe}.e1"]
    return {
        "type": "roughconductor",
        "distribution": "beckmann",
        # e1 is the log of the axes' ratio: along the length times exp(e1), across it over it.
        "alpha_u": texture(alpha(ln_mu + e1)),
        "alpha_v": texture(alpha(ln_mu - e1)),
        "eta": {"type": "rgb", "value": [wanted["eta"]] * 3},
        "k": {"type": "rgb", "value": [wanted["k"]] * 3},
    }


def sensor(camera: dict[str, Any], samples: int) -> dict[str, Any]:
    right, down = np.array(camera["right"]), np.array(camera["down"])
    forward = np.cross(right, down)
    half = 0.5 * camera["width_px"] / camera["scale_px_per_mm"]
    place = np.eye(4)
    # Mitsuba's camera looks along z with y up, so x runs to the left.
    place[:3, 0], place[:3, 1], place[:3, 2] = -right * half, -down * half, forward
    place[:3, 3] = np.array(camera["position_mm"]) - 600 * forward
    return {
        "type": "orthographic",
        "to_world": mitsuba.ScalarTransform4f(place),
        "near_clip": 1.0,
        "far_clip": 2000.0,
        "film": {
            "type": "hdrfilm",
            "width": camera["width_px"],
            "height": camera["height_px"],
            "rfilter": {"type": "box"},
            "pixel_format": "luminance",
            "component_format": "float32",
        },
        "sampler": {"type": "independent", "sample_count": samples},
    }


def source(picture: dict[str, Any], target: np.ndarray) -> dict[str, Any]:
    centre, u, v = (np.array(picture[name]) for name in ("centre_mm", "half_u_mm", "half_v_mm"))
    normal = np.cross(u, v)
    if normal @ (target - centre) < 0:
        v, normal = -v, -normal
    place = np.eye(4)
    place[:3, 0], place[:3, 1], place[:3, 2] = u, v, normal / np.linalg.norm(normal)
    place[:3, 3] = centre
    return {
        "type": "rectangle",
        "to_world": mitsuba.ScalarTransform4f(place),
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": [1.0] * 3}},
    }


def main() -> int:
    wanted = json.load(sys.stdin)
    mitsuba.set_variant("scalar_rgb")
    maps = planes(wanted["maps"])
    blade = {
        "type": "obj",
        "filename": wanted["mesh"],
        "bsdf": {
            "type": "blendbsdf",
            "weight": texture(maps["w"]),
            "ji": conductor(maps, "ji", wanted),
            "ha": conductor(maps, "ha", wanted),
        },
    }
    for index, picture in enumerate(wanted["pictures"]):
        scene = mitsuba.load_dict(
            {
                "type": "scene",
                "integrator": {"type": "direct", "hide_emitters": True},
                "sensor": sensor(wanted["camera"], wanted["samples"]),
                "blade": blade,
                "source": source(picture, np.array(wanted["camera"]["position_mm"])),
            }
        )
        rendered = np.array(mitsuba.render(scene, seed=wanted["seed"] + index))
        np.save(picture["file"], rendered.reshape(rendered.shape[:2]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
