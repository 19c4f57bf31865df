"""The documentation says what is so: links and pictures resolve, commands and options exist, every sentence that the
troubleshooting page quotes stands in the program and every sentence of the program stands on a page, every panel and
operator has its place, figures and defaults are the program's."""

from __future__ import annotations

import ast
import math
import re
import shlex
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import togishi_core

ROOT = Path(__file__).parents[2]
ADDON = ROOT / "addon" / "togishi"
CORE = ROOT / "cpp_core"
GUIDE = ROOT / "docs" / "guide"
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")])


def page_name(path: Path) -> str:
    return str(path.relative_to(ROOT))


def text_of(path: Path) -> str:
    return path.read_text(encoding="utf-8")


def code_of(text: str) -> list[str]:
    """Code spans, and the lines of indented or fenced blocks, of a page."""
    lines, prose, fenced = [], [], False
    for line in text.splitlines():
        if line.lstrip().startswith("```"):
            fenced = not fenced
        elif fenced or re.match(r" {4,}\S", line):
            lines.append(line.strip())
        else:
            prose.append(line)
    spans = re.findall(r"(?<!`)(`+)(?!`)(.+?)(?<!`)\1(?!`)", "\n".join(prose), re.S)
    return lines + [re.sub(r"\s+", " ", span).strip() for _, span in spans]


def tables_of(text: str, *header: str) -> Iterator[list[str]]:
    """The rows, as lists of cells, of the tables whose header begins with these cells."""
    inside = False
    for line in text.splitlines():
        if not line.startswith("|"):
            inside = False
            continue
        cells = [
            cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", line.strip("| \n"))
        ]
        if tuple(cells[: len(header)]) == header:
            inside = True
        elif inside and not set(cells[0]) <= set("-: "):
            yield cells


# --- links and pictures ---------------------------------------------------------------------------


def slug(heading: str) -> str:
    """A heading's anchor, as GitHub makes it."""
    plain = re.sub(r"[`*]|\[([^\]]*)\]\([^)]*\)", r"\1", heading).strip().lower()
    return re.sub(r"[^\w\- ]", "", plain).replace(" ", "-")


def anchors(path: Path) -> set[str]:
    return {slug(h) for h in re.findall(r"^#+ (.+)$", text_of(path), re.M)}


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_links_and_pictures_resolve(page: Path) -> None:
    broken = []
    for target in re.findall(r"\]\(([^)\s]+)\)", text_of(page)):
        if re.match(r"https?:", target):
            continue
        name, _, anchor = target.partition("#")
        file = (page.parent / name) if name else page
        if not file.exists() or (anchor and anchor not in anchors(file)):
            broken.append(target)
    assert not broken


def test_every_page_and_picture_is_reached() -> None:
    reached = {
        (page.parent / target.partition("#")[0]).resolve()
        for page in PAGES
        for target in re.findall(r"\]\(([^)\s]+)\)", text_of(page))
    }
    files = {*ROOT.glob("docs/**/*.md"), *(GUIDE / "pictures").glob("*.*")}
    assert not {page_name(f) for f in files if f.resolve() not in reached}
    assert sum(f.stat().st_size for f in (GUIDE / "pictures").glob("*.*")) < 2_000_000


# --- commands -------------------------------------------------------------------------------------


def test_make_targets_exist() -> None:
    targets = set(re.findall(r"^([a-z0-9.-]+):", text_of(ROOT / "Makefile"), re.M))
    named = {
        (page_name(page), target)
        for page in PAGES
        for code in code_of(text_of(page))
        for target in re.findall(r"(?:^|&& )make ([a-z0-9.-]+)", code)
    }
    assert len(named) > 5
    assert not {(page, target) for page, target in named if target not in targets}


def options_in(help_text: str) -> set[str]:
    return set(re.findall(r"(?<![\w-])--?[a-zA-Z][\w-]*", help_text))


