# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""What the package has is what its documentation and its stubs say."""

import ast
import copy
import doctest
import inspect
import pathlib
import pickle
import re

import pytest

import pcl_ext
from pcl_ext import _native

PACKAGE = pathlib.Path(pcl_ext.__file__).parent


def public_objects():
    for name in pcl_ext.__all__:
        thing = getattr(pcl_ext, name)
        if name == "__version__":
            continue
        yield name, thing
        if inspect.isclass(thing):
            for member, value in vars(thing).items():
                if not member.startswith("_") and (callable(value) or isinstance(value, property)):
                    yield f"{name}.{member}", value


def test_names():
    public = {
        name
        for name, value in vars(pcl_ext).items()
        if not name.startswith("_") and not inspect.ismodule(value)
    }
    assert public == set(pcl_ext.__all__) - {"__version__"}
    assert pcl_ext.__all__ == sorted(pcl_ext.__all__)


def test_everything_is_documented():
    for name, thing in public_objects():
        assert inspect.getdoc(thing), name


@pytest.mark.parametrize("name, thing", public_objects())
def test_parameters_are_documented_and_annotated(name, thing):
    if not callable(thing):
        return
    if inspect.isclass(thing) and issubclass(thing, (tuple, Exception)):
        assert inspect.getdoc(thing) != thing.__name__
        return
    parameters = dict(inspect.signature(thing).parameters)
    parameters.pop("self", None)
    doc = inspect.getdoc(thing)
    documented = re.findall(
        r"^(\w[\w, ]*) : ",
        doc.partition("Parameters\n---")[2].partition("Returns\n---")[0],
        re.M,
    )
    documented = [one for line in documented for one in line.split(", ")]
    assert sorted(documented) == sorted(parameters), name
    for parameter in parameters.values():
        assert parameter.annotation is not inspect.Parameter.empty, name
    if not inspect.isclass(thing):
        assert inspect.signature(thing).return_annotation is not inspect.Signature.empty


def of_stub():
    """Functions of the stub and their parameters."""
    found = {}
    for node in ast.parse((PACKAGE / "_native.pyi").read_text()).body:
        if isinstance(node, ast.FunctionDef):
            found[node.name] = [argument.arg for argument in node.args.args]
        elif isinstance(node, ast.ClassDef):
            for method in node.body:
                if isinstance(method, ast.FunctionDef):
                    found[f"{node.name}.{method.name}"] = [
                        argument.arg for argument in method.args.args
                    ]
        elif isinstance(node, ast.AnnAssign):
            found[node.target.id] = None
    return found


def parameters_of(function):
    """Of a function of pybind11, by the first line of its documentation."""
    arguments = function.__doc__.partition("(")[2].partition(") ->")[0]
    return re.findall(r"(\w+): ", arguments)


def of_module():
    found = {}
    for name, thing in vars(_native).items():
        if name.startswith("__"):
            continue
        if inspect.isclass(thing):
            for member, value in vars(thing).items():
                if callable(value) and (member == "__init__" or not member.startswith("_")):
                    found[f"{name}.{member}"] = parameters_of(value)
        else:
            found[name] = parameters_of(thing) if callable(thing) else None
    return found


def without_self(functions):
    return {
        name: parameters and [one for one in parameters if one not in ("self", "arg0")]
        for name, parameters in functions.items()
    }


def test_the_stub_is_that_of_the_module():
    assert without_self(of_stub()) == without_self(of_module())


def test_it_is_marked_as_typed():
    assert (PACKAGE / "py.typed").exists()


def test_examples_in_the_documentation():
    for module in (pcl_ext, pcl_ext.codec, pcl_ext.outliers, pcl_ext.recording_writer):
        assert doctest.testmod(module).failed == 0


def test_what_has_a_state_is_not_copied(tmp_path):
    path = tmp_path / "a.pcxi"
    path.write_bytes(pcl_ext.Encoder().encode([[0.0, 0.0, 0.0]]))
    for thing in (
        pcl_ext.Encoder(),
        pcl_ext.Decoder(),
        pcl_ext.OutlierRemoval(),
        pcl_ext.PointOutlierRemoval(),
        pcl_ext.TemporalVoxelFilter(),
        pcl_ext.open(path),
        pcl_ext.RecordingWriter(tmp_path / "b.pcxi"),
    ):
        for call in (copy.copy, copy.deepcopy, pickle.dumps):
            with pytest.raises(TypeError, match=f"this {type(thing).__name__}: make another one"):
                call(thing)


def test_codes_that_a_status_has_are_documented():
    source = (pathlib.Path(__file__).parents[1] / "src" / "code_names.cpp").read_text()
    of_codes, of_removals, of_filters, of_recordings = source.split("\ncodeName(")[1:]
    codes = set(re.findall(r'"(\w+)"', of_codes + of_removals + of_filters)) - {"unknown"}
    # What is raised, and what the filters of whole clouds have in C++.
    codes -= {"InvalidSettings", "InvalidInput", "OutputFailed", "LeftOut"}
    codes -= {"DifferentCloud", "InvalidCloud"}
    documented = re.findall(r'"(\w+)"', pcl_ext.Status.__doc__)
    assert sorted(documented) == sorted(codes)


def test_version():
    assert re.fullmatch(r"\d+\.\d+\.\d+", pcl_ext.__version__)


def test_statistics_have_all_fields_of_the_library():
    coding, cloud = _native.Encoder(
        {
            name: parameter.default
            for name, parameter in inspect.signature(pcl_ext.Encoder).parameters.items()
        }
    ).statistics()
    assert tuple(coding) == pcl_ext.FrameStatistics._fields
    assert tuple(cloud) == pcl_ext.CloudStatistics._fields
