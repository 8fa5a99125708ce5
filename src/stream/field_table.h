// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_field.h>
#include <pcl_ext/compression/message_layout.h>
#include <pcl_ext/status.h>

#include "bytes/byte_source.h"
#include "bytes/byte_writer.h"

#include <array>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Writes which fields a stream has, as an I-frame's header does
 * (doc/bitstream.md, "Frame header"). */
void
writeFieldTable(const std::vector<FieldDescription>& fields,
                const std::array<std::int32_t, 3>& viewpoint,
                ByteWriter& writer);

/** \brief Reads and checks what writeFieldTable() wrote.
 * \param[out] fields are appended
 */
CompressionStatus
readFieldTable(ByteSource& source,
               std::vector<FieldDescription>& fields,
               std::array<std::int32_t, 3>& viewpoint);

/** \brief Writes how messages are laid out, likewise.
 * \param[in] layout as isLayout() demands
 */
void
writeLayout(const MessageLayout& layout, ByteWriter& writer);

/** \brief Reads and checks what writeLayout() wrote.
 * \param[in,out] layout fields are appended
 */
CompressionStatus
readLayout(ByteSource& source, MessageLayout& layout);

} // namespace pcl_ext::PCL_EXT_ABI::io
