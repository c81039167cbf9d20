#include "isopach/report/view/space.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <tuple>

#include "isopach/distance/point_tree.hpp"
#include "isopach/match/verdict/shape_detail.hpp"
#include "isopach/report/draw/palette.hpp"
#include "isopach/report/page/values.hpp"
#include "isopach/report/page/words.hpp"
#include "isopach/report/view/block.hpp"
#include "isopach/report/view/view.hpp"

namespace isopach {
namespace {

using Json = nlohmann::ordered_json;
using values::real;

Box3 box_of(const SpaceScene& s) {
  Box3 box;
  for (const Point3& p : s.points)
    if (is_finite(p)) box.add(p);
  return box;
}

/// Bits of three numbers by turns: neighbours in space are mostly neighbours in this order.
std::uint64_t interleaved(std::uint64_t x, std::uint64_t y, std::uint64_t z) {
  std::uint64_t out = 0;
  for (unsigned bit = 0; bit < 21; ++bit)
    out |= ((x >> bit & 1) << (3 * bit)) | ((y >> bit & 1) << (3 * bit + 1)) | ((z >> bit & 1) << (3 * bit + 2));
  return out;
}

struct Placed {
  std::uint64_t cube;
  double off;  ///< squared, from the middle of the cube
  Index point;
};

/// By cubes; within one by the distance from its middle, then by coordinates: the file's order has no say.
std::vector<Placed> placed(const SpaceScene& s, const Box3& box, double side) {
  std::vector<Placed> all;
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    const Point3& p = s.points[i];
    if (!is_finite(p)) continue;
    const std::array<double, 3> at{(p.x - box.min.x) / side, (p.y - box.min.y) / side, (p.z - box.min.z) / side};
    double off = 0;
    for (const double v : at) off += (v - std::floor(v) - 0.5) * (v - std::floor(v) - 0.5);
    const auto cell = [](double v) { return static_cast<std::uint64_t>(std::clamp(std::floor(v), 0.0, 2097151.0)); };
    all.push_back({interleaved(cell(at[0]), cell(at[1]), cell(at[2])), off, static_cast<Index>(i)});
  }
  std::sort(all.begin(), all.end(), [&](const Placed& a, const Placed& b) {
    const Point3 &p = s.points[a.point], &q = s.points[b.point];
    return std::tie(a.cube, a.off, p.x, p.y, p.z) < std::tie(b.cube, b.off, q.x, q.y, q.z);
  });
  return all;
}

std::vector<Index> first_of_cubes(const std::vector<Placed>& all) {
  std::vector<Index> out;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (i == 0 || all[i].cube != all[i - 1].cube) out.push_back(all[i].point);
  return out;
}

/// Of cubes eight times as wide: the points of the largest |value|, so that no peak is thinned away.
void add_peaks(const SpaceScene& s, const std::vector<Placed>& all, std::vector<Index>& chosen) {
  constexpr unsigned wider = 9;  // three bits an axis
  std::vector<Index> peaks;
  for (std::size_t i = 0; i < all.size();) {
    const std::uint64_t cube = all[i].cube >> wider;
    Index best = no_index;
    for (; i < all.size() && all[i].cube >> wider == cube; ++i) {
      const double v = std::fabs(s.values[all[i].point]);
      if (v > 0 && (best == no_index || v > std::fabs(s.values[best]))) best = all[i].point;
    }
    if (best != no_index) peaks.push_back(best);
  }
  std::vector<bool> is_in(s.points.size());
  for (const Index i : chosen) is_in[i] = true;
  for (const Index i : peaks) is_in[i] = true;
  chosen.clear();
  for (const Placed& p : all)
    if (is_in[p.point]) chosen.push_back(p.point);
}

/// Normals by the planes of neighbours, and how far apart points are: to the sixth beside each, in the median.
void add_normals(const SpaceScene& s, SpaceSample& sample, const Context& context) {
  constexpr std::size_t neighbours = 12, beside = 6, block = 4096;
  std::vector<Point3> places;
  for (const Index i : sample.chosen) places.push_back(s.points[i]);
  const PointTree tree(places);
  const auto& m = s.upright.m;
  std::vector<Index> found;
  std::vector<double> gaps;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (i % block == 0) context.check();
    tree.nearest(places[i], neighbours, found);
    Point3 n = found.size() < 3 ? Point3{m[8], m[9], m[10]} : plane_of(places, found).normal;
    if (m[8] * n.x + m[9] * n.y + m[10] * n.z < 0) n = {-n.x, -n.y, -n.z};
    sample.normals.push_back(n);
    if (found.empty()) continue;
    const Point3& q = places[found[std::min(beside, found.size() - 1)]];
    gaps.push_back(std::hypot(q.x - places[i].x, q.y - places[i].y, q.z - places[i].z));
  }
  if (gaps.empty()) return;
  const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
  std::nth_element(gaps.begin(), middle, gaps.end());
  sample.spacing = *middle;
}

