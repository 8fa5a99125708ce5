# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Further fields of points: exact or rounded to a step, of points and of voxels."""

import re
import struct
import zlib

import numpy as np
import pytest

import pcl_ext

TYPES = ["i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8"]
BOX = ((-2, -2, 0), (2, 2, 3))


def with_fields(xyz, *fields, coordinate="f4"):
    """Points with a number of their own, which is their first field, and fields of zeros."""
    points = np.zeros(
        len(xyz),
        [*((name, coordinate) for name in "xyz"), ("number", "u4"), *fields],
    )
    for axis, name in enumerate("xyz"):
        points[name] = xyz[:, axis]
    points["number"] = np.arange(len(xyz))
    return points


def set_bits(points, random):
    """Sets any bits in all fields after the number, and special floats in points 0 to 4."""
    for name in points.dtype.names[4:]:
        numbers = points[name]
        size = numbers.dtype.itemsize
        bits = random.integers(0, 256, (*numbers.shape, size), "u1")
        numbers[...] = bits.view(numbers.dtype)[..., 0]
        if numbers.dtype.kind == "f":
            for point, special in enumerate((-0.0, np.inf, -np.inf, 0.0, np.nan)):
                numbers[point] = special
            numbers.view(f"u{size}")[4] += 77  # a payload


def code(points, resolution=0.1, **settings):
    frame = pcl_ext.Encoder(resolution, **settings).encode(points)
    return pcl_ext.Decoder().decode(frame)


def keep(points, fields="all", **settings):
    """The decoded points in the order of those that were encoded, each with its fields."""
    decoded = code(points, fields=fields, keep_points=True, **settings)
    return in_order(decoded)


def in_order(decoded):
    decoded = decoded[np.argsort(decoded["number"])]
    np.testing.assert_array_equal(decoded["number"], np.arange(len(decoded)))
    return decoded


def assert_same_bits(decoded, points, names):
    for name in names:
        assert decoded[name].dtype == points[name].dtype, name
        assert decoded[name].tobytes() == points[name].tobytes(), name


def test_all_types_and_shapes_are_kept_exactly(room, random):
    shapes = [("descriptor", "f4", (33,)), ("matrix", "i2", (2, 3)), ("one", "u1", (1,)),
              ("doubles", "f8", 2)]
    points = with_fields(room, *((f"of {kind}", kind) for kind in TYPES), *shapes)
    encoder = pcl_ext.Encoder(0.1, fields="all", keep_points=True)
    decoder = pcl_ext.Decoder()
    for number in range(4):
        set_bits(points, random)
        assert points["of f4"].view("u4")[[0, 4]].tolist() == [1 << 31, 0x7FC00000 + 77]
        decoded = in_order(decoder.decode(encoder.encode(points)))
        assert decoder.statistics.is_i_frame == (number == 0)
        assert decoded.dtype.names == points.dtype.names
        assert decoded.dtype["descriptor"] == np.dtype(("f4", (33,)))
        assert decoded.dtype["matrix"] == np.dtype(("i2", (6,)))
        assert decoded.dtype["one"] == np.dtype("u1")
        assert_same_bits(decoded, points, points.dtype.names[3:])
        for name in "xyz":
            assert np.abs(decoded[name] - points[name]).max() < 0.0501
    assert encoder.warning == ""


def test_the_most_values(room):
    decoded = keep(with_fields(room[:9], ("values", "u1", 4095)))
    assert decoded["values"].shape == (9, 4095)
    with pytest.raises(pcl_ext.Error, match="at most 64 with 4096 values"):
        code(with_fields(room[:9], ("values", "u1", 4096)), fields="all")
    more = with_fields(room[:9], ("values", "u1", 4097))
    with pytest.raises(pcl_ext.Error, match="'values' cannot be kept: .* 4097 .* 1 to 4096$"):
        code(more, fields=["number", "values"])
    with pytest.warns(pcl_ext.CompressionWarning, match=r"left out: values \(4,097 values a"):
        assert keep(more).dtype.names == ("x", "y", "z", "number")


