#include "isopach/report/changes.hpp"

#include <algorithm>
#include <cmath>

#include "isopach/report/draw/chart.hpp"
#include "isopach/report/page/change_values.hpp"
#include "isopach/report/page/geojson.hpp"
#include "isopach/report/page/words.hpp"

namespace isopach {
namespace {

using namespace values;

constexpr std::size_t most_numbered = 20;  // on the map: more would hide it

/// The columns of the table and the properties of the outlines.
Json row_of(const Json& change) {
  Json row{{"id", change["id"]}, {"change", change["net"].get<double>() > 0 ? "gained" : "lost"}};
  for (const char* key : {"net", "sigma_net", "area", "mean", "max"}) row[key] = change[key];
  row["x_max"] = change["max_at"][0], row["y_max"] = change["max_at"][1];
  row["x"] = change["centroid"][0], row["y"] = change["centroid"][1];
  for (const char* key : {"points_a", "points_b", "significance", "significant"}) row[key] = change[key];
  return row;
}

}  // namespace

std::string changes_csv(const Comparison& c) {
  const Json list = changes_json(c);
  std::string out =
      "id,change,net,sigma_net,area,mean,max,x_max,y_max,x,y,points_a,points_b,significance,significant\n";
  for (const Json& change : list) {
    std::string separator;
    const Json row = row_of(change);
    for (const auto& [key, value] : row.items()) {
      out += separator + (value.is_null() ? "" : value.is_string() ? value.get<std::string>() : value.dump());
      separator = ",";
    }
    out += "\n";
  }
  return out;
}

std::string changes_geojson(const Comparison& c) {
  const Json list = changes_json(c);
  std::vector<Json> features;
  for (std::size_t i = 0; i < list.size(); ++i)
    features.push_back({{"type", "Feature"},
                        {"id", i + 1},
                        {"properties", row_of(list[i])},
                        {"geometry", polygons_json(c, c.changes->list[i].outline)}});
  return feature_collection(c, "changes", features);
}

std::vector<MapLine> change_lines(const Comparison& c) {
  std::vector<MapLine> lines;
  for (std::size_t i = 0; i < c.changes->list.size(); ++i) {
    std::string label = i < most_numbered ? std::to_string(i + 1) : "";
    for (const PolygonWithHoles& polygon : c.changes->list[i].outline)
      for (const auto& ring : polygon.rings) {
        MapLine& line = lines.emplace_back();
        const auto top =
            std::max_element(ring.begin(), ring.end(), [](const Point2& p, const Point2& q) { return p.y < q.y; });
        line.xy.assign(top, ring.end());  // the label stands over it
        line.xy.insert(line.xy.end(), ring.begin(), top + 1);
        line.label = label;
        label.clear();
      }
  }
  return lines;
}

std::string change_chart(const Comparison& c) {
  const std::vector<Change>& list = c.changes->list;
  if (list.size() < 3) return "";
  Chart chart;
  chart.title = "How many objects are at least how large";
  chart.x_label = "log10 of the volume (" + measured_unit(c, 3) + ")", chart.y_label = "log10 of the number";
  for (const bool gained : {true, false}) {
    ChartSeries series{gained ? "gained" : "lost", {}, true};
    double rank = 0;
    for (const Change& change : list)
      if (change.gained == gained && change.volume > 0)
        series.points.push_back({std::log10(change.volume), std::log10(++rank)});
    if (!series.points.empty()) chart.series.push_back(series);
  }
  return chart_svg(chart);
}

std::string change_sentence(const Comparison& c) {
  constexpr Typography plain = Typography::plain;
  const Changes& x = *c.changes;
  std::size_t gained = 0;
  for (const Change& change : x.list) gained += change.gained ? 1 : 0;
  const auto volume = [&](double v) { return number(v, plain) + " " + measured_unit(c, 3); };
  std::string text = count(gained, plain) + " gained, " + volume(x.all.above - x.small.sum.above) + "; " +
                     count(x.list.size() - gained, plain) + " lost, " + volume(x.all.below - x.small.sum.below);
  const std::size_t small = x.small.gained + x.small.lost;
  if (small > 0)
    text += "; " + count(small, plain) + " smaller ones hold " + volume(x.small.sum.above) + " and " +
            volume(x.small.sum.below);
  return text;
}

}  // namespace isopach
