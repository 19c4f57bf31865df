"""The render engine "Togishi". Touches the `gpu` module only when something is drawn."""

from __future__ import annotations


def register() -> None:
    from . import render_engine

    render_engine.register()


def unregister() -> None:
    from . import render_engine

    render_engine.unregister()
