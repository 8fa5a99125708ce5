// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The module pcl_ext._link: frames over NATS for the classes of pcl_ext.link,
 * which have the documentation. Outcomes are returned as tuples with the name of their
 * code.
 */
#include <pcl_ext/compression/i_frame_requests.h>
#include <pcl_ext/link/frame_publisher.h>
#include <pcl_ext/link/frame_subscriber.h>

#include "bindings.h"

#include <pybind11/stl.h>

#include <array>
#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

namespace pcl_ext::python {

namespace {

using std::chrono::milliseconds;

const char*
codeName(link::LinkCode code)
{
  constexpr std::array<const char*, 11> names = {"Ok",
                                                 "InvalidSettings",
                                                 "InvalidArgument",
                                                 "CannotConnect",
                                                 "Refused",
                                                 "NotConnected",
                                                 "FrameTooLarge",
                                                 "NoFrame",
                                                 "EndOfReplay",
                                                 "Closed",
                                                 "OutOfMemory"};
  return names[static_cast<std::size_t>(code)];
}

py::tuple
outcome(const link::LinkStatus& status)
{
  return py::make_tuple(codeName(status.code()), text(status.message()));
}

/** \brief Bytes that are a text of Python: names of streams may be any. */
py::str
nameOf(const std::string& bytes)
{
  return py::reinterpret_steal<py::str>(PyUnicode_DecodeUTF8(
      bytes.data(), static_cast<py::ssize_t>(bytes.size()), "surrogateescape"));
}

py::dict
metadataOf(const link::StreamMetadata& metadata)
{
  py::dict pairs;
  for (const auto& [key, value] : metadata)
    pairs[nameOf(key)] = nameOf(value);
  return pairs;
}

link::LinkSettings
linkSettings(const std::map<std::string, std::string>& values, double timeout)
{
  link::LinkSettings settings;
  const std::pair<const char*, std::string*> members[] = {
      {"servers", &settings.servers},
      {"site", &settings.site},
      {"client_name", &settings.client_name},
      {"user", &settings.user},
      {"password", &settings.password},
      {"token", &settings.token},
      {"credentials_file", &settings.credentials_file},
      {"ca_file", &settings.ca_file},
      {"certificate_file", &settings.certificate_file},
      {"key_file", &settings.key_file}};
  for (const auto& [name, member] : members)
    *member = values.at(name);
  settings.connect_timeout = milliseconds(static_cast<std::int64_t>(1000.0 * timeout));
  return settings;
}

class Publisher {
public:
  Publisher(const std::map<std::string, std::string>& values, double timeout)
  : publisher_(linkSettings(values, timeout),
               [this](std::size_t stream) { request(stream); })
  {}

  py::tuple
  connect()
  {
    return outcome(withoutGil([&] { return publisher_.connect(); }));
  }

  py::tuple
  addStream(const std::string& name, const link::StreamMetadata& metadata)
  {
    std::size_t stream = 0;
    const link::LinkStatus status =
        withoutGil([&] { return publisher_.addStream(name, metadata, stream); });
    return py::make_tuple(stream, codeName(status.code()), text(status.message()));
  }

  py::tuple
  publish(std::size_t stream, const py::object& data, std::int64_t nanoseconds)
  {
    const ByteView bytes(data);
    if (bytes.size() == 0)
      return outcome({}); // a cloud that max_rate left out
    const link::LinkStatus status = withoutGil([&] {
      return publisher_.publish(
          stream, link::Time(nanoseconds), bytes.data(), bytes.size());
    });
    const std::lock_guard<std::mutex> lock(mutex_);
    if (const auto found = requests_.find(stream); found != requests_.end())
      found->second.countFrame();
    return outcome(status);
  }

  bool
  wantsIFrame(std::size_t stream)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = requests_.find(stream);
    return found != requests_.end() && found->second.take();
  }

  bool
  flush(double timeout)
  {
    return withoutGil([&] {
      return publisher_.flush(
          milliseconds(static_cast<std::int64_t>(1000.0 * timeout)));
    });
  }

