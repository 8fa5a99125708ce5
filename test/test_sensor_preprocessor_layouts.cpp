/** \file
 * \brief SensorPreprocessor on PCLPointCloud2: any layout that makes sense is read, any
 * that does not is refused by name.
 */
#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/intensity/intensity_model.h>

#include <pcl/conversions.h>
#include <pcl/PCLPointCloud2.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace {

using pcl::PCLPointCloud2;
using pcl::PCLPointField;
using pcl_ext::CountIntensity;
using pcl_ext::NativeIntensity;
using pcl_ext::PreprocessingCode;
using pcl_ext::PreprocessingStatus;
using pcl_ext::SensorPreprocessor;

using Output = pcl::PointCloud<pcl::PointXYZI>;

PCLPointField
makeField(const std::string& name,
          std::uint32_t offset,
          std::uint8_t datatype,
          std::uint32_t count = 1)
{
  PCLPointField field;
  field.name = name;
  field.offset = offset;
  field.datatype = datatype;
  field.count = count;
  return field;
}

template <typename NumberT>
void
put(std::uint8_t* place, double value)
{
  const auto number = static_cast<NumberT>(value);
  std::memcpy(place, &number, sizeof(number));
}

void
writeNumber(std::uint8_t* place, std::uint8_t datatype, double value)
{
  switch (datatype) {
  case PCLPointField::INT8:
    return put<std::int8_t>(place, value);
  case PCLPointField::UINT8:
    return put<std::uint8_t>(place, value);
  case PCLPointField::INT16:
    return put<std::int16_t>(place, value);
  case PCLPointField::UINT16:
    return put<std::uint16_t>(place, value);
  case PCLPointField::INT32:
    return put<std::int32_t>(place, value);
  case PCLPointField::UINT32:
    return put<std::uint32_t>(place, value);
  case PCLPointField::FLOAT32:
    return put<float>(place, value);
  case PCLPointField::FLOAT64:
    return put<double>(place, value);
  default:
    FAIL() << "no such datatype in this test";
  }
}

/** \brief Value of a field at a point, as the test filled it in. */
double
valueOf(const std::string& field, std::size_t point)
{
  const auto number = static_cast<double>(point);
  if (field == "x")
    return -4.0 + 0.25 * number;
  if (field == "y")
    return 2.0 - 0.5 * number;
  if (field == "z")
    return 0.125 * number;
  if (field == "intensity" || field == "reflectivity")
    return std::fmod(7.0 * number, 120.0);
  return -77.0;
}

/** \brief A cloud of a layout, every byte that belongs to no field set to rubbish. */
PCLPointCloud2
makeMessage(const std::vector<PCLPointField>& fields,
            std::uint32_t point_step,
            std::uint32_t width,
            std::uint32_t height = 1,
            std::uint32_t row_padding = 0)
{
  PCLPointCloud2 message;
  message.header.frame_id = "sensor";
  message.header.stamp = 99;
  message.width = width;
  message.height = height;
  message.fields = fields;
  message.point_step = point_step;
  message.row_step = width * point_step + row_padding;
  message.is_bigendian = 0;
  message.data.assign(std::size_t{message.row_step} * height, 0xa5);
  for (std::size_t row = 0; row < height; ++row)
    for (std::size_t column = 0; column < width; ++column)
      for (const PCLPointField& field : fields)
        writeNumber(message.data.data() + row * message.row_step + column * point_step +
                        field.offset,
                    field.datatype,
                    valueOf(field.name, row * width + column));
  return message;
}

PCLPointCloud2
plainMessage(std::uint32_t width = 4, std::uint32_t height = 1)
{
  return makeMessage({makeField("x", 0, PCLPointField::FLOAT32),
                      makeField("y", 4, PCLPointField::FLOAT32),
                      makeField("z", 8, PCLPointField::FLOAT32),
                      makeField("intensity", 12, PCLPointField::FLOAT32)},
                     16,
                     width,
                     height);
}

PCLPointField&
fieldOf(PCLPointCloud2& message, const std::string& name)
{
  for (PCLPointField& field : message.fields)
    if (field.name == name)
      return field;
  ADD_FAILURE() << "the test's message has no field " << name;
  return message.fields.front();
}

