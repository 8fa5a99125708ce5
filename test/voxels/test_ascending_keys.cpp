#include "voxels/ascending_keys.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext::io;

struct Element {
  std::uint64_t key;
  int other;
};

std::vector<std::uint64_t>
randomKeys(std::mt19937& random)
{
  std::vector<std::uint64_t> keys(random() % 12);
  for (std::uint64_t& key : keys)
    key = random() % 16;
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
}

std::vector<Element>
elementsOf(const std::vector<std::uint64_t>& keys)
{
  std::vector<Element> elements;
  for (const std::uint64_t key : keys)
    elements.push_back({key, -1});
  return elements;
}

TEST(AscendingLookup, FindsWhatIsThere)
{
  std::mt19937 random(1);
  for (int round = 0; round < 500; ++round) {
    const std::vector<std::uint64_t> keys = randomKeys(random);
    const std::vector<Element> elements = elementsOf(keys);
    AscendingLookup<Element> lookup(elements);
    for (const std::uint64_t key : randomKeys(random)) {
      const auto found = std::find(keys.begin(), keys.end(), key);
      const std::size_t expected = found == keys.end()
                                       ? not_in_list
                                       : static_cast<std::size_t>(found - keys.begin());
      EXPECT_EQ(lookup.find(key), expected);
      EXPECT_EQ(lookup.find(key), expected) << "asked again";
    }
  }
  EXPECT_EQ(AscendingLookup<std::uint64_t>().find(0), not_in_list);
}

TEST(WalkSideBySide, VisitsEachKeyOnce)
{
  using Visits = std::map<std::uint64_t, std::pair<std::size_t, std::size_t>>;
  std::mt19937 random(2);
  for (int round = 0; round < 500; ++round) {
    const std::vector<std::uint64_t> second = randomKeys(random);
    const std::vector<Element> first = elementsOf(randomKeys(random));
    Visits expected;
    for (std::size_t i = 0; i < first.size(); ++i)
      expected[first[i].key] = {i, not_in_list};
    for (std::size_t j = 0; j < second.size(); ++j)
      expected.emplace(second[j], std::make_pair(not_in_list, j)).first->second.second =
          j;
    Visits visits;
    std::uint64_t last = 0;
    const auto visit = [&](std::uint64_t key, std::size_t i, std::size_t j) {
      EXPECT_TRUE(visits.empty() || key > last);
      last = key;
      visits[key] = {i, j};
    };
    EXPECT_TRUE(walkSideBySide(
        first,
        second,
        [&](std::size_t i) { visit(first[i].key, i, not_in_list); },
        [&](std::size_t j, std::size_t i) {
          visit(second[j], i, j);
          return true;
        }));
    EXPECT_EQ(visits, expected);

    // Ends where the visitor says so.
    for (std::size_t stop = 1; stop <= second.size(); ++stop) {
      std::size_t count = 0;
      EXPECT_FALSE(walkSideBySide(
          first,
          second,
          [&](std::size_t i) { EXPECT_LT(first[i].key, second[stop - 1]); },
          [&](std::size_t, std::size_t) { return ++count < stop; }));
      EXPECT_EQ(count, stop);
    }
  }
}

} // namespace
