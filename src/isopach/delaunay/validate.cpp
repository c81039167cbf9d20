#include "isopach/delaunay/validate.hpp"

#include "isopach/geom/predicates.hpp"

namespace isopach {

namespace {

std::string at(const char* what, Index t) { return std::string(what) + " at triangle " + std::to_string(t); }

std::optional<std::string> check_links(const Triangulation& t) {
  for (Index i = 0; i < t.triangles.size(); ++i)
    for (Index k = 0; k < 3; ++k) {
      const HalfEdge h = t.triangles[i].n[k];
      if (triangle_of(h) >= t.triangles.size() || side_of(h) > 2) return at("no such twin", i);
      if (t.twin(h) != half_edge(i, k)) return at("twin does not point back", i);
      if (t.origin(h) != t.target(half_edge(i, k)) || t.target(h) != t.origin(half_edge(i, k)))
        return at("twin has other ends", i);
    }
  return std::nullopt;
}

std::optional<std::string> check_corners(const Triangulation& t, std::span<const Point2> xy) {
  std::vector<bool> used(xy.size(), false);
  for (Index i = 0; i < t.triangles.size(); ++i) {
    const auto& v = t.triangles[i].v;
    for (Index k = 0; k < (t.is_ghost(i) ? 2U : 3U); ++k) {
      if (v[k] >= xy.size()) return at("no such node", i);
      used[v[k]] = true;
    }
    if (t.is_ghost(i) != (v[2] == no_index)) return at("ghost out of place", i);
    if (!t.is_ghost(i) && orientation(xy[v[0]], xy[v[1]], xy[v[2]]) <= 0) return at("not counter-clockwise", i);
  }
  for (std::size_t i = 0; i < used.size(); ++i)
    if (!used[i]) return "node " + std::to_string(i) + " is in no triangle";
  return std::nullopt;
}

std::optional<std::string> check_circles(const Triangulation& t, std::span<const Point2> xy) {
  for (Index i = 0; i < t.real; ++i) {
    const auto& v = t.triangles[i].v;
    for (Index k = 0; k < 3; ++k) {
      const HalfEdge h = t.triangles[i].n[k];
      if (t.is_ghost(triangle_of(h))) continue;
      const Index d = t.triangles[triangle_of(h)].v[previous_side(side_of(h))];
      if (inside_circle(xy[v[0]], xy[v[1]], xy[v[2]], xy[d])) return at("edge is not Delaunay", i);
    }
  }
  return std::nullopt;
}

// Turning left everywhere is not enough: a ring may wind twice, or run to and fro on a line. Once round has one least
// node.
std::optional<std::string> check_hull(const Triangulation& t, std::span<const Point2> xy) {
  Index ring = 0, least = 0;
  Index g = t.real;
  do {
    const Index following = triangle_of(t.triangles[g].n[2]);
    if (!t.is_ghost(following)) return at("ghost ring leads into the mesh", g);
    const Index a = t.triangles[g].v[1], b = t.triangles[g].v[0], c = t.triangles[following].v[0];
    if (t.triangles[following].v[1] != b) return at("ghost ring is broken", g);
    const int turn = orientation(xy[a], xy[b], xy[c]);
    if (t.real == 0 ? turn != 0 : turn < 0) return at("hull is not convex", g);
    if (lexicographic_less(xy[b], xy[a]) && lexicographic_less(xy[b], xy[c])) ++least;
    g = following;
    ++ring;
  } while (g != t.real && ring <= t.ghosts());
  if (ring != t.ghosts()) return "the hull is not one ring";
  if (least != 1) return "the hull goes round more than once, or to and fro";
  return std::nullopt;
}

}  // namespace

std::optional<std::string> validate(const Triangulation& t, std::span<const Point2> xy) {
  if (t.nodes != xy.size()) return std::string("made for another number of nodes");
  if (xy.size() < 2) {
    if (!t.triangles.empty()) return std::string("triangles without nodes");
    return std::nullopt;
  }
  if (t.triangles.size() != 2 * xy.size() - 2) return std::string("not 2n - 2 triangles");
  if (t.ghosts() < 2) return std::string("no hull");
  if (auto bad = check_links(t)) return bad;
  if (auto bad = check_corners(t, xy)) return bad;
  if (auto bad = check_hull(t, xy)) return bad;
  return check_circles(t, xy);
}

}  // namespace isopach
