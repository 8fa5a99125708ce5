// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/link/frame_subscriber.h>

#include "tools/site_program.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <thread>
#include <vector>

namespace pcl_ext::tools::test {

namespace fs = std::filesystem;
using link::test::freePort;
using recording::Time;

namespace {

void
expectTwoStreams(const std::string& path, const std::vector<KnownStream>& sent)
{
  const std::vector<DecodedStream> received = decode(path);
  ASSERT_EQ(received.size(), sent.size());
  for (const DecodedStream& stream : received) {
    const KnownStream& known = stream.name == sent[0].name ? sent[0] : sent[1];
    ASSERT_EQ(stream.name, known.name);
    ASSERT_EQ(stream.frames.size(), known.frames.size());
    for (std::size_t i = 0; i < known.frames.size(); ++i) {
      EXPECT_EQ(stream.frames[i].bytes, known.frames[i].bytes);
      EXPECT_EQ(stream.frames[i].time, known.frames[i].time);
    }
  }
}

} // namespace

using ProgramSite = SiteTest;

TEST_F(ProgramSite, RecordsWhatIsSentByteForByte)
{
  const auto sent = recordTwoStreams(folder / "sent.mcap");
  Receiving receiving(folder, at(server) + "-o received.mcap");
  const ProgramRun run = expectRun("send -q sent.mcap" + at(server));
  EXPECT_EQ(run.output, "71 frames sent to site cell, 0.00 MB\n");
  EXPECT_EQ(receiving.end(SIGINT), 0) << receiving.errors();
  EXPECT_EQ(receiving.output(),
            "received.mcap: 71 frames, 0.02 MB\nsite cell: 71 frames of 2 streams, "
            "0.00 MB\n");
  expectTwoStreams(folder / "received.mcap", sent);
}

TEST_F(ProgramSite, EachFileOfARotatedRecordingCanBeDecodedAlone)
{
  const auto sent = recordTwoStreams(folder / "sent.mcap");
  Receiving receiving(folder, at(server) + "-o part.mcap --rotate-size 1kB");
  expectRun("send -q sent.mcap" + at(server));
  EXPECT_EQ(receiving.end(SIGTERM), 0) << receiving.errors();
  const std::vector<fs::path> parts = partsIn(folder);
  EXPECT_GT(parts.size(), 2u);
  std::map<std::string, std::map<Time, Bytes>> frames;
  for (const fs::path& part : parts) {
    expectRun("verify '" + part.string() + "'");
    for (const DecodedStream& stream : decode(part.string()))
      for (const recording::RecordedFrame& frame : stream.frames)
        frames[stream.name][frame.time] = frame.bytes;
  }
  for (const KnownStream& stream : sent) {
    ASSERT_EQ(frames[stream.name].size(), stream.frames.size()); // none is lost
    for (const auto& frame : stream.frames)
      EXPECT_EQ(frames[stream.name][frame.time], frame.bytes);
  }
}

TEST_F(ProgramSite, RotatesByTheBytesOfTheFile)
{
  Receiving receiving(folder, at(server) + "-o part.mcap --rotate-size 20kB");
  SitePublisher sensor(server);
  const Bytes frame = knownStream(1, 1, 1).frames[0].bytes;
  ASSERT_LT(frame.size(), 100u);
  for (int i = 0; i < 500; ++i)
    sensor.publish(std::chrono::milliseconds(i), frame);
  EXPECT_EQ(receiving.end(SIGTERM), 0) << receiving.errors();
  const std::vector<fs::path> parts = partsIn(folder);
  EXPECT_GT(parts.size(), 2u);
  for (const fs::path& part : parts) {
    const std::string line =
        receiving.output().substr(receiving.output().find(part.filename().string()));
    const std::string told = line.substr(0, line.find(" MB"));
    EXPECT_LT(std::abs(std::stod(told.substr(told.rfind(' '))) -
                       static_cast<double>(fs::file_size(part)) * 1e-6),
              0.006)
        << told;
    EXPECT_LT(fs::file_size(part), 30'000u);
  }
}

TEST_F(ProgramSite, TellsWhichPortOfTheMetricsIsFree)
{
  const BackgroundProgram receiving(folder,
                                    "exec $P receive -q --metrics-port 0 --merge all "
                                    "--merge-wait 0s" +
                                        at(server));
  receiving.waitForOutput("/metrics\n");
  const std::string begin = "metrics: http://127.0.0.1:";
  EXPECT_EQ(receiving.output().rfind(begin, 0), 0u) << receiving.output();
  const int port = std::stoi(receiving.output().substr(begin.size()));
  EXPECT_TRUE(hasPart(metricsAt(static_cast<std::uint16_t>(port)),
                      "\npcl_ext_link_connected "));
}

TEST_F(ProgramSite, ReplaysWhatTheServerKeeps)
{
  const NatsServer keeping("jetstream { store_dir: \"FOLDER\" }");
  const auto sent = recordTwoStreams(folder / "sent.mcap");
  expectFailure("receive --replay all -o x.mcap" + at(keeping),
                1,
                "the server keeps no frames of the site 'cell'");
  EXPECT_EQ(
      expectRun("keep --max-age 1h --max-size 1GB" + at(keeping)).output,
      "the server keeps the frames of site cell of the last 1 h, up to 1 GB; now 0 "
      "frames, 0.00 MB\n");
  expectRun("send -q sent.mcap" + at(keeping));
  for (const std::string from : {"all", "10min"}) {
    expectRun("receive -q --replay " + from + " -o " + from + ".mcap" + at(keeping));
    expectTwoStreams(folder / (from + ".mcap"), sent);
  }
  // Less than the two minutes in which a server looks for repeated messages.
  EXPECT_EQ(
      expectRun("keep --max-age 90s --max-size 5MB" + at(keeping))
          .output.rfind("the server keeps the frames of site cell of the last 1.5 "
                        "min, up to 5 MB; now ",
                        0),
      0u);
}

std::string
exampleOf(const std::string& file)
{
  return textOf(std::string(PCL_EXT_SITE_EXAMPLES) + "/" + file);
}

// Whatever else the examples of server and service are for: test_site_documents.py.
TEST_F(ProgramSite, OnTheExampleOfAServerASensorMaySendAndNotListen)
{
  std::string configuration = exampleOf("nats-server.conf");
  const std::string store = "/var/lib/nats";
  configuration.replace(configuration.find(store), store.size(), "FOLDER");
  const NatsServer example(configuration);
  const std::string password = "PCL_EXT_PASSWORD='change me' \"$P\" ";
  recordTwoStreams(folder / "sent.mcap");
  const ProgramRun sent =
      runShell(password + "send -q sent.mcap --user sensor" + at(example));
  EXPECT_EQ(sent.status, 0) << sent.errors;
  const ProgramRun listening =
      runShell(password + "receive --for 300ms -o x.mcap --user sensor" + at(example));
  EXPECT_TRUE(hasPart(listening.errors, "Permissions Violation for Subscription"));
  EXPECT_EQ(listening.status, 1);
}

TEST_F(ProgramSite, GoesOnWhateverAStreamIsCalled)
{
  writeText(folder / "page.html", view_page);
  Receiving receiving(folder,
                      at(server) + "--view --no-browser --page page.html -o all.mcap "
                                   "--merge all --remove-outliers --map map.ot");
  link::FramePublisher publisher(SitePublisher::settingsOf(server));
  ASSERT_TRUE(publisher.connect().ok());
  const KnownStream known = knownStream(1, 3, 10);
  const std::vector<std::string> names = {
      "\xff\xfe", std::string("\0", 1), "\n", std::string(300, '.'), "/last"};
  for (const std::string& name : names) {
    std::size_t stream = 0;
    ASSERT_TRUE(
        publisher
            .addStream(name,
                       {{"sensor_pose", "x"}, {"\xff", "\xff"}, {"intensity_law", "?"}},
                       stream)
            .ok());
    for (const auto& frame : known.frames)
      ASSERT_TRUE(publisher
                      .publish(stream,
                               frame.time - Time(std::chrono::hours(1)) *
                                                static_cast<int>(stream),
                               frame.bytes.data(),
                               frame.bytes.size())
                      .ok());
  }
  EXPECT_TRUE(publisher.flush(std::chrono::seconds(20)));
  receiving.end(SIGINT);
  EXPECT_TRUE(hasPart(receiving.output(), "15 frames of 5 streams"));
  EXPECT_GE(decode(folder / "all.mcap").size(), 1u);
}

class Sending {
public:
  explicit Sending(const NatsServer& server)
  : first_(server, "/first"), second_(server, "/second"), thread_([this] {
    const auto frame = knownStream(1, 1, 1).frames[0];
    while (!has_ended_) {
      for (SitePublisher* const publisher : {&first_, &second_})
        publisher->publish(frame.time, frame.bytes);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  })
  {}

  ~Sending()
  {
    has_ended_ = true;
    thread_.join();
  }

  Sending(const Sending&) = delete;
  Sending&
  operator=(const Sending&) = delete;

private:
  std::atomic<bool> has_ended_{false};
  SitePublisher first_;
  SitePublisher second_;
  std::thread thread_;
};

TEST_F(ProgramSite, NamesWhatTheServerHasWhereNothingMatches)
{
  const NatsServer trial(exampleOf("trial.conf"));
  expectRun("keep -q" + at(trial));
  const Sending sending(trial);
  const Sending sending_undivided(server);
  const std::string receive = "receive -q --for 500ms --overwrite -o x.mcap ";
  const std::string both = "streams on this site: /first, /second\n";
  expectRefusals(
      1,
      {{receive + "--partition 7" + at(trial),
        "nothing came of any stream of site cell in partition 7; streams on this site: "
        "/first (partition "},
       {receive + "--partition 0" + at(server),
        "The server does not divide them: its configuration needs a mapping"},
       // One of them comes.
       {receive + "--streams /second,first" + at(server),
        "nothing came of the stream first of site cell; " + both},
       {receive + at(trial, "cel"),
        "nothing came of any stream of site cel; nothing is sent to this site at the "
        "moment; sites on this server: cell\n"},
       {receive + "--replay all --streams second" + at(trial),
        "nothing came of the stream second of site cell; " + both}});
  expectRun(receive + "--streams /first" + at(trial));
  // What is not permitted cannot be named.
  const NatsServer strict("authorization { users = [ { user: u, password: p, "
                          "permissions: { subscribe: \"cell.*.frames\" } } ] }");
  const std::pair<const char*, const char*> rows[] = {
      {"cell",
       "nothing that this user may receive is sent to this site at the moment; this "
       "user sees no other site on the server"},
      {"hall",
       "nothing came of any stream of site hall; the server does not permit this user "
       "to receive them"}};
  for (const auto& [site, text] : rows) {
    const ProgramRun run = runShell("PCL_EXT_PASSWORD=p \"$P\" " + receive +
                                    "--user u" + at(strict, site));
    EXPECT_EQ(run.status, 1);
    EXPECT_TRUE(hasPart(run.errors, text));
  }
}

TEST_F(ProgramSite, StreamsBeyondTheLimitAreALoss)
{
  const std::uint16_t port = freePort();
  Receiving receiving(folder, at(server) + "--metrics-port " + std::to_string(port));
  link::FramePublisher publisher(SitePublisher::settingsOf(server));
  ASSERT_TRUE(publisher.connect().ok());
  const Bytes frame = knownStream(1, 1, 1).frames[0].bytes;
  const std::size_t limit = link::SubscriberSettings().max_streams;
  for (std::size_t i = 0; i <= limit; ++i) {
    std::size_t stream = 0;
    ASSERT_TRUE(publisher.addStream(std::to_string(i), {}, stream).ok());
    ASSERT_TRUE(publisher.publish(stream, Time(0), frame.data(), frame.size()).ok());
  }
  EXPECT_TRUE(publisher.flush(std::chrono::seconds(20)));
  EXPECT_TRUE(view::test::waitFor([&] {
    return hasPart(metricsAt(port),
                   "\npcl_ext_link_frames_total{stream=\"" + std::to_string(limit - 1) +
                       "\"} 1\n");
  }));
  EXPECT_EQ(receiving.end(SIGINT), 1);
  EXPECT_TRUE(hasPart(receiving.output(), "4,096 frames of 4,096 streams"));
  EXPECT_EQ(receiving.errors().substr(receiving.errors().find('\n') + 1),
            "pcl_ext receive: 1 message left out, of streams beyond the first 4,096 "
            "streams\n");
}

TEST_F(ProgramSite, TellsWhatIsWrong)
{
  const NatsServer locked("authorization { user: a, password: b }");
  const std::string nobody =
      " --server nats://127.0.0.1:" + std::to_string(freePort()) + " --site cell";
  expectRefusals(2,
                 {{"send", "name an input, - or --cell"},
                  {"receive", "say what to do with the frames"},
                  {"receive -o x.mcap --site a.b", "--site is 'a.b'"},
                  {"receive -o x.mcap --streams ,,", "where a name is empty"},
                  {"receive -o x.mcap --streams ''", "where a name is empty"},
                  {"receive --merge " + std::string(1100, 'a'), "has 1100 bytes"},
                  {"receive -o folder/", "x.mcap or, of one stream"},
                  {"receive -o x.mcap --merge-wait 1s",
                   "--merge-wait is for merged streams: add --merge"},
                  {"receive --merge a --merge-wait=-1ms", "'-1ms' is below 0"},
                  {"receive --merge a --merge-period 0s", "'0s' is not above 0"},
                  {"receive -o x.mcap --map ./x.mcap",
                   "-o and --map are both './x.mcap': name two files"},
                  {"receive --merge a --merged-site cell --site cell",
                   "a centre would receive what it has merged"},
                  {"receive --merge a --merged-site a.b",
                   "--merged-site is 'a.b'; it must be up to 64 letters"},
                  {"receive --rotate-every 1s -o x.mcap --for 5", "has no unit"},
                  {"receive --view --overwrite", "add -o or --map"},
                  {"receive --map -", "--map is '-'; it must be a file"},
                  {"receive --map x.bt", "--map is 'x.bt'; it must not end in "},
                  {"receive --map no/x.ot", "--map is 'no/x.ot'; it must be a "}});
  expectRefusals(1,
                 {{"receive -o no/such/x.mcap" + at(locked), "no/such/x.mcap"},
                  {"receive -o x.mcap --user a" + at(locked),
                   "refuses user 'a': wrong user or password"},
                  {"keep" + nobody, "cannot be reached: no program listens"}});
  EXPECT_FALSE(fs::exists(folder / "x.mcap"));
  EXPECT_FALSE(fs::exists(folder / "x.mcap.unfinished"));
  EXPECT_FALSE(fs::exists(folder / "x.bt"));
  const ProgramRun right =
      runShell("PCL_EXT_PASSWORD=b \"$P\" receive -q --for 10ms -o x.mcap --user a" +
               at(locked));
  EXPECT_EQ(right.status, 1);
  EXPECT_TRUE(hasPart(right.errors, "nothing is sent to this site"));
}

} // namespace pcl_ext::tools::test
