/** \file
 * Fuzz target: SensorPreprocessor on any PCLPointCloud2 does what its header says, which a
 * reference does once more, one point and one field at a time: the same points, or a refusal
 * for a reason that is there; and no byte outside the cloud's data is read.
 *
 * The input describes a layout that makes sense, then lies about it, then the bytes of the
 * points.
 */
#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/intensity/intensity_model.h>

#include "fuzz_input.h"

#include <pcl/PCLPointCloud2.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext;
using pcl_ext::fuzz::FuzzInput;
using pcl_ext::fuzz::require;

using Code = PreprocessingCode;
using Output = pcl::PointCloud<pcl::PointXYZI>;
using QuadraticIntensity = IntensityModel<KinectV2, QuadraticLaw>;

constexpr double resolution = 0.04;

// ---------------------------------------------------------------- what is processed

/** \brief The pose as numbers that a product does not round: where the sensor's axes lie
 * in the world, by axis and sign, and a translation. */
struct Pose {
  std::array<std::size_t, 3> source{0, 1, 2}; ///< sensor axis of each world axis
  std::array<float, 3> sign{1.0f, 1.0f, 1.0f};
  std::array<float, 3> translation{};

  /** \brief False if it is a mirror or not finite. */
  bool
  isRigid() const
  {
    const bool is_odd = (source[0] + 1) % 3 != source[1];
    const float determinant = sign[0] * sign[1] * sign[2] * (is_odd ? -1.0f : 1.0f);
    return determinant > 0.0f &&
           std::all_of(translation.begin(), translation.end(), [](float number) {
             return std::isfinite(number);
           });
  }
};

struct Settings {
  Pose pose;
  std::optional<std::array<std::array<float, 3>, 2>> crop_box;
  float scale = 1.0f;
  std::string intensity_field = "intensity";

  bool
  areValid() const
  {
    if (!pose.isRigid() || !std::isfinite(scale) || !(scale > 0.0f))
      return false;
    for (std::size_t axis = 0; crop_box && axis < 3; ++axis)
      if (!((*crop_box)[0][axis] <= (*crop_box)[1][axis]))
        return false;
    return true;
  }
};

/** \brief A float that is small, or any. */
float
anyFloat(FuzzInput& input)
{
  const std::uint8_t kind = input.byte();
  if (kind < 192)
    return 0.25f * (static_cast<float>(kind) - 96.0f);
  const auto bits = input.number<std::uint32_t>();
  float number;
  std::memcpy(&number, &bits, sizeof(number));
  return number;
}

