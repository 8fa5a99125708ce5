#!/usr/bin/env python3
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Encodes all bags of a folder on the workers of a Dask cluster.

    encode_bags_with_dask.py bags/ recordings/ --resolution 0.05 --scheduler tcp://host:8786
    encode_bags_with_dask.py s3://drives/monday /mnt/recordings --resolution 0.05

The folder may be any that fsspec knows: bags of an object store are copied to the worker
that encodes them. All workers must reach the output folder; without --scheduler they are
processes of this machine. Bags whose recordings are there already are left out, as these
get their names when they are complete. Exits with 1, and a table of what failed, if a bag
is not done.

pcl_ext.encode_bag is all that workers need: Ray's ray.remote(encode_one).remote(...) and
Spark's sparkContext.parallelize(bags).map(...) run it likewise.
"""

import argparse
import contextlib
import glob
import os
import shutil
import sys
import tempfile
import uuid

import dask
import distributed
import fsspec
import fsspec.implementations.local

import pcl_ext


def encode_one(url, output, options, prefix=".encoding_"):
    """Encodes the bag of a URL into a file.

    It works in a folder of its own beside it, whose name has a prefix, so that a worker that
    was taken for dead and the one in its place do not disturb each other.
    """
    with tempfile.TemporaryDirectory(
        prefix=prefix, dir=os.path.dirname(output)
    ) as own, local(url, own) as bag:
        made = os.path.join(own, os.path.basename(output))
        summary = pcl_ext.encode_bag(bag, made, **options)
        # One that lost a part is kept for looking, but is not taken for a complete one.
        os.replace(made, output if summary.ok else output + ".incomplete")
    return summary


@contextlib.contextmanager
def local(url, folder):
    """The path of a bag on this machine."""
    filesystem, path = fsspec.core.url_to_fs(url)
    if isinstance(filesystem, fsspec.implementations.local.LocalFileSystem):
        yield path
        return
    copy = os.path.join(folder, "copy", os.path.basename(path))
    is_folder = filesystem.isdir(path)
    os.makedirs(copy if is_folder else os.path.dirname(copy))
    for file in filesystem.ls(path, detail=False) if is_folder else [path]:
        name = os.path.basename(file)
        filesystem.get_file(file, os.path.join(copy, name) if is_folder else copy)
    yield copy  # which is removed with its folder


def bags_of(url):
    """Names of the bags in a folder without extensions, and their URLs."""
    filesystem, path = fsspec.core.url_to_fs(os.fspath(url))
    bags: dict[str, str] = {}
    for entry in sorted(filesystem.ls(path, detail=True), key=lambda one: one["name"]):
        name = os.path.basename(entry["name"].rstrip("/"))
        is_folder = entry["type"] == "directory"
        stem, extension = (name, "") if is_folder else os.path.splitext(name)
        is_bag = (
            filesystem.exists(entry["name"] + "/metadata.yaml")
            if is_folder
            else extension in (".mcap", ".bag")
        )
        if not is_bag:
            continue
        if stem in bags:
            sys.exit(f"{bags[stem]} and {name} would both become {stem}.mcap: move one")
        bags[stem] = filesystem.unstrip_protocol(entry["name"])
    return bags


def table(failed):
    """Rows of bags and why they failed, in Markdown."""
    return "\n".join(
        ["| bag | why |", "|---|---|"]
        + [f"| {bag} | {' '.join(str(why).split())} |" for bag, why in failed]
    )


def encode_all(client, url, folder, options, retries):
    """Encodes the bags of a folder that have no recording yet.

    Returns summaries of those that were done, by their names, and pairs of the others and
    why.
    """
    os.makedirs(folder, exist_ok=True)
    folder = os.path.abspath(folder)
    prefix = f".encoding_{uuid.uuid4().hex}_"
    futures = {}
    for name, bag in bags_of(url).items():
        output = os.path.join(folder, name + ".mcap")
        if not os.path.exists(output):
            task = encode_one, bag, output, options, prefix
            futures[client.submit(*task, retries=retries, pure=False)] = name
    done, failed = {}, []
    for future in distributed.as_completed(futures):
        name = futures[future]
        if future.status != "finished":
            failed.append((name, future.exception()))
            continue
        summary = future.result()
        if summary.ok:
            done[name] = summary
        else:
            failed.append((name, "; ".join(summary.errors)))
        future.release()
    # Of workers that were killed.
    for left in glob.glob(os.path.join(glob.escape(folder), prefix + "*")):
        shutil.rmtree(left, ignore_errors=True)
    return done, sorted(failed, key=lambda one: one[0])


def main():
    parser = argparse.ArgumentParser(
        description=__doc__.partition("\n")[0],
        epilog="Other options are those of pcl_ext encode, each as --name=value.",
    )
    parser.add_argument("bags", help="a folder, or a URL of one that fsspec knows")
    parser.add_argument("output", help="folder of the recordings, which all workers reach")
    parser.add_argument("--resolution", type=float, help="edge of a voxel, metres")
    parser.add_argument("--scheduler", help="address; else processes of this machine")
    parser.add_argument("--workers", type=int, help="processes (one a core)")
    parser.add_argument("--retries", type=int, default=2, help="of a bag that failed")
    arguments, others = parser.parse_known_args()
    options = {"resolution": arguments.resolution}
    for word in others:
        name, equals, value = word.partition("=")
        if not name.startswith("--"):
            parser.error(f"'{word}' is no option")
        options[name[2:].replace("-", "_")] = value if equals else True
    cluster = (
        {"address": arguments.scheduler}
        if arguments.scheduler
        else {
            "n_workers": arguments.workers or os.cpu_count(),
            "threads_per_worker": 1,
            "dashboard_address": None,
        }
    )
    # A bag that kills its worker again and again is given up.
    with dask.config.set(
        {"distributed.scheduler.allowed-failures": arguments.retries}
    ), distributed.Client(**cluster) as client:
        done, failed = encode_all(
            client, arguments.bags, arguments.output, options, arguments.retries
        )
    frames = sum(summary.frames for summary in done.values())
    print(f"{len(done)} bags encoded, {frames} frames, {len(failed)} failed")
    if failed:
        print(table(failed))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
