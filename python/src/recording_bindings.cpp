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

py::tuple
asTuple(const RecordingStatus& status)
{
  return py::make_tuple(codeName(status.code()), text(status.message()));
}

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

/** \brief The frame and the status. */
py::tuple
frameAndStatus(const recording::RecordedFrame& frame, const RecordingStatus& status)
{
  py::object result = py::none();
  if (status.ok())
    result = asTuple(frame);
  return py::make_tuple(result, codeName(status.code()), text(status.message()));
}

py::tuple
openFile(RecordingFile& file, const std::string& path, const py::dict& limits)
{
  const auto of_all_streams =
      io::DecoderLimits::ofBudget(std::make_shared<io::MemoryBudget>());
  file.setLimits(readLimits(limits, of_all_streams));
  const RecordingStatus status = withoutGil([&] { return file.open(path); });
  return asTuple(status);
}

py::list
streamsOf(const RecordingFile& file)
{
  py::list streams;
  for (const recording::RecordedStream& stream :
       withoutGil([&] { return file.streams(); }))
    streams.append(asTuple(stream));
  return streams;
}

py::list
damageOf(const RecordingFile& file)
{
  py::list all;
  for (const recording::RecordingDamage& damage :
       withoutGil([&] { return file.damage(); }))
    all.append(py::make_tuple(damage.offset, text(damage.message), text(damage.file)));
  return all;
}

py::tuple
nextFrame(RecordingFile& file)
{
  recording::RecordedFrame frame;
  const RecordingStatus status = withoutGil([&] { return file.next(frame); });
  return frameAndStatus(frame, status);
}

py::tuple
readFrame(RecordingFile& file, std::size_t stream, std::size_t number)
{
  recording::RecordedFrame frame;
  const RecordingStatus status =
      withoutGil([&] { return file.read(stream, number, frame); });
  return frameAndStatus(frame, status);
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
  py::object points = py::none();
  if (cloud)
    points = cloud->intoArray();
  return py::make_tuple(points, codeName(status.code()), text(status.message()));
}

void
addReader(py::module_& module)
{
  py::class_<RecordingFile>(module, "Recording")
      .def(py::init<>())
      .def("open", &openFile, "path"_a, "limits"_a)
      .def("close", [](RecordingFile& file) { withoutGil([&] { file.close(); }); })
      .def("streams", &streamsOf)
      .def("next", &nextFrame)
      .def(
          "seek",
          [](RecordingFile& file, std::int64_t time) {
            withoutGil([&] { file.seek(Time(time)); });
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
            return withoutGil([&] { return file.frameAt(stream, Time(time)); });
          },
          "stream"_a,
          "time"_a)
      .def(
          "time_of",
          [](const RecordingFile& file, std::size_t stream, std::size_t number) {
            return withoutGil([&] { return file.timeOf(stream, number).count(); });
          },
          "stream"_a,
          "number"_a)
      .def("damage", &damageOf)
      .def("is_unfinished",
           [](const RecordingFile& file) {
             return withoutGil([&] { return file.isUnfinished(); });
           })
      .def("file_bytes", [](const RecordingFile& file) {
        return withoutGil([&] { return file.fileBytes(); });
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
  return py::make_tuple(number, codeName(status.code()), text(status.message()));
}

py::tuple
append(RecordingOutput& output,
       std::size_t stream,
       const py::object& data,
       std::int64_t time)
{
  const ByteView bytes(data);
  return asTuple(withoutGil(
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
            return asTuple(withoutGil([&] { return output.open(path, may_replace); }));
          },
          "path"_a,
          "may_replace"_a)
      .def("add_stream", &addStream, "name"_a, "frame_id"_a, "metadata"_a)
      .def("append", &append, "stream"_a, "data"_a, "time"_a)
      .def("flush",
           [](RecordingOutput& output) {
             return asTuple(withoutGil([&] { return output.flush(); }));
           })
      .def("finish",
           [](RecordingOutput& output) {
             return asTuple(withoutGil([&] { return output.finish(); }));
           })
      .def("abandon",
           [](RecordingOutput& output) { withoutGil([&] { output.abandon(); }); })
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
