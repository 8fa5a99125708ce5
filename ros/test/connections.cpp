#include "connections.h"

#include "waiting.h"

#include <ros/master.h>
#include <ros/network.h>
#include <ros/this_node.h>
#include <XmlRpcClient.h>
#include <XmlRpcValue.h>

namespace pcl_ext_ros {
namespace test {

std::size_t
subscribersOf(const std::string& node_name, const std::string& topic)
{
  XmlRpc::XmlRpcValue request;
  XmlRpc::XmlRpcValue response;
  XmlRpc::XmlRpcValue uri;
  request[0] = ros::this_node::getName();
  request[1] = node_name;
  constexpr bool until_the_master_is_there = false;
  if (!ros::master::execute(
          "lookupNode", request, response, uri, until_the_master_is_there))
    return 0;
  std::string host;
  std::uint32_t port = 0;
  if (!ros::network::splitURI(uri, host, port))
    return 0;
  XmlRpc::XmlRpcClient node(host.c_str(), static_cast<int>(port), "/");
  XmlRpc::XmlRpcValue caller;
  caller[0] = ros::this_node::getName();
  XmlRpc::XmlRpcValue
      answer; // [code, text, [[id, peer, direction, protocol, topic, ..]]]
  if (!node.execute("getBusInfo", caller, answer) || node.isFault())
    return 0;
  std::size_t count = 0;
  for (int i = 0; i < answer[2].size(); ++i)
    if (static_cast<std::string>(answer[2][i][2]) == "o" &&
        static_cast<std::string>(answer[2][i][4]) == topic)
      ++count;
  return count;
}

bool
waitForSubscribers(const std::string& node_name,
                   const std::string& topic,
                   std::size_t count)
{
  return waitFor([&] { return subscribersOf(node_name, topic) >= count; });
}

} // namespace test
} // namespace pcl_ext_ros