  py::dict
  statistics() const
  {
    const link::PublisherStatistics statistics = publisher_.statistics();
    py::dict values;
    values["frames"] = statistics.frames;
    values["bytes"] = statistics.bytes;
    values["frames_under_way"] = statistics.frames_under_way;
    values["frames_not_sent"] = statistics.frames_not_sent;
    values["frames_unanswered"] = statistics.frames_unanswered;
    values["i_frame_requests"] = statistics.i_frame_requests;
    values["reconnections"] = statistics.reconnections;
    values["is_connected"] = statistics.is_connected;
    return values;
  }

private:
  void
  request(std::size_t stream)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    requests_[stream].add();
  }

  std::mutex mutex_;
  std::map<std::size_t, io::IFrameRequests> requests_; // of streams that had some
  link::FramePublisher publisher_;
};

class Subscriber {
public:
  Subscriber(const std::map<std::string, std::string>& values,
             double timeout,
             const std::vector<std::string>& streams,
             const std::optional<unsigned int>& partition,
             const std::optional<std::int64_t>& replay_from,
             std::size_t max_waiting_bytes)
  : subscriber_([&] {
    link::SubscriberSettings settings;
    settings.link = linkSettings(values, timeout);
    settings.streams = streams;
    settings.partition = partition;
    if (replay_from)
      settings.replay_from = link::Time(*replay_from);
    settings.max_waiting_bytes = max_waiting_bytes;
    return settings;
  }())
  {}

  py::tuple
  connect()
  {
    return outcome(withoutGil([&] { return subscriber_.connect(); }));
  }

  /** \brief The next frame, or none and why. */
  py::tuple
  next(double timeout)
  {
    link::LinkFrame frame;
    const link::LinkStatus status = withoutGil([&] {
      return subscriber_.next(
          frame, milliseconds(static_cast<std::int64_t>(1000.0 * timeout)));
    });
    if (!status.ok())
      return py::make_tuple(
          py::none(), codeName(status.code()), text(status.message()));
    return py::make_tuple(
        py::make_tuple(nameOf(frame.stream),
                       frame.time.count(),
                       py::bytes(reinterpret_cast<const char*>(frame.bytes.data()),
                                 frame.bytes.size()),
                       frame.is_i_frame,
                       metadataOf(frame.metadata)),
        codeName(status.code()),
        text(status.message()));
  }

  void
  requestIFrame(const std::string& stream)
  {
    withoutGil([&] {
      subscriber_.requestIFrame(stream);
      return true;
    });
  }

  static std::optional<double>
  secondsOf(const std::optional<std::chrono::nanoseconds>& age)
  {
    return age ? std::make_optional(std::chrono::duration<double>(*age).count())
               : std::nullopt;
  }

  py::list
  statistics() const
  {
    py::list streams;
    for (const link::LinkStreamStatistics& stream : subscriber_.statistics().streams)
      streams.append(py::make_tuple(nameOf(stream.name),
                                    stream.frames,
                                    stream.bytes,
                                    stream.frames_lost,
                                    stream.frames_dropped,
                                    stream.frames_skipped,
                                    stream.frames_early,
                                    stream.frames_late,
                                    stream.frames_damaged,
                                    stream.messages_invalid,
                                    stream.i_frame_requests,
                                    stream.publishers,
                                    secondsOf(stream.age)));
    return streams;
  }

private:
  link::FrameSubscriber subscriber_;
};

} // namespace

PYBIND11_MODULE(_link, module)
{
  py::class_<Publisher>(module, "Publisher")
      .def(py::init<const std::map<std::string, std::string>&, double>())
      .def("connect", &Publisher::connect)
      .def("add_stream", &Publisher::addStream)
      .def("publish", &Publisher::publish)
      .def("wants_i_frame", &Publisher::wantsIFrame)
      .def("flush", &Publisher::flush)
      .def("statistics", &Publisher::statistics);
  py::class_<Subscriber>(module, "Subscriber")
      .def(py::init<const std::map<std::string, std::string>&,
                    double,
                    const std::vector<std::string>&,
                    const std::optional<unsigned int>&,
                    const std::optional<std::int64_t>&,
                    std::size_t>())
      .def("connect", &Subscriber::connect)
      .def("next", &Subscriber::next)
      .def("request_i_frame", &Subscriber::requestIFrame)
      .def("statistics", &Subscriber::statistics);
}

} // namespace pcl_ext::python
