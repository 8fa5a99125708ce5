// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * Fuzz target: for any bytes decoding ends, stays within its limits, and a frame is
 * either whole or not there.
 *
 * The bytes are a stream as it is. No fuzzer guesses a checksum; the target `frames`,
 * which computes them, reaches what comes after one.
 */
#include "checked_decoding.h"

extern "C" int
LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  pcl_ext::io::FrameDecoder decoder(pcl_ext::fuzz::smallLimits());
  pcl_ext::fuzz::decodeAll(data, size, decoder, [](std::size_t) {});
  const auto found = pcl_ext::io::frameSize(data, size, pcl_ext::fuzz::smallLimits());
  pcl_ext::fuzz::require(found.needed > 0 || found.drop > 0);
  return 0;
}
