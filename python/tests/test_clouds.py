# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""What other packages make of decoded clouds."""

import pickle
import sys

import numpy as np
import pytest

import pcl_ext
from pcl_ext.plotting import colours_of, plot_sizes


@pytest.fixture
def coloured(room, random):
    """A decoded cloud with all kinds of columns."""
    points = np.zeros(
        len(room),
        [*((axis, "f4") for axis in "xyz"), *((channel, "u1") for channel in "rgb"),
         ("ring", "u2"), ("normal", "f4", 3), ("normal_1", "i1"), ("positions", "f8")])
    for axis in range(3):
        points["xyz"[axis]] = room[:, axis]
    for name in "rgb":
        points[name] = random.integers(0, 256, len(room))
    points["ring"] = random.integers(0, 300, len(room))
    points["normal"] = random.uniform(-1, 1, (len(room), 3))
    points["positions"] = random.uniform(0, 1, len(room))
    fields = ["ring", "normal", "normal_1", "positions"]
    frame = pcl_ext.Encoder(0.1, law="count", fields=fields).encode(points)
    return pcl_ext.Decoder().decode(frame)


@pytest.fixture
def organised():
    """An image of 3 rows and 4 columns, of whose points 2 are missing."""
    points = np.zeros((3, 4), [("x", "f4"), ("y", "f4"), ("z", "f4"), ("ring", "u2")])
    points["x"], points["y"] = np.meshgrid(range(4), range(3))
    points["ring"] = points["y"]
    points["z"][1, 2:] = np.nan
    return pcl_ext.Cloud(points)


def test_a_cloud_is_an_array(coloured):
    assert type(coloured) is pcl_ext.Cloud and coloured.dtype.names[:4] == (*"xyz", "intensity")
    near = coloured[coloured["z"] < 1]
    assert type(near) is pcl_ext.Cloud and 0 < len(near) < len(coloured)
    assert type(coloured["z"]) is type(coloured["normal"]) is np.ndarray
    coloured["z"] += 1
    np.testing.assert_array_equal(coloured["z"], pcl_ext.positions(coloured)[:, 2])
    copied = pickle.loads(pickle.dumps(coloured))
    assert type(copied) is pcl_ext.Cloud
    np.testing.assert_array_equal(copied, coloured)
    assert len(pcl_ext.Encoder(0.1, fields="all").encode(coloured)) > 0
    plain = np.asarray(coloured)
    assert type(plain) is np.ndarray and np.shares_memory(pcl_ext.Cloud(plain), plain)
    with pytest.raises(TypeError, match="no fields x, y, z"):
        pcl_ext.Cloud(np.zeros((3, 3)))


def test_a_table_of_pandas(coloured):
    table = coloured.to_pandas()
    assert list(table.columns) == [
        *"xyz", "intensity", *"rgb", "ring",
        "normal_0", "normal_1", "normal_2", "normal_1_", "positions"]
    wanted = ["f4"] * 4 + ["u1"] * 3 + ["u2"] + ["f4"] * 3 + ["i1", "f8"]
    assert list(table.dtypes) == [np.dtype(kind) for kind in wanted]
    for name in (*"xyz", "intensity", *"rgb", "ring", "positions"):
        np.testing.assert_array_equal(table[name], coloured[name])
    for place in range(3):
        np.testing.assert_array_equal(table[f"normal_{place}"], coloured["normal"][:, place])
    table["x"] += 1
    assert table["x"][0] == coloured["x"][0] + 1
    empty = coloured[:0].to_pandas()
    assert len(empty) == 0 and list(empty.dtypes) == list(table.dtypes)


def test_a_table_of_rows_and_columns(organised):
    table = organised.to_pandas()
    np.testing.assert_array_equal(table["y"], np.repeat(range(3), 4))
    assert list(np.flatnonzero(table["z"].isna())) == [6, 7]


