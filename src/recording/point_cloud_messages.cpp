// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/point_cloud_messages.h"

#include <limits>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::recording {

namespace {

constexpr char format_name[] = "pcl_ext"; // of this library's frames
constexpr char cloud_type[] = "sensor_msgs/msg/PointCloud2";
constexpr char compressed_cloud_type[] =
    "point_cloud_interfaces/msg/CompressedPointCloud2";
constexpr char compressed_cloud_type_of_ros1[] = "pcl_ext_ros1/CompressedPointCloud2";
constexpr char cdr_encoding[] = "cdr";
constexpr char ros1_encoding[] = "ros1";
constexpr char schema_encoding[] = "ros2msg";

// The definitions as ROS 2 has them, with the types in them.
constexpr char cloud_definition[] = R"(std_msgs/Header header
uint32 height
uint32 width
sensor_msgs/PointField[] fields
bool is_bigendian
uint32 point_step
uint32 row_step
uint8[] data
bool is_dense
)";
constexpr char compressed_cloud_definition[] = R"(std_msgs/Header header
uint32 height
uint32 width
sensor_msgs/PointField[] fields
bool is_bigendian
uint32 point_step
uint32 row_step
uint8[] compressed_data
bool is_dense
string format
)";
constexpr char definitions_in_both[] =
    R"(================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: sensor_msgs/PointField
uint8 INT8=1
uint8 UINT8=2
uint8 INT16=3
uint8 UINT16=4
uint8 INT32=5
uint8 UINT32=6
uint8 FLOAT32=7
uint8 FLOAT64=8
string name
uint32 offset
uint8 datatype
uint32 count
)";

/** \brief More fields of a point are damage; their descriptions need several times the
 * bytes of the message. */
constexpr std::uint32_t max_fields = 1 << 12;

constexpr std::int64_t nanoseconds_per_second = 1'000'000'000;

bool
hasType(const McapChannel& channel,
        const char* type,
        const char* encoding = cdr_encoding)
{
  return channel.message_encoding == encoding && channel.schema.name == type;
}

McapChannel
channelOf(const std::string& topic, const char* type, const char* definition)
{
  McapChannel channel;
  channel.topic = topic;
  channel.message_encoding = cdr_encoding;
  channel.schema.name = type;
  channel.schema.encoding = schema_encoding;
  channel.schema.text = std::string(definition) + definitions_in_both;
  return channel;
}

void
readField(CdrReader& reader, PointFieldMessage& field)
{
  reader.begin();
  field.name = reader.string();
  field.offset = reader.u32();
  field.datatype = reader.u8();
  field.count = reader.u32();
}

} // namespace

bool
isPointCloud(const McapChannel& channel)
{
  // As ROS 2 names it, as programs that write MCAP files without ROS do, and as DDS does.
  return hasType(channel, cloud_type) || hasType(channel, "sensor_msgs/PointCloud2") ||
         hasType(channel, "sensor_msgs::msg::dds_::PointCloud2_");
}

bool
isRos1PointCloud(const McapChannel& channel)
{
  return hasType(channel, "sensor_msgs/PointCloud2", ros1_encoding);
}

bool
isCompressedPointCloud(const McapChannel& channel)
{
  return hasType(channel, compressed_cloud_type) ||
         hasType(channel, compressed_cloud_type_of_ros1, ros1_encoding);
}

bool
isFormatOfFrames(const std::string& format)
{
  const std::string name = format_name;
  return format == name || format.compare(0, name.size() + 1, name + '/') == 0;
}

MessageEncoding
encodingOf(const McapChannel& channel)
{
  return channel.message_encoding == ros1_encoding ? MessageEncoding::Ros1
                                                   : MessageEncoding::Cdr;
}

McapChannel
pointCloudChannel(const std::string& topic)
{
  return channelOf(topic, cloud_type, cloud_definition);
}

McapChannel
compressedPointCloudChannel(const std::string& topic)
{
  return channelOf(topic, compressed_cloud_type, compressed_cloud_definition);
}

RecordingStatus
readPointCloud(const std::uint8_t* bytes,
               std::size_t size,
               bool is_compressed,
               PointCloudMessage& message,
               MessageEncoding encoding)
{
  // A field has a string, two numbers and a byte, each with its alignment.
  constexpr std::size_t least_field_size = 13;
  CdrReader reader(bytes, size, encoding);
  for (int structure = 0; structure < 3; ++structure) // message, header, stamp
    reader.begin();
  const bool is_ros1 = encoding == MessageEncoding::Ros1;
  if (is_ros1)
    reader.u32();                             // number of the message
  const std::uint32_t seconds = reader.u32(); // ROS 2 has times before 1970
  message.stamp = Time((is_ros1 ? std::int64_t{seconds}
                                : std::int64_t{static_cast<std::int32_t>(seconds)}) *
                           nanoseconds_per_second +
                       reader.u32());
  message.frame_id = reader.string();
  message.height = reader.u32();
  message.width = reader.u32();
  reader.begin();
  const std::uint32_t fields = reader.sequenceSize(least_field_size);
  if (fields > max_fields) {
    message = PointCloudMessage();
    return {RecordingCode::Damaged,
            "a message of a cloud with " + std::to_string(fields) + " fields"};
  }
  message.fields.resize(fields);
  for (PointFieldMessage& field : message.fields)
    readField(reader, field);
  message.is_bigendian = reader.u8() != 0;
  message.point_step = reader.u32();
  message.row_step = reader.u32();
  const std::uint32_t count = reader.sequenceSize(1);
  const std::uint8_t* const begin = reader.take(count);
  message.is_dense = reader.u8() != 0;
  message.format = is_compressed ? reader.string() : std::string();
  if (reader.failed()) {
    message = PointCloudMessage();
    return {RecordingCode::Damaged,
            std::string("the bytes are not a message of ") +
                (is_compressed ? compressed_cloud_type : cloud_type)};
  }
  message.bytes.assign(begin, begin + count);
  return {};
}

void
writePointCloud(const PointCloudMessage& message,
                bool is_compressed,
                std::vector<std::uint8_t>& bytes)
{
  CdrWriter writer(bytes);
  const std::int64_t nanoseconds = message.stamp.count();
  std::int64_t seconds = nanoseconds / nanoseconds_per_second;
  if (nanoseconds % nanoseconds_per_second < 0)
    --seconds; // before 1970, too, nanoseconds are added to seconds
  // Those after 2038 stay as ROS 1 has them, which reads the same bits so.
  const bool is_valid = seconds >= std::numeric_limits<std::int32_t>::min() &&
                        seconds <= std::numeric_limits<std::uint32_t>::max();
  writer.u32(is_valid ? static_cast<std::uint32_t>(seconds) : 0);
  writer.u32(is_valid ? static_cast<std::uint32_t>(nanoseconds -
                                                   seconds * nanoseconds_per_second)
                      : 0);
  writer.string(message.frame_id);
  writer.u32(message.height);
  writer.u32(message.width);
  writer.u32(static_cast<std::uint32_t>(message.fields.size()));
  for (const PointFieldMessage& field : message.fields) {
    writer.string(field.name);
    writer.u32(field.offset);
    writer.u8(field.datatype);
    writer.u32(field.count);
  }
  writer.u8(message.is_bigendian ? 1 : 0);
  writer.u32(message.point_step);
  writer.u32(message.row_step);
  writer.sequence(message.bytes);
  writer.u8(message.is_dense ? 1 : 0);
  if (is_compressed)
    writer.string(message.format.empty() ? format_name : message.format);
}

} // namespace pcl_ext::PCL_EXT_ABI::recording
