#include "cli/parse.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>

#include "cli/command.hpp"
#include "cli/session.hpp"
#include "isopach/base/error.hpp"
#include "isopach/io/expression.hpp"
#include "isopach/io/input_file.hpp"
#include "isopach/report/page/words.hpp"

namespace isopach::cli {
namespace {

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
  if (!text.empty() && text.back() == separator) parts.emplace_back();
  return parts;
}

std::optional<double> number(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::vector<double> numbers(const std::string& text, const std::string& what) {
  std::vector<double> values;
  for (const std::string& part : split(text, ',')) values.push_back(parse_number(part, what));
  return values;
}

struct Statistic {
  const char* name;
  double (*of)(const Comparison&);
};

// net, mean and median are judged by their size: a loss is as far from none as a gain.
constexpr Statistic statistics[] = {
    {"rho", [](const Comparison& c) { return c.measures.rho; }},
    {"rho_dv", [](const Comparison& c) { return c.detail ? c.detail->rho : std::nan(""); }},
    {"currents_distance", [](const Comparison& c) { return c.currents ? c.currents->distance() : std::nan(""); }},
    {"currents_relative", [](const Comparison& c) { return c.currents ? c.currents->relative() : std::nan(""); }},
    {"std", [](const Comparison& c) { return c.measures.difference.std; }},
    {"nmad", [](const Comparison& c) { return c.measures.difference.nmad; }},
    {"rms", [](const Comparison& c) { return c.measures.difference.rms; }},
    {"mean", [](const Comparison& c) { return std::fabs(c.measures.difference.mean); }},
    {"median", [](const Comparison& c) { return std::fabs(c.measures.difference.median); }},
    {"net", [](const Comparison& c) { return std::fabs(c.measures.volume.net); }},
    {"above", [](const Comparison& c) { return c.measures.volume.above; }},
    {"below", [](const Comparison& c) { return c.measures.volume.below; }},
    {"absolute", [](const Comparison& c) { return c.measures.volume.absolute; }},
    {"max",
     [](const Comparison& c) { return std::max(c.measures.difference.max_above, c.measures.difference.max_below); }},
    {"significant_area",  // a share of the area
     [](const Comparison& c) {
       return c.uncertainty.detected ? c.uncertainty.detected->area / c.domain_area : std::nan("");
     }},
};

const Statistic* find_statistic(const std::string& name) {
  for (const Statistic& statistic : statistics)
    if (name == statistic.name) return &statistic;
  return nullptr;
}

// 97.5 for p97.5; nothing for other names.
std::optional<double> percentile_level(const std::string& name) {
  if (name.size() < 2 || name[0] != 'p') return std::nullopt;
  return number(std::string_view(name).substr(1));
}

double value_of(const Tolerance& tolerance, const Comparison& c) {
  if (const Statistic* statistic = find_statistic(tolerance.statistic)) return statistic->of(c);
  const double level = percentile_level(tolerance.statistic).value();
  for (const Percentile& p : all_percentiles(c.measures.difference))
    if (p.level == level) return p.value;
  throw Error(ExitCode::internal, "--fail-above: " + tolerance.statistic + " was not computed");
}

}  // namespace

std::optional<double> as_number(const std::string& text) { return number(text); }

double parse_number(const std::string& text, const std::string& what) {
  const std::optional<double> value = number(text);
  if (!value) throw UsageError(fmt::format("{}: '{}' is not a number", what, text));
  return *value;
}

Direction parse_direction(const std::string& text) {
  using Kind = Direction::Kind;
  if (text == "x") return {Kind::axis_x, {1, 0, 0}};
  if (text == "y") return {Kind::axis_y, {0, 1, 0}};
  if (text == "z") return {Kind::axis_z, {0, 0, 1}};
  if (text == "fit") return {Kind::fit, {0, 0, 1}};
  if (text.find(',') == std::string::npos)
    throw UsageError(fmt::format("--direction: '{}' is not x, y, z, fit or a vector X,Y,Z", text));
  const std::vector<double> v = numbers(text, "--direction");
  if (v.size() != 3) throw UsageError(fmt::format("--direction: '{}' has {} numbers; a vector has 3", text, v.size()));
  if (v[0] == 0 && v[1] == 0 && v[2] == 0) throw UsageError("--direction: 0,0,0 points nowhere");
  return {Kind::vector, {v[0], v[1], v[2]}};
}

std::vector<int> parse_classes(const std::string& text) {
  std::vector<int> classes;
  for (const std::string& part : split(text, ',')) {
    const double value = parse_number(part, "--class");
    if (value < 0 || value > 255 || value != std::floor(value))
      throw UsageError(fmt::format("--class: '{}' is not a class: whole numbers from 0 to 255, e.g. 2,8", part));
    classes.push_back(static_cast<int>(value));
  }
  if (classes.empty()) throw UsageError("--class: name at least one class, e.g. 2");
  return classes;
}

std::optional<Box2> parse_extent(const std::string& text) {
  const std::vector<double> v = numbers(text, "--extent");
  if (v.size() != 4 || !(v[0] < v[2] && v[1] < v[3]))
    throw UsageError(fmt::format("--extent: '{}' is not xmin,ymin,xmax,ymax with min below max", text));
  return Box2{{v[0], v[1]}, {v[2], v[3]}};
}

std::optional<Box2> parse_crop(const std::string& text) {
  const std::vector<double> v = numbers(text, "--crop");
  if (v.size() != 4 || v[0] > v[2] || v[1] > v[3])
    throw UsageError(fmt::format("--crop: '{}' is not xmin,ymin,xmax,ymax with min not above max", text));
  Box2 box;
  box.min = {v[0], v[1]};
  box.max = {v[2], v[3]};
  return box;
}

std::string parse_unit(const std::string& text) {
  for (const char* known : {"m", "mm", "cm", "um", "km", "ft", "us-ft", "in"})
    if (text == known) return text;
  throw UsageError(fmt::format("--unit: '{}' is not one of m, mm, cm, um, km, ft, us-ft, in", text));
}

SigmaSource parse_sigma(const std::string& text, const std::string& option) {
  using Kind = SigmaSource::Kind;
  if (const auto value = number(text)) {
    if (*value < 0)
      throw UsageError(fmt::format("{}: {} is no standard deviation, give one of 0 or more", option, text));
    return {Kind::constant, *value, ""};
  }
  if (text.size() > 1 && text.front() == '@') return {Kind::attribute, 0, text.substr(1)};
  if (!std::ifstream(text))
    throw UsageError(fmt::format(
        "{}: '{}' is neither a number, nor @ and an attribute, nor a raster that can be opened", option, text));
  return {Kind::raster, 0, text};
}

WeightSource parse_weight(const std::string& text) {
  using Kind = WeightSource::Kind;
  using Scan = WeightSource::Scan;
  if (!text.empty() && text.front() == '@') {
    const bool of_a = text.rfind("@a:", 0) == 0, of_b = text.rfind("@b:", 0) == 0;
    const std::string name = text.substr(of_a || of_b ? 3 : 1);
    if (name.empty()) throw UsageError("--weight: name an attribute after '@', e.g. @intensity");
    return {Kind::attribute, of_a ? Scan::a : of_b ? Scan::b : Scan::any, name};
  }
  std::error_code none;  // a formula may be no name of a file
  if (std::filesystem::is_regular_file(std::filesystem::path(text), none)) return {Kind::raster, Scan::any, text};
  for (const char* ending : {".tif", ".tiff", ".asc", ".img", ".grd"})
    if (text.size() > std::strlen(ending) &&
        text.compare(text.size() - std::strlen(ending), std::string::npos, ending) == 0)
      throw InputError("--weight: " + text + ": no such file: give a raster that is there");
  return {Kind::expression, Scan::any, text, Expression(text, "@weight")};  // refused before any file is read
}

namespace {

void check_pose(const Pose& pose, const std::string& path) {
  if (pose.m[12] != 0 || pose.m[13] != 0 || pose.m[14] != 0 || pose.m[15] != 1)
    throw InputError(fmt::format("{}: the last row of a pose is 0 0 0 1; is the matrix transposed?", path));
  const auto& m = pose.m;
  const double determinant =
      m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) + m[2] * (m[4] * m[9] - m[5] * m[8]);
  if (determinant == 0) throw InputError(fmt::format("{}: the matrix flattens space (determinant 0)", path));
}

}  // namespace

