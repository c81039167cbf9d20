// THE PAGE of asymmetry: mirror, match, compare, report by region (docs/use/asymmetry.md).
#include "isopach/apps/asymmetry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "isopach/apps/mirror.hpp"
#include "isopach/apps/symmetry_search.hpp"
#include "isopach/apps/symmetry_start.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/compare/domain.hpp"
#include "isopach/compare/stages.hpp"
#include "isopach/distance/mesh.hpp"
#include "isopach/distance/point_tree.hpp"
#include "isopach/distance/surface_tree.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/match/match.hpp"
#include "isopach/match/surface/surface.hpp"

namespace isopach {
namespace {

constexpr std::size_t thin_points = 1000;  // of the scan that starts are tried on
constexpr double disagree_deg = 15;        // of what is given and what is found: more is worth a warning

double degrees_between(const Point3& a, const Point3& b) {
  return std::atan2(length(cross(a, b)), dot(a, b)) * 180 / std::numbers::pi;
}

/// What the user gave against the pose of the face, where there is one.
void warn_of_pose(const AsymmetryOptions& o, const Frame& frame, Asymmetry& a) {
  if (!a.pose.found()) return;
  const Point3 direction{frame.rotation[6], frame.rotation[7], frame.rotation[8]};
  if (o.orientation == FaceOrientation::given) {
    const double off = degrees_between(direction, a.pose.front);
    if (off > disagree_deg)
      a.warnings.push_back(
          fmt::format("the face that was found in the scan looks {:.0f} degrees away from @direction: "
                      "leave @direction out to take the face as it was found",
                      off));
  }
  if (o.across) {
    const double off = degrees_between(*o.across, a.pose.left), turned = std::min(off, 180 - off);
    if (turned > disagree_deg)
      a.warnings.push_back(
          fmt::format("the sides of the face that was found lie {:.0f} degrees away from @across: leave "
                      "@across out to take them as they were found",
                      turned));
  }
}

void check(const AsymmetryOptions& o) {
  if (!(o.rim >= 0)) throw UsageError(fmt::format("@rim: {} is no width: a number from 0 on", o.rim));
  if (!(o.depth >= 0)) throw UsageError(fmt::format("@depth: {} is no depth: a number above 0", o.depth));
  if (!o.compare.pose.is_identity()) throw UsageError("@pose: a face is taken as it is and the plane found in it");
  if (o.across && !(std::hypot(o.across->x, o.across->y, o.across->z) > 0))
    throw UsageError("@across: 0,0,0 is no direction: give one from one side of the face to the other, e.g. x");
}

/// Which points of the scan take part, in the coordinates of its frame.
struct View {
  Frame frame;
  ScanPoints points;
  Array<Point3> thin;  // means of neighbouring points
  InputSummary summary;
};

/// The ends of the edges between what the sampling supports and what not.
Array<Point3> border_points(const MatchSurface& s) {
  Array<Point3> found;
  for (Index t = 0; t < s.t.real; ++t) {
    if (!s.footprint.keeps(t)) continue;
    for (Index k = 0; k < 3; ++k) {
      const Index other = triangle_of(s.t.triangles[t].n[k]);
      if (!s.t.is_ghost(other) && s.footprint.keeps(other)) continue;
      const Point2 &p = s.xy[s.t.triangles[t].v[k]], &q = s.xy[s.t.triangles[t].v[next_side(k)]];
      found.push_back({p.x, p.y, 0});
      found.push_back({(p.x + q.x) / 2, (p.y + q.y) / 2, 0});
    }
  }
  return found;
}

void keep(ScanPoints& scan, const Array<unsigned char>& kept) {
  std::size_t n = 0;
  for (std::size_t i = 0; i < kept.size(); ++i)
    if (kept[i] != 0) scan.points[n] = scan.points[i], scan.ids[n] = scan.ids[i], ++n;
  scan.points.resize(n), scan.ids.resize(n);
}

void leave_out_rim(ScanPoints& scan, const MatchSurface& surface, double rim, const std::string& path) {
  const Array<Point3> border = border_points(surface);
  const PointTree tree(border);
  Array<unsigned char> kept(scan.points.size());
  for_each_index(kept.size(), [&](std::size_t i) {
    kept[i] = tree.nearest_distance2({scan.points[i].x, scan.points[i].y, 0}) > rim * rim ? 1 : 0;
  });
  keep(scan, kept);
  if (scan.points.empty())
    throw InputError(fmt::format("@rim {}: no point of {} lies that far inside its border: give a smaller width", rim,
                                 path.empty() ? std::string("the scan") : path));
}

/// Points that a face lies over, seen from where the direction comes from.
void leave_out_hidden(ScanPoints& scan, const CloudView& cloud, const Frame& frame, const HeightField& field,
                      const Context& context) {
  if (cloud.faces.empty())
    throw UsageError("@visible: the file has no faces that could hide a point: leave it out, or crop by @depth");
  const Mesh mesh = make_mesh(cloud, Pose{}, frame, field, MeshSource::faces, {}, context);
  const SurfaceTree tree(mesh);
  Box3 box;
  for (const Point3& p : mesh.points) box.add(p);
  const double depth = box.max.z - box.min.z, rounding = 1e-9 * (depth + box.max.x - box.min.x);
  Array<unsigned char> kept(scan.points.size());
  for_each_index(kept.size(), [&](std::size_t i) {
    const Point3& p = scan.points[i];
    const Crossing first = tree.cross({p.x, p.y, box.max.z + depth}, {0, 0, -1});
    const bool hidden = first.face != no_index && box.max.z + depth - first.t > p.z + rounding;
    kept[i] = hidden ? 0 : 1;
  });
  keep(scan, kept);
}

void leave_out_back(ScanPoints& scan, double depth) {
  double foremost = -std::numeric_limits<double>::infinity();
  for (const Point3& p : scan.points) foremost = std::max(foremost, p.z);
  Array<unsigned char> kept(scan.points.size());
  for (std::size_t i = 0; i < kept.size(); ++i) kept[i] = scan.points[i].z >= foremost - depth ? 1 : 0;
  keep(scan, kept);
}

/// What the pose of the face leaves of the scan.
void leave_out_of_region(ScanPoints& scan, const FacePose& pose) {
  Array<unsigned char> kept(scan.points.size());
  for (std::size_t i = 0; i < kept.size(); ++i) kept[i] = pose.region[scan.ids[i]];
  keep(scan, kept);
}

View view_of(const CloudView& cloud, const AsymmetryOptions& o, const FacePose& pose, const Context& context) {
  View view;
  const ProjectOptions& project_options = o.compare.project;
  view.frame = choose_frame(cloud, cloud, Pose{}, project_options, context);
  HeightField field = project(cloud, Pose{}, view.frame, project_options, context);
  view.points = scan_points(cloud, Pose{}, view.frame, field);
  view.summary = stages::summarise_file(cloud, "face");
  view.summary.nodes = field.xy.size();
  view.summary.cleaning = field.cleaning;
  for (const Point3& p : cloud.points)
    if (is_finite(p)) view.summary.bounds.add(p);
  CurveBox curve = view.frame.curve;
  const bool of_face = o.orientation == FaceOrientation::found;
  const bool visible = o.visible || (of_face && !cloud.faces.empty());
  if (visible) leave_out_hidden(view.points, cloud, view.frame, field, context);
  if (of_face) leave_out_of_region(view.points, pose);
  if (o.depth > 0) leave_out_back(view.points, o.depth);
  if (visible || of_face || o.depth > 0) {
    field = field_of(view.points.points, project_options.duplicates, curve, context);
  }
  if (o.rim > 0) {
    const MatchSurface surface =
        make_surface(std::move(field.xy), std::move(field.z), curve, true, o.compare.max_edge, context);
    leave_out_rim(view.points, surface, o.rim, cloud.path);
    field = field_of(view.points.points, project_options.duplicates, curve, context);
  }
  const std::size_t run = std::max<std::size_t>(1, field.xy.size() / thin_points);
  view.thin = means_of_neighbours(field, run, context);
  return view;
}

/// The plane of the pose, the face upright before it.
Upright start_of(const FacePose& pose, const Frame& frame) {
  const Point3 x = in_view(pose.left, frame), y = in_view(pose.up, frame), z = in_view(pose.front, frame);
  return {frame.to_field(pose.tip), {x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z}};
}

/// Where a part lies, in widths of the face from the tip of its nose (FaceFit::in_widths).
bool in_part(StablePart part, double x, double y) {
  constexpr double brow = .27, eye = .10, nose = .11, wing = -.09, lips = -.34, mouth = .20;
  const double beside = std::fabs(x);
  switch (part) {
    case StablePart::forehead:
      return y > brow;
    case StablePart::eyes:
      return y > eye && y <= brow && beside > nose;
    case StablePart::nose:
      return y > wing && y <= brow && beside <= nose;
    case StablePart::cheeks:
      return y > lips && y <= eye && beside > (y > wing ? nose : mouth);
    case StablePart::mouth:
      return y > lips && y <= wing && beside <= mouth;
    case StablePart::chin:
      return y <= lips;
  }
  return false;
}

/// What the plane is fitted to: everything, or the parts that are known not to have changed.
Array<Point3> stable_points(const View& view, const AsymmetryOptions& o, const FacePose& pose) {
  if (o.stable.empty()) return view.points.points;
  if (!pose.found())
    throw UsageError(
        "@stable: no face was found whose parts could be identified: leave it out, or crop the scan to the face");
  Array<Point3> kept;
  for (const Point3& p : view.points.points) {
    const Point3 d = view.frame.to_input(p) - pose.tip;
    const double x = dot(d, pose.left) / pose.width, y = dot(d, pose.up) / pose.width;
    const auto holds = [&](StablePart part) { return in_part(part, x, y); };
    if (std::any_of(o.stable.begin(), o.stable.end(), holds)) kept.push_back(p);
  }
  constexpr std::size_t enough = 100;
  if (kept.size() < enough)
    throw InputError(fmt::format(
        "@stable: the parts hold {} points of the scan, too few for a plane: name more of them", kept.size()));
  return kept;
}

/// The plane with what its search says of itself.
Upright take(FoundPlane&& f, Asymmetry& a) {
  a.plane = f.plane;
  a.sides = f.sides;
  a.iterations = f.iterations;
  a.converged = f.converged;
  a.reason = std::move(f.reason);
  a.overlap = f.overlap;
  a.warnings.insert(a.warnings.end(), f.warnings.begin(), f.warnings.end());
  return f.place;
}

void describe_plane(const View& view, const Upright& place, Asymmetry& a) {
  const auto turned_back = [&](const Point3& v) {
    const auto& r = view.frame.rotation;
    return Point3{r[0] * v.x + r[3] * v.y + r[6] * v.z, r[1] * v.x + r[4] * v.y + r[7] * v.z,
                  r[2] * v.x + r[5] * v.y + r[8] * v.z};
  };
  const std::array<Point3, 3> axes{turned_back(place.axis(0)), turned_back(place.axis(1)), turned_back(place.axis(2))};
  const Point3 origin = view.frame.to_input(place.origin);
  a.plane.normal = axes[0];
  a.plane.point = origin;
  a.plane.offset = dot(axes[0], origin);
  for (std::size_t k = 0; k < 3; ++k) {
    const Point3& r = axes[k];
    a.to_face.m[4 * k] = r.x, a.to_face.m[4 * k + 1] = r.y, a.to_face.m[4 * k + 2] = r.z;
    a.to_face.m[4 * k + 3] = -dot(r, origin);
  }
}

/// The match takes residuals for independent; the jackknives of the pose know that asymmetry is coherent over large
/// parts.
void believe_larger_sigma(Asymmetry& a) {
  a.plane.sigma_angle = std::max(a.plane.sigma_angle, a.pose.sigma_angle_deg);
  a.plane.sigma_offset = std::max(a.plane.sigma_offset, a.pose.sigma_offset);
}

void describe_index(Asymmetry& a) {
  const Comparison& c = a.comparison;
  AsymmetryIndex& index = a.index;
  index.size = std::sqrt(c.domain_area);
  const auto percent = [&](double rho) { return 100 * rho / index.size; };
  index.raw = percent(c.measures.rho);
  index.floor = percent(c.noise_floor->rho);
  index.percent = percent(c.noise_floor->debiased_rho);
}

/// The two sides share their points, so that what chords add on one side they hide on the other: the estimate of what
/// noise adds can be below 0. Then nothing is taken off; without noise there is never more than with it.
void take_off_no_less_than_nothing(Comparison& c) {
  NoiseFloor& floor = *c.noise_floor;
  if (floor.debiased_rho <= c.measures.rho) return;
  floor.debiased = c.measures.volume;
  floor.debiased_rho = c.measures.rho;
}

constexpr std::size_t polygon_cells = 4096;  // of the grid over a polygon

/// The axes of the file that polygons over a face are drawn in: all but the one nearest to the direction, in their
/// order. x and y for a face that looks along z.
std::array<std::size_t, 3> drawn_axes(const Frame& frame) {
  const auto along = [&](std::size_t k) { return std::fabs(frame.rotation[6 + k]); };
  if (along(2) >= along(0) && along(2) >= along(1)) return {0, 1, 2};
  if (along(1) >= along(0)) return {0, 2, 1};
  return {1, 2, 0};
}

std::array<double, 3> listed(const Point3& p) { return {p.x, p.y, p.z}; }

/// Coordinates of polygons: along drawn_axes, about the origin of the view.
Frame drawn_frame(const Frame& view) {
  const auto axes = drawn_axes(view);
  Frame drawn;
  drawn.origin = {listed(view.origin)[axes[0]], listed(view.origin)[axes[1]], 0};
  return drawn;
}

/// From those to face coordinates, as `place` is from the view.
Upright drawn_place(const Frame& view, const Upright& place) {
  const auto axes = drawn_axes(view);
  const auto& r = view.rotation;
  const auto drawn = [&](const Point3& v) {
    const std::array<double, 3> in_file = {r[0] * v.x + r[3] * v.y + r[6] * v.z, r[1] * v.x + r[4] * v.y + r[7] * v.z,
                                           r[2] * v.x + r[5] * v.y + r[8] * v.z};
    return Point3{in_file[axes[0]], in_file[axes[1]], in_file[axes[2]]};
  };
  Upright moved;
  moved.origin = drawn(place.origin);
  for (std::size_t k = 0; k < 3; ++k) {
    const Point3 axis = drawn(place.axis(k));
    moved.rotation[3 * k] = axis.x, moved.rotation[3 * k + 1] = axis.y, moved.rotation[3 * k + 2] = axis.z;
  }
  return moved;
}

FacePolygons polygons_of_face(const CloudView& cloud, const AsymmetryOptions& o, const Frame& frame, Asymmetry& a,
                              const Context& context) {
  FacePolygons polygons;
  if (!o.polygons) return polygons;
  stages::NamedRegions file = stages::regions_of("@regions", *o.polygons, drawn_frame(frame), cloud.crs,
                                                 o.compare.allow_crs, a.warnings, context);
  polygons.names = std::move(file.names);
  for (Region& region : file.regions) {
    std::vector<Region> one;
    one.push_back(std::move(region));
    polygons.regions.emplace_back(std::move(one), polygon_cells);
  }
  return polygons;
}

/// `drawn`: from the coordinates of the polygons to those of the face.
void describe_regions(FacePolygons polygons, const Upright& drawn, Asymmetry& a, const Context& context) {
  const CellView cells = a.comparison.cells.view();
  if (!a.options.polygons) {
    a.regions = face_regions(cells, a.options.parts, context);
    return;
  }
  polygons.place = drawn;
  polygons.origin = a.comparison.frame.origin;
  a.regions = face_regions(cells, polygons, context);
  bool any = false;
  for (std::size_t k = 1; k < a.regions.size(); ++k) {
    if (a.regions[k].area > 0) {
      any = true;
    } else {
      a.warnings.push_back(fmt::format("@regions: {}: polygon '{}' holds no place that is scanned on both sides",
                                       a.options.polygons->path, a.regions[k].name));
    }
  }
  if (!any)
    throw InputError(
        fmt::format("@regions: {}: none of its polygons holds a part of the face that is scanned on both "
                    "sides: give them in x and y of the scan (for a face that looks along y in x and z, along x in y "
                    "and z)",
                    a.options.polygons->path));
}

/// A copy of the file's description without its points.
Cloud description_of(const CloudView& cloud) {
  Cloud empty;
  empty.path = cloud.path, empty.format = cloud.format, empty.unit = cloud.unit;
  empty.vertical_unit = cloud.vertical_unit, empty.crs = cloud.crs;
  return empty;
}

/// Those of the comparison, each once; of layers in words that fit a face, which is compared with itself.
void take_warnings(Asymmetry& a) {
  constexpr double told = 0.02;
  const double share = a.comparison.b.layered_share;
  for (const std::string& w : a.comparison.warnings) {
    if (w.find("several layers along the projection direction") != std::string::npos) continue;
    if (std::find(a.warnings.begin(), a.warnings.end(), w) == a.warnings.end()) a.warnings.push_back(w);
  }
  if (share > told)
    a.warnings.push_back(fmt::format(
        "{}: on {:.0f} % of its area surfaces lie behind one another as seen from the front (hair, ears, the inside of "
        "the mouth), and one of them was taken: crop the scan to the face, or leave out what is hidden by @visible, of "
        "files with faces, or @depth",
        a.face.path.empty() ? "the scan" : a.face.path, 100 * share));
}

/// Mean d over squares of a fifth of the width; the sides of the face are steep and left out.
void warn_of_swelling(const CloudView& cloud, Asymmetry& a) {
  if (!a.pose.found()) return;
  constexpr int squares = 16;
  constexpr double share = 0.2, middle = 0.42, stands_out = 0.047;
  constexpr double enough = 12;
  struct Square {
    Sum d;
    double count = 0;
  };
  std::array<Square, squares * squares> all{};
  const double side = share * a.pose.width;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    if (!std::isfinite(a.of_point[i])) continue;
    const Point3 p = a.to_face.apply(cloud.points[i]);
    if (std::fabs(p.x) > middle * a.pose.width) continue;
    const auto at = [&](double v) { return static_cast<int>(std::clamp(v / side, 0.0, squares - 1.0)); };
    Square& q = all[static_cast<std::size_t>(at(std::fabs(p.x)) * squares + at(p.y + squares / 2 * side))];
    q.d.add(p.x < 0 ? -a.of_point[i] : a.of_point[i]);
    q.count += 1;
  }
  for (const Square& q : all)
    if (q.count >= enough) a.swelling = std::max(a.swelling, std::fabs(q.d.value()) / q.count / a.pose.width);
  if (a.swelling > stands_out)
    a.warnings.push_back(
        "one side stands out over a large part of the face: the midline itself may be drawn towards it by up to some 2 "
        "degrees; name the parts that are not affected (@stable forehead,nose), or compare with a scan from before");
}

/// The pose of the face into the options: direction and sides, unless they are given. The positive side is the
/// patient's left wherever a face tells it: so the face stands upright before its plane, whichever way --across was
/// written.
void find_pose(const CloudView& cloud, AsymmetryOptions& o, Asymmetry& a, const Context& context) {
  a.pose = find_face(cloud, o.compare.project, context);
  const bool found = o.orientation == FaceOrientation::found;
  if (found && !a.pose.found())
    throw OverlapError(
        fmt::format("{}: {}", cloud.path.empty() ? std::string("the scan") : cloud.path, refusal_sentence(a.pose)));
  if (!found) return;
  o.compare.project.direction = {Direction::Kind::vector, a.pose.front};
  if (!o.across) o.across = a.pose.left;
  if (dot(*o.across, a.pose.left) < 0) o.across = -1.0 * *o.across;
  if (a.pose.too_symmetric())
    a.warnings.push_back(
        "the two sides are more alike than those of any living face: a model, a mannequin or a mirrored half?");
}

/// From side to side: as given or found, else the patient's left where the view shows the face from the front.
std::optional<Point3> across_of(const AsymmetryOptions& o, const Asymmetry& a, const Frame& frame) {
  constexpr double from_front = 45;
  const Point3 direction{frame.rotation[6], frame.rotation[7], frame.rotation[8]};
  if (o.across || !a.pose.found() || degrees_between(direction, a.pose.front) > from_front) return o.across;
  return a.pose.left;
}

/// Whether --across says something else than the face: then it holds.
bool sides_overruled(const AsymmetryOptions& o, const FacePose& pose) {
  const double off = o.across ? degrees_between(*o.across, pose.left) : 0;
  return std::min(off, 180 - off) > disagree_deg;
}

Asymmetry run(const CloudView& cloud, const AsymmetryOptions& options, const Context& context) {
  Asymmetry a;
  a.options = options;
  check(options);
  const Cloud description = description_of(cloud);
  a.unit = unit_in_space(description, options.compare, a.warnings);
  stages::Clock clock(a.timing, context);

  clock.start("face");
  AsymmetryOptions in_force = options;
  find_pose(cloud, in_force, a, context);

  clock.start("project");
  const View view = view_of(cloud, in_force, a.pose, context);
  a.face = view.summary;
  warn_of_pose(options, view.frame, a);
  const Point3 across = across_in_view(across_of(in_force, a, view.frame), view.frame);
  FacePolygons polygons = polygons_of_face(cloud, in_force, view.frame, a, context);

  clock.start("start");
  const bool known = options.orientation == FaceOrientation::found && !sides_overruled(options, a.pose);
  const Upright start = known ? start_of(a.pose, view.frame).recentred(view.points.points)
                              : symmetry_start(view.thin, view.frame, across, a.pose.planes, options, context)
                                    .recentred(view.points.points);

  clock.start("match");
  const Array<Point3> stable = stable_points(view, in_force, a.pose);
  const Upright place = take(known ? refined_plane(stable, start, across, options, context)
                                   : agreed_plane(stable, start, across, options, cloud.path, context),
                             a);
  const Upright upright = place.recentred(view.points.points);
  describe_plane(view, upright, a);
  if (known) believe_larger_sigma(a);

  clock.start("compare");
  Cloud face = placed(view.points.points, upright);
  face.path = cloud.path;
  face.unit = face.vertical_unit = a.unit;
  Cloud mirror = mirrored(face);
  mirror.path = "its mirror image";
  CompareOptions compare_options = upright_options(options.compare);
  compare_options.noise_floor = true;
  compare_options.unit.clear();
  a.comparison = compare(mirror, face, compare_options, context);
  take_off_no_less_than_nothing(a.comparison);

  clock.start("regions");
  describe_index(a);
  describe_regions(std::move(polygons), drawn_place(view.frame, upright), a, context);
  a.of_point.assign(cloud.points.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < view.points.ids.size(); ++i)
    a.of_point[view.points.ids[i]] = a.comparison.fields_b.dz_signed[i];
  warn_of_swelling(cloud, a);
  clock.stop();
  take_warnings(a);
  for (const std::string& note : cloud.notes) a.warnings.push_back(note);
  if (!a.converged) a.warnings.push_back("the search for the plane did not converge: " + a.reason);
  return a;
}

}  // namespace

const char* to_text(StablePart part) {
  switch (part) {
    case StablePart::forehead:
      return "forehead";
    case StablePart::eyes:
      return "eyes";
    case StablePart::nose:
      return "nose";
    case StablePart::cheeks:
      return "cheeks";
    case StablePart::mouth:
      return "mouth";
    case StablePart::chin:
      return "chin";
  }
  return "";
}

Asymmetry asymmetry(const CloudView& face, const AsymmetryOptions& options, const Context& context) {
  Asymmetry result;
  run_with_threads(context, [&] { result = run(face, options, context); });
  return result;
}

}  // namespace isopach
