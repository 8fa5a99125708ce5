# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Tests of how the report reads results, lays them out and checks them; no measurements are
needed."""

import pathlib
import tempfile
import unittest

import check_report
import tables
from page import DASH, Table, mean_and_deviation, mean_of, number
from results import CAMERAS, ReportError, Results, Value, read_results

HEADER = "experiment,sensor,coder,resolution_cm,quantity,mean,deviation,samples\n"


def results_of(text):
    """Results of the lines of a file."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "results.csv"
        file.write_text("Processor: one\n\n" + HEADER + text, encoding="utf-8")
        return Results([file])


class ReadingResults(unittest.TestCase):
    def test_values_by_their_key(self):
        results = results_of("a,1,fast,4,bytes,10.5,2,7\na,1,small,2,bytes,20,0,1\n")
        self.assertEqual(results.machine, "Processor: one")
        self.assertEqual(results.value("a", "1", "fast", 4, "bytes"), Value(10.5, 2, 7))
        self.assertIsNone(results.find("a", "2", "fast", 4, "bytes"))
        self.assertEqual(results.names("a", 2), ["fast", "small"])
        self.assertEqual(results.names("a", 2, sensor="2"), [])

    def test_what_is_missing_is_named(self):
        with self.assertRaisesRegex(ReportError, "lack a, 1, fast, 4, bytes"):
            results_of("").value("a", "1", "fast", 4, "bytes")

    def test_a_value_that_is_there_twice_is_refused(self):
        line = "a,1,fast,4,bytes,10,0,1\n"
        with self.assertRaisesRegex(ReportError, "'bytes'\\) is there twice"):
            results_of(line + line)

    def test_lines_that_are_no_results_are_refused(self):
        for line in ("a,1,fast,4,bytes,ten,0,1\n", "a,1\n"):
            with self.assertRaisesRegex(ReportError, "a line that is not a result"):
                results_of(line)

    def test_folders_without_results_are_named(self):
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaisesRegex(ReportError, "no results in"):
                read_results(folder)


class Tables(unittest.TestCase):
    def test_numbers(self):
        self.assertEqual(number(1234.56, 1), "1,234.6")
        self.assertEqual(mean_of(None, 1), DASH)
        self.assertEqual(mean_and_deviation(Value(2.0, 0.5, 3), 1), "2.0 ± 0.5")
        self.assertEqual(mean_and_deviation(Value(2.0, 0.0, 3), 1), "2.0")
        self.assertEqual(mean_and_deviation(None, 1), DASH)

    def test_cells_are_escaped(self):
        table = Table("what <it> is", ["a", "b"])
        table.add_group("one & two")
        table.add_row(["1", DASH])
        self.assertIn("<p class=\"caption\">what &lt;it&gt; is</p>", table.html())
        self.assertIn("one &amp; two", table.html())
        self.assertIn(f'<td>1</td><td class="absent">{DASH}</td>', table.html())

    def test_rows_of_another_length_are_refused(self):
        with self.assertRaisesRegex(ValueError, "1 cells under 2 headings"):
            Table("", ["a", "b"]).add_row(["1"])

    def test_ratios_to_the_paper(self):
        table = tables.beside_paper("", ["fast", "small"])
        tables.add_beside_paper(table, "KiB", (10.0, 0.5), 1, [Value(5.0, 0.2, 9), None])
        tables.add_beside_paper(table, "frames", None, 1, [Value(5.0, 0.0, 1), None])
        self.assertEqual(table.rows, [
            ["KiB", "10.0 ± 0.5", "5.0 ± 0.2", "0.50", DASH, DASH],
            ["frames", DASH, "5.0", DASH, DASH, DASH]])

    def test_quantities_of_subjects_and_groups(self):
        table = tables.quantities(
            results_of("a,1,fast,4,ms,2,0.5,7\n"), "", "coder",
            (("time", "ms", 1), ("size", "bytes", 0)),
            [("all",), ("fast", "a", "1", "fast", 4), ("slow", "a", "1", "slow", 4)])
        self.assertEqual(table.rows, [["all"], ["fast", "2.0 ± 0.5", DASH],
                                      ["slow", DASH, DASH]])


