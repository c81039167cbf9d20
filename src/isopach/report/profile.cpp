#include "isopach/report/profile.hpp"

#include <cmath>

#include "isopach/base/error.hpp"
#include "isopach/compare/measured_cells.hpp"
#include "isopach/report/draw/chart.hpp"
#include "isopach/report/page/values.hpp"
#include "isopach/report/page/words.hpp"

namespace isopach {
namespace {

struct Profile {
  Section section;          // input coordinates
  std::vector<double> lod;  // empty: none
};

Profile profile_of(const Comparison& c, std::span<const Point2> line, const Context& context) {
  const MeasuredCells cells = in_order(measured_cells(c));
  std::vector<Point2> local;
  for (const Point2& p : line) local.push_back({p.x - cells.offset[0], p.y - cells.offset[1]});
  Profile profile{section_along(view_of(cells), local, context), {}};
  Section& s = profile.section;
  for (double& x : s.x) x += cells.offset[0];
  for (double& y : s.y) y += cells.offset[1];
  for (double& z : s.z1) z += cells.offset[2];
  for (double& z : s.z2) z += cells.offset[2];
  if (!cells.lod.empty())  // the same rows: they depend on the places alone
    profile.lod = section_along({cells.xy, cells.lod, cells.lod, cells.triangles}, local, context).z1;
  return profile;
}

/// "<svg …>" out of a figure, in a place of its own.
std::string placed(const std::string& figure, double y) {
  const std::size_t begin = figure.find("<svg "), end = figure.find("</svg>");
  if (begin == std::string::npos || end == std::string::npos) return "";
  return "<svg x=\"0\" y=\"" + std::to_string(static_cast<int>(y)) + "\" width=\"1000\" height=\"320\" " +
         figure.substr(begin + 5, end - begin - 5) + "</svg>\n";
}

std::vector<Point2> series(const std::vector<double>& s, const std::vector<double>& values, double sign = 1) {
  std::vector<Point2> points;
  for (std::size_t i = 0; i < s.size(); ++i) points.push_back({s[i], sign * values[i]});
  return points;
}

}  // namespace

std::string profile_csv(const Comparison& c, std::span<const Point2> line, const Context& context) {
  const Profile p = profile_of(c, line, context);
  const Section& s = p.section;
  std::string out = p.lod.empty() ? "s,x,y,z_a,z_b,d\n" : "s,x,y,z_a,z_b,d,lod\n";
  const auto cell = [](double v) { return std::isfinite(v) ? values::real(v).dump() : std::string(); };
  for (std::size_t i = 0; i < s.s.size(); ++i) {
    out += cell(s.s[i]);
    for (const double v : {s.x[i], s.y[i], s.z1[i], s.z2[i], s.z2[i] - s.z1[i]}) out += "," + cell(v);
    if (!p.lod.empty()) out += "," + cell(p.lod[i]);
    out += "\n";
  }
  return out;
}

std::string profile_svg(const Comparison& c, std::span<const Point2> line, const Context& context) {
  const Profile p = profile_of(c, line, context);
  const Section& s = p.section;
  if (s.s.empty())
    throw UsageError("@profile: the line crosses nothing that was measured: are x and y those of the scans?");
  std::vector<double> d(s.s.size());
  for (std::size_t i = 0; i < d.size(); ++i) d[i] = s.z2[i] - s.z1[i];
  Chart heights, differences;
  heights.title = "Both surfaces along the line", differences.title = "Difference along the line";
  heights.x_label = differences.x_label = "way along the line (" + unit_text(c.unit) + ")";
  heights.y_label = "height (" + measured_unit(c, 1) + ")", differences.y_label = "d (" + measured_unit(c, 1) + ")";
  heights.series = {{"A", series(s.s, s.z1)}, {"B", series(s.s, s.z2)}};
  differences.series = {{"d", series(s.s, d)}};
  if (!p.lod.empty()) {
    differences.series.push_back({"level", series(s.s, p.lod)});
    differences.series.push_back({"-level", series(s.s, p.lod, -1)});
  }
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 1000 640\" font-family=\"sans-serif\" "
         "color=\"#22252a\">\n<rect width=\"1000\" height=\"640\" fill=\"#fff\"/>\n" +
         placed(chart_svg(heights), 0) + placed(chart_svg(differences), 320) + "</svg>\n";
}

}  // namespace isopach