/** \brief Runs a native preprocessor over a copy of the message whose bytes end where
 * the allocation ends, so that a sanitizer sees the first byte too many. */
PreprocessingStatus
processNative(const PCLPointCloud2& message, Output& output)
{
  PCLPointCloud2 tight = message;
  tight.data.shrink_to_fit();
  output.resize(3); // of an earlier call
  SensorPreprocessor<NativeIntensity> preprocessor{NativeIntensity(0.04)};
  const PreprocessingStatus status = preprocessor.process(tight, output);
  if (!status.ok()) {
    EXPECT_TRUE(output.empty());
    EXPECT_EQ(output.width, 0u);
    EXPECT_EQ(preprocessor.getStatistics().points, 0u);
    EXPECT_FALSE(status.message().empty());
  }
  return status;
}

void
expectAllRead(const PCLPointCloud2& message)
{
  Output output;
  const PreprocessingStatus status = processNative(message, output);
  ASSERT_TRUE(status.ok()) << status.message();
  ASSERT_EQ(output.size(), std::size_t{message.width} * message.height);
  for (std::size_t i = 0; i < output.size(); ++i) {
    EXPECT_EQ(output[i].x, static_cast<float>(valueOf("x", i))) << i;
    EXPECT_EQ(output[i].y, static_cast<float>(valueOf("y", i))) << i;
    EXPECT_EQ(output[i].z, static_cast<float>(valueOf("z", i))) << i;
    EXPECT_EQ(output[i].intensity, static_cast<float>(valueOf("intensity", i))) << i;
  }
}

void
expectRefusal(const PCLPointCloud2& message,
              PreprocessingCode code,
              const std::vector<std::string>& culprits)
{
  Output output;
  const PreprocessingStatus status = processNative(message, output);
  EXPECT_EQ(static_cast<int>(status.code()), static_cast<int>(code))
      << status.message();
  for (const std::string& culprit : culprits)
    EXPECT_NE(status.message().find(culprit), std::string::npos)
        << "'" << culprit << "' is not in: " << status.message();
}

TEST(CloudLayout, FieldsMayStandInAnyOrderWithGaps)
{
  expectAllRead(makeMessage({makeField("intensity", 0, PCLPointField::FLOAT32),
                             makeField("z", 9, PCLPointField::FLOAT32),
                             makeField("ring", 13, PCLPointField::UINT16),
                             makeField("x", 17, PCLPointField::FLOAT32),
                             makeField("y", 27, PCLPointField::FLOAT32)},
                            37,
                            11));
}

TEST(CloudLayout, ListOfFieldsMayBeInAnyOrderToo)
{
  expectAllRead(makeMessage({makeField("y", 27, PCLPointField::FLOAT32),
                             makeField("intensity", 31, PCLPointField::UINT8),
                             makeField("z", 1, PCLPointField::FLOAT32),
                             makeField("x", 5, PCLPointField::FLOAT32)},
                            32,
                            9));
}

TEST(CloudLayout, TheLastFieldMayEndWithThePoint)
{
  expectAllRead(makeMessage({makeField("x", 0, PCLPointField::FLOAT32),
                             makeField("y", 4, PCLPointField::FLOAT32),
                             makeField("z", 8, PCLPointField::FLOAT32),
                             makeField("intensity", 12, PCLPointField::UINT8)},
                            13,
                            17));
}

TEST(CloudLayout, IntensityOfEveryDatatypeIsRead)
{
  for (std::uint8_t datatype = PCLPointField::INT8; datatype <= PCLPointField::FLOAT64;
       ++datatype) {
    SCOPED_TRACE("datatype " + std::to_string(datatype));
    expectAllRead(makeMessage({makeField("x", 0, PCLPointField::FLOAT32),
                               makeField("y", 4, PCLPointField::FLOAT32),
                               makeField("z", 8, PCLPointField::FLOAT32),
                               makeField("intensity", 13, datatype)},
                              21,
                              20));
  }
}

