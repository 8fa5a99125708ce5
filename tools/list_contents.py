# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Writes an SPDX 2.3 document of a release: its files, and what others wrote that is in them.

Usage: list_contents.py VERSION FOLDER, in a clone; FOLDER/contents.spdx.json is written.
Needs SOURCE_DATE_EPOCH, and Debian's packages that are named below. tools/release.sh calls it.
"""

import datetime
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
# Compiled into something of a release, from Debian's packages.
COMPILED_IN = {
    "libboost-dev": ("Boost", "BSL-1.0"),
    "libcli11-dev": ("CLI11", "BSD-3-Clause"),
    "nlohmann-json3-dev": ("nlohmann_json", "MIT"),
    "zlib1g-dev": ("zlib", "Zlib"),
    "libzstd-dev": ("zstd", "BSD-3-Clause"),
    "liblz4-dev": ("lz4", "BSD-2-Clause"),
    "libsqlite3-dev": ("SQLite", "blessing"),
    "libeigen3-dev": ("Eigen", "MPL-2.0"),
    "pybind11-dev": ("pybind11", "BSD-3-Clause"),
    "libstdc++6": ("libstdc++", "GPL-3.0-or-later WITH GCC-exception-3.1"),
    "libc++-dev-wasm32": ("libc++", "Apache-2.0 WITH LLVM-exception"),
    "wasi-libc": ("wasi-libc", "Apache-2.0 WITH LLVM-exception AND MIT"),
}
# What Debian's packages of this project are linked with.
LINKED_WITH = {
    "libbz2-dev": ("bzip2", "bzip2-1.0.6"),
    "liblzf-dev": ("LibLZF", "BSD-2-Clause"),
    "libnats-dev": ("NATS C client", "Apache-2.0"),
    "liboctomap-dev": ("OctoMap", "BSD-3-Clause"),
    "libpcl-dev": ("Point Cloud Library", "BSD-3-Clause"),
}
# Of what is not source alone: its licences besides BSD-3-Clause, by a part of its name.
WASM = ("Apache-2.0 WITH LLVM-exception", "MIT", "MPL-2.0", "Zlib")
LICENCES = {
    r"\.whl": ("BSD-2-Clause", "GPL-3.0-or-later WITH GCC-exception-3.1", "MPL-2.0", "Zlib", "blessing"),
    r"viewer\.html": (*WASM, "ISC"),
    r"\.foxe": WASM,
    r"\.tgz": WASM,
    "orig-page": (*WASM, "ISC"),
    "pcl-ext-tools_": (*WASM, "BSL-1.0", "ISC"),
    "libpcl-ext[0-9]": ("BSL-1.0", "MIT", "MPL-2.0"),
    "python3-pcl-ext": ("MPL-2.0",),
}


def digest(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def licence_of(name):
    """Of a file that was made of the source."""
    others = next((licences for part, licences in LICENCES.items() if re.search(part, name)), ())
    return " AND ".join(sorted({"BSD-3-Clause", *others}))


def file_entry(identifier, name, path, licence="BSD-3-Clause"):
    checksums = [
        {"algorithm": "SHA1", "checksumValue": hashlib.sha1(path.read_bytes()).hexdigest()},
        {"algorithm": "SHA256", "checksumValue": digest(path)},
    ]
    return {
        "SPDXID": identifier,
        "fileName": f"./{name}",
        "checksums": checksums,
        "licenseConcluded": licence,
        "licenseInfoInFiles": ["NOASSERTION"],
        "copyrightText": "NOASSERTION",
    }


def verification_code(files):
    """Of a package's files, as SPDX 2.3 computes it (7.9.5)."""
    digests = sorted(entry["checksums"][0]["checksumValue"] for entry in files)
    return {"packageVerificationCodeValue": hashlib.sha1("".join(digests).encode()).hexdigest()}


def package(identifier, name, version, licence, location="NOASSERTION"):
    return {
        "SPDXID": identifier,
        "name": name,
        "versionInfo": version,
        "downloadLocation": location,
        "filesAnalyzed": False,
        "licenseConcluded": licence,
        "licenseDeclared": licence,
        "copyrightText": "NOASSERTION",
    }