@pytest.fixture(scope="module")
def options(togishi: Callable[..., object]) -> dict[str, set[str]]:
    """Options of each subcommand of `togishi`; "" for those of the command itself; "render" for the headless render."""
    from togishi.core import headless

    top = togishi("--help").stdout
    known = {"": options_in(top)}
    for name in re.findall(r"^  (\w[\w-]*)  ", top.split("Subcommands:")[1], re.M):
        text = togishi(name, "--help").stdout
        known[name] = options_in(text) | known[""]
        if "Subcommands:" in text:
            for sub in re.findall(r"^  (\w[\w-]*)  ", text.split("Subcommands:")[1], re.M):
                inner = options_in(togishi(name, sub, "--help").stdout)
                known[f"{name} {sub}"] = inner | known[name]
    actions = headless.parser()._subparsers._group_actions[0].choices["render"]
    known["render"] = {option for action in actions._actions for option in action.option_strings}
    assert {"katana", "bake", "spectrum", "info", "render"} <= set(known)
    return known


def test_command_lines_exist(options: dict[str, set[str]]) -> None:
    """Each line that runs togishi names a subcommand and options that there are."""
    wrong, seen = [], 0
    for page in PAGES:
        for code in code_of(text_of(page)):
            found = re.match(
                r"(?:.*?(?:--command|-m) )?(?:\S*/)?togishi (?!\S*:)(\S.*)", code.split(" #")[0]
            )
            if found is None or "…" in code or re.match(r"(cmake|import)\b", code):
                continue
            words = shlex.split(found[1])
            names = [word for word in words if not word.startswith("-")]
            seen += 1
            if not names and set(words) <= options[""]:
                continue
            if not names or names[0].split("|")[0] not in options:
                wrong.append(f"{page_name(page)}: {code}")
                continue
            used = {word for word in words if re.match(r"--?[a-zA-Z]", word)}
            nested = " ".join(names[:2])
            known = options[nested if nested in options else names[0]]
            if not used <= known:
                wrong.append(f"{page_name(page)}: {code}: {used - known}")
    assert seen > 10
    assert not wrong


def test_every_subcommand_is_in_the_guide(options: dict[str, set[str]]) -> None:
    rows = {row[0].strip("`") for row in tables_of(text_of(GUIDE / "headless.md"), "subcommand")}
    assert rows == {name for name in options if " " not in name} - {"", "render"}


def test_options_that_pages_name_exist(options: dict[str, set[str]]) -> None:
    """A span that is nothing but an option: of the commands, or of a program of somebody else on the page on building."""
    known = set().union(*options.values())
    named = {
        (page_name(page), code)
        for page in (*GUIDE.glob("*.md"), ROOT / "README.md", ROOT / "docs" / "measurement.md")
        if page.exists()
        for code in code_of(text_of(page))
        if re.fullmatch(r"--?[a-zA-Z][\w-]*", code)
    }
    assert len(named) > 20
    assert not {(page, option) for page, option in named if option not in known}


# --- sentences ------------------------------------------------------------------------------------

VARIABLE = "\0"
SENTENCE_CALLS = {
    "report", "poll_message_set", "error_set", "UsageError", "MapError", "ShaderError", "ShaderSourceError",
    "FileNotFoundError", "OSError", "RuntimeError", "ValueError", "InputError",
}  # fmt: skip
# What these say is a result, not that something is wrong.
RESULT_TEXTS = {"fit_table.py"}


