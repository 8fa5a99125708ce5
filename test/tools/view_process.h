/** \file
 * \brief pcl_ext view in the background.
 */
#pragma once

#include "tools/program.h"

#include <sys/types.h>

#include <cstdint>
#include <string>

namespace pcl_ext {
namespace tools {
namespace test {

/** \brief A run of pcl_ext view that serves until it is told to end. */
class ViewProcess {
public:
  /** \brief Starts it and waits until it serves.
   * \param[in] folder working folder; page.html is written there
   * \param[in] arguments as a shell takes them
   * \param[in] environment such as "NAME=value"
   */
  ViewProcess(const TestFolder& folder,
              const std::string& arguments,
              const std::string& environment = "DISPLAY= WAYLAND_DISPLAY=");

  /** \brief Ends it if it still runs. */
  ~ViewProcess();
  ViewProcess(const ViewProcess&) = delete;
  ViewProcess&
  operator=(const ViewProcess&) = delete;

  std::uint16_t
  port() const
  {
    return port_;
  }

  /** \brief The line that tells the address. */
  const std::string&
  line() const
  {
    return line_;
  }

  /** \brief Writes to its standard input. */
  void
  write(const Bytes& bytes);

  void
  closeInput();

  /** \brief Waits for its end.
   * \param[in] signal that it is sent before; 0: none
   * \return its exit status
   */
  int
  waitForEnd(int signal);

  /** \brief What it has written to its standard error until now. */
  std::string
  errors() const;

private:
  pid_t pid_ = -1;
  int input_ = -1;
  std::string errors_file_;
  std::string line_;
  std::uint16_t port_ = 0;
};

/** \brief The page that ViewProcess writes. */
constexpr char view_page[] = "<html><head></head><body class=\"x\"><p></body></html>";

} // namespace test
} // namespace tools
} // namespace pcl_ext
