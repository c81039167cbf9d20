// difference.ply and points_a.ply / points_b.ply: a Cloud is filled and handed to io.
#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/io/write.hpp"
#include "isopach/measure/source.hpp"
#include "isopach/report/page/words.hpp"
#include "isopach/report/report.hpp"

namespace isopach {
namespace {

/// 1 where |d| exceeds the level, 0 where not, NaN where either is.
double significant(double d, double lod) {
  return std::isnan(d) || std::isnan(lod) ? std::nan("") : std::fabs(d) > lod;
}

}  // namespace

std::vector<Attribute> attributes_of(const PointFields& fields) {
  const std::size_t n = fields.dz_signed.size();
  std::vector<Attribute> all{{"dz_signed", fields.dz_signed}, {"dz_abs", Array<double>(n)}};
  for_each_index(n, [&](std::size_t i) { all[1].values[i] = std::fabs(fields.dz_signed[i]); });
  if (fields.lod.empty()) return all;
  all.push_back({fields.lod_name, fields.lod});
  all.push_back({"significant", Array<double>(n)});
  for_each_index(n, [&](std::size_t i) { all[3].values[i] = significant(fields.dz_signed[i], fields.lod[i]); });
  return all;
}

namespace {

Cloud empty_surface(const Comparison& c) {
  Cloud out;
  out.format = "ply";
  out.unit = c.unit;
  out.vertical_unit = height_unit(c);
  out.crs = c.a.crs;
  return out;
}

}  // namespace

void write_overlay_cells(const std::string& path, const Comparison& c, const Context& context) {
  const OverlaySurface& s = c.overlay_surface;
  Cloud out = empty_surface(c);
  out.faces = s.triangles;
  out.points.resize(s.xy.size());
  out.attributes.push_back({"dz", Array<double>(s.xy.size())});
  for_each_index(s.xy.size(), [&](std::size_t i) {
    out.points[i] = c.frame.to_input({s.xy[i].x, s.xy[i].y, s.z2[i]});
    out.attributes[0].values[i] = s.z2[i] - s.z1[i];
  });
  if (!c.overlay_lod.empty()) {
    out.attributes.push_back({c.fields_a.lod_name, c.overlay_lod});
    out.attributes.push_back({"significant", Array<double>(s.xy.size())});
    for_each_index(s.xy.size(), [&](std::size_t i) {
      out.attributes[2].values[i] = significant(out.attributes[0].values[i], c.overlay_lod[i]);
    });
  }
  write_cloud(path, out, context);
}

void write_cells(const std::string& path, const Comparison& c, const Context& context) {
  const Cells& cells = c.cells;
  const Triangulation& t = cells.triangulation;
  Array<Index> vertex(cells.xy.size());
  std::fill(vertex.begin(), vertex.end(), no_index);
  Cloud out = empty_surface(c);
  // Vertices in the order in which the triangles first name them: near each other in the file as in the plane.
  Array<Index> node;
  for (Index i = 0; i < t.real; ++i) {
    if (cells.in_domain[i] == 0) continue;
    std::array<Index, 3> face{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Index n = t.triangles[i].v[k];
      if (vertex[n] == no_index) {
        vertex[n] = static_cast<Index>(node.size());
        node.push_back(n);
      }
      face[k] = vertex[n];
    }
    out.faces.push_back(face);
  }
  const std::size_t whole = node.size();
  out.points.resize(whole + 3 * cells.pieces.size());
  out.attributes.push_back({"dz", Array<double>(out.points.size())});
  if (!cells.lod.empty()) {
    out.attributes.push_back({c.fields_a.lod_name, Array<double>(out.points.size())});
    out.attributes.push_back({"significant", Array<double>(out.points.size())});
  }
  const CellView view = cells.view();
  for (std::size_t i = 0; i < cells.pieces.size(); ++i) {  // cut: corners of their own
    std::array<Index, 3> face{};
    std::array<double, 3> lod{};
    if (!cells.lod.empty()) lod = of_piece(view, cells.pieces[i]).at_corners(cells.lod);
    for (std::size_t k = 0; k < 3; ++k) {
      const Corner& corner = cells.pieces[i].at[k];
      const std::size_t at = whole + 3 * i + k;
      out.points[at] = c.frame.to_input({corner.x, corner.y, corner.z2});
      out.attributes[0].values[at] = corner.d();
      if (!cells.lod.empty()) {
        out.attributes[1].values[at] = lod[k];
        out.attributes[2].values[at] = significant(corner.d(), lod[k]);
      }
      face[k] = static_cast<Index>(at);
    }
    out.faces.push_back(face);
  }
  for_each_index(node.size(), [&](std::size_t i) {
    const Index n = node[i];
    if (!cells.lod.empty()) {
      out.attributes[1].values[i] = cells.lod[n];
      out.attributes[2].values[i] = significant(cells.d(n), cells.lod[n]);
    }
    out.points[i] = c.frame.to_input({cells.xy[n].x, cells.xy[n].y, cells.z2[n]});
    out.attributes[0].values[i] = cells.d(n);
  });
  write_cloud(path, out, context);
}

void write_points(const std::string& path, const CloudView& cloud, const PointFields& fields, const Context& context) {
  if (fields.dz_signed.size() != cloud.points.size())
    throw Error(ExitCode::internal, path + ": " + std::to_string(cloud.points.size()) + " points but " +
                                        std::to_string(fields.dz_signed.size()) + " differences");
  Cloud out;
  out.format = "ply";
  out.points = cloud.points.copy();
  out.unit = cloud.unit;
  out.vertical_unit = cloud.vertical_unit;
  out.crs = cloud.crs;
  out.attributes = attributes_of(fields);
  write_cloud(path, out, context);
}

}  // namespace isopach