Quantised quantised(const std::vector<double>& column, double step_of_range) {
  Quantised q;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double v : column) low = std::min(low, v), high = std::max(high, v);
  if (column.empty()) return q;
  q.low = low, q.step = (high - low) / step_of_range;
  for (const double v : column)
    q.numbers.push_back(q.step > 0 ? static_cast<std::uint32_t>(std::lround((v - low) / q.step)) : 0);
  return q;
}

/// Numbers from 1 on; 0 stands for a missing value.
Quantised with_missing(const std::vector<double>& column) {
  constexpr double steps = 65000;
  Quantised q;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double v : column)
    if (!std::isnan(v)) low = std::min(low, v), high = std::max(high, v);
  q.step = high > low ? (high - low) / steps : 1;
  q.low = (high >= low ? low : 0) - q.step;
  for (const double v : column)
    q.numbers.push_back(std::isnan(v) ? 0 : static_cast<std::uint32_t>(std::lround((v - q.low) / q.step)));
  return q;
}

/// Half a sphere of directions, z ≥ 0, as one number: two coordinates of 64 steps of the octahedron unfolded.
std::uint32_t direction_number(const Point3& n) {
  const double sum = std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z);
  const double u = (n.x + n.y) / (sum > 0 ? sum : 1), v = (n.x - n.y) / (sum > 0 ? sum : 1);
  const auto step = [](double t) { return static_cast<std::uint32_t>(std::lround(31.5 * (t + 1))); };
  return step(u) * 64 + step(v);
}

Point3 turned_by(const Pose& pose, const Point3& n) {
  const auto& m = pose.m;
  return {m[0] * n.x + m[1] * n.y + m[2] * n.z, m[4] * n.x + m[5] * n.y + m[6] * n.z,
          m[8] * n.x + m[9] * n.y + m[10] * n.z};
}

struct Column {
  std::string name;
  Quantised q;
};

std::vector<Column> columns_of(const SpaceScene& s, const SpaceSample& sample) {
  constexpr double place_steps = 1'048'575, blend_steps = 250;
  const auto of = [&](auto&& value) {
    std::vector<double> out;
    out.reserve(sample.chosen.size());
    for (const Index i : sample.chosen) out.push_back(value(i));
    return out;
  };
  std::vector<Column> all;
  all.push_back({"x", quantised(of([&](Index i) { return s.points[i].x; }), place_steps)});
  all.push_back({"y", quantised(of([&](Index i) { return s.points[i].y; }), place_steps)});
  all.push_back({"z", quantised(of([&](Index i) { return s.points[i].z; }), place_steps)});
  Quantised normals{0, 1, {}};
  for (const Point3& n : sample.normals) normals.numbers.push_back(direction_number(turned_by(s.upright, n)));
  all.push_back({"normal", std::move(normals)});
  if (!s.values.empty()) all.push_back({"value", with_missing(of([&](Index i) { return s.values[i]; }))});
  if (!s.levels.empty()) all.push_back({"level", with_missing(of([&](Index i) { return s.levels[i]; }))});
  if (!s.part_of.empty()) {
    Quantised parts{0, 1, {}};
    for (const Index i : sample.chosen) parts.numbers.push_back(s.part_of[i]);
    all.push_back({"part", std::move(parts)});
  }
  if (!s.blend.empty()) all.push_back({"blend", quantised(of([&](Index i) { return s.blend[i]; }), blend_steps)});
  return all;
}

/// Corners as places in `chosen`.
std::vector<std::array<Index, 3>> faces_of(const SpaceScene& s, const SpaceSample& sample) {
  std::vector<std::array<Index, 3>> out;
  if (!sample.is_whole) return out;
  std::vector<Index> place(s.points.size(), no_index);
  for (std::size_t i = 0; i < sample.chosen.size(); ++i) place[sample.chosen[i]] = static_cast<Index>(i);
  for (const auto& f : s.faces) {
    const std::array<Index, 3> corners{place[f[0]], place[f[1]], place[f[2]]};
    if (std::find(corners.begin(), corners.end(), no_index) == corners.end()) out.push_back(corners);
  }
  return out;
}

