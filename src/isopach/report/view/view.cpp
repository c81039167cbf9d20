#include "isopach/report/view/view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "isopach/report/draw/map.hpp"
#include "isopach/report/page/base64.hpp"
#include "isopach/report/page/uncertainty.hpp"
#include "isopach/report/page/values.hpp"
#include "isopach/report/page/words.hpp"
#include "isopach/report/view/block.hpp"
#include "isopach/report/view/script.hpp"
#include "isopach/report/view/thin.hpp"

namespace isopach {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t least_view_vertices = 40000;
using values::real;

Json numbers_json(const Quantised& q) { return {{"low", real(q.low)}, {"step", real(q.step)}}; }

Json frame_json(const Frame& f) { return {{"origin", values::point(f.origin)}, {"rotation", Json(f.rotation)}}; }

/// Text of files may hold anything; in JSON and in names it is valid UTF-8.
Json input_json(const InputSummary& in) { return {{"name", input_name(in)}, {"path", clean_utf8(in.path)}}; }

/// Box of a polygon, frame coordinates; only where the frame is that of the input but for its origin.
Json place_of(const BudgetRow& row, const Comparison& c) {
  constexpr std::array<double, 9> upright{1, 0, 0, 0, 1, 0, 0, 0, 1};
  if (c.frame.rotation != upright) return nullptr;
  for (const auto* sets : {&c.options.area.include, &c.options.area.budget})
    for (const PolygonSet& set : *sets)
      for (const Polygon& polygon : set.polygons) {
        if (set.path != row.file || polygon.name != row.name) continue;
        Box2 box;
        for (const auto& ring : polygon.rings)
          for (const Point2& p : ring) box.add(Point2{p.x - c.frame.origin.x, p.y - c.frame.origin.y});
        if (box.empty()) return nullptr;
        return Json::array({real(box.min.x), real(box.min.y), real(box.max.x), real(box.max.y)});
      }
  return nullptr;
}

Json budget_json(const Comparison& c) {
  Json rows = Json::array();
  for (const BudgetRow& row : c.budget) {
    const Json box = place_of(row, c);
    const Json entry{{"name", clean_utf8(row.name)}, {"net", real(row.volume.net)}, {"box", box}};
    if (!box.is_null()) rows.push_back(entry);
  }
  return rows;
}

/// The largest of the objects, numbered as in the page's table, each with a square of its area.
Json changes_json(const Comparison& c) {
  constexpr std::size_t most = 30;
  Json rows = Json::array();
  if (!c.changes) return rows;
  for (std::size_t i = 0; i < std::min(most, c.changes->list.size()); ++i) {
    const Change& change = c.changes->list[i];
    const double half = std::sqrt(change.area) / 2;
    const Point2& p = change.largest_at;
    const Json box = Json::array({real(p.x - half), real(p.y - half), real(p.x + half), real(p.y + half)});
    const Json entry{{"name", "object " + std::to_string(i + 1)}, {"net", real(change.net())}, {"box", box}};
    rows.push_back(entry);
  }
  return rows;
}

Json scene_json(const ViewScene& scene, const ThinSurface& s) {
  const Comparison& c = *scene.comparison;
  Json out{{"label", scene.label},   {"frame", frame_json(c.frame)},
           {"nodes", s.nodes()},     {"triangles", s.triangles.size()},
           {"of", s.nodes_of_cells}, {"whole", s.is_whole},
           {"x", numbers_json(s.x)}, {"y", numbers_json(s.y)},
           {"z", numbers_json(s.z)}, {"d", numbers_json(s.d)}};
  out["lod"] = s.lod.numbers.empty() ? Json(nullptr) : numbers_json(s.lod);
  out["error"] = {{"d", real(s.d_error)}, {"rms", real(s.d_rms)}, {"z", real(s.z_error)}};
  out["thinned"] = {{"area", real(s.area)}, {"above", real(s.above)}, {"below", real(s.below)}};
  const Volume& v = c.measures.volume;
  out["exact"] = {{"area", real(c.domain_area)}, {"above", real(v.above)}, {"below", real(v.below)}};
  out["a"] = input_json(c.a), out["b"] = input_json(c.b);
  out["budget"] = budget_json(c), out["changes"] = changes_json(c);
  return out;
}

bool is_vertical(const Comparison& c) { return c.options.project.direction.kind == Direction::Kind::axis_z; }

Json head_json(const std::vector<ViewScene>& scenes, const ViewWords& words, const MapOptions& look) {
  const Comparison& c = *scenes.front().comparison;
  double limit = 0;
  for (const ViewScene& scene : scenes)
    if (!shows_no_difference(*scene.comparison)) limit = std::max(limit, colour_limit(*scene.comparison));
  if (look.range > 0) limit = look.range;
  const bool is_projected = words.places && !c.a.crs.empty() && is_vertical(c);
  Json head{{"version", 1},
            {"title", look.title.empty() ? input_name(c.a) + " → " + input_name(c.b) : clean_utf8(look.title)},
            {"unit", unit_text(c.unit)},
            {"heightUnit", measured_unit(c, 1)},
            {"areaUnit", measured_unit(c, 2)},
            {"volumeUnit", measured_unit(c, 3)},
            {"crs", clean_utf8(c.a.crs)},
            {"north", is_projected},
            {"vertical", words.places && is_vertical(c)},
            {"places", words.places},
            {"limit", real(limit)},
            {"palette", look.palette},
            {"flip", look.flip != paints_excess_red(c.unit)},
            {"words", {{"a", words.a}, {"b", words.b}, {"above", words.above}, {"below", words.below}}},
            {"command", clean_utf8(words.command)}};
  if (!look.words.drawn.empty()) head["drawn"] = look.words.drawn;
  return head;
}

std::string data_of(const std::vector<ViewScene>& scenes, const Json& head, std::size_t vertices,
                    const Context& context) {
  Json data = head;
  data["scenes"] = Json::array();
  bool is_empty = true;
  for (const ViewScene& scene : scenes) {
    const ThinSurface s = thin_surface(*scene.comparison, vertices / scenes.size(), context);
    Json one = scene_json(scene, s);
    one["data"] = view_block(s);
    data["scenes"].push_back(std::move(one));
    is_empty = is_empty && s.triangles.empty();
    context.check();
  }
  return is_empty ? std::string() : view_element(data.dump());
}

}  // namespace

