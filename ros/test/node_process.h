/** \file
 * \brief Programs and nodes that a test starts, observes and stops.
 */
#pragma once

#include <sys/types.h>
#include <XmlRpcValue.h>

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext_ros1 {
namespace test {

/** \brief A folder that is removed after the test program. */
std::string
temporaryFolder();

/** \brief A running program. It ends with this object at the latest. */
class ChildProcess {
public:
  /** \brief Starts a program.
   * \param[in] command the program, searched in PATH if it has no slash, and its
   * arguments
   */
  explicit ChildProcess(std::vector<std::string> command);

  /** \brief Interrupts the program, then kills it if it does not end. */
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess&
  operator=(const ChildProcess&) = delete;

  /** \brief Waits for the end of the program.
   * \return exit code, or -signal if a signal ended it; nothing if it still runs
   */
  std::optional<int>
  waitForExit(double seconds = 20.0);

  /** \brief Sends SIGINT, as Ctrl-C does, and waits.
   * \return as waitForExit
   */
  std::optional<int>
  interrupt(double seconds = 20.0);

  /** \brief Sends SIGKILL and waits. */
  void
  kill();

  bool
  isRunning();

  /** \brief Its output until now, stdout and stderr together. */
  std::string
  output() const;

  /** \brief Waits for a text in the output; a failure of the test if it does not
   * come. */
  void
  expectOutput(const std::string& text) const;

private:
  void
  send(int signal_number);

  pid_t pid_ = -1;
  std::optional<int> exit_code_;
  std::string output_file_;
};

/** \brief Private parameters of a node; names without the tilde. */
using Parameters = std::vector<std::pair<std::string, XmlRpc::XmlRpcValue>>;

/** \brief The parameters, then the others; where both have a name, that of the
 * others. */
Parameters
operator+(Parameters parameters, const Parameters& others);

/** \brief A list as the value of a parameter. */
XmlRpc::XmlRpcValue
listOf(const std::vector<XmlRpc::XmlRpcValue>& elements);

/** \brief An entry of ~streams: a topic and one setting. */
XmlRpc::XmlRpcValue
streamEntry(const std::string& topic,
            const std::string& name,
            const XmlRpc::XmlRpcValue& value);

/** \brief A node of this package. */
class NodeProcess : public ChildProcess {
public:
  /** \brief Sets the parameters and starts a node.
   * \param[in] program intensity_compressor, intensity_decompressor or simulated_cell
   * \param[in] full_name of the node, with its namespace
   * \param[in] parameters private ones
   * \param[in] arguments remappings, from:=to
   */
  NodeProcess(const std::string& program,
              const std::string& full_name,
              const Parameters& parameters = {},
              const std::vector<std::string>& arguments = {});

  /** \brief Number of connections over which the node publishes a topic. Asks the node,
   * as the master lists subscriptions, not connections.
   * \param[in] topic full name
   */
  std::size_t
  subscribersOf(const std::string& topic) const;

  /** \brief Waits for that many connections, or more; a failure of the test if they do
   * not come. */
  void
  expectSubscribers(const std::string& topic, std::size_t count) const;

private:
  const std::string name_; // with its namespace
};

} // namespace test
} // namespace pcl_ext_ros1
