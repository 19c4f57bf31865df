"""The demo's page: pictures with captions, figures as tables. One HTML file beside its pictures, no network."""

import html
from dataclasses import dataclass, field
from pathlib import Path

STYLE = """
:root { color-scheme: dark; --ink: #e9e5dc; --soft: #a39d90; --ground: #121110; --line: #2b2926; --accent: #c9b28a; }
* { box-sizing: border-box; }
body { margin: 0; background: var(--ground); color: var(--ink); font: 16px/1.55 "Iowan Old Style", Georgia, serif; }
main { max-width: 1180px; margin: 0 auto; padding: 3rem 1.5rem 5rem; }
h1 { font-weight: 400; font-size: 2.4rem; margin: 0; letter-spacing: .02em; }
h2 { font-weight: 400; font-size: 1.45rem; margin: 3.2rem 0 .4rem; color: var(--accent); }
p { max-width: 46rem; color: var(--soft); margin: .3rem 0 1rem; }
figure { margin: 0; }
figure img, figure video { width: 100%; display: block; background: #000; border: 1px solid var(--line); }
figcaption { font-size: .88rem; color: var(--soft); padding: .4rem 0 .8rem; }
.row { display: grid; gap: 1rem; grid-template-columns: repeat(auto-fit, minmax(300px, 1fr)); }
table { border-collapse: collapse; font-size: .92rem; margin: .6rem 0 1.4rem; }
th, td { text-align: left; padding: .35rem 1.4rem .35rem 0; border-bottom: 1px solid var(--line); vertical-align: top; }
th { font-weight: 400; color: var(--accent); }
td.n { font-variant-numeric: tabular-nums; }
code { font-size: .85em; color: var(--ink); }
a { color: var(--accent); }
"""


@dataclass(frozen=True)
class Picture:
    """A file beside the page, and what a reader should see in it."""

    file: str
    caption: str


@dataclass
class Section:
    """A heading, what it shows, its pictures in rows, and a table (first row: headings)."""

    title: str
    text: str
    rows: list[list[Picture]] = field(default_factory=list)
    table: list[list[str]] = field(default_factory=list)


def _figure(picture: Picture) -> str:
    source, caption = html.escape(picture.file, quote=True), html.escape(picture.caption)
    media = (
        f'<video src="{source}" controls loop muted playsinline></video>'
        if picture.file.endswith(".mp4")
        else f'<a href="{source}"><img src="{source}" alt="{caption}"></a>'
    )
    return f"<figure>{media}<figcaption>{caption}</figcaption></figure>"


def _table(rows: list[list[str]]) -> str:
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in rows[0])
    body = "".join(
        "<tr>" + "".join(f'<td class="n">{html.escape(cell)}</td>' for cell in row) + "</tr>"
        for row in rows[1:]
    )
    return f"<table><tr>{head}</tr>{body}</table>"


def write_page(path: Path, title: str, introduction: str, sections: list[Section]) -> None:
    """Writes the page whole or not at all; every file that it names must stand beside it."""
    missing = [
        picture.file
        for section in sections
        for row in section.rows
        for picture in row
        if not (path.parent / picture.file).is_file()
    ]
    if missing:
        raise FileNotFoundError(f"{path}: the page names files that were not made: {missing}")
    body = []
    for section in sections:
        body.append(f"<h2>{html.escape(section.title)}</h2><p>{html.escape(section.text)}</p>")
        body += [f'<div class="row">{"".join(map(_figure, row))}</div>' for row in section.rows]
        if section.table:
            body.append(_table(section.table))
    text = (
        '<!doctype html><html lang="en"><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{html.escape(title)}</title><style>{STYLE}</style>"
        f"<main><h1>{html.escape(title)}</h1><p>{html.escape(introduction)}</p>{''.join(body)}</main></html>"
    )
    temporary = path.with_suffix(".part.html")
    temporary.write_text(text, encoding="utf-8")
    temporary.replace(path)
