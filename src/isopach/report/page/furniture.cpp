#include "isopach/report/page/furniture.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "isopach/report/page/words.hpp"

namespace isopach {
namespace {

constexpr double least_x = 1e4, least_y = 1e5;  // of national grids, in any of their units

const std::string& crs_of(const Comparison& c) { return c.a.crs.empty() ? c.b.crs : c.a.crs; }

}  // namespace

bool is_map(const Comparison& c) {
  constexpr std::array<double, 9> upright{1, 0, 0, 0, 1, 0, 0, 0, 1};
  if (c.frame.rotation != upright || c.unit == "mm") return false;
  if (!crs_of(c).empty()) return true;
  const Box3& b = c.a.bounds;
  if (c.unit == "unknown" || c.unit.empty() || b.empty()) return false;
  return std::min(std::fabs(b.min.x), std::fabs(b.max.x)) >= least_x &&
         std::min(std::fabs(b.min.y), std::fabs(b.max.y)) >= least_y;
}

std::string crs_name(const std::string& crs) {
  constexpr std::size_t short_enough = 40;
  const std::size_t begin = crs.find('"');
  if (crs.size() < short_enough || begin == std::string::npos) return clean_utf8(crs);
  return clean_utf8(crs.substr(begin + 1, crs.find('"', begin + 1) - begin - 1));
}

std::string signature(const Comparison& c, const MapOptions& look, const std::string& separator) {
  const std::string crs = crs_name(crs_of(c));
  std::string text;
  for (const std::string& part :
       {crs.empty() && is_map(c) ? "no coordinate system named in the files" : crs, clean_utf8(look.author), look.date})
    if (!part.empty()) text += (text.empty() ? "" : separator) + part;
  return text;
}

}  // namespace isopach