def noise_results(filter_precision="0.95", law_precision="0.2"):
    """Laws, the filter and PCL's on all cameras."""
    lines = []
    methods = {"count": "0.1", "quadratic": "0.15", "linear": law_precision,
               tables.FILTER: filter_precision}
    peers = {name: "0.8" for name in ("StatisticalOutlierRemoval 8", "RadiusOutlierRemoval 2",
                                      "StatisticalOutlierRemoval 9", "RadiusOutlierRemoval 3")}
    for sensor in CAMERAS:
        for method, precision in {**methods, **(peers if sensor == "1" else {})}.items():
            is_filter = method == tables.FILTER
            lines += [f"noise,{sensor},{method},4,{quantity},{value},0,20\n"
                      for quantity, value in (
                          ("noise_percent", 8), ("average_precision", precision),
                          ("usual_let_through_percent", 7 if is_filter else 60),
                          ("usual_surface_kept_percent", 95.1),
                          ("median_ms", 1 if is_filter else 9))]
    return results_of("".join(lines))


class Noise(unittest.TestCase):
    def problems(self, *values):
        check = check_report.Checks(noise_results(*values))
        check_report.check_noise(check)
        return check.problems

    def test_the_best_law_is_no_filter(self):
        self.assertEqual(tables.best_law(noise_results(), "1"), "linear")
        self.assertEqual(tables.noise_summary_table(noise_results()).rows[0],
                         ["1", "8.0", "0.200, linear", "0.950", "60.0", "7.0", DASH, DASH])

    def test_a_filter_that_is_no_better_than_a_law_is_a_problem(self):
        self.assertEqual(self.problems(), [])
        self.assertEqual(self.problems("0.95", "0.85")[0], "average precision of the filter, "
                         "sensor 1 is 0.95, not 1 to 1")
        self.assertEqual(len(self.problems("0.7")), 6 + 4)  # PCL's are better, too


def temporal_results(filtered_percent="12"):
    """All streams without a filter and with each one."""
    return results_of("".join(
        f"temporal,{sensor},{name},4,{quantity},{values[name == 'none']},0,20\n"
        for sensor in tables.FILTERED for name in tables.FILTERS
        for quantity, values in (("bytes", (1000, 8000)), ("surface_percent", (99, 100)),
                                 ("of_unfiltered_percent", (filtered_percent, 100)),
                                 ("noise_percent", (0.5, 6)))))


class Temporal(unittest.TestCase):
    def test_quantities_that_a_stream_does_not_have_are_dashes(self):
        rows = tables.temporal_table(temporal_results()).rows
        self.assertEqual(len(rows), 8 * 5)
        self.assertEqual(rows[0], ["sensor 1, count"])
        self.assertEqual(rows[3][:6], ["TemporalVoxelFilter", "1,000", "12.0", "99.00", DASH,
                                       DASH])

    def test_a_filter_that_saves_little_is_a_problem(self):
        def problems(percent):
            check = check_report.Checks(temporal_results(percent))
            check_report.check_temporal(check)
            return check.problems
        self.assertEqual(problems("60"), [])
        self.assertEqual(len(problems("61")), 6 * 2)


class Checking(unittest.TestCase):
    def test_problems_name_the_value_and_its_bounds(self):
        check = check_report.Checks(None)
        check.between(2.0, 1, 3, "a")
        check.near(1.01, 1.0, 0.02, "b")
        check.that(True, "c")
        self.assertEqual(check.problems, [])
        check.between(float("nan"), 1, 3, "a")
        check.near(2.0, 1.0, 0.02, "b", 4)
        check.that(False, "c")
        self.assertEqual(check.problems, ["a is nan, not 1 to 3", "b 4 is 2, not 1 to 2 %",
                                          "c"])


if __name__ == "__main__":
    unittest.main()
