#include "node_process.h"

#include "waiting.h"

#include <gtest/gtest.h>

#include <fcntl.h>
#include <ros/param.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

namespace pcl_ext_ros {
namespace test {

namespace {

constexpr double seconds_to_stop = 10.0;

/** \brief A file in the folder that ends with the test. */
std::string
newOutputFile()
{
  static int number = 0;
  const char* const folder = std::getenv("ROS_HOME");
  return std::string(folder ? folder : ".") + "/output_" + std::to_string(number++) +
         ".txt";
}

/** \brief What the child does from fork to exec; only what is allowed there. */
[[noreturn]] void
becomeProgram(const char* output_file, char* const* arguments)
{
  ::prctl(PR_SET_PDEATHSIG, SIGKILL); // a test that crashes leaves nothing behind
  const int output = ::open(output_file, O_WRONLY | O_CREAT | O_TRUNC, 0600);
  ::dup2(output, STDOUT_FILENO);
  ::dup2(output, STDERR_FILENO);
  ::execvp(arguments[0], arguments);
  ::_exit(127);
}

std::vector<std::string>
nodeCommand(const std::string& program,
            const std::string& full_name,
            const std::vector<std::string>& arguments)
{
  const std::size_t slash = full_name.rfind('/');
  std::vector<std::string> command{std::string(PCL_EXT_ROS_NODES) + "/" + program,
                                   "__ns:=" + full_name.substr(0, slash),
                                   "__name:=" + full_name.substr(slash + 1)};
  command.insert(command.end(), arguments.begin(), arguments.end());
  return command;
}

} // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& command)
: output_file_(newOutputFile())
{
  std::vector<std::string> texts = command;
  std::vector<char*> arguments;
  for (std::string& text : texts)
    arguments.push_back(text.data());
  arguments.push_back(nullptr);
  pid_ = ::fork();
  if (pid_ == 0)
    becomeProgram(output_file_.c_str(), arguments.data());
  EXPECT_GT(pid_, 0) << "fork failed";
}

ChildProcess::~ChildProcess()
{
  send(SIGINT);
  if (!waitForExit(seconds_to_stop))
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
ChildProcess::interrupt()
{
  send(SIGINT);
  return waitForExit();
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
setParameters(const std::string& node_name, const Parameters& parameters)
{
  for (const auto& [name, value] : parameters)
    ros::param::set(node_name + "/" + name, value);
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

NodeProcess::NodeProcess(const std::string& program,
                         const std::string& full_name,
                         const Parameters& parameters,
                         const std::vector<std::string>& arguments)
: ChildProcess((setParameters(full_name, parameters),
                nodeCommand(program, full_name, arguments)))
, name_(full_name)
{}

} // namespace test
} // namespace pcl_ext_ros
