#pragma once

#include <algorithm>
#include <cstddef>

namespace pcl_ext {
namespace io {

/** \brief Bounds how many bytes are read again behind failed frames, so that n bytes are
 * searched in a time that grows as n does, whatever they hold.
 *
 * Behind a failed frame the search goes on at its second byte, as its size may be a lie
 * that hides others. Bytes that hold many such lies would be read many times.
 */
class RereadAllowance {
public:
  /** \param[in] most bytes that may be read again at the start, and that can be saved */
  explicit RereadAllowance(std::size_t most) : most_(most), left_(most) {}

  /** \brief Takes bytes that are to be read again.
   * \return false if these are too many; nothing is taken then
   */
  bool
  take(std::size_t bytes)
  {
    if (bytes > left_)
      return false;
    left_ -= bytes;
    return true;
  }

  /** \brief Tells that bytes lie behind the search for good. */
  void
  pass(std::size_t bytes)
  {
    left_ += std::min((most_ - left_) / times_read, bytes) * times_read;
  }

private:
  static constexpr std::size_t times_read = 16;

  std::size_t most_;
  std::size_t left_;
};

} // namespace io
} // namespace pcl_ext