def debian_version(name):
    ask = ["dpkg-query", "-W", "-f", "${Version}", name]
    return subprocess.run(ask, check=True, capture_output=True, text=True).stdout


def npm_packages():
    """Name, version and licence of what the viewer's page and the extension have in them."""
    lock = json.loads((ROOT / "viewer/package-lock.json").read_text())
    used = set(json.loads((ROOT / "viewer/package.json").read_text())["dependencies"])
    for path, entry in sorted(lock["packages"].items()):
        name = path.rpartition("node_modules/")[2]
        if path.startswith("node_modules/") and not entry.get("dev") and not entry.get("link"):
            used.discard(name)
            yield name, entry["version"], entry.get("license", "NOASSERTION")
    if used:
        sys.exit(f"package-lock.json has no {used}")


def main(version, folder):
    listing = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True)
    sources = [name for name in listing.stdout.decode().split("\0") if name]
    artifacts = sorted(
        path for path in folder.rglob("*") if path.is_file() and path.suffix != ".json")
    packages = [package("SPDXRef-pcl-ext", "pcl_ext", version, "BSD-3-Clause")]
    relations = []

    def relate(one, kind, other):
        relations.append({"spdxElementId": one, "relationshipType": kind, "relatedSpdxElement": other})

    for part in LICENCES:
        if not any(re.search(part, path.name) for path in artifacts):
            sys.exit(f"list_contents.py: no file of the release has '{part}' in its name")
    relate("SPDXRef-DOCUMENT", "DESCRIBES", "SPDXRef-pcl-ext")
    files = []
    for number, name in enumerate(sources):
        files.append(file_entry(f"SPDXRef-source-{number}", f"source/{name}", ROOT / name))
        relate("SPDXRef-pcl-ext", "CONTAINS", files[-1]["SPDXID"])
    packages[0] |= {
        "filesAnalyzed": True,
        "packageVerificationCode": verification_code(files),
        "licenseInfoFromFiles": ["NOASSERTION"],
    }
    for number, path in enumerate(artifacts):
        name = path.relative_to(folder).as_posix()
        files.append(file_entry(f"SPDXRef-file-{number}", name, path, licence_of(name)))
        relate(files[-1]["SPDXID"], "GENERATED_FROM", "SPDXRef-pcl-ext")
    for kind, libraries in (("STATIC_LINK", COMPILED_IN), ("DYNAMIC_LINK", LINKED_WITH)):
        for debian, (name, licence) in libraries.items():
            identifier = "SPDXRef-debian-" + debian.replace("+", "x")
            packages.append(package(identifier, name, debian_version(debian), licence))
            relate("SPDXRef-pcl-ext", kind, identifier)
    for number, (name, of, licence) in enumerate(npm_packages()):
        packages.append(package(f"SPDXRef-npm-{number}", name, of, licence))
        relate("SPDXRef-pcl-ext", "DEPENDS_ON", f"SPDXRef-npm-{number}")
    time = datetime.datetime.fromtimestamp(
        int(os.environ["SOURCE_DATE_EPOCH"]), datetime.timezone.utc)
    document = {
        "spdxVersion": "SPDX-2.3",
        "dataLicense": "CC0-1.0",
        "SPDXID": "SPDXRef-DOCUMENT",
        "name": f"pcl_ext-{version}",
        "documentNamespace": f"https://pcl-ext.example/spdx/{version}/{digest(folder / f'pcl_ext-{version}.tar.gz')}",
        "creationInfo": {
            "created": time.strftime("%Y-%m-%dT%H:%M:%SZ"),
            "creators": ["Tool: pcl_ext/tools/list_contents.py"],
        },
        "packages": packages,
        "files": files,
        "relationships": relations,
    }
    (folder / "contents.spdx.json").write_text(json.dumps(document, indent=1) + "\n")


main(sys.argv[1], pathlib.Path(sys.argv[2]))