def test_a_cloud_of_open3d(coloured, organised):
    open3d = pytest.importorskip("open3d")
    made = coloured.to_open3d()
    assert type(made) is open3d.t.geometry.PointCloud
    values = {name: value.numpy() for name, value in made.point.items()}
    expected = {
        "positions": pcl_ext.positions(coloured),
        "colors": np.stack([coloured[name] for name in "rgb"], axis=1),
        "normal": coloured["normal"],
        "intensity": coloured["intensity"][:, None],
        "ring": coloured["ring"][:, None],
        "normal_1": coloured["normal_1"][:, None],
        "positions_": coloured["positions"][:, None],
    }
    assert values.keys() == expected.keys()
    for name, value in values.items():
        assert value.dtype == expected[name].dtype
        np.testing.assert_array_equal(value, expected[name])
    drawn = made.to_legacy()
    np.testing.assert_allclose(np.asarray(drawn.colors), expected["colors"] / 255)
    assert not np.shares_memory(values["positions"], coloured)
    empty = coloured[:0].to_open3d()
    assert empty.point["normal"].shape == open3d.core.SizeVector([0, 3])
    made = organised.to_open3d()
    np.testing.assert_array_equal(made.point["ring"].numpy().T, [[0] * 4 + [1] * 2 + [2] * 4])


def test_names_of_several_letters_become_attributes_of_open3d():
    pytest.importorskip("open3d")
    points = np.zeros(2, [(name, "f4") for name in ("x", "y", "z", "xy", "gb")])
    assert {"xy", "gb"} <= set(points.view(pcl_ext.Cloud).to_open3d().point)


def test_coordinates_of_maps_keep_their_precision(room):
    far = room.astype("f8") + (500000, 5400000, 300)
    cloud = pcl_ext.Decoder().decode(pcl_ext.Encoder(0.1, law="none").encode(far))
    assert list(cloud.to_pandas().dtypes) == [np.dtype("f8")] * 3
    open3d = pytest.importorskip("open3d")
    assert cloud.to_open3d().point["positions"].dtype == open3d.core.float64


def test_views_with_other_fields_are_no_clouds(coloured):
    bytes_of_it = np.ascontiguousarray(coloured).view("u1")
    for call in (pcl_ext.Cloud.to_pandas, pcl_ext.Cloud.to_open3d, pcl_ext.Cloud.plot):
        with pytest.raises(TypeError, match="no fields x, y, z"):
            call(bytes_of_it.view(pcl_ext.Cloud))


@pytest.mark.parametrize(
    "package, call",
    [("pandas", pcl_ext.Cloud.to_pandas), ("open3d", pcl_ext.Cloud.to_open3d),
     ("matplotlib", pcl_ext.Cloud.plot)])
def test_packages_that_are_missing(coloured, monkeypatch, package, call):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(ImportError, match=f"pip install {package}.*python3-{package}"):
        call(coloured)


def test_a_plot(coloured, organised):
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    axes = coloured.plot()
    (points,) = axes.collections
    assert len(points.get_offsets()) == len(coloured)
    colours = points.get_facecolors()[:, :3]
    assert len(np.unique(colours, axis=0)) > 500
    mine = pyplot.figure().add_subplot(projection="3d")
    assert organised.plot(mine) is mine
    assert len(mine.collections[0].get_offsets()) == 10
    coloured[:0].plot(mine)
    with pytest.raises(TypeError, match="projection"):
        coloured.plot(pyplot.figure().add_subplot())
    bars = plot_sizes([300, 20, 40], 1).patches
    assert [bar.get_height() for bar in bars] == [300, 20, 40, 20]
    assert bars[3].get_facecolor() != bars[1].get_facecolor()
    pyplot.close("all")


def test_colours():
    points = np.zeros(4, [("x", "f4"), ("y", "f4"), ("z", "f4")])
    points["z"] = range(4)
    np.testing.assert_array_equal(colours_of(points), range(4))
    coloured = np.zeros(1, [("z", "f4"), ("r", "u1"), ("g", "u1"), ("b", "u1")])
    coloured["g"] = 255
    np.testing.assert_array_equal(colours_of(coloured), [[0, 1, 0]])
    # Those without an intensity are shown, too.
    points = np.array([(-20.0,), (-5.0,), (np.nan,), (np.inf,)], [("intensity", "f4")])
    np.testing.assert_allclose(colours_of(points), [-20, -5, -20, 1e-6])
    np.testing.assert_array_equal(colours_of(points[2:3]), [0])
    # Reflectances that are called so.
    fields = np.zeros(1, [("z", "f4"), ("r", "f4"), ("g", "f4"), ("b", "f4")])
    np.testing.assert_array_equal(colours_of(fields), [0])