Settings
settingsOf(FuzzInput& input)
{
  Settings settings;
  const std::uint8_t choices = input.byte();
  if ((choices & 1) != 0) {
    constexpr std::size_t sources[6][3] = {
        {0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    const std::uint8_t rotation = input.byte();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      settings.pose.source[axis] = sources[rotation % 6][axis];
      settings.pose.sign[axis] = (rotation >> (5 + axis) & 1) != 0 ? -1.0f : 1.0f;
      settings.pose.translation[axis] = anyFloat(input);
    }
  }
  if ((choices & 2) != 0) {
    settings.crop_box.emplace();
    for (std::array<float, 3>& corner : *settings.crop_box)
      for (float& number : corner)
        number = anyFloat(input);
  }
  if ((choices & 4) != 0)
    settings.scale = anyFloat(input);
  if ((choices & 8) != 0)
    settings.intensity_field = "reflectivity";
  return settings;
}

/** \brief Bytes of a number of a datatype; 0: there is no such datatype. 9, 10 and 11 are
 * INT64, UINT64 and BOOL, which PCL names since 1.13. */
std::size_t
sizeOf(std::uint8_t datatype)
{
  constexpr std::size_t sizes[] = {0, 1, 1, 2, 2, 4, 4, 4, 8, 8, 8, 1};
  return datatype < std::size(sizes) ? sizes[datatype] : 0;
}

pcl::PCLPointCloud2
layoutOf(FuzzInput& input)
{
  pcl::PCLPointCloud2 cloud;
  cloud.header.frame_id = "sensor";
  cloud.header.stamp = 99;
  const std::uint8_t size = input.byte();
  cloud.width = size % 16;
  cloud.height = 1 + size / 16 % 4;
  if (size >= 192)
    cloud.width += input.byte(); // more than what is processed at once
  const std::uint8_t kind = input.byte();
  const auto coordinate = static_cast<std::uint8_t>(
      (kind & 1) != 0 ? pcl::PCLPointField::FLOAT64 : pcl::PCLPointField::FLOAT32);
  // In any order, each behind the one before it, with gaps.
  std::array<const char*, 6> names = {
      "x", "y", "z", "intensity", "reflectivity", "ring"};
  if ((kind & 2) != 0)
    std::rotate(names.begin(), names.begin() + input.byte() % 6, names.end());
  if ((kind & 4) != 0)
    std::swap(names[input.byte() % 6], names[input.byte() % 6]);
  for (const char* const name : names) {
    pcl::PCLPointField field;
    field.name = name;
    field.count = 1;
    field.datatype = coordinate;
    if (field.name.size() > 1)
      field.datatype = static_cast<std::uint8_t>(
          (kind & 8) != 0 ? 1 + input.byte() % 11 : int{pcl::PCLPointField::FLOAT32});
    if ((kind & 16) != 0)
      cloud.point_step += input.byte() % 8;
    field.offset = cloud.point_step;
    cloud.point_step += static_cast<std::uint32_t>(sizeOf(field.datatype));
    cloud.fields.push_back(field);
  }
  cloud.row_step = cloud.width * cloud.point_step;
  if ((kind & 32) != 0)
    cloud.row_step += input.byte();
  cloud.data.resize(std::size_t{cloud.row_step} * cloud.height);
  return cloud;
}

/** \brief Any number; small changes are the more likely. */
std::uint32_t
changed(std::uint32_t number, FuzzInput& input)
{
  const std::uint8_t change = input.byte();
  if (change < 128)
    return number + change % 16u - 8u;
  return change < 192 ? change % 16u : input.number<std::uint32_t>();
}

/** \brief Says something else than the layout was made for. */
void
lie(pcl::PCLPointCloud2& cloud, FuzzInput& input)
{
  const std::uint8_t what = input.byte();
  pcl::PCLPointField spare;
  pcl::PCLPointField& field =
      cloud.fields.empty() ? spare : cloud.fields[what / 16 % cloud.fields.size()];
  switch (what % 16) {
  case 0:
    cloud.width = changed(cloud.width, input);
    break;
  case 1:
    cloud.height = changed(cloud.height, input);
    break;
  case 2:
    cloud.point_step = changed(cloud.point_step, input);
    break;
  case 3:
    cloud.row_step = changed(cloud.row_step, input);
    break;
  case 4: // no more than the input pays for
    cloud.data.resize(std::min<std::size_t>(
        changed(static_cast<std::uint32_t>(cloud.data.size()), input), 1 << 16));
    break;
  case 5:
    cloud.is_bigendian = input.byte();
    break;
  case 6:
    field.offset = changed(field.offset, input);
    break;
  case 7:
    field.count = changed(field.count, input);
    break;
  case 8:
    field.datatype = static_cast<std::uint8_t>(changed(field.datatype, input));
    break;
  case 9:
    field.name = field.name == "X" ? "" : "X";
    break;
  case 10: { // a second one of that name
    pcl::PCLPointField second = field;
    second.offset = changed(second.offset, input);
    cloud.fields.push_back(second);
    break;
  }
  case 11:
    if (!cloud.fields.empty())
      cloud.fields.pop_back();
    break;
  case 12:
    field.offset = cloud.fields.empty() ? 0 : cloud.fields.front().offset; // overlaps
    break;
  case 13:
    cloud.data.resize(cloud.data.size() -
                      std::min<std::size_t>(cloud.data.size(), input.byte()));
    break;
  default:
    break;
  }
}

/** \brief Fills the points: small numbers where a field of floats lies, so that crop boxes
 * have something to do, then what is left of the input. */
void
fillData(pcl::PCLPointCloud2& cloud, FuzzInput& input)
{
  const std::vector<std::uint8_t> bytes = input.rest();
  if (bytes.empty())
    return;
  if (bytes[0] < 128) {
    std::uint32_t state = bytes[0];
    for (std::size_t i = 0; i + 4 <= cloud.data.size(); i += 4) {
      state = state * 1664525u + 1013904223u;
      const float number = 0.25f * (static_cast<float>(state >> 24) - 128.0f);
      std::memcpy(&cloud.data[i], &number, sizeof(number));
    }
  }
  for (std::size_t i = 1; i < bytes.size() && i <= cloud.data.size(); ++i)
    cloud.data[i - 1] = bytes[i];
}

// ---------------------------------------------------------------- the reference

/** \brief What is wrong with a cloud; any of it may be named. */
struct Faults {
  bool has_missing_field = false;
  bool has_invalid_field = false;
  bool has_invalid_layout = false;

  bool
  contain(Code code) const
  {
    return (code == Code::MissingField && has_missing_field) ||
           (code == Code::InvalidField && has_invalid_field) ||
           (code == Code::InvalidLayout && has_invalid_layout);
  }

  bool
  areNone() const
  {
    return !has_missing_field && !has_invalid_field && !has_invalid_layout;
  }
};

/** \brief The first field of a name; one that cannot be read is a fault. */
const pcl::PCLPointField*
readableField(const pcl::PCLPointCloud2& cloud, const std::string& name, Faults& faults)
{
  for (const pcl::PCLPointField& field : cloud.fields) {
    if (field.name != name)
      continue;
    const std::size_t size = sizeOf(field.datatype);
    faults.has_invalid_field |= size == 0 || field.count > 1 ||
                                std::uint64_t{field.offset} + size > cloud.point_step;
    return &field;
  }
  faults.has_missing_field = true;
  return nullptr;
}

/** \brief The fields that are read: x, y, z and the intensity if that is. */
using Fields = std::array<const pcl::PCLPointField*, 4>;

Faults
findFaults(const pcl::PCLPointCloud2& cloud,
           const std::string& intensity_field,
           bool needs_intensity,
           Fields& fields)
{
  Faults faults;
  fields = {readableField(cloud, "x", faults),
            readableField(cloud, "y", faults),
            readableField(cloud, "z", faults),
            needs_intensity ? readableField(cloud, intensity_field, faults) : nullptr};
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (fields[axis] != nullptr)
      faults.has_invalid_field |=
          (fields[axis]->datatype != pcl::PCLPointField::FLOAT32 &&
           fields[axis]->datatype != pcl::PCLPointField::FLOAT64) ||
          (fields[0] != nullptr && fields[axis]->datatype != fields[0]->datatype);
  if (cloud.width == 0 || cloud.height == 0)
    return faults;
  // The products need up to 64 bits each; their sum is compared without adding.
  const std::uint64_t row = std::uint64_t{cloud.width} * cloud.point_step;
  const std::uint64_t rows_before = std::uint64_t{cloud.height - 1} * cloud.row_step;
  faults.has_invalid_layout = cloud.point_step == 0 || cloud.is_bigendian != 0 ||
                              row > cloud.row_step || row > cloud.data.size() ||
                              rows_before > cloud.data.size() - row;
  return faults;
}

template <typename NumberT>
NumberT
numberAt(const std::uint8_t* bytes)
{
  NumberT number;
  std::memcpy(&number, bytes, sizeof(number));
  return number;
}

float
readField(const std::uint8_t* point, const pcl::PCLPointField& field)
{
  const std::uint8_t* const bytes = point + field.offset;
  switch (field.datatype) {
  case 1:
    return numberAt<std::int8_t>(bytes);
  case 2:
    return numberAt<std::uint8_t>(bytes);
  case 3:
    return numberAt<std::int16_t>(bytes);
  case 4:
    return numberAt<std::uint16_t>(bytes);
  case 5:
    return static_cast<float>(numberAt<std::int32_t>(bytes));
  case 6:
    return static_cast<float>(numberAt<std::uint32_t>(bytes));
  case 7:
    return numberAt<float>(bytes);
  case 8:
    return static_cast<float>(numberAt<double>(bytes));
  case 9:
    return static_cast<float>(numberAt<std::int64_t>(bytes));
  case 10:
    return static_cast<float>(numberAt<std::uint64_t>(bytes));
  default:
    return *bytes != 0 ? 1.0f : 0.0f;
  }
}

/** \brief A point's intensity as the model's documentation has it. */
double
expectedIntensity(const CountIntensity& /*model*/, float /*depth*/, float /*native*/)
{
  return 1.0;
}

double
expectedIntensity(const NativeIntensity& /*model*/, float /*depth*/, float native)
{
  return static_cast<double>(native);
}

double
expectedIntensity(const QuadraticIntensity& model, float depth, float /*native*/)
{
  const double share =
      std::clamp(static_cast<double>(depth) / model.cutOffDepth(), 0.0, 1.0);
  return share * share;
}

/** \brief Whether a value is a point's intensity times the scale but for rounding, and for
 * what is too small for a float before it is scaled. Beyond a float all is the same. */
bool
isNear(float value, double intensity, float scale)
{
  constexpr auto smallest = static_cast<double>(std::numeric_limits<float>::min());
  constexpr auto largest = static_cast<double>(std::numeric_limits<float>::max());
  const double expected = intensity * static_cast<double>(scale);
  if (!std::isfinite(value))
    return !(std::abs(expected) < 0.999 * largest);
  return std::abs(static_cast<double>(value) - expected) <=
         1e-5 * std::abs(expected) + smallest * (1.0 + static_cast<double>(scale));
}

// ---------------------------------------------------------------- the comparison

template <typename ModelT>
void
requireSamePoints(const pcl::PCLPointCloud2& cloud,
                  const Fields& fields,
                  const Settings& settings,
                  const ModelT& model,
                  const Output& output,
                  const PreprocessingStatistics& statistics)
{
  std::size_t kept = 0;
  std::size_t not_finite = 0;
  // Rows without points may be billions.
  const std::size_t rows = cloud.width == 0 ? 0 : cloud.height;
  for (std::size_t row = 0; row < rows; ++row)
    for (std::size_t column = 0; column < cloud.width; ++column) {
      const std::uint8_t* const point =
          cloud.data.data() + row * cloud.row_step + column * cloud.point_step;
      std::array<float, 3> place{};
      std::array<float, 3> moved{};
      for (std::size_t axis = 0; axis < 3; ++axis)
        place[axis] = readField(point, *fields[axis]);
      bool is_finite = true;
      bool is_within = true;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        moved[axis] = settings.pose.sign[axis] * place[settings.pose.source[axis]] +
                      settings.pose.translation[axis];
        is_finite =
            is_finite && std::isfinite(place[axis]) && std::isfinite(moved[axis]);
        if (settings.crop_box)
          is_within = is_within && moved[axis] >= (*settings.crop_box)[0][axis] &&
                      moved[axis] <= (*settings.crop_box)[1][axis];
      }
      not_finite += is_finite ? 0 : 1;
      if (!is_finite || !is_within)
        continue;
      require(kept < output.size());
      const pcl::PointXYZI& result = output[kept++];
      require(result.x == moved[0] && result.y == moved[1] && result.z == moved[2]);
      const float native = fields[3] != nullptr ? readField(point, *fields[3]) : 0.0f;
      require(isNear(result.intensity,
                     expectedIntensity(model, place[2], native),
                     settings.scale));
    }
  require(output.size() == kept && output.width == kept && output.height == 1);
  const std::size_t points = std::size_t{cloud.width} * cloud.height;
  require(statistics.points == points);
  require(statistics.points_not_finite == not_finite);
  require(statistics.points_cropped == points - kept - not_finite);
  require(output.is_dense && output.header.frame_id == cloud.header.frame_id &&
          output.header.stamp == cloud.header.stamp);
}

