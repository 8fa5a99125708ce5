// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "inputs/cloud_input.h"
#include "outputs/frame_output.h"
#include "streams/crew.h"
#include "streams/stream_encoder.h"

#include <atomic>
#include <cstddef>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief A cloud on its way to a frame. */
struct CloudInWork {
  enum class Outcome {
    Frame,
    Failed,  ///< the next clouds may be valid
    LeftOut, ///< see --max-rate
    Unread,  ///< as the program was interrupted before
    Refused  ///< as all of its stream, for which the options are not
  };

  InputCloud cloud;
  std::atomic<bool> is_done{false}; ///< the following are set
  Outcome outcome = Outcome::Frame;
  std::string reason;       ///< if it failed or is refused
  std::exception_ptr fault; ///< what ends the program; else null
  OutputFrame frame;        ///< if there is one
  EncodedSums sums;
};

struct EncodedStreamReport {
  EncodedSums sums; ///< also of frames that were not written
  Remarks remarks;
  std::string frame_id_error;    ///< see StreamEncoder::frameIdError()
  bool is_filter_chosen = false; ///< the temporal filter, if it is on, is --max-rate's
  std::string why_nothing;       ///< was encoded; empty if something was
};

/** \brief Encodes the clouds of one stream with the threads of a crew.
 *
 * The stream is divided into parts of so many clouds, each with an encoder of its own, so
 * that several are encoded at once. The division does not depend on the crew, and so the
 * frames do not. A stream is one part where the settings have an effect beyond an
 * I-frame.
 */
class EncodedStream {
public:
  /** \brief Fewest clouds in a part. */
  static constexpr std::size_t fewest_in_part = 120;

  /** \param[in] options must outlive this, as must the crew
   * \param[in] name of the stream
   * \param[in] input reads clouds that are unread; must outlive this
   */
  EncodedStream(const EncodingOptions& options,
                const std::string& name,
                Crew& crew,
                CloudInput& input);

  /** \brief Lets all clouds that were added be done at once, without encoding them, and
   * waits for that. */
  ~EncodedStream();
  EncodedStream(const EncodedStream&) = delete;
  EncodedStream&
  operator=(const EncodedStream&) = delete;

  /** \brief Clouds in a part of a stream; 0: it is one part with these options. */
  static std::size_t
  cloudsInPart(const EncodingOptions& options);

  /** \brief Takes the next cloud.
   * \return the clouds that are encoded from now on, in the order of their frames: none
   * as long as no cloud tells the law, and then all of them
   */
  std::vector<std::shared_ptr<CloudInWork>>
  add(std::shared_ptr<CloudInWork> cloud);

  /** \brief Takes the clouds of a stream in which none tells the law.
   * \return as add()
   */
  std::vector<std::shared_ptr<CloudInWork>>
  addWaiting();

  /** \brief The law of the intensities, after the first frame. */
  IntensityLaw
  law() const
  {
    return law_;
  }

  /** \brief Whether the cloud that tells the law is a lidar's, see
   * pcl_ext::isOfLidar(). */
  bool
  isOfLidar() const
  {
    return is_of_lidar_;
  }

  /** \brief What there is to say, when all clouds are done. */
  const EncodedStreamReport&
  finish();

private:
  struct Part;

  void
  begin(const std::shared_ptr<CloudInWork>& cloud);

  void
  beginPart(std::size_t first_cloud);

  static void
  encodeNext(const std::shared_ptr<Part>& part, Crew& crew);

  void
  add(const StreamEncoder& encoder);

  const EncodingOptions& options_;
  std::string name_;
  Crew& crew_;
  CloudInput& input_;
  std::size_t clouds_in_part_;
  std::optional<std::size_t> first_number_; // of its clouds
  std::size_t next_part_ = 0;
  std::vector<std::shared_ptr<CloudInWork>> waiting_;    // until one tells the law
  std::shared_ptr<const pcl::PCLPointCloud2> law_cloud_; // that did, without points
  clouds::ColourScale colour_scale_; // of clouds until then, if they were unread
  bool is_of_lidar_ = false;
  std::shared_ptr<PlaceReader> reader_;      // of clouds until then
  std::vector<std::shared_ptr<Part>> parts_; // not in the report yet
  std::atomic<IntensityLaw> law_{IntensityLaw::Count};
  EncodedStreamReport report_;
};

} // namespace pcl_ext::tools
