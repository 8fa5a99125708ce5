// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "viewing/browser.h"

#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>

extern char** environ; // no header of POSIX has it

namespace pcl_ext::tools {

namespace {

#ifndef __APPLE__
bool
isSet(const char* variable)
{
  const char* const value = std::getenv(variable);
  return value != nullptr && *value != '\0';
}
#endif

} // namespace

bool
openBrowser(const std::string& url)
{
#ifdef __APPLE__
  std::string program = "open";
#else
  std::string program = "xdg-open";
  if (!isSet("DISPLAY") && !isSet("WAYLAND_DISPLAY"))
    return false;
#endif
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&files, descriptor, "/dev/null", O_RDWR, 0);
  // A process group of its own: an interrupt from the keyboard is not for the browser.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t defaults;
  sigemptyset(&defaults);
  sigaddset(&defaults, SIGPIPE);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
  std::string argument = url;
  char* const arguments[] = {program.data(), argument.data(), nullptr};
  pid_t child = 0;
  const int error =
      ::posix_spawnp(&child, program.c_str(), &files, &attributes, arguments, environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  return error == 0;
}

} // namespace pcl_ext::tools
