// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief What a frame is coded by. */
enum class FrameKind {
  Intra,     ///< I-frame: by itself
  Predicted, ///< P-frame: by the history
  Changes    ///< P-frame: as what differs from the last frame
};

/** \brief Why a frame cannot be a P-frame, or should be none. */
struct IFrameReasons {
  // Of the stream, before the frame is known:
  bool is_requested = false; ///< first frame, other settings, or asked for
  bool is_scheduled = false; ///< by the I-frame rate
  bool is_late = false;      ///< by the time since the last I-frame
  // Of the frame:
  bool has_other_content = false;   ///< grid, scale, layout, or what its voxels have
  bool has_far_stamp = false;       ///< its change takes more bytes than the stamp
  bool has_long_history = false;    ///< which takes time and memory in both directions
  bool repeats_fine_voxels = false; ///< which a history of all voxels codes better

  bool
  any() const
  {
    return is_requested || is_scheduled || is_late || has_other_content ||
           has_far_stamp || has_long_history || repeats_fine_voxels;
  }
};

} // namespace pcl_ext::PCL_EXT_ABI::io