TEST(CloudLayout, EndsOfEveryDatatypeAreRead)
{
  struct Limits {
    std::uint8_t datatype;
    double lowest;
    double highest;
  };
  for (const Limits& limits :
       {Limits{PCLPointField::INT8, -128.0, 127.0},
        Limits{PCLPointField::UINT8, 0.0, 255.0},
        Limits{PCLPointField::INT16, -32768.0, 32767.0},
        Limits{PCLPointField::UINT16, 0.0, 65535.0},
        Limits{PCLPointField::INT32, -2147483648.0, 2147483647.0},
        Limits{PCLPointField::UINT32, 0.0, 4294967295.0},
        Limits{PCLPointField::FLOAT32, -3e38, 3e38},
        Limits{PCLPointField::FLOAT64, -1.0 / 3.0, 3e38}}) {
    PCLPointCloud2 message = makeMessage({makeField("x", 0, PCLPointField::FLOAT32),
                                          makeField("y", 4, PCLPointField::FLOAT32),
                                          makeField("z", 8, PCLPointField::FLOAT32),
                                          makeField("intensity", 12, limits.datatype)},
                                         20,
                                         2);
    writeNumber(message.data.data() + 12, limits.datatype, limits.lowest);
    writeNumber(message.data.data() + 32, limits.datatype, limits.highest);
    Output output;
    ASSERT_TRUE(processNative(message, output).ok());
    EXPECT_EQ(output[0].intensity, static_cast<float>(limits.lowest));
    EXPECT_EQ(output[1].intensity, static_cast<float>(limits.highest));
  }
}

TEST(CloudLayout, CoordinatesMayBeDouble)
{
  expectAllRead(makeMessage({makeField("z", 3, PCLPointField::FLOAT64),
                             makeField("x", 11, PCLPointField::FLOAT64),
                             makeField("y", 20, PCLPointField::FLOAT64),
                             makeField("intensity", 28, PCLPointField::INT16)},
                            31,
                            13,
                            3,
                            5));
}

TEST(CloudLayout, DoubleCoordinatesBeyondFloatAreNotFinite)
{
  PCLPointCloud2 message = makeMessage({makeField("x", 0, PCLPointField::FLOAT64),
                                        makeField("y", 8, PCLPointField::FLOAT64),
                                        makeField("z", 16, PCLPointField::FLOAT64)},
                                       24,
                                       3);
  writeNumber(message.data.data(), PCLPointField::FLOAT64, 1e300);
  writeNumber(message.data.data() + 24 + 8,
              PCLPointField::FLOAT64,
              std::numeric_limits<double>::quiet_NaN());
  SensorPreprocessor<CountIntensity> preprocessor{CountIntensity(0.04)};
  Output output;
  ASSERT_TRUE(preprocessor.process(message, output).ok());
  EXPECT_EQ(output.size(), 1u);
  EXPECT_EQ(preprocessor.getStatistics().points, 3u);
  EXPECT_EQ(preprocessor.getStatistics().points_not_finite, 2u);
}

TEST(CloudLayout, OrganisedCloudsMayHavePaddedRows)
{
  const std::vector<PCLPointField> fields = {
      makeField("x", 0, PCLPointField::FLOAT32),
      makeField("y", 4, PCLPointField::FLOAT32),
      makeField("z", 8, PCLPointField::FLOAT32),
      makeField("intensity", 16, PCLPointField::FLOAT32)};
  expectAllRead(makeMessage(fields, 24, 6, 5));
  expectAllRead(makeMessage(fields, 24, 6, 5, 1));
  expectAllRead(makeMessage(fields, 24, 1, 30, 1000));
}

TEST(CloudLayout, TheLastRowMayGoWithoutItsPadding)
{
  PCLPointCloud2 message =
      makeMessage({makeField("x", 0, PCLPointField::FLOAT32),
                   makeField("y", 4, PCLPointField::FLOAT32),
                   makeField("z", 8, PCLPointField::FLOAT32),
                   makeField("intensity", 12, PCLPointField::FLOAT32)},
                  16,
                  4,
                  3,
                  9);
  message.data.resize(message.data.size() - 9);
  expectAllRead(message);
  message.data.pop_back();
  expectRefusal(message, PreprocessingCode::InvalidLayout, {"rows"});
}

TEST(CloudLayout, BytesBehindTheLastRowDoNotMatter)
{
  PCLPointCloud2 message = plainMessage();
  message.data.resize(message.data.size() + 1000);
  expectAllRead(message);
}

