// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/link/frame_subscriber.h>
#include <pcl_ext/nodes/impl/health_metrics.h>

#include "commands/commands.h"
#include "commands/receive_options.h"
#include "console/console.h"
#include "console/events.h"
#include "console/exit_status.h"
#include "console/interruption.h"
#include "console/throw_unless_ok.h"
#include "link/link_metrics.h"
#include "live/link_output.h"
#include "live/status_line.h"
#include "options/link_options.h"
#include "site/missing_streams.h"
#include "site/replay_progress.h"
#include "site/site_report.h"

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>

namespace pcl_ext::tools {

namespace {

class Receive {
public:
  explicit Receive(const ReceiveOptions& options)
  : options_(options), console_("receive", options.is_quiet)
  {}

  int
  run()
  {
    completeLinkSettings(options_.link.link);
    options_.link.link = LinkOutput::withEvents(std::move(options_.link.link), events_);
    subscriber_ = std::make_unique<link::FrameSubscriber>(options_.link);
    openTakers();
    LinkOutput::connect(*subscriber_);
    console_.remark("receiving from site " + options_.link.link.site + "; Ctrl-C ends");
    if (options_.centre.is_replay)
      replay_.emplace(*subscriber_, console_);
    tellFailure([&] { receiveAll(); });
    if (replay_)
      replay_->show();
    console_.endProgress();
    for (FrameTaker* const taker : takers_) {
      tellFailure([&] { taker->finish(); });
      has_failed_ |= taker->hasLeftOut();
    }
    if (merged_)
      merged_->end(); // so that it is known which frames the server has
    events_.print(console_);
    const SiteFigures all = figures();
    has_failed_ |= missing_.report(all.received, !isInterrupted());
    has_failed_ |= !report(all, console_);
    if (!replay_ && !all.received.is_connected) {
      console_.error(
          "the connection to the server is lost: what was sent since then is "
          "missing");
      has_failed_ = true;
    }
    // A replay has an end of its own.
    if (isInterrupted() && replay_)
      return interrupted;
    return has_failed_ ? something_failed : all_done;
  }

private:
  /** \brief Does some work, and tells why if it fails.
   * \return false if it has failed
   */
  template <typename WorkT>
  bool
  tellFailure(const WorkT& work)
  {
    try {
      work();
      return true;
    }
    catch (const UsageError&) {
      throw;
    }
    catch (const std::exception& error) {
      // A part whose work failed often ends with the same reason.
      if (error.what() != std::exchange(told_failure_, error.what()))
        console_.error(error.what());
      has_failed_ = true;
    }
    return false;
  }

  /** \brief Has each part do some work. One that fails does no more, and the others go
   * on. */
  template <typename WorkT>
  void
  forParts(const WorkT& work)
  {
    for (FrameTaker* const taker : takers_)
      if (failed_.count(taker) == 0 && !tellFailure([&] { work(*taker); }))
        failed_.insert(taker);
  }

  bool
  haveAllFailed() const
  {
    return !takers_.empty() && failed_.size() == takers_.size();
  }

  void
  request(const std::string& stream)
  {
    subscriber_->requestIFrame(stream);
  }

  void
  openTakers()
  {
    const auto request = [this](const std::string& stream) { this->request(stream); };
    if (!options_.output.path.empty())
      takers_.push_back(&recording_.emplace(options_.output,
                                            options_.rotation,
                                            options_.centre.is_replay,
                                            request,
                                            console_));
    if (options_.centre.isOn())
      takers_.push_back(&centre_.emplace(options_.centre, request, console_));
    if (!options_.centre.name.empty()) {
      link::LinkSettings merged = options_.link.link;
      merged.site = options_.merged_site;
      merged_ = std::make_unique<LinkOutput>(
          merged, "", [this](std::size_t) { centre_->requestIFrame(); }, events_);
      centre_->addOutput(*merged_);
    }
    if (options_.view.is_on) {
      view_ = makeSiteView(
          options_.view,
          "site " + options_.link.link.site,
          request,
          [this] { return metrics(); },
          console_);
      takers_.push_back(view_.get());
    }
    served_metrics_ = serveMetrics(
        options_.metrics, [this] { return metrics(); }, console_);
  }

  /** \brief Called by the server's thread. */
  std::string
  metrics() const
  {
    std::string text = link::linkMetrics(subscriber_->statistics());
    if (centre_)
      text += nodes::streamMetrics(centre_->health(), nodes::systemTime()) +
              nodes::mergeMetrics(centre_->mergeCounts());
    if (const auto mapped = centre_ ? centre_->mapCounts() : std::nullopt)
      text += nodes::mapMetrics(*mapped);
    if (merged_)
      text += link::linkMetrics(merged_->statistics());
    return text;
  }