def test_a_voxel_of_one_point_keeps_its_bits(random):
    fields = [*zip("abcd", TYPES[4:]), ("vector", "f4", (3,)), ("pair", "i4", (2,))]
    points = with_fields(np.arange(30.0).reshape(10, 3) + 0.03, *fields)
    set_bits(points, random)
    decoded = in_order(code(points, fields="all"))
    assert_same_bits(decoded, points, points.dtype.names[3:])


def test_ways_to_name_fields(room, random):
    points = with_fields(room, ("ring", "u1"), ("time", "f4"))
    points["ring"] = random.integers(0, 32, len(room))
    points["time"] = random.random(len(room), "f4")

    def frame_of(fields):
        return pcl_ext.Encoder(0.1, fields=fields).encode(points)

    with pytest.warns(pcl_ext.CompressionWarning, match="left out: number, time$"):
        expected = frame_of("ring")
    with pytest.warns(pcl_ext.CompressionWarning):
        assert frame_of(["ring"]) == frame_of([("ring", None)]) == expected
        assert frame_of({"ring": None}) == frame_of((("ring", 0),)) == expected
        # The last step of all is that of the field.
        both = frame_of(["ring", ("time", 1e-3)])
        assert frame_of({"ring": None, "time": 1e-3}) == both != frame_of(["ring", "time"])
        assert frame_of(()) == frame_of([]) == frame_of({}) == pcl_ext.Encoder(0.1).encode(points)
    everything = frame_of("all")
    assert everything == frame_of(["number", "ring", "time"]) == frame_of(["all"])
    assert frame_of([("time", 1e-3), "all"]) == frame_of([("time", 1e-3), "number", "ring"])


BAD_FIELDS = [
    (5, TypeError, r"fields is 5; it must be 'all', a name, a sequence of names and \("),
    (None, TypeError, "fields is None"),
    (b"ring", ValueError, "fields is b'ring'"),
    ([5], ValueError, r"fields is \[5\]"),
    (("ring", 0.5), ValueError, r"fields is \('ring', 0.5\)"),
    ([("ring", 1, 2)], ValueError, r"fields is \[\('ring', 1, 2\)\]"),
    ({5: None}, ValueError, "fields is {5: None}"),
    ({"ring": "fine"}, TypeError, "the step of 'ring' in fields is 'fine'; it must be a number"),
    ({"ring": True}, TypeError, "the step of 'ring' in fields is True"),
    ([("ring", -1)], ValueError, "fields: the step of 'ring' is -1; it must be a positive step"),
    ({"ring": np.nan}, ValueError, "fields: the step of 'ring' is nan"),
    ({"ring": np.inf}, ValueError, "fields: the step of 'ring' is inf"),
    (["ring", ("ring", 2)], ValueError, "fields has 'ring' twice; it must have each name once"),
    ({"all": 0.5}, ValueError, "fields: the step of 'all' is 0.5; it must be left out, as all means"),
]


@pytest.mark.parametrize("fields, error, message", BAD_FIELDS)
def test_bad_fields(fields, error, message):
    with pytest.raises(error, match=message) as raised:
        pcl_ext.Encoder(fields=fields)
    assert "\n" not in str(raised.value)


def test_a_field_that_is_missing(room):
    points = with_fields(room)
    encoder = pcl_ext.Encoder(0.1, fields="number")
    message = "no field 'number' to keep; it has: "
    with pytest.raises(pcl_ext.Error, match=message + "none") as raised:
        encoder.encode(room)
    assert raised.value.code == "InvalidInput"
    with pytest.raises(pcl_ext.Error, match=message + "'ring'$"):
        encoder.encode(np.zeros(5, [*((name, "f4") for name in "xyz"), ("ring", "u1")]))
    # The stream goes on as if there had been no call.
    assert encoder.encode(points) == pcl_ext.Encoder(0.1, fields="number").encode(points)


