#include "isopach/report/asymmetry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "isopach/io/output_file.hpp"
#include "isopach/io/write.hpp"
#include "isopach/report/draw/palette.hpp"
#include "isopach/report/page/furniture.hpp"
#include "isopach/report/page/page.hpp"
#include "isopach/report/page/values.hpp"
#include "isopach/report/page/words.hpp"
#include "isopach/report/view/view_page.hpp"
#include "isopach/version.hpp"

namespace isopach {
namespace {

using namespace values;
constexpr Typography plain = Typography::plain, fine = Typography::fine;

const char* to_text(FaceParts parts) { return parts == FaceParts::thirds ? "thirds" : "halves"; }

/// "+x" where the normal is nearest to that axis of the file.
std::string positive_axis(const Asymmetry& a) {
  const double n[3] = {a.plane.normal.x, a.plane.normal.y, a.plane.normal.z};
  int most = 0;
  for (int k = 1; k < 3; ++k)
    if (std::fabs(n[k]) > std::fabs(n[most])) most = k;
  return std::string(n[most] < 0 ? "-" : "+") + "xyz"[most];
}

/// 1: the positive side is the patient's left, -1: right, 0: no face was found that would tell.
int side_of_patient(const Asymmetry& a) {
  if (!a.pose.found()) return 0;
  constexpr double agree = 0.9659258262890683;  // cosine of 15 degrees
  const Point3 &n = a.plane.normal, &l = a.pose.left;
  const double cosine = n.x * l.x + n.y * l.y + n.z * l.z;
  return cosine > agree ? 1 : cosine < -agree ? -1 : 0;
}

/// "left" and "right" are the patient's; without a face that tells they are those of the picture, whose x runs to the
/// positive side.
std::string positive_side(const Asymmetry& a) { return side_of_patient(a) > 0 ? "left" : "right"; }
std::string negative_side(const Asymmetry& a) { return side_of_patient(a) > 0 ? "right" : "left"; }

/// "left side", "right of the picture".
std::string named(const std::string& side, const Asymmetry& a) {
  return side + (side_of_patient(a) == 0 ? " of the picture" : " side");
}

/// Of an average over the face: to a tenth of the decade of the noise floor, which is not known any finer; 3 digits at
/// most.
std::string to_floor(double value, double floor, Typography t) {
  if (!(floor > 0) || !std::isfinite(value)) return number(value, t, 3);
  const int decimals = std::clamp(1 - static_cast<int>(std::floor(std::log10(floor))), 0, 9);
  const double step = std::pow(10, -decimals), size = std::fabs(value);
  if (size < step / 2) return "less than " + fixed_number(step, decimals, t);
  return std::log10(size) + 1 + decimals > 3 ? number(value, t, 3) : fixed_number(value, decimals, t);
}
std::string index_number(const Asymmetry& a, Typography t) { return to_floor(a.index.percent, a.index.floor, t); }
std::string difference_number(const Asymmetry& a, double d, Typography t) {
  return to_floor(d, a.comparison.noise_floor->rho, t);
}

/// How sure the midline is where it matters: 80 mm from the middle of a face of 150 mm.
double midline_at_ends(const Asymmetry& a) {
  constexpr double away = 80.0 / 150;
  return a.plane.sigma_angle * std::numbers::pi / 180 * away * a.pose.width;
}

/// What a doctor is told of the pose.
std::string pose_words(const Asymmetry& a, Typography t) {
  if (side_of_patient(a) == 0)
    return "Which side is the patient's right is not known: no face was found here that agrees with the plane. Right "
           "and left are those of the picture, seen along the direction given.";
  const std::string gap = t == fine ? "\u00a0" : " ";
  return "The face was found and turned upright. R is the patient's right as the scan has it: if the export mirrored "
         "the "
         "scan, R and L are exchanged; check a mole or a scar. The midline is certain to " +
         number(a.plane.sigma_angle, t, 2) + (t == fine ? "°" : " degrees") + ", that is " +
         number(midline_at_ends(a), t, 2) + gap + unit_text(a.unit) + " at forehead and chin.";
}

Json input_json(const Asymmetry& a) {
  const InputSummary& in = a.face;
  const Cleaning& k = in.cleaning;
  return {{"path", in.path},
          {"points", in.points},
          {"nodes", in.nodes},
          {"used", a.comparison.b.points},
          {"unit", in.unit},
          {"vertical_unit", in.vertical_unit},
          {"crs", text_or_null(in.crs)},
          {"format", in.format},
          {"bounds", {{"min", point(in.bounds.min)}, {"max", point(in.bounds.max)}}},
          {"dropped", {{"nonfinite", k.dropped_nonfinite}, {"class", k.dropped_class}, {"crop", k.dropped_crop}}}};
}

Json stable_json(const AsymmetryOptions& o) {
  if (o.stable.empty()) return nullptr;
  Json names = Json::array();
  for (const StablePart part : o.stable) names.push_back(to_text(part));
  return names;
}

Json parameters_json(const Asymmetry& a) {
  const AsymmetryOptions& o = a.options;
  const CompareOptions& c = o.compare;
  return {{"direction_rule", to_text(c.project.direction.kind)},
          {"orientation", o.orientation == FaceOrientation::found ? "found" : "given"},
          {"stable", stable_json(o)},
          {"across", o.across ? point(*o.across) : Json(nullptr)},
          {"rim", real(o.rim)},
          {"depth", o.depth > 0 ? real(o.depth) : Json(nullptr)},
          {"visible", o.visible},
          {"accept_doubt", o.accept_doubt},
          {"regions", o.polygons ? o.polygons->path : std::string(to_text(o.parts))},
          {"overlap", o.overlap > 0 ? real(o.overlap) : Json("auto")},
          {"max_iterations", o.max_iterations},
          {"border", to_text(c.border)},
          {"folds", to_text(c.folds)},
          {"max_edge", c.max_edge > 0 ? real(c.max_edge) : Json(nullptr)},
          {"duplicates", to_text(c.project.duplicates)},
          {"class", c.project.classes.empty() ? Json(nullptr) : Json(c.project.classes)},
          {"crop", crop_box(c.project.crop)},
          {"unit", a.unit},
          {"allow_crs", c.allow_crs}};
}

Json plane_json(const Asymmetry& a) {
  const SymmetryPlane& p = a.plane;
  return {{"normal", point(p.normal)},
          {"point", point(p.point)},
          {"offset", real(p.offset)},
          {"sigma_angle_deg", real(p.sigma_angle)},
          {"sigma_offset", real(p.sigma_offset)},
          {"twist_deg", real(p.twist)},
          {"glide", real(p.glide)},
          {"agree", a.sides ? real(a.sides->agree) : Json(nullptr)},
          {"shape", a.sides ? real(a.sides->shape) : Json(nullptr)},
          {"positive_side", positive_axis(a)}};
}

Json pose_json(const Asymmetry& a) {
  const FacePose& p = a.pose;
  const bool found = p.found();
  return {{"convention", "face = matrix * input, row-major; the symmetry plane is x = 0 of the face"},
          {"matrix", values::matrix(a.to_face)},
          {"found", found},
          {"refusal", found ? Json(nullptr) : Json(to_text(p.refusal))},
          {"likeness", real(p.likeness)},
          {"front", found ? point(p.front) : Json(nullptr)},
          {"up", found ? point(p.up) : Json(nullptr)},
          {"left", found ? point(p.left) : Json(nullptr)},
          {"width", found ? real(p.width) : Json(nullptr)},
          {"covered", real(p.covered)},
          {"sigma_angle_deg", found ? real(p.sigma_angle_deg) : Json(nullptr)},
          {"spread_percent", found ? real(100 * p.spread) : Json(nullptr)},
          {"swelling_percent", found ? real(100 * a.swelling) : Json(nullptr)}};
}

Json regions_json(const Asymmetry& a) {
  Json rows = Json::array();
  for (const SideDifference& r : a.regions)
    rows.push_back({{"name", r.name},
                    {"area", real(r.area)},
                    {"directional", real(r.directional)},
                    {"absolute", real(r.absolute)},
                    {"rms", real(r.rms)},
                    {"largest", real(r.largest)},
                    {"volume",
                     {{"positive", real(r.volume.above)},
                      {"negative", real(r.volume.below)},
                      {"net", real(r.volume.net)},
                      {"absolute", real(r.volume.absolute)}}}});
  return rows;
}

Json difference_json(const Asymmetry& a) {
  const DifferenceStatistics& d = a.comparison.measures.difference;
  Json percentiles;
  for (std::size_t k = 0; k < percentile_levels.size(); ++k)
    percentiles[std::to_string(percentile_levels[k])] = real(d.abs_percentiles[k]);
  return {{"rms", real(d.rms)},
          {"nmad", real(d.nmad)},
          {"largest", real(std::max(d.max_above, d.max_below))},
          {"abs_percentiles", percentiles}};
}

std::string index_words(const Asymmetry& a, Typography t) {
  return "asymmetry index " + index_number(a, t) + (t == fine ? "\u00a0%" : " %");
}

/// "the patient's left side stands out by 0.31 mm on average", "the side on the right of the picture …"
std::string direction_words(const Asymmetry& a, Typography t) {
  const double d = a.regions.front().directional;
  const std::string side = named(d < 0 ? negative_side(a) : positive_side(a), a);
  return (side_of_patient(a) == 0 ? "the side on the " : "the patient's ") + side + " stands out by " +
         difference_number(a, std::fabs(d), t) + (t == fine ? "\u00a0" : " ") + unit_text(a.unit) + " on average";
}

/// "patient's left", "right of the picture".
std::string of_page(const std::string& side, const Asymmetry& a) {
  return side_of_patient(a) == 0 ? named(side, a) : "patient's " + side;
}

class Page : public ViewPage {
 public:
  Page(const Asymmetry& a, const std::string& json, const MapOptions& look)
      : ViewPage(json),
        a_(a),
        look_(look),
        title_(look.title.empty() ? "Asymmetry of " + input_name(a.face) : clean_utf8(look.title)),
        unit_(unit_text(a.unit)),
        area_(unit_text(a.unit, 2)),
        volume_(unit_text(a.unit, 3)),
        plus_(of_page(positive_side(a), a)),
        minus_(of_page(negative_side(a), a)) {}