Json head_json(const SpaceScene& s, const SpaceSample& sample) {
  Json out{{"version", 1},
           {"kind", "space"},
           {"title", clean_utf8(s.title)},
           {"unit", s.unit},
           {"of", s.points.size()},
           {"nodes", sample.chosen.size()},
           {"whole", sample.is_whole},
           {"spacing", real(sample.spacing)},
           {"upright", Json::array()},
           {"azimuth", s.azimuth},
           {"elevation", s.elevation},
           {"second", s.second},
           {"value", s.value_name},
           {"signed", s.has_sign},
           {"limit", real(s.limit)},
           {"flip", s.flip}};
  for (const std::size_t i : {0, 1, 2, 4, 5, 6, 8, 9, 10}) out["upright"].push_back(real(s.upright.m[i]));
  std::vector<std::size_t> counts(s.parts.size());
  if (!s.part_of.empty())
    for (const unsigned char p : s.part_of) ++counts.at(p);
  else
    counts.at(0) = s.points.size();
  out["parts"] = Json::array();
  for (std::size_t k = 0; k < s.parts.size(); ++k)
    out["parts"].push_back(
        {{"name", clean_utf8(s.parts[k].name)}, {"colour", s.parts[k].colour}, {"count", counts[k]}});
  out["frames"] = Json::array();
  for (const SpaceFrame& f : s.frames) {
    Json matrix = Json::array();
    for (std::size_t i = 0; i < 12; ++i) matrix.push_back(real(f.motion.m[i]));
    out["frames"].push_back({{"label", clean_utf8(f.label)}, {"matrix", matrix}});
  }
  return out;
}

Rgb rgb_of(const std::string& css) {
  const auto part = [&](std::size_t at) { return std::stoi(css.substr(at, 2), nullptr, 16) / 255.0; };
  return {part(1), part(3), part(5)};
}

/// The colours of the view, see viewer/src/space.ts: grey within the level of detection and where nothing is known.
Rgb colour_at(const SpaceScene& s, Index i, const Palette& palette) {
  constexpr Rgb even{0.77, 0.77, 0.77}, none{0.58, 0.56, 0.54};
  if (s.values.empty()) return rgb_of(s.parts[s.part_of.empty() ? 0 : s.part_of[i]].colour);
  const double v = s.values[i];
  if (std::isnan(v)) return none;
  if (!s.levels.empty() && !(std::fabs(v) > s.levels[i])) return even;
  return palette(s.limit > 0 ? v / s.limit : 0);
}

/// A picture with depth: what is nearest to the viewer stays.
class Splatter {
 public:
  Splatter(int width, int height) {
    image_.width = width, image_.height = height;
    image_.rgb.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3, 255);
    depth_.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
                  -std::numeric_limits<double>::infinity());
  }
  void disc(double x, double y, double z, double radius, const Rgb& c) {
    const int x0 = std::max(0, static_cast<int>(std::ceil(x - radius - 0.5)));
    const int x1 = std::min(image_.width - 1, static_cast<int>(std::floor(x + radius - 0.5)));
    const int y0 = std::max(0, static_cast<int>(std::ceil(y - radius - 0.5)));
    const int y1 = std::min(image_.height - 1, static_cast<int>(std::floor(y + radius - 0.5)));
    for (int r = y0; r <= y1; ++r)
      for (int k = x0; k <= x1; ++k) {
        const double dx = k + 0.5 - x, dy = r + 0.5 - y;
        if (dx * dx + dy * dy > radius * radius) continue;
        const std::size_t at =
            static_cast<std::size_t>(r) * static_cast<std::size_t>(image_.width) + static_cast<std::size_t>(k);
        if (!(z > depth_[at])) continue;
        depth_[at] = z;
        std::size_t to = 3 * at;
        for (const double v : {c.r, c.g, c.b})
          image_.rgb[to++] = static_cast<unsigned char>(std::lround(255 * std::clamp(v, 0.0, 1.0)));
      }
  }
  [[nodiscard]] Image take() { return std::move(image_); }

 private:
  Image image_;
  std::vector<double> depth_;
};