def python_text(node: ast.AST) -> str | None:
    """A string expression with VARIABLE for what is put in."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(
            str(part.value) if isinstance(part, ast.Constant) else VARIABLE for part in node.values
        )
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        left, right = python_text(node.left), python_text(node.right)
        return None if left is None and right is None else (left or VARIABLE) + (right or VARIABLE)
    return None


def python_texts() -> tuple[set[str], set[str]]:
    """All strings of the add-on; and those that a user reads when something is wrong."""
    every, sentences = set(), set()
    for file in ADDON.rglob("*.py"):
        for node in ast.walk(ast.parse(text_of(file))):
            if file.name in RESULT_TEXTS:
                break
            text = python_text(node) if isinstance(node, ast.Constant | ast.JoinedStr) else None
            if text is not None:
                every.add(text)
                parts = text.split(VARIABLE)
                if len(parts) > 1 and any(
                    len(re.findall(r"[^\W\d]+", part)) >= 3 for part in parts
                ):
                    sentences.add(text)
            # Why an operator cannot run: (condition, sentence) for operators/poll.py, and the sentences with a name there.
            if isinstance(node, ast.Tuple) and len(node.elts) == 2:
                text = python_text(node.elts[1])
                if text and not isinstance(node.elts[0], ast.Constant) and text.count(" ") >= 2:
                    sentences.add(text)
            if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]).startswith("NEEDS_"):
                sentences.add(python_text(node.value) or "")
            if isinstance(node, ast.Call):
                name = getattr(node.func, "id", getattr(node.func, "attr", ""))
                if name in SENTENCE_CALLS:
                    sentences |= {t for t in map(python_text, node.args) if t}
    return every, sentences


def longest_piece(text: str) -> str:
    return max((piece.strip() for piece in re.split(rf"{VARIABLE}|\n", text)), key=len)


LITERAL = r'"(?:[^"\\\n]|\\.)*"'


def cpp_literals(text: str) -> list[str]:
    """String literals of C++, those that stand side by side joined."""
    runs = re.findall(rf"{LITERAL}(?:\s*{LITERAL})*", text)
    joined = ("".join(literal[1:-1] for literal in re.findall(LITERAL, run)) for run in runs)
    return [text.replace('\\"', '"').replace("\\n", "\n") for text in joined]


def without_comments(text: str) -> str:
    return re.sub(r"^\s*(//|#include).*$", "", text, flags=re.M)


def refusals(text: str) -> Iterator[list[str]]:
    """The arguments of each call that refuses input."""
    for found in re.finditer(r"\b(?:InputError|fail|require|(?:reader|parts?)\.\w+)\s*\(", text):
        depth, end, arguments = 1, found.end(), [""]
        while depth and end < len(text):
            token = re.compile(rf"{LITERAL}|.", re.S).match(text, end)
            assert token is not None
            depth += {"(": 1, "{": 1, ")": -1, "}": -1}.get(token[0], 0)
            if token[0] == "," and depth == 1:
                arguments.append("")
            elif depth:
                arguments[-1] += token[0]
            end = token.end()
        yield arguments


def cpp_sources() -> list[Path]:
    return sorted([*CORE.rglob("*.cpp"), *CORE.rglob("*.hpp")])


def quoted_pieces(cell: str) -> list[str]:
    """What stands in code in a cell, in the pieces between what differs."""
    spans = re.findall(r"(?<!`)(`+)(?!`)(.+?)(?<!`)\1(?!`)", cell)
    pieces = [piece.strip() for _, span in spans for piece in span.split("…")]
    return [piece for piece in pieces if re.search(r"\w", piece)]


def test_quoted_sentences_are_the_addons() -> None:
    every, _ = python_texts()
    rows = list(tables_of(text_of(GUIDE / "troubleshooting.md"), "sentence"))
    assert len(rows) > 50
    wrong = []
    for row in rows:
        pieces = quoted_pieces(row[0])
        assert pieces, row
        if not any(all(piece in text for piece in pieces) for text in every):
            wrong.append(row[0])
    assert not wrong


def test_quoted_refusals_are_the_cores() -> None:
    literals = {
        literal
        for file in cpp_sources()
        for literal in cpp_literals(without_comments(text_of(file)))
    }
    page = text_of(GUIDE / "troubleshooting.md")
    rows = [(row, 3) for row in tables_of(page, "field", "is", "allowed")]
    rows += [(row, 2) for row in tables_of(page, "field", "allowed")]
    assert len(rows) > 80
    wrong = [
        piece
        for row, columns in rows
        for cell in row[:columns]
        for piece in quoted_pieces(cell)
        if not any(piece in literal for literal in literals)
    ]
    assert not wrong


def all_guide_text() -> str:
    return re.sub(r"\s+", " ", "\n".join(text_of(page) for page in PAGES)).replace("\\|", "|")


def test_every_sentence_of_the_addon_is_explained() -> None:
    """A new sentence belongs on docs/guide/troubleshooting.md, with its cause and its remedy."""
    guide = all_guide_text()
    _, sentences = python_texts()
    assert len(sentences) > 60
    missing = {
        text.replace(VARIABLE, "…")
        for text in sentences
        if len(longest_piece(text)) > 11 and longest_piece(text) not in guide
    }
    assert not missing


def test_every_refusal_of_the_core_is_explained() -> None:
    """The same for the core: what an InputError allows. Left out are those that only a caller of the module meets."""
    guide = all_guide_text()
    missing, seen = set(), 0
    for file in cpp_sources():
        if {"python", "reference"} & set(
            file.relative_to(CORE).parts
        ) or file.name == "steel_outline.cpp":
            continue
        for argument in (a for call in refusals(without_comments(text_of(file))) for a in call[1:]):
            literal = max(
                (text.strip(' "(),:;.') for text in cpp_literals(argument)), key=len, default=""
            )
            if literal.count(" ") >= 2 and len(literal) > 11:
                seen += 1
                if literal not in guide:
                    missing.add(f"{file.name}: {literal}")
    assert seen > 60
    assert not missing


# --- panels and operators -------------------------------------------------------------------------


def classes_of_addon() -> Iterator[tuple[str, dict[str, str]]]:
    """(base classes, text attributes) of each class of the add-on."""
    for file in ADDON.rglob("*.py"):
        for node in ast.walk(ast.parse(text_of(file))):
            if isinstance(node, ast.ClassDef):
                values = {
                    target.id: str(
                        item.value.value
                        if isinstance(item.value, ast.Constant)
                        else ast.unparse(item.value)
                    )
                    for item in node.body
                    if isinstance(item, ast.Assign)
                    for target in item.targets
                    if isinstance(target, ast.Name)
                }
                yield " ".join(ast.unparse(base) for base in node.bases), values


def test_every_panel_has_its_place() -> None:
    labels = {
        v["bl_label"]
        for bases, v in classes_of_addon()
        if "types.Panel" in bases and "bl_label" in v
    }
    rows = {row[0] for row in tables_of(text_of(GUIDE / "panels.md"), "panel")}
    assert len(labels) > 10
    assert rows == labels


def test_every_operator_has_its_place() -> None:
    operators = {
        (v["bl_label"], v["bl_idname"])
        for bases, v in classes_of_addon()
        if "types.Operator" in bases and "INTERNAL" not in v.get("bl_options", "")
    }
    rows = {
        (row[0], row[1].strip("`"))
        for row in tables_of(text_of(GUIDE / "panels.md"), "name", "identifier")
    }
    assert len(operators) > 10
    assert rows == operators


def test_keys_are_blenders_own() -> None:
    """panels.md says that Togishi defines none."""
    assert not [file for file in ADDON.rglob("*.py") if "keymap" in text_of(file)]


# --- figures --------------------------------------------------------------------------------------


def test_roughness_table_of_the_conventions() -> None:
    rows = [
        [float(cell) for cell in row]
        for row in tables_of(text_of(ROOT / "docs" / "conventions.md"), "μ (°)")
    ]
    assert len(rows) > 4
    for mu_deg, beckmann, r_beckmann, ggx, r_ggx, weight in rows:
        tangent = math.tan(math.radians(mu_deg))
        alpha = tangent / math.sqrt(math.log(2.0))
        alpha_ggx = tangent / math.sqrt(math.sqrt(2.0) - 1.0)
        expected = (
            alpha,
            math.sqrt(alpha),
            alpha_ggx,
            math.sqrt(alpha_ggx),
            math.log(2.0) / (4.0 * math.pi * math.radians(mu_deg) ** 2),
        )
        assert (beckmann, r_beckmann, ggx, r_ggx, weight) == pytest.approx(expected, rel=5e-3)
        # What the names mean: Beckmann's and GGX' exponent fall to a half where the tilt is mu.
        assert math.exp(-(tangent**2) / alpha**2) == pytest.approx(0.5)
        assert (1.0 + tangent**2 / alpha_ggx**2) ** -2 == pytest.approx(0.5)


def test_gaussian_and_beckmann_agree_as_stated() -> None:
    """conventions.md: less than 3 % up to 2 mu for mu up to 5 degrees; more beyond."""

    def difference(mu_deg: float, tilts: int = 2) -> float:
        mu = math.radians(mu_deg)
        worst = 0.0
        for step in range(1, 41):
            phi = mu * tilts * step / 40
            gauss = math.exp(-math.log(2.0) * (phi / mu) ** 2)
            slope = math.tan(phi) / math.tan(mu)
            beckmann = math.exp(-math.log(2.0) * slope**2) / math.cos(phi) ** 4
            worst = max(worst, abs(beckmann / gauss - 1.0))
        return worst

    assert max(difference(mu) for mu in (0.1, 1.0, 3.0, 5.0)) < 0.03
    assert difference(10.0) > 0.05 and difference(5.0, 3) > 0.05


def test_parts_channels_and_lights_of_the_conventions() -> None:
    page = text_of(ROOT / "docs" / "conventions.md")
    assert ", ".join(f"{i} {name}" for i, name in enumerate(togishi_core.PART_NAMES)) in page
    assert f"`{' '.join(togishi_core.MAP_CHANNELS)}`" in page
    assert f"`{' '.join(light['name'] for light in togishi_core.lights())}`" in page


def test_tangents_turn_as_the_conventions_say() -> None:
    """B = N x T points to the edge (-z) on omote (+y) and to the mune (+z) on ura."""
    blade = togishi_core.katana(togishi_core.katana_defaults("shinogi"), 0.02)
    for corner in range(0, len(blade.corner_vertex), 7):
        normal, tangent = blade.corner_normal[corner], blade.corner_tangent[corner]
        if abs(normal[1]) > 0.9 and abs(tangent[0]) > 0.9:
            assert tangent[0] > 0.0
            across = normal[0] * tangent[1] - normal[1] * tangent[0]  # z of N x T
            assert across * normal[1] < 0.0


def test_defaults_of_the_steel_page() -> None:
    defaults, ranges = togishi_core.steel_defaults(), togishi_core.steel_ranges()
    stated: dict[str, str] = {}
    spans: dict[str, str] = {}
    for row in tables_of(text_of(ROOT / "docs" / "steel.md"), "key", "default", "range"):
        keys = re.findall(r"`(\w+)`", row[0])
        for key, value in zip(keys, row[1].split(", "), strict=True):
            stated[key], spans[key] = value, row[2]
    assert set(stated) == set(defaults)
    for key, value in stated.items():
        assert (
            value == defaults[key]
            if isinstance(defaults[key], str)
            else float(value) == defaults[key]
        )
        if key in ranges:
            low, high = (float(x) for x in spans[key].split("–"))
            assert (low, high) == tuple(ranges[key])
        elif key != "seed":
            assert tuple(spans[key].split(", ")) == tuple(togishi_core.steel_choices()[key])


def test_lobes_of_the_material_page() -> None:
    parts = togishi_core.default_material()["parts"]
    for part, _, text in tables_of(text_of(GUIDE / "materials.md"), "part"):
        key = part.replace("-", "_")
        numbers = [float(n) for n in re.findall(r"\d+(?:\.\d+)?", text)]
        wanted = [parts[key]["mu_t_deg"], parts[key]["mu_b_deg"], parts[key]["rho_deg"]]
        assert numbers == wanted[: len(numbers)] and len(numbers) >= 2, part


def test_changelog_knows_the_version() -> None:
    version = re.search(r'^version = "([^"]+)"', text_of(ROOT / "pyproject.toml"), re.M)
    assert version is not None
    changelog = text_of(ROOT / "CHANGELOG.md")
    assert re.search(rf"^## \[{re.escape(version[1])}\]", changelog, re.M)