Pose read_pose(const std::string& path, const std::string& option) {
  const auto& poses = session().poses;
  if (const auto given = poses.find(path); given != poses.end()) {
    check_pose(given->second, option);
    return given->second;
  }
  std::ifstream file(path);
  if (!file)
    throw InputError(
        fmt::format("{}: cannot be opened: {} needs a file with four lines of four numbers", path, option));
  Pose pose;
  std::size_t count = 0;
  constexpr int longest = 400;  // of a number as text; what has no blanks may have no end either
  for (std::string word; file >> std::setw(longest) >> word; ++count) {
    const std::optional<double> value = number(word);
    if (!value)
      throw InputError(
          fmt::format("{}: '{}' is not a finite number; a pose is four lines of four numbers", path, word));
    if (count < pose.m.size()) pose.m[count] = *value;
  }
  if (count != pose.m.size())
    throw InputError(fmt::format("{}: holds {} numbers; a pose is four lines of four numbers", path, count));
  check_pose(pose, path);
  return pose;
}

namespace {

/// The first list of places of a GeoJSON: coordinates of a LineString, wherever it stands.
const nlohmann::json* first_line(const nlohmann::json& json) {
  if (json.is_object()) {
    const auto type = json.find("type");
    if (type != json.end() && *type == "LineString" && json.contains("coordinates")) return &json["coordinates"];
  }
  if (!json.is_structured()) return nullptr;
  for (const nlohmann::json& part : json)
    if (part.is_structured())
      if (const nlohmann::json* found = first_line(part)) return found;
  return nullptr;
}

std::vector<Point2> line_of_json(const std::string& path, std::span<const char> bytes) {
  const nlohmann::json json = nlohmann::json::parse(bytes.begin(), bytes.end(), nullptr, false);
  const nlohmann::json* places = json.is_discarded() ? nullptr : first_line(json);
  std::vector<Point2> line;
  if (places != nullptr && places->is_array())
    for (const nlohmann::json& p : *places)
      if (p.is_array() && p.size() >= 2 && p[0].is_number() && p[1].is_number())
        line.push_back({p[0].get<double>(), p[1].get<double>()});
  if (line.size() < 2) throw InputError(path + ": holds no line: give a GeoJSON with a LineString, or x and y a line");
  return line;
}

std::vector<Point2> line_of_text(const std::string& path, std::span<const char> bytes) {
  std::string text(bytes.begin(), bytes.end());
  std::replace_if(
      text.begin(), text.end(), [](char l) { return l == ',' || l == ';' || l == '\t' || l == '\r'; }, ' ');
  std::vector<Point2> line;
  for (const std::string& row : split(text, '\n')) {
    std::vector<double> values;
    for (const std::string& word : split(row, ' ')) {
      if (word.empty()) continue;
      const std::optional<double> value = number(word);
      if (!value)
        throw InputError(
            fmt::format("{}: '{}' is not a finite number; a line is x and y, a place a row", path, word.substr(0, 40)));
      values.push_back(*value);
    }
    if (values.size() == 1) throw InputError(path + ": a row with one number; a line is x and y, a place a row");
    if (values.size() >= 2) line.push_back({values[0], values[1]});
  }
  if (line.size() < 2) throw InputError(path + ": holds no line: give two places or more, x and y a row");
  return line;
}

std::vector<Point2> line_of_words(const std::string& text, const std::string& option) {
  std::vector<Point2> line;
  for (const std::string& place : split(text, ';')) {
    if (place.empty()) continue;
    const std::vector<double> xy = numbers(place, option);
    if (xy.size() != 2) throw UsageError(fmt::format("{}: '{}' is no place x,y", option, place));
    line.push_back({xy[0], xy[1]});
  }
  if (line.size() < 2)
    throw UsageError(fmt::format("{}: '{}' is no line: give two places or more, x,y;x,y, or a file", option, text));
  return line;
}

}  // namespace

