"""No bytes make a decoder raise, crash or return what is no cloud."""

import numpy as np

import pcl_ext


def seeds(room, random):
    """Frames of all efforts and contents."""
    colour = random.integers(0, 256, (len(room), 3), dtype="u1")
    frames = []
    for settings, arguments in (
        ({"effort": "fast"}, ()),
        ({"effort": "balanced", "keep_points": True}, ()),
        ({"effort": "small"}, (None, colour)),
        ({"law": "quadratic", "sensor": "kinect_v2", "frame_id": "cell"}, ()),
        ({"law": "none"}, ()),
        ({"format": "published", "colour_bits": 0}, ()),
    ):
        encoder = pcl_ext.Encoder(0.2, **settings)
        frames.append(
            [encoder.encode(room, *arguments), encoder.encode(room, *arguments)]
        )
    return frames


def mutated(frame, random):
    data = np.frombuffer(frame, "u1").copy()
    kind = random.integers(5)
    place = random.integers(len(data))
    if kind == 0:
        data[place] ^= 1 << random.integers(8)
    elif kind == 1:
        data[random.integers(len(data), size=8)] = random.integers(0, 256, 8)
    elif kind == 2:
        data = data[:place]
    elif kind == 3:
        data = np.concatenate((data[place:], data[:place]))
    else:
        data[place : place + 4] = 255
    return data


def test_mutations(room, random):
    outcomes = {}
    streams = seeds(room, random)
    decoders = [pcl_ext.Decoder(max_voxels=1 << 14) for _ in streams]
    removal = pcl_ext.OutlierRemoval("voxels")
    for number in range(10000):
        stream = number % len(streams)
        decoder = decoders[stream]
        data = mutated(streams[stream][random.integers(2)], random)
        cloud = decoder.decode(data, outliers=removal, min_intensity=1.0)
        code = decoder.status.code
        outcomes[code] = outcomes.get(code, 0) + 1
        assert (cloud is None) == (code != "Ok")
        if cloud is None:
            assert decoder.status.message
        else:
            assert len(cloud) <= len(room)
            assert np.isfinite(pcl_ext.positions(cloud)).all()
        size = pcl_ext.frame_size(data)
        assert size.bytes >= 0
    assert outcomes["Corrupt"] > 1000 and outcomes["Truncated"] > 100
    # The decoders go on with the next I-frame.
    for decoder, frames in zip(decoders, streams):
        assert (
            decoder.decode(frames[0]) is not None or decoder.status.code == "OldFrame"
        )


def test_random_bytes(random):
    decoder = pcl_ext.Decoder()
    for size in (0, 1, 3, 4, 100, 10000):
        for _ in range(20):
            assert decoder.decode(random.bytes(size)) is None
            assert decoder.decode(b"PCXI" + random.bytes(size)) is None
            assert decoder.status.code != "Ok"
