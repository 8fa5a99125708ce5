// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Invalid streams, kept as files in test/data/invalid, and what each is refused
 * with. See write_test_streams.cpp for what is wrong with them.
 */
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

const std::string folder = PCL_EXT_TEST_DATA "/invalid";

struct InvalidFile {
  std::string name;
  CompressionCode code;
  std::string message; ///< a part of it
};

const std::vector<InvalidFile> files{
    {"ends_in_header", CompressionCode::Truncated, "ends in a frame header"},
    {"ends_in_payload", CompressionCode::Truncated, "ends in a payload"},
    {"wrong_checksum", CompressionCode::Corrupt, "checksum mismatch of frame 1"},
    {"unknown_version", CompressionCode::UnsupportedVersion, "stream version 2"},
    {"unknown_coder", CompressionCode::Corrupt, "unknown flags"},
    {"p_frame_alone", CompressionCode::MissingReference, "no frame was decoded"},
    {"too_many_voxels", CompressionCode::LimitExceeded, "1099511627776 voxels"},
    {"voxels_without_end",
     CompressionCode::LimitExceeded,
     "voxels exceed the limit of 8388608"},
    {"too_many_bytes",
     CompressionCode::LimitExceeded,
     "payload exceeds the limit of 268435456 bytes"},
    {"bytes_that_do_not_come", CompressionCode::Truncated, "ends in a payload"},
    {"voxels_out_of_nothing",
     CompressionCode::Corrupt,
     "does not decode to 1048576 voxels"},
    {"payload_without_voxels", CompressionCode::Corrupt, "does not decode to 0 voxels"},
    {"depth_model_of_cubes", CompressionCode::Corrupt, "invalid depth model"},
    {"depth_model_far_away", CompressionCode::Corrupt, "invalid depth model"},
    {"depth_model_cut_off",
     CompressionCode::Corrupt,
     "payload smaller than its depth model"},
    {"grid_too_deep", CompressionCode::Corrupt, "grid depth outside 1 to 21"},
    {"grid_off_the_lattice", CompressionCode::Corrupt, "grid outside the lattice"},
    {"symbols_of_17_bits", CompressionCode::Corrupt, "invalid intensity scale"},
    {"long_frame_id", CompressionCode::Corrupt, "frame_id too long"},
    {"placement_of_an_i_frame", CompressionCode::Corrupt, "invalid content"},
    {"unknown_content", CompressionCode::Corrupt, "invalid content"},
    {"scan_without_point_counts", CompressionCode::Corrupt, "invalid content"},
    {"layout_beyond_the_point", CompressionCode::Corrupt, "invalid layout of messages"},
    {"too_many_fields_of_a_layout",
     CompressionCode::Corrupt,
     "layout of messages with too many fields"},
    {"no_fields", CompressionCode::Corrupt, "number of fields outside 1 to 64"},
    {"too_many_fields", CompressionCode::Corrupt, "number of fields outside 1 to 64"},
    {"field_without_name", CompressionCode::Corrupt, "invalid field"},
    {"long_field_name", CompressionCode::Corrupt, "name of a field too long"},
    {"unknown_field_type", CompressionCode::Corrupt, "invalid field"},
    {"field_without_values", CompressionCode::Corrupt, "invalid field"},
    {"too_many_field_values", CompressionCode::Corrupt, "too many values of a point"},
    {"negative_field_step", CompressionCode::Corrupt, "invalid field"},
    {"no_field_step", CompressionCode::Corrupt, "invalid field"},
    {"viewpoint_far_away", CompressionCode::Corrupt, "viewpoint too far away"},
    {"fields_without_supplement",
     CompressionCode::Corrupt,
     "the supplement does not decode"},
    {"points_of_fields_without_end",
     CompressionCode::Corrupt,
     "the supplement does not decode"},
    {"points_of_fields_that_overflow",
     CompressionCode::Corrupt,
     "the supplement does not decode"},
    {"scan_without_columns", CompressionCode::Corrupt, "invalid scan"},
    {"too_many_pixels", CompressionCode::Corrupt, "invalid scan"},
    {"scan_moved_out", CompressionCode::Corrupt, "invalid scan"},
    {"scan_of_unknown_rays", CompressionCode::Corrupt, "invalid scan"},
    {"half_depths_of_no_camera", CompressionCode::Corrupt, "invalid scan"},
    {"scan_too_steep", CompressionCode::Corrupt, "invalid scan"},
    {"scan_with_rows_twice", CompressionCode::Corrupt, "invalid scan"},
    {"scan_with_other_rows", CompressionCode::Corrupt, "invalid scan"}};

TEST(InvalidFiles, AreRefusedWithTheirCodeAndMessage)
{
  FrameDecoder decoder; // one for all: invalid files leave it unchanged
  std::mt19937_64 random(1);
  FrameEncoder encoder(StreamFormat::Version1, 1, Effort::Balanced);
  for (const InvalidFile& invalid : files) {
    SCOPED_TRACE(invalid.name);
    std::ifstream file(folder + "/" + invalid.name + ".pcxi", std::ios::binary);
    ASSERT_TRUE(file.good());
    const Bytes bytes{std::istreambuf_iterator<char>(file), {}};
    VoxelFrame frame;
    const bool needs_fresh = invalid.code == CompressionCode::MissingReference;
    FrameDecoder fresh;
    const CompressionStatus status =
        (needs_fresh ? fresh : decoder).decode(bytes.data(), bytes.size(), frame);
    EXPECT_EQ(static_cast<int>(status.code()), static_cast<int>(invalid.code));
    EXPECT_NE(status.message().find(invalid.message), std::string::npos)
        << status.message();
    EXPECT_TRUE(frame.keys.empty() && frame.intensities.empty());
    EXPECT_EQ(decoded(decoder, encoded(encoder, randomFrame(random, 4, 9)), frame),
              CompressionCode::Ok);
  }
}

TEST(InvalidFiles, CoverTheFolder)
{
  std::set<std::string> known;
  for (const InvalidFile& invalid : files)
    known.insert(invalid.name + ".pcxi");
  std::set<std::string> there;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    there.insert(entry.path().filename().string());
  EXPECT_EQ(there, known);
}

} // namespace
