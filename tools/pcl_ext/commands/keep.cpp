// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/link/frame_subscriber.h>

#include "commands/commands.h"
#include "console/console.h"
#include "console/exit_status.h"
#include "console/throw_unless_ok.h"
#include "measuring/markdown_table.h"
#include "options/link_options.h"
#include "options/options.h"
#include "options/text_values.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <memory>
#include <sstream>
#include <string>
#include <utility>

namespace pcl_ext::tools {

namespace {

/** \brief Listens to the site for a moment, so that I-frames are requested of streams
 * whose next frame is a P-frame, with which a replay cannot begin, and until these have
 * come. Where that is not permitted, they come when they come. */
void
requestIFrames(const link::LinkSettings& link)
{
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds least_time{500};
  constexpr std::chrono::milliseconds most_time{3000};
  constexpr std::chrono::milliseconds patience{10};
  link::SubscriberSettings settings;
  settings.link = link;
  link::FrameSubscriber subscriber(settings);
  if (!subscriber.connect().ok())
    return;
  const auto have_all_begun = [&subscriber] {
    const auto streams = subscriber.statistics().streams;
    return std::all_of(streams.begin(), streams.end(), [](const auto& stream) {
      return stream.frames > 0;
    });
  };
  link::LinkFrame frame;
  const Clock::time_point start = Clock::now();
  while (Clock::now() < start + least_time ||
         (Clock::now() < start + most_time && !have_all_begun()))
    subscriber.next(frame, patience);
}

/** \brief A number with the largest unit of which there is one.
 * \param[in] units how many of the number they are, and names; descending, the last of 1
 */
std::string
withUnit(double number, std::initializer_list<std::pair<double, const char*>> units)
{
  const auto* const unit =
      std::find_if(units.begin(), std::prev(units.end()), [number](const auto& one) {
        return number >= one.first;
      });
  std::ostringstream text;
  text << number / unit->first << ' ' << unit->second;
  return text.str();
}

/** \brief Such as "of the last 24 h, up to 2 GB". */
std::string
describeLimits(const link::KeptFrames& kept)
{
  using Seconds = std::chrono::duration<double>;
  std::string text = "of any age";
  if (kept.max_age > link::Time(0))
    text = "of the last " + withUnit(Seconds(kept.max_age).count(),
                                     {{3600.0, "h"}, {60.0, "min"}, {1.0, "s"}});
  if (kept.max_bytes > 0)
    text += ", up to " + withUnit(static_cast<double>(kept.max_bytes),
                                  {{1e9, "GB"}, {1e6, "MB"}, {1e3, "kB"}, {1.0, "B"}});
  return text;
}

} // namespace

Run
addKeep(CLI::App& app)
{
  struct Options {
    link::LinkSettings link;
    link::KeepSettings keep;
    bool is_quiet = false;
  };
  const auto options = std::make_shared<Options>();
  addLinkOptions(app, options->link);
  addParsed(app,
            "--max-age",
            "TIME",
            "delete what is older (as before; at first 24h)",
            [options](const std::string& text) {
              options->keep.max_age = std::chrono::seconds(static_cast<std::int64_t>(
                  std::ceil(parseDuration("--max-age", text))));
            });
  addParsed(app,
            "--max-size",
            "SIZE",
            "delete the oldest above (as before; at first no limit)",
            [options](const std::string& text) {
              options->keep.max_bytes =
                  static_cast<std::uint64_t>(parseBytes("--max-size", text));
            });
  addQuiet(app, options->is_quiet);
  return [options] {
    Console console("keep", options->is_quiet);
    completeLinkSettings(options->link);
    link::KeptFrames kept;
    throwUnlessOk(link::keepFrames(options->link, options->keep, kept));
    if (kept.messages == 0)
      requestIFrames(options->link);
    constexpr double megabyte = 1e6;
    console.summary(
        "the server keeps the frames of site " + options->link.site + " " +
        describeLimits(kept) + "; now " + counted(kept.messages, "frame") + ", " +
        measuring::formatted(static_cast<double>(kept.bytes) / megabyte, 2) + " MB" +
        (kept.messages_deleted > 0
             ? "; " + counted(kept.messages_deleted, "frame") + " deleted"
             : ""));
    return int(all_done);
  };
}

} // namespace pcl_ext::tools
