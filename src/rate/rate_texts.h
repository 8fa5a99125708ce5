// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/rate_control_status.h>

#include <cstddef>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief A number with three digits. */
std::string
numberText(double number);

/** \brief A rate with its unit, as "2 Mbit/s". */
std::string
rateText(double bits_per_second);

/** \brief A step in words. */
std::string
stepText(const RateStep& step, double resolution);

/** \brief What of a rate and a buffer frames take. */
std::string
overloadText(double bytes_per_second,
             double i_frame_bytes,
             double max_rate,
             double buffer_seconds);

} // namespace pcl_ext::PCL_EXT_ABI::io
