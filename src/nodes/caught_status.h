#pragma once

#include <pcl_ext/status.h>

#include <exception>
#include <new>

namespace pcl_ext {
namespace nodes {

/** \brief Converts the current exception to a status; to be called in a catch block. Does not
 * throw: without memory for the message the status is OutOfMemory.
 * \param[in] code for all exceptions but std::bad_alloc
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