  void
  receiveAll()
  {
    using Clock = std::chrono::steady_clock;
    constexpr std::chrono::milliseconds work_interval{5};
    // A centre may have merged frames to make without that a frame comes.
    const std::chrono::milliseconds patience(centre_ ? 2 : 10);
    constexpr std::chrono::milliseconds last_patience{200};
    const Clock::time_point start = Clock::now();
    const auto is_over = [&] {
      return isInterrupted() ||
             (options_.seconds &&
              std::chrono::duration<double>(Clock::now() - start).count() >=
                  *options_.seconds);
    };
    Clock::time_point next_work;
    std::optional<Clock::time_point> end; // when also what is under way has to be there
    bool is_taken = true;
    while (is_taken && !haveAllFailed() && (!end || Clock::now() < *end)) {
      is_taken = takeNext(patience);
      if (!end && is_over())
        end = replay_ ? Clock::now() : Clock::now() + last_patience;
      // Not for each of thousands of frames, but in a replay, whose time they are.
      const bool is_due = !has_taken_frame_ || Clock::now() >= next_work;
      if (is_due || replay_)
        forParts([](FrameTaker& taker) { taker.work(); });
      if (!is_due)
        continue;
      if (replay_)
        replay_->show();
      events_.print(console_);
      tellConnection();
      missing_.remark(*subscriber_, Clock::now() - start);
      remarkOnSlowness();
      if (!replay_)
        status_.update([this] { return liveFiguresOf(figures()); });
      next_work = Clock::now() + work_interval;
    }
    subscriber_->stop();
    // What is counted is taken, too.
    do
      takeNext(std::chrono::milliseconds(0));
    while (has_taken_frame_);
  }

  /** \brief Takes the next frame, if there is one in time.
   * \return false if none can come any more
   */
  bool
  takeNext(std::chrono::milliseconds patience)
  {
    const auto status = subscriber_->next(frame_, patience);
    has_taken_frame_ = status.ok();
    if (status.ok())
      forParts([this](FrameTaker& taker) { taker.take(frame_); });
    else if (status.code() != link::LinkCode::NoFrame &&
             status.code() != link::LinkCode::EndOfReplay)
      throwUnlessOk(status);
    return status.code() != link::LinkCode::EndOfReplay;
  }

  /** \brief Tells the page whether there is a connection to the site. */
  void
  tellConnection()
  {
    const bool is_connected = subscriber_->isConnected();
    if (is_connected == std::exchange(was_connected_, is_connected))
      return;
    for (FrameTaker* const taker : takers_)
      taker->setProblem(is_connected ? ""
                                     : "The connection to the server of site " +
                                           options_.link.link.site + " is lost");
  }

  SiteFigures
  figures() const
  {
    SiteFigures figures;
    figures.site = options_.link.link.site;
    figures.received = subscriber_->statistics();
    if (centre_) {
      figures.decoded = centre_->health();
      figures.missing = centre_->missing();
      figures.merged_resolution = centre_->mergedResolution();
      figures.has_slow_effort = centre_->hasSlowEffort();
      figures.merged = centre_->mergeCounts();
      figures.mapped = centre_->mapCounts().value_or(nodes::MapCounts());
    }
    if (merged_)
      figures.published = merged_->statistics();
    if (recording_ && failed_.count(&*recording_) > 0)
      figures.recorded = recording_->framesWritten();
    return figures;
  }

  /** \brief Says now and then that this machine is too slow, while it is. */
  void
  remarkOnSlowness()
  {
    constexpr std::chrono::seconds interval{10};
    const auto now = std::chrono::steady_clock::now();
    if (!centre_ || now < next_remark_)
      return;
    const auto remark = [&](std::size_t count, std::size_t& told, const auto& text) {
      if (count == std::exchange(told, count))
        return;
      next_remark_ = now + interval;
      console_.remark(text);
    };
    const nodes::MergeCounts merged = centre_->mergeCounts();
    const auto mapped = centre_->mapCounts().value_or(nodes::MapCounts());
    remark(
        merged.left_out, told_left_out_, slownessOf(merged, centre_->hasSlowEffort()));
    remark(mapped.left_out, told_updates_left_out_, slownessOf(mapped));
  }

  ReceiveOptions options_;
  Console console_;
  MissingStreams missing_{options_.link, console_};
  Events events_;
  // Before those that request I-frames of it.
  std::unique_ptr<link::FrameSubscriber> subscriber_;
  std::optional<ReplayProgress> replay_; // none: frames come live
  std::optional<RotatedRecording> recording_;
  std::unique_ptr<LinkOutput> merged_;
  std::optional<Centre> centre_;
  std::unique_ptr<FrameTaker> view_;
  std::vector<FrameTaker*> takers_;
  std::set<const FrameTaker*> failed_;   // of these
  std::shared_ptr<void> served_metrics_; // after what they are of
  StatusLine status_{console_};
  link::LinkFrame frame_; // keeps its memory
  bool has_taken_frame_ = false;
  std::string told_failure_; // the last one
  bool has_failed_ = false;
  bool was_connected_ = true;
  // See remarkOnSlowness().
  std::size_t told_left_out_ = 0;         // merged frames
  std::size_t told_updates_left_out_ = 0; // of the map
  std::chrono::steady_clock::time_point next_remark_;
};

} // namespace

Run
addReceive(CLI::App& app)
{
  const auto options = std::make_shared<ReceiveOptions>();
  addReceiveOptions(app, *options);
  return [options, &app] {
    completeOptions(app, *options);
    return Receive(*options).run();
  };
}

} // namespace pcl_ext::tools
