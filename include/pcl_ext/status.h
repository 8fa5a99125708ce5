#pragma once

#include <string>
#include <utility>

namespace pcl_ext {

/** \brief What came of an operation that can fail on bad input: a code to branch on and
 * a sentence to show.
 * \tparam CodeT an enumeration whose value `CodeT::Ok` means success
 *
 * Clouds, frames, streams and settings that are bad are reported through this type and
 * never through exceptions.
 */
template <typename CodeT>
class Status {
public:
  using Code = CodeT;

  /** \brief Success. */
  Status() = default;

  /** \brief A failure, or a success with something to say.
   * \param[in] code the kind of outcome
   * \param[in] message one sentence for a person; says what is wrong and with what
   * value
   */
  Status(CodeT code, std::string message) : code_(code), message_(std::move(message)) {}

  /** \brief True if the operation did what it was asked to do. */
  bool
  ok() const
  {
    return code_ == CodeT::Ok;
  }

  /** \brief The kind of outcome. */
  CodeT
  code() const
  {
    return code_;
  }

  /** \brief A sentence for a person; empty on plain success. */
  const std::string&
  message() const
  {
    return message_;
  }

private:
  CodeT code_ = CodeT::Ok;
  std::string message_;
};

/** \brief The status of memory that ran out. Its message fits into a string's own buffer,
 * so that it needs none itself.
 * \tparam StatusT a Status whose codes have an OutOfMemory
 */
template <typename StatusT>
StatusT
outOfMemoryStatus()
{
  return {StatusT::Code::OutOfMemory, "out of memory"};
}

} // namespace pcl_ext
