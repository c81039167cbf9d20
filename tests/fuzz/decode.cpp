#include "tests/fuzz/decode.hpp"

#include <algorithm>

#include "isopach/base/random.hpp"
#include "isopach/io/polygons.hpp"

namespace isopach::fuzz {
namespace {

void add_grid(Input& in, Cloud& cloud) {
  const std::size_t columns = 2 + in.below(14), rows = 2 + in.below(14);
  const bool flat = in.flag();
  for (std::size_t row = 0; row < rows; ++row)
    for (std::size_t column = 0; column < columns; ++column)
      cloud.points.push_back(
          {static_cast<double>(column), static_cast<double>(row), flat ? 0 : in.signed_byte() / 16.0});
  if (!in.flag()) return;
  for (std::size_t row = 0; row + 1 < rows; ++row)
    for (std::size_t column = 0; column + 1 < columns; ++column) {
      const auto at = static_cast<Index>(row * columns + column), above = static_cast<Index>(at + columns);
      cloud.faces.push_back({at, at + 1, above});
      cloud.faces.push_back({at + 1, above + 1, above});
    }
}

void add_scattered(Input& in, Cloud& cloud) {
  for (std::size_t n = in.below(128); n > 0; --n) {
    const double x = in.signed_byte(), y = in.signed_byte();
    cloud.points.push_back({x, y, in.signed_byte() / 8.0});
  }
}

void add_line(Input& in, Cloud& cloud) {
  const double dx = in.signed_byte(), dy = in.signed_byte();
  for (std::size_t n = in.below(64); n > 0; --n) {
    const double t = in.signed_byte();
    cloud.points.push_back({t * dx, t * dy, static_cast<double>(in.signed_byte())});
  }
}

void add_numbers(Input& in, Cloud& cloud) {
  for (std::size_t n = in.below(48); n > 0; --n) {
    const double x = in.number(), y = in.number();
    cloud.points.push_back({x, y, in.number()});
  }
}

/// Hills over the square from 0 to 16, sampled at random places: the same surface for the same three bytes.
void add_hills(Input& in, Cloud& cloud) {
  const double slope = in.signed_byte() / 64.0, height = in.signed_byte() / 32.0, width = 1 + in.byte() / 32.0;
  const double noise = in.byte() / 256.0;
  const RandomStream random(in.byte(), 0);
  const std::size_t n = 32 + in.byte();
  for (std::uint64_t i = 0; i < n; ++i) {
    const auto draw = [&](std::uint64_t which) { return random.uniform(4 * i + which); };
    const double x = 16 * draw(0), y = 16 * draw(1);
    cloud.points.push_back({x, y, slope * x + height * std::sin(x / width) * std::cos(y / width) + noise * draw(2)});
  }
}

void scale(Input& in, Cloud& cloud) {
  constexpr double factors[] = {1, 1, 1, 1e-3, 1e3, 0x1p-40, 1e-150, 1e-308, 1e29, 1e59, 1e150, 0x1p1000};
  constexpr double offsets[] = {0, 0, 0, 0.1, 1e6, -5e8, 1e15, 1e59};
  const double factor = factors[in.below(std::size(factors))], dx = offsets[in.below(std::size(offsets))];
  const double steepness = factors[in.below(std::size(factors))];
  for (Point3& p : cloud.points) p = {p.x * factor + dx, p.y * factor - dx, p.z * steepness};
}

void add_attributes(Input& in, Cloud& cloud) {
  const std::uint8_t which = in.byte();
  if (which % 2 != 0) cloud.attributes.push_back({"classification", {}});
  if (which / 2 % 2 != 0) cloud.attributes.push_back({"sigma", {}});
  if (which / 4 % 2 != 0) cloud.attributes.push_back({"weight", {}});
  for (Attribute& a : cloud.attributes) {
    const RandomStream random(in.byte(), 1);
    const bool any = in.flag();
    for (std::uint64_t i = 0; i < cloud.points.size(); ++i)
      a.values.push_back(any ? in.number() : std::floor(3 * random.uniform(i)));
  }
}

std::optional<RasterValues> decode_raster(Input& in) {
  Cloud cloud;
  cloud.path = "raster";
  const std::size_t columns = 1 + in.below(6), rows = 1 + in.below(6);
  const double size = in.length();
  cloud.grid = RasterGrid{columns, rows, {-in.length(), size, 0, -in.length(), 0, in.flag() ? size : -size}};
  for (std::size_t row = 0; row < rows; ++row)
    for (std::size_t column = 0; column < columns; ++column) {
      const auto& g = cloud.grid->geotransform;
      const double z = in.flag() ? in.byte() : in.number();
      if (in.below(8) == 7) continue;
      cloud.points.push_back(
          {g[0] + (static_cast<double>(column) + 0.5) * g[1], g[3] + (static_cast<double>(row) + 0.5) * g[5], z});
    }
  return RasterValues(cloud);
}

SigmaSource decode_sigma(Input& in) {
  using Kind = SigmaSource::Kind;
  SigmaSource sigma;
  sigma.kind = in.choice({Kind::none, Kind::constant, Kind::attribute, Kind::raster});
  if (sigma.kind == Kind::constant) sigma.value = in.flag() ? in.length() : 0;
  if (sigma.kind == Kind::attribute) sigma.name = "sigma";
  if (sigma.kind == Kind::raster) sigma.name = "raster", sigma.raster = decode_raster(in);
  return sigma;
}

/// Formulas are polynomials, which no refinement follows into a million pieces.
WeightSource decode_weight(Input& in) {
  using Kind = WeightSource::Kind;
  WeightSource weight;
  weight.kind = in.choice({Kind::none, Kind::none, Kind::expression, Kind::attribute, Kind::raster});
  if (weight.kind == Kind::expression) {
    weight.text = "formula";
    const double a = in.length(), b = in.signed_byte();
    weight.formula = [a, b](const Place& p) { return a + b * p.x * p.x + p.slope1; };
  }
  if (weight.kind == Kind::attribute) {
    weight.text = "weight";
    weight.scan = in.choice({WeightSource::Scan::any, WeightSource::Scan::a, WeightSource::Scan::b});
  }
  if (weight.kind == Kind::raster) weight.text = "raster", weight.raster = decode_raster(in);
  return weight;
}

void decode_uncertainty(Input& in, UncertaintyOptions& u) {
  using Model = UncertaintyModel;
  u.model = in.choice({Model::none, Model::independent, Model::correlated, Model::registration});
  u.sigma1 = decode_sigma(in);
  u.sigma2 = decode_sigma(in);
  if (in.flag()) u.confidence = in.share();
  if (in.flag()) u.lod = in.length();
  if (u.model == Model::correlated || in.below(8) == 7) u.correlation_range = in.length();
  u.correlation = in.choice({CorrelationShape::spherical, CorrelationShape::exponential, CorrelationShape::gaussian});
  if (u.model == Model::registration && in.flag()) u.registration_error = in.length();
  if (u.model == Model::registration && in.flag()) {
    PoseCovariance& covariance = u.registration_covariance.emplace();
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = 0; j <= i; ++j)
        covariance.matrix[6 * i + j] = covariance.matrix[6 * j + i] = i == j ? in.length() : in.signed_byte() / 1e3;
    u.registration_source = "covariance";
  }
}

void decode_area(Input& in, AreaOptions& area) {
  const std::uint8_t which = in.byte();
  if (which / 32 == 1) area.include.push_back(decode_polygons(in));
  if (which / 32 == 2) area.exclude.push_back(decode_polygons(in));
  if (which / 32 == 3) area.budget.push_back(decode_polygons(in));
  if (which / 32 != 4) return;
  Mask& mask = area.mask.emplace();
  mask.path = "mask";
  for (const Polygon& polygon : decode_polygons(in).polygons)
    for (const Edge& edge : edges_of(polygon)) mask.edges.push_back(edge);
}

Freedom decode_freedom(Input& in) {
  const std::uint8_t bits = in.byte(), rest = in.byte();
  if (bits < 192) return {};
  return {bits % 2 != 0,     bits / 2 % 2 != 0, bits / 4 % 2 != 0, bits / 8 % 2 != 0,
          rest / 2 % 2 != 0, rest / 4 % 2 != 0, rest % 2 != 0};
}

}  // namespace

