// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Index of an element that does not exist. */
constexpr std::size_t not_in_list = static_cast<std::size_t>(-1);

/** \brief The key of an element of an ascending list. */
constexpr std::uint64_t
keyOf(std::uint64_t key)
{
  return key;
}

template <class Element>
constexpr std::uint64_t
keyOf(const Element& element)
{
  return element.key;
}

/** \brief Finds elements of an ascending list by their keys, in ascending order. */
template <class Element>
class AscendingLookup {
public:
  /** \brief A lookup in an empty list. */
  AscendingLookup() = default;

  /** \param[in] elements ascending; they must outlive the lookup */
  explicit AscendingLookup(const std::vector<Element>& elements)
  : elements_(elements.data()), size_(elements.size())
  {}

  /** \brief Index of the element with a key, or not_in_list. */
  std::size_t
  find(std::uint64_t key)
  {
    while (next_ < size_ && keyOf(elements_[next_]) < key)
      ++next_;
    return next_ < size_ && keyOf(elements_[next_]) == key ? next_ : not_in_list;
  }

private:
  const Element* elements_ = nullptr;
  std::size_t size_ = 0;
  std::size_t next_ = 0;
};

/** \brief Visits the elements of two ascending lists in the order of their keys.
 * \param[in] first,second the lists
 * \param[in] visit_first called with the index of each element of the first list whose
 * key is not in the second one
 * \param[in] visit_second called with the index of each element of the second list, and
 * that of the same key in the first one or not_in_list; returns false to stop
 * \return false if visit_second stopped
 */
template <class First, class Second, class VisitFirst, class VisitSecond>
bool
walkSideBySide(const std::vector<First>& first,
               const std::vector<Second>& second,
               VisitFirst&& visit_first,
               VisitSecond&& visit_second)
{
  const First* const firsts = first.data();
  const Second* const seconds = second.data();
  const std::size_t first_size = first.size();
  const std::size_t second_size = second.size();
  std::size_t i = 0;
  for (std::size_t j = 0; j < second_size; ++j) {
    const std::uint64_t key = keyOf(seconds[j]);
    for (; i < first_size && keyOf(firsts[i]) < key; ++i)
      visit_first(i);
    const bool is_in_both = i < first_size && keyOf(firsts[i]) == key;
    if (!visit_second(j, is_in_both ? i : not_in_list))
      return false;
    i += is_in_both ? 1 : 0;
  }
  for (; i < first_size; ++i)
    visit_first(i);
  return true;
}

} // namespace pcl_ext::PCL_EXT_ABI::io
