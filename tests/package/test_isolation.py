"""The native module beside other image libraries: Blender's own OpenImageIO, OpenEXR and TBB, and PyPI's openimageio,
which other add-ons bring along. All in one process, in both orders of loading; each reads what the others write."""

from __future__ import annotations

import pytest
from clean_blender import CleanBlender
from compile_module import ALLOWED_LIBRARIES
from elf import needs


@pytest.mark.parametrize("order", ["blender-first", "openimageio-first"])
def test_each_reads_the_others_files(blender: CleanBlender, package, order):
    folder = blender.row.openimageio
    assert folder.is_dir(), f"{folder} is missing: run tools/setup_openimageio.sh"
    answer = blender.run("exchange", package, order, path=(folder,))
    assert answer["said"] == answer["problem"] == "", answer.output
    assert answer["module"].startswith(str(blender.site_packages))
    assert answer["openimageio"].startswith(str(folder))
    assert answer["polygons"] > 100
    assert answer["theirs"], "Blender and PyPI's openimageio read one file differently"
    assert answer["uses"].startswith(str(folder)), "the add-on took another OpenImageIO"
    assert answer["named"], "the add-on's named channels are not what openimageio reads"
    assert answer["pair"], "the pair that Blender wrote is not what openimageio reads"
    assert answer["named_back"]
    assert answer["pair_back"]
    assert answer["pattern"]
    assert "none.toml" in answer["refused"]
    assert answer.code == 0, answer.output


def test_the_module_needs_no_image_library(blender: CleanBlender):
    """Nothing that could be loaded in another version than Blender's own: no OpenImageIO, no OpenEXR, no TBB."""
    assert blender.row.module is not None
    found = needs(blender.row.module).libraries
    # The C++ libraries come with g++; the package made with zig has them inside.
    assert found <= ALLOWED_LIBRARIES | {"libstdc++.so.6", "libgcc_s.so.1"}