@pytest.mark.parametrize(
    "kind", ["i8", "u8", "?", ">f4", ">u2", "f2", "S3", "c8", "M8[s]", [("inner", "f4")]]
)
def test_types_that_cannot_be_kept(room, kind):
    points = with_fields(room, ("other", kind), ("ring", "u1"), ("others", kind, 2))
    encoder = pcl_ext.Encoder(0.1, fields="all")
    demand = "must be one of int8, .*float64, in the machine's byte order: convert it"
    with pytest.warns(pcl_ext.CompressionWarning) as warned:
        frame = encoder.encode(points)
    (words,) = (str(warning.message) for warning in warned)
    of_type = re.escape(str(points.dtype["other"]))
    pattern = rf"left out: other \(of {of_type}\), others \(of {of_type}\); a type {demand}"
    assert re.search(pattern, words)
    names = pcl_ext.Decoder().decode(frame).dtype.names
    assert names == ("x", "y", "z", "number", "ring")
    pattern = f"field 'other' cannot be kept: its type is {of_type}; it {demand}"
    with pytest.raises(pcl_ext.Error, match=pattern) as raised:
        code(points, fields="other")
    assert raised.value.code == "InvalidInput"


def test_channels_that_are_no_colour(room):
    points = with_fields(room, ("r", "u1"), ("g", "u1"))
    with pytest.warns(pcl_ext.CompressionWarning, match="left out: number, r, g$"):
        pcl_ext.Encoder(0.1).encode(points)


def test_a_field_of_no_values(room):
    points = with_fields(room, ("nothing", "f4", (0,)))
    with pytest.warns(pcl_ext.CompressionWarning, match=r"left out: nothing \(0 values"):
        assert code(points, fields="all").dtype.names == ("x", "y", "z", "number")


def test_other_arrays_have_no_fields(room):
    assert pcl_ext.Encoder(0.1, fields="all").encode(room) == pcl_ext.Encoder(0.1).encode(room)


def backwards(points):
    return points[::-1].copy()[::-1]


def every_other(points):
    return np.repeat(points, 2)[::2]


def unaligned(points):
    dtype = np.dtype(points.dtype.descr)
    memory = np.zeros(points.nbytes + 1, "u1")
    memory[1:] = np.frombuffer(points.tobytes(), "u1")
    return memory[1:].view(dtype)


def in_another_layout(points):
    names = sorted(points.dtype.names)
    offsets = 3 + np.cumsum([0] + [points.dtype[name].itemsize + 1 for name in names])
    dtype = {
        "names": list(points.dtype.names),
        "formats": [points.dtype[name] for name in points.dtype.names],
        "offsets": [int(offsets[names.index(name)]) for name in points.dtype.names],
        "itemsize": int(offsets[-1]) + 7,
    }
    return points.astype(np.dtype(dtype))


