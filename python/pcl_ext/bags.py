# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Encoding of whole bags, by the program ``pcl_ext``."""

from __future__ import annotations

import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from typing import Any, List, Mapping, Optional, Tuple, Union

from ._progress import Progress, Report, reporting
from ._texts import counted
from .status import Error

PROGRAM_VARIABLE = "PCL_EXT_PROGRAM"

_OWN_PROGRAM = pathlib.Path(__file__).parent / "bin" / "pcl_ext"
"""In packages that pip has built."""


@dataclass(frozen=True)
class StreamSummary:
    """What became of the clouds of one stream.

    Parameters
    ----------
    name : str
        The topic, or the folder of the clouds.
    frames : int
        Encoded clouds.
    bytes : int
        Of the frames.
    failures : int
        Clouds that could not be read or encoded.
    """

    name: str
    frames: int
    bytes: int
    failures: int


@dataclass(frozen=True)
class BagSummary:
    """What became of one bag.

    Parameters
    ----------
    inputs : tuple of str
        The bag, or the folders of clouds.
    output : str
        The recording.
    status : str
        "done"; "incomplete": it was written, but the input is damaged, clouds failed, or
        points are outside the grid of voxels;
        "failed": nothing was written. Of a bag in a folder of bags also "interrupted".
    frames : int
        Of all streams.
    bytes : int
        Of these frames.
    failures : int
        Clouds that could not be read or encoded.
    streams : tuple of StreamSummary
        Those of the bag.
    errors : tuple of str
        What the program said.
    skipped : bool
        A run before has done it, and this one left it as it is; in a folder of bags only.
    """

    inputs: Tuple[str, ...]
    output: str
    status: str
    frames: int
    bytes: int
    failures: int
    streams: Tuple[StreamSummary, ...]
    errors: Tuple[str, ...]
    skipped: bool = False


@dataclass(frozen=True)
class EncodingSummary:
    """What became of the bags of a call of `encode_bag`.

    Parameters
    ----------
    bags : tuple of BagSummary
        One, or those of a folder.
    """

    bags: Tuple[BagSummary, ...]

    @property
    def ok(self) -> bool:
        """True if all bags are done."""
        return all(bag.status == "done" for bag in self.bags)

    @property
    def frames(self) -> int:
        """Of all bags."""
        return sum(bag.frames for bag in self.bags)

    @property
    def bytes(self) -> int:
        """Of all frames."""
        return sum(bag.bytes for bag in self.bags)

    @property
    def failures(self) -> int:
        """Clouds of all bags that could not be read or encoded."""
        return sum(bag.failures for bag in self.bags)

    @property
    def skipped(self) -> Tuple[str, ...]:
        """Paths of the bags that a run before has done, and that this one left as they are."""
        return tuple(name for bag in self.bags if bag.skipped for name in bag.inputs)

    def __str__(self) -> str:
        words = [counted(len(self.bags), "bag")]
        words += [f"{len(self.skipped):,} skipped, as done before"] if self.skipped else []
        words += [counted(self.frames, "frame"), counted(self.bytes, "byte")]
        not_done = sum(bag.status != "done" for bag in self.bags)
        words += [f"{not_done:,} not done"] if not_done else []
        return ", ".join(words)

    @property
    def errors(self) -> Tuple[str, ...]:
        """Of all bags that are not done."""
        return tuple(error for bag in self.bags for error in bag.errors)


def encode_bag(
    path: Union[str, os.PathLike[str]],
    output: Union[str, os.PathLike[str]],
    *,
    jobs: int = 1,
    overwrite: bool = False,
    progress: Progress = False,
    program: Optional[Union[str, os.PathLike[str]]] = None,
    **options: Any,
) -> EncodingSummary:
    """Encodes the clouds of a bag, by running ``pcl_ext encode``.

    Function, summary and errors can be pickled, so that Dask, Ray or Spark map it over
    bags. The bytes are the same wherever it runs, and for each number of jobs. If its
    process is killed, a file with ".unfinished" at the end of its name may stay.

    Parameters
    ----------
    path : str or os.PathLike
        A bag, a folder of clouds, or a folder of bags.
    output : str or os.PathLike
        The recording, x.mcap; of a folder of bags the folder of the recordings.
    jobs : int
        Threads that encode; 0: one a core.
    overwrite : bool
        Replace an output that exists.
    progress : bool or callable
        A function of two numbers, what is done and all there is, of messages of a bag, clouds
        of files, or bags of a folder, without those that are skipped; None for an unknown
        number. It is called at the start, some times a second, and at the end; if it raises
        an exception, the program is interrupted. True: a bar of tqdm, which must be
        installed.
    program : str or os.PathLike, optional
        The program; else that which the environment variable PCL_EXT_PROGRAM names, that
        of the package, if pip installed it, or ``pcl_ext`` in PATH.
    options : object
        Options of the program by their names, see ``pcl_ext encode --help``:
        ``resolution=0.05`` is ``--resolution 0.05``, ``keep_points=True`` is
        ``--keep-points``; None and False leave an option out. A list or a tuple has
        commas between its values; a dict repeats the option: ``pose={"/front": (0, 0, 1, 0,
        0, 0)}``. ``fields`` are as those of `Encoder`: ``fields={"time": 1e-6, "ring": None}``.
        ``max_rate`` is a number of bit/s, as there, or a text with a unit: ``"2Mbit/s"``.
        The effort is "balanced" unless it is given.

    Returns
    -------
    EncodingSummary
        Also if a part of the input is damaged or lost: see its `ok`.

    Raises
    ------
    Error
        If nothing was written, with the message of the program. The code is "Usage" for a
        wrong option, "Failed", "Interrupted", "Killed", or "NoProgram".
    """
    command = [
        _program(program),
        "encode",
        "--json",
        "--quiet",
        f"--jobs={jobs}",
        f"--output={os.fspath(output)}",
        *(["--overwrite"] if overwrite else []),
        *(["--progress"] if progress else []),
        *(word for name, value in options.items() for word in _words(name, value)),
        "--",
        os.fspath(path),
    ]
    with reporting(progress) as report:
        status, output, errors = _run(command, report)
    if status in (0, 1) and output.startswith("{"):
        return _summary(json.loads(output))
    code = {2: "Usage", 130: "Interrupted"}.get(status, "Failed")
    message = errors.strip() or f"'{command[0]}' ended with {status}"
    if status < 0:
        code = "Killed"
        message = f"'{command[0]}' was killed by signal {-status}"
    raise Error(message, code)


