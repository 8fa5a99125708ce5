"""Tests of how the report reads results, lays them out and checks them; no measurements are
needed."""

import pathlib
import tempfile
import unittest

import check_report
import lidar_noise_section
import motion_section
import noise_tables
import tables
import temporal_section
from noise_results import FILTER, FILTER_OF_EACH, METHODS, best_law, least_let_through
from page import DASH, Table, mean_and_deviation, mean_of, number
from results import ReportError, Results, Value, read_results, read_rows

HEADER = "experiment,sensor,coder,resolution_cm,quantity,mean,deviation,samples\n"


def results_of(text):
    """Results of the lines of a file."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "results.csv"
        file.write_text(HEADER + text, encoding="utf-8")
        return Results([file])


class ReadingResults(unittest.TestCase):
    def test_values_by_their_key(self):
        results = results_of("a,1,fast,4,bytes,10.5,2,7\na,1,fast,2,bytes,20,0,1\n"
                             "b:x,2,small,4,ms,1,0,1\n")
        self.assertEqual(results.value("a", "1", "fast", 4, "bytes"), Value(10.5, 2, 7))
        self.assertIsNone(results.find("a", "2", "fast", 4, "bytes"))
        self.assertEqual(results.experiments("b:"), ["x"])
        self.assertEqual(results.coders("a", resolution_cm=2.0), ["fast"])
        self.assertEqual(results.sensors("a", sensor="2"), [])
        self.assertEqual(results.quantities("a", sensor="1"), ["bytes"])

    def test_what_is_missing_is_named(self):
        with self.assertRaisesRegex(ReportError, "lack a, 1, fast, 4, bytes"):
            results_of("").value("a", "1", "fast", 4, "bytes")

    def test_a_value_that_is_there_twice_is_refused(self):
        line = "a,1,fast,4,bytes,10,0,1\n"
        with self.assertRaisesRegex(ReportError, "line 3: .* is there twice"):
            results_of(line + line)

    def test_lines_that_are_no_results_are_refused(self):
        for line in ("a,1,fast,4,bytes,ten,0,1\n", "a,1\n"):
            with self.assertRaisesRegex(ReportError, "line 2, is not a result"):
                results_of(line)

    def test_folders_without_results_are_named(self):
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaisesRegex(ReportError, "no results in"):
                read_results(folder)
            (pathlib.Path(folder) / "rows.csv").write_text("x,y\n", encoding="utf-8")
            with self.assertRaisesRegex(ReportError, "has no rows"):
                read_rows(folder, "rows.csv")


class Tables(unittest.TestCase):
    def test_numbers(self):
        self.assertEqual(number(1234.56, 1), "1,234.6")
        self.assertEqual(mean_of(None, 1), DASH)
        self.assertEqual(mean_and_deviation(Value(2.0, 0.5, 3), 1), "2.0 ± 0.5")
        self.assertEqual(mean_and_deviation(Value(2.0, 0.0, 3), 1), "2.0")

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


def noise_results(filter_precision="0.95"):
    """Laws and filters of all sensors, with a different value for each."""
    lines = []
    for sensor, methods in METHODS.items():
        for place, method in enumerate(methods):
            is_filter = method in (FILTER, FILTER_OF_EACH)
            for quantity, value in (
                    ("noise_percent", "8"),
                    ("average_precision",
                     filter_precision if is_filter else f"0.{place + 1}"),
                    ("usual_let_through_percent", "7" if is_filter else f"{90 - place}")):
                lines.append(f"noise,{sensor},{method},4,{quantity},{value},0,20\n")
    return results_of("".join(lines))


class NoiseTables(unittest.TestCase):
    def test_the_best_law_is_no_filter(self):
        results = noise_results()
        self.assertEqual(best_law(results, "1"), "linear")
        self.assertEqual(best_law(results, "7"), "count")
        self.assertEqual(least_let_through(results, "1"), 88.0)

    def test_the_summary_says_whether_aims_are_met(self):
        for precision, verdict in (("0.950", "met"), ("0.899", "not met")):
            table = noise_tables.summary_table(noise_results(precision))
            self.assertEqual(table.rows[1][:8], ["1", "8.0", "0.300, linear", precision,
                                                 verdict, "88.0", "7.0", "met"])

    def test_bands_without_surface_have_a_dash(self):
        lines = []
        for sensor, methods in METHODS.items():
            for method in methods:
                for band in noise_tables.BANDS:
                    surface = "0" if band == "up to 3 m" else "5"
                    lines += [f"noise_band:{band},{sensor},{method},4,{quantity},{value},"
                              "0,20\n" for quantity, value in (
                                  ("noise_voxels", "3"), ("surface_voxels", surface),
                                  ("average_precision", "1"))]
        table = noise_tables.bands_table(results_of("".join(lines)), "",
                                         "average_precision", 3)
        self.assertEqual(table.rows[1], ["1", DASH] + 4 * ["1.000"])


def motion_results(i_frames_bytes="2000"):
    """Streams that move, each effort with more bytes than the next one."""
    lines = ["streams_run,,all,0,frames,20,0,1\n"]
    for stream, cm in motion_section.STREAMS.items():
        for place, coder in enumerate(("small", "balanced", "fast", "published")):
            for experiment, size in (("motion", "1000"), ("motion_i_frames", i_frames_bytes)):
                lines += [f"{experiment},{stream},{coder},{cm},{quantity},{value},0,20\n"
                          for quantity, value in (("voxels", 1500),
                                                  ("bytes", int(size) + place),
                                                  ("bytes_per_voxel", int(size) / 2000))]
    return results_of("".join(lines))


def problems_of(check_section, results, rows=None):
    """What a section's check finds."""
    check = check_report.Checks.__new__(check_report.Checks)
    check.problems, check.results, check.rows = [], results, rows
    check_section(check)
    return check.problems


