# SPDX-License-Identifier: MIT OR Apache-2.0
"""What the pages need beyond Sphinx: tables from CSV files, captions, figures, examples, formulas.

Figures of the pages come from files that scripts wrote, never from the text; formulas become MathML, which
browsers draw without a script from elsewhere.
"""

from __future__ import annotations

import ast
import csv
import re
import tomllib
from pathlib import Path
from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import directives
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.transforms import SphinxTransform
from sphinx.util.docutils import SphinxDirective
from sphinx.util.math import get_node_equation_number

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parent


class Records(SphinxDirective):
    """Some columns and rows of a CSV file as a table.

    The argument is the file, from this folder. `columns` names what is shown, parted by semicolons, each
    ``name``, ``name = heading`` or ``name:format = heading``; ``where`` keeps rows, ``name = value | value``,
    and `sort` orders them by a column of numbers.
    """

    required_arguments = 1
    option_spec: ClassVar[dict[str, Any]] = {
        "columns": directives.unchanged_required,
        "where": directives.unchanged,
        "sort": directives.unchanged,
    }

    def run(self) -> list[nodes.Node]:
        path = DOCS / self.arguments[0]
        self.env.note_dependency(str(path))
        with path.open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        if not rows:
            raise self.error(f"{path}: no rows")
        for condition in parts(self.options.get("where", "")):
            key, _, value = (piece.strip() for piece in condition.partition("="))
            if key not in rows[0]:
                raise self.error(f"{path}: no column {key!r}")
            kept = {choice.strip() for choice in value.split("|")}
            rows = [row for row in rows if row[key] in kept]
        if not rows:
            raise self.error(f"{path}: no rows where {self.options['where']}")
        if "sort" in self.options:
            rows.sort(key=lambda row: float(row[self.options["sort"]]))
        columns = [column(text) for text in parts(self.options.get("columns", ";".join(rows[0])))]
        for name, _, _ in columns:
            if name not in rows[0]:
                raise self.error(f"{path}: no column {name!r}, only {', '.join(rows[0])}")
        head = [heading for _, _, heading in columns]
        body = [[shown(row[name], style) for name, style, _ in columns] for row in rows]
        return [self.table(head, body)]

    def table(self, head: list[str], body: list[list[str]]) -> nodes.table:
        """The table; columns of numbers are set to the right."""
        table = nodes.table(classes=["records"])
        group = nodes.tgroup(cols=len(head))
        table += group
        group.extend(nodes.colspec(colwidth=1) for _ in head)
        right = [all(is_number(row[k]) for row in body) for k in range(len(head))]
        top, rest = nodes.thead(), nodes.tbody()
        group += [top, rest]
        for place, cells in [(top, head), *((rest, row) for row in body)]:
            row = nodes.row()
            place += row
            for text, is_right in zip(cells, right, strict=True):
                entry = nodes.entry(classes=["text-right"] if is_right else [])
                inline, messages = self.parse_inline(text) if place is top else ([nodes.Text(text)], [])
                entry += nodes.paragraph("", "", *inline, *messages)
                row += entry
        return table


def parts(text: str) -> list[str]:
    return [part.strip() for part in text.split(";") if part.strip()]


def column(text: str) -> tuple[str, str, str]:
    """Name, format and heading of ``name:format = heading``."""
    name, _, heading = (piece.strip() for piece in text.partition("="))
    name, _, style = name.partition(":")
    return name, style, heading or name.replace("_", " ")


def shown(text: str, style: str) -> str:
    """A cell; what is no number is shown as it is, nothing as a dash."""
    if not text or text == "nan":
        return "–"
    return format(float(text), style) if style and is_number(text) else text


def is_number(text: str) -> bool:
    try:
        float(text.rstrip("%"))
    except ValueError:
        return text in {"–", "none", "never"}
    return True


