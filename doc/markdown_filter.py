# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Prints a Markdown file, written as GitHub shows it, as doxygen understands it.

    python3 doc/markdown_filter.py <Markdown file>

- Headings get ids that are unique over all files: of a page its name (`site`, `ros2-README`), of its sections that
  and GitHub's slug (`site-many-centres`). Links to headings lead to these.
- Links to files of source lead to their pages, which have no path; pictures are found by their path from the top.
"""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent


def slug(title):
    text = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", title)
    return re.sub(r"[^\w\- ]", "", text.strip().lower()).replace(" ", "-")


def slugs(page):
    """The line of each heading of a page, from 0, and the anchor that GitHub gives it."""
    found, is_code = {}, False
    for number, line in enumerate(page.read_text().splitlines()):
        if line.lstrip().startswith("```"):
            is_code = not is_code
        heading = None if is_code else re.match(r"#{1,6} +(.*?)[ #]*$", line)
        if heading:
            anchor, repeated = slug(heading[1]), 0
            while anchor in found.values():
                repeated += 1
                anchor = f"{slug(heading[1])}-{repeated}"
            found[number] = anchor
    return found


def doxygen_id(page, anchor):
    name = "-".join(page.resolve().relative_to(ROOT).with_suffix("").parts).removeprefix("doc-")
    return name if anchor == next(iter(slugs(page).values())) else f"{name}-{anchor}"


def doxygen_link(page, link):
    path, _, anchor = link.partition("#")
    target = page.parent / path if path else page
    if anchor and target.suffix == ".md" and target.exists():
        return "#" + doxygen_id(target, anchor)
    source = re.fullmatch(r"(?:\.\./)*(?:examples|include)/(?:[^/]+/)*([^/]+)", link)
    return f"@ref {source[1]}" if source else re.sub(r"^(\.\./)+(?=doc/.+[.]webp$)", "", link)


def main(page):
    headings = slugs(page)
    for number, line in enumerate(page.read_text().splitlines()):
        if number in headings:
            line += f" {{#{doxygen_id(page, headings[number])}}}"
        print(re.sub(r"\]\(([^)\s]+)\)", lambda link: f"]({doxygen_link(page, link[1])})", line))


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]).resolve())
