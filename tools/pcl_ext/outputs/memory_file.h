#pragma once

#include <string>

namespace pcl_ext {
namespace tools {

/** \brief A file in memory. PCL writes clouds into it: on a full disk it would crash,
 * or not notice. */
class MemoryFile {
public:
  /** \throws std::runtime_error if there is no memory */
  MemoryFile();
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile&
  operator=(const MemoryFile&) = delete;

  /** \brief A path for functions that write a file. */
  const std::string&
  path() const
  {
    return path_;
  }

  /** \brief Writes what is in the file to another one.
   * \throws std::runtime_error with the reason
   */
  void
  copyTo(const std::string& path) const;

private:
  int file_;
  std::string path_;
};

} // namespace tools
} // namespace pcl_ext
