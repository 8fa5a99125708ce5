// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief What the standard libraries want of a system that a page does not have, so
 * that the module imports nothing but its memory and random bytes, and is half as
 * large.
 *
 * std::streambuf has a locale, although the codec reads bytes only. The standard
 * library's own constructor of it would link all facets of all locales, 150 kB; these
 * need none. It has to be instantiated here, with _LIBCPP_DISABLE_EXTERN_TEMPLATE.
 */
#include <wasi/api.h>

#include <cstddef>
#include <cstdint>
#include <locale>

std::locale::locale() noexcept : __locale_(nullptr) {}
std::locale::locale(const locale&) noexcept : __locale_(nullptr) {}
std::locale::~locale() = default;
const std::locale&
std::locale::operator=(const locale&) noexcept
{
  return *this;
}

// WASI's functions that the libraries call. There are no files.

__wasi_errno_t
__wasi_fd_close(__wasi_fd_t)
{
  return __WASI_ERRNO_NOTSUP;
}

__wasi_errno_t
__wasi_fd_seek(__wasi_fd_t, __wasi_filedelta_t, __wasi_whence_t, __wasi_filesize_t*)
{
  return __WASI_ERRNO_NOTSUP;
}

__wasi_errno_t
__wasi_fd_write(__wasi_fd_t, const __wasi_ciovec_t*, size_t, __wasi_size_t*)
{
  return __WASI_ERRNO_NOTSUP;
}

// For the keys of hash tables, which an attacker must not know.
__attribute__((import_module("env"), import_name("fill_random"))) extern "C" void
fillRandom(std::uint8_t* bytes, std::size_t size);

__wasi_errno_t
__wasi_random_get(uint8_t* bytes, __wasi_size_t size)
{
  fillRandom(bytes, size);
  return __WASI_ERRNO_SUCCESS;
}
