// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Exception handling of the codec. Only here, so that the codec also builds
 * without exceptions, as for wasm32. Without them running out of memory ends the
 * program.
 */
#pragma once

#include <pcl_ext/version.h>

#include <exception>
#include <new>

#if defined(__cpp_exceptions) || defined(_CPPUNWIND)
#define PCL_EXT_HAS_EXCEPTIONS 1
#else
#define PCL_EXT_HAS_EXCEPTIONS 0
#endif

namespace pcl_ext {

/** \brief Calls a function and returns its result; if it throws, the result of
 * another. */
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

/** \brief Calls a function and returns its result, or, if it throws, that of a handler.
 * \param[in] function to call
 * \param[in] no_memory handler of std::bad_alloc, also of one in the other handler
 * \param[in] failed handler of other exceptions, called with their text
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
      return failed("unknown error");
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

/** \brief Calls a function and returns its result; if it throws std::bad_alloc, the
 * result of another. */
template <typename FunctionT, typename FallbackT>
auto
callOrNoMemory(FunctionT function, FallbackT no_memory) -> decltype(function())
{
#if PCL_EXT_HAS_EXCEPTIONS
  try {
    return function();
  }
  catch (const std::bad_alloc&) {
    return no_memory();
  }
#else
  static_cast<void>(no_memory);
  return function();
#endif
}

/** \brief Calls a function and returns its result; if it throws, calls another one and
 * rethrows. */
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
