// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "bindings.h"
#include "recording_file.h"
#include "stream_settings.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::python {

namespace {

using namespace py::literals;
using recording::RecordingStatus;
using recording::Time;
using Reader = recording::RecordingReader;
using Frame = recording::RecordedFrame;

py::tuple
asTuple(const recording::RecordedStream& stream)
{
  py::dict metadata;
  for (const auto& [name, value] : stream.metadata)
    metadata[text(name)] = text(value);
  return py::make_tuple(text(stream.name),
                        stream.frames,
                        stream.has_times,
                        stream.first_time.count(),
                        stream.last_time.count(),
                        metadata);
}

/** \brief Name, dtype, number of values and step of each. */
py::tuple
asTuple(const std::vector<io::FieldDescription>& fields)
{
  py::list all;
  for (const io::FieldDescription& field : fields)
    all.append(py::make_tuple(text(field.name),
                              nameOf(io::field_types, field.type),
                              field.count,
                              field.step));
  return py::tuple(all);
}

py::tuple
asTuple(const recording::RecordedFrame& frame)
{
  const io::FrameDescription& description = frame.description;
  return py::make_tuple(
      frame.stream,
      frame.number,
      frame.time.count(),
      frame.stamp.count(),
      text(frame.frame_id),
      frame.offset,
      description.status.ok() && description.is_i_frame,
      py::bytes(reinterpret_cast<const char*>(frame.bytes.data()), frame.bytes.size()),
      asTuple(description.fields));
}

/** \brief Returns what a function returns that is called with the reader, without the
 * GIL. */
template <typename FunctionT>
auto
ask(const RecordingFile& file, const FunctionT& function)
{
  return withoutGil([&] { return file.withReader(function); });
}

/** \brief The frame that a function reads, and the status. */
template <typename FunctionT>
py::tuple
askForFrame(const RecordingFile& file, const FunctionT& read)
{
  recording::RecordedFrame frame;
  const RecordingStatus status =
      ask(file, [&](Reader& reader) { return read(reader, frame); });
  return outcome(status.ok() ? py::object(asTuple(frame)) : py::none(), status);
}

py::tuple
openFile(RecordingFile& file, const std::string& path, const py::dict& limits)
{
  const auto of_all_streams =
      io::DecoderLimits::ofBudget(std::make_shared<io::MemoryBudget>());
  file.setLimits(readLimits(limits, of_all_streams));
  return outcome(withoutGil([&] { return file.open(path); }));
}

py::list
streamsOf(const RecordingFile& file)
{
  py::list streams;
  for (const recording::RecordedStream& stream :
       ask(file, [](Reader& reader) { return reader.streams(); }))
    streams.append(asTuple(stream));
  return streams;
}

py::list
damageOf(const RecordingFile& file)
{
  py::list all;
  for (const recording::RecordingDamage& damage :
       ask(file, [](Reader& reader) { return reader.damage(); }))
    all.append(py::make_tuple(damage.offset, text(damage.message), text(damage.file)));
  return all;
}

py::tuple
nextFrame(RecordingFile& file)
{
  return askForFrame(file,
                     [](Reader& reader, Frame& frame) { return reader.next(frame); });
}

py::tuple
readFrame(RecordingFile& file, std::size_t stream, std::size_t number)
{
  return askForFrame(file, [&](Reader& reader, Frame& frame) {
    return reader.read(stream, number, frame);
  });
}

py::tuple
decodeFrame(RecordingFile& file,
            std::size_t stream,
            std::size_t number,
            OutlierFilter* outliers,
            std::optional<float> min_intensity)
{
  std::optional<DecodedCloud> cloud;
  const io::CompressionStatus status = withoutGil([&] {
    return file.decode(stream, number, {outliers, min_intensity}, cloud);
  });
  return outcome(cloud ? py::object(cloud->intoArray()) : py::none(), status);
}

void
addReader(py::module_& module)
{
  py::class_<RecordingFile>(module, "Recording")
      .def(py::init<>())
      .def("open", &openFile, "path"_a, "limits"_a)
      .def("close", &RecordingFile::close, WithoutGil())
      .def("streams", &streamsOf)
      .def("next", &nextFrame)
      .def(
          "seek",
          [](RecordingFile& file, std::int64_t time) {
            ask(file, [&](Reader& reader) { reader.seek(Time(time)); });
          },
          "time"_a)
      .def("read", &readFrame, "stream"_a, "number"_a)
      .def("decode",
           &decodeFrame,
           "stream"_a,
           "number"_a,
           "outliers"_a,
           "min_intensity"_a)
      .def(
          "frame_at",
          [](const RecordingFile& file, std::size_t stream, std::int64_t time) {
            return ask(file, [&](Reader& reader) {
              return reader.frameAt(stream, Time(time));
            });
          },
          "stream"_a,
          "time"_a)
      .def(
          "time_of",
          [](const RecordingFile& file, std::size_t stream, std::size_t number) {
            return ask(file, [&](Reader& reader) {
              return reader.timeOf(stream, number).count();
            });
          },
          "stream"_a,
          "number"_a)
      .def("damage", &damageOf)
      .def("is_unfinished",
           [](const RecordingFile& file) {
             return ask(file, [](Reader& reader) { return reader.isUnfinished(); });
           })
      .def("file_bytes", [](const RecordingFile& file) {
        return ask(file, [](Reader& reader) { return reader.fileBytes(); });
      });
}

py::tuple
addStream(RecordingOutput& output,
          const std::string& name,
          const std::string& frame_id,
          const std::map<std::string, std::string>& metadata)
{
  std::size_t number = 0;
  const RecordingStatus status = withoutGil([&] {
    return output.addStream({name, frame_id, metadata}, number);
  });
  return outcome(py::int_(number), status);
}

py::tuple
append(RecordingOutput& output,
       std::size_t stream,
       const py::object& data,
       std::int64_t time)
{
  const ByteView bytes(data);
  return outcome(withoutGil(
      [&] { return output.append(stream, Time(time), bytes.data(), bytes.size()); }));
}

void
addWriter(py::module_& module)
{
  py::class_<RecordingOutput>(module, "RecordingWriter")
      .def(py::init<>())
      .def(
          "open",
          [](RecordingOutput& output, const std::string& path, bool may_replace) {
            return outcome(withoutGil([&] { return output.open(path, may_replace); }));
          },
          "path"_a,
          "may_replace"_a)
      .def("add_stream", &addStream, "name"_a, "frame_id"_a, "metadata"_a)
      .def("append", &append, "stream"_a, "data"_a, "time"_a)
      .def("flush",
           [](RecordingOutput& output) {
             return outcome(withoutGil([&] { return output.flush(); }));
           })
      .def("finish",
           [](RecordingOutput& output) {
             return outcome(withoutGil([&] { return output.finish(); }));
           })
      .def("abandon", &RecordingOutput::abandon, WithoutGil())
      .def("written", [](const RecordingOutput& output) {
        const RecordingOutput::Written written =
            withoutGil([&] { return output.written(); });
        return py::make_tuple(written.is_open, written.streams, written.frames);
      });
}

} // namespace

void
addRecordings(py::module_& module)
{
  addReader(module);
  addWriter(module);
}

} // namespace pcl_ext::python