class Motion(unittest.TestCase):
    def problems(self, results):
        return problems_of(motion_section.check_motion, results)

    def test_rows_compare_with_i_frames_alone(self):
        table = motion_section.motion_table(motion_results())
        self.assertEqual(len(table.rows), 5 * 5)
        self.assertEqual(table.rows[0], ["fixed camera, 4 cm"])
        self.assertEqual(table.rows[1], ["published", "1,500", "0.500", "1.000", "50.0"])

    def test_history_that_costs_bytes_is_a_problem(self):
        self.assertEqual(self.problems(motion_results()), [])
        self.assertEqual(self.problems(motion_results("996")), [])
        problems = self.problems(motion_results("990"))
        self.assertEqual(len(problems), 5 * 4)
        self.assertIn("bytes against I-frames alone, camera on a hand balanced is",
                      problems[10])


def lidar_noise_results(let_through="20", surfaces="99.9"):
    """All methods in all airs; voxels are scored by one of them."""
    lines = []
    for sensor, noise in zip(lidar_noise_section.AIRS, (1, 4, 7)):
        for method, (_, threshold) in lidar_noise_section.METHODS.items():
            is_own = method == lidar_noise_section.FILTER
            cm = 10 if method in ("filter on rays", "filter on voxels") else 0
            for experiment, edge, quantity, value in (
                    ("scan_points", cm, "noise_percent", noise),
                    ("scan_points", cm, "average_precision", 0.9 if is_own else 0.5),
                    ("scan_voxels", 10, "average_precision", 0.6),
                    (f"scan_points_threshold:{threshold}", cm, "let_through_percent",
                     let_through),
                    (f"scan_points_threshold:{threshold}", cm, "surface_kept_percent",
                     surfaces),
                    ("scan_time", cm, "median_ms", 2)):
                lines.append(f"{experiment},{sensor},{method},{edge},{quantity},{value},0,20\n")
    return results_of("".join(lines))


