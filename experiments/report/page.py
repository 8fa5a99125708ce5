# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
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
th:first-child, td:first-child { position: sticky; left: 0; background: #fff; text-align: left; }
thead th, thead th:first-child { background: #eef1f4; vertical-align: bottom; }
td.paper { background: #fff7df; }
td.absent { color: #77828c; }
td.group, td.group:first-child { background: #f6f8f9; font-weight: 600; text-align: left; }
td.group span { position: sticky; left: .6rem; display: inline-block;
                max-width: calc(100vw - 3.2rem); white-space: normal; }
td.group:first-child { position: static; }
figure { margin: 1rem 0; }
figure img { width: 100%; height: auto; border: 1px solid #dfe4e8; }
figure.wide img { min-width: 44rem; }
figure.narrow img { max-width: 46rem; }
figcaption, p.note { font-size: .9rem; color: #4b5661; }
"""

DASH = "–"  # not measured, not reported, or not defined


def text(words):
    return html.escape(str(words), quote=False)


def number(value, digits):
    return f"{value:,.{digits}f}"


def mean_of(value, digits):
    """The mean of a value, or a dash where there is none."""
    return DASH if value is None else number(value.mean, digits)


def mean_and_deviation(value, digits):
    """Mean and deviation; the deviation is left out where there is none. None is a dash."""
    if value is None:
        return DASH
    mean = number(value.mean, digits)
    if value.samples < 2 or value.deviation == 0.0:
        return mean
    return f"{mean} ± {number(value.deviation, digits)}"


class Table:
    """A table that is filled row by row; cells are text."""

    def __init__(self, caption, header, paper_column=None):
        self.header = header
        self.rows = []  # lists of cells; of one cell where a group of rows begins
        self._caption = caption
        self._paper_column = paper_column

    def add_group(self, words):
        self.rows.append([words])

    def add_row(self, cells):
        if len(cells) != len(self.header):
            raise ValueError(f"{len(cells)} cells under {len(self.header)} headings")
        self.rows.append(cells)

    def _html_row(self, cells):
        if len(cells) == 1:
            return (f'<tr><td class="group" colspan="{len(self.header)}"><span>'
                    f"{text(cells[0])}</span></td></tr>")
        line = ["<tr>"]
        for column, cell in enumerate(cells):
            kinds = ["paper"] if column == self._paper_column else []
            kinds += ["absent"] if cell == DASH else []
            kind = f' class="{" ".join(kinds)}"' if kinds else ""
            line.append(f"<td{kind}>{text(cell)}</td>")
        return "".join(line) + "</tr>"

    def html(self):
        caption = f'<p class="caption">{text(self._caption)}</p>' if self._caption else ""
        header = "".join(f"<th>{text(cell)}</th>" for cell in self.header)
        rows = "\n".join(map(self._html_row, self.rows))
        return (f'{caption}<div class="scroll"><table><thead><tr>{header}</tr></thead>'
                f"<tbody>\n{rows}</tbody></table></div>")


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


def link(address, words):
    """A paragraph that is a link to a file beside the page."""
    return f'<p><a href="{html.escape(address)}">{text(words)}</a></p>'


def page(title, body):
    return ("<!DOCTYPE html>\n"
            '<html lang="en"><head><meta charset="utf-8">'
            '<meta name="viewport" content="width=device-width, initial-scale=1">'
            f"<title>{text(title)}</title><style>{STYLE}</style></head>"
            f"<body><h1>{text(title)}</h1>\n" + "\n".join(body) + "\n</body></html>\n")
