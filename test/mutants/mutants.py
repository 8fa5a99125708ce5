"""Single changes of the library that its tests have to notice; see run.py.

Each is a text that occurs once in a file, and what replaces it. A mutation that no test can
notice, as it changes no result, has an explanation.
"""

from typing import NamedTuple


class Mutant(NamedTuple):
    file: str
    what: str
    old: str
    new: str
    explanation: str = ""


CONTEXT = "src/codec/context/"
FAST = "src/codec/fast/"
STREAM = "src/stream/"
VOXELIZING = "src/voxelizing/"

MUTANTS = [
    # Bounded reading.
    Mutant("src/bytes/byte_source.cpp", "a varint of 65 bits",
           "if (shift == 63 && byte > 1)", "if (shift == 63 && byte > 3)"),
    Mutant("src/bytes/byte_source.cpp", "a varint with a superfluous byte",
           "return byte == 0 && shift > 0 ? invalid : number;", "return number;"),
    Mutant("src/bytes/byte_source.cpp", "skipping beyond the limit",
           "if (size > remaining_)\n    fail(Failure::LimitExceeded);\n  if",
           "if (size > remaining_ + 1)\n    fail(Failure::LimitExceeded);\n  if"),
    Mutant("src/bytes/byte_source.cpp", "reading beyond the limit",
           "if (size > remaining_)\n    fail(Failure::LimitExceeded);\n  else",
           "if (size > remaining_ + 1)\n    fail(Failure::LimitExceeded);\n  else"),

    # Header, checksum, order of frames.
    Mutant("src/bytes/checksum.cpp", "the reference is not part of the checksum",
           "auto checksum = crc32_z(0, prefix.data(), prefix.size());",
           "auto checksum = crc32_z(0, prefix.data(), 0);"),
    Mutant("src/codec/frame_failures.cpp", "limit on voxels off by one",
           "if (count <= limits.max_voxels)", "if (count <= limits.max_voxels + 1)"),
    Mutant(STREAM + "version1_header.cpp", "limit on bytes off by one",
           "if (header.payload_size > limits.max_frame_bytes)",
           "if (header.payload_size >= limits.max_frame_bytes)",
           "with its header a frame of that payload exceeds the limit in any case"),
    Mutant(STREAM + "version1_header.cpp", "a grid of depth 22",
           "grid.depth > max_grid_depth)", "grid.depth > max_grid_depth + 1)"),
    Mutant(STREAM + "version1_header.cpp", "a companded scale that is linear",
           "scale.companded_range <= scale.maxSymbol())",
           "scale.companded_range < scale.maxSymbol())",
           "isConsistent() refuses such a scale behind the payload"),
    Mutant(STREAM + "version1_header.cpp", "a frame_id that is too long",
           "size > max_frame_id_size)", "size > max_frame_id_size + 1)"),
    Mutant(STREAM + "version1_decoder.cpp", "a wrong checksum is accepted",
           "checked_bytes_.size()) == checksum)", "checked_bytes_.size()) != 0)"),
    Mutant(STREAM + "version1_decoder.cpp", "a P-frame behind a lost one",
           "(has_history_ && header_.frame_number - 1 == frame_number_)", "has_history_"),
    Mutant(STREAM + "version1_decoder.cpp", "a frame is not checked behind its payload",
           "if (!isConsistent(frame)) {", "if (false) {",
           "the coders refuse such voxels themselves; this guards against their errors"),
    Mutant(STREAM + "version1_decoder.cpp", "a P-frame of another effort",
           "if (!is_i_frame && header_.effort != effort_)", "if (false)"),
    Mutant(STREAM + "version1_decoder.cpp", "the frame_id of the last frame is lost",
           "header_.has_frame_id || header_.is_i_frame ? header_.frame_id : frame_id_",
           "header_.frame_id"),
    Mutant("src/codec/frame_order.cpp", "frames above the last one are old",
           "number - last_.number < (1u << 31)", "number - last_.number < (1u << 30)"),
    Mutant("src/codec/frame_order.cpp", "copies are not known",
           "if (is_above && !is_copy)", "if (is_above)"),
    Mutant("src/codec/frame_order.cpp", "an old frame is not counted",
           "++old_in_a_row_;", ""),

    # Grids, scales, depth model.
    Mutant("src/voxels/grid_fit.cpp", "a range one short",
           "range.highest[axis] >= grid.first_index[axis] + grid.size())",
           "range.highest[axis] > grid.first_index[axis] + grid.size())"),
    Mutant("src/voxels/grid_fit.cpp", "a grid one level too shallow",
           "while (std::int64_t{1} << depth < extent)",
           "while (std::int64_t{1} << depth < extent - 1)"),
    Mutant("src/voxels/grid_fit.cpp", "a grid beyond the lattice",
           "std::clamp(centred, -lattice_end, lattice_end - grid.size())",
           "std::max(centred, -lattice_end)"),
    Mutant("src/voxels/depth_model.cpp", "a model that is not rounded",
           "std::lround(step)", "step"),
    Mutant("src/voxels/depth_model.cpp", "the sensor is at the origin",
           "(grid.centre(axis, 0) - sensor_origin[axis])", "grid.centre(axis, 0)"),

    # Points to voxels.
    Mutant(VOXELIZING + "lattice.h", "truncation instead of floor",
           "return truncated - (static_cast<double>(truncated) > number ? 1 : 0);",
           "return truncated;"),
    Mutant(VOXELIZING + "lattice.h", "the upper end of the box belongs to the grid",
           "position < end_[axis]))", "position <= end_[axis]))"),
    Mutant(VOXELIZING + "quad_locator.h", "swapped axes",
           "LanesT::template shiftLeft<2>(LanesT::bitAnd(position[1], within_block))",
           "LanesT::template shiftLeft<2>(LanesT::bitAnd(position[0], within_block))"),
    Mutant(VOXELIZING + "quad_locator.h", "points outside of the grid",
           "LanesT::bitOr(LanesT::bitOr(position[0], position[1]), position[2])",
           "LanesT::bitOr(position[0], position[1])"),
    Mutant(VOXELIZING + "quad_locator.h", "points near a voxel's boundary",
           "(3.0 * farthest + size) * 0x1p-23", "0.0 * farthest"),
    Mutant(VOXELIZING + "intensity_quantiser.cpp", "intensities are not rounded",
           "truncates_ ? 0.0 : 0.5", "0.0"),
    Mutant(VOXELIZING + "intensity_quantiser.cpp", "intensities below the scale",
           "std::clamp(number, 0.0, max_number)", "std::min(number, max_number)"),
    Mutant(VOXELIZING + "intensity_quantiser.cpp", "a scale that never shrinks",
           "lowest_ = 0.0;\n    highest_ = 0.0;", "lowest_ = 0.0;"),
    Mutant(VOXELIZING + "voxelizer.cpp", "a mean is a sum",
           "voxel_values_[i] /= static_cast<double>(voxel_counts_[i]);",
           "voxel_values_[i] /= 1.0;"),

    # Histories.
    Mutant(CONTEXT + "history.cpp", "an occupied voxel becomes less probable",
           "const std::uint32_t flip = (0 - is_occupied) & 0xffff;",
           "const std::uint32_t flip = (is_occupied - 1) & 0xffff;"),
    Mutant(CONTEXT + "history.cpp", "records are forgotten one too early",
           "record[index].probability >= least_probability",
           "record[index].probability > least_probability"),
    Mutant(CONTEXT + "history.cpp", "means move by an eighth",
           "record.mean + (difference >> 2)", "record.mean + (difference >> 3)"),
    Mutant(CONTEXT + "history.cpp", "activity without an upper end",
           "(block.activity * 3u + new_voxels * 2u + 2u) / 4u, most_active)",
           "(block.activity * 3u + new_voxels * 2u + 2u) / 4u, most_active + 1u)"),
    Mutant(CONTEXT + "history.cpp", "ages without an upper end",
           "(record.age < oldest ? 1 : 0)", "(record.age <= oldest ? 1 : 0)"),
    Mutant(FAST + "history.cpp", "the history keeps its statistics at an I-frame",
           "if (with_statistics)", "if (false)"),
    Mutant(FAST + "history.cpp", "blocks without known voxels are kept",
           "kept_ += is_kept;", "kept_ += 1;"),

    # Entropy coders.
    Mutant(CONTEXT + "entropy_coder.h", "a carry is lost",
           "if (low_ >= carry) {", "if (false) {"),
    Mutant(CONTEXT + "entropy_coder.h", "a decoder that reads behind its end",
           "(next_ != end_ ? *next_++ : 0u)", "*next_++"),
    Mutant(CONTEXT + "entropy_coder.h", "settled bytes are counted wrong",
           "return 2 * words_ - 4;", "return 2 * words_ - 2;"),

    # New voxels.
    Mutant(FAST + "new_voxels.cpp", "new voxels outside of the grid",
           "(in_grid & ~known) >> shift & 0xff)", "~known >> shift & 0xff)",
           "isConsistent() refuses such voxels behind the payload"),
    Mutant(FAST + "new_voxels.cpp", "a new voxel that is known already",
           "(cells & closed >> shift) != 0 ||", "false ||"),
    Mutant(FAST + "new_voxels.cpp", "several new voxels of which there is one",
           "if (child_masks.count[cells] < 2 ||", "if (child_masks.count[cells] < 1 ||"),
    Mutant(FAST + "new_voxels.cpp", "more voxels than the header says",
           "frame.found_voxels <= frame.voxel_count;", "true;"),
    Mutant(FAST + "new_voxels.cpp", "a symbol that is none",
           "return is_wrong >> 31 == 0;", "return true;"),
    Mutant(CONTEXT + "children.h", "the last child is not implied",
           "const bool is_implied = left == 0 && found == 0;",
           "const bool is_implied = false;"),
    Mutant(CONTEXT + "tiles.h", "a pending node counts as absent",
           "presentOf(tile, octant) | ((tile.pending >> octant & 1u) * 0xff)",
           "presentOf(tile, octant)"),
    Mutant(CONTEXT + "tiles.h", "the tile across an edge is that across a face",
           "if ((beside & axis) != 0 &&",
           "if ((beside & axis) != 0 && key == key_ &&"),
    Mutant(CONTEXT + "new_voxels.h", "nodes that are more than voxels",
           "frame_.children.size() + child_masks.count[children] > max_voxels_",
           "false"),
    Mutant(CONTEXT + "payload.cpp", "the history is used that knows nothing",
           "HistoryUse::knowsEnough(known_voxels_, voxels)", "true"),

    # Outliers, clouds, nodes.
    Mutant("src/outliers/density_blocks.cpp", "a voxel's own density counts once",
           "sum.core = 2 * own[middle] + faces;", "sum.core = own[middle] + faces;"),
    Mutant("src/outliers/density_blocks.cpp", "blocks below are no neighbours",
           "(cells & low_cells[axis]) != 0 ? 0 : 1;", "1;"),
    Mutant("src/outliers/density_blocks.cpp", "densities do not fall",
           "means[i] - (means[i] >> 2)", "means[i]"),
    Mutant("src/outliers/voxel_outlier_removal.cpp", "a history of another unit is kept",
           "if (!is_same_unit || !settings_.use_history)",
           "if (!settings_.use_history)"),
    Mutant("src/outliers/faint_voxels.cpp", "voxels at the threshold are removed",
           "(middle)) < min_intensity)", "(middle)) <= min_intensity)"),
    Mutant("src/filters/moved_points.cpp", "a cropped point is counted as kept",
           "count += kept >> lane & 1;", "count += 1;"),
    Mutant(STREAM + "cloud_encoder.cpp", "the grid is never fitted again",
           "encoder_.isIFrameDue()", "false"),
    Mutant(STREAM + "cloud_encoder.cpp", "a depth model in the published layout",
           "settings_.format == StreamFormat::Version1", "true"),
    Mutant("src/nodes/received_stream.cpp", "an I-frame is requested once only",
           "return failures_in_a_row_++ % 3 == 0;", "return failures_in_a_row_++ == 0;"),
    Mutant("src/nodes/received_stream.cpp", "refused frames count as lost, too",
           "health_.frames_lost += missing - unnumbered_;",
           "health_.frames_lost += missing;"),
    Mutant("src/nodes/merged_voxels.cpp", "voxels without a colour are merged as black",
           "!voxel.has_colour ||", "false ||"),
    Mutant("src/nodes/merged_voxels.cpp", "the origin of merged voxels never moves",
           "if (placed <= most)", "if (true)"),
]
