"""Install, use the module, install another package of the same version over it. reinstall.py REPORT ZIP ZIP"""

from __future__ import annotations

from extension import ARGUMENTS, add_katana, install, problem, report, say_state

report(
    first=install(ARGUMENTS[0]), first_problem=problem(), polygons=len(add_katana().data.polygons)
)
report(second=install(ARGUMENTS[1]))
say_state()
