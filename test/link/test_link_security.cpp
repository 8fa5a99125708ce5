// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "link/linked_streams.h"

#include <cstdlib>

namespace {

using namespace pcl_ext::link;
using namespace pcl_ext::link::test;

void
expectRefusal(const LinkSettings& settings, LinkCode code, const std::string& text)
{
  FramePublisher publisher(settings);
  const LinkStatus status = publisher.connect();
  expectCode(status, code);
  EXPECT_TRUE(hasPart(status.message(), text));
  std::size_t stream = 0;
  expectCode(publisher.addStream("/a", {}, stream), LinkCode::NotConnected);
}

TEST(LinkSecurity, ChecksSettingsBeforeItConnects)
{
  LinkSettings settings;
  settings.site = "a.b";
  expectRefusal(
      settings, LinkCode::InvalidSettings, "site is 'a.b'; it must be up to 64");
  settings.site = "";
  expectRefusal(settings, LinkCode::InvalidSettings, "site is ''");
  settings.site = "cell";
  settings.servers = "localhost:4222";
  expectRefusal(
      settings, LinkCode::InvalidSettings, "servers is 'localhost:4222'; it must");
  settings.servers = "";
  expectRefusal(settings, LinkCode::InvalidSettings, "servers is ''");
  settings.servers = "nats://127.0.0.1:" + std::to_string(freePort());
  settings.key_file = "key.pem";
  expectRefusal(settings, LinkCode::InvalidSettings, "certificate_file and key_file");
  settings.key_file = "";
  settings.ca_file = "/no/such/file";
  expectRefusal(settings, LinkCode::InvalidSettings, "'/no/such/file' cannot be read");
  settings.ca_file = "";
  expectRefusal(settings, LinkCode::CannotConnect, "cannot be reached: no program");
  settings.connect_timeout = std::chrono::milliseconds(0);
  expectRefusal(settings, LinkCode::InvalidSettings, "connect_timeout is '0 ms'");
}

TEST(LinkSecurity, ShowsNothingOfAUserOrPassword)
{
  const std::string rest = "'; it must be nats://HOST:PORT or tls://HOST:PORT";
  const std::vector<std::pair<std::string, std::string>> shown = {
      {"nats://user:secret", "nats://..."},
      {"nats://user:secret,tail", "nats://..."},
      {"nats://user:secret/1", "nats://..."},
      {"nats://user:123456", "nats://..."},
      {"user:secret@a:1", "a:1"},
      {"user:se,cret@a:1", "a:1"},
      {"secret://user@a:1", "a:1"},
      {"nats://user:secret@a:port", "nats://..."},
      {"nats://user:secret@a,secret", "nats://..."},
      {"nats://user:secret@a:1,b:2", "nats://..."},
      {"nats://user:se,cret@a:1,nats://user:secret", "nats://a:1,nats://..."},
      {"nats://a:1,tls://user:se,cret@[::1]:2/,nats://",
       "nats://a:1,tls://[::1]:2,nats://..."},
      {"nats://", "nats://..."},
      {"tls://:1", "tls://..."},
      {"nats://[::1", "nats://..."},
      {"nats://a:1, nats://user:secret@b:2", "nats://a:1,b:2"},
  };
  for (const auto& [servers, text] : shown) {
    LinkSettings settings;
    settings.servers = servers;
    expectCode(checkSettings(settings), LinkCode::InvalidSettings);
    EXPECT_EQ(checkSettings(settings).message(), "servers is '" + text + rest)
        << servers;
  }
}

TEST(LinkSecurity, TakesAUserWhateverItHasAndTellsOfAWrongOne)
{
  const NatsServer server("authorization { user: \"a,b\", password: \"c,d@e:f,g\" }");
  const std::string host = server.url().substr(7);
  LinkSettings settings = settingsOf(server);
  expectRefusal(settings, LinkCode::Refused, "refuses a client without the right user");
  settings.user = "a,b";
  settings.password = "secret,d";
  expectRefusal(
      settings, LinkCode::Refused, "refuses user 'a,b': wrong user or password");
  settings.password = "c,d@e:f,g";
  LinkSettings in_address = settingsOf(server);
  in_address.servers = "nats://127.0.0.1:" + std::to_string(freePort()) +
                       ",nats://a,b:c,d@e:f,g@" + host;
  for (const LinkSettings& right : {settings, in_address}) {
    Receiver receiver(right);
    Sensor sensor(right);
    sensor.publish();
    EXPECT_TRUE(receiver.take());
  }
  // Nothing of a password is in a message.
  in_address.servers = "nats://a,b:secret,d@" + host;
  FramePublisher refused(in_address);
  const LinkStatus status = refused.connect();
  expectCode(status, LinkCode::Refused);
  EXPECT_EQ(status.message().rfind("the server at " + server.url() + " refuses", 0), 0u)
      << status.message();
  EXPECT_FALSE(hasPart(status.message(), "secret"));
}

TEST(LinkSecurity, TellsWhatAServerDoesNotPermitOnceWhateverComesBetween)
{
  const NatsServer server(
      "authorization { users = [ { user: viewer, password: v, permissions: "
      "{ publish: [\"cell.*.requests\", \"cell.*.echo\"], subscribe: \">\" } } ] }");
  LinkSettings settings = settingsOf(server);
  settings.user = "viewer";
  settings.password = "v";
  std::mutex mutex;
  std::vector<std::string> events;
  settings.on_event = [&](const std::string& event) {
    const std::lock_guard<std::mutex> lock(mutex);
    events.push_back(event);
  };
  FramePublisher publisher(settings);
  expectCode(publisher.connect(), LinkCode::Ok);
  std::size_t streams[2] = {};
  expectCode(publisher.addStream("/a", {}, streams[0]), LinkCode::Ok);
  expectCode(publisher.addStream("/b", {}, streams[1]), LinkCode::Ok);
  const Bytes frame = LiveSource(1000).next();
  for (std::uint64_t count = 1; count <= 6; ++count) {
    publisher.publish(streams[count % 2], Time(1), frame.data(), frame.size());
    ASSERT_TRUE(waitFor([&] { return publisher.statistics().violations == count; }));
  }
  publisher.flush(std::chrono::seconds(10));
  const PublisherStatistics sent = publisher.statistics();
  EXPECT_EQ(sent.frames, 0u); // the server had them, and did not permit them
  EXPECT_EQ(sent.bytes, 0u);
  EXPECT_EQ(sent.frames_not_sent, 6u);
  EXPECT_TRUE(waitFor([&] {
    const std::lock_guard<std::mutex> lock(mutex);
    return events.size() >= 2;
  }));
  const std::lock_guard<std::mutex> lock(mutex);
  ASSERT_EQ(events.size(), 2u);
  EXPECT_TRUE(
      hasPart(events[0], "Permissions Violation for Publish to \"cell./b.frames\""))
      << events[0];
  EXPECT_TRUE(hasPart(events[1], "cell./a.frames")) << events[1];
}

/** \brief A server with a user "sensor" of these permissions. */
std::string
permitting(const std::string& permissions)
{
  return "authorization { users = [ { user: sensor, password: s, permissions: { " +
         permissions + " } } ] }";
}

TEST(LinkSecurity, RefusesAPublisherUntilItMayLearnWhatHasArrived)
{
  const std::string none = "publish: \"cell.*.frames\", subscribe: \"cell.*.requests\"";
  for (const std::string& permissions :
       {none, none + ", publish: [\"cell.*.frames\", \"cell.*.echo\"]"}) {
    NatsServer server(permitting(permissions));
    LinkSettings settings = settingsOf(server);
    settings.user = "sensor";
    settings.password = "s";
    settings.connect_timeout = std::chrono::seconds(60); // nothing waits for it
    FramePublisher publisher(settings);
    std::size_t stream = 0;
    for (int i = 0; i < 2; ++i) {
      const LinkStatus status = publisher.connect();
      expectCode(status, LinkCode::Refused);
      EXPECT_TRUE(hasPart(status.message(), "cell.*.echo")) << status.message();
      expectCode(publisher.addStream("/a", {}, stream), LinkCode::NotConnected);
    }
    server.reload(permitting("publish: \">\", subscribe: \">\""));
    ASSERT_TRUE(waitFor([&] { return publisher.connect().ok(); }));
    expectCode(publisher.addStream("/a", {}, stream), LinkCode::Ok);
    const Bytes frame = LiveSource(1000).next();
    const auto publish = [&] {
      return publisher.publish(stream, Time(1), frame.data(), frame.size()).ok();
    };
    EXPECT_TRUE(publish());
    EXPECT_TRUE(publisher.flush(std::chrono::seconds(60)));
    // Taken away, and given back.
    server.reload(permitting(permissions));
    ASSERT_TRUE(waitFor([&] { return !publish(); }));
    server.reload(permitting("publish: \">\", subscribe: \">\""));
    ASSERT_TRUE(waitFor([&] { return publish(); }));
    EXPECT_TRUE(publisher.flush(std::chrono::seconds(60)));
    EXPECT_EQ(publisher.statistics().frames_under_way, 0u);
  }
}

/** \brief Makes certificate.pem and key.pem, and the configuration of a server with them.
 * \param[in] names of the server, as openssl takes them
 */
std::string
tlsOf(const TestFolder& folder, const std::string& names)
{
  const std::string make =
      "cd '" + folder / "" +
      "' && openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes "
      "-keyout key.pem -out certificate.pem -days 2 -subj /CN=localhost -addext "
      "'subjectAltName=" +
      names + "' 2> openssl.log";
  EXPECT_EQ(std::system(make.c_str()), 0);
  return "tls { cert_file: \"" + folder / "certificate.pem" + "\", key_file: \"" +
         folder / "key.pem" + "\" }";
}

TEST(LinkSecurity, TellsOfACertificateOfAnotherHost)
{
  const TestFolder folder;
  const NatsServer server(tlsOf(folder, "DNS:elsewhere"));
  LinkSettings settings = settingsOf(server);
  settings.servers = server.url("tls");
  settings.ca_file = folder / "certificate.pem";
  expectRefusal(settings,
                LinkCode::CannotConnect,
                "the server's certificate must have the name or address by which");
}

TEST(LinkSecurity, Encrypts)
{
  const TestFolder folder;
  const NatsServer server(tlsOf(folder, "DNS:localhost,IP:127.0.0.1"));
  LinkSettings settings = settingsOf(server);
  for (const char* const scheme : {"nats", "tls"}) {
    settings.servers = server.url(scheme);
    expectRefusal(settings,
                  LinkCode::CannotConnect,
                  "takes encrypted connections, and TLS fails");
    expectRefusal(settings, LinkCode::CannotConnect, "self-signed certificate");
  }
  settings.ca_file = folder / "certificate.pem";
  Receiver receiver(settings);
  Sensor sensor(settings);
  sensor.publish();
  EXPECT_TRUE(receiver.take());

  const NatsServer plain;
  settings.servers = plain.url("tls");
  expectRefusal(settings, LinkCode::CannotConnect, "has no TLS");
}

} // namespace
