"""`python -m togishi render …` with the bpy wheel."""

import sys


def run() -> int:
    try:
        import bpy  # noqa: F401
    except ImportError as error:
        print(f"togishi: needs Blender's Python module (pip install bpy): {error}", file=sys.stderr)
        return 2
    import togishi
    from togishi import cli

    togishi.register()
    return cli.main(sys.argv[1:])


if __name__ == "__main__":
    sys.exit(run())
