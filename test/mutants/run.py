#!/usr/bin/env python3
"""Applies the mutations of mutants.py to a copy of the sources, one at a time, and says
which test notices each.

A mutation that no test notices is either explained in mutants.py or a defect of the tests:
the exit status is 1 then. Takes about half a minute for each mutation on one core.

    test/mutants/run.py                  # all of them, in build-mutants
    test/mutants/run.py --only history   # those whose file or name matches
    test/mutants/run.py --check          # only whether each text occurs once in its file
"""

import argparse
import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import time

from mutants import MUTANTS

ROOT = pathlib.Path(__file__).resolve().parents[2]
# In the order in which they run, except for the program of the mutated room, which is first.
PROGRAMS = ("test_stream", "test_voxels", "test_outliers", "test_filters", "test_codec",
            "test_compression", "test_nodes", "test_recording", "test_threads", "test_view", "test_link")
PROGRAM_OF_ROOM = {"bytes": "test_voxels", "voxels": "test_voxels",
                   "voxelizing": "test_voxels", "simd": "test_voxels",
                   "codec": "test_codec", "outliers": "test_outliers",
                   "filters": "test_filters", "compression": "test_compression",
                   "nodes": "test_nodes", "recording": "test_recording", "view": "test_view",
                   "link": "test_link"}
SECONDS_A_PROGRAM = 600
MOST_MEMORY = 8 << 30  # bytes of address space


def copy_sources(target):
    """Copies what git tracks; files that are the same keep their time for ninja."""
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT,
                            check=True, capture_output=True, text=True).stdout.split("\n")
    for name in filter(None, listed):
        source, copy = ROOT / name, target / name
        if not source.is_file():
            continue
        if copy.exists() and copy.read_bytes() == source.read_bytes():
            continue
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(source, copy)


def configure(source, build):
    launcher = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
    subprocess.run(["cmake", "-S", source, "-B", build, "-G", "Ninja", *launcher,
                    "-DCMAKE_BUILD_TYPE=RelWithDebInfo",
                    "-DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O1",
                    "-DPCL_EXT_BUILD_BENCHMARKS=OFF", "-DPCL_EXT_BUILD_EXAMPLES=OFF"],
                   check=True, stdout=subprocess.DEVNULL)


def compile_tests(build, jobs):
    result = subprocess.run(["cmake", "--build", build, "-j", str(jobs), "--target", *PROGRAMS],
                            capture_output=True, text=True)
    return result.returncode == 0, result.stdout


def limit_memory():
    """A mutant may allocate without end."""
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))


def first_failure(build, first="test_stream"):
    """The first test that fails, or None."""
    for program in sorted(PROGRAMS, key=lambda program: program != first):
        try:
            result = subprocess.run([build / "test" / program, "--gtest_fail_fast",
                                     "--gtest_brief=1"], capture_output=True, text=True,
                                    errors="replace", timeout=SECONDS_A_PROGRAM,
                                    preexec_fn=limit_memory)
        except subprocess.TimeoutExpired:
            return f"{program}: does not end"
        if result.returncode == 0:
            continue
        failed = re.search(r"\[  FAILED  \] ([\w/.]+)", result.stdout)
        if failed:
            return f"{program}: {failed.group(1)}"
        return f"{program}: ends with {result.returncode}"
    return None


def misfits(mutants):
    """A line for each mutant whose text does not occur once in its file."""
    lines = []
    for mutant in mutants:
        path = ROOT / mutant.file
        count = path.read_text().count(mutant.old) if path.is_file() else 0
        if count != 1:
            lines.append(f"{mutant.file}: {mutant.what}: '{mutant.old}' occurs {count} times")
    return lines


def judge(mutant, source, build, jobs):
    """What became of a mutant: a word, and the test that noticed it."""
    path = source / mutant.file
    text = path.read_text()
    try:
        path.write_text(text.replace(mutant.old, mutant.new))
        is_compiled, output = compile_tests(build, jobs)
        if not is_compiled:
            return "not compiled", "\n".join(re.findall(r".*error:.*", output)[:3])
        room = mutant.file.split("/")[1]
        failure = first_failure(build, PROGRAM_OF_ROOM.get(room, "test_stream"))
        return ("noticed", failure) if failure else ("survived", mutant.explanation)
    finally:
        path.write_text(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build-mutants")
    parser.add_argument("--only", default="", help="a regular expression for file and name")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--check", action="store_true", help="apply no mutation")
    options = parser.parse_args()

    chosen = [mutant for mutant in MUTANTS
              if re.search(options.only, f"{mutant.file} {mutant.what}")]
    if misfitting := misfits(chosen):
        sys.exit("\n".join(misfitting))
    if options.check:
        return 0
    source, build = options.build / "source", options.build / "build"
    copy_sources(source)
    configure(source, build)
    is_compiled, output = compile_tests(build, options.jobs)
    if not is_compiled:
        sys.exit(output[-2000:])
    failure = first_failure(build)
    if failure:
        sys.exit(f"the tests fail without a mutation: {failure}")

    outcomes = {}
    for mutant in chosen:
        start = time.monotonic()
        outcome, detail = judge(mutant, source, build, options.jobs)
        if outcome == "survived" and detail:
            outcome = "explained"
        outcomes[outcome] = outcomes.get(outcome, 0) + 1
        print(f"{outcome:14} {mutant.file}: {mutant.what}\n{'':14} {detail or ''} "
              f"({time.monotonic() - start:.0f} s)", flush=True)
    print(", ".join(f"{count} {outcome}" for outcome, count in sorted(outcomes.items())))
    return 0 if set(outcomes) <= {"noticed", "explained"} else 1


if __name__ == "__main__":
    sys.exit(main())
