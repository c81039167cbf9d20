#include "isopach/overlay/pair.hpp"

#include "isopach/delaunay/triangulate.hpp"

namespace isopach {

Pair project_pair(const CloudView& a, const CloudView& b, const Pose& pose_b, const ProjectOptions& options,
                  const Context& context) {
  Pair pair;
  pair.frame = choose_frame(a, b, pose_b, options, context);
  both([&] { pair.scan[0].field = project(a, Pose{}, pair.frame, options, context); },
       [&] { pair.scan[1].field = project(b, pose_b, pair.frame, options, context); });
  return pair;
}

void triangulate(Pair& pair, const Context& context) {
  for_both([&](std::size_t k) {
    Scan& s = pair.scan[k];
    s.t = triangulate(s.field.xy, s.field.keys, context);
  });
}

}  // namespace isopach
