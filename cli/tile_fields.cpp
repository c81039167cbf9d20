#include "cli/tile_fields.hpp"

#include <fmt/format.h>

#include "cli/tile_files.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/field/height_field.hpp"
#include "isopach/io/write.hpp"
#include "isopach/tiles/node_heights.hpp"

namespace isopach::cli {
namespace {

class FieldWriter {
 public:
  FieldWriter(const Job& job, const CompareOptions& options, OutputFolder& folder, const Context& context)
      : job_(job), options_(options), folder_(folder), context_(context), file_(job.folder / "points") {}

  /// `heights`: of the nodes of each scan that tile k passed up.
  void write(std::size_t k, const std::array<const Array<double>*, 2>& heights) {
    const Part part = read_part(job_, k);
    const std::shared_ptr<const CellPart> cells = cells_in(job_.tile_file(k, "cells"), job_.id, 0);
    for (std::size_t s = 0; s < 2; ++s) {
      const Array<Point3> points = read_runs(file_, job_.tiles[k].runs[s]);
      if (points.empty()) continue;
      const HeightField field = project_part(points, job_.frame, options_.project.duplicates, nullptr, context_);
      const Array<double> other = node_heights(s, field.xy, *cells, part.scan[s], *heights[s]);
      if (other.size() != field.xy.size()) fail_to_fit(job_.tile_file(k, "cells"));
      Array<double> d(points.size());
      for_each_index(points.size(), [&](std::size_t i) {
        const double there = other[field.node_of_point[i]];
        d[i] = s == 0 ? there - points[i].z : points[i].z - there;
      });
      write_cloud(folder_.path(fmt::format("points_{}_{:06d}.laz", s == 0 ? 'a' : 'b', k)), cloud_of(s, points, d),
                  context_);
    }
  }

 private:
  [[nodiscard]] Cloud cloud_of(std::size_t s, const Array<Point3>& points, const Array<double>& d) const {
    const JobScan& scan = job_.scan[s];
    Cloud cloud;
    cloud.unit = scan.unit, cloud.vertical_unit = scan.vertical_unit, cloud.crs = scan.crs;
    cloud.points.resize(points.size());
    for_each_index(points.size(), [&](std::size_t i) { cloud.points[i] = job_.frame.to_input(points[i]); });
    cloud.attributes.push_back({"dz_signed", d});
    return cloud;
  }

  const Job& job_;
  const CompareOptions& options_;
  OutputFolder& folder_;
  const Context& context_;
  PlacedFile file_;
};

}  // namespace

void write_point_fields(const Job& job, const CompareOptions& options, const JoinedNodes& nodes, OutputFolder& folder,
                        const Context& context) {
  run_with_threads(context, [&] {
    FieldWriter writer(job, options, folder, context);
    for (std::size_t i = 0; i < nodes.tiles.size(); ++i) {
      context.step("writing points", static_cast<double>(i) / static_cast<double>(nodes.tiles.size()));
      writer.write(nodes.tiles[i], {&nodes.heights[0][i], &nodes.heights[1][i]});
    }
  });
}

}  // namespace isopach::cli