  std::string write(const std::string& map_png, const ViewWords& words, const MapOptions& look,
                    const Context& context) {
    write(map_png);
    return with_view({{"", &a_.comparison}}, words, look, context);
  }

 private:
  std::string write(const std::string& map_png) {
    open_page(title_);
    head(map_png);
    regions();
    plane();
    numbers();
    finish_page(of_no_use());
    return out_;
  }

  /// Options that say nothing to who has a face before them: those that were not given, and axes where it was found.
  [[nodiscard]] std::vector<std::string> of_no_use() const {
    std::vector<std::string> names;
    for (const auto& [name, setting] : at("parameters").items())
      if (setting.is_null() || (name == "direction_rule" && a_.pose.found())) names.push_back(name);
    return names;
  }

  void head(const std::string& map_png) {
    out_ += "<header>\n";
    sign("", look_.logo.png);
    out_ += "<h1>" + escaped(title_) + "</h1>\n<p class=\"lead\">The two sides differ by " +
            datum("measure.rho_debiased", difference_number(a_, value("measure.rho_debiased"), fine)) + "\u00a0" +
            unit_ + " on average, " + datum("index.percent", index_number(a_, fine)) +
            "\u00a0% of the size of the face; " + direction_words(a_, fine) +
            ".</p>\n<p class=\"soft\">The face is compared with its own mirror image about the symmetry plane found. d "
            "is the "
            "height of a side above the other side, mirrored: positive where it stands out further. Lengths: " +
            unit_sentence(a_.unit) + ". " + escaped(pose_words(a_, fine)) + "</p>\n";
    sign(signature(a_.comparison, look_, " · "), "");
    out_ += "</header>\n<div class=\"cards\">\n";
    card(datum("index.percent", index_number(a_, fine)), "%", "asymmetry index, noise floor taken off");
    card(brief("index.floor", 3), "%", "noise floor: what a symmetric face would show");
    card(brief_sign("regions.0.directional", 3), unit_, plus_ + " less " + minus_ + " (directional)");
    card(brief("regions.0.absolute", 3), unit_, "mean |d| (absolute)");
    card(percent("domain.coverage"), "%", "of the area compared");
    out_ += "</div>\n";
    warnings();
    out_ += view_place;
    if (!map_png.empty()) picture(map_png, "Map of the left-right differences, with the symmetry plane");
  }

