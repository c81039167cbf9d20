#include "isopach/report/roughness.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "isopach/io/write.hpp"
#include "isopach/report/page/values.hpp"
#include "isopach/report/page/verdict_values.hpp"
#include "isopach/version.hpp"

namespace isopach {
namespace {

using namespace values;
constexpr Typography plain = Typography::plain;

Json length_or_null(double value) { return value > 0 ? real(value) : Json(nullptr); }

Json pose_json(const Pose& pose) { return {{"matrix", matrix(pose)}}; }

Json input_json(const InputSummary& in) {
  return {{"role", in.role},
          {"path", in.path},
          {"points", in.points},
          {"nodes", in.nodes},
          {"duplicates", in.cleaning.duplicates},
          {"layered_share", real(in.layered_share)},
          {"unit", in.unit},
          {"vertical_unit", in.vertical_unit},
          {"crs", text_or_null(in.crs)},
          {"format", in.format}};
}

Json parameters_json(const Roughness& r) {
  const RoughnessOptions& o = r.options;
  const CompareOptions& c = o.compare;
  const auto& m = r.frame.rotation;
  return {{"form", to_text(o.form)},
          {"degree", o.form == FormKind::polynomial ? Json(o.degree) : Json(nullptr)},
          {"s_filter", length_or_null(o.s_filter)},
          {"l_filter", length_or_null(o.l_filter)},
          {"filter", o.l_filter > 0 ? Json(to_text(o.filter)) : Json(nullptr)},
          {"filter_degree", o.l_filter > 0 || o.s_filter > 0 ? Json(o.filter_degree) : Json(nullptr)},
          {"margin", real(r.scan.margin)},
          {"interpolation", o.interpolation == Interpolation::cubic ? "cubic" : "linear"},
          {"wrinkle_depth", length_or_null(o.wrinkles.depth)},
          {"wrinkle_length", length_or_null(o.wrinkles.length)},
          {"border", c.border == BorderRule::trim ? "trim" : "hull"},
          {"folds", c.folds == FoldRule::keep ? "keep" : "leave-out"},
          {"max_edge", length_or_null(c.max_edge)},
          {"duplicates", to_text(c.project.duplicates)},
          {"direction", point({m[6], m[7], m[8]})},
          {"direction_rule", to_text(c.project.direction.kind)},
          {"class", c.project.classes.empty() ? Json(nullptr) : Json(c.project.classes)},
          {"crop", crop_box(c.project.crop)},
          {"match", o.match},
          {"unit", r.unit},
          {"allow_crs", c.allow_crs}};
}

Json wrinkles_json(const Roughness& r, const Texture& x) {
  Json list = Json::array();
  for (std::size_t k = 0; k < x.wrinkles.all.size(); ++k) {
    const Wrinkle& w = x.wrinkles.all[k];
    const Point2& p = x.cells.xy[w.deepest];
    list.push_back({{"number", k + 1},
                    {"depth", real(w.depth)},
                    {"mean_depth", real(w.mean_depth)},
                    {"length", real(w.length)},
                    {"width", real(w.width)},
                    {"area", real(w.area)},
                    {"volume", real(w.volume)},
                    {"deepest", point(r.frame.to_input({p.x, p.y, x.cells.z1[w.deepest]}))}});
  }
  return {{"depth_limit", real(x.wrinkles.depth)},
          {"length_limit", real(x.wrinkles.length)},
          {"count", x.wrinkles.all.size()},
          {"pits", x.wrinkles.pits},
          {"left_out", {{"at_rim", x.wrinkles.at_rim}, {"steep", x.wrinkles.steep}}},
          {"list", list}};
}

Json texture_json(const Roughness& r, const Texture& x) {
  Json values = Json::object();
  for (const ParameterName& p : parameter_names()) values[p.key] = real(x.parameters.*p.value);
  Json form = nullptr;
  if (!x.form.empty()) {
    form = Json::array();
    for (const double c : x.form) form.push_back(real(c));
  }
  return {{"area", real(x.area)},
          {"folded_area", real(x.folded_area)},
          {"folded_share", real(x.folded_share)},
          {"evaluated_area", real(x.parameters.area)},
          {"evaluated_share", real(x.parameters.area / x.area)},
          {"spacing", real(x.spacing)},
          {"form", form},
          {"form_sq", real(x.form_sq)},
          {"waviness_sq", real(x.waviness_sq)},
          {"parameters", values},
          {"wrinkles", wrinkles_json(r, x)}};
}

/// after ÷ scan − 1
Json change(double scan, double after) { return scan != 0 ? real(after / scan - 1) : Json(nullptr); }

Json change_json(const Roughness& r) {
  if (!r.after) return nullptr;
  Json values = Json::object(), wrinkles = Json::array();
  for (const ParameterName& p : parameter_names())
    values[p.key] = change(r.scan.parameters.*p.value, r.after->parameters.*p.value);
  for (std::size_t k = 0; k < r.wrinkles_after.size(); ++k) {
    const LineDepth& d = r.wrinkles_after[k];
    wrinkles.push_back({{"number", k + 1},
                        {"depth", real(d.depth)},
                        {"mean_depth", real(d.mean_depth)},
                        {"depth_change", change(r.scan.wrinkles.all[k].depth, d.depth)},
                        {"mean_depth_change", change(r.scan.wrinkles.all[k].mean_depth, d.mean_depth)}});
  }
  return {{"parameters", values}, {"wrinkles", wrinkles}};
}

class Summary {
 public:
  explicit Summary(const Roughness& r) : r_(r), unit_(unit_text(r.unit)) {}
  void line(const std::string& label, const std::string& text) { isopach::line(out_, label, text); }
  void free_line(const std::string& text) { out_ += text + "\n"; }
  [[nodiscard]] std::string length(double v) const { return number(v, plain) + " " + unit_; }
  [[nodiscard]] const std::string& str() const { return out_; }

