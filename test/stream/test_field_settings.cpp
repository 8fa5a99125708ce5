// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/compression_settings.h>

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;

TEST(FieldSettings, AreReadFromText)
{
  const auto fault_of = [](const char* text) {
    std::vector<FieldSetting> fields = {{"other"}};
    const CompressionStatus status = parseFields(text, fields);
    EXPECT_TRUE(status.ok() || fields.empty()) << text;
    return status.message();
  };
  EXPECT_EQ(fault_of(""), "");
  EXPECT_EQ(fault_of("ring,time:1e-6,a:b:2,all"), "");
  for (const std::string text : {"ring,", ",ring", "ring,,time", ":1", "ring:", "a:b"})
    EXPECT_EQ(fault_of(text.c_str()),
              "fields is '" + text +
                  "'; it must be names with commas between them, each with :STEP above "
                  "0 if it has one, or all");
  std::vector<FieldSetting> spaced;
  EXPECT_TRUE(parseFields("ring, time:0.5 ", spaced).ok());
  ASSERT_EQ(spaced.size(), 2u);
  EXPECT_EQ(spaced[1].name, "time");
  EXPECT_EQ(spaced[1].step, 0.5);
  EXPECT_EQ(fault_of("all:0.1"),
            "fields: the step of 'all' is 0.1; it must be left out, as all means exact "
            "values; name the fields with a step");
  EXPECT_EQ(fault_of("ring,time,ring:2"),
            "fields has 'ring' twice; it must have each name once");
  EXPECT_EQ(fault_of("all,all"), "fields has 'all' twice; it must have each name once");
}

TEST(FieldSettings, AreChecked)
{
  const auto message_of = [](auto change) {
    EncoderSettings settings;
    settings.fields = {{"ring", 0.5}};
    change(settings);
    return checkSettings(settings).message();
  };
  EXPECT_EQ(message_of([](EncoderSettings&) {}), "");
  EXPECT_EQ(message_of([](EncoderSettings& s) { s.fields[0].step = -0.5; }),
            "fields: the step of 'ring' is -0.5; it must be a positive step, or 0 for "
            "exact values");
  EXPECT_EQ(message_of([](EncoderSettings& s) { s.fields[0].name.clear(); }),
            "fields: a name is empty; it must be that of a field, or all");
  EXPECT_EQ(message_of([](EncoderSettings& s) { s.fields.push_back({"ring"}); }),
            "fields has 'ring' twice; it must have each name once");
  EXPECT_EQ(message_of([](EncoderSettings& s) { s.fields[0].name = all_fields; }),
            "fields: the step of 'all' is 0.5; it must be left out, as all means exact "
            "values; name the fields with a step");
  EXPECT_EQ(message_of([](EncoderSettings& s) { s.temporal_filter = 8; }),
            "fields is set; it must be empty with temporal_filter");
  EXPECT_EQ(message_of([](EncoderSettings& s) { s.format = StreamFormat::Published; }),
            "fields is set; it must be empty in the published layout");
  EXPECT_EQ(
      message_of([](EncoderSettings& s) { s.decoder_limits.max_field_values = 0; }),
      "decoder_limits.max_field_values is 0; it must be above 0");
}

} // namespace
