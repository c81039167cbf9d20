// Inside weight.cpp and weight_raster.cpp: the triangles that weights are integrated over.
#pragma once
#include <array>
#include <cmath>
#include <optional>

#include "isopach/measure/volume/weight.hpp"

namespace isopach::weighing {

/// A corner: frame coordinates, height of surface 1, d, and μ where it is linear.
struct Vertex {
  double x, y, z1, d, mu;
};
[[nodiscard]] inline Vertex between(const Vertex& p, const Vertex& q, double t) {
  const auto at = [t](double u, double v) { return u + t * (v - u); };
  return {at(p.x, q.x), at(p.y, q.y), at(p.z1, q.z1), at(p.d, q.d), at(p.mu, q.mu)};
}
[[nodiscard]] inline Vertex middle(const Vertex& p, const Vertex& q) {
  return {(p.x + q.x) / 2, (p.y + q.y) / 2, (p.z1 + q.z1) / 2, (p.d + q.d) / 2, (p.mu + q.mu) / 2};
}

/// A triangle on which everything but μ is linear. Its area is carried along: corners of small pieces have lost digits.
struct Part {
  double area;
  std::array<Vertex, 3> v;
  double slope1, slope2;
};

/// ∬ μ and ∬ |d| μ over a part where d has one sign, with their errors.
struct Amounts {
  double mu = 0, d = 0, mu_error = 0, d_error = 0;
};

/// The first value that is no weight.
struct Refusal {
  enum class Why { negative, not_finite, no_data } why;
  double x, y, value;
};

/// f(part) for the one to three pieces of a triangle on which d has one sign; they add up to it.
template <class F>
void for_each_sign(const Part& part, F&& f) {
  const auto sign = [](double d) { return (d > 0) - (d < 0); };
  const std::array<int, 3> s{sign(part.v[0].d), sign(part.v[1].d), sign(part.v[2].d)};
  std::size_t lone = 3;  // the corner whose sign no other has, the others not both being 0
  for (std::size_t k = 0; k < 3; ++k) {
    const int next = s[(k + 1) % 3], last = s[(k + 2) % 3];
    if (s[k] != 0 && next != s[k] && last != s[k] && (next == -s[k] || last == -s[k])) lone = k;
  }
  if (lone == 3) return f(part);
  const Vertex &p = part.v[lone], &q = part.v[(lone + 1) % 3], &r = part.v[(lone + 2) % 3];
  const double to_q = p.d / (p.d - q.d), to_r = p.d / (p.d - r.d);  // in (0, 1]; 1 where d = 0 at the corner
  Vertex pq = between(p, q, to_q), pr = between(p, r, to_r);
  pq.d = pr.d = 0;
  const auto piece = [&](double area, const Vertex& a, const Vertex& b, const Vertex& c) {
    if (area > 0) f(Part{area, {a, b, c}, part.slope1, part.slope2});
  };
  piece(part.area * to_q * to_r, p, pq, pr);
  piece(part.area * (1 - to_q), pq, q, r);
  piece(part.area * to_q * (1 - to_r), pq, r, pr);
}

/// Integrates a bilinear raster. Of one task.
class RasterParts {
 public:
  explicit RasterParts(const RasterWeight& weight);
  [[nodiscard]] Amounts operator()(const Part& part, std::optional<Refusal>& refused) const;

 private:
  /// A corner in columns and rows from `base`, and |d| there.
  struct Corner {
    double column, row, d;
  };
  struct Polygon {
    unsigned corners = 0;
    std::array<Corner, 8> at;
  };
  [[nodiscard]] static Polygon side_of(const Polygon& p, double Corner::*axis, double line, bool below);
  template <class F>
  static void for_strips(const Polygon& p, double Corner::*axis, double base, std::size_t count, F&& f);
  void add_patch(const Polygon& p, double known_area, const Part& part, Amounts& sum,
                 std::optional<Refusal>& refused) const;

  const RasterValues& values_;
  Point3 origin_;
  double det_;
};

}  // namespace isopach::weighing
