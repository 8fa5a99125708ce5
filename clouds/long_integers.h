// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl/PCLPointCloud2.h>

#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace pcl_ext {
namespace clouds {

/** \brief A field cannot be used as the user wants it. */
class FieldRefusal : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/** \brief What becomes of fields of 64-bit integers, which frames have not, in the clouds
 * of a stream: doubles if these have all values of a cloud, else two uint32 with the same
 * bits. A field that has become two numbers stays so. */
class LongIntegers {
public:
  std::vector<std::string> with_step; ///< fields whose values are rounded to a step
  /** \brief Of several points one value is kept, which must be one of theirs: numbers of
   * 32 bits if these have all values, no doubles but for fields with a step. */
  bool one_of_several = false;

  /** \brief Turns integers of 64 bits of the next cloud into other numbers.
   * \param[in,out] cloud numbers in the order of this machine
   * \param[in,out] remarks is appended to
   * \throws FieldRefusal for a field with a step that needs two numbers
   */
  void
  makeShorter(pcl::PCLPointCloud2& cloud, std::vector<std::string>& remarks);

private:
  /** \brief What a field may become, the next one if it has not all values. */
  enum class Form { Double, Int32, Uint32, TwoUint32 };

  Form
  formOf(const pcl::PCLPointCloud2& cloud, const pcl::PCLPointField& field);

  bool
  holdsAll(Form form,
           const pcl::PCLPointCloud2& cloud,
           const pcl::PCLPointField& field) const;

  bool
  hasStep(const pcl::PCLPointField& field) const;

  std::map<std::string, Form> forms_; // of the clouds before
};

} // namespace clouds
} // namespace pcl_ext