  void regions() {
    open_table("By region", "<th>region</th><th class=\"n\">directional, " + unit_ + "</th><th class=\"n\">absolute, " +
                                unit_ + "</th><th class=\"n\">RMS, " + unit_ + "</th><th class=\"n\">largest, " +
                                unit_ + "</th><th class=\"n\">" + plus_ + " further out, " + volume_ +
                                "</th><th class=\"n\">" + minus_ + " further out, " + volume_ +
                                "</th><th class=\"n\">net, " + volume_ + "</th><th class=\"n\">area, " + area_ +
                                "</th>");
    for (std::size_t i = 0; i < a_.regions.size(); ++i) {
      const std::string row = "regions." + std::to_string(i) + ".";
      out_ += "<tr><th scope=\"row\">" + escaped(a_.regions[i].name) + "</th>";
      for (const std::string& cell :
           {brief_sign(row + "directional", 3), brief(row + "absolute", 3), brief(row + "rms", 3),
            brief(row + "largest", 3), plain(row + "volume.positive"), plain(row + "volume.negative"),
            with_sign(row + "volume.net"), plain(row + "area")})
        out_ += "<td class=\"n\">" + cell + "</td>";
      out_ += "</tr>\n";
    }
    close_table();
    out_ += "<p class=\"soft\">Each region on the " + plus_ + " against its mirror image on the " + minus_ +
            "; area is that of one side. Directional: net volume ÷ area, which side stands out and how far. "
            "Absolute: "
            "how much the sides differ, whichever stands out; noise adds up to " +
            brief("measure.rho_floor", 3) + "\u00a0" + unit_ + " to it." +
            (a_.options.polygons ? " Regions are polygons of " + escaped(a_.options.polygons->path) +
                                       "; each counts together with its mirror image, every pair of places once."
                                 : "") +
            "</p>\n";
  }

