// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds.h"
#include "direct_library.h"
#include "running_nodes.h"

#include <gtest/gtest.h>

#include <netinet/in.h>
#include <pcl_ext_ros/site_link.hpp>
#include <std_msgs/msg/empty.hpp>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

namespace pcl_ext_ros::test {

using diagnostic_msgs::msg::DiagnosticArray;
using diagnostic_msgs::msg::DiagnosticStatus;
using std_msgs::msg::Empty;

namespace {

/** \brief A port of loopback that was free a moment ago. */
std::string
freePort()
{
  const int descriptor = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  EXPECT_EQ(::bind(descriptor, reinterpret_cast<sockaddr*>(&address), size), 0);
  EXPECT_EQ(::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size), 0);
  ::close(descriptor);
  return std::to_string(ntohs(address.sin_port));
}

/** \brief The program nats-server, until it is destroyed. */
class Server {
public:
  explicit Server(const std::string& port) : pid_(::fork())
  {
    if (pid_ == 0) {
      ::execl(PCL_EXT_NATS_SERVER,
              "nats-server",
              "-a",
              "127.0.0.1",
              "-p",
              port.c_str(),
              "-l",
              "/dev/null",
              static_cast<char*>(nullptr));
      ::_exit(127);
    }
  }

  ~Server()
  {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }

  Server(const Server&) = delete;
  Server&
  operator=(const Server&) = delete;

private:
  pid_t pid_;
};

} // namespace

TEST(SiteLink, FramesGoToTheSiteAndComeBackAndRequestsTheOtherWay)
{
  const std::string port = freePort();
  const std::string servers = "servers:=nats://127.0.0.1:" + port;
  RunningNodes nodes;
  nodes.add<SiteLink>(
      optionsOf({"-p", servers, "-p", "to_site:=[/a/pcl_ext]", "-r", "__node:=there"}));
  nodes.add<SiteLink>(optionsOf({"-p",
                                 servers,
                                 "-p",
                                 "from_site:=[/a/pcl_ext]",
                                 "-p",
                                 "frame_id:=plant",
                                 "-r",
                                 "/a/pcl_ext:=/b/pcl_ext",
                                 "-r",
                                 "__node:=here"}));
  const auto tester = nodes.add<Tester>();
  const auto sent = tester->create_publisher<Frame>("/a/pcl_ext", 10);
  Recorder<Frame> received(*tester, "/b/pcl_ext");
  Recorder<Empty> requests(*tester, "/a/pcl_ext/request_i_frame");
  const auto request = tester->create_publisher<Empty>("/b/pcl_ext/request_i_frame", 1);
  Recorder<DiagnosticArray> diagnostics(*tester, "/diagnostics");
  nodes.start();
  const auto isDiagnosed = [&](unsigned char level, const std::string& message) {
    return waitForStatus(diagnostics, "there: site site", level, message) &&
           waitForStatus(diagnostics, "here: site site", level, message);
  };
  EXPECT_TRUE(isDiagnosed(DiagnosticStatus::ERROR, "Not connected"));
  std::optional<Server> server(std::in_place, port);
  ASSERT_TRUE(isDiagnosed(DiagnosticStatus::OK, "OK"));
  ASSERT_TRUE(received.waitForPublisher());
  ASSERT_TRUE(requests.waitForPublisher());
  ASSERT_TRUE(waitUntil([&] { return sent->get_subscription_count() == 1; }));

  DirectStream stream({{"resolution", 0.1}});
  const auto frameOf = [&](std::uint32_t number) {
    return stream.frameOf(makeCloud(number, "world", rclcpp::Time(number + 1, 5)),
                          samplePose(0.0));
  };
  // The first one that it sees has to be an I-frame.
  frameOf(0);
  sent->publish(frameOf(1));
  ASSERT_TRUE(requests.next(0));
  EXPECT_EQ(received.count(), 0u);
  stream.sender().requestIFrame();
  for (std::uint32_t number = 2; number < 5; ++number) {
    const Frame frame = frameOf(number);
    EXPECT_EQ(isIFrame(frame.compressed_data), number == 2);
    sent->publish(frame);
    const auto copy = received.next(number - 2);
    ASSERT_TRUE(copy) << number;
    EXPECT_EQ(copy->compressed_data, frame.compressed_data);
    EXPECT_EQ(copy->header.stamp, frame.header.stamp);
    EXPECT_EQ(copy->header.frame_id, "plant");
    EXPECT_EQ(copy->format, frame.format);
  }
  const std::size_t known = requests.count();
  EXPECT_TRUE(waitUntil([&] {
    request->publish(Empty());
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    return requests.count() > known;
  }));

  // A server that is gone is waited for.
  server.reset();
  const auto isConnected = [&](unsigned char level) {
    return waitUntil([&] {
      const auto status = lastStatus(diagnostics, "there: site site");
      return status && status->level == level;
    });
  };
  ASSERT_TRUE(isConnected(DiagnosticStatus::ERROR));
  server.emplace(port);
  ASSERT_TRUE(isConnected(DiagnosticStatus::OK));
  const std::size_t before = received.count();
  for (std::uint32_t number = 5; received.count() == before && number < 500; ++number) {
    stream.sender().requestIFrame();
    sent->publish(frameOf(number));
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_GT(received.count(), before);
}

TEST(SiteLink, AStreamThatTheSiteRefusesIsAnError)
{
  const std::string port = freePort();
  const Server server(port);
  RunningNodes nodes;
  nodes.add<SiteLink>(optionsOf({"-p",
                                 "servers:=nats://127.0.0.1:" + port,
                                 "-p",
                                 "to_site:=['/a/pcl_ext', 'a/pcl_ext']"}));
  const auto tester = nodes.add<Tester>();
  Recorder<DiagnosticArray> diagnostics(*tester, "/diagnostics");
  nodes.start();
  EXPECT_TRUE(waitForStatus(diagnostics,
                            "site_link: site site",
                            DiagnosticStatus::ERROR,
                            "Nothing is sent: the stream '/a/pcl_ext' exists already"));
}

TEST(SiteLink, ATopicIsNotSentBackToWhereItComesFrom)
{
  EXPECT_THROW(
      SiteLink(optionsOf({"-p", "to_site:=[/a]", "-p", "from_site:=['/a', '/b']"})),
      std::invalid_argument);
}

} // namespace pcl_ext_ros::test
