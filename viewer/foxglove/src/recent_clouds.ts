// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { cloudOf, type Header, type PackedPoints, type PointCloud } from "./messages";

const mostOfTopic = 8;
const mostBytes = 2 ** 28;

interface RecentCloud {
  /** Of whom the frame is. */
  readonly owner: object;
  readonly frame: Uint8Array;
  readonly points: PackedPoints;
  /** Of its message when it was decoded. */
  readonly header: Header;
  /** Of frame and points when they were decoded. */
  readonly bytes: number;
}

/** The last clouds of all topics, as each panel that shows a topic has its messages converted. They are bounded by
 * their number for each topic, and by their bytes for all topics together. */
export class RecentClouds {
  /** From the oldest to the newest. */
  private clouds: RecentCloud[] = [];

  /** The points of a frame that is among the last ones of its owner. */
  find(owner: object, frame: Uint8Array): PackedPoints | null {
    const found = this.clouds.find((cloud) => cloud.owner === owner && areEqual(cloud.frame, frame));
    if (!found) return null;
    if (isWhole(found)) return found.points;
    this.drop(found);
    return null;
  }

  /** The cloud that was decoded last of an owner, with the time that it had. */
  last(owner: object): PointCloud | null {
    const found = this.clouds.filter((cloud) => cloud.owner === owner).pop();
    return found && isWhole(found) ? cloudOf(found.header, found.points) : null;
  }

  remember(owner: object, frame: Uint8Array, points: PackedPoints, header: Header): void {
    // A copy, as the bytes may be part of a much larger chunk of the recording.
    this.clouds.push({ owner, frame: frame.slice(), points, header, bytes: frame.length + points.data.length });
    const ofOwner = this.clouds.filter((cloud) => cloud.owner === owner);
    if (ofOwner.length > mostOfTopic) this.drop(ofOwner[0]);
    while (this.clouds.reduce((sum, { bytes }) => sum + bytes, 0) > mostBytes) this.drop(this.oldestOfLargestOwner());
  }

  forget(owner: object): void {
    this.clouds = this.clouds.filter((cloud) => cloud.owner !== owner);
  }

  private drop(dropped: RecentCloud | undefined): void {
    this.clouds = this.clouds.filter((cloud) => cloud !== dropped);
  }

  /** Of the owner with the most bytes, so that a topic of small clouds keeps its own beside one of large clouds. */
  private oldestOfLargestOwner(): RecentCloud | undefined {
    const bytesOf = new Map<object, number>();
    for (const { owner, bytes } of this.clouds) bytesOf.set(owner, (bytesOf.get(owner) ?? 0) + bytes);
    const most = Math.max(...bytesOf.values());
    return this.clouds.find(({ owner }) => bytesOf.get(owner) === most);
  }
}

/** False if a consumer transferred the data to another thread. */
function isWhole({ frame, points, bytes }: RecentCloud): boolean {
  return frame.length + points.data.length === bytes;
}

function areEqual(a: Uint8Array, b: Uint8Array): boolean {
  return a.length === b.length && a.every((byte, i) => byte === b[i]);
}
