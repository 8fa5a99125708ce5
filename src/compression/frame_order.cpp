#include "frame_order.h"

namespace pcl_ext {
namespace io {

bool
FrameOrder::isOld(std::uint32_t number, std::uint32_t checksum, bool is_i_frame)
{
  if (!last_.is_decoded)
    return false;
  if (number == last_.number + 1)
    return false;
  // An I-frame right behind itself changes nothing, as where one file is read twice.
  if (is_i_frame && last_.isSame(number, checksum))
    return false;
  const bool is_copy = known_[number % known_frames].isSame(number, checksum) ||
                       first_.isSame(number, checksum);
  const bool is_above = number != last_.number && number - last_.number < (1u << 31);
  if (is_above && !is_copy)
    return false;
  const bool may_begin_again = number == 1 || !are_numbers_sure_;
  if (is_i_frame &&
      ((may_begin_again && !is_copy) || old_in_a_row_ >= most_old_in_a_row))
    return false;
  ++old_in_a_row_;
  return true;
}

void
FrameOrder::decoded(std::uint32_t number, std::uint32_t checksum) noexcept
{
  last_ = {number, checksum, true};
  known_[number % known_frames] = last_;
  if (number == 1)
    first_ = last_;
  old_in_a_row_ = 0;
}

} // namespace io
} // namespace pcl_ext
