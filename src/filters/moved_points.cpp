#include "filters/point_mover.h"

#include <algorithm>
#include <cstring>
#include <limits>

namespace pcl_ext {
namespace detail {

namespace {

template <typename LanesT>
class PointMover {
public:
  PointMover(const PointMove& move, float* output, MovedPoints& moved)
  : output_(output), moved_(moved)
  {
    constexpr float largest = std::numeric_limits<float>::max();
    moved.count = 0;
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t column = 0; column < 4; ++column)
        matrix_[row][column] = LanesT::all(move.rows[row][column]);
      // Clamped, so that points within the box are also finite.
      min_[row] = LanesT::all(std::max(move.min[row], -largest));
      max_[row] = LanesT::all(std::min(move.max[row], largest));
    }
  }

  /** \brief Moves up to four points.
   * \tparam lanes how many; four are read in any case
   * \param[in] points four floats are read of each
   * \param[in] stride bytes from one point to the next
   * \param[in] source which point is the first
   */
  template <unsigned int lanes>
  void
  moveQuad(const unsigned char* points, std::size_t stride, std::uint32_t source)
  {
    static_assert(lanes == 1 || lanes == 4, "one point or all");
    constexpr unsigned int wanted = (1u << lanes) - 1;
    Floats point[3];
    loadPoints<LanesT>(points, stride, point[0], point[1], point[2]);
    Floats place[4];
    Floats zeros = LanesT::all(0.0f);
    Ints is_kept = LanesT::all(-1);
    for (std::size_t row = 0; row < 3; ++row) {
      // In the order of Eigen's product of matrix and vector.
      place[row] = LanesT::add(
          LanesT::add(LanesT::add(LanesT::multiply(matrix_[row][0], point[0]),
                                  LanesT::multiply(matrix_[row][1], point[1])),
                      LanesT::multiply(matrix_[row][2], point[2])),
          matrix_[row][3]);
      // NaN if any term is not finite.
      zeros = LanesT::add(zeros, LanesT::subtract(place[row], place[row]));
      is_kept = LanesT::bitAnd(is_kept, LanesT::lessOrEqual(min_[row], place[row]));
      is_kept = LanesT::bitAnd(is_kept, LanesT::lessOrEqual(place[row], max_[row]));
    }
    const Ints is_finite = LanesT::lessOrEqual(zeros, LanesT::all(0.0f));
    if constexpr (lanes == 4)
      finite_ = LanesT::subtract(finite_, is_finite); // -1 in lanes of finite points
    else
      finite_points_ += LanesT::bitsOf(is_finite) & 1;
    const unsigned int kept = LanesT::bitsOf(is_kept) & wanted;
    if (kept != 0)
      keep<lanes>(place, point[2], source, kept);
  }

  /** \brief Number of points that were finite after the move. */
  std::size_t
  countFinite() const
  {
    std::array<std::uint32_t, 4> counts;
    LanesT::store(finite_, counts.data());
    return finite_points_ + counts[0] + counts[1] + counts[2] + counts[3];
  }

private:
  // C arrays: as a template argument a vector type would lose its alignment.
  using Floats = typename LanesT::Floats;
  using Ints = typename LanesT::Ints;

  template <unsigned int lanes>
  void
  keep(Floats (&place)[4], const Floats& depth, std::uint32_t source, unsigned int kept)
  {
    place[3] = LanesT::all(1.0f);
    LanesT::transpose(place[0], place[1], place[2], place[3]);
    std::array<float, 4> depths;
    LanesT::store(depth, depths.data());
    // Without a branch, which would be mispredicted: written in any case, counted if kept.
    std::size_t count = moved_.count;
    for (std::uint32_t lane = 0; lane < lanes; ++lane) {
      LanesT::store(place[lane], output_ + count * moved_point_floats);
      moved_.depths[count] = depths[lane];
      moved_.sources[count] = source + lane;
      count += kept >> lane & 1;
    }
    moved_.count = count;
  }

  Floats matrix_[3][4];
  Floats min_[3];
  Floats max_[3];
  Ints finite_ = LanesT::all(0);  // number of finite points by lane
  std::size_t finite_points_ = 0; // of those moved one at a time
  float* output_;
  MovedPoints& moved_;
};

} // namespace

template <typename LanesT>
void
movePointsWith(const PointBytes& points,
               const PointMove& move,
               float* output,
               MovedPoints& moved)
{
  PointMover<LanesT> mover(move, output, moved);
  std::size_t i = 0;
  // Quads read a float after z, which the last point may not have.
  for (; i + 4 < points.count; i += 4)
    mover.template moveQuad<4>(
        points.first + i * points.stride, points.stride, static_cast<std::uint32_t>(i));
  for (; i < points.count; ++i) {
    std::array<float, 4> point{};
    std::memcpy(point.data(), points.first + i * points.stride, 3 * sizeof(float));
    mover.template moveQuad<1>(reinterpret_cast<const unsigned char*>(point.data()),
                               0,
                               static_cast<std::uint32_t>(i));
  }
  moved.not_finite = points.count - mover.countFinite();
}

template void
movePointsWith<ScalarLanes>(const PointBytes&, const PointMove&, float*, MovedPoints&);
#if defined(__SSE2__) || (defined(__aarch64__) && !defined(__AARCH64EB__))
template void
movePointsWith<NativeLanes>(const PointBytes&, const PointMove&, float*, MovedPoints&);
#endif

void
movePoints(const PointBytes& points,
           const PointMove& move,
           float* output,
           MovedPoints& moved)
{
  movePointsWith<NativeLanes>(points, move, output, moved);
}

} // namespace detail
} // namespace pcl_ext
