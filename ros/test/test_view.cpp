/** \file
 * \brief The central node shows its streams to viewers.
 */
#include <pcl_ext/compression/frame_description.h>

#include "stream_scenario.h"
#include "view/clients.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>

#include <fstream>

namespace pcl_ext_ros1 {
namespace test {

namespace {

using pcl_ext::view::test::LiveClient;
using pcl_ext::view::test::LiveMessage;
using pcl_ext::view::test::request;

/** \brief A port of 127.0.0.1 that nobody uses now. */
int
freePort()
{
  using boost::asio::ip::tcp;
  boost::asio::io_context io;
  return tcp::acceptor(io, {boost::asio::ip::address_v4::loopback(), 0})
      .local_endpoint()
      .port();
}

class View : public StreamScenario {
protected:
  View() { std::ofstream(page) << "the page"; }

  /** \brief Expects the frame of a message.
   * \param[in] flags as of the live protocol; 2: the viewer came after the frame
   */
  static void
  expectFrame(const LiveMessage& shown,
              const CompressedPointCloud2& message,
              std::uint32_t flags)
  {
    EXPECT_EQ(shown.stream, 0u);
    EXPECT_EQ(shown.flags, flags);
    EXPECT_EQ(shown.time, static_cast<std::int64_t>(message.header.stamp.toNSec()));
    EXPECT_EQ(shown.frame, message.compressed_data);
  }

  const int port = freePort();
  const std::string page = temporaryFolder() + "/page.html";
  const Parameters parameters{{"view_port", port}, {"view_page", page}};
};

bool
isIFrame(const CompressedPointCloud2& message)
{
  return pcl_ext::io::describeFrame(message.compressed_data.data(),
                                    message.compressed_data.size())
      .is_i_frame;
}

} // namespace

TEST_F(View, ALateViewerGetsTheFramesThatArrive)
{
  startBoth({{"i_frame_rate", 1000}}, parameters);
  for (std::uint32_t i = 0; i < 4; ++i)
    show(cloud(i)); // the node has them
  const auto viewer_port = static_cast<std::uint16_t>(port);
  EXPECT_EQ(request(viewer_port, "/").body, "the page");
  LiveClient viewer(viewer_port);
  const std::string streams = viewer.next()->text;
  EXPECT_NE(streams.find("\"name\":\"" + compressed + "\""), std::string::npos)
      << streams;
  // From the last I-frame on, which is another one if a subscriber came late.
  std::size_t first = frames.count() - 1;
  while (!isIFrame(*frames[first]))
    --first;
  for (std::size_t i = first; i < 4; ++i)
    expectFrame(viewer.next().value(), *frames[i], 2);
  const auto message = compress(cloud(4));
  ASSERT_TRUE(message);
  expectFrame(viewer.next().value(), *message, 0);
  const std::string metrics = request(viewer_port, "/metrics").body;
  const std::string decoded =
      "\npcl_ext_stream_frames_decoded_total{stream=\"" + compressed + "\"} ";
  EXPECT_NE(metrics.find(decoded), std::string::npos) << metrics;
  EXPECT_EQ(metrics.find(decoded + "0\n"), std::string::npos) << metrics;
}

TEST_F(View, AViewersRequestReachesTheSender)
{
  startBoth({{"i_frame_rate", 100000}}, parameters);
  show(cloud(0));
  LiveClient viewer(static_cast<std::uint16_t>(port));
  viewer.next(); // the streams
  std::uint32_t number = 1;
  ASSERT_TRUE(compress(cloud(number++)));
  ASSERT_TRUE(compress(cloud(number++)));
  EXPECT_FALSE(isIFrame(*frames.last()));
  ASSERT_TRUE(viewer.send(R"({"type":"i-frame","stream":0})"));
  const bool has_come = waitFor([&] {
    const auto message = compress(cloud(number++));
    return message && isIFrame(*message);
  });
  EXPECT_TRUE(has_come);
}

TEST_F(View, APortThatIsTakenEndsTheNode)
{
  boost::asio::io_context io;
  const boost::asio::ip::tcp::acceptor other(
      io, {boost::asio::ip::address_v4::loopback(), 0});
  const int taken = other.local_endpoint().port();
  NodeProcess central_node("intensity_decompressor",
                           full("decompressor"),
                           Parameters{{"view_port", taken}, {"view_page", page}});
  EXPECT_EQ(central_node.waitForExit(), 1);
  EXPECT_NE(central_node.output().find("port " + std::to_string(taken) +
                                       " of 127.0.0.1 is taken"),
            std::string::npos)
      << central_node.output();
}

TEST_F(View, WithoutItsPageTheNodeEnds)
{
  NodeProcess central_node(
      "intensity_decompressor",
      full("decompressor"),
      Parameters{{"view_port", port}, {"view_page", temporaryFolder() + "/no.html"}});
  EXPECT_EQ(central_node.waitForExit(), 1);
  EXPECT_NE(central_node.output().find("no.html'; it must be the viewer's page"),
            std::string::npos)
      << central_node.output();
}

} // namespace test
} // namespace pcl_ext_ros1
