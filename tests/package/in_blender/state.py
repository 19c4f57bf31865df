"""What the extension says of itself in this process: state.py REPORT [ZIP]; with a ZIP it is installed before."""

from __future__ import annotations

import bpy
from extension import ARGUMENTS, NAME, enabled, install, report, say_state

if ARGUMENTS:
    report(said=install(ARGUMENTS[0]), enabled=enabled())
else:
    bpy.ops.preferences.addon_enable(module=NAME)
if enabled():
    say_state()
