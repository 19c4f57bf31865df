"""Evaluates one function of shaders/shared on the GPU, on rows of numbers.

The arguments travel as texels of a float texture, a full-screen triangle computes one row a pixel, and the result is
read back from a float framebuffer. Argument and result types come from the GLSL text itself, so that a
function added there needs no code here.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

WIDTHS = {"float": 1, "vec2": 2, "vec3": 3, "vec4": 4}
ROW_PIXELS = 256
"""Pixels in one row of the framebuffer: the rows of numbers are laid out in lines of this length."""


@dataclass(frozen=True)
class Function:
    name: str
    result: str
    arguments: tuple[tuple[str, str], ...]  # (type, name)


@dataclass
class SharedText:
    """shaders/shared/model.glsl with its includes, and what it declares."""

    text: str
    structs: dict[str, tuple[tuple[str, str], ...]] = field(init=False)  # name -> (type, name)
    functions: dict[str, Function] = field(init=False)

    def __post_init__(self) -> None:
        code = re.sub(r"//[^\n]*", "", self.text)
        self.structs = {
            name: tuple(re.findall(r"(\w+)\s+(\w+)\s*;", body))
            for name, body in re.findall(r"\bstruct\s+(\w+)\s*\{([^}]*)\}", code)
        }
        self.functions = {
            name: Function(name, result, tuple(re.findall(r"(\w+)\s+(\w+)\s*(?:,|$)", arguments)))
            for result, name, arguments in re.findall(
                r"\bTG_FN\s+(\w+)\s+(\w+)\s*\(([^)]*)\)", code
            )
        }

    def leaves(self, type_name: str, name: str) -> list[tuple[str, int]]:
        """Scalars and vectors that a value is made of: (expression, width), in order of declaration."""
        if type_name in WIDTHS:
            return [(name, WIDTHS[type_name])]
        return [
            leaf
            for member_type, member in self.structs[type_name]
            for leaf in self.leaves(member_type, f"{name}.{member}")
        ]

    def input_leaves(self, function: Function) -> list[tuple[str, int]]:
        return [leaf for kind, name in function.arguments for leaf in self.leaves(kind, name)]

    def output_leaves(self, function: Function) -> list[tuple[str, int]]:
        return self.leaves(function.result, "result")


def scalars(leaves: list[tuple[str, int]]) -> list[str]:
    """One expression per number: result.facet.dx, normal.y ..."""
    return [
        expression if width == 1 else f"{expression}.{'xyzw'[i]}"
        for expression, width in leaves
        for i in range(width)
    ]


def texels(count: int) -> int:
    return (count + 3) // 4


def fragment_source(shared: SharedText, function: Function) -> str:
    """Reads the arguments, calls the function, writes four numbers of its result from `first_output` on."""
    lines = ["void main() {", "  ivec2 pixel = ivec2(gl_FragCoord.xy);"]
    inputs = scalars(shared.input_leaves(function))
    for i in range(texels(len(inputs))):
        lines.append(
            f"  vec4 in_{i} = texelFetch(rows, ivec2(pixel.x * {texels(len(inputs))} + {i}, pixel.y), 0);"
        )
    for kind, name in function.arguments:
        lines.append(f"  {kind} {name};")
    for i, expression in enumerate(inputs):
        lines.append(f"  {expression} = in_{i // 4}[{i % 4}];")
    call = ", ".join(name for _, name in function.arguments)
    lines.append(f"  {function.result} result = {function.name}({call});")
    outputs = scalars(shared.output_leaves(function))
    padded = outputs + ["0.0"] * (-len(outputs) % 4)
    lines.append(f"  float all_outputs[{len(padded)}] = float[{len(padded)}]({', '.join(padded)});")
    lines.append(
        "  row = vec4(all_outputs[first_output], all_outputs[first_output + 1], "
        "all_outputs[first_output + 2], all_outputs[first_output + 3]);"
    )
    return "\n".join([*lines, "}"])


class GpuFormulas:
    """Needs a GPU context (see conftest.py)."""

    def __init__(self, shared: SharedText) -> None:
        self.shared = shared
        self._shaders: dict[str, object] = {}

    @cached_property
    def _triangle(self) -> object:
        from gpu.types import GPUVertBuf, GPUVertFormat

        layout = GPUVertFormat()
        layout.attr_add(id="corner", comp_type="F32", len=2, fetch_mode="FLOAT")
        corners = GPUVertBuf(layout, 3)
        corners.attr_fill("corner", [(-1.0, -1.0), (3.0, -1.0), (-1.0, 3.0)])
        return corners

    def _shader(self, name: str) -> object:
        import gpu

        if name not in self._shaders:
            info = gpu.types.GPUShaderCreateInfo()
            info.sampler(0, "FLOAT_2D", "rows")
            info.push_constant("INT", "first_output")
            info.vertex_in(0, "VEC2", "corner")
            info.fragment_out(0, "VEC4", "row")
            info.vertex_source("void main() { gl_Position = vec4(corner, 0.0, 1.0); }")
            info.fragment_source(
                f"#define TG_FN\n#define TG_PRECISE precise\n{self.shared.text}\n"
                f"{fragment_source(self.shared, self.shared.functions[name])}"
            )
            self._shaders[name] = gpu.shader.create_from_info(info)
        return self._shaders[name]

    def __call__(self, name: str, inputs: np.ndarray) -> np.ndarray:
        """inputs (N, K) -> (N, M), both flattened as togishi_core.formulas has them."""
        import gpu
        from gpu.types import GPUBatch

        function = self.shared.functions[name]
        input_count = len(scalars(self.shared.input_leaves(function)))
        output_count = len(scalars(self.shared.output_leaves(function)))
        count = inputs.shape[0]
        height = -(-count // ROW_PIXELS)
        width = texels(input_count)
        packed = np.zeros((height * ROW_PIXELS, width * 4), np.float32)
        packed[:count, :input_count] = inputs
        # A NaN is a value like any other here; unused pixels repeat the first row.
        packed[count:, :input_count] = inputs[0]
        rows = gpu.types.GPUTexture(
            (ROW_PIXELS * width, height),
            format="RGBA32F",
            data=gpu.types.Buffer("FLOAT", packed.size, packed.ravel()),
        )
        shader = self._shader(name)
        batch = GPUBatch(type="TRIS", buf=self._triangle)
        offscreen = gpu.types.GPUOffScreen(ROW_PIXELS, height, format="RGBA32F")
        outputs = np.empty((height * ROW_PIXELS, texels(output_count) * 4), np.float32)
        try:
            for first in range(0, output_count, 4):
                with offscreen.bind():
                    gpu.state.blend_set("NONE")
                    gpu.state.depth_test_set("NONE")
                    shader.bind()
                    shader.uniform_sampler("rows", rows)
                    shader.uniform_int("first_output", first)
                    batch.draw(shader)
                buffer = offscreen.texture_color.read()
                buffer.dimensions = height * ROW_PIXELS * 4
                outputs[:, first : first + 4] = np.asarray(buffer).reshape(-1, 4)
        finally:
            offscreen.free()
        return outputs[:count, :output_count]