TEST(CloudLayout, ACountOfZeroIsReadAsOne)
{
  PCLPointCloud2 message = plainMessage();
  for (PCLPointField& field : message.fields)
    field.count = 0;
  expectAllRead(message);
}

TEST(CloudLayout, FieldsThatNobodyReadsMayBeAnything)
{
  PCLPointCloud2 message = plainMessage();
  message.fields.push_back(makeField("junk", 4000000000u, 200, 70000));
  message.fields.push_back(makeField("", 0, 0, 0));
  expectAllRead(message);
}

TEST(CloudLayout, TheIntensityFieldCanBeNamed)
{
  PCLPointCloud2 message =
      makeMessage({makeField("x", 0, PCLPointField::FLOAT32),
                   makeField("y", 4, PCLPointField::FLOAT32),
                   makeField("z", 8, PCLPointField::FLOAT32),
                   makeField("reflectivity", 12, PCLPointField::UINT16)},
                  14,
                  6);
  Output output;
  SensorPreprocessor<NativeIntensity> preprocessor{NativeIntensity(0.04)};
  PreprocessingStatus status = preprocessor.process(message, output);
  EXPECT_EQ(status.code(), PreprocessingCode::MissingField);
  EXPECT_NE(status.message().find("'intensity'"), std::string::npos);
  preprocessor.setIntensityField("reflectivity");
  ASSERT_TRUE(preprocessor.process(message, output).ok());
  ASSERT_EQ(output.size(), 6u);
  EXPECT_EQ(output[5].intensity, static_cast<float>(valueOf("reflectivity", 5)));
  preprocessor.setIntensityField("ambient");
  status = preprocessor.process(message, output);
  EXPECT_EQ(status.code(), PreprocessingCode::MissingField);
  EXPECT_NE(status.message().find("'ambient'"), std::string::npos);
}

TEST(CloudLayout, ModelsThatDoNotReadIntensityDoNotMindABadOne)
{
  SensorPreprocessor<CountIntensity> preprocessor{CountIntensity(0.04)};
  PCLPointCloud2 message = plainMessage();
  Output output;
  fieldOf(message, "intensity") = makeField("intensity", 4294967295u, 99, 3);
  EXPECT_TRUE(preprocessor.process(message, output).ok());
  message.fields.pop_back();
  EXPECT_TRUE(preprocessor.process(message, output).ok());
  ASSERT_EQ(output.size(), 4u);
  EXPECT_EQ(output[0].intensity, 1.0f);
}

TEST(CloudLayout, HeaderOfTheMessageIsCarried)
{
  Output output;
  ASSERT_TRUE(processNative(plainMessage(), output).ok());
  EXPECT_EQ(output.header.frame_id, "sensor");
  EXPECT_EQ(output.header.stamp, 99u);
}

TEST(CloudLayout, MessagesOfPclsOwnTypesAreRead)
{
  pcl::PointCloud<pcl::PointXYZINormal> cloud;
  for (std::size_t i = 0; i < 12; ++i) {
    pcl::PointXYZINormal point;
    point.x = static_cast<float>(valueOf("x", i));
    point.y = static_cast<float>(valueOf("y", i));
    point.z = static_cast<float>(valueOf("z", i));
    point.intensity = static_cast<float>(valueOf("intensity", i));
    cloud.push_back(point);
  }
  cloud.width = 4;
  cloud.height = 3;
  PCLPointCloud2 message;
  pcl::toPCLPointCloud2(cloud, message);
  expectAllRead(message);
}

TEST(CloudLayout, PointsThatAreNotFiniteAreLeftOut)
{
  PCLPointCloud2 message = plainMessage(6, 2);
  for (const std::size_t point : {std::size_t{1}, std::size_t{7}})
    writeNumber(message.data.data() + point * 16 + 4,
                PCLPointField::FLOAT32,
                std::numeric_limits<double>::quiet_NaN());
  SensorPreprocessor<NativeIntensity> preprocessor{NativeIntensity(0.04)};
  preprocessor.setCropBox(Eigen::Vector3f(-100.0f, -100.0f, 0.0f),
                          Eigen::Vector3f(100.0f, 100.0f, 1.0f));
  Output output;
  ASSERT_TRUE(preprocessor.process(message, output).ok());
  const auto& statistics = preprocessor.getStatistics();
  EXPECT_EQ(statistics.points, 12u);
  EXPECT_EQ(statistics.points_not_finite, 2u);
  EXPECT_EQ(statistics.points_cropped, 3u); // z of points 9 to 11 is above 1
  EXPECT_EQ(output.size(), 7u);
  EXPECT_EQ(output.height, 1u);
}