def _run(command: List[str], report: Optional[Report]) -> Tuple[int, str, str]:
    """Status, standard output and errors of a run of the program."""
    errors = []
    # A file takes the output, as nothing reads a pipe until the errors end.
    with tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as output:
        try:
            process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.PIPE,
                encoding="utf-8",
                errors="replace",
            )
        except OSError as error:
            raise Error(
                f"cannot run '{command[0]}': {error.strerror}", "NoProgram"
            ) from None
        with process:
            try:
                for line in process.stderr or ():
                    if report and line.startswith('{"done": '):
                        state = json.loads(line)
                        report(state["done"], state["total"])
                    else:
                        errors.append(line)
            except BaseException:
                process.terminate()
                raise
        output.seek(0)
        return process.returncode, output.read(), "".join(errors)


def _program(program: Optional[Union[str, os.PathLike[str]]]) -> str:
    named = program or os.environ.get(PROGRAM_VARIABLE)
    if named:
        return os.fspath(named)
    found = str(_OWN_PROGRAM) if _OWN_PROGRAM.exists() else shutil.which("pcl_ext")
    if found is None:
        raise Error(
            "there is no program pcl_ext in PATH: install it, name it with the "
            f"environment variable {PROGRAM_VARIABLE}, or pass program=",
            "NoProgram",
        )
    return found


def run_program() -> None:
    """Runs the program ``pcl_ext`` of this package in place of Python, which pip installs as a
    command."""
    if not _OWN_PROGRAM.exists():
        sys.exit(
            "pcl_ext: this package was built without the program, as what it needs was missing; "
            "see python/README.md"
        )
    os.execv(_OWN_PROGRAM, ["pcl_ext", *sys.argv[1:]])


def _words(name: str, value: Any) -> List[str]:
    option = "--" + name.replace("_", "-")
    if value is None or value is False:
        return []
    # A rate without a value would take the next word for one.
    if value is True and name != "max_rate":
        return [option]
    if name == "fields":
        return [f"{option}={_fields(value)}"]
    if isinstance(value, Mapping):
        return [f"{option}={key}={_text(one)}" for key, one in value.items()]
    # A number is in bit/s, as that of Encoder; the program wants the unit.
    is_rate = name == "max_rate" and isinstance(value, (int, float))
    return [f"{option}={_text(value)}{'bit/s' if is_rate else ''}"]


def _fields(fields: Any) -> str:
    """Fields as `Encoder` takes them, for the program: NAME or NAME:STEP each."""
    if isinstance(fields, Mapping):
        fields = tuple(fields.items())
    if not isinstance(fields, (list, tuple)):
        return str(fields)
    pairs = [field if isinstance(field, tuple) else (field, None) for field in fields]
    return ",".join(f"{name}:{step}" if step else str(name) for name, step in pairs)


def _text(value: Any) -> str:
    if isinstance(value, (list, tuple)):
        return ",".join(str(one) for one in value)
    return str(value)


def _summary(json_object: Any) -> EncodingSummary:
    return EncodingSummary(
        tuple(
            BagSummary(
                tuple(bag["inputs"]),
                bag["output"],
                bag["status"],
                bag["frames"],
                bag["frame_bytes"],
                bag["failures"],
                tuple(StreamSummary(**stream) for stream in bag["streams"]),
                tuple(bag["errors"]),
                bag.get("skipped", False),
            )
            for bag in json_object["bags"]
        )
    )
