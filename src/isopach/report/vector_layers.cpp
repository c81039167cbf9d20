#include "isopach/report/vector_layers.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstring>

#include "isopach/compare/contour_lines.hpp"
#include "isopach/io/output_file.hpp"
#include "isopach/io/write.hpp"
#include "isopach/measure/changes/outlines.hpp"
#include "isopach/report/layers.hpp"
#include "isopach/report/page/geojson.hpp"

namespace isopach {
namespace {

using namespace values;

/// Sides of the triangles of T for which `is_in` says so; `is_cut`: of which pieces are in.
template <class In, class Cut>
void add_triangles(const Cells& cells, In&& is_in, Cut&& is_cut, OutlineBuilder& outline) {
  const Triangulation& t = cells.triangulation;
  for (Index i = 0; i < t.real; ++i) {
    if (!is_in(i)) continue;
    const Triangle& of = t.triangles[i];
    for (Index k = 0; k < 3; ++k) {
      const Index other = triangle_of(of.n[k]);
      const OutlineSide side{cells.xy[of.v[k]], cells.xy[of.v[next_side(k)]]};
      if (t.is_ghost(other) || (!is_in(other) && !is_cut(other)))
        outline.add(side);
      else if (is_cut(other))
        outline.add_loose(side, true);
    }
  }
}

std::vector<PolygonWithHoles> domain_of(const Cells& cells) {
  std::vector<unsigned char> cut(cells.triangulation.real, 0);
  for (const CellPiece& piece : cells.pieces) cut[piece.cell] = 1;
  OutlineBuilder outline;
  add_triangles(
      cells, [&](Index i) { return cells.in_domain[i] != 0; }, [&](Index i) { return cut[i] != 0; }, outline);
  for (const CellPiece& piece : cells.pieces)
    for (std::size_t k = 0; k < 3; ++k) {
      const Corner &p = piece.at[k], &q = piece.at[(k + 1) % 3];
      outline.add_loose({Point2{p.x, p.y}, Point2{q.x, q.y}}, false);
    }
  return outline.polygons();
}

std::vector<PolygonWithHoles> footprint_of(const Cells& cells, unsigned scan) {
  OutlineBuilder outline;
  const auto is_in = [&](Index i) { return (cells.scanned[i] & scan) != 0; };
  add_triangles(
      cells, is_in, [](Index) { return false; }, outline);
  return outline.polygons();
}

double area_of(const std::vector<PolygonWithHoles>& polygons) {
  double area = 0;
  for (const PolygonWithHoles& polygon : polygons)
    for (const auto& ring : polygon.rings) area += ring_area(ring);
  return area;
}

/// The arrays of a VTK file, one behind the other, each with its size in bytes before it.
class Appended {
 public:
  explicit Appended(OutputFile& file) : file_(file) {}
  /// `count` values that `value(i)` gives.
  template <class T, class F>
  void write(std::size_t count, F&& value) {
    put(static_cast<std::uint64_t>(count * sizeof(T)));
    for (std::size_t i = 0; i < count; ++i) put(static_cast<T>(value(i)));
  }
  void flush() {
    file_.write(buffer_);
    buffer_.clear();
  }

 private:
  template <class T>
  void put(T value) {
    std::array<char, sizeof(T)> bytes{};
    std::memcpy(bytes.data(), &value, sizeof(T));
    buffer_.append(bytes.data(), bytes.size());
    if (buffer_.size() > (1U << 20)) flush();
  }
  OutputFile& file_;
  std::string buffer_;
};

}  // namespace

std::string contours_geojson(const Comparison& c, double step, const Context& context) {
  const MeasuredCells cells = in_order(measured_cells(c));
  std::vector<Json> features;
  for (const ContourLine& line : contour_lines(view_of(cells), step, "@contours", context)) {
    Json corners = Json::array();
    for (const Point2& p : line.xy) corners.push_back(place_json(c, p));
    features.push_back({{"type", "Feature"},
                        {"properties", {{"d", real(line.level)}}},
                        {"geometry", {{"type", "LineString"}, {"coordinates", corners}}}});
  }
  return feature_collection(c, "contours", features);
}

std::string outlines_geojson(const Comparison& c, const Context& context) {
  require_map_direction(c.options.project, "@outlines");
  context.check();
  std::vector<Json> features;
  const auto add = [&](const char* name, const std::vector<PolygonWithHoles>& polygons) {
    features.push_back({{"type", "Feature"},
                        {"properties", {{"name", name}, {"area", real(area_of(polygons))}}},
                        {"geometry", polygons_json(c, polygons)}});
  };
  add("domain", domain_of(c.cells));
  if (!c.cells.scanned.empty()) {
    add("footprint_a", footprint_of(c.cells, 1));
    add("footprint_b", footprint_of(c.cells, 2));
  }
  return feature_collection(c, "outlines", features);
}

void write_vtu(const std::string& path, const Comparison& c, const Context& context) {
  context.step("write", 0);
  const MeasuredCells m = in_order(measured_cells(c));
  const std::size_t points = m.xy.size(), cells = m.triangles.size();
  const bool has_lod = !m.lod.empty();
  write_atomically(path, [&](const std::string& temporary) {
    OutputFile file(temporary, path);
    std::uint64_t at = 0;
    const auto array = [&](const char* type, const std::string& name, unsigned components, std::uint64_t bytes) {
      const std::string text = fmt::format(
          "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n", type,
          name, components, at);
      at += 8 + bytes;
      return text;
    };
    std::string head = fmt::format(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"{}\" "
        "header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
        std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian", points, cells);
    head += "<Points>\n";
    head += array("Float64", "points", 3, 24 * points);
    head += "</Points>\n<Cells>\n";
    head += array("Int64", "connectivity", 1, 24 * cells);
    head += array("Int64", "offsets", 1, 8 * cells);
    head += array("UInt8", "types", 1, cells);
    head += "</Cells>\n<PointData Scalars=\"d\">\n";
    for (const char* name : {"d", "z_a", "z_b"}) head += array("Float64", name, 1, 8 * points);
    if (has_lod) head += array("Float64", "lod", 1, 8 * points);
    file.write(head + "</PointData>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_");
    Appended data(file);
    data.write<double>(3 * points, [&](std::size_t i) {
      const std::size_t v = i / 3;
      const Point3 p = c.frame.to_input({m.xy[v].x, m.xy[v].y, m.z2[v]});
      return i % 3 == 0 ? p.x : i % 3 == 1 ? p.y : p.z;
    });
    data.write<std::int64_t>(3 * cells, [&](std::size_t i) { return m.triangles[i / 3][i % 3]; });
    data.write<std::int64_t>(cells, [](std::size_t i) { return 3 * (i + 1); });
    data.write<std::uint8_t>(cells, [](std::size_t) { return 5; });  // VTK_TRIANGLE
    data.write<double>(points, [&](std::size_t i) { return m.z2[i] - m.z1[i]; });
    data.write<double>(points, [&](std::size_t i) { return m.z1[i] + m.offset[2]; });
    data.write<double>(points, [&](std::size_t i) { return m.z2[i] + m.offset[2]; });
    if (has_lod) data.write<double>(points, [&](std::size_t i) { return m.lod[i]; });
    data.flush();
    file.write("\n</AppendedData>\n</VTKFile>\n");
    file.close();
  });
}

}  // namespace isopach