def lidar_rows(kept_snow=5):
    """A revolution of which some of the snow stays."""
    return {"lidar_in_snow": [
        {"is_snow": float(kind == "snow"), "is_mixed_echo": float(kind == "mixed"),
         "log_odds": 1.0 if place < kept else -1.0}
        for kind, number, kept in (("snow", 1000, kept_snow), ("mixed", 200, 200),
                                   ("surface", 20_000, 19_990))
        for place in range(number)]}


class LidarNoise(unittest.TestCase):
    def problems(self, results, rows):
        return problems_of(lidar_noise_section.check_lidar_noise, results, rows)

    def test_methods_on_voxels_and_on_points_have_rows(self):
        rows = lidar_noise_section.lidar_table(lidar_noise_results()).rows
        self.assertEqual(len(rows), 3 * 6)
        self.assertEqual(rows[0], ["clear air: 1.0 % of the points are noise"])
        self.assertEqual(rows[7], ["PointOutlierRemoval", "0.900", "0.600", DASH, DASH,
                                   "80.0", "99.90", DASH, "2.0"])
        self.assertEqual(rows[8][:3], ["VoxelOutlierRemoval, rays, voxels of 10 cm", "0.500",
                                       "0.600"])

    def test_a_method_that_was_not_measured_is_named(self):
        with self.assertRaisesRegex(ReportError, "lack filter on points of sensor 7"):
            lidar_noise_section.lidar_table(results_of(""))

    def test_surfaces_that_are_removed_are_a_problem(self):
        self.assertEqual(self.problems(lidar_noise_results(), lidar_rows()), [])
        problems = self.problems(lidar_noise_results(surfaces="98"), lidar_rows())
        self.assertEqual(len(problems), 3)
        self.assertEqual(problems[0], "surfaces kept of 7 is 98, not 99 to 100")

    def test_snow_that_stays_in_the_picture_is_a_problem(self):
        self.assertEqual(self.problems(lidar_noise_results(), lidar_rows(kept_snow=200)),
                         ["snow that is shown is 0.2, not 0 to 0.1"])


def temporal_results(filtered_bytes="1000"):
    """All streams without a filter, and with each one the same bytes."""
    lines = []
    for law, sensor, cm in temporal_section.STREAMS:
        for name in temporal_section.FILTERS:
            is_filtered = name != "none"
            size = filtered_bytes if is_filtered else "8000"
            share = int(size) / 80
            lines += [f"temporal:{law},{sensor},{name},{cm},{quantity},{value},0,20\n"
                      for quantity, value in (
                          ("balanced 30 bytes", size), ("balanced 300 bytes", size),
                          ("balanced 30 of_unfiltered_percent", share),
                          ("balanced 300 of_unfiltered_percent", share),
                          ("surface_percent", 99 if is_filtered else 100),
                          ("new_percent", 98 if is_filtered else 100),
                          ("new_voxels", temporal_section.LEAST_NEW),
                          ("new_later_percent", 100),
                          ("noise_percent", 0.5 if is_filtered else 6))]
    return results_of("".join(lines))


class Temporal(unittest.TestCase):
    def test_quantities_that_a_stream_does_not_have_are_dashes(self):
        rows = temporal_section.temporal_table(temporal_results()).rows
        self.assertEqual(len(rows), 20 * 5)
        self.assertEqual(rows[0], ["sensor 1, count, 4 cm"])
        self.assertEqual(rows[3][:4], ["TemporalVoxelFilter", DASH, "1,000", "12.5"])

    def test_a_filter_that_saves_little_is_a_problem(self):
        def problems(size):
            return problems_of(temporal_section.check_temporal, temporal_results(size))
        self.assertEqual(problems("4800"), [])
        self.assertEqual(len(problems("4880")), 20 * 2)


class Checking(unittest.TestCase):
    def test_problems_name_the_value_and_its_bounds(self):
        check = check_report.Checks.__new__(check_report.Checks)
        check.problems = []
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
