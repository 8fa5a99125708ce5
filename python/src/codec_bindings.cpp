// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/frame_decoder.h>

#include "array_decoder.h"
#include "array_encoder.h"
#include "bindings.h"
#include "cloud_arrays.h"
#include "outlier_filter.h"
#include "stream_settings.h"
#include "temporal_filter.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::python {

namespace {

using namespace py::literals;

py::dict
asDict(const io::CodedFrameStatistics& coding)
{
  return py::dict("frame_number"_a = coding.frame_number,
                  "is_i_frame"_a = coding.is_i_frame,
                  "is_of_changes"_a = coding.is_of_changes,
                  "has_points"_a = coding.has_points,
                  "voxels"_a = coding.voxels,
                  "bytes"_a = coding.bytes,
                  "header_bytes"_a = coding.header_bytes,
                  "occupancy_bytes"_a = coding.occupancy_bytes,
                  "intensity_bytes"_a = coding.intensity_bytes,
                  "attribute_bytes"_a = coding.attribute_bytes,
                  "skipped_bytes"_a = coding.skipped_bytes);
}

/** \brief Figures of the cloud of an encoded frame. */
py::dict
cloudAsDict(const io::FrameStatistics& frame)
{
  const io::VoxelizationStatistics& cloud = frame.voxelization;
  return py::dict("resolution"_a = cloud.resolution,
                  "points"_a = cloud.points,
                  "points_used"_a = cloud.points_used,
                  "points_not_finite"_a = cloud.points_not_finite,
                  "points_outside_box"_a = cloud.points_outside_box,
                  "points_outside_grid"_a = cloud.points_outside_grid,
                  "points_behind_sensor"_a = cloud.points_behind_sensor,
                  "intensities_not_finite"_a = cloud.intensities_not_finite,
                  "intensities_out_of_range"_a = cloud.intensities_out_of_range,
                  "intensities_vanished"_a = cloud.intensities_vanished,
                  "colours_left_out"_a = cloud.colours_left_out,
                  "alphas_left_out"_a = cloud.alphas_left_out,
                  "voxels_hidden"_a = frame.voxels_hidden,
                  "voxels_held"_a = frame.voxels_held,
                  "is_sensor_moving"_a =
                      frame.sensor_motion == io::SensorMotion::Moving);
}

py::dict
asDict(const io::RateControlStatus& status)
{
  return py::dict("max_rate"_a = status.max_rate,
                  "used_rate"_a = status.used_rate,
                  "encode_ms"_a = status.encode_ms,
                  "resolution"_a = status.resolution,
                  "step"_a = status.step_number,
                  "last_step"_a = status.last_step,
                  "changes"_a = status.changes,
                  "clouds_left_out"_a = status.clouds_left_out,
                  "choice"_a = status.choice,
                  "reason"_a = status.reason,
                  "not_kept"_a = status.not_kept);
}

/** \brief stamp is None, or microseconds and a frame_id. */
py::tuple
encode(ArrayEncoder& encoder,
       const py::object& xyz,
       const py::object& intensity,
       const py::object& colour,
       const std::optional<std::pair<std::uint64_t, std::string>>& stamp,
       const py::object& sensor_pose,
       OutlierFilter* outliers)
{
  const CloudArrays arrays(xyz, intensity, colour);
  CloudToEncode cloud{
      arrays.columns(), arrays.hasIntensityArgument(), {}, {}, outliers};
  if (stamp)
    cloud.stamp = io::FrameStamp{stamp->first, stamp->second};
  if (!sensor_pose.is_none())
    cloud.sensor_pose = readPose(sensor_pose);
  std::vector<std::uint8_t> bytes;
  const io::CompressionStatus status =
      withoutGil([&] { return encoder.encode(cloud, bytes); });
  py::object frame = py::none();
  if (status.ok() || status.code() == io::CompressionCode::LeftOut)
    frame = py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return outcome(frame, status);
}

py::tuple
decode(ArrayDecoder& decoder,
       const py::object& data,
       OutlierFilter* outliers,
       std::optional<float> min_intensity,
       TemporalFilter* temporal_filter)
{
  const ByteView bytes(data);
  std::optional<DecodedCloud> cloud;
  const io::CompressionStatus status = withoutGil([&] {
    return decoder.decode(
        bytes.data(), bytes.size(), {outliers, min_intensity, temporal_filter}, cloud);
  });
  return outcome(cloud ? py::object(cloud->intoArray()) : py::none(), status);
}

py::tuple
decodeChanges(ArrayDecoder& decoder, const py::object& data)
{
  const ByteView bytes(data);
  std::optional<ArrayDecoder::Changes> changes;
  const io::CompressionStatus status = withoutGil(
      [&] { return decoder.decodeChanges(bytes.data(), bytes.size(), changes); });
  py::object parts = py::none();
  if (changes)
    parts = py::make_tuple(
        changes->gone.intoArray(), changes->came.intoArray(), changes->is_from_nothing);
  return outcome(parts, status);
}

py::object
stampOf(const ArrayDecoder& decoder)
{
  const std::optional<io::FrameStamp> stamp =
      withoutGil([&] { return decoder.stamp(); });
  if (!stamp)
    return py::none();
  return py::make_tuple(stamp->stamp, text(stamp->frame_id));
}

py::array_t<float>
score(OutlierFilter& outliers, ArrayDecoder& decoder)
{
  const ArrayDecoder::Scores scores =
      withoutGil([&] { return decoder.score(outliers); });
  const auto rows = static_cast<py::ssize_t>(scores.rows);
  const auto columns = static_cast<py::ssize_t>(scores.columns);
  if (rows == 1)
    return py::array_t<float>(columns, scores.log_odds.data());
  return py::array_t<float>({rows, columns}, scores.log_odds.data());
}

/** \brief Log-odds of the points of a cloud, in its shape. */
py::array_t<float>
scorePoints(PointFilter& outliers, const py::object& xyz)
{
  const CloudArrays arrays(xyz, py::none(), py::none());
  const std::vector<float> log_odds =
      withoutGil([&] { return outliers.score(arrays.columns()); });
  return py::array_t<float>(arrays.shape(), log_odds.data());
}

template <typename FilterT>
py::tuple
statusOf(const FilterT& outliers)
{
  const OutlierRemovalStatus status = withoutGil([&] { return outliers.status(); });
  return py::make_tuple(
      codeName(status.code()), text(status.message()), status.removed);
}

py::tuple
frameSize(const py::object& data, const py::dict& limits)
{
  const ByteView bytes(data);
  const io::DecoderLimits checked = readLimits(limits);
  const io::FrameSize size =
      withoutGil([&] { return io::frameSize(bytes.data(), bytes.size(), checked); });
  return py::make_tuple(codeName(size.status.code()),
                        text(size.status.message()),
                        size.known,
                        size.needed,
                        size.drop);
}

py::dict
sensors()
{
  py::dict sensors;
  for (const auto& [sensor, name] : named_sensors)
    sensors[name] =
        py::make_tuple(sensor.fov_x_deg, sensor.fov_y_deg, sensor.columns, sensor.rows);
  return sensors;
}

py::list
laws()
{
  py::list laws;
  for (const NamedValue<IntensityLaw>& known : intensity_laws)
    laws.append(known.name);
  return laws;
}

/** \brief The types of fields, and what a type must be, in words. */
py::tuple
fieldTypes()
{
  py::set names;
  for (const NamedValue<io::FieldType>& type : io::field_types)
    names.add(type.name);
  return py::make_tuple(names, fieldDemand());
}

void
addEncoder(py::module_& module)
{
  py::class_<ArrayEncoder>(module, "Encoder")
      .def(py::init([](const py::dict& settings) {
             return std::make_unique<ArrayEncoder>(readArrayEncoderSettings(settings));
           }),
           "settings"_a)
      .def("encode",
           &encode,
           "xyz"_a,
           "intensity"_a,
           "colour"_a,
           "stamp"_a,
           "sensor_pose"_a,
           "outliers"_a)
      .def("request_i_frame", &ArrayEncoder::requestIFrame, WithoutGil())
      .def("set_max_rate", &ArrayEncoder::setMaxRate, "bits_per_second"_a, WithoutGil())
      .def("rate_control",
           [](const ArrayEncoder& encoder) {
             return asDict(withoutGil([&] { return encoder.rateControl(); }));
           })
      .def("law",
           [](const ArrayEncoder& encoder) {
             return nameOf(lawChoices(), withoutGil([&] { return encoder.law(); }));
           })
      .def("statistics", [](const ArrayEncoder& encoder) {
        const io::FrameStatistics frame =
            withoutGil([&] { return encoder.statistics(); });
        return py::make_tuple(asDict(frame.coding), cloudAsDict(frame));
      });
}

void
addDecoder(py::module_& module)
{
  py::class_<ArrayDecoder>(module, "Decoder")
      .def(py::init([](const py::dict& limits) {
             return std::make_unique<ArrayDecoder>(readLimits(limits));
           }),
           "limits"_a)
      .def("decode",
           &decode,
           "data"_a,
           "outliers"_a,
           "min_intensity"_a,
           "temporal_filter"_a)
      .def("decode_changes", &decodeChanges, "data"_a)
      .def("stamp", &stampOf)
      .def("statistics", [](const ArrayDecoder& decoder) {
        return asDict(withoutGil([&] { return decoder.statistics(); }));
      });
}

void
addOutlierRemoval(py::module_& module)
{
  py::class_<OutlierFilter>(module, "OutlierRemoval")
      .def(py::init([](const py::dict& settings) {
             return std::make_unique<OutlierFilter>(readRemovalSettings(settings));
           }),
           "settings"_a)
      .def("score", &score, "decoder"_a)
      .def(
          "set_stream",
          [](OutlierFilter& outliers, const std::string& law, bool is_of_lidar) {
            withoutGil([&] {
              outliers.setStream(valueNamed(intensity_laws, law), is_of_lidar);
            });
          },
          "law"_a,
          "is_of_lidar"_a)
      .def("reset", &OutlierFilter::reset, WithoutGil())
      .def("unit",
           [](const OutlierFilter& outliers) {
             return nameOf(density_units, withoutGil([&] { return outliers.unit(); }));
           })
      .def("status", &statusOf<OutlierFilter>);
  py::class_<PointFilter>(module, "PointOutlierRemoval")
      .def(py::init([](const py::dict& settings) {
             return std::make_unique<PointFilter>(readPointRemovalSettings(settings));
           }),
           "settings"_a)
      .def("score", &scorePoints, "xyz"_a)
      .def("reset", &PointFilter::reset, WithoutGil())
      .def("status", &statusOf<PointFilter>);
}

void
addTemporalFilter(py::module_& module)
{
  py::class_<TemporalFilter>(module, "TemporalVoxelFilter")
      .def(py::init([](const py::dict& settings) {
             return std::make_unique<TemporalFilter>(
                 readTemporalFilterSettings(settings));
           }),
           "settings"_a)
      .def("reset", &TemporalFilter::reset, WithoutGil())
      .def("status", [](const TemporalFilter& filter) {
        const TemporalFilterStatus status = withoutGil([&] { return filter.status(); });
        return py::make_tuple(codeName(status.code()),
                              text(status.message()),
                              status.hidden,
                              status.held);
      });
}

} // namespace

void
addCodec(py::module_& module)
{
  addEncoder(module);
  addDecoder(module);
  addOutlierRemoval(module);
  addTemporalFilter(module);
  module.def("frame_size", &frameSize, "data"_a, "limits"_a);
  module.def("default_settings", &defaultSettings);
  module.def("encoder_settings", &encoderSettings);
  module.def("sensors", &sensors);
  module.def("laws", &laws);
  module.def("field_types", &fieldTypes);
}

} // namespace pcl_ext::python