  void scan(const Texture& x) {
    line(x.input.role, fmt::format("{}: {} points, {} {} evaluated, {:.1f} % of it", input_name(x.input),
                                   count(x.input.points, plain), number(x.parameters.area, plain),
                                   unit_text(r_.unit, 2), 100 * x.parameters.area / x.area));
    if (x.folded_area > 0)
      line("folds",
           fmt::format("{:.2g} % of the area has several layers along the direction and is {}", 100 * x.folded_share,
                       r_.options.compare.folds == FoldRule::keep ? "measured as triangulated" : "left out"));
  }
  void parameter(const ParameterName& p) {
    const auto value = [&](const Texture& x) {
      return p.power > 0 ? length(x.parameters.*p.value) : number(x.parameters.*p.value, plain);
    };
    std::string text = fmt::format("{:<16}", value(r_.scan));
    if (r_.after) {
      const double before = r_.scan.parameters.*p.value;
      text = fmt::format("{} -> {}", value(r_.scan), value(*r_.after));
      if (before != 0)
        text += fmt::format(" ({} %)", signed_number(100 * (r_.after->parameters.*p.value / before - 1), plain, 3));
      text = fmt::format("{:<40}", text);
    }
    line(p.symbol, text + p.meaning);
  }
  void wrinkles() {
    const Wrinkles& w = r_.scan.wrinkles;
    line("wrinkles", fmt::format("{} deeper than {} and longer than {}; {} other valleys", w.all.size(),
                                 length(w.depth), length(w.length), w.pits));
    if (w.at_rim + w.steep > 0)
      line("", fmt::format("left out: {} along the rim of the scan or of a fold, {} steeper than a height field shows",
                           w.at_rim, w.steep));
    for (std::size_t k = 0; k < w.all.size() && k < shown; ++k) {
      std::string text = fmt::format("{}: depth {}, mean {}, length {}, width {}", k + 1, length(w.all[k].depth),
                                     length(w.all[k].mean_depth), length(w.all[k].length), length(w.all[k].width));
      if (r_.after) {
        const LineDepth& d = r_.wrinkles_after[k];
        text += std::isfinite(d.depth)
                    ? fmt::format("; after: depth {}, mean {}", length(d.depth), length(d.mean_depth))
                    : std::string("; after: not seen");
      }
      line("", text);
    }
    if (w.all.size() > shown) line("", fmt::format("... and {} more, see wrinkles.csv", w.all.size() - shown));
  }

