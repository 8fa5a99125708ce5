#include "node_process.h"

#include "recorder.h"

#include <gtest/gtest.h>

#include <fcntl.h>
#include <ros/master.h>
#include <ros/network.h>
#include <ros/param.h>
#include <ros/this_node.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <XmlRpcClient.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>

namespace pcl_ext_ros1 {
namespace test {

namespace {

std::string
newOutputFile()
{
  static int number = 0;
  return temporaryFolder() + "/output_" + std::to_string(number++) + ".txt";
}

/** \brief The child between fork and exec, where few functions are allowed. */
[[noreturn]] void
becomeProgram(const char* output_file, char* const* arguments)
{
  ::prctl(PR_SET_PDEATHSIG, SIGKILL); // ends with a test that crashes
  const int output = ::open(output_file, O_WRONLY | O_CREAT | O_TRUNC, 0600);
  ::dup2(output, STDOUT_FILENO);
  ::dup2(output, STDERR_FILENO);
  ::execvp(arguments[0], arguments);
  ::_exit(127);
}

/** \brief Sets the parameters of a node and returns the command that starts it. */
std::vector<std::string>
prepareNode(const std::string& program,
            const std::string& full_name,
            const Parameters& parameters,
            const std::vector<std::string>& arguments)
{
  for (const auto& [name, value] : parameters)
    ros::param::set(full_name + "/" + name, value);
  const std::size_t slash = full_name.rfind('/');
  std::vector<std::string> command{std::string(PCL_EXT_ROS1_NODES) + "/" + program,
                                   "__ns:=" + full_name.substr(0, slash),
                                   "__name:=" + full_name.substr(slash + 1)};
  command.insert(command.end(), arguments.begin(), arguments.end());
  return command;
}

} // namespace

std::string
temporaryFolder()
{
  const char* const folder = std::getenv("ROS_HOME"); // of with_master.py
  return folder != nullptr ? folder : ".";
}

ChildProcess::ChildProcess(std::vector<std::string> command)
: output_file_(newOutputFile())
{
  std::vector<char*> arguments;
  for (std::string& text : command)
    arguments.push_back(text.data());
  arguments.push_back(nullptr);
  pid_ = ::fork();
  if (pid_ == 0)
    becomeProgram(output_file_.c_str(), arguments.data());
  EXPECT_GT(pid_, 0) << "fork failed";
}

ChildProcess::~ChildProcess()
{
  if (!interrupt(10.0))
    kill();
}

void
ChildProcess::send(int signal_number)
{
  if (isRunning())
    ::kill(pid_, signal_number);
}

std::optional<int>
ChildProcess::waitForExit(double seconds)
{
  waitFor([this] { return !isRunning(); }, seconds);
  return exit_code_;
}

std::optional<int>
ChildProcess::interrupt(double seconds)
{
  send(SIGINT);
  return waitForExit(seconds);
}

void
ChildProcess::kill()
{
  send(SIGKILL);
  waitForExit();
}

bool
ChildProcess::isRunning()
{
  int state = 0;
  if (exit_code_ || pid_ <= 0 || ::waitpid(pid_, &state, WNOHANG) != pid_)
    return !exit_code_ && pid_ > 0;
  exit_code_ = WIFEXITED(state) ? WEXITSTATUS(state) : -WTERMSIG(state);
  return false;
}

std::string
ChildProcess::output() const
{
  std::ostringstream text;
  text << std::ifstream(output_file_).rdbuf();
  return text.str();
}

void
ChildProcess::expectOutput(const std::string& text) const
{
  EXPECT_TRUE(waitFor([&] { return output().find(text) != std::string::npos; }))
      << "no '" << text << "' in:\n"
      << output();
}

Parameters
operator+(Parameters parameters, const Parameters& others)
{
  for (const auto& other : others) {
    const auto same =
        std::find_if(parameters.begin(), parameters.end(), [&](const auto& parameter) {
          return parameter.first == other.first;
        });
    if (same != parameters.end())
      *same = other;
    else
      parameters.push_back(other);
  }
  return parameters;
}

XmlRpc::XmlRpcValue
listOf(const std::vector<XmlRpc::XmlRpcValue>& elements)
{
  XmlRpc::XmlRpcValue list;
  list.setSize(static_cast<int>(elements.size()));
  for (std::size_t i = 0; i < elements.size(); ++i)
    list[static_cast<int>(i)] = elements[i];
  return list;
}

XmlRpc::XmlRpcValue
streamEntry(const std::string& topic,
            const std::string& name,
            const XmlRpc::XmlRpcValue& value)
{
  XmlRpc::XmlRpcValue entry;
  entry["topic"] = topic;
  entry[name] = value;
  return entry;
}

NodeProcess::NodeProcess(const std::string& program,
                         const std::string& full_name,
                         const Parameters& parameters,
                         const std::vector<std::string>& arguments)
: ChildProcess(prepareNode(program, full_name, parameters, arguments)), name_(full_name)
{}

std::size_t
NodeProcess::subscribersOf(const std::string& topic) const
{
  XmlRpc::XmlRpcValue request;
  XmlRpc::XmlRpcValue response;
  XmlRpc::XmlRpcValue uri;
  request[0] = ros::this_node::getName();
  request[1] = name_;
  constexpr bool waits_for_master = false;
  std::string host;
  std::uint32_t port = 0;
  if (!ros::master::execute("lookupNode", request, response, uri, waits_for_master) ||
      !ros::network::splitURI(uri, host, port))
    return 0;
  XmlRpc::XmlRpcClient node(host.c_str(), static_cast<int>(port), "/");
  XmlRpc::XmlRpcValue caller;
  caller[0] = ros::this_node::getName();
  XmlRpc::XmlRpcValue answer;
  if (!node.execute("getBusInfo", caller, answer) || node.isFault())
    return 0;
  // [code, text, [[id, peer, direction, protocol, topic, ..], ..]]
  std::size_t count = 0;
  for (int i = 0; i < answer[2].size(); ++i)
    if (static_cast<std::string>(answer[2][i][2]) == "o" &&
        static_cast<std::string>(answer[2][i][4]) == topic)
      ++count;
  return count;
}

void
NodeProcess::expectSubscribers(const std::string& topic, std::size_t count) const
{
  EXPECT_TRUE(waitFor([&] { return subscribersOf(topic) >= count; }))
      << name_ << " has no " << count << " subscribers of " << topic << '\n'
      << output();
}

} // namespace test
} // namespace pcl_ext_ros1
