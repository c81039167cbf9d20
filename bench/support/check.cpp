#include "bench/support/check.hpp"

#include <fmt/format.h>

#include "isopach/delaunay/validate.hpp"

namespace isopach::bench {

std::size_t edges(const Triangulation& t) { return (3 * std::size_t{t.real} + t.ghosts()) / 2; }

std::string verdict(const SortedTriangulation& s) {
  const auto fault = validate(s.triangulation, s.xy);
  return fault ? "WRONG: " + *fault : "right";
}

std::string verdict(const SortedTriangulation& s, std::size_t edges_of_rival) {
  const std::string own = verdict(s);
  if (own != "right" || edges(s.triangulation) == edges_of_rival) return own;
  return fmt::format("WRONG: {} edges, CGAL {}", edges(s.triangulation), edges_of_rival);
}

}  // namespace isopach::bench