  void plane() {
    open_table("The symmetry plane", "<th>name</th><th></th><th>unit</th><th>what it says</th>", " class=\"told\"");
    const bool has_patient = side_of_patient(a_) != 0;  // who has no use for axes of the file
    for (const auto& [k, name] :
         {std::pair{"0", "normal, x"}, std::pair{"1", "normal, y"}, std::pair{"2", "normal, z"}})
      if (!has_patient)
        row(name, brief_sign(std::string("plane.normal.") + k, 6), "",
            *k == '0' ? "unit vector to the " + plus_ + ", input coordinates" : std::string());
    if (!has_patient) row("offset", brief_sign("plane.offset", 7), unit_, "normal · p for every point p of the plane");
    row("its direction", brief("plane.sigma_angle_deg", 2), "°", "one standard deviation");
    row("its place", brief("plane.sigma_offset", 2), unit_, "likewise, at the middle of the face");
    row("twist", brief("plane.twist_deg", 2), "°",
        "turn about the normal that would fit better than a pure reflection: near 0 for a face");
    row("glide", brief("plane.glide", 2), unit_, "shift along the plane, likewise");
    row("fitted", percent("fit.overlap"), "% of area",
        "taken for symmetric; the rest differs more than noise and does not pull at the plane");
    close_table();
  }

