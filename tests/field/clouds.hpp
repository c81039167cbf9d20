// Clouds for the tests of field/.
#pragma once
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <utility>
#include <vector>

#include "isopach/field/height_field.hpp"

namespace isopach::test {

/// Uniform and normal numbers whose bits do not depend on the standard library.
class FieldRandom {
 public:
  explicit FieldRandom(std::uint64_t seed) : engine_(seed) {}
  double uniform() { return std::ldexp(static_cast<double>(engine_() >> 11), -53); }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  double normal() { return std::sqrt(-2 * std::log(1 - uniform())) * std::cos(2 * std::acos(-1.0) * uniform()); }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(engine_() % n); }
  template <class T>
  void shuffle(T& items) {
    for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[below(i)]);
  }

 private:
  std::mt19937_64 engine_;
};

inline Cloud make_cloud(const std::vector<Point3>& points) {
  Cloud cloud;
  cloud.path = "made.xyz";
  cloud.points.assign(points.begin(), points.end());
  return cloud;
}

/// n points over [0, side]² moved by `shift`, with heights from a smooth function.
inline Cloud smooth_cloud(std::size_t n, std::uint64_t seed, double side = 10, Point3 shift = {0, 0, 0}) {
  FieldRandom random(seed);
  Cloud cloud = make_cloud({});
  for (std::size_t i = 0; i < n; ++i) {
    const double x = random.uniform(0, side), y = random.uniform(0, side);
    cloud.points.push_back({x + shift.x, y + shift.y, std::sin(x) + 0.2 * y + shift.z});
  }
  return cloud;
}

template <class T>
bool same_bits(const T& a, const T& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0);
}

inline bool same_frame(const Frame& a, const Frame& b) {
  return a.origin == b.origin && same_bits(a.rotation, b.rotation) && a.axis_aligned == b.axis_aligned &&
         a.curve.min == b.curve.min && a.curve.scale == b.curve.scale;
}

}  // namespace isopach::test
