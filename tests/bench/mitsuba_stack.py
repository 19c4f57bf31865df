"""A plate under many lights by Mitsuba 3, as a stranger would photograph it: tests/bench/capture_lights.py captures it.

Runs in .venv-mitsuba, with nothing of Togishi. Reads from standard input

    {"file": "plate.npz", "width": 80, "height": 60, "tilt_deg": 12, "turn_deg": 30, "mu_deg": [2, 6], "eta": 2.9,
     "k": 3.1, "lights": [[x, y, z], ...]}

and writes `pictures` (light, row, column): radiance under an irradiance of 1, without noise; and the truth of each
pixel: `mu_t_deg`, `mu_b_deg`, `rho_deg` against the picture's x axis laid onto the plate, `normal` (3,). The plate is
turned in its plane and tilted about the picture's y axis; an orthographic camera looks along -z. Source: the plugin
`roughconductor` with Beckmann's distribution and textured alpha_u and alpha_v; mu is where D = exp(-(tan/alpha)^2)/cos^4
falls to its half.

{"maps": "maps.exr", "file": "maps.npz"} instead writes the planes of an OpenEXR file.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import mitsuba
import numpy as np
from mitsuba_textures import alpha, texture

TEXELS = 256
SAMPLES = 16
FAR = 5.0


def alphas(low_deg: float, high_deg: float) -> tuple[np.ndarray, np.ndarray]:
    """Along u and v: smooth waves within the range, the narrow one at most two thirds of the wide one."""
    u, v = np.meshgrid(np.linspace(0, 1, TEXELS), np.linspace(0, 1, TEXELS))
    wide = 0.5 + 0.5 * np.sin(2 * np.pi * (0.5 * u + 0.2 * v))
    narrow = 0.5 + 0.5 * np.cos(2 * np.pi * (0.2 * u - 0.5 * v))
    apart = np.log(1.5)
    low, high = np.log(low_deg), np.log(high_deg)
    ln_t = low + apart + (high - low - apart) * wide
    ln_b = low + (ln_t - apart - low) * narrow
    return alpha(ln_t), alpha(ln_b)


def half_width_deg(alpha: float) -> float:
    """Of Beckmann's D along one axis: tan^2 = alpha^2 (ln 2 - 4 ln cos)."""
    angle = 0.0
    for _ in range(20):
        angle = np.arctan(alpha * np.sqrt(np.log(2.0) - 4 * np.log(np.cos(angle))))
    return float(np.degrees(angle))


def scene(wanted: dict[str, Any], light: list[float]) -> Any:
    turn = mitsuba.ScalarTransform4f
    high = 1.0
    wide = wanted["width"] / wanted["height"]
    alpha_u, alpha_v = alphas(*wanted["mu_deg"])
    film = {
        "type": "hdrfilm",
        "width": wanted["width"],
        "height": wanted["height"],
        "rfilter": {"type": "box"},
        "component_format": "float32",
    }
    return mitsuba.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "direct", "emitter_samples": 1, "bsdf_samples": 0},
            "sensor": {
                "type": "orthographic",
                # Half of the picture's width is 1 in the camera's units.
                "to_world": turn().look_at(origin=[0, 0, FAR], target=[0, 0, 0], up=[0, 1, 0])
                @ turn().scale([wide * high, wide * high, 1]),
                "film": film,
                "sampler": {"type": "stratified", "sample_count": SAMPLES},
            },
            "light": {
                "type": "directional",
                "direction": [-value for value in light],
                "irradiance": {"type": "rgb", "value": [1.0] * 3},
            },
            "plate": {
                "type": "rectangle",
                "to_world": turn().rotate([0, 1, 0], wanted["tilt_deg"])
                @ turn().rotate([0, 0, 1], wanted["turn_deg"])
                @ turn().scale(1.5 * wide * high),
                "bsdf": {
                    "type": "roughconductor",
                    "distribution": "beckmann",
                    "alpha_u": texture(alpha_u),
                    "alpha_v": texture(alpha_v),
                    "eta": {"type": "rgb", "value": [wanted["eta"]] * 3},
                    "k": {"type": "rgb", "value": [wanted["k"]] * 3},
                },
            },
        }
    )


def truth(wanted: dict[str, Any]) -> dict[str, np.ndarray]:
    """What Mitsuba itself finds under each pixel's middle."""
    found = scene(wanted, wanted["lights"][0])
    textures = [mitsuba.load_dict(texture(values)) for values in alphas(*wanted["mu_deg"])]
    width, height = wanted["width"], wanted["height"]
    out = {name: np.empty((height, width)) for name in ("mu_t_deg", "mu_b_deg", "rho_deg")}
    for row in range(height):
        for column in range(width):
            x = (2 * (column + 0.5) / width - 1) * width / height
            y = 1 - 2 * (row + 0.5) / height
            point = found.ray_intersect(mitsuba.Ray3f([x, y, FAR], [0, 0, -1]))
            for name, plane in zip(("mu_t_deg", "mu_b_deg"), textures, strict=True):
                out[name][row, column] = half_width_deg(float(plane.eval_1(point)))
            normal = np.array(point.n, float).ravel()
            along = np.array(point.dp_du, float).ravel()
            tangent = np.array([1.0, 0, 0]) - normal[0] * normal
            tangent /= np.linalg.norm(tangent)
            azimuth = np.arctan2(along @ np.cross(normal, tangent), along @ tangent)
            out["rho_deg"][row, column] = np.degrees(azimuth) % 180
    return {**out, "normal": normal}


def main() -> int:
    wanted = json.load(sys.stdin)
    mitsuba.set_variant("scalar_rgb")
    if "maps" in wanted:
        bitmap = mitsuba.Bitmap(wanted["maps"])
        names, values = bitmap.struct_(), np.array(bitmap)
        np.savez(wanted["file"], **{names[i].name: values[..., i] for i in range(len(names))})
        return 0
    pictures = [
        np.array(mitsuba.render(scene(wanted, light)))[..., 0] for light in wanted["lights"]
    ]
    np.savez(wanted["file"], pictures=np.stack(pictures), **truth(wanted))
    return 0


if __name__ == "__main__":
    sys.exit(main())