  void numbers() {
    open_table("The numbers", "<th>name</th><th></th><th>unit</th><th>what it says</th>", " class=\"told\"");
    row("index, measured", brief("index.raw", 3), "%", "100 ρ ÷ size, with what points and noise add");
    row("size", plain("index.size"), unit_, "square root of the area compared");
    row("ρ, mean |d|", plain("measure.rho"), unit_, "between face and mirror image");
    row("ρ, noise floor", plain("measure.rho_floor"), unit_,
        "what a symmetric face with these points and this noise would show");
    row("ρ, debiased", datum("measure.rho_debiased", difference_number(a_, value("measure.rho_debiased"), fine)), unit_,
        "without what points and noise add");
    row("RMS", plain("difference.rms"), unit_, "root of the mean of d²");
    for (const int level : percentile_levels)
      row("|d| at " + std::to_string(level) + "\u00a0%", plain("difference.abs_percentiles." + std::to_string(level)),
          unit_, std::to_string(level) + "\u00a0% of the area differs by no more than this");
    row("largest |d|", plain("difference.largest"), unit_, "");
    row("points", whole("input.points"), "", "of the file");
    row("points used", whole("input.used"), "", "kept by crop, class and rim");
    row("area compared", plain("domain.area"), area_, "both sides");
    close_table();
  }