TEST(InvalidCloudLayout, EachCoordinateMustBeThere)
{
  for (const std::string name : {"x", "y", "z"}) {
    PCLPointCloud2 message = plainMessage();
    fieldOf(message, name).name = "not_" + name;
    expectRefusal(message, PreprocessingCode::MissingField, {"'" + name + "'"});
  }
  PCLPointCloud2 nameless = plainMessage();
  nameless.fields.clear();
  expectRefusal(nameless, PreprocessingCode::MissingField, {"'x'"});
}

TEST(InvalidCloudLayout, NamesAreTakenAsTheyAre)
{
  PCLPointCloud2 message = plainMessage();
  fieldOf(message, "z").name = "Z";
  expectRefusal(message, PreprocessingCode::MissingField, {"'z'"});
}

TEST(InvalidCloudLayout, CoordinatesMustBeFloats)
{
  for (const std::string name : {"x", "y", "z"})
    for (std::uint8_t datatype = PCLPointField::INT8; datatype < PCLPointField::FLOAT32;
         ++datatype) {
      PCLPointCloud2 message = plainMessage();
      fieldOf(message, name).datatype = datatype;
      expectRefusal(message,
                    PreprocessingCode::InvalidField,
                    {"'" + name + "'", std::to_string(datatype)});
    }
}

TEST(InvalidCloudLayout, CoordinatesMustShareADatatype)
{
  for (const std::string name : {"x", "y", "z"}) {
    PCLPointCloud2 message = plainMessage();
    message.point_step = 32;
    message.row_step = 4 * 32;
    message.data.resize(4 * 32);
    fieldOf(message, name).datatype = PCLPointField::FLOAT64;
    expectRefusal(message, PreprocessingCode::InvalidField, {"'x'", "'y'", "'z'"});
  }
}

TEST(InvalidCloudLayout, UnknownDatatypesAreNamed)
{
  for (const std::string name : {"x", "y", "z", "intensity"})
    for (const int datatype : {0, 9, 10, 11, 12, 255}) {
      PCLPointCloud2 message = plainMessage();
      fieldOf(message, name).datatype = static_cast<std::uint8_t>(datatype);
      expectRefusal(message,
                    PreprocessingCode::InvalidField,
                    {"'" + name + "'", std::to_string(datatype)});
    }
}

TEST(InvalidCloudLayout, FieldsOfSeveralNumbersAreNamed)
{
  for (const std::string name : {"x", "y", "z", "intensity"})
    for (const std::uint32_t count : {2u, 3u, 4294967295u}) {
      PCLPointCloud2 message = plainMessage();
      fieldOf(message, name).count = count;
      expectRefusal(message,
                    PreprocessingCode::InvalidField,
                    {"'" + name + "'", std::to_string(count)});
    }
}

TEST(InvalidCloudLayout, FieldsMustLieWithinThePoint)
{
  for (const std::string name : {"x", "y", "z", "intensity"})
    for (const std::uint32_t offset :
         {13u, 16u, 1000u, 2147483648u, 4294967292u, 4294967293u, 4294967295u}) {
      PCLPointCloud2 message = plainMessage();
      fieldOf(message, name).offset = offset;
      expectRefusal(message, PreprocessingCode::InvalidField, {"'" + name + "'"});
    }
}

TEST(InvalidCloudLayout, LargeIntensityMustLieWithinThePoint)
{
  PCLPointCloud2 message = plainMessage();
  fieldOf(message, "intensity").datatype = PCLPointField::FLOAT64; // at 12 of 16
  expectRefusal(message, PreprocessingCode::InvalidField, {"'intensity'", "20", "16"});
}

TEST(InvalidCloudLayout, RowsMustHoldTheirPoints)
{
  PCLPointCloud2 message = plainMessage(4, 2);
  message.row_step = 4 * 16 - 1;
  expectRefusal(message, PreprocessingCode::InvalidLayout, {"rows", "63"});
  message.row_step = 0;
  expectRefusal(message, PreprocessingCode::InvalidLayout, {"rows"});
}

