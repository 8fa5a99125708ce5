# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Arrays of any type and layout: the same frame, or a clear error."""

import numpy as np
import pytest

import pcl_ext


def frame_of(*arguments, **settings):
    return pcl_ext.Encoder(0.1, **settings).encode(*arguments)


def in_wide_rows(xyz):
    wide = np.full((len(xyz), 8), np.nan, xyz.dtype)
    wide[:, 2:5] = xyz
    return wide[:, 2:5]


def every_other(xyz):
    return np.repeat(xyz, 2, axis=0)[::2]


def unaligned(xyz):
    memory = np.zeros(xyz.nbytes + 1, "u1")
    memory[1:] = np.frombuffer(xyz.tobytes(), "u1")
    return memory[1:].view(xyz.dtype).reshape(-1, 3)


def read_only(xyz):
    xyz = xyz.copy()
    xyz.flags.writeable = False
    return xyz


def structured(names, formats, offsets, itemsize):
    def make(xyz):
        dtype = np.dtype(
            {"names": names, "formats": formats, "offsets": offsets, "itemsize": itemsize}
        )
        points = np.zeros(len(xyz), dtype)
        for axis, name in enumerate("xyz"):
            points[name] = xyz[:, axis]
        return points

    return make


LAYOUTS = {
    "fortran": np.asfortranarray,
    "float64": lambda xyz: xyz.astype("f8"),
    "float64 in columns": lambda xyz: np.asfortranarray(xyz.astype("f8")),
    "big-endian": lambda xyz: xyz.astype(">f4"),
    "big-endian float64": lambda xyz: xyz.astype(">f8"),
    "part of rows": in_wide_rows,
    "every other row": every_other,
    "from last to first": lambda xyz: np.ascontiguousarray(xyz[::-1])[::-1],
    "axes from last to first": lambda xyz: np.ascontiguousarray(xyz[:, ::-1])[:, ::-1],
    "unaligned": unaligned,
    "read-only": read_only,
    "image": lambda xyz: xyz.reshape(50, -1, 3),
    "image in columns": lambda xyz: np.asfortranarray(xyz.reshape(50, -1, 3)),
    "list": lambda xyz: xyz.tolist(),
    "long double": lambda xyz: xyz.astype(np.longdouble),
    "fields": structured("xyz", ["f4"] * 3, [0, 4, 8], 12),
    "fields of 16 bytes": structured("xyz", ["f4"] * 3, [0, 4, 8], 16),
    "fields in another order": structured("xyz", ["f4"] * 3, [8, 0, 4], 12),
    "packed fields": structured("xyz", ["f4"] * 3, [1, 5, 9], 13),
    "mixed fields": structured("xyz", ["f8", "f4", ">f4"], [0, 8, 12], 16),
    "image of fields": lambda xyz: structured("xyz", ["f4"] * 3, [0, 4, 8], 12)(
        xyz
    ).reshape(50, -1),
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_layouts_have_the_same_frame(room, layout):
    assert frame_of(LAYOUTS[layout](room)) == frame_of(room)


@pytest.mark.parametrize(
    "type_of_number", ["u1", "u2", ">u2", "i1", "i4", "i8", "u8", "f2", "f8", ">f8"]
)
def test_types_of_intensity(room, random, type_of_number):
    intensity = random.integers(0, 128, len(room))
    expected = frame_of(room, intensity.astype("f4"))
    numbers = intensity.astype(type_of_number)
    assert frame_of(room, numbers) == expected
    assert frame_of(room, np.repeat(numbers, 2)[::2]) == expected
    assert frame_of(room, numbers[::-1].copy()[::-1]) == expected
    points = np.zeros(
        len(room),
        [("x", "f4"), ("intensity", type_of_number), ("y", "f4"), ("z", "f4")],
    )
    for axis, name in enumerate("xyz"):
        points[name] = room[:, axis]
    points["intensity"] = numbers
    assert frame_of(points) == expected
    # An argument goes before a field.
    points["intensity"] = 0
    assert frame_of(points, numbers) == expected


def test_an_intensity_beyond_floats_is_told():
    encoder = pcl_ext.Encoder(law="native")
    words = "1 of 2 points have an intensity that is not finite as a float"
    with pytest.warns(pcl_ext.CompressionWarning, match=words):
        encoder.encode(np.ones((2, 3)), np.array([1e300, 5]))


def test_column_of_a_matrix_as_intensity(room, random):
    """As a KITTI file: x, y, z and reflectance."""
    rows = np.column_stack((room, random.random(len(room), "f4")))
    expected = frame_of(room, rows[:, 3].copy())
    assert frame_of(rows[:, :3], rows[:, 3]) == expected


def test_images(room, random):
    intensity = random.integers(0, 256, len(room))
    colour = random.integers(0, 256, (len(room), 3), dtype="u1")
    expected = frame_of(room, intensity, colour)
    image = (50, len(room) // 50)
    assert (
        frame_of(room.reshape(*image, 3), intensity.reshape(image), colour.reshape(*image, 3))
        == expected
    )


def coloured(room, fields):
    points = np.zeros(len(room), [("x", "f4"), ("y", "f4"), ("z", "f4"), *fields])
    for axis, name in enumerate("xyz"):
        points[name] = room[:, axis]
    return points


def test_layouts_of_colours(room, random):
    colour = random.integers(0, 256, (len(room), 3), dtype="u1")
    expected = frame_of(room, None, colour)
    assert expected != frame_of(room)
    with_alpha = np.column_stack((colour, colour[:, 0]))
    assert frame_of(room, None, with_alpha) == expected
    assert frame_of(room, None, np.asfortranarray(colour)) == expected
    assert frame_of(room, None, colour[:, ::-1].copy()[:, ::-1]) == expected
    channels = coloured(room, [("b", "u1"), ("g", "u1"), ("r", "u1")])
    for channel, name in enumerate("rgb"):
        channels[name] = colour[:, channel]
    assert frame_of(channels) == expected
    packed = colour.astype("u4")
    packed = packed[:, 0] << np.uint32(16) | packed[:, 1] << np.uint32(8) | packed[:, 2]
    packed |= np.uint32(255 << 24)
    for name, type_of_field in (("rgb", "u4"), ("rgba", "u4"), ("rgb", "f4"), ("rgb", "i4")):
        points = coloured(room, [(name, type_of_field)])
        points[name] = packed.view(type_of_field)
        assert frame_of(points) == expected
        assert frame_of(points[::-1].copy()[::-1]) == expected
    # An argument goes before fields.
    assert frame_of(points, None, colour) == expected


def test_empty_clouds():
    empty = np.empty((0, 3), "f4")
    frame = frame_of(empty)
    for given in (
        empty.astype("f8"),
        np.empty((0, 5, 3)),
        np.empty(0, [("x", "f4"), ("y", "f4"), ("z", "f4")]),
    ):
        assert frame_of(given) == frame
    cloud = pcl_ext.Decoder().decode(frame)
    assert cloud.shape == (0,)
    # The fields are those of the stream's other frames.
    frame = frame_of(empty, np.empty(0), np.empty((0, 3), "u1"))
    assert pcl_ext.Decoder().decode(frame).dtype.names == (
        "x",
        "y",
        "z",
        "intensity",
        "r",
        "g",
        "b",
    )


def test_one_point_of_any_stride():
    expected = frame_of(np.full((1, 3), 0.5, "f4"))
    assert frame_of(np.broadcast_to(np.float32(0.5), (1, 3))) == expected
    assert frame_of(np.full((9, 3), 0.5, "f4")[::9]) == expected
    same = np.broadcast_to(np.float32(0.5), (4, 3))
    assert frame_of(same) == frame_of(same.copy())


def test_the_input_stays_as_it_is(room, random):
    copy = room.copy()
    intensity = random.random(len(room))
    intensity_copy = intensity.copy()
    frame_of(room, intensity)
    np.testing.assert_array_equal(room, copy)
    np.testing.assert_array_equal(intensity, intensity_copy)


def test_scratch_memory_of_larger_clouds_is_not_read_again(room):
    """Clouds of all sizes in one stream, copied into memory that is reused."""
    used = pcl_ext.Encoder(0.1, i_frame_rate=1, bounding_box=((-2, -2, 0), (2, 2, 3)))
    for count in (6500, 10, 0, 3000):
        new = pcl_ext.Encoder(0.1, i_frame_rate=1, bounding_box=((-2, -2, 0), (2, 2, 3)))
        decoded = pcl_ext.Decoder().decode(used.encode(np.asfortranarray(room[:count])))
        expected = pcl_ext.Decoder().decode(new.encode(room[:count]))
        np.testing.assert_array_equal(decoded, expected)


FIELDS = [("x", "f4"), ("y", "f4")]
BAD_CLOUDS = [
    (5, ValueError, r"xyz has shape \(\)"),
    (np.zeros(()), ValueError, r"xyz has shape \(\)"),
    (np.zeros(3), ValueError, r"xyz has shape \(3,\); it must be \(N, 3\)"),
    (np.zeros((5, 2)), ValueError, r"\(5, 2\)"),
    (np.zeros((5, 4)), ValueError, r"of more columns pass xyz\[:, :3\]"),
    (np.zeros((3, 5)), ValueError, r"\(3, 5\)"),
    (np.zeros((0,)), ValueError, r"\(0,\)"),
    (np.zeros((5, 3), int), TypeError, "xyz has dtype int64; it must be float32 or float64"),
    (np.zeros((5, 3), bool), TypeError, "dtype bool"),
    (np.zeros((5, 3), complex), TypeError, "dtype complex128"),
    (np.zeros((5, 3), "datetime64[s]"), TypeError, "dtype datetime64"),
    (np.ma.zeros((5, 3)), TypeError, r"masked array; pass xyz.filled\(value\)"),
    (np.array([{}]), TypeError, "dtype object"),
    ("a cloud", TypeError, "no array of numbers"),
    (b"a cloud", TypeError, "no array of numbers"),
    (None, TypeError, "no array of numbers"),
    ([[1, 2], [3]], TypeError, "numpy makes no array"),
    (np.zeros(5, FIELDS), ValueError, r"fields \('x', 'y'\); it must have x, y and z"),
    (np.zeros((), [*FIELDS, ("z", "f4")]), ValueError, "one record"),
    (np.zeros((2, 3, 4, 3)), ValueError, r"xyz has shape \(2, 3, 4, 3\); it must be \(N, 3\) or"),
    (np.zeros((2, 3, 4), [*FIELDS, ("z", "f4")]), ValueError, r"shape \(2, 3, 4\); a structured"),
    (np.zeros(5, [*FIELDS, ("z", "i4")]), TypeError, "the field z of xyz has dtype int32"),
    (np.zeros(5, [*FIELDS, ("z", "f4", 2)]), ValueError, "field z of xyz has several"),
    (
        np.zeros(5, [*FIELDS, ("z", "f4"), ("rgb", "f8")]),
        TypeError,
        "field rgb of xyz has dtype float64",
    ),
    (
        np.zeros(5, [*FIELDS, ("z", "f4"), ("rgb", ">u4")]),
        TypeError,
        "field rgb of xyz has dtype >u4",
    ),
    (
        np.zeros(5, [*FIELDS, ("z", "f4"), ("r", "f4"), ("g", "f4"), ("b", "f4")]),
        TypeError,
        "field r of xyz has dtype float32; it must be uint8",
    ),
]


@pytest.mark.parametrize("xyz, error, message", BAD_CLOUDS)
def test_bad_clouds(room, xyz, error, message):
    encoder = pcl_ext.Encoder(0.1)
    with pytest.raises(error, match=message) as raised:
        encoder.encode(xyz)
    assert "\n" not in str(raised.value)
    # The stream goes on as if there had been no call.
    assert encoder.encode(room) == frame_of(room)


BAD_ARGUMENTS = [
    (
        {"intensity": np.zeros(4)},
        ValueError,
        r"intensity has shape \(4,\); the cloud has shape \(5,\)",
    ),
    ({"intensity": np.zeros((5, 1))}, ValueError, r"\(5, 1\)"),
    ({"intensity": 1.0}, ValueError, r"shape \(\)"),
    ({"intensity": np.zeros(5, bool)}, TypeError, "intensity has dtype bool"),
    ({"intensity": np.zeros(5, complex)}, TypeError, "dtype complex128"),
    ({"intensity": ["a"] * 5}, TypeError, "intensity is no array of numbers"),
    ({"colour": np.zeros((5, 3))}, TypeError, "colour has dtype float64; it must be uint8"),
    ({"colour": np.zeros((4, 3), "u1")}, ValueError, r"colour has shape \(4, 3\)"),
    ({"colour": np.zeros((5, 2), "u1")}, ValueError, r"each point needs red, green and blue"),
    ({"colour": np.zeros((), "u1")}, ValueError, r"colour has shape \(\)"),
    ({"stamp": -1.0}, ValueError, "stamp is -1.0; it must be seconds"),
    ({"stamp": float("nan")}, ValueError, "stamp is nan"),
    ({"stamp": float("inf")}, ValueError, "stamp is inf"),
    ({"stamp": 1700000000000000000}, ValueError, "of nanoseconds pass"),
    ({"stamp": "noon"}, ValueError, "noon"),
    ({"stamp": "1"}, ValueError, "stamp is '1'; it must be seconds"),
    ({"stamp": 10**400}, ValueError, r"stamp is 10+\.\.\.0+; it must be seconds"),
    ({"sensor_pose": np.eye(3)}, ValueError, "sensor_pose must be an array of 4 x 4"),
    ({"sensor_pose": np.full((4, 4), np.nan)}, ValueError, "sensor_pose is not a rotation"),
    ({"sensor_pose": 2 * np.eye(4)}, ValueError, "sensor_pose is not a rotation"),
    ({"sensor_pose": -np.eye(4)}, ValueError, "sensor_pose is not a rotation"),
    ({"sensor_pose": "above"}, ValueError, "sensor_pose must be"),
]


@pytest.mark.parametrize("arguments, error, message", BAD_ARGUMENTS)
def test_bad_arguments(arguments, error, message):
    cloud = np.full((5, 3), 0.5)
    encoder = pcl_ext.Encoder(0.1)
    with pytest.raises(error, match=message):
        encoder.encode(cloud, **arguments)
    assert encoder.encode(cloud) == frame_of(cloud)


def test_intensity_and_law_must_agree(room):
    intensity = np.ones(len(room))
    counting = pcl_ext.Encoder(0.1, law="count")
    with pytest.raises(ValueError, match="law 'count' does not use"):
        counting.encode(room, intensity)
    native = pcl_ext.Encoder(0.1, law="native")
    with pytest.raises(ValueError, match="there is no intensity"):
        native.encode(room)
    native.encode(room[:0])
    automatic = pcl_ext.Encoder(0.1)
    assert automatic.law == "automatic"
    automatic.encode(room)
    assert automatic.law == "none"
    with pytest.raises(ValueError, match="law='native'"):
        automatic.encode(room, intensity)
    by_intensity = pcl_ext.Encoder(0.1)
    by_intensity.encode(room, intensity)
    assert by_intensity.law == "native"
    # A field may come along.
    points = np.zeros(10, [("x", "f4"), ("y", "f4"), ("z", "f4"), ("intensity", "f4")])
    assert counting.encode(points) == frame_of(np.zeros((10, 3)), law="count")