std::vector<Point2> read_line(const std::string& text, const std::string& option) {
  const bool is_file = text.find(';') == std::string::npos;
  if (!is_file) return line_of_words(text, option);
  const Context nobody_stops;
  InputFile file(text, nobody_stops);
  const std::span<const char> bytes = file.bytes();
  const auto first = std::find_if(bytes.begin(), bytes.end(), [](char l) { return l != ' ' && l != '\n'; });
  const std::vector<Point2> line =
      first != bytes.end() && *first == '{' ? line_of_json(text, bytes) : line_of_text(text, bytes);
  for (const Point2& p : line)
    if (!std::isfinite(p.x) || !std::isfinite(p.y)) throw InputError(text + ": a coordinate that is no finite number");
  return line;
}

std::vector<Tolerance> parse_tolerances(const std::string& text) {
  std::vector<Tolerance> tolerances;
  for (const std::string& part : split(text, ',')) {
    const std::size_t equals = part.find('=');
    if (equals == std::string::npos)
      throw UsageError(fmt::format("--fail-above: '{}' is not STATISTIC=LIMIT, e.g. p95=0.05", part));
    Tolerance tolerance{part.substr(0, equals), parse_number(part.substr(equals + 1), "--fail-above " + part)};
    const std::optional<double> level = percentile_level(tolerance.statistic);
    if (level && !(*level > 0 && *level < 100))
      throw UsageError(
          fmt::format("--fail-above: {}: a percentile lies between 0 and 100, e.g. p95 or p99.5", tolerance.statistic));
    if (!level && find_statistic(tolerance.statistic) == nullptr) {
      std::vector<std::string> names;
      for (const Statistic& statistic : statistics) names.emplace_back(statistic.name);
      throw UsageError(fmt::format("--fail-above: unknown statistic '{}'{}; known: {}", tolerance.statistic,
                                   did_you_mean(tolerance.statistic, names), statistic_names()));
    }
    if (tolerance.limit < 0) throw UsageError(fmt::format("--fail-above: the limit in '{}' is below 0", part));
    tolerances.push_back(std::move(tolerance));
  }
  return tolerances;
}