LAYOUTS = {
    "from last to first": backwards,
    "every other": every_other,
    "every other from last to first": lambda points: backwards(every_other(points)),
    "unaligned": unaligned,
    "another layout": in_another_layout,
    "image": lambda points: points.reshape(50, -1),
    "image in columns": lambda points: np.asfortranarray(points.reshape(50, -1)),
    "image from last to first": lambda points: backwards(points).reshape(50, -1),
    "read-only": lambda points: np.frombuffer(points.tobytes(), points.dtype),
    "recarray": lambda points: points.view(np.recarray),
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_layouts_have_the_same_frame(room, random, layout):
    fields = [("vector", "f4", (3,)), ("time", "f8"), ("ring", "u1"), ("range", "f4")]
    points = with_fields(room, *fields)
    set_bits(points, random)
    settings = {"fields": "all", "keep_points": True}
    given = LAYOUTS[layout](points)
    expected = pcl_ext.Encoder(0.1, **settings).encode(points.reshape(given.shape))
    copy = given.tobytes()
    assert pcl_ext.Encoder(0.1, **settings).encode(given) == expected
    assert given.tobytes() == copy


def test_strides_of_zero_and_of_one_point(room, random):
    points = with_fields(room[:5], ("time", "f8"))
    set_bits(points, random)
    for given in (np.broadcast_to(points[:1], (7,)), points[4:5][::-1], points[::-3][:1]):
        assert pcl_ext.Encoder(0.1, fields="all").encode(given) == pcl_ext.Encoder(
            0.1, fields="all"
        ).encode(given.copy())


def test_memory_of_larger_clouds_is_not_read_again(room, random):
    """Clouds of all sizes in one stream, copied into memory that is reused."""
    settings = {"i_frame_rate": 1, "bounding_box": BOX, "fields": "all", "keep_points": True}
    used = pcl_ext.Encoder(0.1, **settings)
    for count in (3000, 10, 0, 1, 6500):
        points = with_fields(room[:count], ("time", "f8"), ("pair", "i2", 2))
        points["time"] = random.random(count)
        points["pair"] = random.integers(-9, 9, (count, 2))
        decoded = pcl_ext.Decoder().decode(used.encode(backwards(points)))
        assert_same_bits(in_order(decoded), points, ["time", "pair"])


def test_a_field_takes_the_place_of_the_intensity(room, random):
    points = with_fields(room, ("intensity", "f4"))
    points["intensity"] = random.random(len(room)) * 1000
    decoded = keep(points)
    assert decoded.dtype.names == ("x", "y", "z", "number", "intensity")
    assert_same_bits(decoded, points, ["intensity"])
    # Without the field it is the voxel's.
    voxels = code(points, fields="number", keep_points=True)
    assert voxels.dtype.names == ("x", "y", "z", "intensity", "number")
    assert not np.isin(voxels["intensity"], points["intensity"]).all()


def test_colours(room, random):
    channels = ["r", "g", "b"]
    points = with_fields(room, *((name, "u1") for name in channels))
    for name in channels:
        points[name] = random.integers(0, 256, len(room))
    xyz = ("x", "y", "z")
    # The stream has a colour of each voxel already.
    decoded = keep(points)
    assert decoded.dtype.names == (*xyz, *channels, "number")
    assert (decoded["r"] != points["r"]).any()
    # Unless it is not kept there, or the points' own are named.
    decoded = keep(points, colour_bits=0)
    assert decoded.dtype.names == (*xyz, "number", *channels)
    assert_same_bits(decoded, points, channels)
    decoded = keep(points, ["number", *channels])
    assert decoded.dtype.names == (*xyz, "number", *channels)
    assert_same_bits(decoded, points, channels)
    decoded = keep(points, ["number", "g"])
    assert decoded.dtype.names == (*xyz, "r", "b", "number", "g")
    assert_same_bits(decoded, points, ["g"])


def test_packed_colours(room, random):
    points = with_fields(room, ("rgb", "u4"))
    points["rgb"] = random.integers(0, 1 << 24, len(room))
    assert keep(points).dtype.names == ("x", "y", "z", "r", "g", "b", "number")
    both = with_fields(room, ("rgb", "u4"), ("rgba", "u4"))
    with pytest.warns(pcl_ext.CompressionWarning, match="left out: rgba$"):
        assert keep(both).dtype.names == ("x", "y", "z", "r", "g", "b", "number")
    decoded = keep(points, colour_bits=0)
    assert decoded.dtype.names == ("x", "y", "z", "number", "rgb")
    assert_same_bits(decoded, points, ["rgb"])


def test_names_of_other_scripts(room):
    name = "Zeit in µs 時"
    points = with_fields(room[:20], (name, "u2"))
    points[name] = np.arange(20)
    assert_same_bits(keep(points, ["number", name]), points, [name])
    long_name = "µ" * 33
    points = with_fields(room[:20], (long_name, "u2"))
    with pytest.raises(pcl_ext.Error, match="its name has 66 bytes; it must have 1 to 64$"):
        code(points, fields=["number", long_name])
    reason = r"its name has 66 b"
    with pytest.warns(pcl_ext.CompressionWarning, match=rf"left out: {long_name} \({reason}"):
        assert keep(points).dtype.names == ("x", "y", "z", "number")
    with pytest.warns(pcl_ext.CompressionWarning, match=r"left out: '' \(its name has 0 bytes"):
        nameless = {"names": [*"xyz", ""], "formats": 4 * ["f4"]}
        assert code(np.zeros(5, nameless), fields="all").dtype.names == ("x", "y", "z")
    # What has no UTF-8 is no reason to refuse a cloud.
    odd = keep(with_fields(room[:20], ("\udc80", "u2")))
    assert odd.dtype.names == ("x", "y", "z", "number", "?")


def renamed(frame, old, new):
    """An I-frame with another name of the same length, as another writer may have made it."""
    assert frame.count(old) == 1 and len(old) == len(new)
    content = frame.replace(old, new)[9:]
    return frame[:5] + struct.pack("<I", zlib.crc32(bytes(4) + content)) + content


def test_names_that_are_taken(room):
    fields = [("Q", "u1"), ("first", "u1"), ("other", "u2"), ("third", "i1"), ("again", "u1")]
    points = with_fields(room[:20], *fields)
    points["Q"] = np.arange(20)
    points["other"] = 1000 + np.arange(20)
    points["third"] = -np.arange(20)
    points["again"] = 100 + np.arange(20)
    frame = pcl_ext.Encoder(0.1, fields="all", keep_points=True).encode(points)
    decoder = pcl_ext.Decoder()
    names = [(b"\1Q", b"\1x"), (b"third", b"fir\xffd"), (b"other", b"first"), (b"again", b"first")]
    for old, new in names:
        frame = renamed(frame, old, new)
    decoded = decoder.decode(frame)
    assert decoder.status.code == "Ok"
    decoded = in_order(decoded)
    assert decoded.dtype.names[3:] == ("number", "x_", "first", "first_", "fir\ufffdd", "first__")
    np.testing.assert_array_equal(decoded["x_"], points["Q"])
    np.testing.assert_array_equal(decoded["first_"], points["other"])
    np.testing.assert_array_equal(decoded["first__"], points["again"])
    np.testing.assert_array_equal(decoded["fir\ufffdd"], points["third"])
    assert np.abs(decoded["x"] - points["x"]).max() < 0.0501


def test_values_are_aligned(room, random):
    points = with_fields(room, ("a", "u1"), ("b", "f8"), ("c", "i2", 3), ("d", "f4"), ("e", "i1"))
    set_bits(points, random)
    decoded = keep(points)
    assert decoded.flags.aligned
    for name, (kind, offset) in decoded.dtype.fields.items():
        assert offset % kind.base.itemsize == 0, name
    assert decoded.dtype.itemsize % 8 == 0
    assert pcl_ext.positions(decoded).shape == (len(room), 3)
    np.testing.assert_array_equal(pcl_ext.positions(decoded)[:, 2], decoded["z"])


def test_decoded_clouds_can_be_encoded_again(room, random):
    points = with_fields(room, ("ring", "u1"), ("intensity", "f4"), ("vector", "f4", 3))
    set_bits(points, random)
    points["intensity"] = random.random(len(room))
    decoded = keep(points)
    again = keep(decoded)
    assert again.dtype == decoded.dtype
    assert_same_bits(again, points, ["ring", "intensity", "vector"])


def test_limits(room):
    points = with_fields(room, ("vector", "f4", 3))
    frame = pcl_ext.Encoder(0.1, fields="all", keep_points=True).encode(points)
    values = 4 * len(points)
    assert pcl_ext.Decoder(max_field_values=values).decode(frame) is not None
    decoder = pcl_ext.Decoder(max_field_values=values - 1)
    assert decoder.decode(frame) is None
    assert decoder.status.code == "LimitExceeded"
    assert f"{values} values of fields exceed the limit" in decoder.status.message


def test_recordings(room, random, tmp_path):
    path = tmp_path / "lidar.mcap"
    points = with_fields(room, ("time", "f8"), ("vector", "f4", 3))
    points["time"] = random.random(len(room))
    encoder = pcl_ext.Encoder(
        0.1,
        bounding_box=BOX,
        fields=["number", ("time", 0.5), "vector"],
        keep_points=True,
    )
    with pcl_ext.RecordingWriter(path) as writer:
        stream = writer.add_stream("/lidar")
        for number in range(3):
            writer.append(stream, encoder.encode(points), time=number)
    with pcl_ext.open(path) as recording:
        first, second, third = recording
        assert first.fields == (
            pcl_ext.FrameField("number", "uint32", 1, 0.0),
            ("time", "float64", 1, 0.5),
            ("vector", "float32", 3, 0.0),
        )
        assert second.fields == third.fields == ()
        decoded = in_order(recording.frame("/lidar", 2))
        assert_same_bits(decoded, points, ["vector"])
        assert np.abs(decoded["time"] - points["time"]).max() <= 0.25
    with pcl_ext.open(path, max_field_values=5 * len(room) - 1) as recording:
        assert recording.frame("/lidar", 0) is None
        assert recording.status.code == "LimitExceeded"
    with pytest.raises(ValueError, match="max_field_values is 0"):
        pcl_ext.open(path, max_field_values=0)
