#include "isopach/simulate/sampling.hpp"

#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/base/random.hpp"

namespace isopach {
namespace {

enum Purpose : std::uint64_t { along_jitter, across_jitter, irregular_x, irregular_y, border, purposes };

RandomStream stream(const Draw& draw, Purpose purpose) { return {draw.seed, 1000 + draw.scan * purposes + purpose}; }

/// Twice the signed area of the triangle abc; positive: c lies to the left of ab.
double turn(const Point2& a, const Point2& b, const Point2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

Box2 bounds(const Outline& polygon) {
  Box2 box;
  for (const Point2& p : polygon) box.add(p);
  return box;
}

/// The part of a convex polygon where side·(y − level) >= 0.
Outline cut(const Outline& polygon, double level, double side) {
  Outline kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point2 p = polygon[i], q = polygon[(i + 1) % polygon.size()];
    const double dp = side * (p.y - level), dq = side * (q.y - level);
    if (dp >= 0) kept.push_back(p);
    if ((dp < 0) != (dq < 0)) kept.push_back({p.x + (q.x - p.x) * dp / (dp - dq), level});
  }
  return kept;
}

/// Turns the plane so that the heading becomes the x axis (direction = 1), or back (−1).
struct Turn {
  double c, s;
  [[nodiscard]] Point2 operator()(const Point2& p) const { return {c * p.x + s * p.y, c * p.y - s * p.x}; }
  [[nodiscard]] Point2 back(const Point2& p) const { return {c * p.x - s * p.y, s * p.x + c * p.y}; }
};

/// One strip after another, each a number of lines, each a number of pulses; in the turned frame.
struct Flight {
  Box2 box;
  double width, shift;     // of a strip; from strip to strip
  double step, line_step;  // from pulse to pulse; from line to line
  std::size_t strips, lines, pulses;

  [[nodiscard]] Point2 position(std::size_t i, const ScanPattern& pattern, double along, double across) const {
    const std::size_t pulse = i % pulses, line = i / pulses % lines, strip = i / pulses / lines;
    const double t = (static_cast<double>(pulse) + 0.5) / static_cast<double>(pulses);  // the mirror turns while flying
    const bool backward = pattern.zigzag && line % 2 == 1;
    const double x = box.min.x + (static_cast<double>(line) + t - 1) * line_step;
    const double y = box.min.y + static_cast<double>(strip) * shift + (backward ? 1 - t : t) * width;
    return {x + pattern.jitter * line_step * along, y + pattern.jitter * step * across};
  }
};

Flight plan_flight(const Outline& turned, std::size_t count, const ScanPattern& pattern) {
  Flight flight{};
  flight.box = bounds(turned);
  flight.strips = static_cast<std::size_t>(pattern.strips);
  flight.width = (flight.box.max.y - flight.box.min.y) / (pattern.strips - (pattern.strips - 1) * pattern.overlap);
  flight.shift = flight.width * (1 - pattern.overlap);
  double scanned = 0;  // where strips overlap, twice
  for (int k = 0; k < pattern.strips; ++k) {
    const double low = flight.box.min.y + k * flight.shift;
    scanned += polygon_area(cut(cut(turned, low, 1), low + flight.width, -1));
  }
  const double cell = scanned / static_cast<double>(count);
  flight.pulses = static_cast<std::size_t>(std::max(1.0, std::round(flight.width / std::sqrt(cell / pattern.stretch))));
  flight.step = flight.width / static_cast<double>(flight.pulses);
  flight.line_step = cell / flight.step;
  flight.lines = static_cast<std::size_t>(std::ceil((flight.box.max.x - flight.box.min.x) / flight.line_step)) + 2;
  return flight;
}

}  // namespace

Outline rectangle(const Point2& min, const Point2& max) { return {min, {max.x, min.y}, max, {min.x, max.y}}; }

bool contains(const Outline& polygon, const Point2& p) {
  for (std::size_t i = 0; i < polygon.size(); ++i)
    if (turn(polygon[i], polygon[(i + 1) % polygon.size()], p) < 0) return false;
  return true;
}

Array<Point2> scan_nodes(const Outline& footprint, std::size_t count, const ScanPattern& pattern, const Draw& draw) {
  const Turn turned{std::cos(pattern.heading), std::sin(pattern.heading)};
  Outline polygon;
  for (const Point2& p : footprint) polygon.push_back(turned(p));
  const Flight flight = plan_flight(polygon, count, pattern);
  const RandomStream along = stream(draw, along_jitter), across = stream(draw, across_jitter);
  return gather_blocks<Array<Point2>>(
      flight.strips * flight.lines * flight.pulses, default_block, [&](std::size_t begin, std::size_t end) {
        Array<Point2> kept;
        kept.reserve(end - begin);
        for (std::size_t i = begin; i < end; ++i) {
          const Point2 p =
              turned.back(flight.position(i, pattern, 2 * along.uniform(i) - 1, 2 * across.uniform(i) - 1));
          if (contains(footprint, p)) kept.push_back(p);
        }
        return kept;
      });
}

Array<Point2> irregular_nodes(const Outline& footprint, std::size_t count, const Draw& draw) {
  const Box2 box = bounds(footprint);
  const RandomStream rx = stream(draw, irregular_x), ry = stream(draw, irregular_y);
  Array<Point2> nodes(count);
  for_each_index(count, [&](std::size_t i) {
    for (std::size_t counter = i;; counter += count) {  // every try of every node has a counter of its own
      nodes[i] = {box.min.x + rx.uniform(counter) * (box.max.x - box.min.x),
                  box.min.y + ry.uniform(counter) * (box.max.y - box.min.y)};
      if (contains(footprint, nodes[i])) break;
    }
  });
  return nodes;
}

Array<Point2> border_nodes(const Outline& footprint, double spacing, const Draw& draw) {
  const RandomStream random = stream(draw, border);
  Array<Point2> nodes(footprint.begin(), footprint.end());
  for (std::size_t i = 0; i < footprint.size(); ++i) {
    const Point2 p = footprint[i], q = footprint[(i + 1) % footprint.size()];
    const auto inner = static_cast<std::size_t>(std::hypot(q.x - p.x, q.y - p.y) / spacing);
    for (std::size_t j = 0; j < inner; ++j) {
      const double place =
          (static_cast<double>(j) + 0.25 + 0.5 * random.uniform(nodes.size())) / static_cast<double>(inner);
      const double t = std::round(place * 0x1p20) * 0x1p-20;  // few digits: p + t (q − p) is exact, so on the side
      nodes.push_back({p.x + t * (q.x - p.x), p.y + t * (q.y - p.y)});
    }
  }
  return nodes;
}

Array<Point2> bordered_nodes(const Outline& footprint, std::size_t count, const Draw& draw) {
  const double spacing = std::sqrt(polygon_area(footprint) / static_cast<double>(count));
  Array<Point2> nodes = border_nodes(footprint, spacing, draw);
  if (nodes.size() > count) nodes.resize(std::max(count, footprint.size()));
  const Array<Point2> inside = irregular_nodes(footprint, count - std::min(count, nodes.size()), draw);
  nodes.insert(nodes.end(), inside.begin(), inside.end());
  return nodes;
}

}  // namespace isopach
