"""The report's HTML: one file, nothing from the network."""

import base64
import html

STYLE = """
:root { color-scheme: light; }
* { box-sizing: border-box; }
body { font: 16px/1.5 system-ui, sans-serif; color: #1d2329; background: #fff;
       margin: 0 auto; max-width: 72rem; padding: 1rem; }
h1 { font-size: 1.7rem; line-height: 1.2; }
h2 { font-size: 1.3rem; margin-top: 2.5rem; border-bottom: 2px solid #d5dbe1; }
h3 { font-size: 1.05rem; margin: 1.5rem 0 .5rem; }
.scroll { overflow-x: auto; }
.scroll + .scroll { margin-top: 1rem; }
table { border-collapse: separate; border-spacing: 0; font-size: .85rem; font-variant-numeric: tabular-nums; }
p.caption { font-size: .9rem; margin: 1rem 0 .3rem; color: #4b5661; }
th, td { padding: .25rem .6rem; border-bottom: 1px solid #dfe4e8; text-align: right; }
td { white-space: nowrap; }
th { min-width: 5rem; }
th:first-child, td:first-child { position: sticky; left: 0; background: #fff; }

th:first-child, td:first-child { text-align: left; }
thead th, thead th:first-child { background: #eef1f4; vertical-align: bottom; }
tr.paper td, tr.paper td:first-child { background: #fff7df; }
td.absent { color: #77828c; font-style: italic; }
td.chapter, td.chapter:first-child { background: #f6f8f9; font-weight: 600; text-align: left; }
details { margin: .5rem 0; }
summary { cursor: pointer; font-weight: 600; }
figure { margin: 1rem 0; }
figure img { width: 100%; height: auto; border: 1px solid #dfe4e8; }
figure.wide img { min-width: 44rem; }
figure.narrow img { max-width: 46rem; }
figcaption, p.note { font-size: .9rem; color: #4b5661; }
code { background: #eef1f4; padding: 0 .2rem; overflow-wrap: anywhere; }
"""


def text(words):
    return html.escape(str(words), quote=False)


def number(value, digits):
    return f"{value:,.{digits}f}"


def mean_and_deviation(figure, digits):
    """Mean and deviation; the deviation is left out of what was measured once."""
    mean = number(figure.mean, digits)
    if figure.samples < 2:
        return mean
    return f"{mean} ± {number(figure.deviation, digits)}"


NOT_AT_HAND = "not at hand"


class Table:
    """A table that is filled row by row; cells are text."""

    def __init__(self, caption, header):
        self._header = header
        self._caption = f'<p class="caption">{text(caption)}</p>' if caption else ""
        self._lines = ["<thead><tr>"]
        self._lines += [f"<th>{text(cell)}</th>" for cell in header]
        self._lines.append("</tr></thead><tbody>")

    def add_chapter(self, words):
        self._lines.append(f'<tr><td class="chapter" colspan="{len(self._header)}">'
                           f"{text(words)}</td></tr>")

    def add_row(self, cells, is_of_paper=False):
        if len(cells) != len(self._header):
            raise ValueError(f"{len(cells)} cells under {len(self._header)} headings")
        self._lines.append('<tr class="paper">' if is_of_paper else "<tr>")
        for cell in cells:
            kind = ' class="absent"' if cell in (NOT_AT_HAND, "–") else ""
            self._lines.append(f"<td{kind}>{text(cell)}</td>")
        self._lines.append("</tr>")

    def html(self):
        return (self._caption + '<div class="scroll"><table>' + "\n".join(self._lines)
                + "</tbody></table></div>")


def picture(png, description, caption, is_narrow=False):
    """A picture within the page."""
    encoded = base64.b64encode(png).decode("ascii")
    kind = "narrow" if is_narrow else "wide"
    return (f'<figure class="{kind}"><div class="scroll">'
            f'<img src="data:image/png;base64,{encoded}" alt="{html.escape(description)}">'
            f"</div><figcaption>{text(caption)}</figcaption></figure>")


def paragraph(words):
    return f"<p>{text(words)}</p>"


def note(words):
    return f'<p class="note">{text(words)}</p>'


def _table_of_markdown(lines):
    rows = [[cell.strip() for cell in line.strip().strip("|").split("|")]
            for line in lines]
    table = Table("", rows[0])
    for row in rows[2:]:  # the second line rules off the header
        table.add_row(row)
    return table.html()


def sections_of_markdown(markdown):
    """Headings, each with its paragraphs and tables as HTML: as much of Markdown as this
    project's programs print. What is before the first heading belongs to each of them."""
    common = []
    sections = []
    for block in markdown.strip().split("\n\n"):
        block = block.strip()
        blocks = sections[-1][1] if sections else common
        if block.startswith("#"):
            sections.append((block.lstrip("#").strip(), list(common)))
        elif block.startswith("|"):
            blocks.append(_table_of_markdown(block.splitlines()))
        elif block:
            blocks.append(note(block))
    return sections


def page(title, body):
    return ("<!DOCTYPE html>\n"
            '<html lang="en"><head><meta charset="utf-8">'
            '<meta name="viewport" content="width=device-width, initial-scale=1">'
            f"<title>{text(title)}</title><style>{STYLE}</style></head>"
            f"<body><h1>{text(title)}</h1>\n" + "\n".join(body) + "\n</body></html>\n")
