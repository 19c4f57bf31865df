"""The stub file and the module agree: the public interface never changes by accident."""

import ast
import re
from pathlib import Path

import togishi_core

STUB = Path(__file__).parents[2] / "cpp_core" / "python" / "togishi_core.pyi"


def stub_interface() -> tuple[dict[str, list[str]], set[str]]:
    """Functions with their parameter names, and all other public names, as the stub has them."""
    functions: dict[str, list[str]] = {}
    others: set[str] = set()
    for node in ast.parse(STUB.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef):
            functions[node.name] = [a.arg for a in node.args.args + node.args.kwonlyargs]
        elif isinstance(node, ast.ClassDef):
            others.add(node.name)
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            others.add(node.target.id)
    return functions, others


def bound_parameters(name: str) -> list[str]:
    """Parameter names of a bound function, from the signature that pybind11 writes into its docstring."""
    signature = getattr(togishi_core, name).__doc__.splitlines()[0]
    inside = signature[signature.index("(") + 1 : signature.rindex(") ->")]
    return re.findall(r"(?:^|, )\*?(\w+): ", inside)


def test_every_stub_function_is_bound_with_the_same_parameters() -> None:
    functions, _ = stub_interface()
    assert len(functions) > 15
    differences = {
        name: (parameters, bound_parameters(name) if hasattr(togishi_core, name) else "missing")
        for name, parameters in functions.items()
        if not hasattr(togishi_core, name) or bound_parameters(name) != parameters
    }
    assert not differences


def test_nothing_is_bound_that_the_stub_does_not_document() -> None:
    functions, others = stub_interface()
    public = {name for name in dir(togishi_core) if not name.startswith("_")}
    assert public - set(functions) - others == set()
    assert others - public - {"F32", "F64", "__version__"} == set()


def test_every_bound_function_says_what_it_does() -> None:
    functions, _ = stub_interface()
    undocumented = [n for n in functions if len(getattr(togishi_core, n).__doc__.splitlines()) < 3]
    assert not undocumented
