#!/usr/bin/env python3
"""Puts measured tables into experiments/noise/README.md, each between its two comments.

update_noise_readme.py <folder of results> <README.md>
"""

import pathlib
import re
import sys

import noise_section
import noise_tables
from noise_results import FILTER
from results import ReportError, read_results

# As many as the page is to be of.
FRAMES = 300


def listed(sentences):
    return "\n".join("- " + words for words in sentences) + "\n"


def blocks_of(results):
    """What stands between which comments."""
    return {
        "aims": listed(noise_section.aims_in_words(results)),
        "summary": noise_tables.summary_table(results).markdown(),
        "person": noise_tables.person_table(results).markdown(),
        "peers": noise_tables.peers_table(results).markdown(),
        "times": noise_tables.times_table(results).markdown(),
        "bytes": noise_tables.bytes_table(results).markdown(),
        "failures": listed(noise_section.where_each_fails(results)),
        "frames": noise_section.frames_in_words(results) + "\n",
    }


def with_block(page, name, block):
    """The page with a block in the place of what was there."""
    begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    pattern = re.compile(f"(?s){re.escape(begin)}.*?{re.escape(end)}")
    if len(pattern.findall(page)) != 1:
        raise ReportError(f"the page lacks the comments '{begin}' and '{end}'")
    return pattern.sub(lambda _: f"{begin}\n\n{block}\n{end}", page)


def main(folder, file):
    results = read_results(folder)
    frames = results.figure("noise", "1", FILTER, 4, "average_precision").samples
    if frames != FRAMES:
        raise ReportError(f"'{folder}' has {frames} frames; the page is of {FRAMES}")
    page = file.read_text(encoding="utf-8")
    for name, block in blocks_of(results).items():
        page = with_block(page, name, block)
    file.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    try:
        main(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]))
    except (OSError, ReportError) as error:
        sys.exit(f"update_noise_readme.py: {error}")
