# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Finds dead links in the reference that doxygen made, and in the Markdown files.

    python3 doc/check_links.py <html folder> <Markdown file> ...

Links to other sites are not checked. Exits with 1 if a link is dead, or for doxygen alone.
"""

import html
import pathlib
import re
import sys
from urllib.parse import unquote

from markdown_filter import slugs

# Doxygen 1.9 links its summaries to headings that it leaves out where all members are private.
SUMMARIES = {"nested-classes", "define-members"}


def is_elsewhere(link):
    return re.match(r"[a-z]+:", link) is not None


def anchors(page, known={}):
    if page not in known:
        known[page] = set(re.findall(r'\b(?:id|name)="([^"]+)"', page.read_text()))
    return known[page]


def dead_links_of_page(page):
    for link in re.findall(r'\b(?:href|src)="([^"]+)"', page.read_text()):
        link = html.unescape(link)
        if is_elsewhere(link):
            continue
        path, _, anchor = link.partition("#")
        target = page.parent / unquote(path) if path else page
        if not target.exists():
            yield link
        elif anchor and target.suffix == ".html" and anchor not in SUMMARIES:
            if unquote(anchor) not in anchors(target):
                yield link


def dead_links_of_markdown(page):
    text = re.sub(r"```.*?```", "", page.read_text(), flags=re.DOTALL)
    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        if is_elsewhere(link):
            continue
        path, _, anchor = link.partition("#")
        target = page.parent / path if path else page
        if not target.exists() or anchor and target.suffix == ".md" and anchor not in slugs(target).values():
            yield link
    # Outside of the reference these are no links and no ids.
    yield from re.findall(r"\]\((@ref [^)]*)\)", text)
    yield from re.findall(r"^#.* (\{#[\w-]+\})$", text, re.MULTILINE)


def main(folder, markdown_files):
    dead = [(page, link) for page in sorted(pathlib.Path(folder).glob("*.html"))
            for link in dead_links_of_page(page)]
    dead += [(page, link) for page in map(pathlib.Path, markdown_files)
             for link in dead_links_of_markdown(page)]
    for page, link in dead:
        print(f"{page}: dead link {link}", file=sys.stderr)
    return 1 if dead else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