std::string view_of(const std::vector<ViewScene>& scenes, const ViewWords& words, const MapOptions& look,
                    const ViewLimits& limits, const Context& context) {
  if (scenes.empty() || limits.vertices == 0u) return "";
  const Json head = head_json(scenes, words, look);
  const std::string script = view_script_element();
  const std::size_t taken = limits.page_bytes + script.size();
  const std::size_t room = page_budget > taken ? page_budget - taken : 0;
  constexpr std::size_t usual = 14;  // bytes a vertex
  std::size_t vertices =
      limits.vertices.value_or(std::clamp<std::size_t>(room / usual, least_view_vertices, default_view_vertices));
  std::string data = data_of(scenes, head, vertices, context);
  // A surface that compresses badly gets fewer vertices; where pictures fill the page, the least that shows a shape.
  for (int tries = 0; tries < 3 && !limits.vertices && data.size() > room && vertices > least_view_vertices; ++tries) {
    const double share = 0.95 * static_cast<double>(room) / static_cast<double>(data.size());
    vertices =
        std::max<std::size_t>(least_view_vertices, static_cast<std::size_t>(share * static_cast<double>(vertices)));
    data = data_of(scenes, head, vertices, context);
  }
  return data.empty() ? "" : data + script;
}

std::string view_element(const std::string& json) {
  std::string text = json;
  for (std::size_t i = 0; (i = text.find('<', i)) != std::string::npos; i += 6) text.replace(i, 1, "\\u003c");
  return "<script type=\"application/json\" id=\"view-data\">" + text + "</script>\n";
}

std::string view_script_element() { return "<script>" + std::string(view_script()) + "</script>\n"; }

std::string view_policy() {
  const std::string_view digits = view_script_sha256();
  std::string bytes;
  for (std::size_t i = 0; i + 1 < digits.size(); i += 2)
    bytes += static_cast<char>(std::stoi(std::string(digits.substr(i, 2)), nullptr, 16));
  return "script-src 'sha256-" + base64(bytes) + "'";
}

}  // namespace isopach