void damage(Input& in, Cloud& cloud) {
  for (std::size_t n = in.below(8); n > 0 && !cloud.points.empty(); --n) {
    const std::size_t at = in.byte() * cloud.points.size() / 256;
    Point3& p = cloud.points[at];
    const std::size_t what = in.below(6);
    if (what == 0) p.x = in.number();
    if (what == 1) p.y = in.number();
    if (what == 2) p.z = in.number();
    if (what == 3) p = cloud.points[0];
    if (what == 4) p = {cloud.points[0].x, cloud.points[0].y, in.signed_byte() / 4.0};
    if (what == 5 && !cloud.faces.empty())
      cloud.faces[at % cloud.faces.size()][0] = static_cast<Index>(cloud.points.size() - in.below(2));
  }
}

Cloud decode_cloud(Input& in) {
  Cloud cloud;
  cloud.path = "fuzz";
  const std::size_t kind = in.below(8);
  if (kind < 2) add_grid(in, cloud);
  if (kind == 2) add_scattered(in, cloud);
  if (kind == 3) add_line(in, cloud);
  if (kind == 4) add_numbers(in, cloud);
  if (kind > 4) add_hills(in, cloud);
  scale(in, cloud);
  damage(in, cloud);
  add_attributes(in, cloud);
  return cloud;
}

Pose decode_pose(Input& in) {
  Pose pose;
  const std::size_t kind = in.below(4);
  if (kind == 1) pose.m[3] = in.signed_byte() / 64.0, pose.m[7] = in.signed_byte() / 64.0, pose.m[11] = in.number();
  if (kind == 2) {
    const double angle = in.signed_byte() / 64.0;
    pose.m[0] = pose.m[5] = std::cos(angle), pose.m[4] = std::sin(angle), pose.m[1] = -pose.m[4];
  }
  for (std::size_t i = 0; kind == 3 && i < 12; ++i) pose.m[i] = in.number();
  return pose;
}