template <typename ModelT>
void
requireSame(const pcl::PCLPointCloud2& cloud, const Settings& settings)
{
  const ModelT model(resolution);
  SensorPreprocessor<ModelT> preprocessor(model);
  preprocessor.setIntensityField(settings.intensity_field);
  preprocessor.setIntensityScale(settings.scale);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear().setZero();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto row = static_cast<Eigen::Index>(axis);
    pose.linear()(row, static_cast<Eigen::Index>(settings.pose.source[axis])) =
        static_cast<double>(settings.pose.sign[axis]);
    pose.translation()[row] = static_cast<double>(settings.pose.translation[axis]);
  }
  preprocessor.setSensorPose(pose);
  if (settings.crop_box) {
    const auto& [min, max] = *settings.crop_box;
    preprocessor.setCropBox(Eigen::Vector3f(min.data()), Eigen::Vector3f(max.data()));
  }
  Output output;
  output.resize(3); // of an earlier call
  const PreprocessingStatus status = preprocessor.process(cloud, output);

  Fields fields;
  const Faults faults =
      findFaults(cloud, settings.intensity_field, ModelT::uses_native, fields);
  if (status.ok()) {
    require(settings.areValid() && faults.areNone());
    requireSamePoints(
        cloud, fields, settings, model, output, preprocessor.getStatistics());
    return;
  }
  require(!status.message().empty());
  require(output.empty() && output.width == 0);
  require(preprocessor.getStatistics().points == 0);
  require(status.code() == Code::InvalidSettings ? !settings.areValid()
                                                 : faults.contain(status.code()));
}

} // namespace

extern "C" int
LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  FuzzInput input(data, size);
  const std::uint8_t choices = input.byte();
  const Settings settings = settingsOf(input);
  pcl::PCLPointCloud2 cloud = layoutOf(input);
  for (int lies = choices / 4 % 4; lies > 0; --lies)
    lie(cloud, input);
  fillData(cloud, input);
  // Ends where the memory ends, so that a sanitizer sees the first byte too many.
  cloud.data.shrink_to_fit();
  switch (choices % 4) {
  case 0:
    requireSame<CountIntensity>(cloud, settings);
    break;
  case 1:
    requireSame<QuadraticIntensity>(cloud, settings);
    break;
  default:
    requireSame<NativeIntensity>(cloud, settings);
  }
  return 0;
}
