// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// The one definition of PCL's range coders in a test program: PCL's header defines them
// without `inline`, and a library that instantiates them would bring VTK along.
#include <pcl/compression/entropy_range_coder.h>
#include <pcl/io/impl/entropy_range_coder.hpp>
