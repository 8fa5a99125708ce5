// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Points of 16 and 32 bytes, which begin with x, y, z and a fourth float.
 */
#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <type_traits>

#define PCL_ADD_POINT4D                                                                \
  union EIGEN_ALIGN16 {                                                                \
    float data[4];                                                                     \
    struct {                                                                           \
      float x;                                                                         \
      float y;                                                                         \
      float z;                                                                         \
    };                                                                                 \
  };                                                                                   \
  Eigen::Map<Eigen::Vector4f, Eigen::Aligned16> getVector4fMap()                       \
  {                                                                                    \
    return Eigen::Map<Eigen::Vector4f, Eigen::Aligned16>(data);                        \
  }                                                                                    \
  Eigen::Map<const Eigen::Vector4f, Eigen::Aligned16> getVector4fMap() const           \
  {                                                                                    \
    return Eigen::Map<const Eigen::Vector4f, Eigen::Aligned16>(data);                  \
  }                                                                                    \
  Eigen::Map<Eigen::Vector3f> getVector3fMap()                                         \
  {                                                                                    \
    return Eigen::Map<Eigen::Vector3f>(data);                                          \
  }                                                                                    \
  Eigen::Map<const Eigen::Vector3f> getVector3fMap() const                             \
  {                                                                                    \
    return Eigen::Map<const Eigen::Vector3f>(data);                                    \
  }

#define PCL_ADD_RGB                                                                    \
  union {                                                                              \
    struct {                                                                           \
      std::uint8_t b;                                                                  \
      std::uint8_t g;                                                                  \
      std::uint8_t r;                                                                  \
      std::uint8_t a;                                                                  \
    };                                                                                 \
    float rgb;                                                                         \
    std::uint32_t rgba;                                                                \
  };

#define PCL_MAKE_ALIGNED_OPERATOR_NEW EIGEN_MAKE_ALIGNED_OPERATOR_NEW

// The members of a point are found by their names.
#define POINT_CLOUD_REGISTER_POINT_STRUCT(type, fields)                                \
  static_assert(std::is_class<type>::value, "a point is a structure");

namespace pcl {

struct EIGEN_ALIGN16 PointXYZ {
  PCL_ADD_POINT4D
  PointXYZ() : data{0.0f, 0.0f, 0.0f, 1.0f} {}
  PointXYZ(float x_, float y_, float z_) : data{x_, y_, z_, 1.0f} {}
  PCL_MAKE_ALIGNED_OPERATOR_NEW
};

struct EIGEN_ALIGN16 PointXYZI {
  PCL_ADD_POINT4D
  float intensity = 0.0f;
  PointXYZI() : data{0.0f, 0.0f, 0.0f, 1.0f} {}
  PCL_MAKE_ALIGNED_OPERATOR_NEW
};

namespace fields {
struct x;
struct y;
struct z;
struct rgb;
struct rgba;
} // namespace fields

namespace traits {

template <typename PointT>
struct has_xyz : std::true_type {};

template <typename PointT, typename = void>
struct has_intensity : std::false_type {};
template <typename PointT>
struct has_intensity<PointT, std::void_t<decltype(PointT::intensity)>>
: std::true_type {};

template <typename PointT, typename = void>
struct has_color : std::false_type {};
template <typename PointT>
struct has_color<PointT, std::void_t<decltype(PointT::rgba)>> : std::true_type {};

template <typename PointT, typename FieldT>
struct has_field : has_color<PointT> {};

/** \brief Of x, y and z, which are the first of a point, and of rgb and rgba, which
 * follow the four floats of its coordinates. */
template <typename PointT, typename FieldT>
struct offset {
  static constexpr std::size_t value = std::is_same<FieldT, fields::x>::value   ? 0
                                       : std::is_same<FieldT, fields::y>::value ? 4
                                       : std::is_same<FieldT, fields::z>::value
                                           ? 8
                                           : 4 * sizeof(float);
};

} // namespace traits
} // namespace pcl
