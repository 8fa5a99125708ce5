// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * Compares all transports of point_cloud_transport that are installed on the same
 * clouds, in one run, and prints the Markdown table of README.md.
 */
#include "pcl_ext_point_cloud_transport/transport_interface.hpp"

#include <pcl/io/pcd_io.h>
#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/point_types.h>

#include <pluginlib/class_loader.hpp>
#include <point_cloud_transport/publisher_plugin.hpp>
#include <point_cloud_transport/subscriber_plugin.hpp>
#include <rclcpp/rclcpp.hpp>
#include <sensor_msgs/point_cloud2_iterator.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

using pcl_ext_point_cloud_transport::toTransport;
using point_cloud_transport::PublisherPlugin;
using point_cloud_transport::SubscriberPlugin;
using sensor_msgs::msg::PointCloud2;
using Positions = pcl::PointCloud<pcl::PointXYZ>;

/** \brief A transport and parameters of its publisher, without their prefix. */
struct Setup {
  std::string transport;
  std::vector<rclcpp::Parameter> parameters;
  std::string name; ///< in the table
};

std::vector<Setup>
setupsOf(const std::string& transport)
{
  if (transport != "pcl_ext")
    return {{transport, {}, transport}};
  using rclcpp::Parameter;
  const Parameter balanced("effort", "balanced");
  return {
      {transport,
       {Parameter("resolution", 0.04), Parameter("effort", "fast")},
       "pcl_ext, 4 cm, fast"},
      {transport, {Parameter("resolution", 0.04), balanced}, "pcl_ext, 4 cm, balanced"},
      {transport, {Parameter("resolution", 0.01), balanced}, "pcl_ext, 1 cm, balanced"},
      {transport,
       {Parameter("resolution", 0.001), Parameter("keep_points", true), balanced},
       "pcl_ext, 1 mm, keep_points, balanced"}};
}

struct Stream {
  std::string name;
  std::vector<PointCloud2> clouds;
};

PointCloud2
readCloud(const std::filesystem::path& file)
{
  pcl::PCLPointCloud2 cloud;
  if (pcl::PCDReader().read(file.string(), cloud) != 0)
    throw std::runtime_error(file.string() + ": cannot be read");
  PointCloud2 message;
  message.height = cloud.height;
  message.width = cloud.width;
  for (const pcl::PCLPointField& field : cloud.fields) {
    sensor_msgs::msg::PointField copy;
    copy.name = field.name;
    copy.offset = field.offset;
    copy.datatype = field.datatype;
    copy.count = field.count;
    message.fields.push_back(copy);
  }
  message.point_step = cloud.point_step;
  message.row_step = cloud.row_step;
  message.is_dense = cloud.is_dense != 0;
  message.data = cloud.data;
  message.header.frame_id = "sensor";
  return message;
}

/** \brief The PCD files of a folder, by their names. */
Stream
readStream(const std::filesystem::path& folder)
{
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".pcd")
      files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  Stream stream;
  stream.name = folder.filename().string();
  for (const auto& file : files)
    stream.clouds.push_back(readCloud(file));
  if (stream.clouds.empty())
    throw std::runtime_error(folder.string() + ": no PCD files");
  return stream;
}

Positions::Ptr
positionsOf(const PointCloud2& cloud)
{
  Positions::Ptr positions(new Positions);
  for (sensor_msgs::PointCloud2ConstIterator<float> x(cloud, "x"); x != x.end(); ++x)
    if (std::isfinite(x[0]) && std::isfinite(x[1]) && std::isfinite(x[2]))
      positions->push_back({x[0], x[1], x[2]});
  return positions;
}

/** \brief What a transport keeps of a stream, and what it takes. */
struct Figures {
  double points = 0.0; ///< of all clouds, finite ones
  double points_back = 0.0;
  double bytes = 0.0; ///< of the serialized messages
  std::vector<double> encode_ms;
  std::vector<double> decode_ms;
  double largest_error = 0.0; ///< metres, from each point to the nearest one
  bool keeps_order = true;
  std::string fields;
};

void
addDifferences(const PointCloud2& in, const PointCloud2& out, Figures& figures)
{
  const Positions::Ptr points = positionsOf(in);
  const Positions::Ptr back = positionsOf(out);
  figures.points += static_cast<double>(points->size());
  figures.points_back += static_cast<double>(back->size());
  figures.fields.clear();
  for (const auto& field : out.fields)
    figures.fields += (figures.fields.empty() ? "" : " ") + field.name;
  pcl::KdTreeFLANN<pcl::PointXYZ> tree;
  if (back->empty())
    return;
  tree.setInputCloud(back);
  pcl::Indices index(1);
  std::vector<float> square(1);
  double largest = 0.0;
  for (const pcl::PointXYZ& point : *points) {
    tree.nearestKSearch(point, 1, index, square);
    largest = std::max(largest, std::sqrt(static_cast<double>(square[0])));
  }
  figures.largest_error = std::max(figures.largest_error, largest);
  figures.keeps_order &= points->size() == back->size();
  // An order by chance has points that are further off than the nearest ones.
  for (std::size_t i = 0; figures.keeps_order && i < points->size(); ++i) {
    const auto distance = static_cast<double>(
        ((*points)[i].getVector3fMap() - (*back)[i].getVector3fMap()).norm());
    figures.keeps_order = distance <= 1.001 * largest + 1e-6;
  }
}

