import type { Codec, Decoder, DecoderLimits, Status } from "@pcl_ext/codec";

import type { PackedPoints } from "./messages";
import { packPoints } from "./packed_points";

const mostRecent = 8;
const mostRecentBytes = 2 ** 26;

/** The points of a frame, or why there are none. */
export type Decoded =
  | { readonly points: PackedPoints; readonly status: null }
  | { readonly points: null; readonly status: Pick<Status, "code" | "message"> };

/** Decodes the frames of a topic in whatever order they come.
 *
 * A frame is decoded if it depends on none, or on the very one that was decoded last: a P-frame has a checksum over that
 * of its reference, and so over all frames back to the I-frame, which the decoder verifies. Thus frames of a place in the
 * recording that was left, of another consumer's place, or of another stream with the same numbers are not decoded, and
 * do not disturb those that follow the last one.
 */
export class TopicDecoder {
  private decoder: Decoder;
  private readonly limits: DecoderLimits;
  /** The last frames, as each panel that shows a topic has its messages converted. */
  private readonly recent: { frame: Uint8Array; points: PackedPoints }[] = [];

  constructor(private readonly codec: Codec) {
    this.limits = codec.recordingLimits(Infinity);
    this.decoder = codec.createDecoder(this.limits);
  }

  decode(frame: Uint8Array): Decoded {
    const known = this.recent.find((other) => areEqual(other.frame, frame));
    if (known) return { points: known.points, status: null };
    const { status, description } = this.codec.describeFrame(frame, this.limits);
    if (!description) return { points: null, status };
    if (description.format === "published" && description.kind === "P")
      return { points: null, status: { code: "UnsupportedVersion", message: noPublishedPFrames } };
    let result = this.decoder.decode(frame, { coded: true });
    if (result.status.code === "OldFrame" && description.kind === "I") {
      this.decoder.free();
      this.decoder = this.codec.createDecoder(this.limits);
      result = this.decoder.decode(frame, { coded: true });
    }
    if (!result.voxels) return { points: null, status: result.status };
    const points = packPoints(result.voxels, this.decoder);
    if (!points) return { points: null, status: { code: "OutOfMemory", message: "out of memory" } };
    this.remember(frame, points);
    return { points, status: null };
  }

  private remember(frame: Uint8Array, points: PackedPoints): void {
    // A copy, as the bytes may be part of a much larger chunk of the recording.
    this.recent.unshift({ frame: frame.slice(), points });
    let bytes = 0;
    const isKept = (entry: { points: PackedPoints }, i: number): boolean => {
      bytes += entry.points.data.length;
      return i === 0 || (i < mostRecent && bytes <= mostRecentBytes);
    };
    this.recent.splice(0, Infinity, ...this.recent.filter(isKept));
  }
}

const noPublishedPFrames =
  "P-frames of the published layout have no checksum, so that one may be taken for that of another stream; only I-frames " +
  "are shown. Encode the clouds with stream version 1";

function areEqual(a: Uint8Array, b: Uint8Array): boolean {
  return a.length === b.length && a.every((byte, i) => byte === b[i]);
}
