#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext {
namespace io {

/** \brief Tells late and repeated frames of a stream from new ones, so that they are
 * dropped: one that were decoded would make its successors ones that lack their
 * reference.
 *
 * Frames are numbered by their sender, which begins with an I-frame of number 1 each time
 * that it starts. Numbers wrap round.
 */
class FrameOrder {
public:
  /** \param[in] are_numbers_sure a checksum protects them; of I-frames whose numbers may be
   * damaged only copies are old
   */
  explicit FrameOrder(bool are_numbers_sure) : are_numbers_sure_(are_numbers_sure) {}

  /** \brief Judges a frame.
   * \param[in] number of the frame
   * \param[in] checksum of the frame, which tells it from another one of its number
   * \param[in] is_i_frame whether it stands alone
   * \return true if it is to be dropped: it was decoded before, or a later one was; and
   * nothing says that the sender began again
   */
  bool
  isOld(std::uint32_t number, std::uint32_t checksum, bool is_i_frame);

  /** \brief Takes a frame that was decoded for the last one.
   * \param[in] can_be_told its checksum tells its copies: it has voxels
   */
  void
  decoded(std::uint32_t number, std::uint32_t checksum, bool can_be_told) noexcept;

  /** \brief Tells that the input ended: it may be read again from its beginning. */
  void
  inputEnded() noexcept
  {
    has_input_ended_ = true;
  }

private:
  struct Frame {
    std::uint32_t number = 0;
    std::uint32_t checksum = 0;
    bool is_decoded = false;

    bool
    isSame(std::uint32_t other_number, std::uint32_t other_checksum) const
    {
      return is_decoded && number == other_number && checksum == other_checksum;
    }
  };

  bool
  beginsAgain(std::uint32_t number, bool is_copy) const;

  /** \brief Frames whose copies are known. */
  static constexpr std::size_t known_frames = 256;

  /** \brief After so many old frames without a new one the sender is taken for one that
   * began again, and an I-frame of it for the first one: one that was never seen after few,
   * as frames that were overtaken come alone; a copy after more than come in a row. */
  static constexpr unsigned int most_unknown_in_a_row = 2;
  static constexpr unsigned int most_copies_in_a_row = 24;

  bool are_numbers_sure_;
  std::array<Frame, known_frames> known_{}; // by number
  Frame first_;                             // the last one of number 1
  Frame last_;
  unsigned int old_in_a_row_ = 0;
  bool has_input_ended_ = false; // since the last frame that was decoded
};

} // namespace io
} // namespace pcl_ext
