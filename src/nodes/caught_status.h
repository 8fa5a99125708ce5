#pragma once

#include <pcl_ext/status.h>

#include <exception>
#include <new>

namespace pcl_ext {
namespace nodes {

/** \brief The status of memory that ran out. Its message fits into a string's own buffer,
 * so that it needs none itself. */
template <typename StatusT>
StatusT
outOfMemoryStatus()
{
  return {StatusT::Code::OutOfMemory, "out of memory"};
}

/** \brief What has just been caught as a status; to be called where that is. Throws
 * nothing: where there is no memory for a message, memory is what ran out.
 * \param[in] code of what is not for want of memory
 */
template <typename StatusT>
StatusT
caughtStatus(typename StatusT::Code code) noexcept
{
  try {
    try {
      throw;
    }
    catch (const std::bad_alloc&) {
      return outOfMemoryStatus<StatusT>();
    }
    catch (const std::exception& exception) {
      return {code, exception.what()};
    }
    catch (...) {
      return {code, "unknown error"};
    }
  }
  catch (...) {
    return outOfMemoryStatus<StatusT>();
  }
}

} // namespace nodes
} // namespace pcl_ext
