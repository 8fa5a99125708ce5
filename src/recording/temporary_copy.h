#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/recording/recording_status.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace recording {

/** \brief Copies an input that cannot seek, such as a pipe, into a temporary file
 * without a name. Devices and terminals are refused, as they may have no end.
 *
 * It is exported for the program pcl_ext, which reads clouds, too, from pipes.
 * \param[in] input descriptor of the input
 * \param[in] name of the input, for messages
 * \param[in] is_wanted is asked after signals and before each part; false ends the
 * copy. Empty: it is wanted
 * \param[in] beginning bytes of the input that were read already
 * \param[out] copy descriptor of the copy, which the caller closes
 */
PCL_EXT_RECORDING_EXPORT RecordingStatus
copyToTemporaryFile(int input,
                    const std::string& name,
                    const std::function<bool()>& is_wanted,
                    const std::vector<std::uint8_t>& beginning,
                    int& copy);

} // namespace recording
} // namespace pcl_ext
