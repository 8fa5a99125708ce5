// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { Codec, type Decoder, type StatusCode, type Voxels } from "@pcl_ext/codec";

import type { CompressedCloud, PackedPoints, PointCloud } from "./messages";
import { packPoints } from "./packed_points";
import type { RecentClouds } from "./recent_clouds";

interface Problem {
  readonly code: StatusCode | "FurtherBytes";
  readonly message: string;
}

/** The points of a frame, or null; why there are none, or what is not shown of the bytes. */
export interface Decoded {
  readonly points: PackedPoints | null;
  readonly problem: Problem | null;
}

/** Decodes the frames of a topic in whatever order they come.
 *
 * A frame is decoded if it depends on none, or on the very one that was decoded last: a P-frame has a checksum over that
 * of its reference, and so over all frames back to the I-frame, which the decoder verifies. Thus frames of a place in the
 * recording that was left, of another consumer's place, or of another stream with the same numbers are not decoded, and
 * do not disturb those that follow the last one.
 */
export class TopicDecoder {
  /** Of the topic alone, so that it has a memory of its own, and what exhausts that disturbs no other topic. */
  private readonly codec: Codec;
  private decoder: Decoder;

  /** @throws RangeError if there is no memory for it */
  constructor(
    module: WebAssembly.Module,
    private readonly recent: RecentClouds,
  ) {
    this.codec = Codec.loadNow(module);
    this.decoder = this.codec.createDecoder();
  }

  /** @throws RangeError if there is no memory for the points */
  decode({ compressed_data: bytes, header }: CompressedCloud): Decoded {
    const known = this.recent.find(this, bytes);
    if (known) return { points: known, problem: null };
    const { status, description } = this.codec.describeFrame(bytes);
    if (!description) return { points: null, problem: status };
    if (description.format === "published" && description.kind === "P")
      return { points: null, problem: { code: "UnsupportedVersion", message: noPublishedPFrames } };
    let result = this.decoder.decode(bytes, { coded: true });
    if (result.status.code === "OldFrame" && description.kind === "I") {
      this.decoder.free();
      this.decoder = this.codec.createDecoder();
      result = this.decoder.decode(bytes, { coded: true });
    }
    if (!result.voxels) return { points: null, problem: result.status };
    const points = packPoints(result.voxels, this.decoder);
    if (!points) return { points: null, problem: { code: "OutOfMemory", message: "out of memory" } };
    this.recent.remember(this, bytes, points, header);
    return { points, problem: furtherBytes(bytes, result.voxels) };
  }

  /** The cloud that was decoded last, with its own time. */
  last(): PointCloud | null {
    return this.recent.last(this);
  }
}

const noPublishedPFrames =
  "P-frames of the published layout have no checksum, so that one may be taken for that of another stream; only I-frames " +
  "are shown. Encode the clouds with stream version 1";

/** As the nodes do, only the first frame of a message is decoded; they do not say so. */
function furtherBytes(bytes: Uint8Array, frame: Voxels): Problem | null {
  if (bytes.length === frame.bytes) return null;
  return { code: "FurtherBytes", message: "a message has bytes beside its first frame, which are not shown" };
}