double
millisecondsOf(const std::function<void()>& action)
{
  const auto start = std::chrono::steady_clock::now();
  action();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() -
                                                   start)
      .count();
}

/** \brief Sends a stream through new plugins. */
Figures
measure(const Setup& setup,
        const Stream& stream,
        pluginlib::ClassLoader<PublisherPlugin>& publishers,
        pluginlib::ClassLoader<SubscriberPlugin>& subscribers)
{
  static int number = 0;
  const std::string topic = "/compared_" + std::to_string(++number);
  rclcpp::NodeOptions options;
  for (const rclcpp::Parameter& parameter : setup.parameters)
    options.append_parameter_override(topic.substr(1) + "." + setup.transport + "." +
                                          parameter.get_name(),
                                      parameter.get_parameter_value());
  const auto node = std::make_shared<rclcpp::Node>("compare_transports", options);
  const auto publisher =
      publishers.createUniqueInstance(PublisherPlugin::getLookupName(setup.transport));
  const auto subscriber = subscribers.createUniqueInstance(
      SubscriberPlugin::getLookupName(setup.transport));
  publisher->advertise(toTransport(node), topic, toTransport(rclcpp::QoS(10)));
  Figures figures;
  for (const PointCloud2& cloud : stream.clouds) {
    std::optional<PublisherPlugin::EncodeResult> encoded;
    figures.encode_ms.push_back(
        millisecondsOf([&] { encoded.emplace(publisher->encode(cloud)); }));
    if (!*encoded || !encoded->value())
      throw std::runtime_error(*encoded ? "no message" : encoded->error());
    const std::shared_ptr<rclcpp::SerializedMessage> message = *encoded->value();
    figures.bytes += static_cast<double>(message->size());
    std::optional<SubscriberPlugin::DecodeResult> decoded;
    figures.decode_ms.push_back(
        millisecondsOf([&] { decoded.emplace(subscriber->decode(message)); }));
    if (!*decoded || !decoded->value())
      throw std::runtime_error(*decoded ? "no cloud" : decoded->error());
    addDifferences(cloud, **decoded->value(), figures);
  }
  publisher->shutdown();
  return figures;
}

double
medianOf(std::vector<double> values)
{
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void
printRow(const std::string& stream,
         const std::string& transport,
         const Figures& figures)
{
  const auto clouds = static_cast<double>(figures.encode_ms.size());
  std::printf("| %s | %s | %.0f | %.2f | %.2f | %.1f %% | %s | %.2f | %s |\n",
              stream.c_str(),
              transport.c_str(),
              figures.bytes / clouds,
              medianOf(figures.encode_ms),
              medianOf(figures.decode_ms),
              figures.points > 0 ? 100.0 * figures.points_back / figures.points : 0.0,
              figures.keeps_order ? "yes" : "no",
              1e3 * figures.largest_error,
              figures.fields.c_str());
}

void
compare(const std::vector<Stream>& streams)
{
  pluginlib::ClassLoader<PublisherPlugin> publishers(
      "point_cloud_transport", "point_cloud_transport::PublisherPlugin");
  pluginlib::ClassLoader<SubscriberPlugin> subscribers(
      "point_cloud_transport", "point_cloud_transport::SubscriberPlugin");
  std::vector<Setup> setups;
  for (const std::string& lookup_name : publishers.getDeclaredClasses()) {
    const std::size_t begin = lookup_name.find('/') + 1;
    const std::size_t end = lookup_name.rfind("_pub");
    for (const Setup& setup : setupsOf(lookup_name.substr(begin, end - begin)))
      setups.push_back(setup);
  }
  std::printf("| stream | transport | bytes a message | encode ms | decode ms | points "
              "kept | in order | largest error mm | fields |\n"
              "|---|---|---|---|---|---|---|---|---|\n");
  for (const Stream& stream : streams)
    for (const Setup& setup : setups)
      try {
        printRow(
            stream.name, setup.name, measure(setup, stream, publishers, subscribers));
      }
      catch (const std::exception& failure) {
        std::printf("| %s | %s | %s |\n",
                    stream.name.c_str(),
                    setup.name.c_str(),
                    failure.what());
      }
}

} // namespace

int
main(int argc, char** argv)
{
  rclcpp::init(argc, argv);
  const std::vector<std::string> folders(argv + 1, argv + argc);
  if (folders.empty() || folders[0] == "--help") {
    std::cout << "Compares the transports of point clouds that are installed.\n"
                 "Usage: compare_transports FOLDER...\n"
                 "  FOLDER  PCD files of one stream, in the order of their names\n";
    return folders.empty() ? 2 : 0;
  }
  int status = 0;
  try {
    std::vector<Stream> streams;
    for (const std::string& folder : folders)
      streams.push_back(readStream(folder));
    compare(streams);
  }
  catch (const std::exception& failure) {
    std::cerr << "compare_transports: " << failure.what() << '\n';
    status = 1;
  }
  rclcpp::shutdown();
  return status;
}