class ThesisFigures(SphinxDirective):
    """The pictures that answer the figures of a chapter of the thesis, from `thesis_figures.toml`."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        path = DOCS / "thesis_figures.toml"
        self.env.note_dependency(str(path))
        figures = tomllib.loads(path.read_text(encoding="utf-8"))
        chosen = {number: entry for number, entry in figures.items() if number.startswith(self.arguments[0])}
        if not chosen:
            raise self.error(f"{path}: no figure begins with {self.arguments[0]!r}")
        out: list[nodes.Node] = []
        for number, entry in chosen.items():
            picture = Path(entry["picture"]).relative_to("docs").as_posix()
            figure = nodes.figure("", nodes.image(uri=picture, alt=f"Fig. {number}"))
            text, messages = self.parse_inline(f"**{number}**: {entry['shows']} (`{entry['script']}`)")
            figure += nodes.caption("", "", *text)
            out += [figure, *messages]
        return out


class Captions(SphinxTransform):
    """A picture that is a paragraph, and a paragraph of emphasis below it: a figure with its caption.

    Such a picture has its caption where plain Markdown is shown, too.
    """

    default_priority = 200

    def apply(self, **_: Any) -> None:
        for picture in list(self.document.findall(nodes.image)):
            alone = picture.parent
            if not isinstance(alone, nodes.paragraph) or len(alone) != 1:
                continue
            below = alone.next_node(nodes.paragraph, descend=False, siblings=True)
            if below is None or len(below) != 1 or not isinstance(below[0], nodes.emphasis):
                continue
            figure = nodes.figure("", picture, nodes.caption("", "", *below[0].children))
            below.parent.remove(below)
            alone.replace_self(figure)


#: What the paragraph of an example begins with that says what its picture shows; with the file's name if
#: there are several pictures.
SEE = re.compile(r"What to see(?: in (\S+))?:\s*")


class Example(SphinxDirective):
    """A script of `examples/`: its question, its picture, what it prints, and its text.

    `gallery.py` has run it and keeps what it printed and drew.
    """

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        name = self.arguments[0]
        script, kept = ROOT / "examples" / f"{name}.py", DOCS / "gallery" / name
        if not (kept / "printed.txt").exists():
            raise self.error(f"{kept} is missing: run docs/gallery.py {name}")
        question = ast.get_docstring(ast.parse(script.read_text(encoding="utf-8"))) or ""
        # the first sentence, or what stands before its colon, is the heading
        title, mark, rest = re.split(r"(?<!fig)([?.:])\s+", question + " ", maxsplit=1)
        # what it answers in the paper stands below, not in the heading
        source = re.search(r"\s*(\[[^\]]*\])$", title)
        if source is not None:
            title, rest = title[: source.start()], f"{source[1]} {rest}"
        # a line that begins with a per cent sign would be a comment
        paragraphs = [" ".join(text.split()) for text in rest.split("\n\n")]
        told: dict[str | None, str] = {
            found[1]: text[found.end() :] for text in paragraphs if (found := SEE.match(text))
        }
        rest = "\n\n".join(text for text in paragraphs if not SEE.match(text))
        lines = [f"### {title}{mark.strip('.:')}", "", rest[:1].upper() + rest[1:], ""]
        pictures = sorted(path for path in kept.iterdir() if path.suffix in (".png", ".gif"))
        if len(pictures) == 1 and None in told:
            told[pictures[0].name] = told.pop(None)
        if set(told) != {picture.name for picture in pictures}:
            raise self.error(f"{script}: each of its pictures needs a paragraph 'What to see in FILE:'")
        for picture in pictures:
            seen = told[picture.name]
            lines += [f"```{{figure}} gallery/{name}/{picture.name}", f":alt: {picture.stem}", ""]
            lines += [seen[:1].upper() + seen[1:], "```", ""]
        lines += [f"```{{literalinclude}} gallery/{name}/printed.txt", ":language: text", "```", ""]
        lines += ["```{raw} html", f"<details><summary>examples/{name}.py</summary>", "```", ""]
        lines += [f"```{{literalinclude}} ../examples/{name}.py", ":language: python", "```", ""]
        lines += ["```{raw} html", "</details>", "```"]
        self.env.note_dependency(str(script))
        return self.parse_text_to_nodes("\n".join(lines), allow_section_headings=True)


def visit_inline_formula(self: Any, node: nodes.math) -> None:
    self.body.append(f'<span class="math">{tex2mathml(node.astext())}</span>')
    raise nodes.SkipNode


def visit_formula(self: Any, node: nodes.math_block) -> None:
    self.body.append(self.starttag(node, "div", CLASS="math"))
    if node.get("number"):
        number = get_node_equation_number(self, node)
        self.body.append(f'<span class="eqno">({number})')
        self.add_permalink_ref(node, "Link to this equation")
        self.body.append("</span>")
    self.body.append(tex2mathml(node.astext(), as_block=True) + "</div>\n")
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, Any]:
    app.add_transform(Captions)
    app.add_directive("records", Records)
    app.add_directive("thesis-figures", ThesisFigures)
    app.add_directive("example", Example)
    app.add_html_math_renderer("mathml", (visit_inline_formula, None), (visit_formula, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