  const Asymmetry& a_;
  const MapOptions& look_;
  std::string title_, unit_, area_, volume_, plus_, minus_;
};

}  // namespace

std::string asymmetry_json(const Asymmetry& a, const std::vector<std::string>& outputs) {
  const Comparison& c = a.comparison;
  const Json report = {
      {"schema", "isopach.asymmetry/1"},
      {"tool", {{"name", tool_name}, {"version", version}}},
      {"input", input_json(a)},
      {"parameters", parameters_json(a)},
      {"plane", plane_json(a)},
      {"pose", pose_json(a)},
      {"index",
       {{"percent", real(a.index.percent)},
        {"raw", real(a.index.raw)},
        {"floor", real(a.index.floor)},
        {"size", real(a.index.size)}}},
      {"measure",
       {{"rho", real(c.measures.rho)},
        {"rho_floor", real(c.noise_floor->rho)},
        {"rho_debiased", real(c.noise_floor->debiased_rho)}}},
      {"regions", regions_json(a)},
      {"difference", difference_json(a)},
      {"domain", {{"area", real(c.domain_area)}, {"area_union", real(c.area_union)}, {"coverage", real(c.coverage)}}},
      {"fit",
       {{"iterations", a.iterations},
        {"converged", a.converged},
        {"reason", message(a.reason)},
        {"overlap", real(a.overlap)}}},
      {"outputs", outputs},
      {"warnings", messages(a.warnings)},
      {"timing_s", timing(a.timing)}};
  return report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string asymmetry_text(const Asymmetry& a) {
  const std::string unit = unit_text(a.unit), volume = unit_text(a.unit, 3);
  const auto n = [](double v) { return number(v, plain, 3); };
  std::string out = fmt::format("{}: {}, {}\n", input_name(a.face), index_words(a, plain), direction_words(a, plain));
  line(out, "points",
       fmt::format("{}, {} of them used", count(a.face.points, plain), count(a.comparison.b.points, plain)));
  line(out, "index",
       fmt::format("{} % of the size {} {}; measured {} %, of which points and noise make {} %", index_number(a, plain),
                   n(a.index.size), unit, n(a.index.raw), n(a.index.floor)));
  line(out, "mean |d| (rho)",
       fmt::format("{} {}, without the noise floor {} {}", n(a.comparison.measures.rho), unit,
                   difference_number(a, a.comparison.noise_floor->debiased_rho, plain), unit));
  const SymmetryPlane& p = a.plane;
  out += "  " + pose_words(a, plain) + "\n";
  line(out, "plane",
       fmt::format("({}, {}, {}) . p = {} {}", fixed_number(p.normal.x, 6, plain), fixed_number(p.normal.y, 6, plain),
                   fixed_number(p.normal.z, 6, plain), number(p.offset, plain, 6), unit));
  line(out, "",
       fmt::format("known to {} degrees and {} {} (one standard deviation)", number(p.sigma_angle, plain, 2),
                   number(p.sigma_offset, plain, 2), unit));
  if (a.sides)
    line(out, "",
         fmt::format("about it {} % of what both sides show agrees within noise, and their shapes agree by {}",
                     fixed_number(100 * std::clamp(a.sides->agree, 0.0, 1.0), 0, plain),
                     fixed_number(std::clamp(a.sides->shape, 0.0, 1.0), 2, plain)));
  line(out, "compared",
       fmt::format("{} % of the area of face and mirror image; the plane was fitted to {} % of that",
                   fixed_number(100 * a.comparison.coverage, 1, plain), fixed_number(100 * a.overlap, 1, plain)));
  out += fmt::format("  {:<16}{:>14}{:>14}{:>14}{:>14}\n", positive_side(a) + " less " + negative_side(a),
                     "directional", "absolute", "largest", "net volume");
  for (const SideDifference& r : a.regions)
    out += fmt::format("  {:<16}{:>14}{:>14}{:>14}{:>14}\n", r.name, signed_number(r.directional, plain, 3),
                       n(r.absolute), n(r.largest), signed_number(r.volume.net, plain));
  line(out, "", fmt::format("in {}, {}", unit, volume));
  if (a.unit == "unknown" || a.unit.empty()) line(out, "units", unit_sentence(a.unit));
  line(out, "time", fmt::format("{:.2f} s", a.timing.total));
  for (const std::string& w : a.warnings) out += "warning: " + message_text(w) + "\n";
  return out;
}

void write_asymmetry_map(const std::string& path, const Asymmetry& a, const MapOptions& look, const Context& context) {
  MapOptions options = look;
  if (options.title.empty()) options.title = input_name(a.face) + ": each side against the other, mirrored";
  MapWords& words = options.words;
  words.headline = index_words(a, fine) + "   ·   mean |d| (ρ) " + number(a.comparison.measures.rho, fine, 3) +
                   "\u00a0" + unit_text(a.unit) + ", noise floor " + number(a.comparison.noise_floor->rho, fine, 3) +
                   "\u00a0" + unit_text(a.unit);
  words.where = direction_words(a, fine) + "   ·   " + fixed_number(100 * a.comparison.coverage, 1, fine) +
                " % of the area compared";
  words.above = "stands out further", words.below = "lies further back";
  words.zero = "both sides alike", words.left_out = "scanned, but not the other side";
  words.note = "d = this side − the other side, mirrored";
  words.across = side_of_patient(a) == 0 ? "from the symmetry plane" : "from the midline";
  words.up = side_of_patient(a) == 0 ? "along the symmetry plane" : "along the midline";
  const Point3 origin = a.comparison.frame.origin;
  options.flip = options.flip != !paints_excess_red(a.unit);  // red stands out, whatever the unit
  Box2 box;
  for (const Point2& p : a.comparison.cells.xy) box.add(p);
  options.lines.push_back({{{-origin.x, box.max.y}, {-origin.x, box.min.y}}, "symmetry plane"});
  if (const int side = side_of_patient(a); side != 0)
    for (const double x : {box.min.x, box.max.x}) {
      const double y = box.max.y;
      options.lines.push_back(
          {{{x, y}, {x, y}}, (x > -origin.x) == (side > 0) ? "L: patient's left" : "R: patient's right"});
    }
  write_map(path, a.comparison, options, context);
}

void write_asymmetry_html(const std::string& path, const Asymmetry& a, const std::string& map_png,
                          const std::string& json, const MapOptions& look, const Context& context) {
  context.check();
  const ViewWords words{"mirrored", "face", "stands out further", "lies further back", false, ""};
  MapOptions shown = look;
  shown.flip = look.flip != !paints_excess_red(a.unit);  // as on the map
  write_text_atomically(path, Page(a, json, look).write(map_png, words, shown, context));
}

void write_asymmetry_points(const std::string& path, const CloudView& face, const Asymmetry& a,
                            const Context& context) {
  Cloud out;
  out.points = face.points.copy();
  out.unit = face.unit, out.vertical_unit = face.vertical_unit, out.crs = face.crs;
  out.attributes.push_back({"asymmetry", a.of_point});
  write_cloud(path, out, context);
}

}  // namespace isopach
