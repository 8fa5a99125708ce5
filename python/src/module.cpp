// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The module pcl_ext._native: the library for the classes of the package, which
 * have the documentation. Outcomes are returned as tuples with the name of their code.
 */
#include <pcl_ext/version.h>

#include "bindings.h"

namespace pcl_ext::python {

PYBIND11_MODULE(_native, module)
{
  module.attr("version") = pcl_ext::version();
  addCodec(module);
  addRecordings(module);
}

} // namespace pcl_ext::python
