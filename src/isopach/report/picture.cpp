#include "isopach/report/picture.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/geom/curve.hpp"
#include "isopach/report/layers.hpp"
#include "isopach/report/page/words.hpp"

namespace isopach {
namespace {

/// What both scans may share, in the frame.
Box2 shared_box(const Comparison& c) {
  const Box3& all = c.frame.box;
  constexpr std::array<double, 9> upright{1, 0, 0, 0, 1, 0, 0, 0, 1};
  const Box3 &a = c.a.bounds, &b = c.b.bounds;
  if (c.frame.rotation == upright && !a.empty() && !b.empty()) {
    const Point3& o = c.frame.origin;
    const Box2 shared{{std::max(a.min.x, b.min.x) - o.x, std::max(a.min.y, b.min.y) - o.y},
                      {std::min(a.max.x, b.max.x) - o.x, std::min(a.max.y, b.max.y) - o.y}};
    if (!shared.empty() && shared.min.y <= shared.max.y) return shared;
  }
  return all.empty() ? Box2{{0, 0}, {1, 1}} : Box2{{all.min.x, all.min.y}, {all.max.x, all.max.y}};
}

Box2 shown_box(const Comparison& c, const MapOptions& look) {
  if (!look.extent) return shared_box(c);
  const Point3& o = c.frame.origin;
  const Box2 &e = *look.extent, shared = shared_box(c);
  const Box2 seen{{std::max(e.min.x - o.x, shared.min.x), std::max(e.min.y - o.y, shared.min.y)},
                  {std::min(e.max.x - o.x, shared.max.x), std::min(e.max.y - o.y, shared.max.y)}};
  return seen.min.x < seen.max.x && seen.min.y < seen.max.y ? seen : shared;
}

double side_of(const Box2& box, const Comparison& c, const MapOptions& look) {
  constexpr double squares_a_pixel = 0.6;  // across: as much of its width as the map itself has
  const double width = box.max.x - box.min.x, height = box.max.y - box.min.y;
  const double of_map = std::max(width, height) / (squares_a_pixel * look.width);
  const auto nodes = static_cast<double>(std::max<std::size_t>(1, c.a.nodes + c.b.nodes));
  const double of_nodes = std::sqrt((c.domain_area > 0 ? c.domain_area : width * height) / nodes);
  const double side = std::max(of_map, of_nodes);
  if (!(side > 0)) return 1;
  const double digit = std::pow(10.0, std::floor(std::log10(side)) - 1);
  return std::ceil(side / digit) * digit;
}

/// Squares are joined at their middles: those around a frame that was asked for reach to its sides.
Box2 with_rim(const Box2& box, double side, const MapOptions& look) {
  if (!look.extent) return box;
  return {{box.min.x - side, box.min.y - side}, {box.max.x + side, box.max.y + side}};
}

struct Square {
  Point2 at;
  double z, d;
};

std::vector<Square> squares_of(const RasterLayers& layers, const Point3& offset) {
  const Array<double>&d = layers.bands[0].values, &coverage = layers.bands[1].values, &z = layers.bands[2].values;
  double all = 0, of_half = 0;
  for (const double share : coverage) all += share, of_half += share >= 0.5 ? share : 0;
  const double least = of_half >= 0.8 * all ? 0.5 : 0;  // what is narrower than a square is drawn as wide as one
  std::vector<Square> squares;
  for (std::size_t i = 0; i < d.size(); ++i) {
    if (!(coverage[i] > 0 && coverage[i] >= least)) continue;
    const double column = static_cast<double>(i % layers.columns) + 0.5,
                 row = static_cast<double>(i / layers.columns) + 0.5;
    const auto& g = layers.geotransform;
    squares.push_back({{g[0] + column * g[1] - offset.x, g[3] + row * g[5] - offset.y}, z[i] - offset.z, d[i]});
  }
  return squares;
}

/// Of the rows of the frame's rotation: where its origin lies.
Point3 offset_of(const Frame& frame) {
  const auto& r = frame.rotation;
  const Point3& o = frame.origin;
  const auto along = [&](std::size_t k) { return r[3 * k] * o.x + r[3 * k + 1] * o.y + r[3 * k + 2] * o.z; };
  return {along(0), along(1), along(2)};
}

Cells cells_of(const std::vector<Square>& squares, double side, const Frame& frame, const Context& context) {
  std::vector<Point2> places(squares.size());
  for (std::size_t i = 0; i < squares.size(); ++i) places[i] = squares[i].at;
  Cells cells;
  for (const Index i : curve_order(places, frame.curve)) {
    const Square& s = squares[i];
    cells.xy.push_back(s.at), cells.z1.push_back(s.z), cells.z2.push_back(s.z + s.d);
  }
  cells.triangulation = triangulate(cells.xy, frame.curve, context);
  cells.in_domain.resize(cells.triangulation.real);
  cells.scanned.assign(cells.triangulation.real,
                       0);  // between squares nothing is known of the scans, and none is hatched
  for_each_index(cells.in_domain.size(), [&](std::size_t i) {
    const auto& v = cells.triangulation.triangles[i].v;
    bool is_near = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const Point2 &p = cells.xy[v[k]], &q = cells.xy[v[(k + 1) % 3]];
      is_near = is_near && std::max(std::fabs(p.x - q.x), std::fabs(p.y - q.y)) < 1.5 * side;
    }
    cells.in_domain[i] = is_near ? 1 : 0;
  });
  return cells;
}

}  // namespace

Picture picture_of(const PartedCells& parted, const Comparison& c, const MapOptions& look, const Context& context) {
  const Box2 box = shown_box(c, look);
  Picture picture;
  picture.side = side_of(box, c, look);
  const RasterLayers layers = difference_layers(parted, c, picture.side, with_rim(box, picture.side, look), context);
  picture.cells = cells_of(squares_of(layers, offset_of(c.frame)), picture.side, c.frame, context);
  if (c.uncertainty.lod) picture.cells.lod.assign(picture.cells.xy.size(), *c.uncertainty.lod);
  return picture;
}

std::string drawn_by(const Picture& picture, const Comparison& c) {
  return "drawn by means over squares of " + number(picture.side, Typography::fine, 2) + "\u00a0" + measured_unit(c, 1);
}

}  // namespace isopach
