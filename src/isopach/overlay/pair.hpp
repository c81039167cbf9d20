// Pair: two scans in one frame, each as a mesh, and each as the other one sees it. What compares two scans is made of
// one, stage by stage; what has not been made yet is empty.
#pragma once
#include <array>

#include "isopach/base/context.hpp"
#include "isopach/base/fixed_sum.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/cloud/cloud_view.hpp"
#include "isopach/delaunay/triangulation.hpp"
#include "isopach/field/height_field.hpp"
#include "isopach/overlay/overlay.hpp"

namespace isopach {

/// What is not known of a scan yet, where it stands for the part of a larger one about which the parts alone could not
/// say all; empty: everything.
struct Asked {
  Array<unsigned char> border;  ///< by real triangle: whether the border keeps it; the others are kept
  Array<unsigned char> folds;   ///< by node: whether it is covered; the others are not
  Array<unsigned char> detail;  ///< by real triangle: whether it counts in ρ_dV if this scan is the coarser one
  Array<unsigned char> area;    ///< by real triangle: whether its area counts in that of the scan
  FixedSum kept_elsewhere;      ///< area of triangles that the border is known to keep
};

/// A scan in the frame of its pair.
struct Scan {
  HeightField field;
  Triangulation t;              ///< of the nodes of the field
  Array<unsigned char> kept;    ///< one flag per real triangle: part of the scan; empty if all are
  Array<unsigned char> folded;  ///< … and whether it is in a fold; empty if none is
  Asked asked;                  ///< of a part of a scan (tiles/)
};

/// The nodes of one scan in the other.
struct Seen {
  Locations at;     ///< where each lies
  Array<double> z;  ///< height of the other surface there
};

struct Pair {
  Frame frame;
  std::array<Scan, 2> scan;  ///< A, B
  std::array<Seen, 2> seen;  ///< the nodes of A in B, those of B in A

  /// One of the two surfaces, once it is located and interpolated.
  [[nodiscard]] OverlayMesh mesh(std::size_t k) const {
    return {scan[k].t, scan[k].field.xy, scan[k].field.z, seen[k].at, seen[k].z, scan[k].kept};
  }
};

/// f(0) and f(1) side by side.
template <class F>
void for_both(F&& f) {
  both([&] { f(std::size_t{0}); }, [&] { f(std::size_t{1}); });
}

/// The frame of both and their nodes in it. Errors and cost as of choose_frame and project.
[[nodiscard]] Pair project_pair(const CloudView& a, const CloudView& b, const Pose& pose_b,
                                const ProjectOptions& options, const Context& context);

/// T1 and T2. Cost O(n log n).
void triangulate(Pair& pair, const Context& context);

}  // namespace isopach
