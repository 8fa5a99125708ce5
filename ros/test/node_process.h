/** \file
 * \brief Programs that a test starts, watches and stops.
 */
#pragma once

#include <sys/types.h>
#include <XmlRpcValue.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext_ros {
namespace test {

/** \brief Private parameters of a node; names without the tilde. */
using Parameters = std::vector<std::pair<std::string, XmlRpc::XmlRpcValue>>;

/** \brief A program that runs beside the test, and never longer than this object lives. */
class ChildProcess {
public:
  /** \brief Starts a program.
   * \param[in] command the program, found in PATH if it has no slash, and its arguments
   */
  explicit ChildProcess(const std::vector<std::string>& command);

  /** \brief Interrupts the program if it still runs, and kills it if that does not help. */
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess&
  operator=(const ChildProcess&) = delete;

  /** \brief Sends a signal, if the program still runs. */
  void
  send(int signal_number);

  /** \brief Waits for the end of the program.
   * \return its exit code, or -signal if one ended it; none if it still runs
   */
  std::optional<int>
  waitForExit(double seconds = 20.0);

  /** \brief SIGINT, which a node ends by as by Ctrl-C, and waits.
   * \return as waitForExit
   */
  std::optional<int>
  interrupt();

  /** \brief SIGKILL, as a computer that loses power, and waits. */
  void
  kill();

  /** \brief True as long as the program runs. */
  bool
  isRunning();

  /** \brief What it wrote until now, stdout and stderr together. */
  std::string
  output() const;

private:
  pid_t pid_ = -1;
  std::optional<int> exit_code_;
  std::string output_file_;
};

/** \brief A private parameter as the master keeps it. */
void
setParameters(const std::string& node_name, const Parameters& parameters);

/** \brief A list for a parameter. */
XmlRpc::XmlRpcValue
listOf(const std::vector<XmlRpc::XmlRpcValue>& elements);

/** \brief One node of this package. */
class NodeProcess : public ChildProcess {
public:
  /** \brief Starts a node.
   * \param[in] program intensity_compressor, intensity_decompressor or simulated_cell
   * \param[in] full_name of the node, with its namespace
   * \param[in] parameters private parameters, set before it starts
   * \param[in] arguments remappings, from:=to
   */
  NodeProcess(const std::string& program,
              const std::string& full_name,
              const Parameters& parameters = {},
              const std::vector<std::string>& arguments = {});

  /** \brief With its namespace. */
  const std::string&
  name() const
  {
    return name_;
  }

private:
  std::string name_;
};

} // namespace test
} // namespace pcl_ext_ros
