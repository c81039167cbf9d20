#include "isopach/overlay/localise_in_order.hpp"

#include "isopach/base/parallel.hpp"
#include "isopach/overlay/localise.hpp"

namespace isopach {

Locations localise_in_order(std::span<const Point2> points, const Triangulation& t, std::span<const Point2> xy,
                            const Context& context) {
  context.check();
  if (t.real == 0) return localise(points, {}, t, xy, context);  // which looks at no tree then
  constexpr std::size_t block = std::size_t{1} << 15;
  Locations result;
  result.kind.resize(points.size());
  result.id.resize(points.size());
  Array<Index> entry((points.size() + block - 1) / block);  // of the first node of each block
  Index at = 0;
  for (std::size_t b = 0; b < entry.size(); ++b) {
    (void)locate(points[b * block], t, xy, at, result.visited);
    entry[b] = at;
  }
  result.visited += reduce_blocks<std::uint64_t>(
      points.size(), block,
      [&](std::size_t begin, std::size_t end) {
        Index here = entry[begin / block];
        std::uint64_t visited = 0;
        for (std::size_t i = begin; i < end; ++i) {
          const Location found = locate(points[i], t, xy, here, visited);
          result.kind[i] = found.kind;
          result.id[i] = found.id;
        }
        return visited;
      },
      [](std::uint64_t& total, std::uint64_t part) { total += part; });
  return result;
}

}  // namespace isopach
