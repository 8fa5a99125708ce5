#include "measuring/result_file.h"

#include <iostream>
#include <stdexcept>

namespace pcl_ext {
namespace measuring {

ResultFile::ResultFile(const std::string& path)
: path_(path.empty() ? "standard output" : path)
, output_(path.empty() ? std::cout.rdbuf() : file_.open(path, std::ios::out))
{
  if (!output_)
    throw std::runtime_error("cannot write '" + path_ + "'");
  output_.precision(10);
  output_ << "experiment,sensor,coder,resolution_cm,quantity,mean,deviation,samples\n";
}

void
ResultFile::addLine(const Subject& subject,
                    const std::string& quantity,
                    double mean,
                    double deviation,
                    std::size_t samples)
{
  output_ << subject.experiment << ',' << subject.sensor << ',' << subject.coder << ','
          << 100.0 * subject.resolution << ',' << quantity << ',' << mean << ','
          << deviation << ',' << samples << '\n';
}

void
ResultFile::add(const Subject& subject,
                const std::string& quantity,
                const Samples& samples)
{
  addLine(subject, quantity, samples.mean(), samples.deviation(), samples.count());
}

void
ResultFile::add(const Subject& subject,
                const std::string& quantity,
                double value,
                std::size_t samples)
{
  addLine(subject, quantity, value, 0.0, samples);
}

void
ResultFile::close()
{
  output_.flush();
  if (!output_)
    throw std::runtime_error("could not write all of '" + path_ + "'");
}

} // namespace measuring
} // namespace pcl_ext