TEST(InvalidCloudLayout, AByteTooFewIsNoticed)
{
  PCLPointCloud2 message = plainMessage(4, 3);
  message.data.pop_back();
  expectRefusal(message, PreprocessingCode::InvalidLayout, {"191"});
  message = plainMessage(1, 1);
  message.data.pop_back();
  expectRefusal(message, PreprocessingCode::InvalidLayout, {"15"});
  message.data.clear();
  expectRefusal(message, PreprocessingCode::InvalidLayout, {"0 bytes"});
}

TEST(InvalidCloudLayout, SizesWhoseProductsWrapAreNoticed)
{
  struct Size {
    std::uint32_t width;
    std::uint32_t height;
    std::uint32_t point_step;
    std::uint32_t row_step;
  };
  for (const Size& size : {Size{4294967295u, 4294967295u, 16, 64},
                           Size{2147483648u, 2, 16, 0},
                           Size{268435456u, 1, 16, 0},
                           Size{268435457u, 1, 16, 16},
                           Size{1, 4294967295u, 16, 4294967295u},
                           Size{65536u, 65536u, 65536u, 0},
                           Size{4, 4294967295u, 16, 64},
                           Size{4294967295u, 1, 4294967295u, 4294967295u},
                           Size{1, 4294967295u, 4294967295u, 4294967295u}}) {
    PCLPointCloud2 message = plainMessage();
    message.width = size.width;
    message.height = size.height;
    message.point_step = size.point_step;
    message.row_step = size.row_step;
    SCOPED_TRACE(std::to_string(size.width) + " x " + std::to_string(size.height));
    expectRefusal(message, PreprocessingCode::InvalidLayout, {});
  }
}

TEST(InvalidCloudLayout, PointsNeedBytes)
{
  PCLPointCloud2 message = plainMessage();
  message.point_step = 0;
  expectRefusal(message, PreprocessingCode::InvalidLayout, {"point"});
}

TEST(InvalidCloudLayout, PointStepMustHoldTheFields)
{
  PCLPointCloud2 message = plainMessage();
  message.point_step = 11;
  expectRefusal(message, PreprocessingCode::InvalidField, {"'z'", "11"});
}

TEST(InvalidCloudLayout, ForeignByteOrderIsRefused)
{
  PCLPointCloud2 message = plainMessage();
  message.is_bigendian = 1;
  expectRefusal(message, PreprocessingCode::InvalidLayout, {"byte order"});
}

TEST(InvalidCloudLayout, EmptyCloudsStillNeedTheirFields)
{
  PCLPointCloud2 message = plainMessage(0, 1);
  expectAllRead(message);
  fieldOf(message, "y").name = "why";
  expectRefusal(message, PreprocessingCode::MissingField, {"'y'"});
}

TEST(InvalidCloudLayout, RandomLayoutsNeverReadOutsideTheBytes)
{
  // What counts is that a sanitizer stays silent, and that a status is given.
  std::mt19937 generator(77);
  const auto upTo = [&generator](std::uint32_t highest) {
    return std::uniform_int_distribution<std::uint32_t>(0, highest)(generator);
  };
  int accepted = 0;
  for (int round = 0; round < 20000; ++round) {
    PCLPointCloud2 message;
    message.width = upTo(4);
    message.height = upTo(3);
    message.point_step = upTo(24);
    message.row_step = message.width * message.point_step + upTo(3) - upTo(1);
    message.data.resize(std::max<std::size_t>(
                            std::size_t{message.row_step % 1000} * message.height, 1) -
                        upTo(1));
    for (const std::string name : {"x", "y", "z", "intensity"})
      message.fields.push_back(
          makeField(name,
                    upTo(20),
                    static_cast<std::uint8_t>(name == "intensity" ? upTo(9) : 7),
                    upTo(1)));
    Output output;
    const PreprocessingStatus status = processNative(message, output);
    if (status.ok()) {
      ++accepted;
      EXPECT_LE(output.size(), std::size_t{message.width} * message.height);
    }
  }
  EXPECT_GT(accepted, 100);
}

} // namespace