void check_tolerances(const std::vector<Tolerance>& tolerances, const CompareOptions& options) {
  const bool has_level = options.uncertainty.lod > 0 || options.uncertainty.sigma1.kind != SigmaSource::Kind::none;
  for (const Tolerance& tolerance : tolerances) {
    if (tolerance.statistic == "significant_area" && !has_level)
      throw UsageError("--fail-above: significant_area is known with --lod, or --sigma1 and --sigma2, alone");
    if (tolerance.statistic.starts_with("currents_") && options.measure != MeasureKind::currents)
      throw UsageError("--fail-above: " + tolerance.statistic + " is known with --measure currents alone");
  }
}

std::string statistic_names() {
  std::string all;
  for (const Statistic& statistic : statistics) all += (all.empty() ? "" : ", ") + std::string(statistic.name);
  return all + ", pNN (|d| that NN % of the area stays below, e.g. p95 or p99.5)";
}

std::vector<double> percentiles_of(const std::vector<Tolerance>& tolerances) {
  std::vector<double> levels;
  for (const Tolerance& tolerance : tolerances) {
    const std::optional<double> level = percentile_level(tolerance.statistic);
    if (!level) continue;
    const auto is_it = [&](double known) { return known == *level; };
    if (std::none_of(percentile_levels.begin(), percentile_levels.end(), is_it) &&
        std::none_of(levels.begin(), levels.end(), is_it))
      levels.push_back(*level);
  }
  return levels;
}

std::string exceeded(const Comparison& comparison, const std::vector<Tolerance>& tolerances) {
  std::string line;
  for (const Tolerance& tolerance : tolerances) {
    const double value = value_of(tolerance, comparison);
    if (!(value <= tolerance.limit))
      line += fmt::format("{}{} is {:.6g}, above {:.6g}", line.empty() ? "" : "; ", tolerance.statistic, value,
                          tolerance.limit);
  }
  return line;
}

}  // namespace isopach::cli
