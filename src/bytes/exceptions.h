/** \file
 * \brief The only place of the codec with `try`: it also builds where a target or its
 * flags leave exceptions out, as for wasm32. Memory that runs out ends the program there.
 */
#pragma once

#include <exception>
#include <new>

#if defined(__cpp_exceptions) || defined(_CPPUNWIND)
#define PCL_EXT_HAS_EXCEPTIONS 1
#else
#define PCL_EXT_HAS_EXCEPTIONS 0
#endif

namespace pcl_ext {

/** \brief What a function returns, or, if it throws, what another one does. */
template <typename FunctionT, typename FallbackT>
auto
callOrElse(FunctionT function, FallbackT fallback) -> decltype(function())
{
#if PCL_EXT_HAS_EXCEPTIONS
  try {
    return function();
  }
  catch (...) {
    return fallback();
  }
#else
  static_cast<void>(fallback);
  return function();
#endif
}

/** \brief What a function returns. If it throws, others return in its place:
 * \param[in] function to call
 * \param[in] no_memory called where memory ran out, in the next one, too
 * \param[in] failed called with the text of any other exception; empty if it has none
 */
template <typename FunctionT, typename NoMemoryT, typename FailedT>
auto
callOrElse(FunctionT function, NoMemoryT no_memory, FailedT failed)
    -> decltype(function())
{
#if PCL_EXT_HAS_EXCEPTIONS
  try {
    try {
      return function();
    }
    catch (const std::bad_alloc&) {
      throw;
    }
    catch (const std::exception& exception) {
      return failed(exception.what());
    }
    catch (...) {
      return failed("");
    }
  }
  catch (...) {
    return no_memory();
  }
#else
  static_cast<void>(no_memory);
  static_cast<void>(failed);
  return function();
#endif
}

/** \brief What a function returns; if it throws, another one is called first. */
template <typename FunctionT, typename CleanupT>
auto
callOrCleanUp(FunctionT function, CleanupT clean_up) -> decltype(function())
{
#if PCL_EXT_HAS_EXCEPTIONS
  try {
    return function();
  }
  catch (...) {
    clean_up();
    throw;
  }
#else
  static_cast<void>(clean_up);
  return function();
#endif
}

} // namespace pcl_ext
