// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "options/bin_options.h"

#include "clouds/bin_file.h"
#include "options/options.h"

#include <stdexcept>
#include <string>

namespace pcl_ext::tools {

void
addBinFields(CLI::App& app, std::vector<clouds::FileField>& fields)
{
  addParsed(app,
            "--bin-fields",
            "NAME[:TYPE],...",
            "of .bin files: x,y,z,_,ring:uint16; _: left out (by name)",
            [&fields](const std::string& text) {
              try {
                fields = clouds::parseBinFields(text);
              }
              catch (const std::runtime_error& error) {
                throw UsageError(std::string("--bin-fields: ") + error.what());
              }
            });
}

} // namespace pcl_ext::tools
