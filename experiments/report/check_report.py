#!/usr/bin/env python3
"""Checks that a report is whole: check_report.py <report>."""

import base64
import io
import pathlib
import re
import sys
import unittest

from matplotlib import image

import plain_checks


class Page(unittest.TestCase):
    """The report itself."""

    page = ""

    def pictures(self):
        for encoded in re.findall(r'src="data:image/png;base64,([^"]+)"', self.page):
            yield image.imread(io.BytesIO(base64.b64decode(encoded)))

    def ink(self, pixels):
        """Share of a picture that is not white."""
        return float((pixels[..., :3] < 0.98).any(axis=-1).mean())

    def test_nothing_comes_from_elsewhere(self):
        for source in re.findall(r'(?:src|href)="([^"]*)"', self.page):
            self.assertTrue(source.startswith("data:"), source[:80])
        self.assertNotRegex(self.page, r"url\(|@import|<script|<link|<iframe")

    def test_every_picture_is_there_and_not_blank(self):
        pictures = list(self.pictures())
        self.assertEqual(len(pictures), 6)
        for pixels in pictures:
            self.assertGreater(pixels.shape[0], 200)
            self.assertGreater(pixels.shape[1], 400)
            self.assertGreater(self.ink(pixels), 0.02)

    def test_every_view_of_figure_11_shows_something(self):
        encoded = re.search(r'src="data:image/png;base64,([^"]+)" alt="Top views', self.page)
        self.assertIsNotNone(encoded, "there is no figure 11")
        pixels = image.imread(io.BytesIO(base64.b64decode(encoded[1])))
        height, width = (size // part for size, part in zip(pixels.shape, (2, 3)))
        for row, column in ((0, 0), (0, 1), (0, 2), (1, 0), (1, 1)):
            # The middle of a view, without its frame.
            view = pixels[row * height + height // 4:(row + 1) * height - height // 5,
                          column * width + width // 5:(column + 1) * width - width // 5]
            self.assertGreater(self.ink(view), 0.05, (row, column))

    def test_every_section_is_there(self):
        for words in ("Figure 5", "Figure 7", "Figure 10", "Figure 11",
                      "3.1 Preprocessing", "3.2 Compression", "Depth images",
                      "3.3 Frequency and bandwidth", "3.4 Denoising", "Processor: ",
                      "Noise and surface told apart", "Where each fails", "What moves",
                      "Against PCL's filters", "By distance",
                      "Thresholds, all cameras merged"):
            self.assertIn(words, self.page)

    def test_no_figure_is_missing(self):
        self.assertNotRegex(self.page, r"\b(?:nan|inf)\b")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    try:
        Page.page = pathlib.Path(sys.argv[1]).read_text(encoding="utf-8")
    except OSError as error:
        sys.exit(f"check_report.py: {error}")
    sys.exit(plain_checks.run("check_report.py", (Page,)))