PolygonSet decode_polygons(Input& in) {
  PolygonSet set;
  set.path = "polygons";
  if (in.flag()) set.geo = geo_functions();
  for (std::size_t n = 1 + in.below(3); n > 0; --n) {
    Polygon polygon;
    polygon.name = {static_cast<char>(in.byte()), static_cast<char>(in.byte())};
    for (std::size_t rings = 1 + in.below(3); rings > 0; --rings) {
      std::vector<Point2> ring;
      for (std::size_t corners = 3 + in.below(6); corners > 0; --corners) {
        const double x = in.flag() ? in.signed_byte() / 8.0 : in.number();
        ring.push_back({x, in.signed_byte() / 8.0});
      }
      polygon.rings.push_back(std::move(ring));
    }
    set.polygons.push_back(std::move(polygon));
  }
  return set;
}

ProjectOptions decode_projection(Input& in) {
  using Kind = Direction::Kind;
  ProjectOptions options;
  options.direction.kind =
      in.choice({Kind::axis_z, Kind::axis_z, Kind::axis_z, Kind::axis_x, Kind::axis_y, Kind::fit, Kind::vector});
  if (options.direction.kind == Kind::vector) {
    const double x = in.number(), y = in.number();
    options.direction.vector = {x, y, in.number()};
  }
  using Policy = DuplicatePolicy;
  options.duplicates =
      in.choice({Policy::mean, Policy::min, Policy::max, Policy::median, Policy::first, Policy::error});
  if (in.below(8) == 7) options.classes = {0, 1};
  if (in.below(8) == 7) {
    Box2& box = options.crop.emplace();
    box.add(Point2{in.number(), in.number()});
    box.add(Point2{static_cast<double>(in.signed_byte()), static_cast<double>(in.signed_byte())});
  }
  return options;
}

void decode_scans(Input& in, CompareOptions& options) {
  options.project = decode_projection(in);
  options.pose = decode_pose(in);
  options.border = in.choice({BorderRule::trim, BorderRule::hull});
  options.folds = in.choice({FoldRule::leave_out, FoldRule::keep});
  if (in.below(8) == 7) options.max_edge = in.length();
  if (in.below(8) == 7) options.alpha = in.length();
  if (in.flag()) options.unit = "mm";
  options.check_layers = !in.flag();
}

CompareOptions decode_comparison(Input& in) {
  CompareOptions options;
  decode_scans(in, options);
  options.surface = in.choice({Surface::common, Surface::overlay, Surface::both});
  options.measure = in.choice({MeasureKind::V, MeasureKind::dV, MeasureKind::currents});
  if (options.measure == MeasureKind::currents && in.flag()) options.currents.sigma = in.length();
  if (options.measure == MeasureKind::currents && in.flag()) options.currents.error = in.length() / 1e3;
  options.interpolation = in.choice({Interpolation::linear, Interpolation::cubic});
  options.domain = in.choice({DomainKind::overlap, DomainKind::hull});
  options.keep_overlay = in.flag();
  options.locate = in.choice({LocateMethod::order, LocateMethod::tree, LocateMethod::interface});
  decode_area(in, options.area);
  options.weight = decode_weight(in);
  decode_uncertainty(in, options.uncertainty);
  if (in.flag()) options.percentiles = {in.share() * 100};
  options.noise_floor = in.flag();
  if (in.below(8) == 7) options.min_coverage = in.share();
  return options;
}

MatchOptions decode_matching(Input& in) {
  MatchOptions options;
  decode_scans(in, options.compare);
  options.compare.pose = {};
  options.start = decode_pose(in);
  options.objective = in.choice(
      {Objective::measure, Objective::icp_point, Objective::icp_plane, Objective::currents, Objective::icp_gicp});
  options.coarse = in.below(8) == 7;
  options.freedom = decode_freedom(in);
  if (in.flag()) options.overlap = in.share();
  options.max_iterations = 1 + static_cast<int>(in.below(16));
  if (in.flag()) options.tolerance = in.length() / 1e3;
  options.judge = in.flag();
  options.check_pose = in.flag();
  options.label_points = in.flag();
  IcpOptions& icp = options.icp;
  icp.weights = in.choice({IcpOptions::Weights::tukey, IcpOptions::Weights::uniform});
  if (in.flag()) icp.reject_distance = in.length(), icp.reject_distance_absolute = in.flag();
  if (in.flag()) icp.reject_normal = in.byte() * 180 / 255.0;
  icp.reject_boundary = !in.flag();
  icp.one_to_one = in.flag();
  icp.symmetric = in.flag();
  if (options.objective == Objective::currents && in.flag()) options.sigma = in.length();
  if (options.objective == Objective::measure) options.compare.weight = decode_weight(in);
  return options;
}

}  // namespace isopach::fuzz