/// From the axes of the view to those of the first look.
Pose first_look(const SpaceScene& s) {
  constexpr double degree = std::numbers::pi / 180;
  const double a = s.azimuth * degree, e = s.elevation * degree;
  const double ca = std::cos(a), sa = std::sin(a), ce = std::cos(e), se = std::sin(e);
  Pose out;
  out.m = {ca, 0, -sa, 0, -se * sa, ce, -se * ca, 0, ce * sa, se, ce * ca, 0, 0, 0, 0, 1};
  return out;
}

}  // namespace

SpaceSample sample_space(const SpaceScene& s, std::size_t most, const Context& context) {
  SpaceSample out;
  const Box3 box = box_of(s);
  if (box.empty()) return out;
  const double extent = std::max({box.max.x - box.min.x, box.max.y - box.min.y, box.max.z - box.min.z, 1e-300});
  constexpr double finest = 2'000'000;  // cubes along the extent
  out.is_whole = s.points.size() <= most;
  double side = out.is_whole ? extent / finest : extent / std::sqrt(static_cast<double>(most));
  std::vector<Placed> all = placed(s, box, side);
  if (out.is_whole) {
    for (const Placed& p : all) out.chosen.push_back(p.point);
  } else {
    out.chosen = first_of_cubes(all);
    for (int tries = 0; tries < 6; ++tries) {
      const double filled = static_cast<double>(out.chosen.size()) / static_cast<double>(most);
      if (filled <= 1 && (filled > 0.7 || tries > 3)) break;
      side *= filled > 1 ? 1.03 * std::sqrt(filled) : std::max(0.3, 1.05 * std::sqrt(filled));
      all = placed(s, box, side);
      out.chosen = first_of_cubes(all);
      context.check();
    }
    if (!s.values.empty()) add_peaks(s, all, out.chosen);
  }
  add_normals(s, out, context);
  return out;
}

double space_limit(std::span<const double> values) {
  std::vector<double> sizes;
  for (const double v : values)
    if (std::isfinite(v)) sizes.push_back(std::fabs(v));
  if (sizes.empty()) return 0;
  const std::size_t at = std::min(sizes.size() - 1, sizes.size() * 95 / 100);
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(at), sizes.end());
  if (!(sizes[at] > 0)) return *std::max_element(sizes.begin(), sizes.end());
  const double unit = std::pow(10, std::floor(std::log10(sizes[at])) - 1);
  return std::ceil(sizes[at] / unit) * unit;
}

Image space_picture(const SpaceScene& s, const SpaceSample& sample, int width, int height) {
  const Palette palette("blue-red", s.flip);
  const Pose look = first_look(s);
  std::vector<Point3> seen;
  Box3 box;
  for (const Index i : sample.chosen) {
    seen.push_back(turned_by(look, turned_by(s.upright, s.points[i])));
    box.add(seen.back());
  }
  Splatter out(width, height);
  if (box.empty()) return out.take();
  const double scale = 0.94 * std::min(width / std::max(box.max.x - box.min.x, 1e-300),
                                       height / std::max(box.max.y - box.min.y, 1e-300));
  const double radius = std::clamp(sample.spacing * scale, 1.2, 40.0);
  for (std::size_t k = 0; k < seen.size(); ++k) {
    const Point3 n = turned_by(look, turned_by(s.upright, sample.normals[k]));
    const double sign = n.z < 0 ? -1 : 1, light = sign * (-0.45 * n.x + 0.55 * n.y + 0.70 * n.z);
    const double shade = std::min(1.0, 0.5 + 0.55 * std::max(0.0, light));
    Rgb c = colour_at(s, sample.chosen[k], palette);
    c = {c.r * shade, c.g * shade, c.b * shade};
    out.disc(width / 2.0 + (seen[k].x - (box.min.x + box.max.x) / 2) * scale,
             height / 2.0 - (seen[k].y - (box.min.y + box.max.y) / 2) * scale, seen[k].z, radius, c);
  }
  return out.take();
}

std::string space_view(const SpaceScene& s, const SpaceSample& sample) {
  if (sample.chosen.empty()) return "";
  const std::vector<Column> columns = columns_of(s, sample);
  const std::vector<std::array<Index, 3>> faces = faces_of(s, sample);
  Json data = head_json(s, sample);
  data["columns"] = Json::array();
  std::vector<const Quantised*> numbers;
  for (const Column& c : columns) {
    data["columns"].push_back({{"name", c.name}, {"low", real(c.q.low)}, {"step", real(c.q.step)}});
    numbers.push_back(&c.q);
  }
  data["triangles"] = faces.size();
  data["data"] = numbers_block(numbers, faces);
  return view_element(data.dump()) + view_script_element();
}

}  // namespace isopach
