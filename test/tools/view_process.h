// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include "tools/background_program.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdint>
#include <string>

namespace pcl_ext::tools::test {

/** \brief A run of pcl_ext view that serves until it is told to end. */
class ViewProcess : public BackgroundProgram {
public:
  /** \brief Starts it and waits until it serves.
   * \param[in] folder working folder; page.html is written there
   * \param[in] arguments as a shell takes them
   * \param[in] environment such as "NAME=value"
   */
  ViewProcess(const TestFolder& folder,
              const std::string& arguments,
              const std::string& environment = "DISPLAY= WAYLAND_DISPLAY=")
  : ViewProcess(folder, arguments, environment, Input(folder))
  {}

  ~ViewProcess() { closeInput(); }
  ViewProcess(const ViewProcess&) = delete;
  ViewProcess&
  operator=(const ViewProcess&) = delete;

  std::uint16_t
  port() const
  {
    const std::string text = line();
    const std::size_t end = text.rfind("/ (");
    EXPECT_NE(end, std::string::npos) << text << errors();
    return end == std::string::npos ? std::uint16_t{0}
                                    : static_cast<std::uint16_t>(std::stoi(
                                          text.substr(text.rfind(':', end) + 1)));
  }

  std::string
  line() const
  {
    const std::string text = output();
    return text.substr(0, text.find('\n') + 1);
  }

  void
  write(const Bytes& bytes) const
  {
    EXPECT_EQ(::write(input_, bytes.data(), bytes.size()),
              static_cast<ssize_t>(bytes.size()));
  }

  void
  closeInput()
  {
    if (input_ >= 0)
      ::close(input_);
    input_ = -1;
  }

private:
  /** \brief A pipe with a name for the standard input, and what else is there before the
   * program runs. */
  struct Input {
    explicit Input(const TestFolder& folder)
    {
      static int runs = 0;
      name = "view_" + std::to_string(++runs);
      const std::string path = folder / name;
      EXPECT_EQ(::mkfifo(path.c_str(), S_IRUSR | S_IWUSR), 0);
      file = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
      writeText(folder / "page.html", view_page);
    }

    std::string name;
    int file;
  };

  ViewProcess(const TestFolder& folder,
              const std::string& arguments,
              const std::string& environment,
              const Input& input)
  : BackgroundProgram(folder,
                      "exec env " + environment + " \"$P\" view --page page.html < " +
                          input.name + " " + arguments)
  , input_(input.file)
  {
    EXPECT_TRUE(view::test::waitFor([&] { return !line().empty(); })) << errors();
  }

  int input_;
};

} // namespace pcl_ext::tools::test
