#include "codec/fast/classed_row.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace {

using pcl_ext::io::fast::ClassedRow;
using pcl_ext::io::test::below;
using pcl_ext::io::test::Bytes;

TEST(ClassedRow, RowsComeBack)
{
  std::mt19937_64 random(7);
  ClassedRow encoder;
  ClassedRow decoder;
  for (const std::size_t count : {0u, 1u, 50u, 5000u}) {
    std::vector<std::uint16_t> numbers(count);
    std::vector<std::uint8_t> classes(count);
    for (std::size_t i = 0; i < count; ++i) {
      classes[i] = static_cast<std::uint8_t>(below(random, 16));
      numbers[i] = static_cast<std::uint16_t>(below(random, 40) == 0
                                                  ? below(random, 0x10000)
                                                  : below(random, 1 + classes[i]));
    }
    Bytes bytes;
    encoder.encode(count == 0, numbers, classes, bytes);
    std::vector<std::uint16_t> back;
    const std::uint8_t* const end = bytes.data() + bytes.size();
    EXPECT_FALSE(decoder.decode(bytes.data(), end - 1, count == 0, classes, back));
    ASSERT_TRUE(decoder.decode(bytes.data(), end, count == 0, classes, back));
    decoder.learn();
    EXPECT_EQ(back, numbers);
  }
}

TEST(ClassedRow, HasFourStatesFrom1024NumbersOn)
{
  const auto size = [](std::size_t count) {
    ClassedRow encoder;
    std::vector<std::uint16_t> numbers(count);
    for (std::size_t i = 0; i < count; ++i)
      numbers[i] = static_cast<std::uint16_t>(i * i % 11);
    Bytes bytes;
    encoder.encode(true, numbers, std::vector<std::uint8_t>(count), bytes);
    return bytes.size();
  };
  EXPECT_GE(size(1024), size(1023) + 8);
}

TEST(ClassedRow, CostsAboutItsEntropy)
{
  std::mt19937_64 random(8);
  ClassedRow encoder;
  const std::size_t count = 20000;
  std::vector<std::uint16_t> numbers(count);
  const std::vector<std::uint8_t> classes(count, 3);
  double ones = 0.0;
  for (std::uint16_t& number : numbers) {
    number = static_cast<std::uint16_t>(below(random, 4) == 0 ? 1 : 0);
    ones += number;
  }
  Bytes bytes;
  encoder.encode(true, numbers, classes, bytes);
  const double share = ones / count;
  const double entropy =
      -share * std::log2(share) - (1.0 - share) * std::log2(1.0 - share);
  EXPECT_LT(static_cast<double>(bytes.size()) * 8 / count, 1.025 * entropy);
}

} // namespace
