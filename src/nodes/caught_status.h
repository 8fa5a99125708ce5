#pragma once

#include <pcl_ext/status.h>

#include <exception>
#include <new>

namespace pcl_ext {
namespace nodes {

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