 private:
  static constexpr std::size_t shown = 10;
  const Roughness& r_;
  std::string unit_, out_;
};

}  // namespace

const char* to_text(FormKind form) {
  switch (form) {
    case FormKind::none:
      return "none";
    case FormKind::plane:
      return "plane";
    case FormKind::polynomial:
      return "polynomial";
    case FormKind::reference:
      return "reference";
  }
  return "";
}

const char* to_text(MeanFilter filter) { return filter == MeanFilter::robust ? "robust" : "gaussian"; }

const std::vector<ParameterName>& parameter_names() {
  using P = ArealParameters;
  static const std::vector<ParameterName> names{
      {"sa", "Sa", &P::sa, 1, "mean size of the heights about their mean"},
      {"sq", "Sq", &P::sq, 1, "root mean square of the heights"},
      {"sq_points", "Sq of points", &P::sq_points, 1, "the same over the points: noise counts in full"},
      {"sz", "Sz", &P::sz, 1, "highest peak to deepest pit, Sp + Sv"},
      {"sp", "Sp", &P::sp, 1, "highest peak"},
      {"sv", "Sv", &P::sv, 1, "deepest pit"},
      {"ssk", "Ssk", &P::ssk, 0, "skewness: below 0 where valleys are deeper than peaks are high"},
      {"sku", "Sku", &P::sku, 0, "kurtosis: 3 for normal heights, more with single peaks and pits"},
      {"sdr", "Sdr", &P::sdr, 0, "area along the surface over the area in the plane, less 1"},
      {"sdq", "Sdq", &P::sdq, 0, "root mean square of the slope"}};
  return names;
}

std::string removed_text(const Roughness& r, Typography typography) {
  const RoughnessOptions& o = r.options;
  const std::string space = typography == Typography::fine ? "\u00a0" : " ";
  const auto length = [&](double v) { return number(v, typography) + space + unit_text(r.unit); };
  std::string text;
  if (o.s_filter > 0) text += "waves shorter than " + length(o.s_filter) + ", ";
  switch (o.form) {
    case FormKind::none:
      break;
    case FormKind::plane:
      text += "a plane, ";
      break;
    case FormKind::polynomial:
      text += fmt::format("a polynomial of degree {}, ", o.degree);
      break;
    case FormKind::reference:
      text += "the reference, ";
      break;
  }
  if (o.l_filter > 0)
    text += (o.filter == MeanFilter::robust ? "waviness (robust) longer than " : "waviness longer than ") +
            length(o.l_filter) + ", ";
  if (text.empty()) return "nothing was removed";
  text.resize(text.size() - 2);
  return "removed: " + text;
}

std::string roughness_json(const Roughness& r, const std::vector<std::string>& outputs) {
  Json inputs = Json::array({input_json(r.scan.input)});
  if (r.after) inputs.push_back(input_json(r.after->input));
  if (r.reference) inputs.push_back(input_json(*r.reference));
  const Json report = {{"schema", "isopach.roughness/1"},
                       {"tool", {{"name", tool_name}, {"version", version}}},
                       {"inputs", inputs},
                       {"parameters", parameters_json(r)},
                       {"pose", pose_json(r.options.compare.pose)},
                       {"reference_pose", r.reference ? pose_json(r.reference_pose) : Json(nullptr)},
                       {"verdict", verdict_json(r.verdict, r.unit)},
                       {"reference_verdict", verdict_json(r.reference_verdict, r.unit)},
                       {"scan", texture_json(r, r.scan)},
                       {"after", r.after ? texture_json(r, *r.after) : Json(nullptr)},
                       {"change", change_json(r)},
                       {"outputs", outputs},
                       {"warnings", messages(r.warnings)},
                       {"timing_s", timing(r.timing)}};
  return report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string roughness_text(const Roughness& r) {
  Summary s(r);
  s.scan(r.scan);
  if (r.after) s.scan(*r.after);
  s.line("surface", removed_text(r, plain));
  for (const ParameterName& p : parameter_names()) s.parameter(p);
  s.wrinkles();
  if (r.unit == "unknown" || r.unit.empty()) s.line("units", unit_sentence(r.unit));
  s.line("time", fmt::format("{:.2f} s", r.timing.total));
  for (const std::string& w : r.warnings) s.free_line("warning: " + message_text(w));
  return s.str();
}

std::string wrinkles_csv(const Roughness& r) {
  std::string out = "number,depth,mean_depth,length,width,area,volume,x,y,z";
  if (r.after) out += ",depth_after,mean_depth_after";
  out += "\n";
  for (std::size_t k = 0; k < r.scan.wrinkles.all.size(); ++k) {
    const Wrinkle& w = r.scan.wrinkles.all[k];
    const Point2& at = r.scan.cells.xy[w.deepest];
    const Point3 p = r.frame.to_input({at.x, at.y, r.scan.cells.z1[w.deepest]});
    out += fmt::format("{},{},{},{},{},{},{},{},{},{}", k + 1, w.depth, w.mean_depth, w.length, w.width, w.area,
                       w.volume, p.x, p.y, p.z);
    const auto cell = [](double v) { return std::isfinite(v) ? fmt::format(",{}", v) : std::string(","); };
    if (r.after) out += cell(r.wrinkles_after[k].depth) + cell(r.wrinkles_after[k].mean_depth);
    out += "\n";
  }
  return out;
}

void write_roughness_points(const std::string& path, const CloudView& cloud, const Texture& texture,
                            const Context& context) {
  Cloud out;
  out.points = cloud.points.copy();
  out.unit = cloud.unit;
  out.vertical_unit = cloud.vertical_unit;
  out.crs = cloud.crs;
  out.attributes = texture.fields;
  write_cloud(path, out, context);
}

}  // namespace isopach
