/** \file
 * \brief Residuals as numbers: each number is that of one value, small ones are of values
 * near the prediction.
 */
#include "codec/supplement/residuals.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <set>
#include <string>

namespace {

using namespace pcl_ext::io::supplement;

TEST(Residuals, EachValueHasANumberOfItsOwnAndComesBack)
{
  for (const std::int32_t highest : {1, 2, 7, 31, 255})
    for (std::int32_t predicted = 0; predicted <= highest; ++predicted) {
      SCOPED_TRACE(std::to_string(predicted) + " of " + std::to_string(highest));
      std::set<std::uint32_t> numbers;
      for (std::int32_t value = 0; value <= highest; ++value) {
        const std::uint32_t number =
            foldResidual(value - predicted, predicted, highest);
        EXPECT_LE(number, static_cast<std::uint32_t>(highest));
        EXPECT_EQ(unfoldResidual(number, predicted, highest), value - predicted);
        numbers.insert(number);
      }
      EXPECT_EQ(numbers.size(), static_cast<std::size_t>(highest) + 1);
    }
}

TEST(Residuals, NumbersGrowWithTheDistance)
{
  constexpr std::int32_t highest = 100;
  for (const std::int32_t predicted : {0, 30, 50, 99})
    for (std::uint32_t number = 1; number <= highest; ++number)
      EXPECT_GE(std::abs(unfoldResidual(number, predicted, highest)),
                std::abs(unfoldResidual(number - 1, predicted, highest)));
}

TEST(Residuals, TheFirstNumbersAreThoseOfTheDocument)
{
  constexpr std::int32_t predicted = 2;
  constexpr std::int32_t residuals[] = {0, -1, 1, -2, 2, 3, 4, 5};
  for (std::uint32_t number = 0; number < 8; ++number)
    EXPECT_EQ(unfoldResidual(number, predicted, 7), residuals[number]);
}

} // namespace
